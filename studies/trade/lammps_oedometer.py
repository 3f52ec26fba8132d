"""The scene of `studies.trade.packings` in LAMMPS: one run a way of computing it, from the positions of the other engines."""

from pathlib import Path

import numpy as np

from demlaws.lammps.export import Models, models, wall_lines
from demlaws.lammps.run import HEAD, run
from demlaws.plugins.grains import Case
from studies.trade.liggghts_oedometer import EVERY, data_of, grains, held_state, numbers, timed

START = """\
boundary        f f f
newton          on
read_data       start.data
neighbor        4e-4 bin
neigh_modify    delay 0
pair_style      granular
"""
CASE = """\
timestep        {dt:.10g}
fix             gravity all gravity 9.81 vector 0 0 -1
fix             drag all viscous {drag:.10g}
{walls}
fix             move all nve/sphere
variable        upper atom z+radius
compute         top all reduce max v_upper
variable        top equal c_top
variable        centre equal xcm(all,z)
thermo_style    custom step v_centre v_top ke
thermo_modify   norm no lost error format float %.12g
thermo          1000
run             {settle}
variable        touching equal ${{top}}
variable        began equal $(step)
variable        way equal -{speed:.10g}*(step-${{began}})*dt
region          plate plane 0 0 ${{touching}} 0 0 -1 move NULL NULL v_way
{plates}
compute         pushed all reduce sum {columns}
variable        stress equal -({sum})/{area:.10g}
variable        height equal ${{touching}}+v_way
thermo_style    custom step v_stress v_height v_centre ke {named}
thermo_modify   norm no lost error format float %.12g
thermo          {every}
label           pressing
run             {every} post no
if              "${{stress}} >= {full:.10g}" then "jump SELF pressed"
jump            SELF pressing
label           pressed
variable        reached equal v_way
variable        low equal ${{reached}}
variable        way equal ${{low}}
run             {hold} post no
variable        least equal 0.8*${{stress}}
compute         contacts all pair/local force cutoff radius
dump            forces all local 1 post/forces.txt c_contacts
run             0 post no
undump          forces
variable        held equal $(step)
variable        way equal ${{low}}+{back:.10g}*(step-${{held}})*dt
label           easing
run             {every} post no
if              "${{stress}} < ${{least}}" then "jump SELF eased"
jump            SELF easing
label           eased
"""


def model_lines(folder, given, way):
    """`Models` of a way; its tables are written to `folder`."""
    two, friction = grains(given), given["friction"]
    if way["model"] == "hertz":
        words = f"hertz/material {given['young']:.12g} 0.0 {given['poisson']:g} tangential mindlin NULL 0.0"
        pairs = [f"pair_coeff * * {words} {friction:g} damping viscoelastic"]
        return Models(pairs, [f"{words} 0.0 damping viscoelastic"] * len(two))
    case = Case(way["law"], tuple(two), way["unloading"], dict(way["options"]), way["rtol"], restitution=1.0, friction=friction)
    return models(case, folder, wall_friction=0.0, tangential_damping=0.0)


def oedometer(folder, given, way, ranks=1):
    """One way through the test; what it wrote, as YADE's does (see studies.trade.packings.outcome)."""
    folder = Path(folder)
    (folder / "post").mkdir(parents=True, exist_ok=True)
    centres, radii, width = np.array(given["centres"]), np.array(given["radii"]), given["width"]
    (folder / "start.data").write_text(data_of(centres, radii, width, given["density"], types=2))
    said = model_lines(folder, given, way)
    walls = [
        ("floor", "wall/gran", "zplane 0.0 NULL"),
        ("sides", "wall/gran", f"xplane 0.0 {width:.10g}"),
        ("faces", "wall/gran", f"yplane 0.0 {width:.10g}"),
    ]
    plates = wall_lines(said, [("plate", "wall/gran/region", "region plate contacts")])
    names = [line.split()[1] for line in plates if line.startswith("fix")]
    pushed = [f"c_pushed[{n + 1}]" for n in range(len(names))] if len(names) > 1 else ["c_pushed"]
    values = {
        **numbers(given),
        "walls": "\n".join(wall_lines(said, walls)),
        "plates": "\n".join(line for line in plates if line.startswith("fix")),
        "columns": " ".join(f"f_{name}[4]" for name in names),
        "sum": "+".join(pushed),
        "named": " ".join(pushed),
        "hold": round(given["hold"] / given["dt"] / EVERY) * EVERY,
    }
    text = HEAD + START + "\n".join(said.pairs) + "\n" + CASE.format(**values)
    (folder / "in.oedometer").write_text(text)
    log, seconds = timed(lambda: run(folder / "in.oedometer", ranks, plugin=way["model"] != "hertz"))
    forces = np.abs(np.loadtxt(folder / "post" / "forces.txt", skiprows=9))
    rows = np.stack([log["height"], log["stress"]], 1)
    peak = int(np.argmax(log["stress"] >= given["stress"]))
    end = int(np.argmin(np.abs(log["Step"] - log["Step"][peak] - values["hold"])))
    return {
        "height": float(log["centre"][0]),
        "branches": [rows[: peak + 1].tolist(), rows[end:].tolist()],
        "held": {**held_state(given, forces), "plate": float(rows[end, 0]), "stress": float(rows[end, 1])},
        "steps": int(log["Step"][-1]),
        "seconds": seconds,
    }
