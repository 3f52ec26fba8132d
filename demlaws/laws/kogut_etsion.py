"""Kogut & Etsion 2002: finite elements of an elastic-perfectly plastic sphere, as powers of ω/ω_c.

The printed branches do not meet: 1.03 (ω/ω_c)^1.425 stands for 1 to 6, 1.40 (ω/ω_c)^1.263 for 6 to 110, and Hertz below. Here
P/P_c is the smallest of the three at every ω, so that each begins where it crosses the one before: at 1.483 and 6.649 in
place of 1 and 6; between 1 and 1.483 and between 6 and 6.649 that is up to 2.9 and 1.7 % below print. The printed areas,
0.93 (ω/ω_c)^1.136 and 0.94 (ω/ω_c)^1.146, do not meet either: here A/A_c is the larger of ω/ω_c and the second, within
2.9 % of print between 1 and 6, as printed beyond.

Each coefficient, with K = 0.454 + 0.41 ν and H = 2.8 Y, agrees with two public codes of others (TaoYang1999/SCHC-framework,
and a set of MATLAB functions of statistical models).
"""

import math
from typing import NamedTuple

import numpy as np

from demlaws.contact import pressure_of
from demlaws.core.dispatch import bind
from demlaws.core.fastmath import exp2, hertz_coefficient, hertz_overlap, kernel, log2, sqrt
from demlaws.laws.definition import (
    POSITIVE,
    PRESSURE,
    Advice,
    Definition,
    Drawing,
    Fitting,
    Limit,
    Loading,
    Numbers,
    Option,
    Rules,
    pressure_option,
    yielding_bulk,
)
from demlaws.laws.etsion import ETSION, JACKSON, NOT_THORNTON, rule_numbers

_FACTOR1, _POWER1, _FACTOR2, _POWER2 = 1.03, 1.425, 1.40, 1.263
_AREA, _AREA_POWER = 0.94, 1.146
_FIRST = _FACTOR1 ** (1.0 / (1.5 - _POWER1))  # ω/ω_c at which the branches cross
_SECOND = (_FACTOR2 / _FACTOR1) ** (1.0 / (_POWER1 - _POWER2))
_FORCE1 = _FIRST**1.5
_FORCE2 = _FACTOR1 * _SECOND**_POWER1
_ENERGY1 = 0.4 * _FIRST**2.5  # ∫ P/P_c d(ω/ω_c) there
_WORK1, _WORK2 = _FACTOR1 / (_POWER1 + 1.0), _FACTOR2 / (_POWER2 + 1.0)  # ∫ of the branches: these times ω^(power + 1)
_ENERGY2 = _ENERGY1 + _WORK1 * (_SECOND ** (_POWER1 + 1.0) - _FIRST ** (_POWER1 + 1.0))
_OFFSET1, _OFFSET2 = _ENERGY1 - _WORK1 * _FIRST ** (_POWER1 + 1.0), _ENERGY2 - _WORK2 * _SECOND ** (_POWER2 + 1.0)
LARGEST_RATIO = 110.0
"""ω/ω_c to which the finite elements went."""


class KogutEtsionShape(NamedTuple):
    """K H, the pressure that with E* and R gives ω_c."""

    pressure: float  # K H [Pa]


class KogutEtsionParams(NamedTuple):
    """One contact."""

    hertz_coefficient: float  # (4/3) E* √R [N/m^1.5]
    critical_overlap: float  # ω_c [m]
    inverse_critical: float  # [1/m]
    critical_force: float  # P_c [N]


@kernel
def _scale(shape, radius, modulus, roughness):
    ratio = 0.5 * math.pi * shape.pressure / modulus
    critical = ratio * ratio * radius
    coefficient = hertz_coefficient(radius, modulus)
    return KogutEtsionParams(coefficient, critical, 1.0 / critical, coefficient * critical * sqrt(critical))


