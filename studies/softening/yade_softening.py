"""Runs of `studies.softening.study` in YADE; started by it under YADE.

Each run's row is printed as it ends, so that a study that is stopped keeps what it has.
"""

import json

import numpy as np
import yade
from yade import utils

from studies.trade.yade_oedometer import Box, press
from studies.under_yade import serve

O = yade.O  # noqa: E741


def grains_of(given, run, places, kind=Box):
    """The run's box of grains at `places` of the specification, moved at random, as this copy of the run wants."""
    centres = np.array(given[places])
    centres = centres + run["shake"] * np.random.default_rng(run["copy"]).uniform(-1.0, 1.0, centres.shape)
    # the rows that are kept were measured with YADE's own shear
    way = {"model": "", "given": run["law"], "unloading": run["unloading"], "options": {"shear": "native"}}
    values = {**given, "young": run["young"], "surface": run["surface"], "density": run["density"]}
    made = kind(values, centres, given["radii"], way, gravity=run["gravity"])
    O.dt = run["dt"]
    return made


def cycles(given, run):
    """At rest under gravity, pressed to the stress, held, eased to a part of it, and so on."""
    return press(grains_of(given, run, "centres"), run, lambda held: run["least"])


def pour(given, run):
    """A loose block falls and comes to rest: height of the centre of gravity, contacts, what still moves."""
    box = grains_of(given, run, "loose")
    box.run(run["time"] / O.dt)
    return {"height": box.centre(), "held": box.contacts(), "unbalanced": utils.unbalancedForce(), "steps": box.steps}


class Sheared(Box):
    """Grains between six smooth walls: two sides and the plate move, to a stress or at a speed."""

    def state(self):
        """Stress [Pa] on the moving walls across x, y and z, and the height [m] of the box."""
        x, y, z = O.bodies[2].state.pos[0], O.bodies[4].state.pos[1], self.plate.state.pos[2]
        return O.forces.f(2)[0] / (y * z), O.forces.f(4)[1] / (x * z), O.forces.f(5)[2] / (x * y), z

    def follow(self, run, axial=None):
        """Rows until the moving walls have their stress, or the plate at the speed `axial` its strain."""
        self.run_of, self.axial, self.looking.iterPeriod = run, axial, 10

        def reached(row):
            if axial is None:
                return len(self.rows) > 100 and all(abs(one / run["stress"] - 1.0) < 0.02 for one in row[:3])
            return row[3] <= (1.0 - run["strain"]) * self.rows[0][3]

        return self.until(reached, 400_000 if axial is None else 2_000_000)

    def look(self):
        """Called by YADE every few steps: note stress and size, set the walls' speeds."""
        super().look()
        run = self.run_of
        wanted = [run["gain"] * (one / run["stress"] - 1.0) for one in self.rows[-1][:3]]
        x, y, z = (max(-run["fastest"], min(run["fastest"], v)) for v in wanted)
        O.bodies[2].state.vel, O.bodies[4].state.vel = (x, 0, 0), (0, y, 0)
        self.move(z if self.axial is None else self.axial)


def shear(given, run):
    """Isotropic compression, then the plate comes down between sides kept at their stress: rows of stresses and sizes."""
    box = grains_of(given, run, "centres", Sheared)
    box.run(run["settle"] / O.dt)
    box.lower_onto_grains()
    next(e for e in O.engines if isinstance(e, yade.NewtonIntegrator)).gravity = (0, 0, 0)
    box.follow(run)
    rows = box.follow(run, -run["speed"])
    return {
        "held": box.contacts(),
        "rows": rows[::10],
        "unbalanced": utils.unbalancedForce(),
        "steps": box.steps,
    }


def main(given):
    """Do each run, and print what was found as a line that `study` reads."""
    for number, run in enumerate(given["runs"]):
        try:
            found = {"cycles": cycles, "pour": pour, "shear": shear}[run["process"]](given, run)
        except RuntimeError as error:
            found = {"failed": str(error)}
        print("PROGRESS " + json.dumps({"number": number, "found": found}), flush=True)
    return []


if __name__ == "__main__":
    serve(main)
