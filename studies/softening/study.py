"""What users trade: modulus, loading rate, time step. The same processes with softer grains, faster, and in longer steps.

Granite spheres, rough, in YADE: pressed in an oedometer, cycled there, poured, sheared to the peak. Each run is a `Run`; its
results are one row of a file of JSON lines (`KEPT`), so that a study that was stopped goes on. Rows of LIGGGHTS, measured with
version 0.2.0, are kept beside them. `ERRORS` of a softened run are those against the same process at full modulus, its
overlaps divided by s^(2/3); the scatter of the unscaled run over copies shaken by `packings.SHAKEN` of a radius says what is
chance.
"""

import json
import math
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import trapezoid

from demlaws.advice.modulus import STUDY_STEP
from demlaws.advice.soften import Softening
from demlaws.contact import DENSITY, Surface
from demlaws.errors import DemlawsError
from demlaws.laws import POHRT_POPOV
from demlaws.make import law as bind_law
from demlaws.plugins.grains import Grain
from studies.engines import under_yade
from studies.trade import packings
from studies.trade.candidates import GRANITE, RADII, SURFACE
from studies.trade.packings import SHAKEN, largest_step, mean_force, slope

KEPT = Path(__file__).with_name("softening.jsonl")
"""The rows of the study that this version of demlaws is advised by."""
STRESS = 3.75e5
DEEP = 0.038  # [m] height of the packing of 150
DIAMETER = 2.0 * float(np.mean(RADII))
QUANTILES = tuple(range(5, 100, 5))
RESTING = 2870  # steps at half the unit to come to rest under gravity
LEAST = 0.2  # of the stress, to which a cycle unloads

STUDIED = (POHRT_POPOV, "hertz")
"""Law and rule of the reference runs."""


TRADED = ("factor", "scaled", "inertial", "part", "law", "unloading", "density")
"""Fields of a `Run` that a user trades; the others say what process it is, of what grains."""


class Run(NamedTuple):
    """One run of the study. Stress [Pa]; size: of the grains, over 3.5 and 4.5 mm; rough: Sq over 1.7 µm."""

    engine: str
    process: str  # "cycles" (an oedometer; cycles=1: loading and unloading), "pour", "shear"
    factor: float = 1.0  # by which Young's modulus is divided
    scaled: bool = True  # σ and pressures are scaled along
    inertial: float = 3e-4  # I = rate × diameter × √(density/stress)
    part: float = 0.5  # time step over `Run.unit`
    copy: int = 0
    cycles: int = 1
    law: str = STUDIED[0]
    unloading: str = STUDIED[1]
    stress: float = STRESS
    size: float = 1.0
    rough: float = 1.0
    density: float = 1.0  # by which the grains' is multiplied, their weight kept: gravity is divided by it
    scatter: float = (
        0.0  # above 0: a lattice of spheres whose radii fall short of 4 mm by up to this [m], stretched as overlaps
    )

    @property
    def short(self) -> float:
        """By what the radii of a lattice fall short, at most [m]: a length as overlaps are."""
        return self.scatter * Softening(self.factor).overlap

    @property
    def reference(self) -> "Run":
        """The process as it is: full modulus, slow, half the unit of time step, the richest law of the study."""
        plain = Run("", "")
        return self._replace(**{n: getattr(plain, n) for n in TRADED})

    @property
    def surface(self) -> Surface:
        """Surface of the grains of this run."""
        return Surface(self.rough * SURFACE.roughness, SURFACE.fractal_dimension, SURFACE.hardness)

    @property
    def unit(self) -> float:
        """Unit of the time step [s]: that of a smooth grain of the smaller size on a fixed contact at ten times the mean force,
        over √3. It is `modulus.STUDY_STEP` times the stability limit of the packing at its largest stress, so not stable."""
        force = 10.0 * mean_force(self.size * DIAMETER, self.stress)
        return largest_step(self.size * min(RADII), force) * Softening(self.factor).step

    @property
    def depth(self) -> float:
        """Overlap over diameter of the softened grains at the mean force, σ scaled along."""
        grain, diameter = Grain(self.size * LATTICE, GRANITE, self.surface), 2.0 * self.size * LATTICE
        law = bind_law(self.law, grain.contact(grain))
        overlap = float(law.overlap(mean_force(diameter, self.stress)))
        return overlap * Softening(self.factor).overlap / diameter

    @property
    def kappa(self) -> float:
        """Stiffness number (E*/p)^(2/3) of the softened grains."""
        return float((0.5 * GRANITE.plane_modulus / self.factor / self.stress) ** (2 / 3))

    @property
    def sunk(self) -> float:
        """By what the plate of the oedometer sinks, about [m]."""
        return 0.0047 * DEEP * self.size * (self.stress / STRESS) ** 0.45 * Softening(self.factor).overlap

    def given(self) -> dict:
        """Engine input of this run."""
        softening = Softening(self.factor)
        slower = math.sqrt(self.density)  # all of a heavier grain's motion
        unit = slower * self.unit
        dt, density = self.part * unit, self.density * (GRANITE.density or DENSITY)
        rate = self.inertial / (self.size * DIAMETER * math.sqrt(density / self.stress))
        speed = rate * DEEP * self.size
        return {
            **self._asdict(),
            "young": GRANITE.young / self.factor,
            "surface": vars(softening.of(self.surface) if self.scaled else self.surface),
            "dt": dt,
            "speed": speed,
            "back": speed,
            "settle": RESTING * 0.5 * unit,
            "hold": 0.25 * RESTING * 0.5 * unit,
            "every": int(np.clip(round(self.sunk / (150 * speed * dt)), 1, 40)),  # about 150 readings while the plate goes down
            "least": LEAST * self.stress,
            "shake": SHAKEN * self.size * min(RADII),
            "time": 0.25 * math.sqrt(self.size) * slower,
            "strain": 0.15,
            "gain": 0.1 / slower,
            "fastest": 0.05 / slower,
            "gravity": 9.81 / self.density,
            "density": density,
        }


