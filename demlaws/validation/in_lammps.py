"""The rows that LAMMPS computes."""

from demlaws.lammps.run import HEAD, run
from demlaws.validation import scripts
from demlaws.validation.arrays import RIGID

MODEL = "demlaws/table law.tbl {young:.17g} 1.0 {poisson:.17g} tangential mindlin NULL 0.0 10.0 damping demlaws/tangent"
MATERIAL = """\
pair_style      granular
pair_coeff      * * {model}
timestep        {dt:.17g}
"""


def _material(job, folder):
    scripts.save_table(job, folder)
    return MATERIAL.format(model=MODEL.format(**job), **job)


def _plane(job):
    # a wall is of the grains' own modulus, so that E* is half of E/(1 - ν²): twice E stands for a rigid one
    model = MODEL.format(young=2.0 * RIGID / (1.0 + RIGID) * job["young"], poisson=job["poisson"])
    return f"fix plane all wall/gran granular {model} zplane 0.0 NULL"


ENGINE = scripts.Engine(HEAD + "boundary        {boundary}\n", 1, _material, _plane, run)


def answer(jobs):
    """What each job gives, as in_yade.py answers."""
    return scripts.answer(ENGINE, jobs)
