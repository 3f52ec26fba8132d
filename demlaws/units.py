"""Checks of user input: one error that names the value, the unit and the range."""

import math
import re

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


def too_large_overlap(overlap, radius):
    """Text about an overlap [m] beyond LARGEST_OVERLAP of its radius [m], for Python and engines alike."""
    return (
        f"overlap {overlap:g} m is {overlap / radius:.3g} times the effective radius R = {radius:g} m: contact laws hold for "
        f"overlaps up to {SMALL_OVERLAP:g} R, beyond R there is no answer; check units, loads and the step"
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
        raise DemlawsError(too_large_overlap(value, value / worst))
    return large_overlap(value, value / worst, int(np.sum(ratio > SMALL_OVERLAP)), ratio.size)


UNITS = {
    "m": {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "inch": 0.0254, "um": 1e-6, "nm": 1e-9, "pm": 1e-12},
    "Pa": {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9, "N/mm²": 1e6, "N/mm2": 1e6},
    "N": {"N": 1.0, "mN": 1e-3, "uN": 1e-6, "nN": 1e-9, "kN": 1e3, "MN": 1e6},
    "m/s": {"m/s": 1.0, "mm/s": 1e-3, "um/s": 1e-6},
    "kg": {"kg": 1.0, "g": 1e-3, "mg": 1e-6, "t": 1e3},
    "kg/m³": {"kg/m³": 1.0, "kg/m3": 1.0, "g/cm³": 1e3, "g/cm3": 1e3},
    "m/N": {"m/N": 1.0, "mm/N": 1e-3, "um/N": 1e-6, "nm/N": 1e-9, "mm/kN": 1e-6, "um/kN": 1e-9},
    "rad": {"rad": 1.0, "deg": math.pi / 180.0, "°": math.pi / 180.0},
}
"""SI unit → spellings that are read in text beside a plain number, and what each is in that unit."""
_QUANTITY = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?|[-+]?(?:inf|nan))\s*(\S*)\s*")


def quantity(text, name, unit=""):
    """A number in the SI unit `unit` from text such as "3mm", "2.4 µm", "60GPa" or "6e10". Raises DemlawsError."""
    match = _QUANTITY.fullmatch(text)
    factors = UNITS.get(unit, {})
    symbol = match[2].replace("µ", "u").replace("μ", "u") if match else ""
    if match and (not symbol or symbol in factors):
        return float(match[1]) * factors.get(symbol, 1.0)
    units = f" in {unit}, or with one of the units {', '.join(factors)}" if factors else f" in {unit}" if unit else ""
    raise DemlawsError(f"{name} must be a number{units}, got {text!r:.60}")


def unmasked(value):
    """A masked array as a plain one with NaN where it is masked; anything else as it is. numpy itself drops the mask."""
    if not isinstance(value, np.ma.MaskedArray) or value.dtype.kind not in "fiu":
        return value
    return (value if value.dtype.kind == "f" else value.astype(float)).filled(math.nan)


def real(value, name, unit="", array=False):
    """A number (or an array of them) as float64: numbers, or text as `quantity` reads it; anything else is refused."""
    if isinstance(value, str):
        return np.float64(quantity(value, name, unit))
    try:
        if array and isinstance(value, (list, tuple)):
            value = [quantity(v, name, unit) if isinstance(v, str) else v for v in value]
        result = np.asarray(unmasked(value))
        if result.dtype.kind not in "fiu":  # None, text, complex numbers, dates, truth values
            raise TypeError
        result = result.astype(float)
    except (TypeError, ValueError, OverflowError):
        kind = "a number or an array" if array else "a number"
        raise DemlawsError(f"{name} must be {kind}{f' in {unit}' if unit else ''}, got {value!r:.60}") from None
    if result.ndim > (1 if array else 0):
        kind = "a number or a 1-D array" if array else "one number"
        raise DemlawsError(f"{name} must be {kind}, got shape {result.shape}")
    return result


def number(value, name, unit="", low=0.0, high=math.inf, allow_low=False):
    """`value` (a number, or text as `quantity` reads it) as a float above `low` (or from it) and up to `high`, or an error
    that names it."""
    result = float(real(value, name, unit))
    if math.isfinite(result) and (low < result or (allow_low and low == result)) and result <= high:
        return result
    end = "" if high == math.inf else f" and at most {high:g}"
    raise DemlawsError(
        f"{name} = {result:g} {unit}".rstrip() + f": must be {'at least' if allow_low else 'above'} {low:g}{end}"
    )


def positive(value, name, unit):
    """An array of positive, finite numbers; DemlawsError otherwise."""
    array = real(value, name, unit, array=True)
    if not np.all(np.isfinite(array) & (array > 0)):
        raise DemlawsError(f"{name} must be positive and finite, in {unit}, got {value!r}")
    return array


def whole(value, name, low=1, high=10_000_000):
    """`value` as a whole number from `low` to `high`, or an error that names it."""
    result = float(real(value, name))
    if result == result and low <= result <= high and result == int(result):
        return int(result)
    raise DemlawsError(f"{name} = {result:.15g}: give a whole number from {low} to {high}")
