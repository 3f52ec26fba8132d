"""A box of grains in YADE: packed by six walls, probed at rising pressure, loaded in cycles; started by `studies.shapes`."""

import math
import time

import numpy as np
import yade
from yade import utils

import __main__
import demlaws as dl
from demlaws.yade import Curvature, Law2_ScGeom_MindlinPhys_Demlaws, engines
from studies.under_yade import serve

O = yade.O  # noqa: E741
LOOSE, ROUGH = math.radians(3), math.radians(30)  # friction of a packing in the making, and after
LOW = 5e3  # pressure [Pa] on soft grains
PITCH = 0.062  # of the lattice [m]; no grain is wider
EVERY = 5  # steps between two readings of the walls


def grain(shape, given, centre, generator):
    """Add one grain of a size and form at random, turned at random: a superellipsoid, a clump like it or a sphere like it."""
    half = 0.5 * generator.uniform(0.040, 0.055) * np.array([1.0, generator.uniform(0.7, 1.0), generator.uniform(0.6, 0.9)])
    sharpness, turn = generator.uniform(0.5, 0.8, 2), generator.normal(size=4)
    turned = yade.Quaternion(*map(float, turn / np.linalg.norm(turn)))
    middle = yade.Vector3(*map(float, centre))
    if shape == "sphere":  # the volume of a superellipsoid of sharpness 0.65 is 1.25 of the ellipsoid's
        O.bodies.append(utils.sphere(middle, float((1.25 * half.prod()) ** (1 / 3)), material="grains"))
    elif shape == "clump":  # a core, and a sphere in each of the eight corners
        corners = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
        radius = 0.5 * half[2]
        places = [(0.0, 0.0, 0.0), *(0.8 * corners * (half - radius)).tolist()]
        radii = [half[2], *[radius] * 8]
        members = [
            utils.sphere(middle + turned * yade.Vector3(*p), float(r), material="grains")
            for p, r in zip(places, radii, strict=True)
        ]
        O.bodies.appendClumped(members, discretization=12)
    else:
        body = utils.levelSetBody(
            "superellipsoid",
            center=middle,
            extents=tuple(map(float, half)),
            epsilons=tuple(map(float, sharpness)),
            spacing=float(half[0] / given["cells"]),
            nSurfNodes=given["nodes"],
            nodesPath=1,
            material="grains",
        )
        body.state.ori = turned
        O.bodies.append(body)


