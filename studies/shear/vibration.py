"""Grains at rest while a load vibrates, in the engines: a block on a rough incline, a heap, and an oedometer.

A model of shear that loses force in each vibration lets the block slide below Coulomb's limit, and the heap sink, without end.
"""

import itertools
import json
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

import numpy as np
from tqdm import tqdm

import demlaws as dl
from demlaws import lammps, liggghts
from demlaws.errors import DemlawsError
from demlaws.lammps.run import HEAD as LAMMPS_HEAD
from demlaws.liggghts.run import HEAD as LIGGGHTS_HEAD
from studies.engines import under_yade
from studies.shear.cyclic import WORDS, settlement
from studies.shear.rest import settle
from studies.trade.liggghts_oedometer import data_text

YOUNG, POISSON, DENSITY, FRICTION, RESTITUTION = 1e8, 0.25, 2600.0, 0.5, 0.5
OWN = {"liggghts": "history", "lammps": "mindlin", "yade": "native"}
LIGGGHTS = """\
fix m1 all property/global youngsModulus peratomtype {young} {young}
fix m2 all property/global poissonsRatio peratomtype {poisson} {poisson}
fix m3 all property/global coefficientRestitution peratomtypepair 2 {e} {e} {e} {e}
fix m4 all property/global coefficientFriction peratomtypepair 2 {mu} {mu} {mu} {mu}
pair_style gran model {pair}
pair_coeff * *
"""
CASE = """\
{head}read_data start.data
group grains type 1
group fixed type 2
neighbor {skin:.10g} bin
neigh_modify delay 0 exclude group fixed fixed
{contacts}timestep {dt:.10g}
variable swing equal 0
{loads}
fix move grains {integrator}
fix hold fixed freeze
variable along equal xcm(grains,x)
variable height equal xcm(grains,z)
thermo_style custom step v_along v_height ke
thermo_modify norm no lost error format float %.15g
thermo {settle}
run {settle}
variable began equal $(step)
variable swing equal sin(2*PI*(step-${{began}})/{period})
thermo {every}
run {steps}
"""


class Scene(NamedTuple):
    """What a vibration acts on."""

    grains: list  # (diameter [m], place [m])
    fixed: list  # the same of grains that do not move
    walls: dict  # axis → places of flats [m]
    gravity: tuple  # direction
    push: float  # amplitude of a vertical force on each grain [N]
    swing: float  # amplitude of gravity, over it
    turns: bool  # whether grains can turn
    drag: float  # [1/s] of a grain's speed
    dt: float
    settle: int  # steps
    period: int  # steps of a vibration

    def box(self):
        """Ends of the box [m] along each axis."""
        places = np.array([place for _, place in self.grains + self.fixed])
        room = 3.0 * max(size for size, _ in self.grains)
        ends = zip(places.min(0) - room, places.max(0) + room, "xyz", strict=True)
        return [
            (min(low, *self.walls.get(a, [low])) - 1e-3, max(high, *self.walls.get(a, [high])) + 1e-3) for low, high, a in ends
        ]


def block():
    """A sphere that cannot turn on a plane of slope 0.5 μ: a block that stays by half of Coulomb's limit. Overlap ±1 %."""
    diameter, slope = 0.02, 0.5 * FRICTION
    mass = DENSITY * np.pi / 6 * diameter**3
    norm = np.hypot(1.0, slope)
    weight = mass * 9.81 / norm
    law = dl.law("hertz", dl.Contact(diameter / 2, YOUNG / (2 * (1 - POISSON**2))))
    overlap = law.overlap(weight)
    time = 2 * np.pi * np.sqrt(mass / law.stiffness(overlap))
    gravity = (slope / norm, 0.0, -1.0 / norm)
    push = 1.5 * 0.01 * weight
    place = (0.0, 0.0, diameter / 2 - overlap)
    return Scene([(diameter, place)], [], {"z": [0.0]}, gravity, push, 0.0, False, 0.5 / time, time / 40, 20_000, 400)


