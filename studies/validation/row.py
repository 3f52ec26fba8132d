"""One row of the report: a number that somebody else wrote, and ours."""

import csv
import json
import math
from pathlib import Path
from typing import NamedTuple

PYTHON = "Python"
"""Where a row is computed, if in no engine."""


class Row(NamedTuple):
    """A found value passes from `low` to `high`; `found` is NaN where the row could not be run, and `note` says why."""

    what: str
    where: str  # "Python" or the engine
    expected: str  # as printed
    low: float
    high: float
    found: float
    source: str  # key of SOURCES
    unit: str = ""
    note: str = ""

    @property
    def verdict(self):
        """pass, FAIL, or not run."""
        if math.isnan(self.found):
            return "not run"
        return "pass" if self.low <= self.found <= self.high else "FAIL"


def near(what, expected, found, tolerance, source, *, where=PYTHON, unit="", note=""):
    """A row that passes within a relative `tolerance` of `expected`."""
    width, digits = abs(expected) * tolerance, 7 if tolerance > 1e-9 else 15
    text = f"{expected:.{digits}g} ± {tolerance:g}"
    return Row(what, where, text, expected - width, expected + width, float(found), source, unit, note)


def between(what, low, high, found, source, *, where=PYTHON, unit="", note=""):
    """A row that passes from `low` to `high`."""
    return Row(what, where, f"{low:g} to {high:g}", low, high, float(found), source, unit, note)


def missing(what, where, expected, source, why):
    """A row that could not be run."""
    return Row(what, where, expected, math.nan, math.nan, math.nan, source, "", why)


_, _, _, EQUATIONS, METHODS = KINDS = (
    "Measured by others",
    "Computed by others' codes",
    "Printed in papers",
    "Our evaluation of printed equations",
    "Our other methods",
)
"""Whose answer a row is compared with, the strongest first."""


class Source(NamedTuple):
    """Who gave the answer, under what terms it is quoted, and whose answer it is (one of KINDS)."""

    kind: str
    licence: str
    text: str


with open(Path(__file__).with_name("sources.csv"), newline="", encoding="utf-8") as _file:
    SOURCES = {row.pop("key"): Source(**row) for row in csv.DictReader(_file)}
NUMBERS = {name: one["rows"] for name, one in json.loads(Path(__file__).with_name("published.json").read_text()).items()}
"""Tables of published numbers; published.json has a description and column titles of each."""
