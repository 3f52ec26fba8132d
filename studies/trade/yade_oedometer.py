"""The scene of `studies.trade.packings` in YADE; started by it under YADE: oedometer.py SPECIFICATION RESULT (JSON files)."""

import json
import os
import sys
import time

import numpy as np
import yade
from yade import utils

import demlaws as dl
from demlaws.yade import Law2_ScGeom_MindlinPhys_Demlaws, engines

O = yade.O  # noqa: E741
GRAVITY = 9.81
EVERY = 40  # steps between two readings of the plate


def material(given, label, friction, model="", young=None):
    """A YADE material; the Conical Damage Model wants one of its own."""
    values = {"young": young or given["young"], "poisson": given["poisson"], "density": given["density"], "label": label}
    if model == "cdm":
        return yade.FrictMatCDM(frictionAngle=friction, sigmaMax=given["cdm"][0], alpha=given["cdm"][1], **values)
    return yade.FrictMat(frictionAngle=friction, **values)


class Box:
    """Grains between a floor, four smooth sides and a plate that waits above."""

    def __init__(self, given, centres, radii, way, friction, young=None, damping=0.3, gravity=GRAVITY):
        O.reset()
        model, width = way["model"], given["width"]
        O.materials.append(material(given, "grains", np.arctan(friction), model, young))
        O.materials.append(material(given, "walls", 1e-4, model, young))  # the Conical Damage Model refuses 0
        self.top = 10.0 * width  # out of the way
        for axis, place, sense in ((2, 0.0, 1), (0, 0.0, 1), (0, width, -1), (1, 0.0, 1), (1, width, -1), (2, self.top, -1)):
            position = [width / 2] * 3
            position[axis] = place
            O.bodies.append(utils.wall(tuple(position), axis, sense=sense, material="walls"))
        self.plate = O.bodies[5]
        self.area = width * width
        for centre, radius in zip(centres, radii, strict=True):
            O.bodies.append(utils.sphere(tuple(map(float, centre)), float(radius), material="grains"))
        physics = None
        if model == "hertz":
            law = yade.Law2_ScGeom_MindlinPhys_Mindlin()
        elif model == "cdm":
            law = yade.Law2_ScGeom_MindlinPhysCDM_HertzMindlinCDM()
            physics = yade.Ip2_FrictMatCDM_FrictMatCDM_MindlinPhysCDM()
        else:
            surface = dl.Surface(**given["surface"])
            law = Law2_ScGeom_MindlinPhys_Demlaws(
                way["given"],
                way["unloading"],
                {"grains": surface, "walls": surface},
                flats="yade",
                shear=way["shear"],
                **way["options"],
            )  # YADE's radius at the walls, as its own laws have it
        newton = yade.NewtonIntegrator(damping=damping, gravity=(0, 0, -gravity))
        self.rows, self.reached = [], None
        looking = yade.PyRunner(command="__import__('__main__').box.look()", iterPeriod=EVERY, dead=True, label="looking")
        O.engines = engines(law, physics=physics, newton=newton, verlet=0.2, after=[looking])
        self.looking = next(e for e in O.engines if e.label == "looking")
        self.steps, self.seconds = 0, 0.0

    def run(self, steps):
        """Run this many steps, and count them and the time they take."""
        started = time.process_time() if O.numThreads == 1 else time.perf_counter()
        O.run(int(steps), True)
        self.seconds += (time.process_time() if O.numThreads == 1 else time.perf_counter()) - started
        self.steps += int(steps)

    def spheres(self):
        """The bodies that are spheres."""
        return [b for b in O.bodies if isinstance(b.shape, yade.Sphere)]

    def centres(self):
        """Centres of the spheres [m], one row each."""
        return np.array([tuple(b.state.pos) for b in self.spheres()])

    def lower_onto_grains(self):
        """Put the plate where it touches the highest grain."""
        top = max(b.state.pos[2] + b.shape.radius for b in self.spheres())
        self.plate.state.pos = (self.plate.state.pos[0], self.plate.state.pos[1], top)

    def move(self, speed):
        """Give the plate this vertical speed [m/s]."""
        self.plate.state.vel = (0, 0, speed)

    def state(self):
        """Height of the plate and stress on it."""
        return self.plate.state.pos[2], O.forces.f(self.plate.id)[2] / self.area

    def look(self):
        """Called by YADE every few steps: YADE's own waiting for a run to end takes as long as hundreds of them."""
        self.rows.append(self.state())
        if self.reached(self.rows[-1][1]):
            O.stopAtIter = O.iter + 1

    def until(self, reached, limit=200_000):
        """Run until the stress on the plate says so; (height of the plate, stress) every few steps."""
        self.rows, self.reached, self.looking.dead = [], reached, False
        before = O.iter
        self.run(limit)
        self.steps += O.iter - before - limit
        self.looking.dead, O.stopAtIter = True, 0
        if not reached(self.rows[-1][1]):
            raise RuntimeError(f"the plate has not reached its stress after {limit} steps: {self.rows[-1]}")
        return self.rows

    def bring_to(self, pressure, speed):
        """Move the plate until its stress stays near `pressure` while it rests."""
        self.looking.iterPeriod = EVERY // 2  # the plate is fast
        for _ in range(200):
            self.run(2_000)
            now = self.state()[1]
            if now < 0.7 * pressure:
                self.move(-speed)
                self.until(lambda stress: stress > 1.1 * pressure)
            elif now > 1.4 * pressure:
                self.move(speed)
                self.until(lambda stress: stress < 0.9 * pressure)
            else:
                return
            self.move(0.0)
            speed *= 0.8
        raise RuntimeError(f"the packing does not bear {pressure:g} Pa: {now:g} Pa")

    def forces(self):
        """Normal forces between grains that touch [N]."""
        found = [i.phys.normalForce.norm() for i in O.interactions if i.isReal and min(i.id1, i.id2) > 5]
        return [f for f in found if f > 0.0]


