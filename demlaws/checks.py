"""Checks of what users give: one clear error that names the value, the unit and the range."""

import math

from demlaws.errors import DemlawsError


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
