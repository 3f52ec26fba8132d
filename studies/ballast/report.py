"""Settlement, resilient modulus and loss per cycle from the rows of `cycles`: tables and picture."""

from functools import partial
from typing import NamedTuple

import numpy as np

from demlaws.files import save_csv
from demlaws.laws import HERTZ, POHRT_POPOV
from studies.assembly.report import spread
from studies.ballast.bed import DENSITY
from studies.ballast.cycles import SENSITIVITY, Case, case_of
from studies.paired import change, clear

LONGEST = 200
"""Cycles of the cases in the tables; one case has more."""
EXPONENTS = np.linspace(0.001, 0.999, 999)
MEAN = 40e-3  # diameter of a mean grain [m]
KEY = ("grains", "law", "sigma", "shear", "rule")


class Kind(NamedTuple):
    """What the beds of one line of the table share."""

    grains: str
    law: str
    sigma: float
    shear: str
    rule: str

    def __str__(self):
        rough = f", σ = {self.sigma:g} µm" if self.sigma else ""
        return f"{self.grains}, {self.law}{rough}, {self.shear}" + ", rule elastic" * (self.rule == "elastic")


def kind_of(case):
    """`Kind` of a case."""
    return Kind(*(getattr(case, name) for name in KEY))


def order(kind):
    """Spheres first, smooth first, then by roughness and shear model."""
    return kind.grains != "spheres", kind.sigma, kind.shear


def series(rows, least=30, most=LONGEST, **settings):
    """`Kind` → seed → rows in order of the cycle, of cases with these settings (default: those of `Case`)

    and `least` to `most` cycles; of two cases of a seed the longer one.
    """
    wanted, found = {name: getattr(Case(), name) for name in ("period", "dt", "count")} | settings, {}
    for row in sorted(rows, key=lambda row: (row["cycles"], row["cycle"])):
        if least <= row["cycles"] <= most and all(row[name] == value for name, value in wanted.items()):
            beds = found.setdefault(Kind(*(row[name] for name in KEY)), {})
            beds.setdefault(int(row["seed"]), {}).setdefault(row["cycles"], []).append(row)
    return {
        kind: {seed: list(cases.values())[-1] for seed, cases in sorted(found[kind].items())}
        for kind in sorted(found, key=order)
    }


def longest(rows):
    """Seed → rows in order of the cycle of the beds with the most cycles."""
    most, found = max((row["cycles"] for row in rows), default=0), {}
    for row in sorted(rows, key=lambda row: (row["seed"], row["cycle"])):
        if row["cycles"] == most:
            found.setdefault(int(row["seed"]), []).append(row)
    return found


def main_cycles(rows):
    """Number and settlement [µm] of the cycles between 20 and 200 kPa."""
    chosen = [row for row in rows if row["cycle"] <= row["cycles"]]
    return np.array([[row["cycle"], row["settlement_um"]] for row in chosen]).T


class Fit(NamedTuple):
    """s = a + b log10 N and s = c N^d over some cycles; rms deviations over the last settlement."""

    constant: float  # a [µm]
    slope: float  # b [µm per decade]
    logarithmic: float
    factor: float  # c [µm]
    exponent: float  # d
    power: float

    def at(self, number):
        """Both settlements [µm] after this many cycles."""
        return self.constant + self.slope * np.log10(number), self.factor * np.asarray(number) ** self.exponent


def fit(rows, last=np.inf):
    """`Fit` of a bed over cycles 2 to `last`."""
    number, settled = main_cycles(rows)
    number, settled = number[(number > 1) & (number <= last)], settled[(number > 1) & (number <= last)]
    slope, constant = np.polyfit(np.log10(number), settled, 1)

    def factor(exponent):
        shape = number**exponent
        return shape @ settled / (shape @ shape)

    best = min(EXPONENTS, key=lambda exponent: np.sum((settled - factor(exponent) * number**exponent) ** 2))
    found = Fit(float(constant), float(slope), 0.0, float(factor(best)), float(best), 0.0)
    off = [float(np.sqrt(np.mean((settled - law) ** 2)) / settled[-1]) for law in found.at(number)]
    return found._replace(logarithmic=off[0], power=off[1])


