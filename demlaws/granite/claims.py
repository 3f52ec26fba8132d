"""Statements of Altuhafi, Baudet & Coop 2023 compared with the laws that ran."""

from collections.abc import Iterable

from demlaws import granite
from demlaws.errors import quiet
from demlaws.granite import MODULI, ROUGH_SPHERES, cone_claims, sphere_claims
from demlaws.granite.verdicts import Bench


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
