"""Luding 2008 without adhesion: straight branches whose unloading stiffens up to a limit overlap, elastic beyond.

The formulae agree with those of MercuryDPM (LinearPlasticViscoelasticInteraction.cc).
"""

from typing import NamedTuple

from demlaws.core.dispatch import bind
from demlaws.core.fastmath import hertz_coefficient, kernel
from demlaws.laws.definition import (
    LENGTH,
    Advice,
    Definition,
    Drawing,
    Fitting,
    Loading,
    Numbers,
    Option,
    Parameter,
    Rules,
    no_limits,
    plastic_from_the_start,
)
from demlaws.laws.linear_unloading import K1, LINEAR, ONLY_STRAIGHT, STRAIGHT, LinearParams, numbers


class LudingShape(NamedTuple):
    """The stiffnesses are those of every contact."""

    loading_stiffness: float  # k1 [N/m]
    stiffness_ratio: float  # k̂2/k1
    plasticity_depth: float  # φ_f


@kernel
def _scale(shape, radius, modulus, roughness):
    k1 = shape.loading_stiffness
    largest = shape.stiffness_ratio * k1
    # δ* = k̂2/(k̂2 - k1) φ_f 2 a1 a2/(a1 + a2); R = a1 a2/(a1 + a2)
    limit = shape.stiffness_ratio / (shape.stiffness_ratio - 1.0) * shape.plasticity_depth * 2.0 * radius
    return LinearParams(hertz_coefficient(radius, modulus), k1, k1, (largest - k1) / limit, largest, limit)


bind(LudingShape, scale=_scale)


LAW = Definition(
    name="luding",
    prepare=lambda contact, loading_stiffness, stiffness_ratio, plasticity_depth: LudingShape(
        loading_stiffness, stiffness_ratio, plasticity_depth
    ),
    equation="P = k1 δ to δ*, then k̂2; back along k2 (δ - δp), k2 = k1 + (k̂2 - k1) δmax/δ*",
    source="Luding 2008, Granular Matter 10, 235 (10.1007/s10035-008-0099-x), without its adhesive branch",
    description="straight branches, plastic to a depth",
    limits=no_limits,
    loading=Loading(kinks=lambda p, **_: [p.limit]),
    length="radius",
    collapses=False,
    unloading=("elastic", "linear"),
    rules=Rules(default="linear", own=(LINEAR,), numbers=numbers, refused=ONLY_STRAIGHT),
    options={
        "loading_stiffness": K1,
        "stiffness_ratio": Option("", Numbers(1.0, 1e6), "k̂2/k1, of the stiffest unloading"),
        "plasticity_depth": Option("", Numbers(0.0, 1.0), "φ_f, largest plastic overlap over 2R", LENGTH),
    },
    fitting=Fitting(
        identifiable=False,
        parameters={
            **STRAIGHT,
            "stiffness_ratio": STRAIGHT["stiffness_ratio"]._replace(unloading=False),  # loading shows it beyond δ*
            "plasticity_depth": Parameter("", True, lambda c: (1e-6, 0.5), lambda c: [1e-3], option=True),
        },
        free=("loading_stiffness", "stiffness_ratio", "plasticity_depth"),
    ),
    advice=Advice(suits=plastic_from_the_start),
    drawing=Drawing(
        colour="#c51b7d",
        example={"loading_stiffness": 3e6, "stiffness_ratio": 5.0, "plasticity_depth": 0.005},
        example_curve={"loading_stiffness": 1.5e7},
    ),
)
