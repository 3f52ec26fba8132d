"""Conical Damage Model (Harkness et al. 2016; Suhr & Six 2016): Hertz whose radius grows where the tip crushes.

Beyond the load at which Hertz's peak pressure is σ_max the contact keeps that pressure: the radius becomes
R = (δ + R0 A)/(h + A) with h = (π σ_max/(2E*))², A = (1 - sin α)/sin α, and the overlap of the blunted tip is
u = δ - (R - R0) A = h R, so that P = (4/3) E* √R u^1.5 = (4/3) E* h^1.5 R². Contact area and load are then proportional,
a²/P = 3/(2π σ_max), and unloading along Hertz's curve of R from u is rule `thornton`.
"""

import math
from typing import NamedTuple

import numpy as np

from demlaws.contact import GRANITE_YIELD_PRESSURE, pressure_of
from demlaws.core.dispatch import bind
from demlaws.core.fastmath import hertz_coefficient, hertz_overlap, kernel, sqrt
from demlaws.errors import DemlawsError
from demlaws.laws.definition import (
    LENGTH,
    POSITIVE,
    PRESSURE,
    Advice,
    Bulk,
    Definition,
    Drawing,
    Fitting,
    Limit,
    Loading,
    Numbers,
    Option,
    Parameter,
    Rules,
    elastic_bulk,
    power_of,
    pressure_option,
)


class ConicalDamageShape(NamedTuple):
    """The strength and the cone."""

    strength: float  # σ_max [Pa]
    blunting: float  # A = (1 - sin α)/sin α


class ConicalDamageParams(NamedTuple):
    """One contact."""

    hertz_coefficient: float  # (4/3) E* √R0 [N/m^1.5]
    yield_overlap: float  # h R0 [m]
    yield_force: float  # P where the peak pressure is σ_max [N]
    growth: float  # d(R/R0)/dδ = 1/(R0 (h + A)) [1/m]


@kernel
def _scale(shape, radius, modulus, roughness):
    ratio = 0.5 * math.pi * shape.strength / modulus
    h = ratio * ratio
    overlap = h * radius
    coefficient = hertz_coefficient(radius, modulus)
    return ConicalDamageParams(
        coefficient, overlap, coefficient * overlap * sqrt(overlap), 1.0 / (radius * (h + shape.blunting))
    )


@kernel
def _first_loading(shape, p, overlap):
    excess = overlap - p.yield_overlap
    ratio = 1.0 + p.growth * (0.0 if excess <= 0.0 else excess)  # R/R0
    root = p.hertz_coefficient * sqrt(overlap)
    force = p.yield_force * ratio * ratio
    stiffness = 2.0 * p.yield_force * p.growth * ratio
    equivalent = hertz_overlap(p, force)
    # a² = u R = h R²: over R0
    area = p.yield_overlap * ratio * ratio
    if excess <= 0.0:
        return root * overlap, 1.5 * root, overlap, overlap
    return force, stiffness, equivalent, area


@kernel
def _inverse(shape, p, force):
    if force <= p.yield_force:
        return hertz_overlap(p, force)
    return p.yield_overlap + (sqrt(force / p.yield_force) - 1.0) / p.growth


@kernel
def _energy(shape, p, overlap):
    low = overlap if overlap <= p.yield_overlap else p.yield_overlap
    work = 0.4 * p.hertz_coefficient * low * low * sqrt(low)
    if overlap <= p.yield_overlap:
        return work
    more = overlap - p.yield_overlap
    x = p.growth * more
    return work + p.yield_force * more * (1.0 + x + x * x / 3.0)


bind(ConicalDamageShape, scale=_scale)
bind(ConicalDamageParams, first_loading=_first_loading, inverse=_inverse, energy=_energy)


def _blunting(angle):
    """A = (1 - sin α)/sin α, a depth over a radius."""
    return (1.0 - math.sin(angle)) / math.sin(angle)


def _prepare(contact, strength, angle):
    if angle >= 0.5 * math.pi:
        raise DemlawsError(f"angle = {angle:g} rad: give an angle below π/2, where the cone is a plane")
    return ConicalDamageShape(pressure_of(contact, strength, "strength"), _blunting(angle))


def _limits(contact, strength, angle):
    """Of the work of crushing a blunted tip stores 1.2 h/(h + A), more than all of it where A < h/5 [our derivation]."""
    modulus, radius = np.broadcast_arrays(np.asarray(contact.modulus, float), np.asarray(contact.radius, float))
    h = (0.5 * math.pi * strength / modulus) ** 2
    returns = (h > 5.0 * _blunting(angle)) & (h < 1.0)
    if not np.any(returns):
        return []
    load = float(np.min((4.0 / 3.0 * modulus * h * np.sqrt(h) * radius * radius)[returns]))
    deep = float(np.min(h[returns]))
    reason = (
        f"tips crush from overlaps of {deep:.2g} R on, and a cone of α = {angle:.4g} rad is too blunt for that: unloading "
        "returns more work than crushing took; a lower strength or a sharper cone (a smaller α) does not"
    )
    return [Limit(0.0, load, reason)]


def _angle_softens(angle, factor):
    """A = (1 - sin α)/sin α is a depth over a radius."""
    return math.asin(1.0 / (1.0 + _blunting(angle) * power_of(factor, LENGTH)))


LAW = Definition(
    name="conical-damage",
    prepare=_prepare,
    equation="Hertz to p0 = σ_max, then p0 = σ_max: R = (δ + R0 A)/(h + A), P = (4/3) E* h^1.5 R²",
    source="Harkness et al. 2016, Granular Matter 18:65; Suhr & Six 2016, 2017, Granular Matter 19:64",
    description="tips that crush, for ballast",
    limits=_limits,
    loading=Loading(
        kinks=lambda p, **_: [p.yield_overlap],
        bulk=Bulk(lambda p: (p.yield_overlap, p.yield_overlap, p.yield_overlap / p.yield_force)),
    ),
    length="radius",
    collapses=False,
    unloading=("elastic", "thornton"),
    rules=Rules(
        default="thornton",
        refused={
            "hertz": "a crushed tip is wider: at some contacts Hertz's curve of the old radius returns more work than loading "
            "took; use 'thornton'"
        },
    ),
    options={
        "strength": Option("Pa", POSITIVE, "σ_max, peak pressure at which the tip crushes", PRESSURE, "sigmaMax"),
        "angle": Option(
            "rad", Numbers(0.0, 0.5 * math.pi), "α of the cone that it becomes: blunt near π/2", _angle_softens, "alpha"
        ),
    },
    fitting=Fitting(
        identifiable=False,
        parameters={
            "strength": pressure_option(1e-4, 1.0, 0.02, 0.1),
            "angle": Parameter("rad", True, lambda c: (0.02, 1.57), lambda c: [0.5, 1.3], option=True),
        },
        free=("strength", "angle"),
    ),
    advice=Advice(
        suits=lambda conditions: elastic_bulk(
            conditions, False, f"{conditions.state}: calibrated on ballast in bulk, not measured on contacts"
        ),
        smooth=True,
    ),
    drawing=Drawing(colour="#5254a3", line="-.", example={"strength": GRANITE_YIELD_PRESSURE, "angle": 1.2}),
)
