"""The oedometer test of glass beads of Cheng et al. 2019 (CMAME 350, 268), and a packing of spheres predicted with each law.

`glass_beads.dat`: axial strain, p and q [MPa], porosity, as kept in GrainLearning's repository (tests/data/oedo_sim_data/
obsdata.dat, BSD-3-Clause, copyright 2025 Hongyang Cheng). Density, Poisson's ratio and the result of their calibration are in
grainLearning/mcTriax_e.py of version 0.2 there; the size distribution is that of grainLearning/Packs/PeriSp_10000_0.68.txt,
which another script there loads for sand: that of the beads is not kept. E = 70 GPa, the modulus of glass, is the default of
their two-bead script. The diameter of the beads is in none of these files: 60 µm is assumed. Their kept runs have mean overlaps
of 0.130 and 0.387 µm at 6.8 and 52 MPa (grainLearning/Oedometric/iter2/VAE3_00_…, in mm); 300 grains of ours with their
parameters have 0.135 and 0.396 µm, so that 58 µm would agree. The diameter matters to roughness and to resistance to rolling.
"""

import json
from pathlib import Path
from typing import NamedTuple

import numpy as np

from demlaws.errors import DemlawsError
from demlaws.laws import HERTZ, POHRT_POPOV
from studies.engines import under_yade

HERE = Path(__file__).parent
RESULTS = HERE / "oedometer.jsonl"
SCRIPT = "experiment/yade_oedometer.py"
RADIUS = 30e-6  # [m], median of the beads: assumed
FITTED = {"young": 137.459e9, "friction": 0.36298}
"""E [Pa] and friction of their calibration."""
ROLLING = (2458.66e-9, 0.39885)
"""Resistance to rolling of their calibration: stiffness [N m] of rolling and of twisting, largest rolling moment over F R.

Their script counts in µg, mm and ms ("units: ug->1e-9kg; mm->1e-3m; ms->1e-3s"), and YADE takes krot as it is given, so that
their 2458.66 is in nN m. That is 1 to 2 % of k_n R²: rolling is slower than the contact and asks for no smaller step.
"""
SETUP = {
    "poisson": 0.2,
    "density": 2465.9,
    "damping": 0.2,
    "timestep": 0.7,
    "radius": RADIUS,
    "sizes": [[0.567, 0.69, 0.752, 0.891, 1.0, 1.074, 1.128, 1.248, 1.6], [0, 0.05, 0.1, 0.25, 0.5, 0.75, 0.9, 0.95, 1]],
    "loose_friction": 0.6,
    "porosity": 0.391059,
    "margin": 0.0005,
    "inertial": 1e-3,
}


class Case(NamedTuple):
    """One prediction: a law in YADE, and what it assumes of the beads."""

    label: str
    law: str = "native"  # or a law of demlaws
    roughness: float = 0.0  # Sq of each bead [m]
    young: float = 70e9
    friction: float = 0.36
    rolling: tuple | None = None  # krot = ktwist [N m] and eta of YADE's Mindlin
    fractal_dimension: float = 2.2
    unloading: str = "elastic"


CALIBRATED = "YADE's Hertz–Mindlin, all as calibrated by Cheng et al."
CASES = (
    Case("YADE's Hertz–Mindlin"),
    Case("hertz", HERTZ),
    *(Case(f"pohrt-popov, Sq = {sq:g} µm", POHRT_POPOV, 1e-6 * sq, unloading=HERTZ) for sq in (0.07, 0.15, 0.3)),
    Case("YADE's Hertz–Mindlin, E and friction as calibrated by Cheng et al.", **FITTED),
    Case("YADE's Hertz–Mindlin, rolling", rolling=ROLLING),
    Case("pohrt-popov, Sq = 0.07 µm, rolling", POHRT_POPOV, 0.07e-6, unloading=HERTZ, rolling=ROLLING),
    Case(CALIBRATED, rolling=ROLLING, **FITTED),
)
STIFFER = tuple(Case(f"{CALIBRATED}, krot × {n}", rolling=(n * ROLLING[0], ROLLING[1]), **FITTED) for n in (8, 64))
"""What the stiffness of rolling changes: run with `FEW` grains."""
FEW = 300


SAME = ", from one packing"
"""Ends the label of runs that start from the same packing."""


