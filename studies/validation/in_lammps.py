"""The rows that LAMMPS computes: those of LIGGGHTS, whose inputs it takes but for the lines of the contacts."""

from demlaws.lammps.run import HEAD, run
from studies.validation import in_liggghts
from studies.validation.arrays import RIGID

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