# --- what is run


def _copies(run, count):
    return [run._replace(copy=n) for n in range(count)]


def plan(quick: bool = False) -> list[Run]:
    """The runs in YADE whose rows are kept. quick: some minutes, those of E, E/10 and E/100, loaded and unloaded once."""
    runs = [run for run in load() if run.engine == "yade"]
    if not quick:
        return runs
    return [r for r in runs if r.factor in (1.0, 10.0, 100.0) and r == Run("yade", "cycles", r.factor, r.scaled, copy=r.copy)]


OTHERS: tuple[dict[str, Any], ...] = (
    {"stress": 1.0e5, "factor": 5.0},
    {"stress": 1.0e5, "factor": 30.0},
    {"stress": 1.0e6, "factor": 5.0},
    {"size": 0.25, "factor": 20.0},
    {"size": 3.0, "factor": 10.0},
    {"size": 3.0, "factor": 10.0, "scaled": False},
    {"rough": 0.2, "factor": 30.0},
    {"rough": 0.2, "factor": 10.0, "scaled": False},
    {"rough": 3.0, "factor": 10.0, "inertial": 1e-3},
    {"stress": 2.0e5, "size": 0.5, "rough": 0.5, "factor": 50.0, "inertial": 1e-3},
)
"""Scenes of other radii, pressures and roughness, from which predictions are made, too."""
FASTER: tuple[dict[str, Any], ...] = tuple(
    {**grains, "inertial": rate}
    for grains in ({"stress": 1.0e5}, {"stress": 1.0e6}, {"size": 0.25}, {"size": 3.0}, {"rough": 0.2}, {"rough": 3.0})
    for rate in (1e-3, 3e-3)
)
"""The same at full modulus, loaded faster."""
FITTED_ON = frozenset(Run("yade", "cycles", **scene) for scene in (*OTHERS, *FASTER))
HELD_BACK: tuple[dict[str, Any], ...] = (
    {"stress": 5.0e4, "factor": 10.0},
    {"stress": 5.0e4, "factor": 10.0, "scaled": False},
    {"stress": 7.0e5, "factor": 20.0},
    {"size": 0.4, "factor": 5.0},
    {"size": 2.0, "factor": 40.0},
    {"rough": 0.4, "factor": 15.0},
    {"rough": 0.4, "factor": 5.0, "scaled": False},
    {"rough": 2.0, "factor": 25.0},
    {"stress": 1.5e5, "size": 1.5, "factor": 8.0, "inertial": 1e-3},
    {"stress": 5.0e5, "size": 0.7, "rough": 0.6, "factor": 60.0, "inertial": 5e-4},
)
"""Scenes from which no prediction is made: predictions are tested on them."""


