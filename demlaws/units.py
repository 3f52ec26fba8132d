"""Checks of user input, and admissible values of materials, surfaces and contacts: one set of limits and words for Python,
YADE and the plugins. One error names the value, the unit and the range.

`judge(young=60.6)` returns findings: inadmissible values, which are refused, and unlikely ones, about which a warning is
issued. `cpp/demlaws_range.h` judges a contact's modulus and roughness in the same words.
"""

import math
import re
from typing import NamedTuple

import numpy as np

from demlaws.errors import DemlawsError

SMALL_OVERLAP = 0.1
"""Overlap over effective radius up to which contact laws are valid (bodies as half-spaces). One warning beyond it."""
LARGEST_OVERLAP = 1.0
"""Overlap over effective radius above which laws are undefined."""


def large_overlap(overlap, radius, count=1, total=1):
    """Text about overlaps beyond SMALL_OVERLAP of the radius, for Python and engines alike: largest one [m], its R [m]."""
    those = f" ({count} of {total} contacts are beyond {SMALL_OVERLAP:g} R)" if total > 1 else ""
    return (
        f"overlap {as_typed(overlap, 'm')} is {overlap / radius:.3g} of the effective radius R = {radius:g} m{those}: contact "
        f"laws are valid for overlaps up to {SMALL_OVERLAP:g} R; check units, loads and the step"
    )


def too_large_overlap(overlap, radius):
    """Text about an overlap [m] beyond LARGEST_OVERLAP of its radius [m], for Python and engines alike."""
    return (
        f"overlap {as_typed(overlap, 'm')} is {overlap / radius:.3g} times the effective radius R = {radius:g} m: contact laws "
        f"are valid for overlaps up to {SMALL_OVERLAP:g} R and undefined beyond R; check units, loads and the step"
    )


def check_overlaps(overlap, radius, source=()):
    """None, or the text for a warning where some overlap [m] is beyond SMALL_OVERLAP of its radius [m].

    Raises DemlawsError where one is beyond LARGEST_OVERLAP of it. Both may be arrays, which broadcast. source: see `typed`.
    """
    if np.size(overlap) == 0:
        return None
    with np.errstate(over="ignore", under="ignore"):
        ratio = np.asarray(overlap) / np.asarray(radius)
    where = int(np.argmax(ratio))
    worst = float(ratio.flat[where])
    if not worst > SMALL_OVERLAP * (1.0 + 1e-9):
        return None
    value, own = (float(np.broadcast_to(one, ratio.shape).flat[where]) for one in (overlap, radius))
    value = typed(value, source, "m")
    if worst > LARGEST_OVERLAP:
        raise DemlawsError(too_large_overlap(value, own))
    return large_overlap(value, own, int(np.sum(ratio > SMALL_OVERLAP)), ratio.size)


UNITS = {
    "m": {
        "m": 1.0,
        "cm": 1e-2,
        "mm": 1e-3,
        "inch": 0.0254,
        "in": 0.0254,
        "um": 1e-6,
        "micron": 1e-6,
        "nm": 1e-9,
        "Å": 1e-10,
        "pm": 1e-12,
    },
    "Pa": {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9, "N/mm²": 1e6, "N/mm2": 1e6},
    "N": {
        "N": 1.0,
        "mN": 1e-3,
        "uN": 1e-6,
        "nN": 1e-9,
        "kN": 1e3,
        "MN": 1e6,
        "gf": 9.80665e-3,
        "kgf": 9.80665,
        "lbf": 4.4482216152605,
    },
    "m/s": {"m/s": 1.0, "mm/s": 1e-3, "um/s": 1e-6},
    "kg": {"kg": 1.0, "g": 1e-3, "mg": 1e-6, "t": 1e3},
    "kg/m³": {"kg/m³": 1.0, "kg/m3": 1.0, "g/cm³": 1e3, "g/cm3": 1e3},
    "m/N": {"m/N": 1.0, "mm/N": 1e-3, "um/N": 1e-6, "nm/N": 1e-9, "mm/kN": 1e-6, "um/kN": 1e-9},
    "rad": {"rad": 1.0, "deg": math.pi / 180.0, "°": math.pi / 180.0},
    "N/m": {"N/m": 1.0, "N/mm": 1e3, "N/um": 1e6, "kN/m": 1e3, "kN/mm": 1e6, "MN/m": 1e6},
    "1/m": {"1/m": 1.0, "1/mm": 1e3, "1/um": 1e6},
    "1/m²": {"1/m²": 1.0, "1/m2": 1.0, "1/mm²": 1e6, "1/mm2": 1e6, "1/um²": 1e12, "1/um2": 1e12},
    "1/s": {"1/s": 1.0, "/s": 1.0},
}
"""SI unit → spellings that are read in text beside a plain number, and what each is in that unit."""
_QUANTITY = re.compile(r"([-+]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][-+]?\d+)?|[-+]?(?:inf|nan))\s*(\S*)")
_LONGEST = 100
"""Characters of a number with its unit."""


HANDY = {"m": ("µm", 1e6), "Pa": ("GPa", 1e-9), "m/N": ("µm/N", 1e6), "N/m": ("N/µm", 1e-6)}
"""SI unit → the unit in which people read such a quantity of a contact, and its number per SI unit."""