def heap():
    """330 grains of 4 mm between walls, on a base of fixed grains; gravity swings by ±20 %."""
    size, generator = 0.004, np.random.default_rng(7)
    places = np.array([(x, y, z) for z in range(19) for y in range(2) for x in range(9)])[:330] * 1.06 * size
    places = places + np.array([-4.24 * size, 0.0036, 0.006]) + generator.uniform(-1e-4, 1e-4, places.shape)
    floor = [(size, (size * x, size * (y + 0.5), 0.0)) for x in range(-22, 23) for y in range(3)]
    walls = {"x": [-0.09, 0.09], "y": [0.0, 0.012]}
    down = (0.0, 0.0, -1.0)
    return Scene([(size, tuple(p)) for p in places.tolist()], floor, walls, down, 0.0, 0.2, True, 0.0, 1e-5, 100_000, 1000)


SCENES = {"block": block, "heap": heap}
IN_LIGGGHTS = ("oedometer", "rest")
"""Scenes that run there only."""


def _contacts(engine, model, scene):
    """Lines of pairs and walls, with one model of shear."""
    words = WORDS[model]
    table = "" if model == "own" else "table.tbl"
    sides = [(f"w{a}{n}", a, place) for a, places in scene.walls.items() for n, place in enumerate(places)]
    if engine == "liggghts":

        def terms(place):
            own = f"hertz tangential history {place}" if model == "own" else f"demlaws/table tangential demlaws {place}"
            return f"{own} {f'table {table} {words}' if table else ''}"

        numbers = {"young": YOUNG, "poisson": POISSON, "e": RESTITUTION, "mu": FRICTION}
        lines = LIGGGHTS.format(pair=terms(""), **numbers)
        for name, axis, place in sides:
            lines += f"fix {name} grains wall/gran model {terms(f'primitive type 2 {axis}plane {place:.10g}')}\n"
        return lines
    if table:
        model = f"demlaws/table {table} {YOUNG} {RESTITUTION} {POISSON} {words} tangential demlaws 1.0 {FRICTION}"
        model += " damping demlaws/tangent"
    else:
        model = f"hertz/material {YOUNG} {RESTITUTION} {POISSON} tangential mindlin NULL 1.0 {FRICTION} damping tsuji"
    lines = f"pair_style granular\npair_coeff * * {model}\n"
    for name, axis, place in sides:
        ends = f"{place:.10g} NULL" if place <= 0.0 else f"NULL {place:.10g}"
        lines += f"fix {name} grains wall/gran granular {model} {axis}plane {ends}\n"
    return lines