TRIED = tuple(
    [(1.0, rate, 0.7) for rate in (2e-4, 3e-4, 4e-4, 5e-4, 7e-4, 1e-3, 1.4e-3, 2e-3)]
    + [(1.0, rate, 0.5) for rate in (2e-4, 3e-4, 5e-4, 1e-3, 2e-3)]
    + [(10.0, rate, 0.7) for rate in (3e-4, 7e-4, 1.4e-3)]
)
"""(factor, I, part of the unit of time step) with which each of the held-back scenes is run: the fastest of those that meet a
tolerance is compared with the advice."""
SLOWER = (3.75e5, 1e5, 3e4, 1e4, 3e3)
"""Stresses [Pa] at which a lattice, and the packing from its own start, is pressed at full and at a tenth of the modulus."""


def held_back() -> list[Run]:
    """Ten packings from which no prediction is made, as they are: those of `HELD_BACK`, each once, and two more."""
    grains = [{k: v for k, v in scene.items() if k in ("stress", "size", "rough")} for scene in HELD_BACK]
    grains += [{"stress": 2.5e5, "size": 1.2, "rough": 1.5}, {"stress": 6.0e5, "size": 2.5, "rough": 0.8}]
    return list(dict.fromkeys(Run("yade", "cycles", **one) for one in grains))


def similar() -> list[Run]:
    """A lattice at full and at a tenth of the modulus, I √κ alike, with σ scaled and with σ left alone; the packing likewise,
    whose gaps do not scale."""
    runs = []
    for stress in SLOWER:
        one = Run("yade", "cycles", stress=stress)
        softer = [one._replace(factor=10.0, scaled=scaled) for scaled in (True, False)]
        like = [r._replace(scatter=SCATTER, inertial=float(f"{r.inertial * r.factor ** (1 / 3):.6g}")) for r in (one, *softer)]
        runs += [r for run in like for r in _copies(run, 5)]
        runs += [r for run in (one, *softer) for r in _copies(run, 3)]
    return runs


# --- running


def load(path: Path = KEPT) -> dict[Run, dict]:
    """Run → its row, of a file of JSON lines; a line cut off by an end that came too early is left out."""
    rows: dict[Run, dict] = {}
    if not path.exists():
        return rows
    lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
    for line in lines:
        try:
            row = json.loads(line)
            rows[Run(**row["run"])] = row
        except (ValueError, TypeError, KeyError):
            continue
    if len(lines) > 1 and not rows:  # one line may be the cut-off first
        raise DemlawsError(f"{path} is not a file of a study: none of its {len(lines)} lines is a row; name another file")
    return rows


def missing(runs: list[Run], rows: dict) -> list[Run]:
    """Those of the runs that have no row yet."""
    return [run for run in dict.fromkeys(runs) if run not in rows]


def execute(runs: list[Run], path: Path, progress: Any = lambda run: None) -> None:
    """Make the runs that `path` does not hold, and append each one's row as it ends."""
    left = missing(runs, load(path))
    if path.exists() and not path.read_bytes().endswith(b"\n"):  # an end that came too early: its line is made again
        whole = path.read_bytes().rpartition(b"\n")
        path.write_bytes(whole[0] + whole[1])

    def keep(run, found):
        row = {"run": run._asdict(), **summary(run, found)}
        path.parent.mkdir(parents=True, exist_ok=True)
        with open(path, "a", encoding="utf-8") as file:
            file.write(json.dumps(row) + "\n")
        progress(run)

    for kind in dict.fromkeys((run.size, run.short) for run in left):
        own = [run for run in left if (run.size, run.short) == kind]

        def ended(text, own=own):
            message = json.loads(text)
            keep(own[message["number"]], message["found"])

        under_yade("softening/yade_softening.py", {**scene(*kind), "runs": [run.given() for run in own]}, ended)


LATTICE = 4e-3
"""Radius of the spheres of a lattice [m]."""
SCATTER = 4e-6
"""By what they fall short of it, at most [m]: as much as overlaps."""


def lattice(short: float, across: int = 5, layers: int = 7) -> tuple:
    """(radii, centres, width) [m] of 148 spheres in a face-centred cubic lattice between walls, floor and top that they touch
    but for the random `short` [m] of their radii: gaps that are as large as overlaps, and scale with them."""
    spacing = 2.0 * LATTICE
    centres = []
    for layer in range(layers):
        odd = layer % 2
        places = LATTICE * (1 + odd) + spacing * np.arange(across - odd)
        height = LATTICE + layer * spacing / math.sqrt(2.0)
        centres += [(x, y, height) for y in places for x in places]
    radii = LATTICE - short * np.random.default_rng(packings.QUICK.seed).random(len(centres))
    return radii, np.array(centres), across * spacing


