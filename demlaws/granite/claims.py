"""Statements of Altuhafi, Baudet & Coop 2023 compared with the laws that ran, and what FC5's uncertain inputs do."""

from collections.abc import Iterable
from typing import NamedTuple

from demlaws import granite
from demlaws.errors import quiet
from demlaws.granite import MODULI, ROUGH_SPHERES, cone_claims, displacement_gained, find_test, sphere_claims, stiffness_at
from demlaws.granite.verdicts import Bench
from demlaws.laws import POHRT_POPOV
from demlaws.make import law


def granite_claims(tests: Iterable[str] | None = None):
    """Every claim of Altuhafi, Baudet & Coop 2023 that can be compared with a run; tests: those that concern one of these.

    The verdict is that with E* of the paper's text; `other_gives` and `other_verdict` are those with E/(2(1 - ν)).
    """
    with quiet():
        by_text, by_figures = (
            [claim for group in (*sphere_claims.GROUPS, *cone_claims.GROUPS) for claim in group(bench)]
            for bench in map(Bench, MODULI)
        )
    claims = [
        one if one[:4] == other[:4] else one._replace(other_gives=other.gives, other_verdict=other.verdict)
        for one, other in zip(by_text, by_figures, strict=True)
    ]
    return claims if tests is None else [c for c in claims if any(name in _concerned(c) for name in tests)]


def _concerned(claim):
    """Names of the tests that a claim concerns."""
    groups = {"rough spheres": ROUGH_SPHERES, "all spheres": [t.name for t in granite.TESTS[:5]]}
    names = [t.name for t in granite.TESTS]
    return groups.get(claim.test) or [n for n in names if n in claim.test or n.partition("(")[0] in claim.test.split(", ")]


# --- sensitivity of the cones


class Sensitivity(NamedTuple):
    """What an uncertain input of FC5 does to Pohrt-Popov."""

    radius: float  # [m]
    fractal_dimension: float
    displacement: float  # gained from 0.1 N to 7 N [m]
    stiffness: float  # at 7 N [N/m]
    threshold: float  # F [N]


def cone_sensitivity(modulus="text"):
    """FC5 with each radius that the paper measured (0.31, 0.35 mm by microscope, 0.62 by camera) and Df from 2.1 to 2.35."""
    base, rows = find_test("FC5", modulus), []
    with quiet():
        for radius in (0.31e-3, 0.35e-3, 0.62e-3):
            for dimension in (2.10, 2.22, 2.35):
                one = law(POHRT_POPOV, base.contact.with_values(radius=radius, fractal_dimension=dimension))
                displacement, stiffness = displacement_gained(one, 0.1, 7.0), stiffness_at(one, 7.0)
                threshold = float(one.force(1.0 / one.params.inverse_threshold))
                rows.append(Sensitivity(radius, dimension, displacement, stiffness, threshold))
    return rows