class Box:
    """Grains between six walls (bodies 0 to 5) that keep a pressure, keep still, or load in cycles."""

    def __init__(self):
        self.goal, self.ends, self.rows, self.steps, self.seconds = None, None, [], 0, 0.0
        __main__.look = self.look

    def use(self, law, timestep):
        """Let this law act, with a constant step [s]."""
        shapes = [yade.Bo1_Sphere_Aabb(), yade.Bo1_Wall_Aabb(), yade.Bo1_LevelSet_Aabb()]
        geometries = [
            yade.Ig2_Sphere_Sphere_ScGeom(),
            yade.Ig2_Wall_Sphere_ScGeom(),
            yade.Ig2_LevelSet_LevelSet_ScGeom(),
            yade.Ig2_Wall_LevelSet_ScGeom(),
        ]
        reading = yade.PyRunner(command="__import__('__main__').look()", iterPeriod=EVERY)
        newton = yade.NewtonIntegrator(damping=0.7)
        O.engines = engines(law, geometries=geometries, bounds=shapes, after=[reading], newton=newton)
        next(e for e in O.engines if isinstance(e, yade.Collider)).verletDist = 1e-3
        O.dt = timestep

    def size(self):
        """Lengths of the box [m]."""
        return np.array([O.bodies[2 * n + 1].state.pos[n] - O.bodies[2 * n].state.pos[n] for n in range(3)])

    def stresses(self):
        """Mean of the stresses on opposite walls [Pa]."""
        size = self.size()
        forces = np.array([0.5 * (O.forces.f(2 * n + 1)[n] - O.forces.f(2 * n)[n]) for n in range(3)])
        return forces * size / size.prod()

    def move(self, speeds):
        """Strain rates of the box [1/step], compression positive."""
        for n, speed in enumerate(np.asarray(speeds) * self.size() / (2 * O.dt)):
            for wall, sense in ((2 * n, 1), (2 * n + 1, -1)):
                O.bodies[wall].state.vel = yade.Vector3(*[float(sense * speed) if k == n else 0.0 for k in range(3)])

    def look(self):
        """Called by YADE every few steps: keep the pressure, or turn the plates at the ends of a cycle."""
        stresses = self.stresses()
        self.rows.append(stresses)
        if self.goal is not None:
            self.move(self.rate * np.clip(3 * (1 - stresses / self.goal), -1, 1))
        elif self.ends is not None:
            low, high = self.ends
            self.track.append((self.size()[2], stresses[2]))
            if (self.down and stresses[2] >= high) or (not self.down and stresses[2] <= low):
                self.turns.append(len(self.track) - 1)
                self.down = not self.down
                self.move((0, 0, self.rate if self.down else -self.rate))

    def run(self, steps):
        """Run this many steps; mean stresses [Pa] of the readings."""
        started, self.rows = time.process_time(), []
        O.run(steps, True)
        self.seconds += time.process_time() - started
        self.steps += steps
        return np.mean(self.rows, axis=0)

    def compress(self, pressure, rate, patience):
        """Bring all stresses to a pressure at no more than this strain per step, then let the walls rest."""
        self.goal, self.rate, near = pressure, rate, 0
        for _ in range(patience):
            near = near + 1 if np.abs(self.run(500) / pressure - 1).max() < 0.02 else 0
            if near == 2:
                break
        self.goal = None
        self.move((0, 0, 0))
        self.run(500)

    def load(self, low, high, count, rate):
        """Cycles of the vertical stress between fixed sides: height [m] and stress [Pa] of the readings, places of turns."""
        self.goal, self.ends, self.down, self.rate, self.turns, self.track = None, (low, high), True, rate, [], []
        self.move((0, 0, rate))
        while len(self.turns) < 2 * count:
            self.run(500)
        return np.array(self.track), self.turns[: 2 * count]

    def probe(self, strain, repeats):
        """Constrained moduli [Pa] from small changes of the height without sliding, and the change of the stress at rest [Pa].

        Each modulus compares the stress after a change with the mean of those before it and after the next change, which
        cancels a steady drift. Stresses are means of 20 readings after a rest.
        """

        def rested():
            self.run(400)
            return self.run(20 * EVERY)[2]

        still, steps = [rested() for _ in range(4)], 50
        stress, sense = [still[-1]], 1
        utils.setContactFriction(math.radians(89.9))
        for _ in range(2 * repeats):
            self.move((0, 0, sense * strain / steps))
            self.run(steps)
            self.move((0, 0, 0))
            stress.append(rested())
            sense = -sense
        utils.setContactFriction(ROUGH)
        bends = np.diff(stress, 2) * (-1.0) ** np.arange(1, 2 * repeats)
        return bends / (2 * strain), float(np.abs(np.diff(still)).mean())

    def state(self):
        """Stresses, contacts, largest overlap, kinetic energy and time of a step as text."""
        depths = [i.geom.penetrationDepth for i in O.interactions if i.isReal]
        return (
            f"{self.stresses().round()} Pa, {len(depths)} contacts, overlap {max(depths):.1e} m, "
            f"{utils.kineticEnergy():.1e} J, step {O.iter}, {1e3 * self.seconds / self.steps:.2f} ms per step"
        )


def report(text):
    """A line for the process that waits."""
    print("PROGRESS", text, flush=True)


