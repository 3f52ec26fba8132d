"""Which part of a rough contact deforms plastically, the asperities or the bulk (Jamari & Schipper 2006, 2008).

The mean pressure in the middle of a rough contact, p(0), is Hertz's p0 lowered by roughness:

    p(0)/p0 = 1 - exp(-2/(3 α^0.6)),   p0 = (6 P E*²/(π³ R²))^(1/3),   α = σ (16 R E*²/(9 P²))^(1/3).

The bulk stays elastic, so that only asperities deform, while p(0)/H_m < 0.6; above, the bulk yields; both deform where
the ratio is close to 0.6. Both papers print 16 in place of the 6 and one loses the cube root; with the 6 of Hertz's
theory their printed α and p(0)/H_m are reproduced (`published_tests`).
"""

import math
from typing import NamedTuple

import numpy as np

from demlaws.checks import number
from demlaws.contact import Contact, Material
from demlaws.errors import DemlawsError

YIELD_RATIO = 0.6
"""p(0)/H_m at which the bulk begins to yield (Tabor)."""

BAND = 0.04
"""Half width of the range around `YIELD_RATIO` in which asperities and bulk deform together.

Ours: the papers say "near 0.6"; their points with both are at 0.570 and 0.630, bulk alone is seen from 0.647.
"""


class Regime(NamedTuple):
    """The criterion at one load. Pressures in Pa, loads in N, roughness in m."""

    load: float
    roughness_parameter: float  # α
    hertz_pressure: float  # p0
    central_pressure: float  # p(0)
    ratio: float  # p(0)/H_m
    deforms: str  # "asperities", "both" or "bulk"
    transition_load: float  # load at which p(0)/H_m = 0.6
    transition_roughness: float  # roughness at which it is, at this load; 0 where even a smooth bulk stays elastic

    def __str__(self):
        part = {
            "asperities": "asperities deform, the bulk stays elastic",
            "both": "asperities and bulk deform together",
            "bulk": "the bulk yields",
        }[self.deforms]
        change = f"{self.transition_load:.4g} N" if math.isfinite(self.transition_load) else "no load"
        roughness = (
            f"σ = {self.transition_roughness * 1e6:.3g} µm at this load"
            if self.transition_roughness > 0
            else "at this load the bulk of a smooth contact is elastic too"
        )
        return (
            f"P = {self.load:g} N: α = {self.roughness_parameter:.3g}, p0 = {self.hertz_pressure / 1e9:.4g} GPa, "
            f"p(0)/H_m = {self.ratio:.3f}: {part}\n"
            f"the answer changes (p(0)/H_m = {YIELD_RATIO}) at {change}; {roughness}"
        )


def hertz_pressure(contact, load):
    """p0 = (6 P E*²/(π³ R²))^(1/3) [Pa], the largest pressure of a smooth contact under `load` [N]."""
    return (6.0 * np.asarray(load, float) * contact.modulus**2 / (math.pi**3 * contact.radius**2)) ** (1 / 3)


def pressure_drop(roughness_parameter):
    """p(0)/p0 = 1 - exp(-2/(3 α^0.6)): their fit to Greenwood & Tripp's results for μ = 4 to 17."""
    alpha = np.asarray(roughness_parameter, float)
    with np.errstate(divide="ignore"):
        return -np.expm1(-2.0 / (3.0 * alpha**0.6))


def pressure_ratio(contact, load):
    """p(0)/H_m under `load` [N] (number or array), of a contact that has a hardness."""
    load = _loads(load)
    drop = pressure_drop(contact.roughness_parameter(load))
    return _plain(hertz_pressure(contact, load) * drop / _hardness(contact))


def deforming_part(ratio):
    """ "asperities", "both" or "bulk" for a ratio p(0)/H_m."""
    return "asperities" if ratio < YIELD_RATIO - BAND else "bulk" if ratio > YIELD_RATIO + BAND else "both"


