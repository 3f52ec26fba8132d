"""Tangential stiffness K_t of a contact: K_t/K of an elastic contact times a normal stiffness, of which there are two.

Which one is a choice, a tag type as an unloading rule is. Any law and any rule has both; a rule whose own answer is
cheaper than the general one binds it.
"""

import math
from typing import NamedTuple

import numpy as np

from demlaws.core.dispatch import (
    bind,
    contact_area,
    first_loading,
    gather,
    generic,
    inverse,
    scatter,
    step,
    unloading_curve,
)
from demlaws.core.fastmath import cbrt, sqrt
from demlaws.core.numba_compat import kernel, loop
from demlaws.core.unloading import Elastic, Given, Hertz, Thornton, rule_of

SPRINGS = 11
"""Springs of a contact in the engines by default (`slip`)."""
DEFAULT_LEVELS, MOST_LEVELS = 3, 8
"""Levels of springs (`levels`)."""
LARGEST_SHEAR_RATIO = 4.0 / 3.0
"""Largest K_t/K: 2(1-ν)/(2-ν) at ν = -1."""
EMPTY = 1e-9
"""Of K_t: a level of less stiffness counts as empty; otherwise a rise by rounding would join two levels."""


class ElasticShear(NamedTuple):
    """The stiffness with which the contact would unload now, on whatever branch it is: continuous through a reversal."""


class LoadingShear(NamedTuple):
    """The tangent of first loading at the force that the contact carries now."""


class ShearChoice(NamedTuple):
    """What is known of a choice beside its kernel."""

    name: str
    tag: tuple
    number: int  # in demlaws_table.h
    description: str  # one line


CHOICES = {
    choice.name: choice
    for choice in (
        ShearChoice("elastic", ElasticShear(), 1, "the stiffness with which the contact would unload now"),
        ShearChoice("loading", LoadingShear(), 2, "the tangent of first loading at the force carried now"),
    )
}
"""Name → the choices that any law and rule may take."""
DEFAULT = "elastic"
SLIP = "slip"
"""Name of the choice with partial slip (`core.slip`), beside those of `CHOICES`."""


def _just_below(*kinds):
    below = 1.0 - 2.0**-36
    return lambda rule, shape, p, overlap, force, stiffness, state: step(rule, shape, p, overlap * below, state)[1]


@generic(_just_below)
def unloading_stiffness(rule, shape, p, overlap, force, stiffness, state):
    """Stiffness [N/m] with which a contact would unload from here; the rest is what `step` has just returned for it.

    For a rule without such a function the tangent just below is used.
    """


@generic(lambda *_: lambda rule, shape, p, overlap, force, stiffness, state: at_force(shape, p, force))
def loading_stiffness(rule, shape, p, overlap, force, stiffness, state):
    """Tangent [N/m] of first loading at a force; the arguments are those of `unloading_stiffness`."""


@kernel
def at_force(shape, p, force):
    """Tangent of first loading at `force`."""
    return first_loading(shape, p, inverse(shape, p, force))[1] if force > 0.0 else 0.0


@generic()
def shear_stiffness(choice, rule, shape, p, overlap, force, stiffness, state):
    """The normal stiffness [N/m] used to compute K_t; not negative."""


@kernel
def _elastic(choice, rule, shape, p, overlap, force, stiffness, state):
    return max(unloading_stiffness(rule, shape, p, overlap, force, stiffness, state), 0.0)


@kernel
def _loading(choice, rule, shape, p, overlap, force, stiffness, state):
    return max(loading_stiffness(rule, shape, p, overlap, force, stiffness, state), 0.0)


bind(ElasticShear, shear_stiffness=_elastic)
bind(LoadingShear, shear_stiffness=_loading)


# --- the rules' own


@kernel
def _same(rule, shape, p, overlap, force, stiffness, state):
    return stiffness


@kernel
def _by_recoverable(coefficient, overlap, force, plastic):
    """K = 1.5 P/(δ - δp) of Hertz's curve P = coefficient (δ - δp)^1.5; from P alone where rounding leaves little of δ - δp."""
    elastic = overlap - plastic
    if elastic > 1e-9 * overlap:  # as in demlaws_table.h
        return 1.5 * force / elastic
    return 1.5 * cbrt(coefficient * coefficient * force)


