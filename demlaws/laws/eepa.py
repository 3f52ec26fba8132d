"""EEPA (Thakur et al. 2014, Morrissey 2013) without adhesion and pull-off, n = 1.5: k1 δ^1.5, back along k2 (δ^1.5 - δp^1.5).

With n = 1 the model is Walton & Braun's of constant k2.
"""

from typing import NamedTuple

from demlaws.core.dispatch import bind, energy, first_loading, unloading_curve
from demlaws.core.fastmath import cbrt, hertz_coefficient, hertz_overlap, kernel, sqrt
from demlaws.core.shear import of_first_loading
from demlaws.core.unloading import Rule, own_rule
from demlaws.laws.definition import (
    Advice,
    Definition,
    Drawing,
    Fitting,
    Numbers,
    Option,
    Parameter,
    Rules,
    no_limits,
    plastic_from_the_start,
)


class EepaShape(NamedTuple):
    """Stiffnesses over Hertz's."""

    softness: float  # k1 over (4/3) E* √R
    stiffness_ratio: float  # k2/k1


class EepaParams(NamedTuple):
    """One contact."""

    hertz_coefficient: float  # (4/3) E* √R [N/m^1.5]
    loading: float  # k1 [N/m^1.5]
    unloading: float  # k2 [N/m^1.5]
    plastic_ratio: float  # δp/δmax = (1 - k1/k2)^(2/3)


@kernel
def _scale(shape, radius, modulus, roughness):
    coefficient = hertz_coefficient(radius, modulus)
    k1 = shape.softness * coefficient
    root = cbrt(1.0 - 1.0 / shape.stiffness_ratio)
    return EepaParams(coefficient, k1, shape.stiffness_ratio * k1, root * root)


@kernel
def _first_loading(shape, p, overlap):
    root = p.loading * sqrt(overlap)
    force = root * overlap
    equivalent = hertz_overlap(p, force)
    return force, 1.5 * root, equivalent, equivalent


@kernel
def _inverse(shape, p, force):
    root = cbrt(force / p.loading)
    return root * root


@kernel
def _energy(shape, p, overlap):
    return 0.4 * p.loading * overlap * overlap * sqrt(overlap)


bind(EepaShape, scale=_scale)
bind(EepaParams, first_loading=_first_loading, inverse=_inverse, energy=_energy)


class Eepa(NamedTuple):
    """Unloads along k2 (δ^1.5 - δp^1.5), δp = (1 - k1/k2)^(2/3) δmax; reloads along the same curve, then first loading."""


@kernel
def _step(rule, shape, p, overlap, state):
    params = unloading_curve(shape, p)[1]
    k2 = params.unloading
    positive = 0.0 if overlap <= 0.0 else overlap
    root = sqrt(positive)
    if overlap >= state[0]:
        force, stiffness, _, _ = first_loading(shape, p, positive)
        maximum, plastic = overlap, params.plastic_ratio * overlap
    else:
        maximum, plastic = state
        elastic = root * positive - sqrt(plastic) * plastic
        force = k2 * (0.0 if elastic <= 0.0 else elastic)
        stiffness = 0.0 if elastic <= 0.0 else 1.5 * k2 * root
    if overlap <= 0.0:
        force, stiffness, maximum, plastic = 0.0, 0.0, 0.0, 0.0
    return force, stiffness, (maximum, plastic)


@kernel
def _recoverable_energy(k2, overlap, plastic):
    """∫ k2 (x^1.5 - δp^1.5) dx from δp to δ, without the difference of δ^2.5 and δp^2.5 where they are close."""
    if overlap <= plastic:
        return 0.0
    a, b = sqrt(overlap), sqrt(plastic)
    # (2/5)(a⁵ - b⁵) - b³ (a² - b²) = (a - b)² (2a³ + 4a²b + 6ab² + 3b³)/5
    return 0.2 * k2 * (a - b) * (a - b) * (a * a * (2.0 * a + 4.0 * b) + b * b * (6.0 * a + 3.0 * b))


