"""A grain of 0.5 mm that falls between two fixed spheres of 10 mm is held for ever by Law2_ScGeom_MindlinPhys_Mindlin.

yade -x -n neck.py. Prints its height every 0.06 s, in mm, for steps of 1, 0.5 and 0.25 µs. Found with YADE 2023.02a.
"""

import math

import yade
from yade import O
from yade.utils import sphere

for step in (1e-6, 5e-7, 2.5e-7):
    O.reset()
    stone = yade.FrictMat(young=5e8, poisson=0.3, frictionAngle=math.atan(0.5), density=2500)
    O.materials.append(stone)
    big, small = 5e-3, 0.25e-3
    place = (big, 0.11 * small, math.sqrt((big + small) ** 2 - big**2 - (0.11 * small) ** 2))
    O.bodies.append([sphere((x, 0, 0), big, fixed=True, material=stone) for x in (0, 2 * big)])
    O.bodies.append(sphere(place, small, material=stone))
    O.engines = [
        yade.ForceResetter(),
        yade.InsertionSortCollider([yade.Bo1_Sphere_Aabb()]),
        yade.InteractionLoop(
            [yade.Ig2_Sphere_Sphere_ScGeom()],
            [yade.Ip2_FrictMat_FrictMat_MindlinPhys(en=0.5, es=1.0)],
            [yade.Law2_ScGeom_MindlinPhys_Mindlin()],
        ),
        yade.NewtonIntegrator(gravity=(0, 0, -9.81), damping=0),
    ]
    O.dt = step
    heights = []
    for _ in range(5):
        O.run(round(0.06 / step), True)
        heights.append(f"{1e3 * O.bodies[2].state.pos[2]:9.3f}")
    print(f"step {1e6 * step:g} µs:", *heights)
