"""Walton & Braun 1986: linear loading, stiffer linear unloading ("partially latching spring").

With constant k2 it is EDEM's Hysteretic Spring model as Altair describes it, e = √(K1/K2). Of k2 = k1 + S Pmax no second
public statement was found.
"""

from typing import NamedTuple

from demlaws.core.dispatch import bind
from demlaws.core.fastmath import hertz_coefficient, kernel
from demlaws.errors import DemlawsError
from demlaws.laws.definition import (
    STIFFNESS,
    Advice,
    Definition,
    Drawing,
    Fitting,
    Numbers,
    Option,
    Rules,
    no_limits,
    plastic_from_the_start,
)
from demlaws.laws.linear_unloading import K1, LINEAR, ONLY_STRAIGHT, STRAIGHT, LinearParams, numbers


class WaltonBraunShape(NamedTuple):
    """The stiffnesses are those of every contact."""

    loading_stiffness: float  # k1 [N/m]
    stiffness_ratio: float  # k2/k1 of the first contact
    growth: float  # S [1/m]


@kernel
def _scale(shape, radius, modulus, roughness):
    k1 = shape.loading_stiffness
    first, growth = shape.stiffness_ratio * k1, shape.growth * k1
    beyond = 4.0 * radius  # overlaps end at R: neither the limit nor the largest stiffness is met
    return LinearParams(hertz_coefficient(radius, modulus), k1, first, growth, first + growth * beyond, beyond)


bind(WaltonBraunShape, scale=_scale)


def _prepare(contact, loading_stiffness, stiffness_ratio=None, growth=None):
    if (stiffness_ratio is None) == (growth is None):
        raise DemlawsError(
            "law 'walton-braun' needs either stiffness_ratio, k2/k1 from 1, or growth, S in 1/m of k2 = k1 + S Pmax: give one"
        )
    if growth is None:
        return WaltonBraunShape(loading_stiffness, stiffness_ratio, 0.0)
    return WaltonBraunShape(loading_stiffness, 1.0, growth)


LAW = Definition(
    name="walton-braun",
    prepare=_prepare,
    equation="P = k1 δ; back along k2 (δ - δp), k2 constant or k2 = k1 + S Pmax",
    source="Walton & Braun 1986, J. Rheol. 30, 949 (10.1122/1.549893)",
    description="straight branches, plastic",
    limits=no_limits,
    length="radius",
    collapses=False,
    unloading=("elastic", "linear"),
    rules=Rules(default="linear", own=(LINEAR,), numbers=numbers, refused=ONLY_STRAIGHT),
    options={
        "loading_stiffness": K1,
        "stiffness_ratio": Option("", Numbers(1.0, 1e6, True), "k2/k1; this or growth is needed"),
        "growth": Option("1/m", Numbers(0.0, included=True), "S of k2 = k1 + S Pmax, in place of stiffness_ratio", STIFFNESS),
    },
    fitting=Fitting(
        identifiable=False,
        parameters=STRAIGHT,
        free=("loading_stiffness", "stiffness_ratio"),
    ),
    advice=Advice(suits=plastic_from_the_start),
    drawing=Drawing(
        colour="#7b3294", example={"loading_stiffness": 3e6, "stiffness_ratio": 2.0}, example_curve={"loading_stiffness": 6e6}
    ),
)
