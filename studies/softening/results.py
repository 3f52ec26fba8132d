"""Errors of the runs of the study against the process as it is, as points and tables."""

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from demlaws.advice.soften import Softening
from studies.softening.study import DEEP, STRESS, Run, label, similar

FIRST = ("low", "loading", "unloading", "exponent", "coordination", "forces", "work")
OF_PROCESS = {"cycles": (*FIRST, "settlement"), "pour": ("height", "coordination", "forces"), "shear": ("peak", "coordination")}
"""Quantities that are compared. low, loading, unloading: tangent stiffness of the packing from a tenth to a fifth of the
stress, from half to all of it, and after the turn, times s^(2/3); exponent: of stiffness against stress, between the first two
(a difference); forces: largest difference of the quantiles of force over its mean; work: lost in the first cycle, and
settlement: from the first peak to the last, both over s^(2/3)."""
ABSOLUTE = ("exponent", "forces")  # compared by difference


def values(run: Run, row: dict) -> dict:
    """What a row says of the grains as they are: lengths, stiffness and work unstretched."""
    stretch, found = Softening(run.factor).overlap, dict(row)
    for name in found.keys() & {"low", "loading", "unloading"}:
        found[name] *= stretch
    for name in found.keys() & {"settlement", "put_in", "given_back"}:
        found[name] /= stretch
    if "put_in" in found:
        found["work"] = found["put_in"] - found["given_back"]
    return found


class Point(NamedTuple):
    """Copies of one way of running a process, against the process as it is."""

    run: Run  # copy 0
    errors: dict  # quantity → relative error (of `ABSOLUTE`: difference) of the mean over copies
    chance: dict  # quantity → standard deviation of one copy of the process as it is
    steps: float  # of loading and unloading once, rest and hold left out, or of all the process
    copies: int
    unbalanced: float | None  # largest force that does not balance over the mean force of a contact, while it moves


def _first(run):
    return run._replace(copy=0, cycles=1)


def points(rows: dict, others: bool = False) -> list[Point]:
    """A `Point` of every way that the rows hold, those of the process as it is among them; others: of the other scenes."""
    groups: dict = {}
    for run, row in rows.items():
        if "failed" not in row:
            groups.setdefault(_first(run), []).append((run, values(run, row)))
    result = []
    for first, found in groups.items():
        plain = Run("", "")
        other = any(getattr(first, n) != getattr(plain, n) for n in ("size", "rough", "scatter")) or (
            first.process == "cycles" and first.stress != STRESS
        )
        reference = groups.get(_first(first.reference)) if first.process == "cycles" else _base_of(groups, first)
        if other != others or not reference:
            continue
        loose = [v["unbalanced"] for _, v in found if "unbalanced" in v]
        unbalanced = float(np.mean(loose)) if loose else None
        one, compared = found[0][0]._replace(copy=0), _compare(first, found, reference)
        result.append(Point(one, *compared, _steps(first), len(found), unbalanced))
    return result


def _base_of(groups, run):
    """Of a pour or a shear the copies at full modulus and the slowest rate that was run."""
    alike = [r for r in groups if (r.process, r.engine, r.factor, r.part) == (run.process, run.engine, 1.0, 0.5)]
    return groups[min(alike, key=lambda r: r.inertial)] if alike else None


def _compare(run, found, reference):
    errors, chance = {}, {}
    for name in OF_PROCESS[run.process]:
        key = "quantiles" if name == "forces" else name
        longest = max((r.cycles for r, v in found if key in v), default=0)
        mine, base = (
            np.array([v[key] for r, v in rows if key in v and (name != "settlement" or r.cycles == longest)])
            for rows in (found, reference)
        )
        if not mine.size or not base.size:
            continue
        scale = 1.0 if name in ABSOLUTE else float(base.mean())
        error = (mine.mean(0) - base.mean(0)) / scale
        errors[name] = float(np.abs(error).max() if name == "forces" else error)
        if len(base) > 1:
            chance[name] = float(np.max(np.std(base, axis=0, ddof=1))) / abs(scale)
    return errors, chance


