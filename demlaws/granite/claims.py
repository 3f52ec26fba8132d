"""Statements of the papers compared with the laws that ran: four verdicts, and the numbers behind each.

A sentence about measured data could be decided by measured points alone, which are not public; a sentence that a rule or a
chosen parameter makes true is built in, and says nothing for or against the law. Criteria are those of a reader of the paper's
text and figures: "around" is within 10 %, similar lines of a double logarithmic figure are within a tenth of a decade.
"""

from collections.abc import Iterable
from typing import NamedTuple

from demlaws import granite
from demlaws.errors import quiet
from demlaws.granite import MODULI, ROUGH_SPHERES, bind, displacement_gained, find_test, run_test, stiffness_at
from demlaws.laws import POHRT_POPOV
from demlaws.make import law

REPRODUCED, NOT_REPRODUCED = "reproduced", "not reproduced"
UNDECIDED, BUILT_IN = "cannot be decided without measured points", "built in"
AROUND = 0.1
"""Relative difference from a number that the paper calls "around" or "about"."""
SIMILAR = 10.0**0.1
"""Ratio of two stiffnesses whose lines in a double logarithmic figure are a tenth of a decade apart."""


class Claim(NamedTuple):
    """One sentence of a paper, what the run gives, and the verdict."""

    test: str
    claim: str
    gives: str
    verdict: str
    criterion: str = ""  # of the verdict: when the claim counts as reproduced, or why it is built in or cannot be decided
    other_gives: str = ""  # with E* = 40.4 GPa, which the printed numbers fit; "": the same
    other_verdict: str = ""


class Bench:
    """The tests with one E*, and laws and runs on them, each made once."""

    def __init__(self, modulus="text"):
        self.modulus, self._laws, self._runs = modulus, {}, {}

    def test(self, name):
        """A test."""
        return find_test(name, self.modulus)

    def __call__(self, name, test):
        """A law on a test of this name."""
        if (name, test) not in self._laws:
            self._laws[name, test] = bind(name, self.test(test))
        return self._laws[name, test]

    def run(self, name, test):
        """A law through the stages of a test of this name."""
        if (name, test) not in self._runs:
            self._runs[name, test] = run_test(name, self.test(test))[0]
        return self._runs[name, test]


def verdict_of(holds):
    """REPRODUCED or NOT_REPRODUCED."""
    return REPRODUCED if holds else NOT_REPRODUCED


def around(value, printed):
    """Whether a value is within AROUND of a printed number."""
    return abs(value / printed - 1.0) <= AROUND


def open_claim(test, claim, gives, *tests, why="it is about measured points"):
    """A claim about measured points of these tests."""
    missing = f"no points of {', '.join(tests)}"
    return Claim(test, claim, "; ".join(filter(None, (gives, missing))), UNDECIDED, why)


def granite_claims(tests: Iterable[str] | None = None):
    """Every claim of Altuhafi, Baudet & Coop 2023 that can be compared with a run; tests: those that concern one of these.

    The verdict is that with E* of the paper's text; `other_gives` and `other_verdict` are those with E/(2(1 - ν)).
    """
    from demlaws.granite.cone_claims import GROUPS as CONES
    from demlaws.granite.sphere_claims import GROUPS as SPHERES

    with quiet():
        by_text, by_figures = (
            [claim for group in (*SPHERES, *CONES) for claim in group(bench)] for bench in map(Bench, MODULI)
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
