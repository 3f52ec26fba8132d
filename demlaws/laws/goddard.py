"""Goddard 1990: blunt cone tips that round off."""

import math
from typing import NamedTuple

from demlaws.core.dispatch import bind
from demlaws.core.fastmath import cbrt, hertz_coefficient, hertz_overlap, kernel, sqrt
from demlaws.laws.definition import Definition, Drawing, Fitting, Loading, Numbers, Option, Parameter, slope_softens
from demlaws.laws.pohrt_popov import transition_energy

_RATIO = 4.0 / 3.0  # δ*/δ_H(P*): a cone's overlap over Hertz's at the load where they have one stiffness


class GoddardShape(NamedTuple):
    """Depends on the surface slope only."""

    threshold_over_radius: float  # δ*/R = (3π²/16) tan²β


class GoddardParams(NamedTuple):
    """One contact."""

    hertz_coefficient: float  # (4/3) E* √R [N/m^1.5]
    inverse_threshold: float  # 1/δ* [1/m]
    offset: float  # δ* - δ_H(P*) = δ*/4 [m]


@kernel
def _scale(shape, radius, modulus, roughness):
    threshold = shape.threshold_over_radius * radius
    return GoddardParams(hertz_coefficient(radius, modulus), 1.0 / threshold, 0.25 * threshold)


@kernel
def _first_loading(shape, p, overlap):
    relative = overlap * p.inverse_threshold
    slope = cbrt(relative)
    if relative < 1.0:
        equivalent = 0.75 * overlap * slope
    else:
        equivalent = overlap - p.offset
        slope = 1.0
    root = p.hertz_coefficient * sqrt(equivalent)
    return root * equivalent, 1.5 * root * slope, equivalent, equivalent


@kernel
def _inverse(shape, p, force):
    equivalent = hertz_overlap(p, force)
    relative = equivalent * p.inverse_threshold * _RATIO
    if relative < 1.0:
        return sqrt(relative * sqrt(relative)) / p.inverse_threshold
    return equivalent + p.offset


@kernel
def _energy(shape, p, overlap):
    force, _, equivalent, _ = _first_loading(shape, p, overlap)
    return transition_energy(p, _RATIO, overlap, force, equivalent)


bind(GoddardShape, scale=_scale)
bind(GoddardParams, first_loading=_first_loading, inverse=_inverse, energy=_energy)


LAW = Definition(
    name="goddard",
    prepare=lambda contact, slope: GoddardShape(3.0 * math.pi**2 / 16.0 * max(math.tan(slope) ** 2, 1e-40)),
    equation="P = (2E*/(π tan β)) δ² to P* = (9π³/128) E* R² tan³β, then Hertz stiffness",
    source="Goddard 1990; surface slope β in place of the cone's: our derivation",
    description="blunt cone tips",
    loading=Loading(kinks=lambda p, **_: [1.0 / p.inverse_threshold]),
    length="radius",
    options={
        "slope": Option("rad", Numbers(0.0, 1.0, True), "slope β of the tip's or the surface's flank", slope_softens),
    },
    fitting=Fitting(
        parameters={"slope": Parameter("rad", True, lambda c: (1e-4, 0.9), lambda c: [0.003, 0.01, 0.03, 0.1], option=True)},
        free=("slope",),
    ),
    drawing=Drawing(colour="#8c564b", example={"slope": 0.035}, example_curve={"slope": 0.03}),
)
