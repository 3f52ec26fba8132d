"""One oedometer test in a periodic cell; started by `studies.experiment` under YADE: SPECIFICATION RESULT (JSON files)."""

import itertools
import time

import numpy as np
import yade
from yade import utils

import demlaws as dl
from demlaws.yade import Law2_ScGeom_MindlinPhys_Demlaws, engines
from studies.under_yade import serve

O = yade.O  # noqa: E741
LOOK = 20  # steps between two settings of the cell's velocity


def scene(given, case, grains, size, friction):
    """A periodic cell [m] with grains (centre, radius) under the law of a case."""
    O.reset()
    O.periodic = True
    O.cell.setBox(*size)
    values = {"young": case["young"], "poisson": given["poisson"], "density": given["density"]}
    O.materials.append(yade.FrictMat(frictionAngle=np.arctan(friction), label="glass", **values))
    O.bodies.append([utils.sphere(tuple(map(float, c)), float(r), material="glass") for c, r in grains])
    if case["law"] == "native":
        law = yade.Law2_ScGeom_MindlinPhys_Mindlin()
    else:
        surface = dl.Surface(roughness=case["roughness"], fractal_dimension=case["fractal_dimension"])
        law = Law2_ScGeom_MindlinPhys_Demlaws(case["law"], case["unloading"], {"glass": surface})
    krot, eta = case.get("rolling") or (0.0, 0.0)
    law.includeMoment = krot > 0.0
    O.engines = engines(
        law,
        physics=yade.Ip2_FrictMat_FrictMat_MindlinPhys(krot=krot, ktwist=krot, eta=eta),
        newton=yade.NewtonIntegrator(damping=given["damping"]),
        timestep=given["timestep"],
        verlet=0.2,
    )
    O.dt = 0.2 * utils.PWaveTimeStep()
    if krot:  # the stepper does not know it: half the limit of the smallest grain with six contacts, all rolling against it
        inertia = min(b.state.inertia[0] for b in O.bodies)
        next(e for e in O.engines if isinstance(e, yade.TimeStepper)).maxDt = (inertia / (12.0 * krot)) ** 0.5


def run(steps):
    """Run this many steps; YADE's own waiting for the end of a run takes as long as hundreds of them."""
    for _ in range(steps):
        O.step()


def stress():
    """Normal stresses of the cell [Pa], compression positive."""
    tensor = utils.getStress()
    return -np.array([tensor[0, 0], tensor[1, 1], tensor[2, 2]])


def rate(given, pressure, inertial):
    """Strain rate [1/s] of this inertial number at a pressure [Pa]."""
    return inertial / (2.0 * given["radius"]) * (pressure / given["density"]) ** 0.5


def porosity(solid):
    """Porosity of the cell that holds this volume of grains [m³]."""
    return 1.0 - solid / O.cell.volume


def hold(given, goal, inertial, finished, limit=400_000):
    """Bring the three normal stresses to a goal [Pa] and keep them there until finished(stresses) is true."""
    goal = np.array(goal)
    largest = rate(given, goal.mean(), inertial)
    for step in range(0, limit, LOOK):
        now = stress()
        velocity = -largest * np.clip(5.0 * (1.0 - now / goal), -1.0, 1.0)
        O.cell.velGrad = yade.Matrix3(velocity[0], 0, 0, 0, velocity[1], 0, 0, 0, velocity[2])
        if finished(now, step):
            return
        run(LOOK)
    raise RuntimeError(f"the stresses are {now} Pa for {goal} Pa and the porosity is not reached after {limit} steps")


def at_rest(goal, steps):
    """A test for `hold`: stresses within 0.5 % of the goal for this many steps, and balanced forces."""
    goal, since = np.array(goal), [0]

    def finished(now, step):
        if np.any(np.abs(now / goal - 1.0) > 5e-3):
            since[0] = step
        return step - since[0] >= steps and utils.unbalancedForce() < 2e-3

    return finished


