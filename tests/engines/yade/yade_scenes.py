"""Small scenes, scripts in processes of their own, and the comparison of YADE's forces with those of the law."""

import importlib
import math
import subprocess
from collections import defaultdict
from pathlib import Path

import numpy as np
import pytest

import demlaws as dl
from demlaws import yade as dy
from demlaws.make import example_law
from demlaws.yade.run import run


class _Yade:
    """The module yade, imported when a test first needs it: tests are collected where it is absent, too."""

    def __getattr__(self, name):
        return getattr(importlib.import_module("yade"), name)


yade = _Yade()
YOUNG, POISSON = 60.6e9, 0.25
GRANITE = dl.Surface(roughness=2.4e-6, fractal_dimension=2.22, hardness=6.266e9)
SURFACES = {"granite": GRANITE}
MODULUS = YOUNG / (1 - POISSON**2) / 2
OVERLAP = 1e-5
FLATS = {
    "facet": lambda utils, stone: utils.facet([(-1, -1, 0), (1, -1, 0), (0, 1, 0)], fixed=True, material=stone),
    "wall": lambda utils, stone: utils.wall(0, 2, sense=1, material=stone),
    "box": lambda utils, stone: utils.box((0, 0, -0.1), (1, 1, 0.1), fixed=True, material=stone),
}


def sphere(*arguments, **options):
    return yade.utils.sphere(*arguments, **options)


def functor(law="pohrt-popov", unloading="hertz", surfaces=SURFACES, **options):
    return dy.Law2_ScGeom_MindlinPhys_Demlaws(law, unloading, surfaces, **options)


def material(label="granite", young=YOUNG, poisson=POISSON, friction=0.5):
    made = yade.FrictMat(young=young, poisson=poisson, frictionAngle=friction, density=2650, label=label)
    yade.O.materials.append(made)
    return made


def set_engines(law, timestep=1e-7, **options):
    yade.O.engines = dy.engines(law, **options)
    yade.O.dt = timestep


def interaction_loop(*laws, geometries=None, physics=None):
    geometries = geometries or [yade.Ig2_Sphere_Sphere_ScGeom()]
    return yade.InteractionLoop(geometries, physics or [yade.Ip2_FrictMat_FrictMat_MindlinPhys()], list(laws))


def engine_list(*loops, bounds=(), damping=0.0):
    """What a user writes who does not take our `engines`."""
    collider = yade.InsertionSortCollider([yade.Bo1_Sphere_Aabb(), *bounds], verletDist=1e-3)
    return [yade.ForceResetter(), collider, *loops, yade.NewtonIntegrator(damping=damping)]


def advance(steps):
    """As O.run, which waits 40 ms for its thread."""
    for _ in range(steps):
        yade.O.step()


def fixed_pair(stone, overlap=OVERLAP, radius=0.01, x=0.0):
    """Two fixed spheres that overlap."""
    return [yade.utils.sphere((x, 0, z), radius, fixed=True, material=stone) for z in (0, 2 * radius - overlap)]


def two_spheres(law, speed=-0.3, gap=1e-6, radius=0.01, sideways=0.0, steps=0):
    """A sphere that moves towards a fixed one, after so many steps; the law."""
    stone = material()
    yade.O.bodies.append(sphere((0, 0, 0), radius, fixed=True, material=stone))
    yade.O.bodies.append(sphere((0, 0, 2 * radius + gap), radius, material=stone))
    yade.O.bodies[1].state.vel = (sideways, 0, speed)
    set_engines(law)
    advance(steps)
    return law


def still(law, label="granite", **stone):
    """Two fixed spheres that overlap by OVERLAP."""
    yade.O.bodies.append(fixed_pair(material(label, **stone)))
    set_engines(law, 1e-9)


def acting(law, label="granite", **stone):
    """The law, in the scene of `still` after three steps."""
    still(law, label, **stone)
    advance(3)
    return law


def force():
    return yade.O.interactions[0, 1].phys.normalForce.norm()


def expected(roughness=GRANITE.roughness, radius=0.005):
    """Force of `still` by the law itself, to rounding."""
    pair = dl.Contact(radius, MODULUS, roughness * 2**0.5, GRANITE.fractal_dimension, GRANITE.hardness)
    return pytest.approx(float(dl.law("pohrt-popov", pair, "hertz").force(OVERLAP)), rel=1e-12)


def stops(message, steps=5):
    """Assert that the run ends with this message."""
    with pytest.raises(RuntimeError, match=message):
        advance(steps)


def assert_guarded():
    """A position that is not finite stops the run with a message about its contact."""
    yade.O.bodies[1].state.pos = (0, 0, float("nan"))
    stops(r"contact 0\+1", 20)


def under_yade(text, tmp_path, threads=1):
    """Run a script in a YADE process of its own."""
    script = tmp_path / "script.py"
    script.write_text(f"import sys\nsys.path.insert(0, {str(Path(__file__).parent)!r})\n{text}")
    options = {"capture_output": True, "text": True, "timeout": 600, "cwd": tmp_path, "stdin": subprocess.DEVNULL}
    return run(script, (), threads, **options)


def cloud(law, number=150, seed=3, rate=-20.0, damping=0.1, physics=None, friction=0.5):
    """A periodic cloud of spheres that is being compressed isotropically [rate in 1/s]."""
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

    def worst(self, law="pohrt-popov", unloading="hertz", pair=None, modulus=MODULUS, **options):
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
            one = unloading(contact) if callable(unloading) else example_law(law, contact, unloading, **options)
            path = one.follow(overlap[keep])
            wrong = max(wrong, np.abs(path.force - force[keep]).max())
            largest = max(largest, path.force.max())
            positive = path.stiffness > 0
            tangent = max(tangent, np.abs(stiffness[keep][positive] / path.stiffness[positive] - 1).max(initial=0))
            steps += int(keep.sum())
        assert largest > 0 and math.isfinite(wrong)
        return wrong / largest, tangent, steps

    def exact(self, *arguments, **options):
        """Assert that force and tangent are the law's to rounding; returns the number of steps."""
        wrong, tangent, steps = self.worst(*arguments, **options)
        assert wrong <= 1e-14 and tangent <= 1e-13
        return steps


def needs(feature):
    """Skip where YADE's own list of features is without it. In CI, where YADE is Debian's, a skipped test is a failure."""
    if feature not in importlib.import_module("yade.config").features:
        pytest.skip(f"this YADE is built without {feature}")
