"""The scene of `studies.trade.packings` in YADE; started by it under YADE."""

import sys
import time

import numpy as np
import yade
from yade import utils

import demlaws as dl
from demlaws.yade import Law2_ScGeom_MindlinPhys_Demlaws, engines
from studies.under_yade import serve

O = yade.O  # noqa: E741
GRAVITY = 9.81
EVERY = 40  # steps between two readings of the plate


class Box:
    """Grains between a floor, four smooth sides and a plate that waits above."""

    def __init__(self, given, centres, radii, way, gravity=GRAVITY):
        O.reset()
        model, width = way["model"], given["width"]
        kind, values = yade.FrictMat, {name: given[name] for name in ("young", "poisson", "density")}
        if model == "cdm":
            kind, values = yade.FrictMatCDM, {**values, "sigmaMax": given["cdm"][0], "alpha": given["cdm"][1]}
        O.materials.append(kind(frictionAngle=np.arctan(given["friction"]), label="grains", **values))
        O.materials.append(kind(frictionAngle=1e-4, label="walls", **values))  # the Conical Damage Model refuses 0
        top = 10.0 * width  # out of the way
        for axis, place, sense in ((2, 0.0, 1), (0, 0.0, 1), (0, width, -1), (1, 0.0, 1), (1, width, -1), (2, top, -1)):
            position = [width / 2] * 3
            position[axis] = place
            O.bodies.append(utils.wall(tuple(position), axis, sense=sense, material="walls"))
        self.plate = O.bodies[5]
        self.area = width * width
        grains = [utils.sphere(tuple(c), r, material="grains") for c, r in zip(centres.tolist(), radii, strict=True)]
        self.spheres = [O.bodies[number] for number in O.bodies.append(grains)]
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
                **way["options"],
            )  # YADE's radius at the walls, as its own laws have it
        newton = yade.NewtonIntegrator(damping=0.3, gravity=(0, 0, -gravity))
        self.rows, self.reached = [], None
        looking = yade.PyRunner(command="__import__('__main__').box.look()", iterPeriod=EVERY, dead=True, label="looking")
        O.engines = engines(law, physics=physics, newton=newton, verlet=0.2, after=[looking])
        self.looking = next(e for e in O.engines if e.label == "looking")
        self.steps, self.seconds = 0, 0.0
        sys.modules["__main__"].box = self

    def run(self, steps):
        """Run this many steps, and count them and the time they take."""
        started = time.process_time()
        O.run(int(steps), True)
        self.seconds += time.process_time() - started
        self.steps += int(steps)

    def lower_onto_grains(self):
        """Put the plate where it touches the highest grain."""
        top = max(b.state.pos[2] + b.shape.radius for b in self.spheres)
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
        if self.reached(self.rows[-1]):
            O.stopAtIter = O.iter + 1

    def until(self, reached, limit=4_000_000):
        """Run until reached(row); rows, the `state` every few steps."""
        self.rows, self.reached, self.looking.dead = [], reached, False
        before = O.iter
        self.run(limit)
        self.steps += O.iter - before - limit
        self.looking.dead, O.stopAtIter = True, 0
        if not reached(self.rows[-1]):
            raise RuntimeError(f"the walls have not come to their stress or strain after {limit} steps: {self.rows[-1]}")
        return self.rows

    def centre(self):
        """Height of the centre of gravity [m]."""
        return float(np.average([b.state.pos[2] for b in self.spheres], weights=[b.state.mass for b in self.spheres]))

    def contacts(self):
        """Normal forces between grains that touch [N], how many contacts a grain has (without walls')."""
        found = [i.phys.normalForce.norm() for i in O.interactions if i.isReal and min(i.id1, i.id2) > 5]
        forces = [f for f in found if f > 0.0]
        return {"forces": forces, "coordination": 2.0 * len(forces) / len(self.spheres)}


def press(box, run, least):
    """Rest, compression to the stress, hold, unloading to least(stress after the hold), repeated; returns the results.

    run: settle, hold [s], stress [Pa], speeds of the plate down and up [m/s], cycles, steps between two readings (every).
    """
    box.run(run["settle"] / O.dt)
    height = box.centre()
    box.lower_onto_grains()
    branches, held, unbalanced = [], None, 0.0
    for _ in range(run["cycles"]):
        box.looking.iterPeriod = run["every"]
        box.move(-run["speed"])
        branches.append(box.until(lambda row: row[1] >= run["stress"]))
        if held is None:  # while the plate moves, at the stress
            unbalanced = utils.unbalancedForce()
        box.move(0.0)
        if held is None:
            box.looking.iterPeriod = EVERY
            box.run(run["hold"] / O.dt)
            held = {**box.contacts(), "plate": box.state()[0], "stress": box.state()[1]}
            box.looking.iterPeriod = run["every"]
        box.move(run["back"])
        end = least(held["stress"])
        branches.append(box.until(lambda row, end=end: row[1] <= end))
        box.move(0.0)
    about = {"unbalanced": unbalanced, "steps": box.steps, "seconds": box.seconds}
    return {"height": height, "branches": branches, "held": held, **about}


def oedometer(given, way):
    """One way through the test."""
    centres = np.array(given["centres"]) + (np.array(given["shift"]) if way["shaken"] else 0.0)
    box = Box(given, centres, given["radii"], way)
    O.dt = given["dt"]
    return press(box, {**given, "cycles": 1, "every": EVERY}, lambda held: 0.8 * held)


def ways(given):
    """The scene each way."""
    for number, way in enumerate(given["ways"]):
        print(f"PROGRESS {number + 1} {way['label']}", flush=True)
        yield oedometer(given, way)


if __name__ == "__main__":
    serve(lambda given: list(ways(given)))
