"""What a cheaper law costs a whole scene: the same oedometer test under each choice of law, inside an engine.

Granite spheres of 7 and 9 mm lie in a box under gravity. Every choice of law starts from the same positions, which YADE's
own Hertz has brought to rest (`packing`), comes to rest itself, is pressed by a plate to `Setup.stress`, held, and unloaded
by a fifth. What differs in the end is the law: the height of the centre of gravity, the stiffness of the packing, and
the time that the run took. Errors are those against the richest law, rough-plastic contacts with
Thornton unloading; that law once more from positions shaken by 1e-9 of the radius says how much of them is chance.
"""

import math
import tempfile
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from demlaws.errors import DemlawsError
from demlaws.laws import HERTZ
from demlaws.make import law as bind_law
from demlaws.plugins.grains import Grain
from demlaws.timestep import timestep
from studies.engines import available, under_yade
from studies.trade import lammps_oedometer, liggghts_oedometer
from studies.trade.candidates import GRANITE, RADII, STONE, SURFACE, Way, ways

SHAKEN = 1e-9


def mean_force(diameter, stress):
    """Mean force [N] of the contacts in a packing under a stress [Pa], of six contacts per grain in 0.6 of the volume."""
    return math.pi * diameter**2 * stress / (0.6 * 6)


def largest_step(radius, force):
    """Stability limit [s] of a smooth grain on a fixed contact at a force [N], over √3 for contacts in all directions."""
    grain = Grain(radius, GRANITE, SURFACE)
    law = bind_law(HERTZ, grain.contact(grain))
    return timestep(law, grain.mass, force, other_mass=math.inf, shear_ratio=0.0) / math.sqrt(3.0)


