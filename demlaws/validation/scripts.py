"""The rows of engines that read input scripts, LIGGGHTS and LAMMPS: one run a job; they differ in a few lines (`Engine`)."""

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from demlaws.validation.arrays import CELLS, EDGE, SITES
from demlaws.validation.jobs import bound, contact_of, quiet


class Engine(NamedTuple):
    """What one engine says its own way."""

    head: str  # the first lines of an input, with {boundary}
    types: int  # of atoms: a wall's material is one
    material: Callable  # job, folder → lines of materials, pair style and time step; the law's table is written to the folder
    plane: Callable  # job → line of a rigid plane at z = 0
    run: Callable  # input file → columns of its log


def save_table(job, folder):
    """A table of the job's law, made to 1e-9, in the folder of its run."""
    one = bound(job["law"], contact_of(job), job["unloading"], **job["options"])
    quiet(one.tabulate, 1e-9).save(folder / "law.tbl")


IMPACT = """\
region          box block -{far:.17g} {far:.17g} -{far:.17g} {far:.17g} -{far:.17g} {far:.17g} units box
create_box      {types} box
neighbor        {skin:.17g} bin
neigh_modify    delay 0
{material}{bodies}
fix             move all nve/sphere
group           last id {last}
compute         push last reduce sum fz
variable        force equal c_push
variable        speed equal {between}
thermo_style    custom step v_force v_speed
thermo_modify   format float %.17e lost ignore norm no
thermo          1
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


def impact(engine, job, folder):
    """Peak force [N] and rebound over approach speed of two spheres, or of one and a rigid plane."""
    radius, apart = job["radius"], 1e-3 * job["overlap"]
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
    values = {"far": 4 * radius, "skin": 0.1 * radius, "last": len(place), "between": between, "steps": 2 * job["steps"]}
    values["types"] = engine.types
    (folder / "in.impact").write_text(
        engine.head.format(boundary="f f f") + IMPACT.format(material=material, bodies="\n".join(lines), **values)
    )
    log = engine.run(folder / "in.impact")
    force = log["force"]
    parted = bool(np.any((np.maximum.accumulate(force) > 0.0) & (force == 0.0)))
    return {"peak": float(force.max()), "restitution": float(log["speed"][-1] / job["speed"]), "parted": parted}


def lattice(engine, job, folder):
    """A periodic array along a path of strains: for each, rows of (overlap of the contacts, stress tensor)."""
    radius = job["radius"]
    edge = EDGE[job["array"]] * radius * (1.0 + 1e-9)
    whole = CELLS * edge
    places = [
        [(c + s + 0.25) * edge for c, s in zip(cell, site, strict=True)]
        for cell in np.ndindex(CELLS, CELLS, CELLS)
        for site in SITES[job["array"]]
    ]
    lines = ["array", "", f"{len(places)} atoms", f"{engine.types} atom types", ""]
    lines += [f"0 {whole:.17g} {a}lo {a}hi" for a in "xyz"] + ["", "Atoms", ""]
    for number, place in enumerate(places, start=1):
        x, y, z = (f"{v:.17g}" for v in place)
        lines.append(f"{number} 1 {2 * radius:.17g} {job['density']:.17g} {x} {y} {z}")
    (folder / "start.data").write_text("\n".join(lines) + "\n")
    text = engine.head.format(boundary="p p p")
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


KINDS = {"impact": impact, "lattice": lattice}


def answer(engine, jobs):
    """What each job gives, as in_yade.py answers."""
    found = []
    for job in jobs:
        with tempfile.TemporaryDirectory() as scratch:
            found.append(KINDS[job["kind"]](engine, job, Path(scratch)))
    return found
