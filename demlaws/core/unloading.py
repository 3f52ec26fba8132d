"""Unloading rules. A rule joins any law of first loading for which it is passive (never returns more work than it took).

A law may bring rules of its own (`own_rule`, `Rules.own`), which no other law is offered.

A rule is a `Rule` record, whose tag type stands for it in compiled code, and pure compiled functions over one contact bound to
that type. The state is a tuple of floats; all zeros is a contact before first loading, as it is again after separation.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

from numba.extending import overload

from demlaws.core.dispatch import (
    bind,
    contact_area,
    energy,
    first_loading,
    inverse,
    inverse_near,
    scale,
    unloading_curve,
    with_pointers,
    with_pointers_to_invert,
)
from demlaws.core.fastmath import cbrt, sqrt
from demlaws.core.numba_compat import INLINED, kernel


class Elastic(NamedTuple):
    """Unloads along the loading curve; no history."""


class Hertz(NamedTuple):
    """Unloads along the Hertz curve of the original radius through (δmax, Pmax): P = (4/3) E* √R (δ - δp)^1.5.

    δp = δmax - δ_H(Pmax) is the plastic overlap. Reloading follows the same curve to (δmax, Pmax), then first loading.
    For 0 < δ < δp the bodies overlap and carry no force. Source: Tolomeo & McDowell after Altuhafi et al. 2023.
    """


class Thornton(NamedTuple):
    """As `Hertz`, with the larger radius R_p = (4 E*/(3 Pmax)) a_max³ after yielding (Thornton 1997).

    If the bulk has not yielded, a_max is the Hertz radius, R_p = R, and the rule is `Hertz`.
    """


class Given(NamedTuple):
    """Unloads along a given elastic curve U, shifted through (δmax, Pmax): P = U(δ - δp), δp = δmax - U⁻¹(Pmax).

    U is the first loading of another law, or a table. Reloading follows the same curve to (δmax, Pmax), then first
    loading; for 0 < δ < δp the bodies overlap and carry no force. `Hertz` is U = Hertz. Along first loading
    dδp/dδ = 1 - K(P)/K_U(P), so the rule is passive exactly where K(P) ≤ K_U(P) at every load. [our derivation]
    """


GIVEN = "table"
"""Name of the one rule that needs a curve beside the law."""


class Rule(NamedTuple):
    """Properties of an unloading rule."""

    name: str
    tag: tuple  # instance of the type that its kernels are bound to
    state: tuple  # names of what a contact remembers, in the order of the state tuple
    curve: str  # along which it unloads: "own", that of first loading, so that nothing is lost; "hertz"; "given", by the user;
    # "law": by kernels of the law, which must return no work on any path
    number: int | None  # in demlaws_table.h; None: C++ does not have it
    description: str  # one line
    keys: tuple = ()  # of a law's own rule: names of the numbers that a table holds for it; `Rules.numbers`
    shape: Callable | None = None  # those numbers, length over σ, length over R → Shape that the rule reads in a table
    springs: str | None = None  # curve of the springs of partial slip: "own", "hertz", "given" as in `curve`, or "thornton":
    # Hertz's with the radius ratio state[2]; all but "own" from the plastic overlap state[1]. None: an engine has no springs


_OVERLAPS = ("maximum_overlap", "plastic_overlap")
RULES = {
    rule.name: rule
    for rule in (
        Rule("elastic", Elastic(), (), "own", 0, "unloads along the curve of first loading", springs="own"),
        Rule("hertz", Hertz(), _OVERLAPS, "hertz", 1, "unloads along Hertz's curve of the contact's radius", springs="hertz"),
        Rule(
            "thornton",
            Thornton(),
            (*_OVERLAPS, "radius_ratio"),
            "hertz",
            2,
            "as hertz, with the larger radius of curvature after yielding",
            springs="thornton",
        ),
        Rule(GIVEN, Given(), _OVERLAPS, "given", 3, "unloads along the curve of another law or of a table", springs="given"),
    )
}
"""Name → the rules that any law may take."""


_OF_TAG = {type(rule.tag): rule for rule in RULES.values()}
"""Type of tag → rule, those of laws included: a file that runs twice makes two types of one name."""
SPRINGS = {None: 0, "hertz": 2, "thornton": 3}
"""Springs that a law's own rule may have → numbers of the state that they are computed from, at least."""
LARGEST_STATE = 3
"""Numbers that a contact may remember: what every engine keeps room for."""


