"""Tables of the triaxial study: measured and simulated strain over cycles, effects in pairs of packings."""

import csv
from pathlib import Path
from typing import NamedTuple

import numpy as np

from demlaws.laws import HERTZ, POHRT_POPOV
from studies.paired import change, clear
from studies.triaxial.cycles import COLLAPSED, Case, case_of

MEASURED = Path(__file__).parent / "measured.csv"
SLOW = (5.0, 10.0)
"""Frequencies of the tests that are compared first [Hz]."""
USUAL = Case()
NUMBERS = (1, 10, 200, 500, 2000)


class Course(NamedTuple):
    """Permanent strain [%] after numbers of cycles, and the number of the cycle in which the sample collapsed, or NaN."""

    cycles: np.ndarray
    strain: np.ndarray
    collapsed: float = np.nan

    def at(self, cycle):
        """Strain after a cycle, between kept ones by interpolation in log N; NaN beyond the last."""
        inside = self.cycles[0] <= 1.05 * cycle and cycle <= 1.001 * self.cycles[-1]
        return float(np.interp(np.log(cycle), np.log(self.cycles), self.strain)) if inside else np.nan

    def exponent(self, first, last):
        """d of s ∝ N^d between two cycles; NaN for fewer than three points."""
        one = (self.cycles >= first) & (self.cycles <= last) & (self.strain > 0.0)
        if one.sum() < 3 or self.cycles[-1] < 0.9 * min(last, 1e4):
            return np.nan
        return float(np.polyfit(np.log(self.cycles[one]), np.log(self.strain[one]), 1)[0])


SHAPES = {
    **{f"s({number}) (%)": lambda one, number=number: one.at(number) for number in NUMBERS},
    "s(1)/s(200)": lambda one: one.at(1) / one.at(200),
    "d, 2 to 200": lambda one: one.exponent(2, 200),
    "s(200)/s(2000)": lambda one: one.at(200) / one.at(2000),
}
"""Of a course: the numbers that the criteria name."""


def measured(kind="axial", path=MEASURED):
    """(p, q [kPa], frequency [Hz]) → `Course` of the measured tests."""
    with open(path, newline="") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    found = {}
    for row in rows:
        if row["strain"] == kind:
            key = tuple(float(row[name]) for name in ("confining_pressure_kPa", "largest_deviator_kPa", "frequency_Hz"))
            found.setdefault(key, []).append((float(row["cycles"]), 100.0 * float(row["value"])))
    return {key: Course(*np.array(sorted(points)).T) for key, points in found.items()}


def simulated(rows, count=USUAL.count):
    """`Case` → `Course` of the cases with this number of grains."""
    found = {}
    for row in sorted(rows, key=lambda row: row["cycle"]):
        if row["count"] == count:
            found.setdefault(case_of(row), []).append(row)
    return {case: course(some) for case, some in found.items()}


def course(rows):
    """`Course` of the rows of a case; the row of a collapse has no load."""
    whole = [row for row in rows if not np.isnan(row["q_kPa"])]
    collapsed = rows[-1]["cycle"] if len(whole) < len(rows) else np.nan
    points = np.array([(row["cycle"], row["axial"]) for row in whole]).reshape(-1, 2)
    if not len(points):
        points = np.array([(1.0, np.nan)])
    return Course(*points.T, collapsed)


def name_of(case):
    """Law, roughness, edges; grains and friction other than the usual ones."""
    usual = USUAL
    words = [f"{case.law}" + (f", σ = {case.sigma:g} µm" if case.sigma else "")]
    words += [f"edges of {case.edge:g} mm"] * bool(case.edge)
    words += ["rule elastic"] * (case.rule != usual.rule)
    words += [case.grains] * (case.grains != usual.grains)
    words += [f"friction {case.friction:g}"] * (case.friction != usual.friction)
    return ", ".join(words)


def spans(values, digits=3):
    """Smallest to largest of numbers, or the one; – without one."""
    values = [value for value in values if not np.isnan(value)]
    if not values:
        return "–"
    low, high = (f"{value:.{digits}g}" for value in (min(values), max(values)))
    return low if low == high else f"{low} to {high}"


def groups(found):
    """(name, p, q) → courses of all packings."""
    together = {}
    for case, one in found.items():
        together.setdefault((name_of(case), case.p, case.q), []).append(one)
    return together


