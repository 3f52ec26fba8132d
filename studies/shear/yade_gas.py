"""The closed gas of `gas` in YADE: run under YADE with its settings as JSON, prints energies at 31 times as JSON."""

import json
import math
import os
import sys
import warnings

import yade
from yade.utils import sphere, wall

from demlaws.contact import Surface
from demlaws.core.unloading import GIVEN
from demlaws.errors import DemlawsError, ValidityWarning
from demlaws.laws.registry import find
from demlaws.make import example
from demlaws.yade import Law2_ScGeom_MindlinPhys_Demlaws, engines
from studies.shear.gas import BOX, CONTACT, DIAMETER, places_and_speeds

O = yade.O  # noqa: E741  YADE's name


def functor(law, rule, shear):
    """A law of ours on the surfaces of CONTACT, or YADE's own for `law` None."""
    if law is None:
        return yade.Law2_ScGeom_MindlinPhys_Mindlin()
    surface = Surface(CONTACT.roughness / math.sqrt(2.0), CONTACT.fractal_dimension, CONTACT.hardness)
    given, options = (example(law, CONTACT, rule), {}) if rule == GIVEN else (law, find(law).example)
    unloading = None if rule == GIVEN else rule
    return Law2_ScGeom_MindlinPhys_Demlaws(given, unloading, surface, shear=shear, bridge="native", **options)


def kinetic():
    """Energy of motion and rotation [J]."""
    spheres = (body.state for body in O.bodies if body.dynamic)
    return sum(0.5 * (s.mass * s.vel.squaredNorm() + s.inertia[0] * s.angVel.squaredNorm()) for s in spheres)


def main(law, rule, shear, friction, poisson, steps):
    """[(energy of bodies and contacts, the same with what contacts have lost), ...]."""
    stone = yade.FrictMat(young=60.6e9, poisson=poisson, frictionAngle=math.atan(friction), density=2650, label="granite")
    O.materials.append(stone)
    for place, speed in places_and_speeds():
        O.bodies[O.bodies.append(sphere(place, DIAMETER / 2, material=stone))].state.vel = speed
    O.bodies.append([wall(place, axis, material=stone) for axis in range(3) for place in (0.0, BOX)])
    acting = functor(law, rule, shear)
    O.engines, O.dt = engines(acting), 2e-7
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


if __name__ == "__main__":
    warnings.simplefilter("ignore", ValidityWarning)
    try:
        result = main(**json.loads(sys.argv[1]))
    except (DemlawsError, RuntimeError) as error:
        result = {"refused": str(error)}
    print("RESULT " + json.dumps(result), flush=True)
    os._exit(0)
