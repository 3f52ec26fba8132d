"""Heights of a grain that falls between two fixed spheres of 10 mm, in YADE: CSV for `python -m studies.shear --neck`.

demlaws yade run -x studies/shear/yade_neck.py > studies/shear/neck.csv: some minutes.
"""

import math
import os

import yade

from demlaws.yade import Law2_ScGeom_MindlinPhys_Demlaws

O = yade.O  # noqa: E741  YADE's name
BIG, TIME, POINTS = 5e-3, 0.3, 60  # radius [m], [s]


def heights(model, ratio, step):
    """Height [mm] at POINTS times of a grain of BIG/ratio; model: "stock", or a shear model of demlaws."""
    O.reset()
    stone = yade.FrictMat(young=5e8, poisson=0.3, frictionAngle=math.atan(0.5), density=2500, label="stone")
    O.materials.append(stone)
    small, side = BIG / ratio, 0.11 * BIG / ratio
    place = (BIG, side, math.sqrt((BIG + small) ** 2 - BIG**2 - side**2))
    O.bodies.append([yade.utils.sphere((x, 0, 0), BIG, fixed=True, material=stone) for x in (0, 2 * BIG)])
    O.bodies.append(yade.utils.sphere(place, small, material=stone))
    law = yade.Law2_ScGeom_MindlinPhys_Mindlin()
    if model != "stock":
        law = Law2_ScGeom_MindlinPhys_Demlaws("hertz", surfaces=None, smooth=True, shear=model)
    physics = yade.Ip2_FrictMat_FrictMat_MindlinPhys(en=0.5, es=1.0)
    O.engines = [
        yade.ForceResetter(),
        yade.InsertionSortCollider([yade.Bo1_Sphere_Aabb()]),
        yade.InteractionLoop([yade.Ig2_Sphere_Sphere_ScGeom()], [physics], [law]),
        yade.NewtonIntegrator(gravity=(0, 0, -9.81), damping=0),
    ]
    O.dt = step
    for _ in range(POINTS):
        O.run(round(TIME / POINTS / step), True)
        yield 1e3 * O.bodies[2].state.pos[2]


if __name__ == "__main__":
    print("ratio,step_us,model,heights_mm")
    for ratio, steps in ((2, (1.0, 0.5)), (5, (1.0, 0.5)), (10, (1.0, 0.5)), (20, (1.0, 0.5, 0.25)), (40, (1.0, 0.5, 0.25))):
        for step in steps:
            for model in ("stock", "elastic", "slip"):
                print(f"{ratio},{step},{model},{' '.join(f'{z:.3f}' for z in heights(model, ratio, 1e-6 * step))}", flush=True)
    os._exit(0)