def scene(size, short=0.0):
    """The packing of 150, and the loose block that it fell from, in grains `size` times as large; or a lattice."""
    setup = packings.QUICK
    if short:
        radii, centres, width = lattice(short)
        return setup.given(size * radii, size * centres, size * width)
    radii, centres = packings.packing(setup)
    given = setup.given(size * radii, size * centres, size * setup.width)
    return {**given, "loose": (size * setup.start()[0]).tolist()}


# --- what a run gave


def _rounded(value):
    return [float(f"{v:.6g}") for v in value] if isinstance(value, list) else float(f"{value:.6g}")


def summary(run: Run, found: dict) -> dict:
    """The figures of a run, from what an engine wrote. Lengths and strains are those of the softened grains."""
    if "failed" in found:
        return {"failed": found["failed"].strip().splitlines()[-1]}  # the last line of a traceback
    held = found["held"]
    forces = np.array(held["forces"])
    if not forces.size or not np.all(np.isfinite(forces)):
        return {"failed": "no grain touches another in the end"}
    row = {
        "steps": found["steps"],
        "coordination": held["coordination"],
        "quantiles": [float(v) for v in np.percentile(forces / forces.mean(), QUANTILES)],
    }
    if "unbalanced" in found:
        row["unbalanced"] = found["unbalanced"]
    if run.process == "cycles":
        row |= _of_cycles(run, found)
    elif run.process == "pour":
        row["height"] = found["height"]
    else:
        row["peak"] = _strength(found["rows"])
    known = {name: value for name, value in row.items() if isinstance(value, list) or math.isfinite(value)}
    return {name: value if name == "steps" else _rounded(value) for name, value in known.items()}


def _crossing(rows, stress):
    """Height of the plate [m] where the stress first reaches `stress`, between two rows."""
    rows = np.asarray(rows)
    above = int(np.argmax(rows[:, 1] >= stress))
    if above == 0:
        return float(rows[0, 0])
    (h1, s1), (h2, s2) = rows[above - 1], rows[above]
    return float(h1 + (h2 - h1) * (stress - s1) / (s2 - s1))


def _of_cycles(run, found):
    branches, thickness = found["branches"], found["held"]["plate"]
    first, back = np.array(branches[0]), np.array(branches[1])
    held = back[0, 1]

    def tangent(rows, low, high):
        try:
            return slope(rows[:, 0], rows[:, 1], low, high, thickness)
        except DemlawsError:  # so fast that the stress is passed within two looks
            return math.nan

    low = tangent(first, 0.1 * run.stress, 0.2 * run.stress)
    loading = tangent(first, 0.5 * run.stress, 1.1 * run.stress)
    peaks = [_crossing(up, 0.99 * run.stress) for up in branches[::2]]
    row = {
        "low": low,
        "loading": loading,
        "unloading": tangent(back, 0.7 * held, 1.01 * held),
        "exponent": math.log(loading / low) / math.log(0.75 / 0.15) if low > 0.0 < loading else math.nan,
        "put_in": -trapezoid(first[:, 1], first[:, 0]),  # [J/m²], up to the stress
        "given_back": trapezoid(back[:, 1], back[:, 0]),
    }
    if run.cycles > 1:
        row["settlement"] = peaks[0] - peaks[-1]
    return row


def _strength(rows):
    """Largest axial over lateral stress, smoothed over 1 % of strain; rows: stresses across x, y and z, height of the box."""
    rows = np.array(rows)
    ratio, strain = rows[:, 2] / (0.5 * (rows[:, 0] + rows[:, 1])), 1.0 - rows[:, 3] / rows[0, 3]
    width = max(3, int(np.sum(strain < 0.01)))
    return float(np.max(np.convolve(ratio, np.ones(width) / width, "valid")))


def label(run: Run) -> str:
    """A way in words."""
    law = "" if (run.law, run.unloading) == STUDIED else f"{run.law}, {run.unloading}; "
    alone = "" if run.scaled or run.factor == 1.0 else ", σ alone"
    part = "" if run.part == 0.5 else f", {STUDY_STEP * run.part:.2g} of the stability limit"
    density = "" if run.density == 1.0 else f", density × {run.density:g}"
    return f"{law}E/{run.factor:g}{alone}, I = {run.inertial:g}{part}{density}"