@kernel
def of_hertz(rule, shape, p, overlap, force, stiffness, state):
    """Shear stiffness's normal stiffness [N/m] by Hertz: that of the unloading curve where first loading ends, else the
    tangent."""
    if overlap >= state[0] and overlap > 0.0:
        return _by_recoverable(p.hertz_coefficient, overlap, force, state[1])
    return stiffness


@kernel
def of_thornton(rule, shape, p, overlap, force, stiffness, state):
    """The same with the larger radius of the state."""
    if overlap >= state[0] and overlap > 0.0:
        return _by_recoverable(p.hertz_coefficient * sqrt(state[2]), overlap, force, state[1])
    return stiffness


@kernel
def _of_curve(rule, shape, p, overlap, force, stiffness, state):
    elastic = overlap - state[1]
    curve_shape, curve, _ = unloading_curve(shape, p)
    return first_loading(curve_shape, curve, elastic)[1] if overlap >= state[0] and elastic > 0.0 else stiffness


@kernel
def of_first_loading(rule, shape, p, overlap, force, stiffness, state):
    """The tangent of first loading [N/m] at the same force [N]."""
    return stiffness if overlap >= state[0] else at_force(shape, p, force)


bind(Elastic, unloading_stiffness=_same, loading_stiffness=_same)
bind(Hertz, unloading_stiffness=of_hertz, loading_stiffness=of_first_loading)
bind(Thornton, unloading_stiffness=of_thornton, loading_stiffness=of_first_loading)
bind(Given, unloading_stiffness=_of_curve, loading_stiffness=of_first_loading)


@loop
def shear_loop(choice, rule, shape, p, overlap, state):
    """The normal stiffness used to compute K_t along a path of one contact; `state` is moved on as in `follow_loop`."""
    shear = np.empty(overlap.size)
    for i in range(overlap.size):
        force, stiffness, new = step(rule, shape, p, overlap[i], gather(state, 0))
        scatter(state, 0, new)
        shear[i] = shear_stiffness(choice, rule, shape, p, overlap[i], force, stiffness, new)
    return shear


# --- the pressure of the contact


@kernel
def smooth_radius(p, modulus):
    """Radius [m] of the contact's Hertz curve: R, or that of a blunter bulk (`bulk_radius`), to which a²/R belongs."""
    root = 0.75 * p.hertz_coefficient / modulus
    return root * root


def _pressure(*kinds):
    rule = rule_of(kinds[0].instance_class)
    remembers = bool(rule.state) and rule.state[0] == "maximum_overlap"
    if not rule.state:
        return lambda rule, shape, p, modulus, overlap, force, stiffness, state: (
            over_area(force, smooth_radius(p, modulus) * first_loading(shape, p, overlap)[3]) if force > 0.0 else 0.0
        )

    def pressure(rule, shape, p, modulus, overlap, force, stiffness, state):
        if not force > 0.0:
            return 0.0
        if remembers and overlap >= state[0]:
            area = contact_area(rule, shape, p, overlap, first_loading(shape, p, overlap)[3])
            return over_area(force, smooth_radius(p, modulus) * area)
        a = 0.5 * max(unloading_stiffness(rule, shape, p, overlap, force, stiffness, state), 0.0) / modulus
        return over_area(force, a * a)

    return pressure


@generic(_pressure)
def mean_pressure(rule, shape, p, modulus, overlap, force, stiffness, state):
    """Mean pressure P/(π a²) [Pa] of a contact; force, stiffness and state are those that `step` has just returned.

    a² is that of first loading, for a rule that keeps a radius the one from which it unloads; where the contact unloads,
    2 E* a is the stiffness of unloading. Twin: demlaws/cpp/demlaws_contact.h.
    """


@kernel
def friction_at(mu0, c1, c2, pressure):
    """μ0 + c1/(1 + c2 p) of a contact at the mean pressure p [Pa]."""
    return mu0 + c1 / (1.0 + c2 * pressure)


@kernel
def over_area(force, square):
    """P/(π a²) [Pa]; 0 without an area."""
    return force / (math.pi * square) if square > 0.0 else 0.0


@loop
def pressure_loop(rule, shape, p, modulus, overlap, state, pressure):
    """Mean pressure [Pa] along a path of one contact: `pressure` is written, `state` is moved on as in `follow_loop`."""
    for n in range(overlap.size):
        force, tangent, new = step(rule, shape, p, overlap[n], gather(state, 0))
        scatter(state, 0, new)
        pressure[n] = mean_pressure(rule, shape, p, modulus, overlap[n], force, tangent, new)