def transition_load(contact, ratio=YIELD_RATIO):
    """Load [N] at which p(0)/H_m reaches `ratio`; below it only asperities deform.

    p(0) rises with the load at every roughness, as P^0.733 where roughness rules and as P^(1/3) without it, so there is
    one such load. One number, or one entry a contact.
    """
    hardness, ratio = _hardness(contact), number(ratio, "ratio")
    smooth = math.pi**3 * contact.radius**2 * (ratio * hardness) ** 3 / (6.0 * contact.modulus**2)
    low = np.log(np.asarray(smooth, float))
    high = low + 1.0
    while np.any(pressure_ratio(contact, np.exp(high)) < ratio):
        high = np.where(pressure_ratio(contact, np.exp(high)) < ratio, 2.0 * high - low + 1.0, high)
        if np.any(high > 600.0):
            raise DemlawsError(
                f"no load below 1e260 N brings p(0)/H_m to {ratio:g}: check roughness, radius and hardness units"
            )
    for _ in range(80):
        middle = 0.5 * (low + high)
        below = pressure_ratio(contact, np.exp(middle)) < ratio
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    return _plain(np.exp(0.5 * (low + high)))


def lowest_transition_load(contact):
    """Lowest `transition_load` [N] of an array of contacts; of many, the bound from their extremes, which is not above it."""
    if contact.size is not None and contact.size > 64:
        extremes = {
            "radius": np.min(contact.radius),
            "modulus": np.max(contact.modulus),
            "roughness": np.min(contact.roughness),
        }
        contact = contact.with_values(**{name: float(value) for name, value in extremes.items()})
    return float(np.min(transition_load(contact)))


def transition_roughness(contact, load, ratio=YIELD_RATIO):
    """Combined roughness σ [m] at which p(0)/H_m equals `ratio` under `load` [N]; 0 where no roughness is needed."""
    load = _loads(load)
    share = number(ratio, "ratio") * _hardness(contact) / hertz_pressure(contact, load)
    with np.errstate(divide="ignore", invalid="ignore"):
        alpha = np.where(share < 1.0, (-2.0 / (3.0 * np.log1p(-np.minimum(share, 1.0)))) ** (1 / 0.6), 0.0)
    return _plain(alpha / (16.0 * contact.radius * contact.modulus**2 / (9.0 * load**2)) ** (1 / 3))


def assess(contact, load):
    """The `Regime` of one contact under `load` [N].

    Raises DemlawsError without a hardness, or for a load that is not positive.
    """
    if contact.size is not None:
        raise DemlawsError("assess takes one contact; this one is an array: use pressure_ratio and transition_load")
    load = number(load, "load", "N")
    p0 = float(hertz_pressure(contact, load))
    ratio = pressure_ratio(contact, load)
    return Regime(
        load=load,
        roughness_parameter=float(contact.roughness_parameter(load)),
        hertz_pressure=p0,
        central_pressure=ratio * contact.hardness,
        ratio=ratio,
        deforms=deforming_part(ratio),
        transition_load=transition_load(contact),
        transition_roughness=transition_roughness(contact, load),
    )


def pressure_map(contact, loads, roughnesses):
    """p(0)/H_m over `loads` [N] (columns) and `roughnesses` [m] (rows); `contact` gives the rest."""
    loads, roughnesses = _loads(loads), np.asarray(roughnesses, float)
    alpha = roughnesses[:, None] * contact.with_values(roughness=1e-9).roughness_parameter(loads)[None, :] / 1e-9
    return hertz_pressure(contact, loads)[None, :] * pressure_drop(alpha) / _hardness(contact)


class Advice(NamedTuple):
    """Whether a law's physics fits a contact up to a load, and why."""

    law: str
    fits: bool
    reason: str


