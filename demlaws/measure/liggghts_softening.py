"""Runs of `demlaws.measure.softening` in LIGGGHTS: the oedometer and its cycles, and a pour."""

from pathlib import Path

import numpy as np

from demlaws.advice.soften import Softening
from demlaws.contact import Material, Surface
from demlaws.liggghts.export import Grain
from demlaws.materials import GRANITE
from demlaws.measure.liggghts_oedometer import CASE, DRAG, carry_out, prepare

RTOL = 1e-5  # of the tables
_PRESSING = CASE.index("thermo_style    custom step v_stress")
_DRIVE = "fix             drive all move/mesh mesh plate linear 0. 0. -{speed:.10g}\n"
CYCLES = (
    CASE[:_PRESSING].replace(_DRIVE, "")
    + """\
variable        sense equal -1.0
thermo_style    custom step v_stress v_touched v_sense
thermo_modify   norm no lost ignore format float %.12g
thermo          {every}
variable        turn loop {cycles}
label           again
variable        sense equal -1.0
fix             drive all move/mesh mesh plate linear 0. 0. -{speed:.10g}
label           pressing
run             {every}
if              "${{stress}} >= {full:.10g}" then "jump SELF pressed"
jump            SELF pressing
label           pressed
unfix           drive
variable        sense equal 0.0
if              "${{turn}} > 1" then "jump SELF held"
run             {hold}
dump            forces all local 1 post/forces.txt c_contacts[1] c_contacts[2] c_contacts[3]
run             0
undump          forces
label           held
variable        sense equal 1.0
fix             drive all move/mesh mesh plate linear 0. 0. {speed:.10g}
label           easing
run             {every}
if              "${{stress}} < {least:.10g}" then "jump SELF eased"
jump            SELF easing
label           eased
unfix           drive
next            turn
jump            SELF again
"""
)


POUR = (
    CASE[: CASE.index("variable        touching")]
    + """\
dump            forces all local 1 post/forces.txt c_contacts[1] c_contacts[2] c_contacts[3]
run             0
"""
)
AIR = 30.0  # of a falling grain's speed [1/s]: it lands at a third of what it would freely, and has come to rest in the time


def _made(scene, told, places):
    """(what `prepare` is given, way, centres) of a run whose grains start at `places` of the scene."""
    random = np.random.default_rng(told["copy"])
    centres = np.array(scene[places])
    centres = centres + told["shake"] * random.uniform(-1.0, 1.0, centres.shape)
    material = Material(told["young"], GRANITE.poisson, GRANITE.hardness, GRANITE.density)
    two = [Grain(radius, material, Surface(**told["surface"])) for radius in sorted(set(scene["radii"]))]
    way = {"model": "", "law": told["law"], "unloading": told["unloading"], "options": told["options"], "rtol": RTOL}
    return {**scene, **told, "grains": two, "poisson": GRANITE.poisson}, way, centres


def pour(folder, scene, told):
    """A loose block falls and comes to rest; what it wrote, as YADE's does (see yade_softening.py)."""
    given, way, centres = _made(scene, told, "loose")
    path = Path(folder) / "in.pour"
    log, forces, seconds = carry_out(path, prepare(path, {**given, "settle": told["time"]}, way, centres, POUR, AIR))
    held = {
        "forces": forces.tolist(),
        "coordination": 2.0 * forces.size / len(scene["radii"]),
        "kinetic": float(log["KinEng"][-1]),
    }
    return {"height": float(log["centre"][-1]), "held": held, "steps": int(log["Step"][-1]), "seconds": seconds}


def cycles(folder, scene, told):
    """One run; what it wrote, as YADE's does (see yade_softening.py)."""
    given, way, centres = _made(scene, told, "centres")
    drag = DRAG / told["size"] / Softening(told["factor"]).step  # the same share of speed in a contact's own period
    path = Path(folder) / "in.cycles"
    own = {name: told[name] for name in ("least", "every", "cycles")}
    log, forces, seconds = carry_out(path, prepare(path, given, way, centres, CYCLES, drag, **own))
    step, stress, sense = log["Step"], log["stress"], log["sense"]
    # the first row of a run repeats the last of the one before, with the sense in which it then goes
    height = log["touched"] + np.append(0.0, np.cumsum(sense[1:] * np.diff(step))) * told["speed"] * told["dt"]
    turns = np.flatnonzero((sense[1:] != sense[:-1]) & (sense[1:] != 0.0)) + 1
    branches = [part.tolist() for part in np.split(np.stack([height, stress], 1), turns)]
    if len(branches) != 2 * told["cycles"]:
        raise RuntimeError(f"{len(branches)} branches of {told['cycles']} cycles")
    kept = np.flatnonzero(sense == 0.0)
    end = int(kept[-1]) if kept.size else int(turns[0])
    return {
        "top": float(height[0]),
        "branches": branches,
        "held": {
            "forces": forces.tolist(),
            "coordination": 2.0 * forces.size / len(scene["radii"]),
            "plate": float(height[end]),
            "stress": float(stress[end]),
        },
        "steps": int(step[-1]),
        "seconds": seconds,
    }
