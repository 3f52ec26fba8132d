"""Which part of a rough contact deforms plastically, the asperities or the bulk (Jamari & Schipper 2006, 2008).

The criterion itself stands in `criterion`; here are its answer for one contact (`assess`), a map of it, what each law
says to it (`advise`), and the papers' own tests.
"""

import itertools
import math
import warnings
from typing import NamedTuple

import numpy as np

from demlaws.contact import Contact, Material
from demlaws.criterion import (
    BAND,
    FIT_LIMIT,
    YIELD_RATIO,
    central_pressure,
    checked_loads,
    deforming_part,
    hardness_of,
    hertz_pressure,
    lowest_transition_load,
    pressure_drop,
    pressure_ratio,
    transition_load,
    transition_roughness,
)
from demlaws.errors import DemlawsError, ValidityWarning
from demlaws.laws.definition import Conditions
from demlaws.laws.registry import registry
from demlaws.units import number, real

__all__ = [
    "BAND",
    "YIELD_RATIO",
    "Advice",
    "PublishedTest",
    "Regime",
    "advise",
    "assess",
    "central_pressure",
    "deforming_part",
    "hertz_pressure",
    "lowest_transition_load",
    "pressure_drop",
    "pressure_map",
    "pressure_ratio",
    "published_contact",
    "published_tests",
    "transition_load",
    "transition_roughness",
]


class Regime(NamedTuple):
    """The criterion at one load. Pressures in Pa, loads in N, roughness in m."""

    load: float
    roughness_parameter: float  # α
    hertz_pressure: float  # p0
    central_pressure: float  # p(0)
    ratio: float  # p(0)/H_m; with a measured yield pressure p0/p_y, which is to be held against 1
    deforms: str  # "asperities", "both" or "bulk"
    transition_load: float  # load at which p(0)/H_m = 0.6
    transition_roughness: float  # roughness at which it is, at this load; 0 where even a smooth bulk stays elastic
    mu: float | None = None  # of Greenwood & Tripp's solution, where p(0) comes from it
    yield_pressure: float | None = None  # [Pa], measured

    def __str__(self):
        part = {
            "asperities": "asperities deform, the bulk stays elastic",
            "both": "asperities and bulk deform together",
            "bulk": "the bulk yields",
        }[self.deforms]
        if self.yield_pressure is not None:
            return (
                f"P = {self.load:g} N: α = {self.roughness_parameter:.3g}, p0 = {self.hertz_pressure / 1e9:.4g} GPa, "
                f"p0/p_y = {self.ratio:.3f} with the measured p_y = {self.yield_pressure / 1e9:.4g} GPa: {part}\n"
                f"the answer changes (p0 = p_y) at {self.transition_load:.4g} N"
            )
        how = "by its closed fit" if self.mu is None else f"by Greenwood & Tripp's solution at μ = {self.mu:g}"
        change = f"{self.transition_load:.4g} N" if math.isfinite(self.transition_load) else "no load"
        roughness = (
            f"σ = {self.transition_roughness * 1e6:.3g} µm at this load"
            if self.transition_roughness > 0
            else "at this load the bulk of a smooth contact is elastic too"
        )
        return (
            f"P = {self.load:g} N: α = {self.roughness_parameter:.3g}, p0 = {self.hertz_pressure / 1e9:.4g} GPa, "
            f"p(0)/H_m = {self.ratio:.3f} {how}: {part}\n"
            f"the answer changes (p(0)/H_m = {YIELD_RATIO}) at {change}; {roughness}"
        )


def _contact(contact):
    if not isinstance(contact, Contact):
        raise DemlawsError(f"contact must be a demlaws.Contact, got {contact!r:.60}")
    return contact