def moduli(rows):
    """Largest pressure [kPa] and resilient modulus [MPa] of the last cycle of each stage."""
    last = {row["high_kPa"]: row for row in rows if row["cycle"] > row["cycles"]}
    found = [
        (row["peak_kPa"], (row["peak_kPa"] - row["least_kPa"]) * row["height_mm"] / row["resilient_um"])
        for row in last.values()
    ]
    return np.array(found).T


def modulus_exponent(rows):
    """n of M ∝ p^n."""
    return float(np.polyfit(*np.log(moduli(rows)), 1)[0])


def tangent_exponent(rows):
    """m of a tangent modulus ∝ p^m with the strains of the last cycles of all stages, ∝ p^(1-m) - p0^(1-m).

    M has a smaller exponent, because it is a secant from p0 = 20 kPa.
    """
    last = {row["high_kPa"]: row for row in rows if row["cycle"] > row["cycles"]}.values()
    peak, least, strain = (np.array([row[name] for row in last]) for name in ("peak_kPa", "least_kPa", "resilient_um"))
    off = [np.std(np.log((peak ** (1 - m) - least ** (1 - m)) / strain)) for m in EXPONENTS]
    return float(EXPONENTS[np.argmin(off)])


def settlement(rows, cycle):
    """Settlement [µm] after a cycle (between kept ones by interpolation in log N); NaN beyond the last."""
    number, settled = main_cycles(rows)
    return float(np.interp(np.log(cycle), np.log(number), settled)) if cycle <= number[-1] else np.nan


class Dissipation(NamedTuple):
    """Energy that a cycle dissipates [mJ], and shares [%] of friction, plastic flow and damping in it."""

    total: float
    friction: float
    plastic: float
    damping: float
    of_work: float  # total over the work of loading


def dissipation(rows, first=15, last=30):
    """Mean `Dissipation` of the kept cycles from `first` to `last`; the models of LAMMPS do not book friction: NaN."""
    chosen = [
        row for row in rows if first <= row["cycle"] <= min(last, row["cycles"]) and not np.isnan(row.get("rest_J", np.nan))
    ]
    if not chosen:
        return Dissipation(*[np.nan] * 5)
    inside, plastic, rest, work = (
        np.mean([row[f"{name}_J"] for row in chosen]) for name in ("dissipated", "plastic", "rest", "work")
    )
    total = inside + rest
    known = np.nan if chosen[0]["shear"] in STOCK else 1.0
    shares = (100.0 * part / total for part in (known * (inside - plastic), plastic, known * rest))
    return Dissipation(1e3 * float(total), *map(float, shares), float(total / work))


def secant(rows, cycle):
    """Resilient modulus [MPa] of a cycle between 20 and 200 kPa."""
    (row,) = (row for row in rows if row["cycle"] == cycle)
    return (row["peak_kPa"] - row["least_kPa"]) * row["height_mm"] / row["resilient_um"]


def inertial(rows):
    """Largest inertial number of cycles 2 and later: rate of strain × d √(ρ/p), both amid a swing of the load."""
    return max(
        np.pi
        * row["resilient_um"]
        * 1e-3
        / row["height_mm"]
        / row["period"]
        * MEAN
        * np.sqrt(DENSITY / (500.0 * row["high_kPa"]))
        for row in rows
        if row["cycle"] > 1
    )


def seconds(rows):
    """Time [s] of all cycles of a bed."""
    cycle, each = np.array([(row["cycle"], row["seconds"]) for row in rows]).T
    return float(np.sum(np.diff(cycle, prepend=0.0) * each))