def run(engine, name, model, cycles, rows=50):
    """[cycles, place along the slope, height [m]] of the centre of mass at `rows` times of a vibration."""
    scene = SCENES[name]()
    every = max(cycles // rows, 1) * scene.period
    if engine == "yade":
        numbers = {"young": YOUNG, "poisson": POISSON, "density": DENSITY, "friction": FRICTION, "restitution": RESTITUTION}
        given = {**scene._asdict(), **numbers, "model": model, "every": every, "steps": cycles * scene.period}
        return np.array(under_yade("shear/yade_vibration.py", given))
    head = LIGGGHTS_HEAD if engine == "liggghts" else f"{LAMMPS_HEAD}boundary f f f\n"
    atoms = [(kind, size, DENSITY, *p) for kind, group in ((1, scene.grains), (2, scene.fixed)) for size, p in group]
    mass = DENSITY * np.pi / 6 * scene.grains[0][0] ** 3
    loads = [f"variable gravity equal 9.81*(1+{scene.swing:.10g}*v_swing)"]
    loads.append("fix gravity grains gravity v_gravity vector {:.12g} {:.12g} {:.12g}".format(*scene.gravity))
    if scene.push:
        loads += [f"variable push equal {scene.push:.12g}*v_swing", "fix push grains addforce 0 0 v_push"]
    if scene.drag:
        loads.append(f"fix drag grains viscous {scene.drag * mass:.10g}")
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "start.data").write_text(data_text(scene.box(), atoms))
        if model != "own":
            sizes = dl.Contact(scene.grains[0][0] / 4, YOUNG / (2 * (1 - POISSON**2)))
            dl.law("hertz", sizes).tabulate().save(Path(folder) / "table.tbl")
        text = CASE.format(
            head=head,
            skin=0.25 * scene.grains[0][0],
            contacts=_contacts(engine, model, scene),
            loads="\n".join(loads),
            integrator="nve/sphere" if scene.turns else "nve",
            dt=scene.dt,
            settle=scene.settle,
            period=scene.period,
            every=every,
            steps=cycles * scene.period,
        )
        (Path(folder) / "in.vibration").write_text(text)
        log = {"liggghts": liggghts, "lammps": lammps}[engine].run(Path(folder) / "in.vibration", plugin=model != "own")
    start = int(np.flatnonzero(log["Step"] >= scene.settle)[0])
    kept = np.flatnonzero(log["Step"] >= scene.settle)
    kept = kept[np.append(True, np.diff(log["Step"][kept]) > 0)]
    cycle = (log["Step"][kept] - log["Step"][start]) / scene.period
    return np.stack([cycle, log["along"][kept], log["height"][kept]], 1)


def run_all(name, engines, models, *, cycles, shaken, out):
    """Append a line per engine, model and seed to `out` (JSON lines) and print it; runs that it has are left out."""
    if name in IN_LIGGGHTS and engines != ["liggghts"]:
        raise DemlawsError(f"--vibrate {name} runs in LIGGGHTS only, got --engines {' '.join(engines)}")
    done = [json.loads(line) for line in out.read_text().splitlines()] if out.exists() else []
    seeds = shaken if name in IN_LIGGGHTS else [0]
    for engine, model, seed in tqdm(list(itertools.product(engines, models, seeds)), disable=not sys.stderr.isatty()):
        case = {"scene": name, "engine": engine, "model": model, "cycles": cycles}
        if name in IN_LIGGGHTS:
            case["shaken"] = seed
        if any(case.items() <= row.items() for row in done):
            continue
        if name == "oedometer":
            height, thickness = settlement(model, cycles, seed)
            rows = np.stack([np.arange(1.0, height.size + 1.0), 0.0 * height, height], 1)
            case["thickness"] = thickness
        elif name == "rest":
            rows = settle(model, seed)
        else:
            rows = run(engine, name, model, cycles)
        with open(out, "a") as file:
            file.write(json.dumps({**case, "rows": [[float(f"{v:.9g}") for v in row] for row in rows.tolist()]}) + "\n")
        print(describe(case, rows), flush=True)


def describe(case, rows):
    """One line: movement in nm in the first tenth, the last half and, per cycle, there; of a packing at rest what is left."""
    if case["scene"] == "rest":
        ends = [rows[np.searchsorted(rows[:, 0], end - 1e-9)] for end in (0.4, 0.8)]
        return f"rest, {case['model']}: " + "; ".join(f"after {t:.1f} s energy {ke:.0e}, walls {f:.0e}" for t, ke, f in ends)
    cycle, place = rows[:, 0], 1e9 * rows[:, 1 if case["scene"] == "block" else 2]
    tenth, half = np.interp([0.1 * case["cycles"], 0.5 * case["cycles"]], cycle, place)
    late = cycle >= 0.5 * case["cycles"]
    trend = np.polyfit(cycle[late], place[late], 1)[0]
    return (
        f"{case['scene']}, {case['engine']}, {case['model']}, {case['cycles']:,} cycles: {tenth - place[0]:+.1f} nm in the "
        f"first tenth, {place[-1] - half:+.2f} nm in the last half, {trend:+.2e} nm per cycle"
    )