@kernel
def _first_loading(shape, p, overlap):
    w = overlap * p.inverse_critical
    logarithm = log2(w if w > 1.0 else 1.0)
    factor = _FACTOR1 if w <= _SECOND else _FACTOR2
    power = _POWER1 if w <= _SECOND else _POWER2
    force = factor * p.critical_force * exp2(power * logarithm)
    stiffness = power * force / overlap
    equivalent = hertz_overlap(p, force)
    area = _AREA * p.critical_overlap * exp2(_AREA_POWER * logarithm)
    area = area if area > overlap else overlap
    root = p.hertz_coefficient * sqrt(overlap)
    if w <= _FIRST:
        return root * overlap, 1.5 * root, overlap, overlap
    return force, stiffness, equivalent, area


@kernel
def _inverse(shape, p, force):
    f = force / p.critical_force
    if f <= _FORCE1:
        return hertz_overlap(p, force)
    if f <= _FORCE2:
        return p.critical_overlap * exp2(log2(f / _FACTOR1) / _POWER1)
    return p.critical_overlap * exp2(log2(f / _FACTOR2) / _POWER2)


@kernel
def _energy(shape, p, overlap):
    w = overlap * p.inverse_critical
    if w <= _FIRST:
        return 0.4 * p.hertz_coefficient * overlap * overlap * sqrt(overlap)
    if w <= _SECOND:
        work = _OFFSET1 + _WORK1 * exp2((_POWER1 + 1.0) * log2(w))
    else:
        work = _OFFSET2 + _WORK2 * exp2((_POWER2 + 1.0) * log2(w))
    return work * p.critical_force * p.critical_overlap


bind(KogutEtsionShape, scale=_scale)
bind(KogutEtsionParams, first_loading=_first_loading, inverse=_inverse, energy=_energy)


def _pressure(strength, poisson):
    """K H [Pa]: K = 0.454 + 0.41 ν, H = 2.8 Y."""
    return (0.454 + 0.41 * poisson) * 2.8 * strength


def _limits(contact, yield_strength, poisson=0.3):
    radius, modulus = np.asarray(contact.radius), np.asarray(contact.modulus)
    critical = (0.5 * math.pi * _pressure(yield_strength, poisson) / modulus) ** 2 * radius
    force = 4.0 / 3.0 * modulus * np.sqrt(radius) * critical**1.5 * _FACTOR2 * LARGEST_RATIO**_POWER2
    return [
        Limit(
            0.0, float(np.min(force)), "the finite elements behind the law end at 110 ω_c, where the contact is fully plastic"
        )
    ]


STRENGTH = pressure_option(1e-5, 0.3, *np.geomspace(0.005, 0.1, 3))
STRENGTH_OPTION = Option("Pa", POSITIVE, "yield strength of the softer body", PRESSURE)
POISSON_OPTION = Option("", Numbers(0.0, 0.5, True), "its Poisson's ratio")

LAW = Definition(
    name="kogut-etsion",
    prepare=lambda contact, yield_strength, poisson=0.3: KogutEtsionShape(
        _pressure(pressure_of(contact, yield_strength, "yield_strength"), poisson)
    ),
    equation="P/P_c = min(ω^1.5, 1.03 ω^1.425, 1.40 ω^1.263), ω = δ/ω_c, ω_c = (π K H/(2E*))² R",
    source="Kogut & Etsion 2002 (10.1115/1.1490373); unloading Etsion, Kligerman & Kadin 2005 (10.1016/j.ijsolstr.2004.12.006)",
    description="smooth spheres that yield, fitted",
    limits=_limits,
    loading=Loading(kinks=lambda p, **_: [_FIRST * p.critical_overlap, _SECOND * p.critical_overlap]),
    length="radius",
    collapses=False,
    unloading=("elastic", "etsion"),
    rules=Rules(
        default="etsion",
        own=(ETSION, JACKSON),
        numbers=lambda p, length, error: rule_numbers(p, length, _AREA ** (-1.0 / (_AREA_POWER - 1.0)), _AREA_POWER - 1.0),
        refused=NOT_THORNTON,
    ),
    options={"yield_strength": STRENGTH_OPTION, "poisson": POISSON_OPTION},
    fitting=Fitting(identifiable=False, parameters={"yield_strength": STRENGTH}, free=("yield_strength",)),
    advice=Advice(suits=yielding_bulk, smooth=True),
    drawing=Drawing(colour="#4d9221", line="--", example={"yield_strength": 1.0375e9}),
)