def prepare(given):
    """A loose packing with YADE's own law at the radial stress: centres, radii and size of the cell [m]."""
    random = np.random.default_rng(given["seed"])
    ratios, shares = given["sizes"]
    radii = given["radius"] * np.interp((np.arange(given["count"]) + 0.5) / given["count"], shares, ratios)
    radii = random.permutation(radii)
    across = int(np.ceil(given["count"] ** (1.0 / 3.0) - 1e-9))
    places = random.permutation(across**3)[: given["count"]]
    pitch = 2.04 * radii.max()
    cells = np.stack([places % across, places // across % across, places // across**2], 1) + 0.5
    shift = random.uniform(-1.0, 1.0, cells.shape) * (0.49 * pitch - radii)[:, None]
    grains = list(zip(pitch * cells + shift, radii, strict=True))
    size = (pitch * across,) * 3
    native = {"law": "native", "young": 70e9}
    scene(given, native, grains, size, given["loose_friction"])
    goal = [given["radial"]] * 3
    hold(given, goal, 1e-2, lambda now, step: now.mean() > 0.5 * goal[0])
    hold(given, goal, 1e-3, at_rest(goal, 2_000))
    return packing_now()


def densify(given, solid):
    """Lower the friction at constant stress until the porosity is the measured one; the friction at the end."""
    goal = [given["radial"]] * 3
    hold(given, goal, 1e-3, at_rest(goal, 1_000))
    friction = [given["loose_friction"]]

    def denser(now, step):
        if porosity(solid) <= given["porosity"] + given["margin"]:
            return True
        if step % 200 == 0 and np.all(np.abs(now / goal - 1.0) < 0.02):
            friction[0] *= 0.97
            utils.setContactFriction(np.arctan(friction[0]))
        return False

    hold(given, goal, 1e-3, denser)
    return friction[0]


def packing_now():
    """Centres and radii of the grains and size of the cell [m]."""
    return {
        "centres": [list(O.cell.wrap(b.state.pos)) for b in O.bodies],
        "radii": [b.shape.radius for b in O.bodies],
        "size": list(O.cell.size),
    }


def oedometer(given, case):
    """Rows of axial strain, axial and radial stress [Pa] and porosity of one case; with "keep" the packing before the test."""
    packing = given["packing"]
    grains = list(zip(packing["centres"], packing["radii"], strict=True))
    solid = float((4.0 / 3.0 * np.pi * np.array(packing["radii"]) ** 3).sum())
    prepared = "friction" in packing
    scene(given, case, grains, packing["size"], case["friction"] if prepared else given["loose_friction"])
    friction = packing["friction"] if prepared else densify(given, solid)
    utils.setContactFriction(np.arctan(case["friction"]))
    goal = [given["radial"], given["radial"], given["axial"][0]]
    hold(given, goal, 5e-4, at_rest(goal, 2_000))
    if given.get("keep"):
        return {**packing_now(), "friction": friction}
    height, rows = O.cell.size[2], []

    def look():
        now = stress()
        rows.append((1.0 - O.cell.size[2] / height, now[2], now[:2].mean(), porosity(solid)))
        return now[2]

    look()
    speed = rate(given, given["axial"][0], given["inertial"])
    for start, end in itertools.pairwise(given["axial"]):
        sense = 1.0 if end > start else -1.0
        O.cell.velGrad = yade.Matrix3(0, 0, 0, 0, 0, 0, 0, 0, -sense * speed)
        while sense * (end - look()) > 0.0:
            if len(rows) > 20_000:
                raise RuntimeError(f"the axial stress {end:g} Pa is not reached: {rows[-1]}")
            run(5 * LOOK)
    return {
        "rows": rows,
        "prepared_with_friction": friction,
        "coordination": 2.0 * O.interactions.countReal() / len(O.bodies),
        "inertial": speed * 2.0 * given["radius"] * (given["density"] / given["axial"][0]) ** 0.5,
        "steps": O.iter,
    }


def answer(given):
    """A packing, or a test of it."""
    started = time.process_time()
    result = oedometer(given, given["case"]) if given.get("case") else prepare(given)
    return {**result, "seconds": time.process_time() - started}


serve(answer)
