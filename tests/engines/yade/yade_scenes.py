"""Small scenes and the comparison of what YADE applied with what the law says."""

import math
from collections import defaultdict

import numpy as np

import demlaws as dl
from demlaws.make import example

YOUNG, POISSON = 60.6e9, 0.25
GRANITE = dl.Surface(roughness=2.4e-6, fractal_dimension=2.22, hardness=6.266e9)
SURFACES = {"granite": GRANITE}


def functor(law="pohrt-popov", unloading="hertz", surfaces=SURFACES, **options):
    from demlaws.yade import Law2_ScGeom_MindlinPhys_Demlaws

    return Law2_ScGeom_MindlinPhys_Demlaws(law, unloading, surfaces, **options)


def material(label="granite", young=YOUNG, poisson=POISSON, friction=0.5):
    import yade

    made = yade.FrictMat(young=young, poisson=poisson, frictionAngle=friction, density=2650, label=label)
    yade.O.materials.append(made)
    return made


def set_engines(law, timestep=1e-7, **options):
    import yade

    from demlaws.yade import engines

    yade.O.engines = engines(law, **options)
    yade.O.dt = timestep


def cloud(law, number=150, seed=3, rate=-20.0, damping=0.1, physics=None, friction=0.5):
    """A periodic cloud of spheres that is being compressed isotropically [rate in 1/s]."""
    import yade
    from yade import pack

    made = material(friction=friction)
    yade.O.periodic = True
    yade.O.cell.hSize = yade.Matrix3(0.1, 0, 0, 0, 0.1, 0, 0, 0, 0.1)
    spheres = pack.SpherePack()
    spheres.makeCloud((0, 0, 0), (0.1, 0.1, 0.1), rMean=0.0075, rRelFuzz=0.3, periodic=True, seed=seed, num=number)
    spheres.toSimulation(material=made)
    yade.O.cell.velGrad = yade.Matrix3(rate, 0, 0, 0, rate, 0, 0, 0, rate)
    set_engines(law, 1e-6, newton=yade.NewtonIntegrator(damping=damping), physics=physics)


class Recorder:
    """Overlap, force and tangent of every contact at every step, by life of the contact."""

    def __init__(self):
        self.lives = defaultdict(list)

    def step(self, count=1):
        import yade

        omega = yade.O
        for _ in range(count):
            omega.step()
            for contact in omega.interactions:
                if contact.isReal:
                    phys, geom = contact.phys, contact.geom
                    force = phys.normalForce.dot(geom.normal)
                    flat = not isinstance(omega.bodies[contact.id1].shape, yade.Sphere)
                    row = (geom.penetrationDepth, force, phys.kn, np.inf if flat else geom.refR1, geom.refR2)
                    self.lives[contact.id1, contact.id2, contact.iterMadeReal].append(row)

    def worst(self, law="pohrt-popov", unloading="hertz", pair=None, modulus=YOUNG / (1 - POISSON**2) / 2, **options):
        """Largest |F - F_law| over the largest force, and largest relative error of the tangent, each life on its own."""
        pair = GRANITE.combined(GRANITE) if pair is None else pair
        wrong, largest, tangent, steps = 0.0, 0.0, 0.0, 0
        for rows in self.lives.values():
            overlap, force, stiffness, radius1, radius2 = np.array(rows).T
            radius = 1.0 / (1.0 / radius1[0] + 1.0 / radius2[0])
            contact = dl.Contact(radius, modulus, pair.roughness, pair.fractal_dimension, pair.hardness)
            keep = overlap >= 0
            if not keep.any():
                continue
            one = unloading(contact) if callable(unloading) else example(law, contact, unloading, **options)
            path = one.follow(overlap[keep])
            wrong = max(wrong, np.abs(path.force - force[keep]).max())
            largest = max(largest, path.force.max())
            positive = path.stiffness > 0
            tangent = max(tangent, np.abs(stiffness[keep][positive] / path.stiffness[positive] - 1).max(initial=0))
            steps += int(keep.sum())
        assert largest > 0 and math.isfinite(wrong)
        return wrong / largest, tangent, steps