def prepare(given):
    """A dense packing of soft grains at 5 kPa, drawn apart until none touch, saved to given["packing"]."""
    generator, across = np.random.default_rng(given["seed"]), math.ceil(given["count"] ** (1 / 3))
    stone = {"young": given["young"], "poisson": 0.25, "density": 2680.0}
    O.materials.append(yade.FrictMat(frictionAngle=LOOSE, label="grains", **stone))
    O.materials.append(yade.FrictMat(frictionAngle=0.0, label="walls", **stone))
    width = across * PITCH
    for axis in range(3):
        for place, sense in ((0.0, 1), (width, -1)):
            position = [place if n == axis else width / 2 for n in range(3)]
            O.bodies.append(utils.wall(position, axis, sense=sense, material="walls"))
    for n in range(given["count"]):
        place = np.array([n % across, n // across % across, n // across**2]) + generator.uniform(0.45, 0.55, 3)
        grain(given["shape"], given, place * PITCH, generator)
    box = Box()
    for softer in (1000, 300, 100, 30, 10, 3, 1):
        O.interactions.clear()
        for material in O.materials:
            material.young = given["young"] / softer
        box.use(Law2_ScGeom_MindlinPhys_Demlaws("hertz", smooth=True, radius="body"), 6e-6 * softer**0.5)
        first = softer == 1000
        box.compress(LOW if softer > 10 else given["ends"][0], 3e-5 if first else 5e-6, 60 if first else 12)
        report(f"{given['shape']}, E/{softer}: {box.state()}")
    O.interactions.clear()
    O.engines = []
    O.save(given["packing"])
    return {}


def loaded(given):
    """A box with the saved packing under one law, and the law."""
    O.load(given["packing"])
    for material in O.materials:
        material.young = given["young"]
    radius = given["radius"]
    surfaces = {"grains": dl.Surface(**given["surface"]), "walls": dl.Surface(0)} if given["surface"] else None
    radius = Curvature(**radius) if isinstance(radius, dict) else radius
    law = Law2_ScGeom_MindlinPhys_Demlaws(given["law"], given["unloading"], surfaces, smooth=not surfaces, radius=radius)
    box = Box()
    box.use(law, given["timestep"])
    O.materials["grains"].frictionAngle = ROUGH
    return box, law


def small(given):
    """Small-strain moduli [Pa] at rising pressure, their standard deviation and the stress's change at rest."""
    box, _ = loaded(given)
    rows = []
    for pressure in given["pressures"]:
        box.compress(pressure, 3e-6, 6)
        found, noise = box.probe(given["strain"], given["repeats"])
        contacts = sum(i.isReal for i in O.interactions)
        rows.append([float(box.stresses()[2]), float(found.mean()), float(found.std(ddof=1)), contacts, noise])
        report(f"{rows[-1]} {box.state()}")
    return {"rows": rows}


def measure(given):
    """Moduli and heights in cycles under one law, from the saved packing."""
    box, law = loaded(given)
    mass = sum(b.state.mass for b in O.bodies if (b.isStandalone and b.id > 5) or b.isClump)
    box.compress(given["ends"][0], 3e-6, 6)
    report(box.state())
    track, turns = box.load(*given["ends"], given["cycles"], given["rate"])
    heights = [track[0, 0], *track[turns, 0]]
    return {
        "stiffness": moduli(track, turns[-20:], given["windows"]),
        "contacts": sum(i.isReal for i in O.interactions),
        "solid": float(mass / 2680.0 / box.size().prod()),
        "radius": float(np.median(law.contacts().radius)),
        "heights": [float(height) for height in heights],
        "steps": box.steps,
        "seconds": box.seconds,
    }


def moduli(track, turns, windows):
    """Constrained modulus [Pa] within each window of stress, from the unloading between pairs of turns."""
    found = []
    for low, high in windows:
        strains = []
        for begin, end in zip(turns[::2], turns[1::2], strict=True):
            height, stress = track[begin : end + 1].T
            falling = np.minimum.accumulate(stress)[::-1]
            first, last = np.interp((low, high), falling, height[::-1])
            strains.append((first - last) / height[0])
        found.append(float((high - low) / np.mean(strains)))
    return found


serve(lambda given: {"prepare": prepare, "small": small, "measure": measure}[given["task"]](given))
