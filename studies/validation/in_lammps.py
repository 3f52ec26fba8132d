"""The rows that LAMMPS computes: those of LIGGGHTS, whose inputs it takes but for the lines of the contacts."""

import tempfile
from pathlib import Path
from typing import NamedTuple

from demlaws.contact import Contact
from demlaws.lammps.run import HEAD, run
from demlaws.laws.names import HERTZ
from studies.validation import in_liggghts
from studies.validation.arrays import RIGID
from studies.validation.published import bound
from studies.validation.row import near

CONTACT = "tangential mindlin NULL 1 10 damping demlaws/tangent"
MATERIAL = """\
pair_style      granular
pair_coeff      * * demlaws/table law.tbl {young:.17g} 1 {poisson:.17g} {contact}
timestep        {dt:.17g}
"""


def _material(job, folder):
    in_liggghts.save_table(job, folder)
    return MATERIAL.format(contact=CONTACT, **job)


def _plane(job):
    bodies = f"{job['young']:.17g} 1 {job['poisson']:.17g} against {RIGID * job['young']:.17g} {job['poisson']:.17g}"
    return f"fix plane all wall/gran granular demlaws/table law.tbl {bodies} {CONTACT} zplane 0.0 NULL"


LAMMPS = in_liggghts.Engine(HEAD + "boundary        f f f\nnewton          off\n", _material, _plane, run)


def answer(jobs):
    """What each job gives, as in_yade.py answers."""
    return in_liggghts.answer(jobs, LAMMPS)


class Oblique(NamedTuple):
    """An oblique impact on a wall that LAMMPS's tests keep (dem04): x and z [m], v_x and v_z [m/s] after so many steps."""

    name: str
    tangential: str
    steps: int
    kept: tuple


OBLIQUE = (
    Oblique(
        "dem04-mindlin-oblique", "mindlin", 3300,
        (7.7638651345996810e-05, 2.5067258974728027e-03, 1.9626460766213021, 2.9278423105668629),
    ),
    Oblique(
        "dem04-mindlinrescale-oblique", "mindlin_rescale", 3317,
        (7.7972301179679522e-05, 2.5072236306699839e-03, 1.9626460766007514, 2.9278423115198366),
    ),
)  # fmt: skip
OBLIQUE_TOLERANCE = 1e-9
"""The releases differ: LAMMPS of 22 Jul 2025 with its own hertz/material is 5e-10 from what that of 4 Jul 2026 keeps."""
OBLIQUE_INPUT = """\
boundary        p p f
region          box block -0.2 0.2 -0.05 0.05 -0.05 0.1 units box
create_box      1 box
create_atoms    1 single 0 0 0.00255 units box
set             group all diameter 0.005 density 2700
velocity        all set 2.5069 0 -2.9876
neighbor        0.001 bin
neigh_modify    delay 0
timestep        1e-8
pair_style      granular
pair_coeff      * * {contact}
fix             move all nve/sphere
fix             plane all wall/gran granular {contact} zplane 0.0 NULL
variable        x equal x[1]
variable        z equal z[1]
variable        u equal vx[1]
variable        w equal vz[1]
thermo_style    custom step v_x v_z v_u v_w
thermo_modify   format float %.17e norm no
thermo          {steps}
run             {steps}
"""


def oblique(one, normal="demlaws/table law.tbl"):
    """x, z, v_x, v_z after the impact, with the table of Hertz's law, or another normal model, in place of hertz/material."""
    young, poisson = 7e10, 0.33
    contact = f"{normal} {young:g} 0.98 {poisson} tangential {one.tangential} NULL 0.5 0.092 damping coeff_restitution"
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        bound(HERTZ, Contact(0.0025, 0.5 * young / (1.0 - poisson**2))).tabulate(1e-9).save(folder / "law.tbl")
        (folder / "in.oblique").write_text(HEAD + OBLIQUE_INPUT.format(contact=contact, steps=one.steps))
        log = run(folder / "in.oblique")
        return [float(log[name][-1]) for name in "xzuw"]


def oblique_rows():
    """Rows of the oblique impacts that LAMMPS's tests keep, with our normal model and LAMMPS's own shear and damping."""
    for one in OBLIQUE:
        for quantity, unit, kept, found in zip(
            ("x", "z", "v_x", "v_z"), ("m", "m", "m/s", "m/s"), one.kept, oblique(one), strict=True
        ):
            yield near(
                f"{one.name}, {quantity} after {one.steps} steps",
                "LAMMPS",
                kept,
                found,
                OBLIQUE_TOLERANCE,
                "lammps-oblique",
                unit,
            )
