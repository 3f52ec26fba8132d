"""Pohrt & Popov 2012, 2013: self-affine roughness on spheres, power law to full contact, then Hertz stiffness.

The exponent 0.2567 Df is a fit to boundary elements. The theory of Pastewka, Prodanov, Lorenz, Müser, Robbins & Persson 2013
(Phys. Rev. E 87, 062809, arXiv 1210.4635) has 1/(1 + H) with H = 3 - Df: both agree within 4 % up to Df 2.5; at Df 2.8 the
fit is 14 % smaller. Above 2.5 a warning is issued.
"""

import math
from typing import NamedTuple

import numpy as np

from demlaws.core.dispatch import bind
from demlaws.core.fastmath import hertz_coefficient, hertz_overlap, kernel, power, sqrt
from demlaws.laws.definition import (
    DIMENSION,
    SIGMA,
    Advice,
    Definition,
    Drawing,
    Fitting,
    Limit,
    Loading,
    Rules,
    bulk_yield,
    elastic_asperities,
)

LARGEST_DIMENSION = 2.5
"""Df above which 0.2567 Df and 1/(1 + H) differ by more than 4 %."""


class PohrtPopovShape(NamedTuple):
    """Depends on the fractal dimension only."""

    ratio: float  # r = δ(F)/δ_H(F) = (2/3)/(1 - m): overlap over Hertz overlap at the threshold force F
    inverse_ratio: float
    kappa: float  # δ_H(F)/σ = A0/(π R σ)


class PohrtPopovParams(NamedTuple):
    """One contact. With h = δ_H(F): δ(F) = r h."""

    hertz_coefficient: float  # (4/3) E* √R [N/m^1.5]
    inverse_threshold: float  # 1/δ(F) [1/m]
    offset: float  # δ(F) - δ_H(F) = (r - 1) h [m]: excess over the Hertz overlap above F


@kernel
def _scale(shape, radius, modulus, roughness):
    threshold = shape.kappa * roughness
    return PohrtPopovParams(
        hertz_coefficient(radius, modulus), 1.0 / (threshold * shape.ratio), threshold * (shape.ratio - 1.0)
    )


@kernel
def _equivalent(shape, p, overlap):
    """Hertz-equivalent overlap and its slope: h t^r and t^(r-1) with t = δ/δ(F) = δ/(r h), then parallel to Hertz."""
    relative = overlap * p.inverse_threshold
    slope = power(relative, shape.ratio - 1.0)
    if relative < 1.0:
        return overlap * slope * shape.inverse_ratio, slope
    return overlap - p.offset, 1.0


@kernel
def _first_loading(shape, p, overlap):
    equivalent, slope = _equivalent(shape, p, overlap)
    root = p.hertz_coefficient * sqrt(equivalent)
    return root * equivalent, 1.5 * root * slope, equivalent, equivalent


@kernel
def _inverse(shape, p, force):
    equivalent = hertz_overlap(p, force)
    relative = equivalent * (p.inverse_threshold * shape.ratio)
    if relative < 1.0:
        return power(relative, shape.inverse_ratio) / p.inverse_threshold
    return equivalent + p.offset


@kernel
def transition_energy(p, ratio, overlap, force, equivalent):
    """∫P dδ of a power law δ^(3 ratio/2) up to the threshold and the shifted Hertz curve above it."""
    exponent = 1.5 * ratio + 1.0
    if overlap * p.inverse_threshold < 1.0:
        return force * overlap / exponent
    h = 1.0 / (p.inverse_threshold * ratio)
    return p.hertz_coefficient * h * h * sqrt(h) * (ratio / exponent - 0.4) + 0.4 * force * equivalent


@kernel
def _energy(shape, p, overlap):
    force, _, equivalent, _ = _first_loading(shape, p, overlap)
    return transition_energy(p, shape.ratio, overlap, force, equivalent)


bind(PohrtPopovShape, scale=_scale)
bind(PohrtPopovParams, first_loading=_first_loading, inverse=_inverse, energy=_energy)


def _prepare(contact):
    # Extended precision once, so that the exponent and the threshold carry one rounding each.
    dimension = np.longdouble(contact.fractal_dimension)
    m = np.longdouble("0.2567") * dimension
    root_pi = np.sqrt(np.longdouble("3.14159265358979323846264338327950288"))
    kappa = np.longdouble(3) / 4 * root_pi * (20 / (root_pi**3 * dimension)) ** (1 / m)
    ratio = float(2 / (3 * (1 - m)))
    return PohrtPopovShape(ratio, 1.0 / ratio, float(kappa))


def _limits(contact):
    limits = bulk_yield(contact)
    if contact.fractal_dimension > LARGEST_DIMENSION * (1.0 + 1e-9):
        overlap = _prepare(contact).kappa * np.asarray(contact.sigma)  # δ_H at the threshold force
        threshold = float(np.max(4.0 / 3.0 * contact.modulus * np.sqrt(contact.radius) * overlap**1.5))
        reason = (
            f"fractal dimension above {LARGEST_DIMENSION:g}: the exponent 0.2567 Df of the stiffness is more than 4 % (at 2.8: "
            "14 %) below 1/(1 + H), H = 3 - Df, of Pastewka et al. 2013"
        )
        limits += [Limit(threshold, math.inf, reason)] if threshold > 0.0 else []
    return limits


LAW = Definition(
    name="pohrt-popov",
    prepare=_prepare,
    equation="K = (π√A0 E* Df/10) (P/(σ E* √A0))^(0.2567 Df) to F, then Hertz stiffness",
    source="Pohrt & Popov 2012, 2013; Altuhafi, Baudet & Coop 2023, Eqs. 7–9",
    description="self-affine roughness",
    limits=_limits,
    loading=Loading(needs=("sigma", "fractal_dimension"), kinks=lambda p: [1.0 / p.inverse_threshold]),
    rules=Rules(default="hertz"),
    fitting=Fitting(parameters={"sigma": SIGMA, "fractal_dimension": DIMENSION}, free=("sigma", "fractal_dimension")),
    advice=Advice(
        suits=lambda conditions: elastic_asperities(
            conditions, conditions.contact.fractal_dimension is not None, "needs a fractal dimension"
        ),
        rank=4,
        candidate=True,
    ),
    drawing=Drawing(colour="#d62728"),
)
