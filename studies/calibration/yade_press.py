"""A packing pressed in one direction, for each sample of a law; started by `studies.calibration` under YADE (JSON files)."""

import numpy as np
import yade
from yade import pack, utils

import demlaws as dl
from demlaws.yade import Law2_ScGeom_MindlinPhys_Demlaws, engines
from studies.under_yade import serve

O = yade.O  # noqa: E741


def scene(given, sample, grains, side, friction):
    """A periodic cell with these grains under the law at a sample (combined roughness [µm], effective modulus [GPa])."""
    O.reset()
    O.periodic = True
    O.cell.setBox(side, side, side)
    young = 2e9 * sample[1] * (1.0 - given["poisson"] ** 2)  # of two like grains
    surface = dl.Surface(roughness=1e-6 * sample[0] / 2**0.5, fractal_dimension=given["dimension"])
    values = {"poisson": given["poisson"], "density": 2680.0, "label": "granite"}
    O.materials.append(yade.FrictMat(young=young, frictionAngle=np.arctan(friction), **values))
    O.bodies.append([utils.sphere(tuple(c), given["radius"], material="granite") for c in grains])
    law = Law2_ScGeom_MindlinPhys_Demlaws("pohrt-popov", "hertz", {"granite": surface})
    O.engines = engines(law, newton=yade.NewtonIntegrator(damping=0.3), timestep=0.5)
    O.dt = 0.2 * utils.PWaveTimeStep()


def deform(rates, stress, steps=100_000):
    """Shrink the cell at these rates [1/s] until the vertical stress passes `stress` [Pa]: rows of height [m] and stress."""
    O.cell.velGrad = yade.Matrix3(-rates[0], 0, 0, 0, -rates[1], 0, 0, 0, -rates[2])
    rows = []
    while len(rows) < steps // 50 and (not rows or rows[-1][1] < stress):
        for _ in range(50):
            O.step()
        rows.append((O.cell.size[2], -utils.getStress()[2, 2]))
    return np.array(rows)


def prepare(given):
    """Centres and side [m] of a dense packing without friction at a third of the lowest stress."""
    count, radius = given["count"], given["radius"]
    side = 2.0 * radius * (count * np.pi / 6.0 / 0.3) ** (1.0 / 3.0)
    cloud = pack.SpherePack()
    cloud.makeCloud((0, 0, 0), (side,) * 3, rMean=radius, num=count, periodic=True, seed=given["seed"])
    scene(given, (4.0, 32.0), [c for c, _ in cloud], side, 0.0)
    for rate in (4, 1, 0.3, 0.1):
        deform((rate,) * 3, given["stresses"][0] / 3.0)
        deform((0, 0, 0), np.inf, 1_500)
    return [[list(b.state.pos) for b in O.bodies], O.cell.size[2]]


def press(given):
    """Strains at the stresses, the packing pressed for each sample."""
    centres, side = packing = given["packing"] or prepare(given)
    strains = []
    for sample in given["samples"]:
        scene(given, sample, centres, side, 0.5)
        deform((0, 0, 0), np.inf, 1_000)
        rows = deform((0, 0, 0.4), 1.05 * given["stresses"][-1])
        if rows[-1][1] < given["stresses"][-1]:
            raise RuntimeError(f"{rows[-1][1]:g} Pa: the packing does not reach {given['stresses'][-1]:g} Pa")
        height = np.interp(given["stresses"], np.maximum.accumulate(rows[:, 1]), rows[:, 0])
        strains.append((1.0 - height / side).tolist())
    return {"strain": strains, "packing": packing}


serve(press)
