"""What ways of computing contacts cost in an engine's step: a close packing of granite that stands still, every way in turn."""

import math
import subprocess
import tempfile
from importlib import import_module
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from demlaws.engines import SHARED, compiler
from demlaws.errors import DemlawsError, quiet
from demlaws.grains import Grain
from demlaws.lammps.run import HEAD as LAMMPS_HEAD
from demlaws.liggghts.build import PLUGIN
from demlaws.liggghts.run import HEAD as LIGGGHTS_HEAD
from studies.costs.costs import describe, under_yade
from studies.trade import lammps_oedometer, liggghts_oedometer
from studies.trade.candidates import GRANITE, STONE, SURFACE, Way, close_packing
from studies.trade.liggghts_oedometer import MATERIAL, pairwise

HEADS = {"liggghts": f"{LIGGGHTS_HEAD}processors 1 1 1\n", "lammps": f"{LAMMPS_HEAD}boundary f f f\nnewton on\n"}
NEIGHBOURS = {"liggghts": "delay 0 contact_distance_factor 1.01", "lammps": "delay 0"}
# setforce keeps the grains still; fix freeze would keep them out of the list of neighbours
CASE = """\
{head}read_data       start.data
neighbor        {skin:.10g} bin
neigh_modify    {neighbours}
{contacts}fix             gravity all gravity 9.81 vector 0 0 -1
fix             move all nve/sphere
fix             still all setforce 0. 0. 0.
thermo_style    custom step atoms ke
thermo_modify   norm no
thermo          100000
run             20
run             {steps}
"""


class StepCost(NamedTuple):
    """One way in one engine; times per contact and step, one thread."""

    way: Way
    step: float  # ns of the whole step
    over_hertz: float  # whole step over that with the engine's own Hertz
    law: float  # share of the step that the normal law takes; NaN of an engine's own
    model: float  # YADE: share of the Law2 functor, with shear and friction; LIGGGHTS, LAMMPS: share of the pair loop


def step_costs(engine, ways, radius, overlap, force, side, rounds, steps=200, progress=lambda things: things):
    """`StepCost` of each `Way` in an engine, of side³ granite spheres of a radius with contacts of an overlap [m].

    rounds: in each every way has its turn; steps: of a turn in LIGGGHTS and LAMMPS; force: near which edinburgh is fitted [N].
    """
    grain, own = Grain(radius, GRANITE, SURFACE), [Way("hertz", model="hertz"), *ways]
    given, contact = {**STONE, "radius": radius, "overlap": overlap}, grain.contact(grain)
    with tempfile.TemporaryDirectory() as scratch, quiet(), np.errstate(all="ignore"):
        if engine == "yade":
            return _in_yade(own, given, contact, scratch, side, rounds)
        given |= {"friction": 0.5, "mean_force": force}
        return _in_plugin(engine, own, given, contact, Path(scratch), side, rounds, steps, progress)


def _in_yade(ways, given, contact, scratch, side, repeats):
    described = [describe(way, scratch, contact, n) for n, way in enumerate(ways)]
    found = under_yade("costs/yade_cost.py", {**given, "side": side, "repeats": repeats, "ways": described})
    # other engines' share of a step does not depend on the law, what they measured on it is noise
    rest = min(f["rest"] / f["contacts"] for f in found)
    native = found[0]["loop"] / found[0]["contacts"] + rest
    # a functor of Mindlin's that does nothing: the remaining cost of the loop
    bare = min((f["nothing"] / f["contacts"] for f in found if f["nothing"]), default=math.nan)
    costs = []
    for way, f in zip(ways[1:], found[1:], strict=True):
        loop = f["loop"] / f["contacts"]
        if f["mindlin"] is None:
            step = loop + rest
            costs.append(StepCost(way, step, step / native, math.nan, (loop - bare) / step))
            continue
        # differences within one packing, on the scale of the native one
        added, model = (loop - f["mindlin"] / f["contacts"]), (loop - f["nothing"] / f["contacts"])
        step = native + added
        costs.append(StepCost(way, step, step / native, added / step, model / step))
    return costs


def header_cost(table, contact, largest, folder):
    """ns per contact of the law's step in the C++ header alone, at overlaps up to `largest` [m]."""
    program = folder / "cost"
    if not program.is_file():
        flags = [flag for flag in PLUGIN.flags if flag not in ("-fPIC", "-shared")]
        source = str(Path(__file__).with_name("cost.cpp"))
        command = [compiler() or "g++", *flags, "-march=native", f"-I{SHARED}", source, "-o", str(program), "-ldl"]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode:
            raise DemlawsError(f"cost.cpp did not compile: {done.stderr.strip()[:300]}")
    arguments = [table, contact.modulus, contact.radius, contact.roughness, largest, 4000, 200]
    done = subprocess.run([str(program), *map(str, arguments)], capture_output=True, text=True)
    if done.returncode:
        raise DemlawsError(f"the cost of {table} could not be measured: {done.stderr.strip()[:300]}")
    return float(done.stdout.split()[0])


def _contacts(engine, folder, given, way):
    """Lines of the contacts and the time step; the way's tables are written to `folder`."""
    described = {**way._asdict(), "options": dict(way.options)}
    if engine == "lammps":
        pairs = lammps_oedometer.model_lines(folder, given, described).pairs
        return "\n".join(["pair_style granular", *pairs, "timestep 1e-9\n"])
    model, words, more = liggghts_oedometer.model_lines(folder, given, described)
    young, poisson = (" ".join([f"{given[name]:.10g}"] * 3) for name in ("young", "poisson"))
    values = {"restitution": pairwise([1.0] * 5)[2:], "friction": pairwise([given["friction"]] * 5)[2:], "dt": 1e-9, "types": 3}
    return MATERIAL.format(model=model, words=words, more=more, young=young, poisson=poisson, **values)


def _in_plugin(engine, ways, given, contact, scratch, side, rounds, steps, progress):
    module, radius = import_module(f"demlaws.{engine}.run"), given["radius"]
    centres = close_packing(side, radius, given["overlap"])
    contacts = len(cKDTree(centres).query_pairs(2.0 * radius - 0.5 * given["overlap"]))
    given = {**given, "radii": [radius, 1.01 * radius]}  # two types and the walls', as in the scene; one of them occurs
    types = 2 if engine == "lammps" else 3
    block = liggghts_oedometer.data_of(centres, np.full(len(centres), radius), 3.0 * side * radius, given["density"], types)
    files, alone = [], []
    for number, way in enumerate(ways):
        folder = scratch / str(number)
        folder.mkdir()
        (folder / "start.data").write_text(block)
        values = {"head": HEADS[engine], "neighbours": NEIGHBOURS[engine], "skin": 0.1 * radius, "steps": steps}
        files.append(folder / "in.cost")
        files[-1].write_text(CASE.format(contacts=_contacts(engine, folder, given, way), **values))
        tables = sorted(folder.glob("*.tbl"))
        alone.append(header_cost(tables[0], contact, given["overlap"], scratch) if tables else math.nan)
    times = [[] for _ in ways]
    for _ in progress(range(rounds)):
        for way, file, own in zip(ways, files, times, strict=True):
            module.run(file, plugin=not way.model, log="log.cost")
            own.append(module.timings(file.with_name("log.cost")))
    step, pair = 1e9 / steps * np.min(times, axis=1).T
    rows = list(zip(ways, step.tolist(), pair.tolist(), alone, strict=True))
    return [StepCost(way, s / contacts, s / step[0], a * contacts / s, p / s) for way, s, p, a in rows[1:]]
