"""The rows that LIGGGHTS computes: one run a job, with a table of the job's law made to 1e-9."""

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from demlaws.liggghts.run import HEAD, run
from studies.trade.liggghts_oedometer import data_text
from studies.validation.arrays import CELLS, EDGE, RIGID, SITES
from studies.validation.jobs import STOCK, bound, contact_of, quiet

MATERIAL = """\
fix             m1 all property/global youngsModulus peratomtype {young:.17g} {rigid:.17g}
fix             m2 all property/global poissonsRatio peratomtype {poisson:.17g} {poisson:.17g}
fix             m3 all property/global coefficientRestitution peratomtypepair 2 {restitution}
fix             m4 all property/global coefficientFriction peratomtypepair 2 {friction}
pair_style      gran model demlaws/table {words} limitForce off
pair_coeff      * *
timestep        {dt:.17g}
"""
IMPACT = """\
region          box block -{far:.17g} {far:.17g} -{far:.17g} {far:.17g} -{far:.17g} {far:.17g} units box
create_box      2 box
neighbor        {skin:.17g} bin
neigh_modify    delay 0
{material}{bodies}
fix             move all nve/sphere
group           last id {last}
compute         push last reduce sum fz
variable        force equal c_push
variable        speed equal {between}
variable        place equal z[{last}]
thermo_style    custom step v_force v_speed v_place
thermo_modify   format float %.17e lost ignore norm no
thermo          1
run             {steps}
"""
COLLISIONS = """\
read_data       start.data
neighbor        {skin:.17g} bin
neigh_modify    delay 0
{material}{plane}
fix             move all nve/sphere
dump            last all custom {steps} last.dump id vx vz omegay
dump_modify     last sort id format {line}"%d %.17g %.17g %.17g"
run             {steps}
"""
ARRAY = """\
read_data       start.data
neighbor        {skin:.17g} bin
neigh_modify    delay 0
{material}compute         warm all temp
compute         push all pressure warm virial
variable        xx equal c_push[1]
variable        yy equal c_push[2]
variable        zz equal c_push[3]
variable        edge equal lx
thermo_style    custom step v_edge v_xx v_yy v_zz
thermo_modify   format float %.17e norm no
thermo          1
"""
# without velocities: positions follow the box exactly, and only normal forces change
SQUEEZE = """\
fix             strain all deform 1 {sides} remap x
run             {steps}
unfix           strain
"""
# with them, so that tangential springs act; contacts across the box's sides lag by a step
PROBE = """\
fix             move all nve/sphere
{ramps}fix             strain all deform 1 {sides} remap v
run             {steps}
unfix           strain
unfix           move
velocity        all set 0 0 0
"""


class Engine(NamedTuple):
    """What differs between LIGGGHTS and LAMMPS, which take the same inputs but for the contacts."""

    head: str
    material: Callable  # (job, folder) → the lines up to the time step; writes the table
    plane: Callable  # job → the fix of the rigid plane z = 0
    run: Callable
    line: str  # word before the format of a line in dump_modify


def save_table(job, folder):
    """The table of a job's law, to 1e-9, as law.tbl."""
    one = bound(job["law"], contact_of(job), job["unloading"], **job["options"])
    quiet(one.tabulate, 1e-9).save(folder / "law.tbl")


def _words(job):
    """The models of a contact: a table with the tangential model of LIGGGHTS, or with ours."""
    shear = job.get("shear", STOCK)
    return "tangential history table law.tbl" if shear == STOCK else f"tangential demlaws table law.tbl shear {shear}"


def _material(job, folder):
    def four(value):
        return f"{value} {value} {value} {value}"

    save_table(job, folder)
    return MATERIAL.format(
        rigid=RIGID * job["young"],
        words=_words(job),
        **(job | {"restitution": four(job.get("restitution", 1)), "friction": four(job.get("friction", 10))}),
    )


def _plane(job):
    tangential, rest = _words(job).split(" table ")
    return f"fix plane all wall/gran model demlaws/table {tangential} primitive type 2 zplane 0.0 table {rest} limitForce off"


LIGGGHTS = Engine(HEAD, _material, _plane, run, "")


def collisions(job, folder, engine=LIGGGHTS):
    """Velocities sideways and away, and ω R [m/s] of spheres after each collision of `in_yade.collisions`."""
    radius, other, count = job["radius"], job["other"], len(job["motions"])
    far = 3.0 * max(radius, other)
    spheres = [(1, 2 * radius, job["density"], n * far, 0.0, radius * (1.0 + 1e-9)) for n in range(count)]
    moving = [(sideways, 0.0, -down, 0.0, spin / radius, 0.0) for down, sideways, spin in job["motions"]]
    if other:
        spheres += [(1, 2 * other, job["other_density"], n * far, 0.0, -other) for n in range(count)]
        moving += [(0.0, 0.0, 0.0, 0.0, job["other_spin"] * spin / other, 0.0) for *_, spin in job["motions"]]
    (folder / "start.data").write_text(data_text(((-far, count * far), (-far, far), (-far, far)), spheres, moving))
    values = {"skin": 0.1 * radius, "steps": 3 * job["steps"], "line": engine.line}
    plane = "" if other else engine.plane(job)
    text = engine.head + COLLISIONS.format(material=engine.material(job, folder), plane=plane, **values)
    (folder / "in.collisions").write_text(text)
    engine.run(folder / "in.collisions")
    rows = (folder / "last.dump").read_text().splitlines()[-(2 * count if other else count) :][:count]
    found = np.array([row.split() for row in rows], dtype=float)
    return (found[:, 1:] * (1.0, 1.0, radius)).tolist()