STOCK = ("mindlin",)
"""Shear models whose friction `compute demlaws/energy` does not have."""
COLUMNS = {
    **{f"settled (µm), N = {number}": partial(settlement, cycle=number) for number in (1, 18, 30, 100, 200)},
    "settled (µm), last": lambda rows: main_cycles(rows)[1][-1],
    "a + b log N: b (µm)": lambda rows: fit(rows).slope,
    "off (%)": lambda rows: 100.0 * fit(rows).logarithmic,
    "N^d: d": lambda rows: fit(rows).exponent,
    "off, %": lambda rows: 100.0 * fit(rows).power,
    "M (MPa)": lambda rows: moduli(rows)[1][-1],
    "M (MPa), N = 18": partial(secant, cycle=18),
    "n": modulus_exponent,
    "m": tangent_exponent,
    "dissipated in cycle 1 (mJ)": lambda rows: dissipation(rows, 1, 1).total,
    "plastic flow in cycle 1 (%)": lambda rows: dissipation(rows, 1, 1).plastic,
    "dissipated later (mJ)": lambda rows: dissipation(rows).total,
    "over work": lambda rows: dissipation(rows).of_work,
    "friction (%)": lambda rows: dissipation(rows).friction,
    "plastic flow (%)": lambda rows: dissipation(rows).plastic,
    "damping (%)": lambda rows: dissipation(rows).damping,
    "over work, N = 9 to 18": lambda rows: dissipation(rows, 9, 18).of_work,
    "inertial number": inertial,
    "steps per cycle": lambda rows: rows[-1]["steps"],
    "time (s)": seconds,
}
"""Of each bed; later: cycles 15 to 30."""


def measures(last=LONGEST):
    """Name → function of the rows of a bed with `last` cycles: the columns of the tables."""
    return {
        "settlement, N = 1 (µm)": lambda rows: settlement(rows, 1),
        f"N = 1 to {last} (µm)": lambda rows: settlement(rows, last) - settlement(rows, 1),
        "M (MPa)": COLUMNS["M (MPa)"],
        "n": modulus_exponent,
        "dissipated in cycle 1 (mJ)": COLUMNS["dissipated in cycle 1 (mJ)"],
        "later (mJ)": COLUMNS["dissipated later (mJ)"],
    }


MEASURES = measures()


def cell(values):
    """Mean ± standard deviation, three digits."""
    mean, deviation = spread(value for value in values if not np.isnan(value))
    if np.isnan(mean):
        return "–"
    if mean == 0.0:
        return "0"
    digits = max(0, 2 - int(np.floor(np.log10(abs(mean)))))
    return f"{mean:.{digits}f}" + ("" if np.isnan(deviation) else f" ± {deviation:.{digits}f}")