def _steps(run):
    """Steps of the process: of an oedometer those in which the plate moves, once down to the stress and back."""
    told = run.given()
    if run.process == "pour":
        return told["time"] / told["dt"]
    if run.process == "shear":
        return told["strain"] * DEEP / told["speed"] / told["dt"]
    return 1.5 * run.sunk / told["speed"] / told["dt"]


def worst(point: Point) -> float:
    """Largest error of the packing's stiffness (of a pour: of its height, of shear: of the peak strength)."""
    stiffness = [abs(e) for name, e in point.errors.items() if name in ("low", "loading", "unloading")]
    first = abs(point.errors.get(OF_PROCESS[point.run.process][0], math.nan))
    return max(stiffness, default=first)


def _cell(name, value, sign="+"):
    if value is None:
        return "-"
    return f"{value:{sign}.3f}" if name in ABSOLUTE else f"{100 * value:{sign}.1f}%"


def rows_of_points(found: list[Point]) -> Iterator[dict]:
    """Rows of a table: errors in per cent (exponent and forces: as they are), and the scatter of one copy."""
    for key in sorted({(p.run.engine, p.run.process) for p in found}):
        own = sorted((p for p in found if (p.run.engine, p.run.process) == key), key=lambda p: p.steps)
        names = [n for n in OF_PROCESS[key[1]] if any(n in p.errors for p in own)]
        table = f"{key[1]} in {key[0]}"
        for p in own:
            cells = {n: _cell(n, p.errors.get(n)) for n in names}
            cells["unbalanced"] = "-" if p.unbalanced is None else f"{p.unbalanced:.1g}"
            yield {"table": table, "case": label(p.run), "κ": f"{p.run.kappa:.0f}", "steps": f"{p.steps:.0f}", **cells}
        chance = {n: _cell(n, next((p.chance[n] for p in own if n in p.chance), None), sign="") for n in names}
        yield {"table": table, "case": "chance (one copy at full modulus)", **chance}


class Similar(NamedTuple):
    """Grains of a tenth of the modulus against those as they are, from starts that differ in chance only."""

    run: Run  # softened, copy 0
    deviation: dict  # quantity of `FIRST` → relative difference (exponent: difference) of the means over copies
    chance: dict  # quantity → standard deviation of the difference of two copies, one of each

    @property
    def worst(self) -> float:
        """The largest deviation over its chance."""
        return max(abs(self.deviation[n]) / self.chance[n] for n in self.deviation)


def similarity(rows: dict) -> list[Similar]:
    """A `Similar` of every stress, start and way of `similar` that the rows hold; the quantiles of force are left out."""
    groups: dict = {}
    for run in similar():
        if run in rows and "failed" not in rows[run]:
            groups.setdefault(run._replace(copy=0), []).append(values(run, rows[run]))
    found = []
    for run, soft in groups.items():
        hard = groups.get(run.reference)
        if run.factor == 1.0 or not hard or min(len(soft), len(hard)) < 2:
            continue
        deviation, chance = {}, {}
        for name in FIRST:
            if name == "forces":
                continue
            mine, base = (np.array([v[name] for v in copies]) for copies in (soft, hard))
            scale = 1.0 if name in ABSOLUTE else float(base.mean())
            deviation[name] = (float(mine.mean()) - float(base.mean())) / scale
            chance[name] = math.hypot(np.std(mine, ddof=1), np.std(base, ddof=1)) / abs(scale)
        found.append(Similar(run, deviation, chance))
    return found


def rows_of_similarity(found: list[Similar]) -> Iterator[dict]:
    """Rows of a table: deviation ± chance, in per cent (exponent: as it is)."""
    for one in sorted(found, key=lambda s: (s.run.scatter == 0.0, not s.run.scaled, -s.run.stress)):
        cells = {"overlap/d": f"{one.run.depth:.2g}"}
        for n, d in one.deviation.items():
            c = one.chance[n]
            cells[n] = f"{d:+.3f} ± {c:.3f}" if n in ABSOLUTE else f"{100 * d:+.1f} ± {100 * c:.1f} %"
        start = "lattice, gaps scaled" if one.run.scatter else "packing, gaps as they are"
        way = f"{start}, σ {'scaled' if one.run.scaled else 'alone'}, {one.run.stress / 1e3:g} kPa"
        yield {"table": "E/10 against E, chance behind ±", "case": way, **cells}