@dataclass(frozen=True)
class Setup:
    """The scene. SI units."""

    count: int = 1000
    across: int = 9  # widest grains side by side
    stress: float = 5e5
    friction: float = 0.5
    speed: float = 0.01  # of the plate
    settle: float = 0.02  # time to come to rest
    hold: float = 0.004
    seed: int = 2026

    @property
    def width(self):
        """Width of the box [m]."""
        return 2.02 * max(RADII) * self.across

    @property
    def largest_force(self):
        """A force that few contacts pass: ten times the mean at the largest stress."""
        return 10.0 * mean_force(float(2 * np.mean(RADII)), self.stress)

    def start(self):
        """Centres and radii of a loose block of grains, before anything has moved."""
        random = np.random.default_rng(self.seed)
        radii = np.where(random.random(self.count) < 0.5, *RADII)
        pitch = 2.0 * max(RADII)
        number = np.arange(self.count)
        centres = np.stack([number % self.across, number // self.across % self.across, number // self.across**2], 1) + 0.5
        free = (pitch - 2.0 * radii)[:, None] + 0.02 * max(RADII)
        step = np.array([self.width / self.across, self.width / self.across, pitch + 0.02 * max(RADII)])
        return centres * step + 0.49 * free * random.uniform(-1.0, 1.0, centres.shape), radii

    def given(self, radii, centres, width=None):
        """Input of an engine's oedometer.py."""
        return {
            **asdict(self),
            "width": width or self.width,
            "dt": self.timestep(),
            **STONE,
            "mean_force": 0.1 * self.largest_force,
            "back": self.speed / 3,
            "radii": radii.tolist(),
            "centres": centres.tolist(),
        }

    def timestep(self):
        """Stable step [s] of every way: a grain of the smaller size between stiff contacts."""
        return 0.5 * largest_step(min(RADII), self.largest_force)


QUICK = Setup(count=150, across=5, settle=0.008, speed=0.02, hold=0.002)


def packing(setup):
    """Radii and centres [m] of the packing that every way starts from: dense, at rest under gravity.

    YADE's Hertz made it of `Setup.start`: grains of E/1000 with a friction of 0.05 fell, were pressed to 3 kPa and became
    granite in six steps, the plate giving way so that the pressure stayed.
    """
    path = Path(__file__).with_name(f"granite-{setup.count}.txt")
    rows = np.loadtxt(path) * 1e-6
    return rows[:, 0], rows[:, 1:]


class Outcome(NamedTuple):
    """What a scene became under one way."""

    way: Way
    height: float  # of the centre of gravity, at rest under gravity [m]
    low: float  # tangent of stress against strain of the packing, from a tenth to a fifth of the full stress [Pa]
    loading: float  # the same, from half to full stress [Pa]
    unloading: float  # the same, while the stress falls by a fifth [Pa]
    stress: float  # after the hold [Pa]
    forces: np.ndarray  # normal forces between grains after the hold [N]
    steps: int
    seconds: float


class Errors(NamedTuple):
    """One outcome against another."""

    height: float  # [m]
    low: float  # relative
    loading: float
    unloading: float


def slope(height, stress, low, high, thickness):
    """Tangent modulus [Pa]: least squares of stress against the plate's height where the stress is from low to high."""
    height, stress = np.asarray(height), np.asarray(stress)
    chosen = (stress >= low) & (stress <= high)
    if np.count_nonzero(chosen) < 3:
        raise DemlawsError(f"only {np.count_nonzero(chosen)} rows of the run have a stress from {low:g} to {high:g} Pa")
    return float(-np.polyfit(height[chosen], stress[chosen], 1)[0] * thickness)


def outcome(way, setup, raw):
    """An `Outcome` from what an engine's run wrote (dict, see the engines' oedometer.py)."""
    loading, unloading = map(np.array, raw["branches"])
    loading, held = loading[: np.argmax(loading[:, 1] >= setup.stress) + 1], raw["held"]
    thickness, stress = held["plate"], held["stress"]
    return Outcome(
        way,
        raw["height"],
        slope(loading[:, 0], loading[:, 1], 0.1 * setup.stress, 0.2 * setup.stress, thickness),
        slope(loading[:, 0], loading[:, 1], 0.5 * setup.stress, 1.1 * setup.stress, thickness),
        slope(unloading[:, 0], unloading[:, 1], 0.8 * stress, stress, thickness),
        stress,
        np.array(held["forces"]),
        raw["steps"],
        raw["seconds"],
    )


def errors(found, richest):
    """`Errors` of an outcome against the richest law's."""
    return Errors(
        found.height - richest.height,
        found.low / richest.low - 1.0,
        found.loading / richest.loading - 1.0,
        found.unloading / richest.unloading - 1.0,
    )


def _for_yade(way, file):
    """A way as the scripts under YADE take it; a table is written to `file`."""
    if not way.rtol:
        return {**way._asdict(), "options": dict(way.options), "given": way.law}
    largest = Grain(max(RADII), GRANITE, SURFACE)
    way.bind(largest.contact(largest)).save(file)
    return {**way._asdict(), "options": {}, "given": str(file)}


def run(engine, setup=None, chosen=None, progress=lambda label: None):
    """`Outcome` of every way of an engine (or of the chosen ones), the richest first. Raises where the engine is missing."""
    missing = available(engine)
    if missing:
        raise DemlawsError(missing)
    setup = setup or Setup()
    chosen = list(chosen or ways(engine))
    radii, centres = packing(setup)
    shift = SHAKEN * np.random.default_rng(1).uniform(-1.0, 1.0, centres.shape) * min(RADII)
    given = setup.given(radii, centres)
    raw = []
    with tempfile.TemporaryDirectory() as scratch:
        if engine == "yade":
            described = [_for_yade(way, Path(scratch) / f"{n}.tbl") for n, way in enumerate(chosen)]
            raw = under_yade("trade/yade_oedometer.py", {**given, "shift": shift.tolist(), "ways": described}, progress)
        else:
            oedometer = {"liggghts": liggghts_oedometer, "lammps": lammps_oedometer}[engine].oedometer
            for number, way in enumerate(chosen):
                progress(f"{number + 1} {way.label}")
                places = (centres + shift if way.shaken else centres).tolist()
                described = {**way._asdict(), "options": dict(way.options)}
                raw.append(oedometer(Path(scratch) / str(number), {**given, "centres": places}, described))
    return [outcome(way, setup, found) for way, found in zip(chosen, raw, strict=True)]


def table(outcomes, setup):
    """The outcomes as text, errors against the first."""
    stress = [f"{x * setup.stress / 1e3:g}" for x in (0.15, 0.75, 0.9)]
    lines = [
        f"{'':34}{'height':>9}{'packing stiffness (MPa), error, at':^42}{'time':>8}",
        f"{'':34}{'error':>9}{f'{stress[0]} kPa':>14}{f'{stress[1]} kPa':>14}{'unloading':>14}"
        f"{'s':>8}{'steps':>7}{'µs/step':>9}",
    ]
    for found in outcomes:
        e = errors(found, outcomes[0])
        cells = "".join(
            f"{value / 1e6:7.1f}{100 * error:+6.1f}%"
            for value, error in ((found.low, e.low), (found.loading, e.loading), (found.unloading, e.unloading))
        )
        lines.append(
            f"{found.way.label:34}{1e6 * e.height:+6.2f} µm{cells}"
            f"{found.seconds:8.1f}{found.steps:7d}{1e6 * found.seconds / found.steps:9.0f}"
        )
    return "\n".join(lines)
