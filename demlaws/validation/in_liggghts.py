"""The rows that LIGGGHTS computes."""

from demlaws.liggghts.run import HEAD, run
from demlaws.validation import scripts
from demlaws.validation.arrays import RIGID

WORDS = "table law.tbl limitForce off"
MATERIAL = """\
fix             m1 all property/global youngsModulus peratomtype {young:.17g} {rigid:.17g}
fix             m2 all property/global poissonsRatio peratomtype {poisson:.17g} {poisson:.17g}
fix             m3 all property/global coefficientRestitution peratomtypepair 2 1 1 1 1
fix             m4 all property/global coefficientFriction peratomtypepair 2 10 10 10 10
pair_style      gran model demlaws/table tangential history {words}
pair_coeff      * *
timestep        {dt:.17g}
"""


def _material(job, folder):
    scripts.save_table(job, folder)
    return MATERIAL.format(rigid=RIGID * job["young"], words=WORDS, **job)


def _plane(job):
    return f"fix plane all wall/gran model demlaws/table tangential history primitive type 2 zplane 0.0 {WORDS}"


ENGINE = scripts.Engine(HEAD.replace("boundary        f f f", "boundary        {boundary}"), 2, _material, _plane, run)


def answer(jobs):
    """What each job gives, as in_yade.py answers."""
    return scripts.answer(ENGINE, jobs)
