"""A grain that spins about its contact's normal vibrates ever more, or less, with Law2_ScGeom_MindlinPhys_Mindlin, undamped.

yade -x -n -j1 spin.py. A grain of 2 mm is pulled to a fixed sphere of 10 mm and moved along it by 3 mm/s in a small circle.
With μ = 100 it sticks. Prints the largest speed of its centre [mm/s] in each 4 ms, for spins about the normal and two steps.
Found with YADE 2023.02a.
"""

import math

import yade
from yade import O
from yade.utils import sphere

big, small, young, poisson, density, pull, speed = 5e-3, 1e-3, 5e8, 0.25, 2650, 50.0, 3e-3
for spin in (3000.0, 0.0, -3000.0):
    for step in (1e-6, 5e-7):
        O.reset()
        stone = yade.FrictMat(young=young, poisson=poisson, frictionAngle=math.atan(100.0), density=density)
        O.materials.append(stone)
        mass, radius, modulus = density * 4 / 3 * math.pi * small**3, big * small / (big + small), young / (1 - poisson**2) / 2
        overlap = (mass * pull / (4 / 3 * modulus * radius**0.5)) ** (2 / 3)
        O.bodies.append(sphere((0, 0, 0), big, fixed=True, material=stone))
        O.bodies.append(sphere((0, 0, big + small - overlap), small, material=stone))
        state = O.bodies[1].state
        state.vel, state.angVel = (speed, 0, 0), (0, 0, spin)
        O.engines = [
            yade.ForceResetter(),
            yade.InsertionSortCollider([yade.Bo1_Sphere_Aabb()]),
            yade.InteractionLoop(
                [yade.Ig2_Sphere_Sphere_ScGeom(avoidGranularRatcheting=False)],
                [yade.Ip2_FrictMat_FrictMat_MindlinPhys()],
                [yade.Law2_ScGeom_MindlinPhys_Mindlin()],
            ),
            yade.CentralConstantAccelerationEngine(accel=pull, centralBody=0, reciprocal=False),
            yade.NewtonIntegrator(damping=0),
        ]
        O.dt = step
        stiffness = 4 * (1 - poisson) / (2 - poisson) * modulus * (radius * overlap) ** 0.5
        O.run(round(0.5 * math.pi * (mass * 2 / 7 / stiffness) ** 0.5 / step), True)  # a quarter of the vibration
        state.vel += (0, speed, 0)
        largest = []
        for _ in range(5):
            most = 0.0
            for _ in range(round(0.004 / (10 * step))):
                O.run(10, True)
                most = max(most, state.vel.norm())
            largest.append(f"{1e3 * most:7.3f}")
        print(f"spin {spin:g} 1/s, step {1e6 * step:g} µs:", *largest)