def assess(contact, load, mu=None, yield_pressure=None):
    """The `Regime` of one contact under `load` [N].

    mu: Greenwood & Tripp's μ of the surface, as the 2006 paper does it: p(0) then comes from their solution, else from the
    paper's closed fit, which warns (ValidityWarning) for α above 10. yield_pressure: a measured limit pressure p_y [Pa]
    (Thornton's: the smooth Hertz p0 of the load at which yield was seen); the bulk then yields where p0 reaches it, whatever
    the hardness says. Raises DemlawsError without either, or for a load that is not positive.
    """
    if _contact(contact).size is not None:
        raise DemlawsError("assess takes one contact; this one is an array: use pressure_ratio and transition_load")
    load = number(load, "load", "N")
    p0, alpha = float(hertz_pressure(contact, load)), float(contact.roughness_parameter(load))
    if yield_pressure is not None:
        limit = number(yield_pressure, "yield_pressure", "Pa")
        ratio = p0 / limit
        deforms = deforming_part(YIELD_RATIO * ratio)
        yields = float(math.pi**3 * contact.radius**2 * limit**3 / (6.0 * contact.modulus**2))
        return Regime(load, alpha, p0, p0 * float(pressure_drop(alpha)), ratio, deforms, yields, 0.0, mu, limit)
    ratio = pressure_ratio(contact, load, mu)
    if mu is None and alpha > FIT_LIMIT:
        warnings.warn(
            f"α = {alpha:.3g}: above {FIT_LIMIT:g} the closed fit of p(0)/p0 is 1.5 to 2 times too high; give μ",
            ValidityWarning,
            stacklevel=2,
        )
    return Regime(
        load=load,
        roughness_parameter=alpha,
        hertz_pressure=p0,
        central_pressure=ratio * contact.hardness,
        ratio=ratio,
        deforms=deforming_part(ratio),
        transition_load=transition_load(contact, mu=mu),
        transition_roughness=transition_roughness(contact, load, mu=mu),
        mu=mu,
    )


def pressure_map(contact, loads, roughnesses):
    """p(0)/H_m over `loads` [N] (columns) and `roughnesses` [m] (rows); `contact` gives the rest."""
    loads = np.atleast_1d(checked_loads(real(loads, "loads", "N", array=True)))
    roughnesses = np.atleast_1d(real(roughnesses, "roughnesses", "m", array=True))
    _contact(contact)
    alpha = roughnesses[:, None] * contact.with_values(roughness=1e-9).roughness_parameter(loads)[None, :] / 1e-9
    return hertz_pressure(contact, loads)[None, :] * pressure_drop(alpha) / hardness_of(contact)


class PublishedRatio(NamedTuple):
    """A published test and p(0)/H_m, computed: by the paper's own method where it prints μ, and by its closed fit."""

    test: object  # PublishedTest
    alpha: float
    solved: float  # by Greenwood & Tripp at the printed μ, NaN where none is printed
    fitted: float  # by Eq. 4


ORDER = ("bulk", "both", "asperities")
"""What was seen, from the highest p(0)/H_m to the lowest, if the criterion holds."""


def published_ratios():
    """`PublishedRatio` of every published test. Nothing in it is printed in the papers but what `test` holds."""
    rows = []
    for test in published_tests():
        alpha = float(test.contact.roughness_parameter(test.load))
        solved = math.nan if math.isnan(test.mu) else pressure_ratio(test.contact, test.load, test.mu)
        rows.append(PublishedRatio(test, alpha, solved, pressure_ratio(test.contact, test.load)))
    return rows


def swaps(rows, column):
    """Neighbours that stand the wrong way round when the tests of 2006 are put in the order of `column`."""
    ranked = sorted((row for row in rows if not math.isnan(row.solved)), key=lambda row: -getattr(row, column))
    seen = [ORDER.index(row.test.seen) for row in ranked]
    return sum(a > b for a, b in itertools.pairwise(seen))


class Advice(NamedTuple):
    """Whether a law's physics fits a contact up to a load, and why."""

    law: str
    fits: bool
    reason: str


def advise(contact, load, yield_pressure=None, mu=None):
    """For each law, whether its physics fits this contact from first touch up to `load` [N], with the reason.

    The laws differ in what deforms: elastic asperities on an elastic bulk (rms, pohrt-popov, greenwood-tripp), plastic
    asperities on an elastic bulk (bahrami, yip-venart, asperity), a yielding bulk (rough-plastic), or no roughness
    (hertz); each says itself what it fits (`Definition.advise`). yield_pressure, mu: as for `assess`. Without a hardness or a
    yield pressure the bulk cannot be judged, which the reason then says.
    """
    _contact(contact)
    load = number(load, "load", "N")
    alpha = float(np.max(contact.roughness_parameter(load)))
    if yield_pressure is not None:
        ratio = float(np.max(hertz_pressure(contact, load))) / number(yield_pressure, "yield_pressure", "Pa")
        yields, state = ratio > 1.0, f"p0/p_y = {ratio:.2f}"
    elif contact.hardness is None:
        yields, state = False, "no hardness given: bulk yield not judged"
    else:
        ratio = float(np.max(pressure_ratio(contact, load, mu)))
        yields, state = ratio > YIELD_RATIO, f"p(0)/H_m = {ratio:.2f}"
    conditions = Conditions(contact, alpha, float(pressure_drop(alpha)), yields, state)
    advice = {name: definition.advise(conditions) for name, definition in registry().items()}
    return [Advice(name, bool(fits), reason) for name, (fits, reason) in advice.items()]