def own_rule(rule: Rule) -> Rule:
    """Make a law's own rule known to compiled code, for its `Rules.own`.

    Its kernels `step`, `unloaded` and `stored_and_dissipated` are bound to its tag. They have the law's Shape and Params from
    `unloading_curve(shape, p)`, so that they serve a table of the law, too, and the force from `first_loading`. A rule with a
    `number` has `keys` and a `shape`: of a table `unloading_curve` gives the Shape that `shape` makes of the file's numbers,
    and its Params.
    TypeError: the name of a general rule, a state larger than engines keep, or springs that it cannot have.
    """
    size = len(rule.state)
    springs = rule.springs in SPRINGS and size >= SPRINGS[rule.springs]
    if rule.name in RULES or rule.curve != "law" or size > LARGEST_STATE or not springs:
        raise TypeError(
            f"unloading rule {rule.name!r} with {size} numbers of state: the name must not be one of {', '.join(RULES)}, "
            f"the curve 'law', the state at most {LARGEST_STATE} numbers, the springs one of {SPRINGS} (numbers needed)"
        )
    _OF_TAG[type(rule.tag)] = rule
    return rule


def rule_of(tag_type):
    """The rule whose tag is of this type."""
    return _OF_TAG[tag_type]


def rule_of_smooth_contact(rule):
    """The rule for a smooth contact in YADE, which Hertz's law computes: elastic if the rule belongs to another law."""
    return Elastic() if rule_of(type(rule)).curve == "law" else rule


@overload(rule_of_smooth_contact, jit_options=INLINED)
def _rule_of_smooth_contact(rule):
    if rule_of(rule.instance_class).curve == "law":
        return lambda rule: Elastic()
    return lambda rule: rule


class JoinedShape(NamedTuple):
    """Common properties of the contacts of a law that is given an unloading curve."""

    loading: tuple
    unloading: tuple
    radius: float  # R, E*, σ of the curve's contact over those of the law's
    modulus: float
    roughness: float


class JoinedParams(NamedTuple):
    """One contact: to all but `Given` the law of first loading."""

    hertz_coefficient: float  # of the loading [N/m^1.5]
    loading: tuple
    unloading: tuple
    equivalent_ratio: float  # δ_H of a force on the curve's contact over that on the law's


@kernel
def _joined_scale(shape, radius, modulus, roughness):
    loading = scale(shape.loading, radius, modulus, roughness)
    unloading = scale(shape.unloading, radius * shape.radius, modulus * shape.modulus, roughness * shape.roughness)
    root = cbrt(loading.hertz_coefficient / unloading.hertz_coefficient)
    return JoinedParams(loading.hertz_coefficient, loading, unloading, root * root)


@kernel
def first_loading_within(shape, p, overlap):
    """`first_loading` of a law that is the field `loading` of Shape and Params."""
    return first_loading(shape.loading, p.loading, overlap)


@kernel
def inverse_within(shape, p, force):
    """`inverse` likewise."""
    return inverse(shape.loading, p.loading, force)


@kernel
def energy_within(shape, p, overlap):
    """`energy` likewise."""
    return energy(shape.loading, p.loading, overlap)


@kernel
def _joined_unloading_curve(shape, p):
    return shape.unloading, p.unloading, p.equivalent_ratio


@kernel
def _joined_with_pointers(shape):
    parts = with_pointers(shape.loading), with_pointers_to_invert(shape.unloading)
    return JoinedShape(*parts, shape.radius, shape.modulus, shape.roughness)


