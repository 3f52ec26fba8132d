"""Balance of energy of an oblique impact in YADE, with and without the scaled shear of YADE's geometry.

demlaws yade run -x studies/shear/yade_balance.py: a second.

YADE multiplies the relative velocity of two spheres by (r1 + r2)/(r1 + r2 - δ), so that grains that roll to and fro do
not creep (`avoidGranularRatcheting`); of a wall it takes r as the lever arm, too (`noRatch`). The forces act at the
contact point: the work of the springs of shear then exceeds the work done on the bodies by a share of about δ/(r1 +
r2), whatever the step is. [our derivation]
"""

import math

import yade
import yade.utils

import demlaws.yade as dy

O = yade.O  # noqa: E741  YADE's name
RADIUS, FRICTION = 5e-3, 0.3
STEP = 6.45e-6
"""P-wave step of the spheres [s]."""


def impact(kind, scaled, share, speed=1.0):
    """(energy at the end - at the start)/start, and the largest overlap over R, for a step of `share` P-wave steps."""
    O.reset()
    stone = yade.FrictMat(young=1e9, poisson=0.25, frictionAngle=math.atan(FRICTION), density=2600, label="stone")
    O.materials.append(stone)
    first = yade.utils.wall(0, 2) if kind == "wall" else yade.utils.sphere((0, 0, -RADIUS), RADIUS)
    O.bodies.append([first, yade.utils.sphere((0, 0, RADIUS), RADIUS)])
    O.bodies[1].state.vel = speed * yade.Vector3(0.6, 0.2, -1.0)
    O.bodies[1].state.angVel = speed * yade.Vector3(30, -80, 50)
    law = dy.Law2_ScGeom_MindlinPhys_Demlaws("hertz")
    geometries = [yade.Ig2_Sphere_Sphere_ScGeom(avoidGranularRatcheting=scaled), yade.Ig2_Wall_Sphere_ScGeom(noRatch=scaled)]
    O.engines = dy.engines(law, geometries=geometries)
    O.dt = share * STEP
    start, deepest = yade.utils.kineticEnergy(), 0.0
    while O.iter < 20 / share or O.interactions.countReal():
        O.step()
        deepest = max([deepest, *(i.geom.penetrationDepth for i in O.interactions if i.isReal)])
    totals = law.totals()
    end = yade.utils.kineticEnergy() + totals.stored + totals.dissipated + totals.shear_stored + totals.shear_dissipated
    return end / start - 1.0, deepest / RADIUS


if __name__ == "__main__":
    print("kind  scaled  speed  " + "".join(f"  {share:g} P-wave steps" for share in (0.1, 0.03, 0.01)) + "  overlap/R")
    for kind in ("pair", "wall"):
        for scaled in (True, False):
            for speed in (1.0, 0.1):
                errors = [impact(kind, scaled, share, speed) for share in (0.1, 0.03, 0.01)]
                values = "".join(f"{error:18.1e}" for error, _ in errors)
                print(f"{kind}  {scaled!s:6}  {speed:5g}{values}{errors[-1][1]:11.1e}")