def prepare(given):
    """Packing at rest under gravity, by YADE's Hertz: (width of the box, centres).

    Soft grains with little friction fall and are pressed; then they become granite in steps, between which the plate
    gives way until its stress is what it was: the packing stays dense while its overlaps shrink to those of granite.
    """
    global box
    hertz = {"model": "hertz"}
    centres, radii = np.array(given["centres"]), np.array(given["radii"])
    pressed, plate = 3e3, None
    for softer in (1000, 300, 100, 30, 10, 3, 1):
        box = Box(given, centres, radii, hertz, 0.05, given["young"] / softer, gravity=3 * GRAVITY if softer == 1000 else 0.0)
        O.dt = given["dt"] * min(softer, 30) ** 0.5
        if softer == 1000:
            fall = (2.0 * centres[:, 2].max() / (3 * GRAVITY)) ** 0.5
            box.run(3.0 * fall / O.dt)
            box.lower_onto_grains()
            box.bring_to(pressed, 0.1)
        else:
            box.plate.state.pos = plate
            box.bring_to(pressed, 0.02)
        plate, centres = box.plate.state.pos, box.centres()
        print(f"E/{softer}: {box.state()[1]:.0f} Pa, {len(box.forces())} contacts", flush=True)
    box = Box(given, centres, radii, hertz, given["friction"])
    O.dt = given["dt"]
    box.run(2.0 * given["settle"] / O.dt)
    print(f"at rest: {utils.kineticEnergy():.1e} J, {len(box.forces())} contacts", flush=True)
    return box.centres()


def oedometer(given, centres, way):
    """One way through the test."""
    global box
    box = Box(given, centres, np.array(given["radii"]), way, given["friction"])
    O.dt = given["dt"]
    box.run(given["settle"] / O.dt)
    height = float(np.average(box.centres()[:, 2], weights=np.array(given["radii"]) ** 3))
    box.lower_onto_grains()
    box.move(-given["speed"])
    loading = box.until(lambda stress: stress >= given["stress"])
    box.move(0.0)
    box.run(given["hold"] / O.dt)
    plate, stress = box.state()
    forces = box.forces()
    box.move(given["speed"] / 3)
    unloading = box.until(lambda now: now < 0.8 * stress)
    return {
        "height": height,
        "plate": plate,
        "loading": loading,
        "stress": stress,
        "forces": forces,
        "unloading": unloading,
        "steps": box.steps,
        "seconds": box.seconds,
    }


def main():
    """Read the specification, run the scene each way, write the result."""
    with open(sys.argv[1]) as file:
        given = json.load(file)
    if not given["ways"]:
        found = prepare(given).tolist()
    else:
        centres = np.array(given["centres"])
        found = []
        for number, way in enumerate(given["ways"]):
            print(f"PROGRESS {number + 1} {way['label']}", flush=True)
            found.append(oedometer(given, centres + (np.array(given["shift"]) if way["shaken"] else 0.0), way))
    hand_over(found)


def hand_over(found):
    """Write what was found to RESULT and end YADE at once."""
    with open(sys.argv[2], "w") as file:
        json.dump(found, file)
    sys.stdout.flush()
    os._exit(0)


if __name__ == "__main__":
    main()
