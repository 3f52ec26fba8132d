"""The curves that `demlaws.advice.modulus` predicts from, fitted to the rows of the study in YADE."""

import math

import numpy as np

from demlaws.advice.modulus import HALF, MEASURED, STEADY, PackingNumbers, numbers_of
from demlaws.advice.scene import Scene
from demlaws.contact import GRANITE
from demlaws.errors import DemlawsError
from studies.softening import results, study


def error_curve(pairs: list) -> list:
    """([knob], [error]) of (knob, error) pairs: rises with the knob and lies above all of them; inner points of level parts
    are left out."""
    largest: dict = {}
    for x, e in pairs:
        if x > 0.0 and e > 0.0:
            largest[x] = max(e, largest.get(x, 0.0))
    if not largest:
        raise DemlawsError("the study has no rows to fit a curve to: python -m studies.trade --softening FILE makes them")
    place, error = np.array(sorted(largest.items())).T
    error = np.maximum.accumulate(error)
    level = np.diff(error) == 0.0
    inner = np.r_[False, level] & np.r_[level, False]
    return [[float(f"{v:.4g}") for v in column[~inner]] for column in (place, error)]


def fitted(rows: dict) -> dict:
    """Process → quantities of the study, joined by + → curves and the scatter of one copy, as `modulus.curves` reads them."""
    found: dict = {}
    for process, quantities in MEASURED.items():
        known = _Process(process, rows)
        found[process] = {"unbalanced": error_curve(known.unbalanced)} if known.unbalanced else {}
        for names in quantities.values():
            for some in (names, tuple(n for n in names if n != "unloading")):
                found[process]["+".join(some)] = known.curves(some)
    return found


class _Process:
    """The study's runs in YADE of one process: those of its own packing, and of other scenes."""

    def __init__(self, process, rows):
        self.process, self.pressed = process, process == "oedometer"
        self.points = {
            (p.run.factor, p.run.inertial, p.run.part): p
            for p in results.points(rows)
            if (p.run.engine, p.run.process) == ("yade", "cycles" if self.pressed else process)
            and (p.run.law, p.run.unloading, p.run.density) == (*study.STUDIED, 1.0)
            and (p.run.scaled or p.run.factor == 1.0)
        }
        self.others = results.points(rows, others=True) if self.pressed else []
        loose = [p for p in self.points.values() if p.run.part == HALF and p.unbalanced is not None]
        self.unbalanced = [(self.place(p.run), p.unbalanced) for p in loose]

    def place(self, run):
        """What the error of a rate is over."""
        return run.inertial * math.sqrt(_numbers(run).kappa) if self.pressed else run.inertial

    def curves(self, names):
        """Curves of the largest error among `names`."""
        if (1.0, STEADY, HALF) not in self.points:
            raise DemlawsError(f"the study has no run of {self.process} at full modulus")
        plain = self.points[1.0, STEADY, HALF]
        geometry, rate, soft, step = [], [], [], []
        for (factor, inertial, part), p in self.points.items():
            steady = self.points.get((factor, STEADY, HALF))
            if part == HALF and inertial == STEADY and factor > 1.0:
                geometry.append((_numbers(p.run).depth, _change(names, p, plain)))
            elif part == HALF and inertial > STEADY and steady is not None:
                (rate if factor == 1.0 else soft).append((self.place(p.run), _change(names, p, steady)))
            elif part > HALF and (factor, inertial) == (1.0, STEADY):
                step.append((part, _change(names, p, plain)))
        for p in self.others:  # the scenes that are held back test the predictions
            if p.run in study.FITTED_ON and p.run.scaled and p.run.part == HALF:
                if p.run.factor > 1.0 and p.run.inertial == STEADY:
                    geometry.append((_numbers(p.run).depth, _change(names, p)))
                elif p.run.factor == 1.0 and p.run.inertial > STEADY:
                    rate.append((self.place(p.run), _change(names, p)))
        pairs = {"geometry": geometry, "step": step}
        if self.process != "pour":
            pairs |= {"rate": rate, "soft_rate": soft}
        chance = max((plain.chance[n] for n in names if n in plain.chance), default=0.0)
        return {**{name: error_curve(one) for name, one in pairs.items() if one}, "chance": float(f"{chance:.4g}")}


def _change(names, point, other=None):
    """Largest error of a point against another one (None: against the process as it is)."""
    known = [n for n in names if n in point.errors]
    if len(known) < len(names):  # so fast that a stress is passed between two looks: nothing is right
        return 1.0
    if other is None:
        return max(abs(point.errors[n]) for n in known)
    return max(
        abs(point.errors[n] - other.errors[n])
        if n in results.ABSOLUTE
        else abs((1.0 + point.errors[n]) / (1.0 + other.errors[n]) - 1.0)
        for n in known
    )


def _numbers(run) -> PackingNumbers:
    radii, pressure = run.size * 4e-3, (0.1 * run.stress, run.stress)
    scene = Scene(radii=radii, materials=GRANITE, surfaces=run.surface, pressure=pressure, quantity="stiffness")
    return numbers_of(scene, run.law, {}, run.factor)