def plain_unit(text):
    """A unit as written in `UNITS`: u for both of Unicode's µ, one Å."""
    return text.replace("µ", "u").replace("μ", "u").replace("\u212b", "Å")


class Typed(float):
    """A number in SI units with the text that it was read from."""

    text: str


def quantity(text, name, unit=""):
    """A number in the SI unit `unit` from text such as "3mm", "2.4 µm", "60GPa" or "6e10". Raises DemlawsError."""
    text = text.strip()
    match = _QUANTITY.fullmatch(text) if len(text) <= _LONGEST else None
    factors = UNITS.get(unit, {unit: 1.0} if unit else {})
    symbol = plain_unit(match[2]) if match else ""
    if match and (not symbol or symbol in factors):
        value = Typed(float(match[1]) * factors.get(symbol, 1.0))
        if (math.isinf(value) and "inf" not in match[1]) or (
            value == 0.0 and re.search("[1-9]", match[1].lower().split("e")[0])
        ):
            raise DemlawsError(f"{name} = {text}: the number is too {'small' if value == 0.0 else 'large'} to compute with")
        value.text = text
        return value
    units = f" in {unit}, or with one of the units {', '.join(factors)}" if factors else f" in {unit}" if unit else ""
    raise DemlawsError(f"{name} must be a number{units}, got {text!r:.60}")


def unmasked(value):
    """A masked array as a plain one with NaN where it is masked; anything else as it is. numpy itself drops the mask."""
    if not isinstance(value, np.ma.MaskedArray) or value.dtype.kind not in "fiu":
        return value
    return (value if value.dtype.kind == "f" else value.astype(float)).filled(math.nan)


def _refuse_units(value, name, unit):
    """The value, or DemlawsError if it has a unit other than `unit` (of pint, unyt, astropy): numpy drops it."""
    own = getattr(value, "units", getattr(value, "unit", None))
    if own is None or str(own) in (unit, "dimensionless"):
        return value
    raise DemlawsError(
        f"{name} has the unit {own!s:.30}: give a plain number{f' in {unit}' if unit else ''}, or text with a unit"
    )


def as_float(value, name, unit="", array=False):
    """A number (or an array of them) as float64: numbers, or text as `quantity` reads it; anything else is refused."""
    if isinstance(value, str):
        return np.float64(quantity(value, name, unit))
    _refuse_units(value, name, unit)
    try:
        if isinstance(value, bytes | bytearray | memoryview):  # numpy would take their bytes for numbers
            raise TypeError
        if array and isinstance(value, (list, tuple)):
            value = [quantity(v, name, unit) if isinstance(v, str) else _refuse_units(v, name, unit) for v in value]
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


def as_given(value):
    """A result as a number where it has no dimensions, else the array."""
    return float(value) if np.ndim(value) == 0 else value


def number(value, name, unit="", low=0.0, high=math.inf, allow_low=False):
    """`value` (a number, or text as `quantity` reads it) as a float above `low` (or from it) and up to `high`, or an error
    that names it."""
    result = float(as_float(value, name, unit))
    if math.isfinite(result) and (low < result or (allow_low and low == result)) and result <= high:
        return result
    end = "" if high == math.inf else f" and at most {high:g}"
    text = as_typed(value, unit)
    unit = "" if text.endswith(unit and f" {unit}") else f" {unit}"
    raise DemlawsError(f"{name} = {text}: must be {'at least' if allow_low else 'above'} {low:g}{end}{unit}")


def as_typed(value, unit=""):
    """A number with its unit in words: as the user typed it, in Python or at the command line, else in SI."""
    value = quantity(value, "", unit) if isinstance(value, str) else value
    if not isinstance(value, Typed):
        return f"{float(value):g} {unit}".rstrip()
    return f"{value.text} {unit}".rstrip() if value.text[-1] in "0123456789." else value.text


def typed(value, source, unit):
    """A number [SI] with the user's text if `source`, a number or text or a list of them, has it as text; else as it is."""
    for one in source if isinstance(source, list | tuple) else (source,):
        one = quantity(one, "", unit) if isinstance(one, str) else one
        if isinstance(one, Typed) and one == value:
            return one
    return float(value)


def positive(value, name, unit):
    """An array of positive, finite numbers; DemlawsError otherwise."""
    array = as_float(value, name, unit, array=True)
    if not np.all(np.isfinite(array) & (array > 0)):
        raise DemlawsError(f"{name} must be positive and finite, in {unit}, got {value!r:.200}")
    return array


def whole(value, name, low=1, high=10_000_000):
    """`value` as a whole number from `low` to `high`, or an error that names it."""
    result = float(as_float(value, name))
    if result == result and low <= result <= high and result == int(result):
        return int(result)
    raise DemlawsError(f"{name} = {result:.15g}: give a whole number from {low} to {high}")


class Range(NamedTuple):
    """Admissible values of one quantity: above `low` (or from it, where `low_included`) and up to `high`."""

    unit: str
    low: float
    high: float
    remedy: str
    low_included: bool = False


