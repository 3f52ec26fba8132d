"""Runs of `studies.softening.study` in LIGGGHTS: the oedometer and its cycles, a pour, and shear to the peak."""

from pathlib import Path

import numpy as np

from demlaws.advice.soften import Softening
from demlaws.contact import Material, Surface
from demlaws.grains import Grain
from demlaws.materials import GRANITE
from studies.trade.liggghts_oedometer import CASE, DRAG, EDGE, carry_out, contact_forces, flat, prepare

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
_SERVO = (
    "fix             {name} all mesh/surface/stress/servo file {name}.stl type 3 move {at} com {at} ctrlPV force axis {axis} "
    "target_val v_push_{name} vel_max {{fastest:.10g}} kp {{stiff:.10g}}\n"
)
SHEAR = (
    CASE[: CASE.index("fix             plate all mesh")]
    + """\
unfix           gravity
unfix           right
unfix           rear
variable        goal equal 1.0
variable        push_right equal -{full:.10g}*v_area_x
variable        push_rear equal -{full:.10g}*v_area_y
variable        push_plate equal -{full:.10g}*v_area_z*v_goal
"""
    + _SERVO.format(name="right", at="{width:.10g} 0. 0.", axis="1. 0. 0.")
    + _SERVO.format(name="rear", at="0. {width:.10g} 0.", axis="0. 1. 0.")
    + _SERVO.format(name="plate", at="0. 0. ${{touching}}", axis="0. 0. 1.")
    + """\
fix             press all wall/gran model {model} tangential history mesh n_meshes 3 meshes right rear plate {words}
variable        x equal f_right[7]
variable        y equal f_rear[8]
variable        z equal f_plate[9]
variable        area_x equal v_y*v_z
variable        area_y equal v_x*v_z
variable        area_z equal v_x*v_y
variable        across_x equal f_right[1]/v_area_x
variable        across_y equal f_rear[2]/v_area_y
variable        across_z equal f_plate[3]/v_area_z
variable        off_x equal v_across_x/{full:.10g}-1.0
variable        off_y equal v_across_y/{full:.10g}-1.0
variable        off_z equal v_across_z/{full:.10g}-1.0
variable        there equal "(v_off_x*v_off_x < 4e-4) && (v_off_y*v_off_y < 4e-4) && (v_off_z*v_off_z < 4e-4)"
variable        sheared equal 0.0
thermo_style    custom step v_sheared v_across_x v_across_y v_across_z v_x v_y v_z ke
thermo_modify   norm no lost ignore format float %.12g
thermo          {every}
run             1000
variable        tries loop {most}
label           pressing
run             {every}
if              "${{there}} > 0.5" then "jump SELF pressed"
next            tries
jump            SELF pressing
the_walls_have_not_come_to_their_stress
label           pressed
dump            before all local 1 post/before.txt c_contacts[1] c_contacts[2] c_contacts[3]
run             0
undump          before
variable        sheared equal 1.0
variable        goal equal 1e9
variable        last equal {left:.10g}*${{z}}
fix_modify      plate servo/vel_max {speed:.10g}
label           shearing
run             {every}
if              "${{z}} <= ${{last}}" then "jump SELF sheared"
jump            SELF shearing
label           sheared
dump            forces all local 1 post/forces.txt c_contacts[1] c_contacts[2] c_contacts[3]
run             0
"""
)
LOOKS = 100  # steps between two readings of the walls
MOST = 20_000  # looks until the walls have come to their stress
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


def _held(scene, forces):
    """Forces [N] between grains, and how many contacts a grain has."""
    return {"forces": forces.tolist(), "coordination": 2.0 * forces.size / len(scene["radii"])}


def pour(folder, scene, told):
    """A loose block falls and comes to rest; what it wrote, as YADE's does (see yade_softening.py)."""
    given, way, centres = _made(scene, told, "loose")
    path = Path(folder) / "in.pour"
    log, forces, seconds = carry_out(path, prepare(path, {**given, "settle": told["time"]}, way, centres, POUR, AIR))
    held = {**_held(scene, forces), "kinetic": float(log["KinEng"][-1])}
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
            **_held(scene, forces),
            "plate": float(height[end]),
            "stress": float(stress[end]),
        },
        "steps": int(step[-1]),
        "seconds": seconds,
    }


def shear(folder, scene, told):
    """Isotropic compression, then the plate comes down between sides kept at their stress; as yade_softening.py has it."""
    given, way, centres = _made(scene, told, "centres")
    drag = DRAG / told["size"] / Softening(told["factor"]).step
    path = Path(folder) / "in.shear"
    stiff = told["gain"] / told["fastest"]
    more = {"stiff": stiff, "fastest": told["fastest"], "every": LOOKS, "most": MOST, "left": 1.0 - told["strain"]}
    plugin = prepare(path, given, way, centres, SHEAR, drag, **more)
    spans = (-EDGE, scene["width"] + EDGE), (-EDGE, 1.5 * centres[:, 2].max() + EDGE)
    for axis, name in enumerate(("right", "rear")):
        (path.parent / f"{name}.stl").write_text(flat(axis, *spans))
    log, forces, seconds = carry_out(path, plugin)
    before = _held(scene, contact_forces(path.parent / "post" / "before.txt"))
    down = np.flatnonzero((log["sheared"] == 1.0) & np.append(np.diff(log["Step"]) > 0, True))  # a run repeats the last row
    columns = ("across_x", "across_y", "across_z", "x", "y", "z")
    return {
        "before": {"coordination": before["coordination"]},
        "held": _held(scene, forces),
        "rows": np.stack([log[name][down] for name in columns], 1).tolist(),
        "steps": int(log["Step"][-1]),
        "seconds": seconds,
    }