def impact(job, folder, engine=LIGGGHTS):
    """Peak force [N] and rebound over approach speed of two spheres, or of one and a rigid plane; places after given steps."""
    radius, apart = job["radius"], job["gap"] if "gap" in job else 1e-3 * job["overlap"]
    material = engine.material(job, folder)
    place = [radius + apart] if job["plane"] else [-radius - 0.5 * apart, radius + 0.5 * apart]
    speed = [-job["speed"]] if job["plane"] else [0.5 * job["speed"], -0.5 * job["speed"]]
    lines = [f"create_atoms 1 single 0 0 {z:.17g} units box" for z in place]
    lines += [f"set group all diameter {2 * radius:.17g} density {job['density']:.17g}"]
    for number, v in enumerate(speed, start=1):
        lines += [f"group one{number} id {number}", f"velocity one{number} set 0 0 {v:.17g}"]
    if job["plane"]:
        lines.append(engine.plane(job))
    between = "vcm(one1,z)" if job["plane"] else "vcm(one2,z)-vcm(one1,z)"
    values = {"far": 4 * radius, "skin": 0.1 * radius, "last": len(place), "between": between}
    values["steps"] = job["steps"] if "after" in job else 2 * job["steps"]
    (folder / "in.impact").write_text(engine.head + IMPACT.format(material=material, bodies="\n".join(lines), **values))
    log = engine.run(folder / "in.impact")
    if "after" in job:
        return {"places": [float(log["place"][list(log["Step"]).index(step)]) for step in job["after"]]}
    return {"peak": float(log["force"].max()), "restitution": float(log["speed"][-1] / job["speed"])}


def lattice(job, folder, engine=LIGGGHTS):
    """A periodic array along a path of strains: for each, rows of (overlap of the contacts, stress tensor)."""
    radius = job["radius"]
    edge = EDGE[job["array"]] * radius * (1.0 + 1e-9)
    whole = CELLS * edge
    places = [
        [(c + s + 0.25) * edge for c, s in zip(cell, site, strict=True)]
        for cell in np.ndindex(CELLS, CELLS, CELLS)
        for site in SITES[job["array"]]
    ]
    atoms = [(1, 2 * radius, job["density"], *place) for place in places]
    (folder / "start.data").write_text(data_text([(0.0, whole)] * 3, atoms))
    text = engine.head.replace("boundary        f f f", "boundary        p p p")
    text += ARRAY.format(skin=0.1 * radius, material=engine.material(job, folder))
    path = {name: gradient for name, gradient in job["path"].items() if name != "shear"}
    for name, gradient in path.items():
        rates = {a: gradient[k][k] / (job["steps"] * job["dt"]) for k, a in enumerate("xyz") if gradient[k][k]}
        for a, rate in rates.items():
            text += f"variable        v{a} equal {rate:.17g}*l{a}\nvariable        w{a} equal ${{v{a}}}\n"
        sides = " ".join(f"{a} vel ${{w{a}}}" for a in rates)
        if name == "uniaxial":
            ramps = "variable        low equal xlo\nvariable        high equal xhi\n"
            ramps += "velocity        all ramp vx 0 ${wx} x ${low} ${high} units box\n"
            text += PROBE.format(ramps=ramps, sides=sides, steps=job["steps"])
        else:
            text += SQUEEZE.format(sides=sides, steps=job["steps"])
        text += "".join(f"variable        {v}{a} delete\n" for a in rates for v in "vw")
    (folder / "in.array").write_text(text)
    log = engine.run(folder / "in.array")
    # fix deform moves the box at the end of a step: the grains are still where the row before says
    edges = np.append(whole, log["edge"][:-1])
    distance = edges / CELLS * 2.0 / EDGE[job["array"]]
    stress = [np.diag([-log[k][i] for k in ("xx", "yy", "zz")]).tolist() for i in range(log["Step"].size)]
    found = {}
    for number, name in enumerate(path):
        rows = slice(number * job["steps"] + (1 if number else 0), (number + 1) * job["steps"] + 1)
        overlap = (2.0 * radius - distance)[rows]
        found[name] = [(float(d), s) for d, s in zip(overlap, stress[rows], strict=True) if d > 0.0]
    return found


KINDS = {"impact": impact, "lattice": lattice, "collisions": collisions}


def answer(jobs, engine=LIGGGHTS):
    """What each job gives, as in_yade.py answers."""
    found = []
    for job in jobs:
        with tempfile.TemporaryDirectory() as scratch:
            found.append(KINDS[job["kind"]](job, Path(scratch), engine))
    return found
