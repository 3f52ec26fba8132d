"""Thornton & Ning 1998 without adhesion: Hertz to a limit contact pressure, then a straight line; Thornton's unloading.

The bulk yields where Hertz's stiffness reaches π R p_y, at a_y = π R p_y/(2E*): `rough-plastic` of smooth spheres.
"""

import numpy as np

from demlaws.contact import GRANITE_YIELD_PRESSURE, pressure_of
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
from demlaws.laws.hertz import HertzShape
from demlaws.laws.rough_plastic import RoughPlasticShape

LAW = Definition(
    name="thornton-ning",
    prepare=lambda contact, yield_pressure: RoughPlasticShape(
        HertzShape(), pressure_of(contact, yield_pressure, "yield_pressure"), 0.0, 0.0
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