SOFTEST = 2e3
"""Young's modulus [Pa] below which no grain is: soft gels have about 5 kPa. A modulus in GPa without its unit lies below."""

RANGES = {
    "young": Range(
        "Pa", SOFTEST, math.inf, f"Young's modulus of a grain must be above {SOFTEST:g} Pa; did you mean GPa (1 GPa = 1e9 Pa)?"
    ),
    "poisson": Range("", -1.0, 0.5, "Poisson's ratio must be above -1 and at most 0.5"),
    "density": Range(
        "kg/m³", 10.0, math.inf, "a grain's density must be above 10 kg/m³; did you mean g/cm³ (1 g/cm³ = 1000 kg/m³)?"
    ),
    "hardness": Range("Pa", 0.0, math.inf, "hardness must be positive (a Vickers number in kgf/mm² times 9.807e6)"),
    "fractal_dimension": Range(
        "", 2.0, 3.0, "the fractal dimension of a surface lies in [2, 3] (Hurst exponent H = 3 - Df)", low_included=True
    ),
    "radius": Range("m", 0.0, math.inf, "the radius must be positive (two flats have no Hertz contact)"),
    "edge_radius": Range("m", 0.0, math.inf, "the radius of a grain's edges must be positive"),
    "modulus": Range(
        "Pa",
        SOFTEST / 2,
        math.inf,
        f"the effective modulus E* must be above {SOFTEST / 2:g} Pa; did you mean GPa (1 GPa = 1e9 Pa)?",
    ),
    "roughness": Range("m", 0.0, math.inf, "rms roughness Sq cannot be negative", low_included=True),
    "sigma": Range("m", 0.0, math.inf, "the combined roughness σ cannot be negative", low_included=True),
}
LARGEST_ROUGHNESS = 0.5
"""σ/R above which a roughness is refused: no rough sphere is left."""
LARGE_ROUGHNESS = 0.1
"""σ/R above which a warning is issued: all laws assume a roughness far below the radius."""
LARGE_RADIUS = 1.0
"""Radius [m] above which a warning is issued; a plain number above it that is typed as radius1 or radius2 is refused."""


class Finding(NamedTuple):
    """An inadmissible value, or an unlikely one, in words."""

    admissible: bool
    quantity: str
    text: str  # begins with the name of the quantity


def outside(name: str, values: float | np.ndarray) -> np.ndarray:
    """Whether values [SI] of a quantity of `RANGES` are not admissible, entry by entry."""
    _, low, high, _, included = RANGES[name]
    values = np.asarray(values)
    return ~((values >= low) if included else (values > low)) | (values > high) | ~np.isfinite(values)


def judge(**quantities: float) -> list[Finding]:
    """Findings on one body, surface or contact: keywords of `RANGES` in SI units; an empty list where all is well.

    roughness of a surface, or sigma of a contact, is compared with the contact's effective radius where both are given.

    >>> from demlaws.units import judge
    >>> print(judge(young=60.6, poisson=0.25)[0].text)
    young = 60.6 Pa: Young's modulus of a grain must be above 2000 Pa; did you mean GPa (1 GPa = 1e9 Pa)?
    """
    findings = []
    for name, value in quantities.items():
        if outside(name, value):
            remedy = "it must be positive" if value <= 0.0 < RANGES[name].low else RANGES[name].remedy
            findings.append(Finding(False, name, f"{name} = {as_typed(value, RANGES[name].unit)}: {remedy}"))
    if findings:
        return findings
    radius, rough = quantities.get("radius", 0.0), "sigma" if "sigma" in quantities else "roughness"
    height = quantities.get(rough, 0.0)
    if radius > LARGE_RADIUS:
        findings.append(
            Finding(
                True,
                "radius",
                f"radius = {as_typed(radius, 'm')} is above {LARGE_RADIUS:g} m; did you mean mm (1 mm = 0.001 m)?",
            )
        )
    if radius and height > LARGE_ROUGHNESS * radius:
        admissible = height <= LARGEST_ROUGHNESS * radius
        limit = LARGE_ROUGHNESS if admissible else LARGEST_ROUGHNESS
        findings.append(
            Finding(
                admissible,
                rough,
                f"{rough} = {as_typed(height, 'm')} is {height / radius:.3g} times the radius {as_typed(radius, 'm')}, above "
                f"{limit:g}: the laws assume a roughness far below the radius; did you mean µm (1 µm = 1e-6 m)?",
            )
        )
    return findings


def refuse_plain_radius(name: str, value: object) -> None:
    """Refuse a typed radius, or one in a list, that is a plain number above LARGE_RADIUS: text with its unit is accepted."""
    for one in value if isinstance(value, list | tuple) else [value]:
        array = np.asarray(one)
        if array.dtype.kind in "fiu" and np.any(large := np.isfinite(array) & (array > LARGE_RADIUS)):
            largest = float(array[large].max())
            raise DemlawsError(
                f"{name} = {largest:g} m is above {LARGE_RADIUS:g} m; did you mean mm (1 mm = 0.001 m)? Give a boulder as text "
                f'with its unit, "{largest:g}m", a flat as inf'
            )
