"""Compiled loops over arrays of contacts, for any law and any unloading rule, and the Params that they read.

Params of one contact are a (nested) tuple of floats. Those of an array of contacts are the same tuple with an array in place of
each float, or one float where all contacts have the same.
"""

import math

import numpy as np

from demlaws.core import dispatch
from demlaws.core.dispatch import gather, map_leaves, refuse_other_values, scatter, stored_and_dissipated, with_pointers
from demlaws.core.numba_compat import kernel, loop
from demlaws.core.unloading import Elastic, JoinedParams, JoinedShape
from demlaws.errors import DemlawsError


@loop
def scale_contact(shape, radius, modulus, roughness):
    """Params of one contact: R [m], E* [Pa], σ [m]."""
    return dispatch.scale(shape, radius, modulus, roughness)


@loop
def scale_loop(shape, radius, modulus, roughness, params):
    """Params of each contact, R [m], E* [Pa], σ [m] in arrays, into the arrays of `params`."""
    for i in range(radius.size):
        scatter(params, i, dispatch.scale(shape, radius[i], modulus[i], roughness[i]))


@loop
def batch_loop(rule, shape, params, overlap, state, largest_overlap, expected_maximum, force, stiffness):
    """A step of every contact. Returns True if all overlaps [m], of a rule with a history all forces [N], are numbers up to
    `expected_maximum`.

    An overlap beyond `largest_overlap` [m] counts as NaN, with which every rule gives the force NaN and leaves the history as
    it was. A rule without a history answers all the same, and a law may give a number for NaN.
    """
    good = True
    shape = with_pointers(shape)
    for i in range(overlap.size):
        p = gather(params, i)
        here = float(overlap[i])
        here = here if (here <= largest_overlap) | (len(state) == 0) else math.nan
        new_force, new_stiffness, new_state = dispatch.step(rule, shape, p, here, gather(state, i))
        scatter(state, i, new_state)
        force[i] = new_force
        stiffness[i] = new_stiffness
        good &= (here if len(state) == 0 else new_force) <= expected_maximum
    return good


UNBOUNDED = math.inf
FINITE = float(np.finfo(float).max)


@loop
def inverse_loop(shape, params, force):
    """Overlap [m] of first loading at each force [N], 0 where that is not positive."""
    overlap = np.empty(force.size)
    for i in range(force.size):
        overlap[i] = dispatch.inverse(shape, gather(params, i), force[i]) if force[i] > 0.0 else 0.0
    return overlap


@loop
def energy_loop(shape, params, overlap):
    """Work of first loading [J] to each overlap [m], 0 where that is not positive."""
    energy = np.empty(overlap.size)
    for i in range(overlap.size):
        energy[i] = dispatch.energy(shape, gather(params, i), overlap[i]) if overlap[i] > 0.0 else 0.0
    return energy


@loop
def unloaded_loop(rule, shape, params, force, state):
    """Overlap [m] of each contact at `force` [N], below its largest overlap so far."""
    overlap = np.empty(force.size)
    for i in range(force.size):
        overlap[i] = dispatch.unloaded(rule, shape, gather(params, i), force[i], gather(state, i))
    return overlap


@loop
def energies_loop(rule, shape, params, overlap, state):
    """Energy [J] that each contact can still return, and what it has dissipated since it was made."""
    stored, dissipated = np.empty(overlap.size), np.empty(overlap.size)
    for i in range(overlap.size):
        stored[i], dissipated[i] = stored_and_dissipated(rule, shape, gather(params, i), float(overlap[i]), gather(state, i))
    return stored, dissipated


@loop
def follow_loop(rule, shape, p, overlap, state, history, force, stiffness, stored, dissipated):
    """One contact along a path; `state` (arrays of length 1) goes in as it is and comes out as the path leaves it.

    Returns what the contact has dissipated [J] before it opened, over all its openings.
    """
    banked = 0.0
    for i in range(overlap.size):
        old = gather(state, 0)
        if overlap[i] <= 0.0:
            banked += stored_and_dissipated(rule, shape, p, overlap[i], old)[1]
        force[i], stiffness[i], new = dispatch.step(rule, shape, p, overlap[i], old)
        scatter(state, 0, new)
        scatter(history, i, new)
        energies = stored_and_dissipated(rule, shape, p, overlap[i], new)
        stored[i] = energies[0]
        dissipated[i] = banked + energies[1]
    return banked


# --- params

SMOOTHEST = 1e-40
"""σ/R below which roughness counts as this: no effect left in double precision, and no division by zero at σ = 0."""


@kernel
def clamped_roughness(roughness, radius):
    """Roughness [m] of one contact as laws take it: never below SMOOTHEST times the radius."""
    return max(roughness, SMOOTHEST * radius)


def equal_params(params, other):
    """Whether two nested tuples have the same form and equal numbers and arrays."""
    if isinstance(params, tuple):
        same = type(params) is type(other) and len(params) == len(other)
        return same and all(equal_params(a, b) for a, b in zip(params, other, strict=True))
    return bool(np.array_equal(params, other))


def loading_part(values):
    """The part of a law's Shape or Params that belongs to first loading: all of it, unless an unloading curve is joined."""
    return values.loading if isinstance(values, JoinedShape | JoinedParams) else values


def force_loop(shape, params, overlap):
    """Force [N] and stiffness [N/m] of first loading at any overlaps [m]."""
    force, stiffness = np.empty(overlap.size), np.empty(overlap.size)
    shape, params = loading_part(shape), loading_part(params)
    batch_loop(Elastic(), shape, params, overlap, (), UNBOUNDED, FINITE, force, stiffness)
    return force, stiffness


def clamped_roughnesses(contact):
    """The same for a contact or an array of contacts."""
    return np.maximum(contact.sigma_or_zero, SMOOTHEST * np.asarray(contact.radius))


def bind_params(shape, contact):
    """Params of a contact, or of an array of contacts; DemlawsError where the law's `scale` makes other values than floats."""
    size, roughness = contact.size, clamped_roughnesses(contact)
    if size == 0:
        raise DemlawsError("the contact's arrays are empty: give at least one contact")
    # copies: loops are compiled once for arrays that may be written to, once more for others
    columns = [np.array(np.broadcast_to(v, size or 1), float) for v in (contact.radius, contact.modulus, roughness)]
    first = scale_contact(shape, *(float(column[0]) for column in columns))
    refuse_other_values(first)
    if size is None:
        return first
    params = map_leaves(lambda _: np.empty(size), first)
    scale_loop(shape, *columns, params)
    # one float where all contacts have the same: loops then read one array less
    return map_leaves(lambda values: float(values[0]) if np.all(values == values[0]) else values, params)


def params_at(params, index):
    """Params of contact `index` of an array of contacts (of a single one: its own)."""
    return map_leaves(lambda v: float(v[index]) if isinstance(v, np.ndarray) else v, params)
