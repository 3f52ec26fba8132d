"""Compiled loops over arrays of contacts, for any law and any unloading rule."""

import math

import numpy as np

from demlaws.core import dispatch
from demlaws.core.dispatch import gather, scatter, stored_and_dissipated
from demlaws.core.numba_compat import interleave, loop


@loop
def scale_one(shape, radius, modulus, roughness):
    """Params of one contact: R [m], E* [Pa], σ [m]."""
    return dispatch.scale(shape, radius, modulus, roughness)


@loop
def scale_loop(shape, radius, modulus, roughness, params):
    """Params of each contact, R [m], E* [Pa], σ [m] in arrays, into the arrays of `params`."""
    for i in range(radius.size):
        scatter(params, i, dispatch.scale(shape, radius[i], modulus[i], roughness[i]))


@loop
def batch_loop(rule, params, overlap, state, end, most, force, stiffness):
    """A step of every contact. Returns whether none needs a look: without a history all overlaps [m], with one all forces
    [N] are numbers up to `most`.

    end, most: tuples of one number or of an array with one entry a contact. end: the largest overlap [m] that is answered;
    one beyond it counts as NaN, with which every rule gives the force NaN and leaves the history as it was. A rule without
    a history answers all the same, and a law may give a number for an overlap that is none.
    """
    good = True
    params = dispatch.fix_tables(params)
    # a law alone leaves registers free; with a history and its bound, more than two at a time spill them
    if len(state) == 0:
        interleave(4)
    else:
        interleave(2)
    for i in range(overlap.size):
        p = gather(params, i)
        here = float(overlap[i])
        here = here if (here <= gather(end, i)[0]) | (len(state) == 0) else math.nan
        new_force, new_stiffness, new_state = dispatch.step(rule, p, here, gather(state, i))
        scatter(state, i, new_state)
        force[i] = new_force
        stiffness[i] = new_stiffness
        # last, because LLVM loses the hint where the loop ends in an inlined call
        looked_at = here if len(state) == 0 else new_force
        good &= looked_at <= gather(most, i)[0]
    return good


UNBOUNDED = (math.inf,)
FINITE = (np.finfo(float).max,)


def evaluate_loop(rule, params, overlap, state, force, stiffness):
    """`batch_loop` of a curve that is read at overlaps of any size: whether all forces are finite."""
    return batch_loop(rule, params, overlap, state, UNBOUNDED, FINITE, force, stiffness) and bool(np.isfinite(force).all())


@loop
def inverse_loop(params, force, overlap):
    """Overlap [m] of first loading at each force [N], 0 where that is not positive, into `overlap`."""
    for i in range(force.size):
        overlap[i] = dispatch.inverse(gather(params, i), force[i]) if force[i] > 0.0 else 0.0


@loop
def energy_loop(params, overlap, energy):
    """Work of first loading [J] to each overlap [m], 0 where that is not positive, into `energy`."""
    for i in range(overlap.size):
        energy[i] = dispatch.energy(gather(params, i), overlap[i]) if overlap[i] > 0.0 else 0.0


@loop
def unloaded_loop(rule, params, force, state, overlap):
    """Overlap of each contact at `force`, below its largest overlap so far."""
    for i in range(force.size):
        overlap[i] = dispatch.unloaded(rule, gather(params, i), force[i], gather(state, i))


@loop
def energies_loop(rule, params, overlap, state, stored, dissipated):
    """Energy that each contact can still return, and what it has dissipated since it was made."""
    for i in range(overlap.size):
        stored[i], dissipated[i] = stored_and_dissipated(rule, gather(params, i), float(overlap[i]), gather(state, i))


@loop
def follow_loop(rule, p, overlap, state, history, force, stiffness, stored, dissipated):
    """One contact along a path; `state` (arrays of length 1) goes in as it is and comes out as the path leaves it."""
    banked = 0.0
    for i in range(overlap.size):
        old = gather(state, 0)
        if overlap[i] <= 0.0:
            banked += stored_and_dissipated(rule, p, overlap[i], old)[1]
        force[i], stiffness[i], new = dispatch.step(rule, p, overlap[i], old)
        scatter(state, 0, new)
        scatter(history, i, new)
        energies = stored_and_dissipated(rule, p, overlap[i], new)
        stored[i] = energies[0]
        dissipated[i] = banked + energies[1]
