"""Straight branches, loading with k1 and unloading with k2(δmax) ≥ k1: Walton & Braun, and Luding without adhesion."""

from typing import NamedTuple

import numpy as np

from demlaws.core.dispatch import bind, energy, first_loading, unloading_curve
from demlaws.core.fastmath import hertz_coefficient, hertz_overlap, kernel, sqrt
from demlaws.core.shear import of_first_loading
from demlaws.core.unloading import Rule, own_rule
from demlaws.laws.definition import POSITIVE, STIFFNESS, Option, Parameter


class LinearParams(NamedTuple):
    """One contact: P = k1 δ to `limit`, then straight on with the largest k2."""

    hertz_coefficient: float  # (4/3) E* √R [N/m^1.5]: of the smooth elastic contact; the force does not depend on it
    loading_stiffness: float  # k1 [N/m]
    first_stiffness: float  # k2 of a contact that has hardly been loaded [N/m]
    stiffening: float  # dk2/dδmax [N/m²]
    largest_stiffness: float  # of all k2 [N/m]
    limit: float  # δmax at which k2 is the largest, if loading goes on with that [m]


@kernel
def _first_loading(shape, p, overlap):
    straight = overlap if overlap <= p.limit else p.limit
    force = p.loading_stiffness * straight + p.largest_stiffness * (overlap - straight)
    equivalent = hertz_overlap(p, force)
    return force, p.loading_stiffness if overlap <= p.limit else p.largest_stiffness, equivalent, equivalent


@kernel
def _inverse(shape, p, force):
    at_limit = p.loading_stiffness * p.limit
    if force <= at_limit:
        return force / p.loading_stiffness
    return p.limit + (force - at_limit) / p.largest_stiffness


@kernel
def _energy(shape, p, overlap):
    straight = overlap if overlap <= p.limit else p.limit
    more = overlap - straight
    return p.loading_stiffness * straight * (0.5 * straight + more) + 0.5 * p.largest_stiffness * more * more


bind(LinearParams, first_loading=_first_loading, inverse=_inverse, energy=_energy)


class Linear(NamedTuple):
    """Unloads along P = k2 (δ - δp), δp = δmax - Pmax/k2, k2 = k2(δmax) of the law; reloads likewise."""


@kernel
def _stiffness(params, maximum):
    k2 = params.first_stiffness + params.stiffening * maximum
    return k2 if k2 <= params.largest_stiffness else params.largest_stiffness


@kernel
def _step(rule, shape, p, overlap, state):
    params = unloading_curve(shape, p)[1]
    positive = 0.0 if overlap <= 0.0 else overlap
    if overlap >= state[0]:
        force, stiffness, _, _ = first_loading(shape, p, positive)
        maximum, plastic = overlap, overlap - force / _stiffness(params, overlap)
    else:
        maximum, plastic = state
        k2 = _stiffness(params, maximum)
        elastic = positive - plastic
        force = k2 * (0.0 if elastic <= 0.0 else elastic)
        stiffness = 0.0 if elastic <= 0.0 else k2
    if overlap <= 0.0:
        force, stiffness, maximum, plastic = 0.0, 0.0, 0.0, 0.0
    return force, stiffness, (maximum, plastic)


@kernel
def _stored_and_dissipated(rule, shape, p, overlap, state):
    if state[0] <= 0.0:
        return 0.0, 0.0
    k2 = _stiffness(unloading_curve(shape, p)[1], state[0])
    elastic = max(overlap - state[1], 0.0) if overlap > 0.0 else 0.0
    whole = state[0] - state[1]
    return 0.5 * k2 * elastic * elastic, energy(shape, p, state[0]) - 0.5 * k2 * whole * whole


@kernel
def _unloaded(rule, shape, p, force, state):
    return state[1] + force / _stiffness(unloading_curve(shape, p)[1], state[0])


@kernel
def _unloading_stiffness(rule, shape, p, overlap, force, stiffness, state):
    return _stiffness(unloading_curve(shape, p)[1], overlap) if overlap >= state[0] and overlap > 0.0 else stiffness


bind(
    Linear,
    step=_step,
    stored_and_dissipated=_stored_and_dissipated,
    unloaded=_unloaded,
    unloading_stiffness=_unloading_stiffness,
    loading_stiffness=of_first_loading,
)


class LinearNumbers(NamedTuple):
    """k2 in a table, without units."""

    first: float  # k2/(E* √(R length)) of a contact hardly loaded
    growth: float  # of that by δmax/length
    largest: float
    length_over_roughness: float
    length_over_radius: float


@kernel
def _table_scale(shape, radius, modulus, roughness):
    length = shape.length_over_roughness * roughness + shape.length_over_radius * radius
    unit = modulus * sqrt(radius * length)
    first, growth, largest = shape.first * unit, shape.growth * unit / length, shape.largest * unit
    return LinearParams(hertz_coefficient(radius, modulus), 0.0, first, growth, largest, 0.0)  # loading is the table's


bind(LinearNumbers, scale=_table_scale)

LINEAR = own_rule(
    Rule(
        "linear",
        Linear(),
        ("maximum_overlap", "plastic_overlap"),
        "law",
        4,
        "back along a straight line, P = k2 (δ - δp), k2 as the law says",
        ("linear_first", "linear_growth", "linear_largest"),
        LinearNumbers,
    )
)
"""The rule of every law of straight branches."""


def numbers(p, length, error):
    """k2/(E* √(R length)) of a contact hardly loaded, its growth by δmax/length, and the largest; larger by the table's error.

    Where k2 is the stiffness of loading, a table whose force or stiffness errs upwards would else return work.
    """
    scale = 0.75 * p.hertz_coefficient * length**0.5 / (1.0 + error)
    stiffness = p.first_stiffness / scale, p.stiffening * length / scale, p.largest_stiffness / scale
    return dict(zip(LINEAR.keys, stiffness, strict=True))


ONLY_STRAIGHT = dict.fromkeys(
    ("hertz", "thornton"),
    "at small load a straight branch is stiffer than Hertz's, along which it would return more than it took",
)
K1 = Option("N/m", POSITIVE, "k1; granite of R = 4 mm at 10 N: 3e6", STIFFNESS)
"""Option `loading_stiffness`."""
STRAIGHT = {
    "loading_stiffness": Parameter(
        "N/m",
        True,
        lambda c: (1e-7 * c.modulus * c.radius, 1e3 * c.modulus * c.radius),
        lambda c: c.modulus * c.radius * np.array([0.02, 0.002, 0.006, 0.06, 0.2]),
        option=True,
    ),
    "stiffness_ratio": Parameter("", True, lambda c: (1.001, 1e4), lambda c: [2.0, 20.0], option=True, unloading=True),
}
"""Parameters of a fit."""
