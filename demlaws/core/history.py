"""The overlaps of one contact under a history of forces, for fits: laws share the loops of the rules along Hertz's curve."""

from typing import NamedTuple

import numpy as np

from demlaws.core.dispatch import bind, first_loading, gather, inverse, step, unloaded
from demlaws.core.numba_compat import kernel, loop


class LoadedParams(NamedTuple):
    """In place of a law's Params, for rules that unload along Hertz's curve: one contact under the largest force so far."""

    hertz_coefficient: float  # [N/m^1.5]
    overlap: float  # [m]
    force: float  # [N]
    stiffness: float  # [N/m]
    equivalent: float  # δ_H of the force [m]
    area: float  # a²/R [m]


@kernel
def _loaded_first_loading(shape, p, overlap):
    return p.force, p.stiffness, p.equivalent, p.area


@kernel
def _loaded_inverse(shape, p, force):
    return p.overlap


bind(LoadedParams, first_loading=_loaded_first_loading, inverse=_loaded_inverse)


@loop
def loading_loop(shape, p, force, overlap, stiffness, equivalent, area):
    """First loading of one contact at each `force` > 0 [N]: all else that `LoadedParams` has."""
    for i in range(force.size):
        overlap[i] = inverse(shape, p, force[i])
        # below a seating load the curve continues to overlaps under 0, where `first_loading` is not defined
        _, stiffness[i], equivalent[i], area[i] = first_loading(shape, p, max(overlap[i], 1e-300))


@loop
def history_loop(rule, shape, params, force, initial_state, overlap, stiffness):
    """Overlap [m] and tangent stiffness [N/m] at each `force` > 0 [N] that one contact carries in turn.

    Below the largest force so far the contact unloads or reloads. params: of the contact, or `LoadedParams` with an entry for
    each force.
    """
    peak, state = 0.0, initial_state
    for i in range(force.size):
        p = gather(params, i)
        loads = force[i] >= peak
        if loads:
            peak = force[i]
            overlap[i] = inverse(shape, p, peak)
        else:
            overlap[i] = unloaded(rule, shape, p, force[i], state)
        # below a seating load the curve continues to overlaps under 0, where `step` sees no contact
        _, stiffness[i], new = step(rule, shape, p, max(overlap[i], 1e-300), state)
        state = new if loads else state


def history(rule, shape, params, force):
    """Overlap [m] and tangent stiffness [N/m] at each `force` > 0 [N] that a contact without history carries in turn.

    Laws share the loops of the rules along Hertz's curve, so that a law compiles one loop whatever its rules.
    """
    overlap, stiffness, equivalent, area = np.empty((4, force.size))
    if rule.curve in ("own", "hertz"):
        largest = force if rule.curve == "own" else np.maximum.accumulate(force)
        loading_loop(shape, params, largest, overlap, stiffness, equivalent, area)
        if rule.curve == "own":
            return overlap, stiffness
        params = LoadedParams(params.hertz_coefficient, overlap, largest, stiffness, equivalent, area)
        overlap, stiffness = np.empty((2, force.size))
    history_loop(rule.tag, shape, params, force, (0.0,) * len(rule.state), overlap, stiffness)
    return overlap, stiffness
