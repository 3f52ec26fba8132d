"""The impact of `studies.cases.impact` in YADE; started by it under YADE."""

import yade
from yade import utils

from demlaws.yade import Law2_ScGeom_MindlinPhys_Demlaws, engines
from studies.cases.impact import DIAMETER, GAP, SPEED, SURFACE
from studies.under_yade import serve

O = yade.O  # noqa: E741


def impact(given):
    """Peak force [N] and rebound speed [m/s]."""
    name, unloading, options, dt = given["law"]
    O.materials.append(yade.FrictMat(young=60.6e9, poisson=0.25, frictionAngle=0.5, density=2650, label="granite"))
    for side in (-1, 1):
        O.bodies.append(utils.sphere((side * (DIAMETER + GAP) / 2, 0, 0), DIAMETER / 2, material="granite"))
        O.bodies[-1].state.vel = (-side * SPEED / 2, 0, 0)
    O.engines = engines(Law2_ScGeom_MindlinPhys_Demlaws(name, unloading, {"granite": SURFACE}, **options))
    O.dt = dt
    left, right = O.bodies[0], O.bodies[1]
    peak, parted = 0.0, False
    while not parted and O.iter < 200000:
        O.step()
        force = O.forces.f(1)[0]
        peak, parted = max(peak, force), peak > 0 and force == 0
    return peak, right.state.vel[0] - left.state.vel[0]


if __name__ == "__main__":
    serve(impact)