def table(rows, **settings):
    """Text: measured tests of a load, then the simulated ones, smallest to largest of the packings."""
    tests, simulations = measured(), groups(simulated(rows, **settings))
    heads = [*SHAPES, f"shorter by {100 * COLLAPSED:.0f} %"]
    lines = ["| p, q (kPa) | case | packings | " + " | ".join(heads) + " |", "|---" * (3 + len(heads)) + "|"]

    def line(load, name, courses, collapse):
        cells = [spans([function(one) for one in courses]) for function in SHAPES.values()]
        return f"| {load[0]:g}, {load[1]:g} | {name} | {len(courses)} | " + " | ".join([*cells, collapse]) + " |"

    for load in sorted({key[:2] for key in tests} | {key[1:] for key in simulations}, key=lambda load: (-load[0], load[1])):
        slow = [one for key, one in tests.items() if key[:2] == load and key[2] in SLOW]
        if slow:
            lines.append(line(load, "**measured**, 5 and 10 Hz", slow, "no"))
        for (name, *place), courses in simulations.items():
            if tuple(place) == load:
                ends = sorted(one.collapsed for one in courses if not np.isnan(one.collapsed))
                lines.append(line(load, name, courses, f"in cycle {', '.join(f'{end:g}' for end in ends)}" if ends else "no"))
    return "\n".join(lines)


SMOOTH, ROUGH = USUAL, Case(law=POHRT_POPOV, sigma=2.4)
CORNERS = Case(law="rough-plastic", sigma=2.4, edge=0.35)
EFFECTS = {
    "law: pohrt-popov, σ = 2.4 µm, for hertz": (SMOOTH, ROUGH),
    "the same with rule elastic": (SMOOTH, ROUGH._replace(rule="elastic")),
    "roughness: σ = 10 µm for 2.4 µm": (ROUGH, ROUGH._replace(sigma=10.0)),
    "edges of 0.35 mm that yield, for pohrt-popov": (ROUGH, CORNERS),
    "edges of 0.35 mm, hertz": (SMOOTH, CORNERS._replace(law=HERTZ, sigma=0.0)),
    "friction: 0.9 for 0.6, hertz": (SMOOTH, SMOOTH._replace(friction=0.9)),
    "friction: 0.9 for 0.6, edges that yield": (CORNERS, CORNERS._replace(friction=0.9)),
}
"""Change → cases before and after, of every packing."""
MEASURES = {
    "strain, N = 1": lambda one: one.at(1),
    "strain, N = 1 to 200": lambda one: one.at(200) - one.at(1),
}


def effects(rows, **settings):
    """Text: paired changes in percent with 95 % intervals; bold: clear among all of them (`studies.paired`)."""
    found, cells = simulated(rows, **settings), {}
    for what, (before, after) in EFFECTS.items():
        for name, function in MEASURES.items():
            pairs = [
                (function(found[case]), function(found[other]))
                for case in found
                if case == before._replace(seed=case.seed) and (other := after._replace(seed=case.seed)) in found
            ]
            pairs = [pair for pair in pairs if not np.isnan(pair).any()]
            cells[what, name] = change(*np.transpose(pairs)) if pairs else None
    bold = dict(zip(cells, clear(list(cells.values())), strict=True))
    lines = ["| change (%) | pairs | " + " | ".join(MEASURES) + " |", "|---" * (2 + len(MEASURES)) + "|"]
    for what in EFFECTS:
        some = [cells[what, name] for name in MEASURES]
        if any(some):
            texts = [shown(one, bold[what, name]) for name, one in zip(MEASURES, some, strict=True)]
            lines.append(f"| {what} | {max(one.samples for one in some if one)} | " + " | ".join(texts) + " |")
    return "\n".join(lines)


def shown(one, bold):
    """A change in percent with its interval."""
    if one is None:
        return "–"
    mean, low, high = (f"{100.0 * value:+.0f}" for value in one[:3])
    mean = f"**{mean}**" if bold else mean
    return mean if np.isnan(one.low) else f"{mean} ({low} to {high})"


def course_text(rows):
    """Text: pressures that were held, steps, time per cycle."""
    whole = [row for row in rows if row["cycle"] > 1 and not np.isnan(row["q_kPa"]) and row["count"] == USUAL.count]
    calm = [row for row in whole if row["axial"] < 1.0]
    off = 100.0 * np.array([row["side_off_kPa"] / row["p"] for row in calm])
    high = 100.0 * np.array([row["q_kPa"] / row["q"] - 1.0 for row in calm])
    each = [row["seconds"] for row in whole]
    return (
        f"below 1 % of strain: side pressure within {off.max():.1f} % of p, largest q within {abs(high).max():.1f} %; "
        f"{np.median(each):.2g} s per cycle (median)"
    )
