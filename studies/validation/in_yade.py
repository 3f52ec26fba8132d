"""The rows that YADE computes; started under YADE by `engines`."""

import sys

import numpy as np
import yade
from yade import utils

import demlaws as dl
from demlaws.yade import Law2_ScGeom_MindlinPhys_Demlaws, engines
from studies.under_yade import serve
from studies.validation.arrays import CELLS, EDGE, RIGID, SITES

O = yade.O  # noqa: E741


def _material(job, label, young=1.0):
    O.materials.append(
        yade.FrictMat(
            young=young * job["young"], poisson=job["poisson"], density=job["density"], frictionAngle=1.5, label=label
        )
    )


def _law(job):
    surfaces = {label: dl.Surface(**job["surface"]) for label in ("grain", "rigid")}
    options = job["options"] | ({"shear": job["shear"]} if "shear" in job else {})
    return Law2_ScGeom_MindlinPhys_Demlaws(job["law"], job["unloading"], surfaces, **options)


def _watched(job, look):
    """Engines without damping, and `look()` called after each step's contacts."""
    sys.modules["__main__"].look = look
    O.engines = engines(
        _law(job),
        newton=yade.NewtonIntegrator(damping=0.0),
        after=[yade.PyRunner(command="look()", iterPeriod=1, initRun=True)],
    )
    O.dt = job["dt"]


def impact(job):
    """Peak force [N] and rebound over approach speed of two spheres, or of one and a rigid plane; places after given steps."""
    O.reset()
    radius, speed, peak = job["radius"], job["speed"], [0.0, False]
    _material(job, "grain")
    apart = job["gap"] if "gap" in job else 1e-3 * job["overlap"]
    if job["plane"]:
        _material(job, "rigid", RIGID)
        O.bodies.append(utils.wall((0, 0, 0), 2, sense=1, material="rigid"))
        O.bodies.append(utils.sphere((0, 0, radius + apart), radius, material="grain"))
        O.bodies[1].state.vel = (0, 0, -speed)
    else:
        for side in (-1, 1):
            O.bodies.append(utils.sphere((0, 0, side * (radius + 0.5 * apart)), radius, material="grain"))
            O.bodies[-1].state.vel = (0, 0, -0.5 * side * speed)
    mover = O.bodies[1]

    def look():
        force = O.forces.f(1)[2]
        peak[0], peak[1] = max(peak[0], force), peak[0] > 0.0 and force == 0.0

    _watched(job, look)
    if "after" in job:  # speeds are those of half a step before, and the same as long as nothing touches
        places = []
        for step in job["after"]:
            O.run(step - O.iter, True)
            places.append(mover.state.pos[2])
        return {"places": places}
    for _ in range(job["rounds"]):
        O.run(2000, True)
        if peak[1]:
            break
    rebound = mover.state.vel[2] - (0.0 if job["plane"] else O.bodies[0].state.vel[2])
    return {"peak": peak[0], "restitution": rebound / speed}


def collisions(job):
    """Velocities sideways and away, and ω R [m/s] of spheres after each of the collisions with a rigid plane or another sphere.

    job["motions"]: speed of approach, velocity sideways, ω R before. The other sphere, of radius job["other"] (0: a plane), is
    at rest, or has job["other_spin"] times the surface velocity.
    """
    O.reset()
    radius, other = job["radius"], job["other"]
    _material(job, "grain")
    O.materials[0].frictionAngle = float(np.arctan(job["friction"]))
    if not other:
        _material(job, "rigid", RIGID)
        O.materials[1].frictionAngle = O.materials[0].frictionAngle
        O.bodies.append(utils.wall((0, 0, 0), 2, sense=1, material="rigid"))
    elif job["other_density"] != job["density"]:
        _material(job | {"density": job["other_density"]}, "rigid")
        O.materials[1].frictionAngle = O.materials[0].frictionAngle
    far, numbers = 3.0 * max(radius, other), []
    for n, (down, sideways, spin) in enumerate(job["motions"]):
        numbers.append(O.bodies.append(utils.sphere((n * far, 0, radius * (1.0 + 1e-9)), radius, material="grain")))
        O.bodies[-1].state.vel, O.bodies[-1].state.angVel = (sideways, 0, -down), (0, spin / radius, 0)
        if other:
            label = O.materials[-1].label
            O.bodies.append(utils.sphere((n * far, 0, -other), other, material=label))
            O.bodies[-1].state.angVel = (0, job["other_spin"] * spin / other, 0)
    damping = job["restitution"]
    physics = yade.Ip2_FrictMat_FrictMat_MindlinPhys(**({} if damping == 1.0 else {"en": damping, "es": damping}))
    O.engines = engines(_law(job), physics=physics, newton=yade.NewtonIntegrator(damping=0.0))
    O.dt = job["dt"]
    O.run(3 * job["steps"], True)
    states = [O.bodies[number].state for number in numbers]
    return [[state.vel[0], state.vel[2], state.angVel[1] * radius] for state in states]


def lattice(job):
    """A periodic array along a path of strains: for each, rows of (mean overlap of the contacts, stress tensor)."""
    O.reset()
    O.periodic = True
    cells, radius = CELLS, job["radius"]
    edge = EDGE[job["array"]] * radius * (1.0 + 1e-9)
    O.cell.setBox((cells * edge,) * 3)
    _material(job, "grain")
    for cell in np.ndindex(cells, cells, cells):
        for site in SITES[job["array"]]:
            place = [(c + s + 0.25) * edge for c, s in zip(cell, site, strict=True)]
            O.bodies.append(utils.sphere(tuple(place), radius, material="grain"))
    rows = []

    def look():
        touching = [i.geom.penetrationDepth for i in O.interactions if i.isReal]
        if touching:
            rows.append((float(np.mean(touching)), [list(map(float, row)) for row in utils.getStress()]))

    _watched(job, look)

    def strain(gradient, steps):
        """Rows while the cell is strained by `gradient` in all."""
        rows.clear()
        O.cell.velGrad = yade.Matrix3(*(g / (steps * O.dt) for row in gradient for g in row))
        O.run(steps, True)
        return list(rows)

    found = {name: strain(gradient, job["steps"]) for name, gradient in job["path"].items()}
    O.cell.velGrad = yade.Matrix3.Zero
    return found


KINDS = {"impact": impact, "collisions": collisions, "lattice": lattice}

if __name__ == "__main__":
    serve(lambda jobs: [KINDS[job["kind"]](job) for job in jobs])
