"""Claims about the granite tests: verdicts, and the laws and runs that they are about.

A sentence about measured data could be decided by measured points alone, which are not public; a sentence that a rule or a
chosen parameter makes true is built in, and says nothing for or against the law. Criteria are those of a reader of the paper's
text and figures: "around" is within 10 %, similar lines of a double logarithmic figure are within a tenth of a decade.
"""

from collections import Counter
from typing import NamedTuple

from demlaws.granite import bind, find_test, run_test

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


class Bench(NamedTuple):
    """The tests with one E*, and laws and runs on them."""

    modulus: str

    def test(self, name):
        """A test."""
        return find_test(name, self.modulus)

    def __call__(self, name, test):
        """A law on a test of this name."""
        return bind(name, self.test(test))

    def run(self, name, test):
        """A law through the stages of a test of this name."""
        return run_test(name, self.test(test))[0]


def counts(verdicts):
    """How many there are of each verdict, as text."""
    found = Counter(verdicts)
    return "; ".join(f"{found[verdict]} {verdict}" for verdict in (REPRODUCED, NOT_REPRODUCED, BUILT_IN, UNDECIDED))


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
