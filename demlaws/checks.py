"""Checks of what users give: one clear error that names the value, the unit and the range."""

import math

import numpy as np

from demlaws.errors import DemlawsError

SMALL_OVERLAP = 0.1
"""Overlap over effective radius up to which contact laws hold: all take the bodies for half-spaces. One warning beyond it."""
LARGEST_OVERLAP = 1.0
"""Overlap over effective radius beyond which no law answers."""


def large_overlap(overlap, radius, count=1, total=1):
    """Text about overlaps beyond SMALL_OVERLAP of the radius, for Python and engines alike: largest one [m], its R [m]."""
    those = f" ({count} of {total} contacts are beyond {SMALL_OVERLAP:g} R)" if total > 1 else ""
    return (
        f"overlap {overlap:g} m is {overlap / radius:.3g} of the effective radius R = {radius:g} m{those}: contact laws hold "
        f"for overlaps up to {SMALL_OVERLAP:g} R; check units, loads and the step"
    )


def check_overlaps(overlap, radius):
    """None, or the text for a warning where some overlap [m] is beyond SMALL_OVERLAP of its radius [m].

    Raises DemlawsError where one is beyond LARGEST_OVERLAP of it. Both may be arrays, which broadcast.
    """
    if np.size(overlap) == 0:
        return None
    ratio = np.asarray(overlap) / np.asarray(radius)
    where = int(np.argmax(ratio))
    worst = float(ratio.flat[where])
    if not worst > SMALL_OVERLAP * (1.0 + 1e-9):
        return None
    value = float(np.broadcast_to(overlap, ratio.shape).flat[where])
    if worst > LARGEST_OVERLAP:
        raise DemlawsError(
            f"overlap {value:g} m is {worst:.3g} times the effective radius R = {value / worst:g} m: contact laws hold for "
            f"overlaps up to {SMALL_OVERLAP:g} R, beyond R there is no answer; check units, loads and the step"
        )
    return large_overlap(value, value / worst, int(np.sum(ratio > SMALL_OVERLAP)), ratio.size)


def number(value, name, unit="", low=0.0, high=math.inf, allow_low=False):
    """`value` as a float above `low` (or from it) and up to `high`, or an error that names it."""
    try:
        result = float(value)
    except (TypeError, ValueError):
        raise DemlawsError(f"{name} must be one number, got {value!r}") from None
    if math.isfinite(result) and (low < result or (allow_low and low == result)) and result <= high:
        return result
    end = "" if high == math.inf else f" and at most {high:g}"
    raise DemlawsError(
        f"{name} = {result:g} {unit}".rstrip() + f": must be {'at least' if allow_low else 'above'} {low:g}{end}"
    )
