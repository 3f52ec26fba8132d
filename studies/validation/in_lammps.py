"""The rows that LAMMPS computes: those of LIGGGHTS, whose inputs it takes but for the lines of the contacts."""

from demlaws.lammps.run import HEAD, run
from studies.validation import in_liggghts
from studies.validation.arrays import RIGID
from studies.validation.jobs import STOCK

MATERIAL = """\
pair_style      granular
pair_coeff      * * {contact}
timestep        {dt:.17g}
"""


def _contact(job, bodies=""):
    """The words of a contact; `bodies`: of the other body, where it differs."""
    shear, table = job.get("shear", STOCK), "demlaws/table law.tbl"
    material = f"{job['young']:.17g} {job.get('restitution', 1)} {job['poisson']:.17g}{bodies}"
    more = "tangential mindlin NULL" if shear == STOCK else f"shear {shear} tangential demlaws"
    return f"{table} {material} {more} 1 {job.get('friction', 10)} damping demlaws/tangent"


def _material(job, folder):
    in_liggghts.save_table(job, folder)
    return MATERIAL.format(contact=_contact(job), dt=job["dt"])


def _plane(job):
    contact = _contact(job, f" against {RIGID * job['young']:.17g} {job['poisson']:.17g}")
    return f"fix plane all wall/gran granular {contact} zplane 0.0 NULL"


LAMMPS = in_liggghts.Engine(HEAD + "boundary        f f f\nnewton          off\n", _material, _plane, run, "line ")


def answer(jobs):
    """What each job gives, as in_yade.py answers."""
    return in_liggghts.answer(jobs, LAMMPS)
