"""Runs of `demlaws.measure.softening` in LIGGGHTS: the oedometer and its cycles."""

import resource
from pathlib import Path

import numpy as np

from demlaws.advice.soften import Softening
from demlaws.contact import Material, Surface
from demlaws.liggghts.build import library_path
from demlaws.liggghts.export import Grain
from demlaws.liggghts.run import HEAD, run
from demlaws.materials import GRANITE
from demlaws.measure.liggghts_oedometer import CASE, DRAG, MATERIAL, START, _data, _plate, model_lines, pairwise

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


def cycles(folder, scene, told):
    """One run; what it wrote, as YADE's does (see yade_softening.py)."""
    folder = Path(folder)
    (folder / "post").mkdir(parents=True, exist_ok=True)
    random = np.random.default_rng(told["copy"])
    centres, radii, width = np.array(scene["centres"]), np.array(scene["radii"]), scene["width"]
    centres = centres + told["shake"] * random.uniform(-1.0, 1.0, centres.shape)
    material = Material(told["young"], GRANITE.poisson, GRANITE.hardness, GRANITE.density)
    two = [Grain(radius, material, Surface(**told["surface"])) for radius in sorted(set(scene["radii"]))]
    way = {"model": "", "law": told["law"], "unloading": told["unloading"], "options": told["options"], "rtol": RTOL}
    (folder / "start.data").write_text(_data(centres, radii, width, scene["density"]))
    (folder / "plate.stl").write_text(_plate(width))
    model, words, more = model_lines(folder, {**scene, "grains": two}, way)
    friction, none = scene["friction"], 0.0
    drag = DRAG / told["size"] / Softening(told["factor"]).step  # the same share of speed in a contact's own period
    values = {
        "model": model,
        "words": words,
        "more": more,
        "types": 3,
        "young": " ".join([f"{told['young']:.10g}"] * 3),
        "poisson": " ".join([f"{GRANITE.poisson:.10g}"] * 3),
        "restitution": pairwise([1.0] * 5)[2:],
        "friction": pairwise([friction, friction, friction, none, none])[2:],
        "dt": told["dt"],
        "drag": drag * scene["density"] * 4 / 3 * np.pi * min(radii) ** 3,
        "width": width,
        "area": width * width,
        "settle": round(told["settle"] / told["dt"]),
        "speed": told["speed"],
        "full": told["stress"],
        "least": told["least"],
        "hold": round(told["hold"] / told["dt"]),
        "every": told["every"],
        "cycles": told["cycles"],
    }
    (folder / "in.cycles").write_text((HEAD + START + MATERIAL + CYCLES).format(**values))
    library_path()  # compiled before the clock starts
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    log = run(folder / "in.cycles", plugin=model == "demlaws/table")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    forces = np.linalg.norm(np.loadtxt(folder / "post" / "forces.txt", skiprows=9), axis=1)
    forces = forces[forces > 0.0]
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
            "coordination": 2.0 * forces.size / len(radii),
            "plate": float(height[end]),
            "stress": float(stress[end]),
        },
        "steps": int(step[-1]),
        "seconds": after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime,
    }