bind(JoinedShape, scale=_joined_scale, with_pointers=_joined_with_pointers)
bind(
    JoinedParams,
    first_loading=first_loading_within,
    inverse=inverse_within,
    energy=energy_within,
    unloading_curve=_joined_unloading_curve,
)


@kernel
def _elastic_step(rule, shape, p, overlap, state):
    force, stiffness, _, _ = first_loading(shape, p, 0.0 if overlap <= 0.0 else overlap)
    if overlap <= 0.0:
        force, stiffness = 0.0, 0.0
    return force, stiffness, state


@kernel
def _elastic_stored_and_dissipated(rule, shape, p, overlap, state):
    return (energy(shape, p, overlap) if overlap > 0.0 else 0.0), 0.0


@kernel
def _elastic_unloaded(rule, shape, p, force, state):
    return inverse(shape, p, force) if force > 0.0 else 0.0


@kernel
def _hertz_step(rule, shape, p, overlap, state):
    # Flat rather than nested conditions, and unloading always: LLVM then vectorises the loop around this, on AVX2, too.
    positive = 0.0 if overlap <= 0.0 else overlap
    maximum, plastic = state
    elastic = positive - plastic
    elastic = 0.0 if elastic <= 0.0 else elastic
    root = p.hertz_coefficient * sqrt(elastic)
    force, stiffness = root * elastic, 1.5 * root
    if overlap >= maximum:
        force, stiffness, hertz_overlap, _ = first_loading(shape, p, positive)
        maximum, plastic = overlap, overlap - hertz_overlap
    if overlap <= 0.0:
        force, stiffness, maximum, plastic = 0.0, 0.0, 0.0, 0.0
    return force, stiffness, (maximum, plastic)


@kernel
def _hertz_energy(coefficient, elastic):
    return 0.4 * coefficient * elastic * elastic * sqrt(elastic) if elastic > 0.0 else 0.0


@kernel
def _balance(shape, p, coefficient, overlap, state):
    """Stored and dissipated work where unloading follows coefficient (δ - δp)^1.5.

    δp is negative at small overlaps of a table file whose curve starts from a force (`below_first_row: straight`): what the
    unloading curve holds below δ = 0 is never returned, so it is not stored.
    """
    if state[0] <= 0.0:
        return 0.0, 0.0
    loss = _hertz_energy(coefficient, -state[1])
    stored = _hertz_energy(coefficient, overlap - state[1]) - loss if overlap > 0.0 else 0.0
    return max(stored, 0.0), energy(shape, p, state[0]) - (_hertz_energy(coefficient, state[0] - state[1]) - loss)


@kernel
def _hertz_stored_and_dissipated(rule, shape, p, overlap, state):
    return _balance(shape, p, p.hertz_coefficient, overlap, state)


@kernel
def _hertz_unloaded(rule, shape, p, force, state):
    root = cbrt(force / p.hertz_coefficient)
    return state[1] + root * root


@kernel
def thornton_step(rule, shape, p, overlap, state):
    """Force [N], stiffness [N/m] and new state on Hertz's curve of the larger radius that loading left."""
    positive = 0.0 if overlap <= 0.0 else overlap
    maximum, plastic, ratio = state
    elastic = positive - plastic
    elastic = 0.0 if elastic <= 0.0 else elastic
    root = p.hertz_coefficient * sqrt(ratio * elastic)
    force, stiffness = root * elastic, 1.5 * root
    if overlap >= maximum:
        force, stiffness, hertz_overlap, area = first_loading(shape, p, positive)
        area = contact_area(rule, shape, p, positive, area)
        # R_p/R = (a²/R / δ_H)^1.5 and δmax - δp = a²/R_p
        growth = area / hertz_overlap
        ratio = growth * sqrt(growth)
        maximum, plastic = overlap, overlap - area / ratio
    if overlap <= 0.0:
        force, stiffness, maximum, plastic, ratio = 0.0, 0.0, 0.0, 0.0, 0.0
    return force, stiffness, (maximum, plastic, ratio)