def table(rows, **settings):
    """Text: a line per kind of bed."""
    lines = ["| bed | seeds | " + " | ".join(MEASURES) + " |", "|---" * (2 + len(MEASURES)) + "|"]
    for kind, beds in series(rows, **settings).items():
        cells = [cell([function(one) for one in beds.values()]) for function in MEASURES.values()]
        lines.append(f"| {kind} | {len(beds)} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def runs(rows):
    """`Case` → rows in order of the cycle, sorted by kind, cycles and settings."""
    found = {}
    for row in sorted(rows, key=lambda row: row["cycle"]):
        found.setdefault(case_of(row), []).append(row)

    def place(case):
        return order(kind_of(case)), -case.cycles, case.seed, case.period, case.dt

    return {case: found[case] for case in sorted(found, key=place)}


SETTINGS = {(case.period, case.dt): name for name, case in SENSITIVITY.items()}


def save(rows, again, path):
    """Write the numbers of every bed, and of its repetition `again`, to a CSV file; its path."""
    lines = []
    for some, repeated in ((rows, ""), (again, ", repetition")):
        for case, one in runs(some).items():
            numbers = (f"{function(one):.4g}".replace("nan", "") for function in COLUMNS.values())
            about = (str(getattr(case, name)) for name in (*KEY, "seed", "cycles"))
            lines.append([SETTINGS[case.period, case.dt] + repeated, *about, *numbers])
    return save_csv(path, ["settings", *KEY, "seed", "cycles", *COLUMNS], lines)


BASE = Kind("spheres", HERTZ, 0.0, "default", "hertz")
ROUGH = BASE._replace(law=POHRT_POPOV, sigma=2.4)
CLUMPS, ROUGH_CLUMPS = (kind._replace(grains="clumps") for kind in (BASE, ROUGH))


def _sheared(model):
    return tuple((kind, kind._replace(shear=model)) for kind in (BASE, ROUGH))


EFFECTS = {
    "law: pohrt-popov, σ = 2.4 µm, for hertz": ((BASE, ROUGH),),
    "the same, clumps": ((CLUMPS, ROUGH_CLUMPS),),
    "roughness: σ = 10 µm for 2.4 µm": ((ROUGH, ROUGH._replace(sigma=10.0)),),
    "roughness: σ = 0.5 µm for 2.4 µm": ((ROUGH, ROUGH._replace(sigma=0.5)),),
    "shear: mindlin for default, both laws": _sheared("mindlin"),
    "shear: slip for default, both laws": _sheared("slip"),
    "shape: clumps for spheres, hertz": ((BASE, CLUMPS),),
    "shape: clumps for spheres, pohrt-popov": ((ROUGH, ROUGH_CLUMPS),),
}
"""Change → pairs of kinds, before and after."""


def _controls(grains, smooth, rough):
    elastic = rough._replace(rule="elastic")
    return {
        f"{grains}: σ = 2.4 µm for smooth, rule hertz": ((smooth, rough),),
        f"{grains}: σ = 2.4 µm for smooth, rule elastic": ((smooth, elastic),),
        f"{grains}, σ = 2.4 µm: rule hertz for elastic": ((elastic, rough),),
    }


CONTROL = _controls("spheres", BASE, ROUGH) | _controls("clumps", CLUMPS, ROUGH_CLUMPS)
"""The same of the beds of `cycles.control`."""


def effect(found, pairs, function):
    """`Estimate` of the relative change of a number between pairs of kinds, over beds of the same seeds, or None."""
    values = []
    for kinds in pairs:
        before, after = (found.get(kind, {}) for kind in kinds)
        values += [[function(beds[seed]) for beds in (before, after)] for seed in sorted(before.keys() & after.keys())]
    return change(*np.transpose(values)) if values and not np.isnan(values).any() else None


def effects(rows, changes=EFFECTS, last=LONGEST):
    """Text: paired changes in percent with 95 % intervals, of beds with `last` cycles; bold: clear among all of the table."""
    found, numbers = series(rows), measures(last)
    heads = [name.split(" (")[0] for name in numbers]
    lines = ["| change (%) | pairs | " + " | ".join(heads) + " |", "|---" * (2 + len(numbers)) + "|"]
    estimates = [[effect(found, pairs, function) for function in numbers.values()] for pairs in changes.values()]
    bold = clear([one for row in estimates for one in row]).reshape(len(changes), len(numbers))
    for what, row, marks in zip(changes, estimates, bold, strict=True):
        if any(row):
            pairs = max(one.samples for one in row if one)
            lines.append(f"| {what} | {pairs} | " + " | ".join(map(_cell, row, marks)) + " |")
    return "\n".join(lines)


def _cell(one, bold):
    """Text of an `Estimate` of a relative change in percent."""
    if one is None:
        return "–"
    mean, low, high = (f"{100.0 * value:+.0f}" for value in one[:3])
    mean = f"**{mean}**" if bold else mean
    return mean if np.isnan(one.low) else f"{mean} ({low} to {high})"


def course(rows):
    """Text: inertial number, load carried, time per cycle."""
    carried = [np.median([row[name] for row in rows if row["high_kPa"] == 200.0]) for name in ("least_kPa", "peak_kPa")]
    each = [row["seconds"] for row in rows if row["cycle"] > 1]
    text = f"inertial number at most {inertial(rows):.1g}; {np.median(each):.2g} s per cycle (median, {min(each):.2g} to"
    return f"{text} {max(each):.2g}); the plate carries {carried[0]:.0f} to {carried[1]:.0f} kPa (median)"


def many(rows):
    """Text: both laws of settlement, fitted to the first and to all cycles of the longest cases."""
    lines = [
        "| seed | fitted to cycles | a + b log N: b (µm) | off (%) | last (µm) | N^d: d | off, % | last, µm | measured (µm) |",
        "|---" * 9 + "|",
    ]
    for seed, one in longest(rows).items():
        last = main_cycles(one)[0][-1]
        for end in (30.0, LONGEST, last):
            law = fit(one, end)
            ends = law.at(last)
            logarithmic = f"{law.slope:.0f} | {100 * law.logarithmic:.1f} | {ends[0]:.0f}"
            power = f"{law.exponent:.3f} | {100 * law.power:.1f} | {ends[1]:.0f}"
            lines.append(f"| {seed} | 2 to {end:.0f} | {logarithmic} | {power} | {settlement(one, last):.0f} |")
    return "\n".join(lines)
