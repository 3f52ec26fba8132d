"""Hertz 1882: smooth elastic spheres."""

import math
from typing import NamedTuple

import numpy as np

from demlaws.core.dispatch import bind
from demlaws.core.fastmath import hertz_coefficient, hertz_overlap, kernel, sqrt
from demlaws.laws.definition import HERTZ_CURVE, Advice, Definition, Drawing, Fitting, Limit, Loading, bulk_yield, elastic_bulk


class HertzShape(NamedTuple):
    """Nothing distinguishes one Hertz law from another."""


class HertzParams(NamedTuple):
    """One smooth contact."""

    hertz_coefficient: float  # (4/3) E* √R [N/m^1.5]


@kernel
def _scale(shape, radius, modulus, roughness):
    return HertzParams(hertz_coefficient(radius, modulus))


@kernel
def _first_loading(shape, p, overlap):
    stiffness = p.hertz_coefficient * sqrt(overlap)
    return stiffness * overlap, 1.5 * stiffness, overlap, overlap


@kernel
def _inverse(shape, p, force):
    return hertz_overlap(p, force)


@kernel
def _inverse_near(shape, p, force, equivalent):
    return equivalent


@kernel
def _energy(shape, p, overlap):
    return 0.4 * p.hertz_coefficient * overlap * overlap * sqrt(overlap)


bind(HertzShape, scale=_scale)
bind(HertzParams, first_loading=_first_loading, inverse=_inverse, inverse_near=_inverse_near, energy=_energy)


SMOOTH = 0.05
"""α = σ/δ up to which roughness changes the contact radius by at most 7 % (Johnson 1985, ch. 13)."""


def _limits(contact):
    limits = bulk_yield(contact)
    overlap = np.asarray(contact.sigma_or_zero) / SMOOTH
    force = 4.0 / 3.0 * np.asarray(contact.modulus) * np.sqrt(contact.radius) * overlap**1.5
    if np.any(force > 0.0):
        reason = f"α > {SMOOTH:g}: this law has no roughness, which makes a contact softer at low load (pohrt-popov, rms)"
        limits.append(Limit(float(np.max(force)), math.inf, reason))
    return limits


def _suits(conditions):
    drop = float(conditions.pressure_drop)
    reason = f"α = {conditions.roughness_parameter:.2g} at low load: roughness lowers the pressure by {100 * (1 - drop):.0f} %"
    return elastic_bulk(conditions, drop > 0.95, reason)


LAW = Definition(
    name="hertz",
    prepare=lambda contact: HertzShape(),
    equation="P = (4/3) E* √R δ^1.5",
    source="Hertz 1882; Johnson, Contact Mechanics, 1985, ch. 4",
    description="smooth elastic spheres",
    limits=_limits,
    length="radius",
    unloading=("elastic",),  # which is Hertz's
    loading=Loading(computed=HERTZ_CURVE),
    fitting=Fitting(free=("modulus",)),
    advice=Advice(
        suits=_suits,
        rank=1,
        smooth=True,
        candidate=True,
        closed_form_is_cheapest=True,
        native={"yade": "hertz", "liggghts": "hertz", "lammps": "hertz"},
    ),
    drawing=Drawing(colour="#222222", line="--"),
)
