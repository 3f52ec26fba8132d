"""Statements of a paper: records, their criteria, and the verdict that computed numbers give.

The tolerances are ours: "around", "similar" and "nearly" are within 10 %.
"""

import math
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple

REPRODUCED, NOT_REPRODUCED = "reproduced", "not reproduced"
UNDECIDED, BUILT_IN = "cannot be decided", "built in"
VERDICTS = (REPRODUCED, NOT_REPRODUCED, BUILT_IN, UNDECIDED)
NEAR = 0.1
"""Relative difference of numbers that a paper calls near, similar or about the same."""


class Criterion(NamedTuple):
    """When a statement counts as reproduced: every number is in a range; or why numbers do not decide it.

    Examples
    --------
    >>> near(73.0).verdict({"crossover": 71.8}), near(73.0).verdict({"crossover": 57.5})
    ('reproduced', 'not reproduced')
    """

    low: float = -math.inf
    high: float = math.inf
    reason: str = ""
    fixed: str = ""  # BUILT_IN or UNDECIDED, whatever the numbers are

    def verdict(self, numbers: Mapping[str, float]) -> str:
        """The verdict on these numbers; NaN is in no range."""
        return self.fixed or (REPRODUCED if all(self.low <= n <= self.high for n in numbers.values()) else NOT_REPRODUCED)

    def __str__(self) -> str:
        if self.fixed:
            return self.reason
        ends = {"at least": self.low, "at most": self.high}
        text = " and ".join(f"{word} {end:.4g}" for word, end in ends.items() if math.isfinite(end))
        return f"{text}: {self.reason}" if self.reason else text


def near(value: float) -> Criterion:
    """Within `NEAR` of a printed number."""
    return Criterion(value * (1.0 - NEAR), value * (1.0 + NEAR), f"within {NEAR:.0%} of {value:g}")


def built_in(reason: str) -> Criterion:
    """True because of the chosen law, rule or parameter."""
    return Criterion(reason=reason, fixed=BUILT_IN)


def undecided(reason: str = "the measured points are not public") -> Criterion:
    """Neither a run nor the paper's own numbers decide it."""
    return Criterion(reason=reason, fixed=UNDECIDED)


class Claim(NamedTuple):
    """A statement of a paper, the quantity that tests it, and the criterion."""

    place: str  # in the paper
    test: str  # tests that it concerns
    statement: str
    quantity: str  # name of the numbers, with their unit
    numbers: Callable[[Any], Mapping[str, float]] | None  # of the source of laws: label → number
    criterion: Criterion


class Judged(NamedTuple):
    """A claim with its numbers and verdict, and with those by another value of E* where they differ."""

    place: str
    test: str
    claim: str
    gives: str
    verdict: str
    criterion: str
    other_gives: str = ""
    other_verdict: str = ""


def judge(claims: Iterable[Claim], source: Any, other: Any = None) -> list[Judged]:
    """Every claim with the numbers of a source of laws, and with those of another."""
    found = []
    for claim in claims:
        results = []
        for laws in (source,) if other is None else (source, other):
            numbers = claim.numbers(laws) if claim.numbers else {}
            text = ", ".join(f"{label} {number:.4g}".strip() for label, number in numbers.items())
            results.append((f"{claim.quantity}: {text}" if text else claim.quantity, claim.criterion.verdict(numbers)))
        second = results[1] if len(results) > 1 and results[1] != results[0] else ()
        found.append(Judged(*claim[:3], *results[0], str(claim.criterion), *second))
    return found


def counts(verdicts: Iterable[str]) -> str:
    """Number of each verdict, as text."""
    found = Counter(verdicts)
    return "; ".join(f"{found[verdict]} {verdict}" for verdict in VERDICTS)