def advise(contact, load):
    """For each law, whether its physics fits this contact from first touch up to `load` [N], with the reason.

    The laws differ in what deforms: elastic asperities on an elastic bulk (rms, pohrt-popov, greenwood-tripp), plastic
    asperities on an elastic bulk (bahrami, yip-venart, asperity), a yielding bulk (rough-plastic), or no roughness
    (hertz). Without a hardness the bulk cannot be judged, which the reason then says.
    """
    load = number(load, "load", "N")
    alpha = float(np.max(contact.roughness_parameter(load)))
    if contact.hardness is None:
        bulk, state = False, "no hardness given: bulk yield not judged"
    else:
        ratio = float(np.max(pressure_ratio(contact, load)))
        bulk, state = ratio > YIELD_RATIO, f"p(0)/H_m = {ratio:.2f}"
    smooth = float(pressure_drop(alpha)) > 0.95

    def elastic_bulk(extra_ok=True, extra=""):
        if bulk:
            return False, f"{state}: the bulk yields and this law keeps it elastic"
        return extra_ok, extra if not extra_ok else state

    dimension = contact.fractal_dimension is not None
    advice = {
        "hertz": elastic_bulk(
            smooth, f"α = {alpha:.2g}: roughness lowers the pressure by {100 * (1 - pressure_drop(alpha)):.0f} %"
        ),
        "rms": elastic_bulk(alpha <= 5.0, f"α = {alpha:.2g}: unreliable above 5"),
        "pohrt-popov": elastic_bulk(dimension, "needs a fractal dimension"),
        "goddard": elastic_bulk(),
        "greenwood-tripp": elastic_bulk(),
        "bahrami": elastic_bulk(contact.hardness is not None, "needs a hardness"),
        "yip-venart": elastic_bulk(contact.hardness is not None, "needs a hardness"),
        "asperity": elastic_bulk(contact.hardness is not None, "needs a hardness"),
        "rough-plastic": (
            bulk,
            f"{state}: " + ("the bulk yields" if bulk else "the bulk is elastic; a rough law alone will do"),
        ),
    }
    return [Advice(name, bool(fits), reason) for name, (fits, reason) in advice.items()]


class PublishedTest(NamedTuple):
    """One indentation of Jamari & Schipper 2006 (their Figs. 5-7, 9-11) or 2008."""

    label: str
    material: str
    contact: Contact
    load: float  # N
    alpha: float  # as printed, NaN where not
    ratio: float  # p(0)/H_m: 2006 as drawn in Fig. 12, 2008 as printed (Cm)
    seen: str  # "asperities", "both", "bulk"


ALUMINIUM = Material(young=75.2e9, poisson=0.34, hardness=0.24e9)
BRASS = Material(young=105e9, poisson=0.34, hardness=1.2e9)
STEEL_BALL = Material(young=210e9, poisson=0.3, hardness=7.5e9)
SILICON_CARBIDE_BALL = Material(young=430e9, poisson=0.17, hardness=28e9)


def published_tests():
    """The published points: six of 2006 (steel ball, R = 5 mm) and two of 2008 (SiC ball, R = 3.175 mm)."""
    rows = [
        ("Al_B", ALUMINIUM, 0.67e-6, 4.0, 0.86, 1.061, "bulk"),
        ("Al_AB", ALUMINIUM, 2.1e-6, 4.0, 2.70, 0.630, "both"),
        ("Al_A", ALUMINIUM, 2.2e-6, 4.0, 2.84, 0.616, "asperities"),
        ("Br_B", BRASS, 0.13e-6, 12.0, 0.09, 0.647, "bulk"),
        ("Br_AB", BRASS, 0.28e-6, 12.0, 0.20, 0.570, "both"),
        ("Br_A", BRASS, 0.70e-6, 12.0, 0.50, 0.438, "asperities"),
        ("2008 isotropic", ALUMINIUM, 1.3e-6, 0.2, math.nan, 0.16, "asperities"),
        ("2008 anisotropic", ALUMINIUM, 1.4e-6, 0.2, math.nan, 0.15, "asperities"),
    ]
    tests = []
    for label, flat, roughness, load, alpha, ratio, seen in rows:
        ball, radius = (SILICON_CARBIDE_BALL, 3.175e-3) if label.startswith("2008") else (STEEL_BALL, 5e-3)
        contact = Contact.between(ball, flat, radius1=radius, roughness2=roughness)
        name = "aluminium" if flat is ALUMINIUM else "brass"
        tests.append(PublishedTest(label, name, contact, load, alpha, ratio, seen))
    return tests


def _hardness(contact):
    if contact.hardness is None:
        raise DemlawsError(
            "the criterion needs the contact's hardness: give Contact(..., hardness=...) or Material(..., hardness=...)"
        )
    return contact.hardness


def _loads(load):
    array = np.asarray(load, float)
    if not np.all(np.isfinite(array) & (array > 0)):
        raise DemlawsError(f"load must be positive and finite, in N, got {load!r}")
    return array


def _plain(value):
    return float(value) if np.ndim(value) == 0 else value
