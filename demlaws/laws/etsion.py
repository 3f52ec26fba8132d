"""Unloading of a yielded sphere along Hertz's curve of the radius that loading left, in two variants.

`etsion`: the residual overlap follows from the largest force and the law's contact radius (Etsion, Kligerman & Kadin 2005).
`jackson`: it is the fit of Jackson, Chusoipin & Green 2005 to their finite elements (10.1115/1.1843166).
"""

import math
from typing import NamedTuple

from demlaws.core.dispatch import bind, first_loading, unloading_curve
from demlaws.core.fastmath import exp2, hertz_coefficient, kernel, log2
from demlaws.core.shear import of_first_loading, of_thornton
from demlaws.core.unloading import Rule, own_rule, thornton_step, thornton_stored_and_dissipated, thornton_unloaded


class Etsion(NamedTuple):
    """Unloads along Hertz's curve of R_p = 4 E* a_max³/(3 Pmax) from δp = δmax - 3 Pmax/(4 E* a_max); reloading likewise.

    The formula is Thornton's; the contact radius a is the law's own function of the overlap, not that of a limit pressure. It
    is Hertz's curve through (δmax, Pmax, a_max), with the exponent 1.5, and not a fit to finite elements: with `kogut-etsion`
    and ν = 0.3, δp/δmax is 0.10, 0.29, 0.50, 0.63 at w = δmax/ω_c = 3, 10, 30, 80. The fit (1 - w^-0.28)(1 - w^-0.69), which
    is attributed to the paper (its text was not at hand), gives 0.14, 0.38, 0.56, 0.67.
    """


@kernel
def _contact_area(rule, shape, p, overlap, area):
    curve_shape, curve, _ = unloading_curve(shape, p)
    return first_loading(curve_shape, curve, overlap)[3]  # of a table, too, the law's; LLVM leaves out what is not used


class Jackson(NamedTuple):
    """δp/δmax = 1.02 [1 - ((ω + 5.9)/6.9)^-0.54], ω = δmax/ω_c; along Hertz's curve from there to Pmax at δmax.

    0 to ω = 1. From ω = 145 the ratio is constant: the largest load of the finite elements, 750 P_c, is reached there, and at
    ω = 10⁴ the fit would exceed 1.
    """


LARGEST_FITTED = 145.0
"""ω/ω_c from which rule `jackson` keeps its ratio of residual to largest overlap."""


@kernel
def _fitted_area(rule, shape, p, overlap, area):
    """a²/R [m] with which `thornton_step` leaves the fitted residual: δ_H³/(δmax - δp)²."""
    w = overlap / unloading_curve(shape, p)[1].critical_overlap
    w = min(max(w, 1.0), LARGEST_FITTED)
    elastic = overlap * (1.0 - 1.02 * (1.0 - exp2(-0.54 * log2((w + 5.9) / 6.9))))
    hertz_overlap = first_loading(shape, p, overlap)[2]
    growth = hertz_overlap / elastic
    return hertz_overlap * growth * growth


for _tag, _area in ((Etsion, _contact_area), (Jackson, _fitted_area)):
    bind(
        _tag,
        step=thornton_step,
        contact_area=_area,
        stored_and_dissipated=thornton_stored_and_dissipated,
        unloaded=thornton_unloaded,
        unloading_stiffness=of_thornton,
        loading_stiffness=of_first_loading,
    )


class EtsionNumbers(NamedTuple):
    """Contact radius in a table, without units: a²/(R δ) = max(1, u/overlap)^power. Rule `jackson` reads the overlap alone."""

    overlap: float
    power: float
    length_over_roughness: float
    length_over_radius: float


class EtsionTableParams(NamedTuple):
    """One contact."""

    hertz_coefficient: float  # (4/3) E* √R [N/m^1.5]
    critical_overlap: float  # where the contact radius leaves Hertz's, of rule `jackson` ω_c [m]
    power: float


@kernel
def _table_scale(shape, radius, modulus, roughness):
    length = shape.length_over_roughness * roughness + shape.length_over_radius * radius
    return EtsionTableParams(hertz_coefficient(radius, modulus), shape.overlap * length, shape.power)


@kernel
def _table_area(shape, p, overlap):
    """As `first_loading`, of which nothing but the contact radius is known here."""
    ratio = overlap / p.critical_overlap
    area = overlap * exp2(p.power * log2(ratio if ratio > 1.0 else 1.0))
    return math.nan, math.nan, math.nan, area


bind(EtsionNumbers, scale=_table_scale)
bind(EtsionTableParams, first_loading=_table_area)


def _jackson_numbers(overlap, *lengths):
    """The Shape of rule `jackson` in a table: ω_c without units."""
    return EtsionNumbers(overlap, 0.0, *lengths)


def rule_numbers(p, length, joint, power):
    """Values of the keys of both rules; a²/(R δ) = max(1, ω/joint)^power."""
    overlap = p.critical_overlap / length
    return {"etsion_overlap": overlap * joint, "etsion_power": power, "jackson_overlap": overlap}


_STATE = ("maximum_overlap", "plastic_overlap", "radius_ratio")
ETSION = own_rule(
    Rule(
        "etsion",
        Etsion(),
        _STATE,
        "law",
        6,
        "back along Hertz's curve of the radius that Pmax and the law's own contact radius leave",
        ("etsion_overlap", "etsion_power"),
        EtsionNumbers,
        springs="thornton",
    )
)
JACKSON = own_rule(
    Rule(
        "jackson",
        Jackson(),
        _STATE,
        "law",
        7,
        "back along Hertz's curve from the residual overlap of finite elements",
        ("jackson_overlap",),
        _jackson_numbers,
        springs="thornton",
    )
)

NOT_THORNTON = {"thornton": "a limit pressure gives that rule its contact radius; 'etsion' takes this law's own"}