@kernel
def _stored_and_dissipated(rule, shape, p, overlap, state):
    if state[0] <= 0.0:
        return 0.0, 0.0
    k2 = unloading_curve(shape, p)[1].unloading
    stored = _recoverable_energy(k2, overlap, state[1]) if overlap > 0.0 else 0.0
    return stored, energy(shape, p, state[0]) - _recoverable_energy(k2, state[0], state[1])


@kernel
def _unloaded(rule, shape, p, force, state):
    root = cbrt(sqrt(state[1]) * state[1] + force / unloading_curve(shape, p)[1].unloading)
    return root * root


@kernel
def _unloading_stiffness(rule, shape, p, overlap, force, stiffness, state):
    return 1.5 * unloading_curve(shape, p)[1].unloading * sqrt(overlap) if overlap >= state[0] and overlap > 0.0 else stiffness


bind(
    Eepa,
    step=_step,
    stored_and_dissipated=_stored_and_dissipated,
    unloaded=_unloaded,
    unloading_stiffness=_unloading_stiffness,
    loading_stiffness=of_first_loading,
)


class EepaNumbers(NamedTuple):
    """k2 in a table, without units."""

    stiffness: float  # k2/(E* √R)
    plastic: float  # δp/δmax
    length_over_roughness: float
    length_over_radius: float


@kernel
def _table_scale(shape, radius, modulus, roughness):
    coefficient = hertz_coefficient(radius, modulus)
    return EepaParams(coefficient, 0.0, shape.stiffness * 0.75 * coefficient, shape.plastic)  # loading is the table's


bind(EepaNumbers, scale=_table_scale)

EEPA = own_rule(
    Rule(
        "eepa",
        Eepa(),
        ("maximum_overlap", "plastic_overlap"),
        "law",
        5,
        "back along k2 (δ^1.5 - δp^1.5), k2 as the law says",
        ("eepa_stiffness", "eepa_plastic"),
        EepaNumbers,
    )
)


_ONLY_OWN = dict.fromkeys(
    ("hertz", "thornton"),
    "its unloading is its own rule 'eepa', or 'elastic'; for Hertz's curve take law 'hertz' or 'thornton-ning'",
)

LAW = Definition(
    name="eepa",
    prepare=lambda contact, stiffness_ratio, softness=1.0: EepaShape(softness, stiffness_ratio),
    equation="P = k1 δ^1.5; back along k2 (δ^1.5 - δp^1.5), δp = (1 - k1/k2)^(2/3) δmax",
    source="Thakur et al. 2014, Granular Matter 16, 383 (10.1007/s10035-014-0506-4); Morrissey 2013; without adhesion, n = 1.5",
    description="powder: plastic from the first load",
    limits=no_limits,
    length="radius",
    unloading=("elastic", "eepa"),
    rules=Rules(
        default="eepa",
        own=(EEPA,),
        numbers=lambda p, length, error: {
            "eepa_stiffness": p.unloading / (0.75 * p.hertz_coefficient),
            "eepa_plastic": p.plastic_ratio,
        },
        refused=_ONLY_OWN,
    ),
    options={
        "stiffness_ratio": Option("", Numbers(1.0, 1e6, True), "k2/k1"),
        "softness": Option("", Numbers(0.0, 1e3), "k1 over Hertz's (4/3) E* √R"),
    },
    fitting=Fitting(
        identifiable=False,
        parameters={
            "softness": Parameter("", True, lambda c: (1e-4, 100.0), lambda c: [0.5, 0.05], option=True),
            "stiffness_ratio": Parameter("", True, lambda c: (1.0, 1e4), lambda c: [2.0, 20.0], option=True, unloading=True),
        },
        free=("softness", "stiffness_ratio"),
    ),
    advice=Advice(suits=plastic_from_the_start),
    drawing=Drawing(colour="#01665e", example={"stiffness_ratio": 3.0}, example_curve={"softness": 4.0}),
)
