"""Thornton & Ning 1998 without adhesion: Hertz to a limit contact pressure, then a straight line; Thornton's unloading."""

import math
from typing import NamedTuple

import numpy as np

from demlaws.contact import GRANITE_YIELD_PRESSURE, pressure_of
from demlaws.core.dispatch import bind
from demlaws.core.fastmath import hertz_coefficient, kernel
from demlaws.laws.definition import (
    POSITIVE,
    PRESSURE,
    Advice,
    Bulk,
    Definition,
    Drawing,
    Fitting,
    Loading,
    Option,
    Rules,
    no_limits,
    pressure_option,
    yielding_bulk,
)
from demlaws.laws.hertz import HertzParams, HertzShape
from demlaws.laws.rough_plastic import RoughPlasticParams


class ThorntonNingShape(NamedTuple):
    """The limit pressure, and Hertz's law before yield."""

    loading: HertzShape
    yield_pressure: float  # p_y [Pa]


@kernel
def _scale(shape, radius, modulus, roughness):
    # p_y = 2 E* a_y/(π R), δ_y = a_y²/R; then dP/dδ = π R p_y: Params and curve of a smooth contact that yields
    ratio = 0.5 * math.pi * shape.yield_pressure / modulus
    overlap = ratio * ratio * radius
    stiffness = math.pi * radius * shape.yield_pressure
    coefficient = hertz_coefficient(radius, modulus)
    force = 2.0 / 3.0 * stiffness * overlap  # there Hertz's stiffness, 1.5 P/δ, is that of the line
    return RoughPlasticParams(coefficient, HertzParams(coefficient), 1.0, overlap, force, stiffness, overlap, 1.0 / stiffness)


bind(ThorntonNingShape, scale=_scale)


LAW = Definition(
    name="thornton-ning",
    prepare=lambda contact, yield_pressure: ThorntonNingShape(
        HertzShape(), pressure_of(contact, yield_pressure, "yield_pressure")
    ),
    equation="P = (4/3) E* √R δ^1.5 to p_y, then dP/dδ = π R p_y; back along Hertz's curve of R_p",
    source="Thornton 1997; Thornton & Ning 1998, Powder Technology 99, 154 (10.1016/S0032-5910(98)00099-0), without adhesion",
    description="smooth spheres whose bulk yields",
    limits=no_limits,
    loading=Loading(kinks=lambda p, **_: [p.yield_overlap], bulk=Bulk(lambda p: (p.yield_overlap, p.yield_area, p.area_slope))),
    length="radius",
    collapses=False,
    unloading=("elastic", "hertz", "thornton"),
    rules=Rules(default="thornton"),
    options={
        "yield_pressure": Option(
            "Pa",
            POSITIVE,
            "limit contact pressure p_y, a fit parameter: 1.6 (first yield) to 4.2 times the yield strength",
            PRESSURE,
        ),
    },
    fitting=Fitting({"yield_pressure": pressure_option(1e-4, 1.0, *np.geomspace(0.01, 0.3, 4))}, ("yield_pressure",)),
    advice=Advice(suits=yielding_bulk, smooth=True),
    drawing=Drawing(colour="#bcbd22", example={"yield_pressure": GRANITE_YIELD_PRESSURE}),
)
