"""The tests of Jamari & Schipper 2006 and 2008, p(0)/H_m of each, and the contact of 2008 on a synthetic map."""

import itertools
import math
from typing import NamedTuple

from demlaws.contact import Contact, Material
from demlaws.errors import DemlawsError
from demlaws.solvers import criterion


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


LOAD = 0.2  # [N], of the tests of 2008

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
        ("2008 isotropic", ALUMINIUM, 1.3e-6, LOAD, math.nan, math.nan, 0.16, "asperities"),
        ("2008 anisotropic", ALUMINIUM, 1.4e-6, LOAD, math.nan, math.nan, 0.15, "asperities"),
    ]
    tests = []
    for label, flat, roughness, load, alpha, mu, ratio, seen in rows:
        ball, radius = (SILICON_CARBIDE_BALL, 3.175e-3) if label.startswith("2008") else (STEEL_BALL, 5e-3)
        contact = Contact.between(ball, flat, radius1=radius, radius2="flat", roughness1=0, roughness2=roughness)
        name = "aluminium" if flat is ALUMINIUM else "brass"
        tests.append(PublishedTest(label, name, contact, load, alpha, mu, ratio, seen))
    return tests


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
        solved = math.nan if math.isnan(test.mu) else criterion.pressure_ratio(test.contact, test.load, test.mu)
        rows.append(PublishedRatio(test, alpha, solved, criterion.pressure_ratio(test.contact, test.load)))
    return rows


def swaps(rows, column):
    """Neighbours that stand the wrong way round when the tests of 2006 are put in the order of `column`."""
    ranked = sorted((row for row in rows if not math.isnan(row.solved)), key=lambda row: -getattr(row, column))
    seen = [ORDER.index(row.test.seen) for row in ranked]
    return sum(a > b for a, b in itertools.pairwise(seen))


def published_contact(kind, seed=2):
    """The contact of the 2008 paper on a synthetic map: kind "isotropic" (Sq = 1.3 µm) or "anisotropic" (1.4 µm).

    SiC ball, R = 3.175 mm, on aluminium; the measured maps are not public, so a self-affine map of the paper's roughness and
    field of view (260 by 240 µm) replaces them, 0.5 µm pixels, waves of 6 to 40 µm, the anisotropic one 8 times longer
    along x [our choice].
    """
    from demlaws.solvers.contact import RoughContact
    from demlaws.solvers.ellipsoid import ALUMINIUM_FACTOR, ALUMINIUM_RATIO
    from demlaws.surface import self_affine

    if not isinstance(kind, str) or kind not in ("isotropic", "anisotropic"):
        raise DemlawsError(f"kind = {kind!r}: the surfaces of the paper are 'isotropic' and 'anisotropic'")
    test = {t.label: t for t in published_tests()}[f"2008 {kind}"]
    heights = self_affine(
        (480, 520),
        0.5e-6,
        0.8,
        roughness=test.contact.sigma,
        seed=seed,
        shortest=6e-6,
        longest=40e-6,
        anisotropy=8.0 if kind == "anisotropic" else 1.0,
    )
    return RoughContact(heights, test.contact, 0.34, ALUMINIUM_FACTOR, ALUMINIUM_RATIO)
