"""Runs of `studies.softening.study` in YADE; started by it under YADE: yade_softening.py SPECIFICATION RESULT (JSON files).

Each run's row is printed as it ends, so that a study that is stopped keeps what it has.
"""

import json
import sys

import numpy as np
import yade
from yade import utils

from studies.trade.yade_oedometer import EVERY, Box, hand_over

O = yade.O  # noqa: E741


def grains_of(given, run, centres, kind=Box):
    """The run's box of grains at `centres`."""
    way = {"model": run["model"], "given": run["law"], "unloading": run["unloading"], "options": run["options"]}
    way["shear"] = run.get("shear", "native")  # the rows that are kept were measured with YADE's own
    values = {**given, "young": run["young"], "surface": run["surface"], "density": run["density"]}
    made = kind(values, centres, np.array(given["radii"]), way, given["friction"], gravity=run["gravity"])
    O.dt = run["dt"]
    return made


def shaken(centres, run):
    """Centres [m] moved at random, as this copy of the run wants."""
    random = np.random.default_rng(run["copy"])
    return centres + run["shake"] * random.uniform(-1.0, 1.0, centres.shape)


def state_of(made):
    """Forces between grains, how many contacts a grain has (those with the walls are left out), kinetic energy."""
    forces = made.forces()
    return {"forces": forces, "coordination": 2.0 * len(forces) / len(made.spheres()), "kinetic": utils.kineticEnergy()}


def cycles(given, run):
    """At rest under gravity, pressed to the stress, held, eased to a part of it, and so on: (height, stress) of each branch."""
    global box
    box = grains_of(given, run, shaken(np.array(given["centres"]), run))
    box.run(run["settle"] / O.dt)
    box.lower_onto_grains()
    top = box.state()[0]
    branches, held, unbalanced = [], None, 0.0
    for number in range(run["cycles"]):
        for speed, reached in (
            (-run["speed"], lambda now: now >= run["stress"]),
            (run["speed"], lambda now: now <= run["least"]),
        ):
            box.move(speed)
            box.looking.iterPeriod = run["every"]
            branches.append(box.until(reached, 4_000_000))
            if held is None:  # while the plate moves, at the stress
                unbalanced = utils.unbalancedForce()
            box.move(0.0)
            if number == 0 and held is None:
                box.looking.iterPeriod = EVERY
                box.run(run["hold"] / O.dt)
                held = {**state_of(box), "plate": box.state()[0], "stress": box.state()[1]}
    about = {"unbalanced": unbalanced, "steps": box.steps, "seconds": box.seconds}
    return {"top": top, "branches": branches, "held": held, **about}


def pour(given, run):
    """A loose block falls and comes to rest: height of the centre of gravity, contacts, what still moves."""
    global box
    box = grains_of(given, run, shaken(np.array(given["loose"]), run))
    box.run(run["time"] / O.dt)
    height = float(np.average(box.centres()[:, 2], weights=np.array(given["radii"]) ** 3))
    about = {"unbalanced": utils.unbalancedForce(), "steps": box.steps, "seconds": box.seconds}
    return {"height": height, "held": state_of(box), **about}


class Sheared(Box):
    """Grains between six smooth walls: two sides and the plate move, to a stress or at a speed."""

    def stresses(self):
        """Stress [Pa] on the moving walls across x, y and z, and the size [m] of the box."""
        x, y, z = O.bodies[2].state.pos[0], O.bodies[4].state.pos[1], self.plate.state.pos[2]
        return (O.forces.f(2)[0] / (y * z), O.forces.f(4)[1] / (x * z), O.forces.f(5)[2] / (x * y)), (x, y, z)

    def follow(self, run, axial):
        """Keep the moving walls at the stress; the plate at a speed instead, where `axial` is one."""
        self.run_of, self.axial, self.rows = run, axial, []
        self.looking.iterPeriod, self.looking.dead = 10, False
        before, limit = O.iter, 400_000 if axial is None else 2_000_000
        self.run(limit)
        self.steps += O.iter - before - limit
        self.looking.dead, O.stopAtIter = True, 0
        if O.iter - before == limit:
            raise RuntimeError(f"the walls have not come to their stress or strain after {limit} steps: {self.rows[-1]}")
        return self.rows

    def look(self):
        """Called by YADE every few steps: note stress and size, set the walls' speeds."""
        if self.reached is not None:  # the box's own
            return Box.look(self)
        run = self.run_of
        stress, size = self.stresses()
        self.rows.append((*stress, *size))
        wanted = [run["gain"] * (one / run["stress"] - 1.0) for one in stress]
        limited = [max(-run["fastest"], min(run["fastest"], v)) for v in wanted]
        O.bodies[2].state.vel, O.bodies[4].state.vel = (limited[0], 0, 0), (0, limited[1], 0)
        self.plate.state.vel = (0, 0, limited[2] if self.axial is None else self.axial)
        if self.axial is None:
            done = len(self.rows) > 100 and all(abs(one / run["stress"] - 1.0) < 0.02 for one in stress)
        else:
            done = size[2] <= (1.0 - run["strain"]) * self.rows[0][5]
        if done:
            O.stopAtIter = O.iter + 1
        return None


def shear(given, run):
    """Isotropic compression, then the plate comes down between sides kept at their stress: rows of stresses and sizes."""
    global box
    box = grains_of(given, run, shaken(np.array(given["centres"]), run), Sheared)
    box.run(run["settle"] / O.dt)
    box.lower_onto_grains()
    next(e for e in O.engines if isinstance(e, yade.NewtonIntegrator)).gravity = (0, 0, 0)
    compressed = box.follow(run, None)[-1]
    before = state_of(box)
    rows = box.follow(run, -run["speed"])
    return {
        "compressed": compressed,
        "before": before,
        "held": state_of(box),
        "rows": rows[::10],
        "unbalanced": utils.unbalancedForce(),
        "steps": box.steps,
        "seconds": box.seconds,
    }


def main():
    """Read the specification, do each run, write what was found."""
    with open(sys.argv[1]) as file:
        given = json.load(file)
    for number, run in enumerate(given["runs"]):
        try:
            found = {"cycles": cycles, "pour": pour, "shear": shear}[run["process"]](given, run)
        except RuntimeError as error:
            found = {"failed": str(error)}
        print("PROGRESS " + json.dumps({"number": number, "found": found}), flush=True)
    hand_over([])


if __name__ == "__main__":
    main()
