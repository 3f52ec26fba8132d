"""The closed gas of `studies.shear.gas` in YADE: energies at 31 times of each run; started by it under YADE."""

import math

import yade
from yade.utils import kineticEnergy, sphere, wall

from demlaws.contact import Surface
from demlaws.errors import DemlawsError, quiet
from demlaws.laws.registry import find
from demlaws.make import example_law
from demlaws.yade import Law2_ScGeom_MindlinPhys_Demlaws, engines
from studies.shear.gas import DIAMETER, SPACING, TIME, contact
from studies.under_yade import serve

O = yade.O  # noqa: E741  YADE's name


def functor(law, rule, shear, poisson):
    """A law of ours on the surfaces of `contact`, or YADE's own for `law` None."""
    if law is None:
        return yade.Law2_ScGeom_MindlinPhys_Mindlin()
    pair = contact(poisson)
    surface = Surface(pair.sigma / math.sqrt(2.0), pair.fractal_dimension, pair.hardness)
    flats = "yade" if find(law).needs_map else "plane"  # solved for one contact: walls with YADE's own radius there
    return Law2_ScGeom_MindlinPhys_Demlaws(example_law(law, pair, rule), None, surface, shear=shear, flats=flats)


def simulate(given, poisson, friction, shear):
    """[(energy of bodies and contacts, the same with what contacts have lost), ...]."""
    O.reset()
    stone = yade.FrictMat(young=60.6e9, poisson=poisson, frictionAngle=math.atan(friction), density=2650, label="granite")
    O.materials.append(stone)
    for place, speed in given["grains"]:
        O.bodies[O.bodies.append(sphere(place, DIAMETER / 2, material=stone))].state.vel = speed
    O.bodies.append([wall(place, axis, material=stone) for axis in range(3) for place in (0.0, 4 * SPACING)])
    law = functor(given["law"], given["rule"], shear, poisson)
    O.engines, O.dt = engines(law), TIME / given["steps"]
    energies = []
    for _ in range(31):
        kept = lost = kineticEnergy()
        if given["law"] is not None:
            totals = law.totals()
            kept += totals.stored + totals.shear_stored
            lost = kept + totals.dissipated + totals.shear_dissipated
        energies.append((kept, lost))
        O.run(given["steps"] // 30, True)
    return energies


def attempt(given, run):
    """The energies of a run, or why it is refused."""
    try:
        return simulate(given, *run)
    except (DemlawsError, RuntimeError) as error:
        return str(error)


if __name__ == "__main__":
    with quiet():
        serve(lambda given: [attempt(given, run) for run in given["runs"]])
