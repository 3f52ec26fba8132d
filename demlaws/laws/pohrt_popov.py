"""Pohrt & Popov 2012, 2013: self-affine roughness on spheres, power law to full contact, then Hertz stiffness."""

import math
from typing import NamedTuple

import numpy as np

from demlaws.dispatch import bind
from demlaws.fastmath import cbrt, kernel, power
from demlaws.laws.definition import Definition, Limit
from demlaws.laws.hertz import hertz_coefficient, hertz_overlap


class Shape(NamedTuple):
    """Depends on the fractal dimension only."""

    ratio: float  # r = δ(F)/δ_H(F) = (2/3)/(1 - m): overlap over Hertz overlap at the threshold force F
    kappa: float  # δ_H(F)/σ = A0/(π R σ)


class Params(NamedTuple):
    """One contact."""

    hertz_coefficient: float  # (4/3) E* √R [N/m^1.5]
    threshold: float  # h = δ_H(F) [m]
    ratio: float  # r


@kernel
def _scale(shape, radius, modulus, roughness):
    return Params(hertz_coefficient(radius, modulus), shape.kappa * roughness, shape.ratio)


@kernel
def _virgin(p, overlap):
    relative = overlap / (p.threshold * p.ratio)
    if relative < 1.0:
        equivalent = p.threshold * power(relative, p.ratio)
        force = p.hertz_coefficient * equivalent * math.sqrt(equivalent)
        return force, 1.5 * p.ratio * force / overlap, equivalent, equivalent
    equivalent = overlap - p.threshold * (p.ratio - 1.0)
    stiffness = p.hertz_coefficient * math.sqrt(equivalent)
    return stiffness * equivalent, 1.5 * stiffness, equivalent, equivalent


@kernel
def _inverse(p, force):
    equivalent = hertz_overlap(p, force)
    if equivalent < p.threshold:
        return p.threshold * p.ratio * power(equivalent / p.threshold, 1.0 / p.ratio)
    return equivalent + p.threshold * (p.ratio - 1.0)


@kernel
def transition_energy(p, overlap, force, equivalent):
    """∫P dδ of a power law δ^(3r/2) up to the threshold and the shifted Hertz curve above it."""
    if equivalent < p.threshold:
        return force * overlap / (1.5 * p.ratio + 1.0)
    coefficient, h = p.hertz_coefficient, p.threshold
    below = coefficient * h * h * math.sqrt(h) * (p.ratio / (1.5 * p.ratio + 1.0) - 0.4)
    return below + 0.4 * force * equivalent


@kernel
def _energy(p, overlap):
    force, _, equivalent, _ = _virgin(p, overlap)
    return transition_energy(p, overlap, force, equivalent)


bind(Shape, scale=_scale)
bind(Params, virgin=_virgin, inverse=_inverse, energy=_energy)


def stiffness_exponent(fractal_dimension):
    """m of K ∝ P^m: 0.2567 Df."""
    return 0.2567 * fractal_dimension


def _prepare(contact):
    # Extended precision once, so that the exponent and the threshold carry one rounding each.
    dimension = np.longdouble(contact.fractal_dimension)
    m = np.longdouble("0.2567") * dimension
    root_pi = np.sqrt(np.longdouble("3.14159265358979323846264338327950288"))
    kappa = np.longdouble(3) / 4 * root_pi * (20 / (root_pi**3 * dimension)) ** (1 / m)
    return Shape(float(2 / (3 * (1 - m))), float(kappa))


def _limits(contact):
    threshold = _threshold_force(contact)
    return [
        Limit(
            0.0,
            math.inf if np.max(contact.roughness) == 0 else float(np.max(2.0 * threshold)),
            "the source has no plastic bulk; the granite tests were softer than this law above about 70 N "
            "(twice the threshold force is taken as the end of its support)",
        )
    ]


def _threshold_force(contact):
    """F = (4 E*/(3 R)) (A0/π)^1.5 [N] above which the stiffness is Hertz's."""
    shape = _prepare(contact)
    return 4 / 3 * contact.modulus * np.sqrt(contact.radius) * (shape.kappa * contact.roughness) ** 1.5


LAW = Definition(
    name="pohrt-popov",
    prepare=_prepare,
    equation="K = (π√A0 E* Df/10) (P/(σ E* √A0))^(0.2567 Df) to F, then Hertz stiffness",
    source="Pohrt & Popov 2012, 2013; Altuhafi, Baudet & Coop 2023, Eqs. 7–9",
    description="self-affine roughness",
    limits=_limits,
    needs=("fractal_dimension",),
)