class PublishedTest(NamedTuple):
    """One indentation of Jamari & Schipper 2006 (their Figs. 5-7, 9-11) or 2008."""

    label: str
    material: str
    contact: Contact
    load: float  # N
    alpha: float  # as printed, NaN where not
    mu: float  # Greenwood & Tripp's μ as printed, NaN where not
    ratio: float  # p(0)/H_m as printed (2008, Cm), NaN where not: none of 2006 is
    seen: str  # "asperities", "both", "bulk"


PRINTED_RATIOS = {4.0: 0.90, 11.0: 0.925, 17.0: 0.93}
"""p(0)/p0 at α = 0.09 that the text of 2006 reads from its Fig. 1, by μ."""

ALUMINIUM = Material(young=75.2e9, poisson=0.34, hardness=0.24e9)
BRASS = Material(young=105e9, poisson=0.34, hardness=1.2e9)
STEEL_BALL = Material(young=210e9, poisson=0.3, hardness=7.5e9)
SILICON_CARBIDE_BALL = Material(young=430e9, poisson=0.17, hardness=28e9)


def published_tests():
    """The published points: six of 2006 (steel ball, R = 5 mm) and two of 2008 (SiC ball, R = 3.175 mm)."""
    rows = [
        ("Al_B", ALUMINIUM, 0.67e-6, 4.0, 0.86, 6.0, math.nan, "bulk"),
        ("Al_AB", ALUMINIUM, 2.1e-6, 4.0, 2.70, 10.0, math.nan, "both"),
        ("Al_A", ALUMINIUM, 2.2e-6, 4.0, 2.84, 12.0, math.nan, "asperities"),
        ("Br_B", BRASS, 0.13e-6, 12.0, 0.09, 11.0, math.nan, "bulk"),
        ("Br_AB", BRASS, 0.28e-6, 12.0, 0.20, 13.0, math.nan, "both"),
        ("Br_A", BRASS, 0.70e-6, 12.0, 0.50, 7.0, math.nan, "asperities"),
        ("2008 isotropic", ALUMINIUM, 1.3e-6, 0.2, math.nan, math.nan, 0.16, "asperities"),
        ("2008 anisotropic", ALUMINIUM, 1.4e-6, 0.2, math.nan, math.nan, 0.15, "asperities"),
    ]
    tests = []
    for label, flat, roughness, load, alpha, mu, ratio, seen in rows:
        ball, radius = (SILICON_CARBIDE_BALL, 3.175e-3) if label.startswith("2008") else (STEEL_BALL, 5e-3)
        contact = Contact.between(ball, flat, radius1=radius, roughness2=roughness)
        name = "aluminium" if flat is ALUMINIUM else "brass"
        tests.append(PublishedTest(label, name, contact, load, alpha, mu, ratio, seen))
    return tests


def published_contact(kind, seed=2, memory="pressure"):
    """The contact of the 2008 paper on a synthetic map: kind "isotropic" (Sq = 1.3 µm) or "anisotropic" (1.4 µm).

    SiC ball, R = 3.175 mm, on aluminium; the measured maps are not public, so a self-affine map of the paper's roughness and
    field of view (260 by 240 µm) stands in, 0.5 µm pixels, waves of 6 to 40 µm, the anisotropic one 8 times longer
    along x [our choice].
    """
    from demlaws.solvers.patches import ALUMINIUM_FACTOR, ALUMINIUM_RATIO, RoughContact
    from demlaws.surface import self_affine

    if not isinstance(kind, str) or kind not in ("isotropic", "anisotropic"):
        raise DemlawsError(f"kind = {kind!r}: the surfaces of the paper are 'isotropic' and 'anisotropic'")
    test = {t.label: t for t in published_tests()}[f"2008 {kind}"]
    heights = self_affine(
        (480, 520),
        0.5e-6,
        0.8,
        test.contact.roughness,
        seed,
        shortest=6e-6,
        longest=40e-6,
        anisotropy=8.0 if kind == "anisotropic" else 1.0,
    )
    return RoughContact(heights, test.contact, 0.34, ALUMINIUM_FACTOR, ALUMINIUM_RATIO, memory=memory)
