"""Admissible values of materials, surfaces and contacts: one set of limits and words for Python, YADE and the plugins.

`judge(young=60.6)` returns findings: inadmissible values, which are refused, and unlikely ones, about which a warning is
issued. `cpp/demlaws_range.h` judges a contact's modulus and roughness in the same words (tests/cpp/test_limits.py).
"""

import math
from typing import NamedTuple

import numpy as np

from demlaws.errors import DemlawsError


class Range(NamedTuple):
    """Admissible values of one quantity: above `low` (or from it, where `low_included`) and up to `high`."""

    unit: str
    low: float
    high: float
    remedy: str
    low_included: bool = False


SOFTEST = 2e3
"""Young's modulus [Pa] below which no grain is: soft gels have some 5 kPa. A modulus in GPa without its unit lies below."""

RANGES = {
    "young": Range(
        "Pa", SOFTEST, math.inf, f"Young's modulus of a grain is above {SOFTEST:g} Pa; did you mean GPa (1 GPa = 1e9 Pa)?"
    ),
    "poisson": Range("", -1.0, 0.5, "Poisson's ratio must be above -1 and at most 0.5"),
    "density": Range(
        "kg/m³", 10.0, math.inf, "a grain's density is above 10 kg/m³; did you mean g/cm³ (1 g/cm³ = 1000 kg/m³)?"
    ),
    "hardness": Range("Pa", 0.0, math.inf, "hardness must be positive (a Vickers number in kgf/mm² times 9.807e6)"),
    "fractal_dimension": Range(
        "", 2.0, 3.0, "the fractal dimension of a surface lies in [2, 3] (Hurst exponent H = 3 - Df)", low_included=True
    ),
    "radius": Range("m", 0.0, math.inf, "the radius must be positive (two flats have no Hertz contact)"),
    "edge_radius": Range("m", 0.0, math.inf, "the radius of a grain's edges must be positive"),
    "modulus": Range(
        "Pa", SOFTEST / 2, math.inf, f"the effective modulus E* is above {SOFTEST / 2:g} Pa; did you mean GPa (1 GPa = 1e9 Pa)?"
    ),
    "roughness": Range("m", 0.0, math.inf, "rms roughness Sq cannot be negative", low_included=True),
}
LARGEST_ROUGHNESS = 0.5
"""σ/R above which a roughness is refused: no rough sphere is left."""
LARGE_ROUGHNESS = 0.1
"""σ/R above which a warning is issued: all laws take the roughness for small beside the radius."""
LARGE_RADIUS = 1.0
"""Radius [m] above which a warning is issued; a plain number above it that is typed as radius1 or radius2 is refused."""


class Finding(NamedTuple):
    """An inadmissible value, or an unlikely one, in words."""

    admissible: bool
    text: str


def outside(name: str, values: float | np.ndarray) -> np.ndarray:
    """Whether values [SI] of a quantity of `RANGES` are not admissible, entry by entry."""
    _, low, high, _, included = RANGES[name]
    values = np.asarray(values)
    return ~((values >= low) if included else (values > low)) | (values > high) | ~np.isfinite(values)


def judge(**quantities: float) -> list[Finding]:
    """Findings on one body, surface or contact: keywords of `RANGES` in SI units; an empty list where all is well.

    roughness is compared with radius where both are given (combined roughness and effective radius of a contact).

    >>> from demlaws.admissible import judge
    >>> print(judge(young=60.6, poisson=0.25)[0].text)
    young = 60.6 Pa: Young's modulus of a grain is above 2000 Pa; did you mean GPa (1 GPa = 1e9 Pa)?
    """
    findings = []
    for name, value in quantities.items():
        if outside(name, value):
            findings.append(Finding(False, f"{name} = {value:g} {RANGES[name].unit}".rstrip() + f": {RANGES[name].remedy}"))
    if findings:
        return findings
    radius, roughness = quantities.get("radius", 0.0), quantities.get("roughness", 0.0)
    if radius > LARGE_RADIUS:
        findings.append(Finding(True, f"radius = {radius:g} m is above {LARGE_RADIUS:g} m; did you mean mm (1 mm = 0.001 m)?"))
    if radius and roughness > LARGE_ROUGHNESS * radius:
        admissible = roughness <= LARGEST_ROUGHNESS * radius
        limit = LARGE_ROUGHNESS if admissible else LARGEST_ROUGHNESS
        findings.append(
            Finding(
                admissible,
                f"roughness = {roughness:g} m is {roughness / radius:.3g} of the radius {radius:g} m, above {limit:g}: the "
                "laws take roughness for small beside the radius; did you mean µm (1 µm = 1e-6 m)?",
            )
        )
    return findings


def refuse(**quantities: float) -> list[str]:
    """Texts of the warnings that `judge` finds; DemlawsError where a value is not admissible."""
    findings = judge(**quantities)
    for one in findings:
        if not one.admissible:
            raise DemlawsError(one.text)
    return [one.text for one in findings]


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
