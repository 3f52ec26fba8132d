"""The scenes of `studies.shear.vibration` in YADE; started by it under YADE."""

import math
import sys

import numpy as np
import yade
from yade import utils

from demlaws.yade import Law2_ScGeom_MindlinPhys_Demlaws, engines
from studies.under_yade import serve

O = yade.O  # noqa: E741


def law_of(model):
    """The functor of a model of shear, with Hertz's law."""
    if model == "own":
        return yade.Law2_ScGeom_MindlinPhys_Mindlin()
    options = {"shear": "slip"} if model == "slip" else {"levels": int(model[0])}
    return Law2_ScGeom_MindlinPhys_Demlaws("hertz", **options)


def answer(given):
    """[cycles, place along the slope, height [m]] of the centre of mass of the grains."""
    material = yade.FrictMat(
        young=given["young"],
        poisson=given["poisson"],
        density=given["density"],
        frictionAngle=math.atan(given["friction"]),
        label="grains",
    )
    O.materials.append(material)
    grains = [O.bodies.append(utils.sphere(place, size / 2, material="grains")) for size, place in given["grains"]]
    for size, place in given["fixed"]:
        O.bodies.append(utils.sphere(place, size / 2, material="grains", fixed=True))
    for axis, places in given["walls"].items():
        for place in places:
            position = [0.0] * 3
            position["xyz".index(axis)] = place
            O.bodies.append(utils.wall(tuple(position), "xyz".index(axis), material="grains"))
    if not given["turns"]:
        for number in grains:
            O.bodies[number].state.blockedDOFs = "XYZ"
    physics = yade.Ip2_FrictMat_FrictMat_MindlinPhys(en=given["restitution"], es=given["restitution"])
    newton = yade.NewtonIntegrator(damping=0.0)
    gravity, swing, period = np.array(given["gravity"]), given["swing"], given["period"]
    weights = np.array([O.bodies[number].state.mass for number in grains])
    began = None

    def shake():
        part = 0.0 if began is None else math.sin(2 * math.pi * (O.iter - began) / period)
        newton.gravity = tuple(9.81 * (1.0 + swing * part) * gravity)

    sys.modules["__main__"].shake = shake
    shaker = yade.PyRunner(command="__import__('__main__').shake()", iterPeriod=10, initRun=True)
    O.engines = engines(law_of(given["model"]), physics=physics, newton=newton, verlet=0.2, before=[shaker])
    O.dt = given["dt"]
    O.run(given["settle"], True)
    began, rows = O.iter, []
    for step in range(0, given["steps"] + 1, given["every"]):
        if step:
            O.run(given["every"], True)
        places = np.array([O.bodies[number].state.pos for number in grains])
        mean = (weights @ places) / weights.sum()
        rows.append([step / period, mean[0], mean[2]])
    return rows


if __name__ == "__main__":
    serve(answer)
