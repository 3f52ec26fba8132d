"""Runs of `studies.softening.study` in LIGGGHTS: the oedometer and its cycles, a pour, and shear to the peak."""

from pathlib import Path

import numpy as np

from demlaws.advice.soften import Softening
from demlaws.contact import Material, Surface
from demlaws.grains import Grain
from demlaws.materials import GRANITE
from studies.trade.liggghts_oedometer import (
    CASE,
    DRAG,
    EDGE,
    FORCES,
    TOUCHING,
    carry_out,
    contact_forces,
    flat,
    held_state,
    prepare,
    press,
)

RTOL = 1e-5  # of the tables
POUR = CASE + FORCES.format(name="forces")
_SERVO = (
    "fix             {name} all mesh/surface/stress/servo file {name}.stl type 3 move {at} com {at} ctrlPV force axis {axis} "
    "target_val v_push_{name} vel_max {{fastest:.10g}} kp {{stiff:.10g}}\n"
)
SHEAR = (
    CASE
    + TOUCHING
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
"""
    + FORCES.format(name="before")
    + """\
variable        sheared equal 1.0
variable        goal equal 1e9
variable        last equal {left:.10g}*${{z}}
fix_modify      plate servo/vel_max {speed:.10g}
label           shearing
run             {every}
if              "${{z}} <= ${{last}}" then "jump SELF sheared"
jump            SELF shearing
label           sheared
"""
    + FORCES.format(name="forces")
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


def pour(folder, scene, told):
    """A loose block falls and comes to rest; what it wrote, as YADE's does (see yade_softening.py)."""
    given, way, centres = _made(scene, told, "loose")
    path = Path(folder) / "in.pour"
    log, forces, seconds = carry_out(path, prepare(path, {**given, "settle": told["time"]}, way, centres, POUR, AIR))
    held = {**held_state(scene, forces), "kinetic": float(log["KinEng"][-1])}
    return {"height": float(log["centre"][-1]), "held": held, "steps": int(log["Step"][-1]), "seconds": seconds}


def _drag(told):
    """The same share of speed in a contact's own period [1/s]."""
    return DRAG / told["size"] / Softening(told["factor"]).step


def cycles(folder, scene, told):
    """One run; what it wrote, as YADE's does (see yade_softening.py)."""
    given, way, centres = _made(scene, told, "centres")
    own = {name: told[name] for name in ("least", "every", "cycles")}
    return press(Path(folder) / "in.cycles", given, way, centres, _drag(told), **own)


def shear(folder, scene, told):
    """Isotropic compression, then the plate comes down between sides kept at their stress; as yade_softening.py has it."""
    given, way, centres = _made(scene, told, "centres")
    path = Path(folder) / "in.shear"
    stiff = told["gain"] / told["fastest"]
    more = {"stiff": stiff, "fastest": told["fastest"], "every": LOOKS, "most": MOST, "left": 1.0 - told["strain"]}
    plugin = prepare(path, given, way, centres, SHEAR, _drag(told), **more)
    spans = (-EDGE, scene["width"] + EDGE), (-EDGE, 1.5 * centres[:, 2].max() + EDGE)
    for axis, name in enumerate(("right", "rear")):
        (path.parent / f"{name}.stl").write_text(flat(axis, *spans))
    log, forces, seconds = carry_out(path, plugin)
    before = held_state(scene, contact_forces(path.parent / "post" / "before.txt"))
    down = np.flatnonzero((log["sheared"] == 1.0) & np.append(np.diff(log["Step"]) > 0, True))  # a run repeats the last row
    columns = ("across_x", "across_y", "across_z", "x", "y", "z")
    return {
        "before": {"coordination": before["coordination"]},
        "held": held_state(scene, forces),
        "rows": np.stack([log[name][down] for name in columns], 1).tolist(),
        "steps": int(log["Step"][-1]),
        "seconds": seconds,
    }