@kernel
def thornton_stored_and_dissipated(rule, shape, p, overlap, state):
    """Stored and dissipated work [J] at an overlap [m], with the larger radius of the state."""
    return _balance(shape, p, p.hertz_coefficient * sqrt(state[2]), overlap, state)


@kernel
def thornton_unloaded(rule, shape, p, force, state):
    """Overlap [m] at a force [N] on the unloading curve of the state."""
    root = cbrt(force / (p.hertz_coefficient * sqrt(state[2])))
    return state[1] + root * root


@kernel
def _given_step(rule, shape, p, overlap, state):
    curve_shape, curve, ratio = unloading_curve(shape, p)
    positive = 0.0 if overlap <= 0.0 else overlap
    loads = overlap >= state[0]
    if loads:
        force, stiffness, equivalent, _ = first_loading(shape, p, positive)
        sought = equivalent * ratio
        elastic = inverse_near(curve_shape, curve, force, sought)
        force = force if elastic == elastic else math.nan  # beyond the curve's end
        maximum, plastic = overlap, 0.0
    else:
        force, stiffness, sought = 0.0, 0.0, 0.0
        maximum, plastic = state
        elastic = positive - plastic
        elastic = 0.0 if elastic <= 0.0 else elastic
    # one reading of the curve for both: where the contact is, or the last step of the search for Pmax on it
    back, tangent, equivalent, _ = first_loading(curve_shape, curve, elastic)
    if loads:
        # in δ_H, which is straighter than the force: dδ_H/dδ = K δ_H/(1.5 P)
        rise = tangent * equivalent
        estimate = elastic - (1.5 * back * (equivalent - sought) / rise if elastic > 0.0 and rise > 0.0 else 0.0)
        plastic = overlap - (0.0 if estimate <= 0.0 else estimate)
    else:
        force = 0.0 if elastic <= 0.0 else back
        force = force if overlap == overlap else math.nan  # a law may give a number for NaN
        stiffness = 0.0 if elastic <= 0.0 else tangent
    if overlap <= 0.0:
        force, stiffness, maximum, plastic = 0.0, 0.0, 0.0, 0.0
    return force, stiffness, (maximum, plastic)


@kernel
def _given_stored_and_dissipated(rule, shape, p, overlap, state):
    curve_shape, curve, _ = unloading_curve(shape, p)
    if state[0] <= 0.0:
        return 0.0, 0.0
    # as in `_balance`: the energy of the curve below δ = 0 is never returned
    loss = energy(curve_shape, curve, -state[1]) if state[1] < 0.0 else 0.0
    elastic = overlap - state[1]
    stored = energy(curve_shape, curve, elastic) - loss if overlap > 0.0 and elastic > 0.0 else 0.0
    whole = state[0] - state[1]
    whole_energy = energy(curve_shape, curve, whole) if whole > 0.0 else 0.0
    return max(stored, 0.0), energy(shape, p, state[0]) - (whole_energy - loss)


@kernel
def _given_unloaded(rule, shape, p, force, state):
    curve_shape, curve, _ = unloading_curve(shape, p)
    return state[1] + (inverse(curve_shape, curve, force) if force > 0.0 else 0.0)


bind(
    Elastic,
    step=_elastic_step,
    stored_and_dissipated=_elastic_stored_and_dissipated,
    unloaded=_elastic_unloaded,
)
bind(Hertz, step=_hertz_step, stored_and_dissipated=_hertz_stored_and_dissipated, unloaded=_hertz_unloaded)
bind(
    Thornton,
    step=thornton_step,
    stored_and_dissipated=thornton_stored_and_dissipated,
    unloaded=thornton_unloaded,
)
bind(
    Given,
    step=_given_step,
    stored_and_dissipated=_given_stored_and_dissipated,
    unloaded=_given_unloaded,
)
