"""The closed gas of `gas` in YADE: energies at 31 times of each run; started by it under YADE."""

import math

import yade
from yade.utils import sphere, wall

from demlaws.contact import Surface
from demlaws.core.unloading import GIVEN
from demlaws.errors import DemlawsError, quiet
from demlaws.laws.registry import find
from demlaws.make import example
from demlaws.yade import Law2_ScGeom_MindlinPhys_Demlaws, engines
from studies.shear.gas import BOX, DIAMETER, TIME, contact, places_and_speeds
from studies.under_yade import serve

O = yade.O  # noqa: E741  YADE's name


def functor(law, rule, shear, poisson):
    """A law of ours on the surfaces of `contact`, or YADE's own for `law` None."""
    if law is None:
        return yade.Law2_ScGeom_MindlinPhys_Mindlin()
    pair = contact(poisson)
    surface = Surface(pair.roughness / math.sqrt(2.0), pair.fractal_dimension, pair.hardness)
    given, options = (example(law, pair, rule), {}) if rule == GIVEN else (law, dict(find(law).example))
    if find(law).needs_map:  # solved for one contact: walls with YADE's own radius there
        options |= {"radii": (pair.radius, pair.radius), "moduli": (pair.modulus, pair.modulus)}
        options["flats"] = "yade"
    unloading = None if rule == GIVEN else rule
    return Law2_ScGeom_MindlinPhys_Demlaws(given, unloading, surface, shear=shear, bridge="native", **options)


def kinetic():
    """Energy of motion and rotation [J]."""
    spheres = (body.state for body in O.bodies if body.dynamic)
    return sum(0.5 * (s.mass * s.vel.squaredNorm() + s.inertia[0] * s.angVel.squaredNorm()) for s in spheres)


def simulate(law, rule, shear, poisson, friction, steps):
    """[(energy of bodies and contacts, the same with what contacts have lost), ...]."""
    stone = yade.FrictMat(young=60.6e9, poisson=poisson, frictionAngle=math.atan(friction), density=2650, label="granite")
    O.materials.append(stone)
    for place, speed in places_and_speeds():
        O.bodies[O.bodies.append(sphere(place, DIAMETER / 2, material=stone))].state.vel = speed
    O.bodies.append([wall(place, axis, material=stone) for axis in range(3) for place in (0.0, BOX)])
    acting = functor(law, rule, shear, poisson)
    O.engines, O.dt = engines(acting), TIME / steps
    energies = []
    for _ in range(31):
        kept = lost = kinetic()
        if law is not None:
            totals = acting.totals()
            kept += totals.stored + totals.shear_stored
            lost = kept + totals.dissipated + totals.shear_dissipated
        energies.append((kept, lost))
        O.run(steps // 30, True)
    return energies


def attempt(run):
    """The energies of a run, or why it is refused."""
    O.reset()
    try:
        return simulate(*run)
    except (DemlawsError, RuntimeError) as error:
        return str(error)


if __name__ == "__main__":
    with quiet():
        serve(lambda runs: [attempt(run) for run in runs])
