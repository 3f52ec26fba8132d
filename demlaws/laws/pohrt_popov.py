"""Pohrt & Popov 2012, 2013: self-affine roughness on spheres, power law to full contact, then Hertz stiffness."""

from typing import NamedTuple

import numpy as np

from demlaws.core.dispatch import bind
from demlaws.core.fastmath import kernel, power, sqrt
from demlaws.core.hertz import hertz_coefficient, hertz_overlap
from demlaws.errors import DemlawsError
from demlaws.laws.definition import (
    DIMENSION,
    ROUGHNESS,
    Advice,
    Definition,
    Drawing,
    Fitting,
    Limit,
    Option,
    bulk_yield,
    elastic_bulk,
)
from demlaws.laws.extended import PI, extended, from_hertz
from demlaws.laws.pohrt_popov_branches import HertzBranchShape, PowerBranchShape


class PohrtPopovShape(NamedTuple):
    """Depends on the fractal dimension only."""

    ratio: float  # r = δ(F)/δ_H(F) = (2/3)/(1 - m): overlap over Hertz overlap at the threshold force F
    kappa: float  # δ_H(F)/σ = A0/(π R σ)


class PohrtPopovParams(NamedTuple):
    """One contact. With r = shape.ratio, h = δ_H(F): δ(F) = r h."""

    hertz_coefficient: float  # (4/3) E* √R [N/m^1.5]
    inverse_threshold: float  # 1/δ(F) [1/m]
    offset: float  # δ(F) - δ_H(F) = (r - 1) h [m]: what the overlap exceeds the Hertz overlap by above F
    ratio: float  # r
    inverse_ratio: float


@kernel
def _scale(shape, radius, modulus, roughness):
    threshold = shape.kappa * roughness
    return PohrtPopovParams(
        hertz_coefficient(radius, modulus),
        1.0 / (threshold * shape.ratio),
        threshold * (shape.ratio - 1.0),
        shape.ratio,
        1.0 / shape.ratio,
    )


@kernel
def _equivalent(p, overlap):
    """Hertz-equivalent overlap and its slope: h t^r and t^(r-1) with t = δ/δ(F) = δ/(r h), then parallel to Hertz."""
    relative = overlap * p.inverse_threshold
    slope = power(relative, p.ratio - 1.0)
    if relative < 1.0:
        return overlap * slope * p.inverse_ratio, slope
    return overlap - p.offset, 1.0


@kernel
def _virgin(p, overlap):
    equivalent, slope = _equivalent(p, overlap)
    root = p.hertz_coefficient * sqrt(equivalent)
    return root * equivalent, 1.5 * root * slope, equivalent, equivalent


@kernel
def _inverse(p, force):
    equivalent = hertz_overlap(p, force)
    relative = equivalent * (p.inverse_threshold * p.ratio)
    if relative < 1.0:
        return power(relative, p.inverse_ratio) / p.inverse_threshold
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
def _energy(p, overlap):
    force, _, equivalent, _ = _virgin(p, overlap)
    return transition_energy(p, p.ratio, overlap, force, equivalent)


def _kinks(p, branch="both"):
    return {"both": lambda: [1.0 / p.inverse_threshold], "power": list, "hertz": lambda: [p.offset]}[branch]()


bind(PohrtPopovShape, scale=_scale)
bind(PohrtPopovParams, virgin=_virgin, inverse=_inverse, energy=_energy)


def stiffness_exponent(fractal_dimension):
    """m of K ∝ P^m: 0.2567 Df."""
    return 0.2567 * fractal_dimension


_BRANCHES = {"both": PohrtPopovShape, "power": PowerBranchShape, "hertz": HertzBranchShape}


def _prepare(contact, branch="both"):
    """branch: "power" or "hertz" leaves out the other side of the threshold, for scenes that never go there."""
    if not isinstance(branch, str) or branch not in _BRANCHES:
        raise DemlawsError(f"branch={branch!r}: the branches of 'pohrt-popov' are {', '.join(_BRANCHES)}")
    # Extended precision once, so that the exponent and the threshold carry one rounding each.
    dimension = np.longdouble(contact.fractal_dimension)
    m = np.longdouble("0.2567") * dimension
    root_pi = np.sqrt(np.longdouble("3.14159265358979323846264338327950288"))
    kappa = np.longdouble(3) / 4 * root_pi * (20 / (root_pi**3 * dimension)) ** (1 / m)
    return _BRANCHES[branch](float(2 / (3 * (1 - m))), float(kappa))


def _limits(contact, branch="both"):
    limits = bulk_yield(contact)
    if branch == "both" or not np.any(np.asarray(contact.roughness) > 0.0):
        return limits
    kappa = _prepare(contact).kappa
    force = 4.0 / 3.0 * contact.modulus * np.sqrt(contact.radius) * (kappa * np.asarray(contact.roughness)) ** 1.5
    if branch == "power":
        reason = "branch='power' leaves out the Hertz stiffness above the threshold"
        return [*limits, Limit(0.0, float(np.min(force)), reason, branch=True)]
    reason = "branch='hertz' leaves out the power law below the threshold"
    return [*limits, Limit(float(np.max(force)), np.inf, reason, branch=True)]


def _exact(contact, overlap, branch="both"):
    dimension, sigma, delta = extended(contact.fractal_dimension), extended(contact.roughness), extended(overlap)
    m = extended("0.2567") * dimension
    r = 2 / (3 * (1 - m))
    h = extended(3) / 4 * np.sqrt(PI) * (20 / (np.sqrt(PI) ** 3 * dimension)) ** (1 / m) * sigma
    t = delta / (r * h)
    power = {"both": t < 1, "power": True, "hertz": False}[branch]
    return from_hertz(contact, np.where(power, h * t**r, delta - (r - 1) * h), np.where(power, t ** (r - 1), 1))


def _advise(conditions):
    return elastic_bulk(conditions, conditions.contact.fractal_dimension is not None, "needs a fractal dimension")


LAW = Definition(
    name="pohrt-popov",
    prepare=_prepare,
    equation="K = (π√A0 E* Df/10) (P/(σ E* √A0))^(0.2567 Df) to F, then Hertz stiffness",
    source="Pohrt & Popov 2012, 2013; Altuhafi, Baudet & Coop 2023, Eqs. 7–9",
    description="self-affine roughness",
    limits=_limits,
    kinks=_kinks,
    needs=("fractal_dimension",),
    exact=_exact,
    options={
        "branch": Option("", "both, power or hertz", "side of the threshold that is kept, for scenes that never leave it"),
    },
    fitting=Fitting(
        parameters={"roughness": ROUGHNESS, "fractal_dimension": DIMENSION}, free=("roughness", "fractal_dimension")
    ),
    advice=Advice(
        advise=_advise,
        rank=4,
        candidate=True,
        branches={"power": "Hertz stiffness above the threshold", "hertz": "power law below the threshold"},
    ),
    drawing=Drawing(label="Pohrt-Popov", colour="#d62728"),
)