class Curve(NamedTuple):
    """Rows of a test, and the rows at which the axial strain turns."""

    strain: np.ndarray
    stress: np.ndarray  # axial [Pa]
    radial: np.ndarray  # [Pa]
    porosity: np.ndarray

    @property
    def turns(self):
        """Numbers of the rows at which the strain turns, with the first and the last."""
        moved = 1 + np.flatnonzero(np.diff(self.strain))  # a row may be repeated
        step = np.sign(np.diff(self.strain)[moved - 1])
        return [0, *moved[:-1][step[1:] != step[:-1]].tolist(), len(self.strain) - 1]

    def gained(self, branch, low, high):
        """Axial strain between two axial stresses [Pa] on a branch: 0 loading, 1 unloading, 2 reloading."""
        first, last = self.turns[branch : branch + 2]
        stress, strain = self.stress[first : last + 1], self.strain[first : last + 1]
        order = np.argsort(stress)
        if stress.min() > 1.02 * low or stress.max() < 0.98 * high:
            raise DemlawsError(
                f"branch {branch} reaches from {stress.min():g} to {stress.max():g} Pa: not {low:g} to {high:g} Pa"
            )
        return float(np.diff(np.interp([low, high], stress[order], strain[order]))[0])

    def exponent(self, low=10e6, high=50e6):
        """m of M ∝ σ^m on first loading: the strain is fitted by a + b σ^(1 - m)."""
        last = self.turns[1]
        chosen = (self.stress[: last + 1] >= low) & (self.stress[: last + 1] <= high)
        stress, strain = self.stress[: last + 1][chosen] / high, self.strain[: last + 1][chosen]

        def misfit(m):
            return float(np.polyfit(stress ** (1.0 - m), strain, 1, full=True)[1][0])

        trial = np.linspace(0.0, 0.9, 181)
        return float(trial[np.argmin([misfit(m) for m in trial])])

    def stress_ratio(self):
        """Radial over axial stress at the first turn."""
        return float(self.radial[self.turns[1]] / self.stress[self.turns[1]])


def measured():
    """The measured curve."""
    strain, p, q, porosity = np.loadtxt(HERE / "glass_beads.dat").T
    return Curve(strain, 1e6 * (p + 2.0 * q / 3.0), 1e6 * (p - q / 3.0), porosity)


def axial_stresses():
    """Axial stresses [Pa] at the measured start, turns and end, which every run follows."""
    curve = measured()
    return [float(curve.stress[turn]) for turn in curve.turns]


def run(count, seeds, path=RESULTS, cases=CASES, progress=print):
    """Run what `path` does not have yet, one YADE at a time, and add a line to it after each run."""
    done = {(row["count"], row["seed"], row["label"]) for row in read(path)}
    for seed in range(1, seeds + 1):
        wanted = [case for case in cases if (count, seed, case.label) not in done]
        if wanted:
            _tests(_specification(count, seed), wanted, path, progress)


def run_from_one_packing(count, seed=1, path=RESULTS, progress=print):
    """YADE's law and ours, both Hertz, from the same packing at the start of the test: what differs is the code."""
    given = _specification(count, seed)
    given["packing"] = under_yade(SCRIPT, {**given, "case": CASES[0]._asdict(), "keep": True})
    _tests(given, CASES[:2], path, progress, SAME)


def _specification(count, seed):
    """What the script is given, with a loose packing that it has made."""
    radial = float(measured().radial[0])
    given = {**SETUP, "count": count, "seed": seed, "radial": radial, "axial": axial_stresses()}
    return {**given, "packing": under_yade(SCRIPT, given)}


def _tests(given, cases, path, progress, same=""):
    about = {name: given[name] for name in ("count", "seed")}
    for case in cases:
        found = under_yade(SCRIPT, {**given, "case": case._asdict()})
        found["rows"] = [[float(f"{value:.6g}") for value in row] for row in found["rows"]]
        row = {**about, **case._asdict(), "label": f"{case.label}{same}", **found}
        with open(path, "a") as file:
            file.write(json.dumps(row) + "\n")
        progress(f"{given['count']} grains, seed {given['seed']}, {row['label']}: {row['steps']} steps, {row['seconds']:.0f} s")


def read(path=RESULTS):
    """Rows of a file of results; [] without the file."""
    if not Path(path).is_file():
        return []
    return [json.loads(line) for line in Path(path).read_text().splitlines()]


def curve_of(row):
    """The curve of one run."""
    return Curve(*np.array(row["rows"]).T)
