"""What laws cost in a YADE step, and what YADE's own models do on one contact; started by `studies.costs.steps` under YADE.

The spheres of a close packing stand still while the interaction loop runs:
the same functor alternates every two steps between our code, Mindlin's own and code that does nothing, over the same
contacts in the same memory, so that the differences are the law's. Models of YADE's have packings of their own.
"""

import ctypes
import time

import numba
import numpy as np
import yade
from numba import types
from yade import utils

import demlaws as dl
from demlaws.yade import Law2_ScGeom_MindlinPhys_Demlaws, native
from studies.trade.candidates import close_packing
from studies.trade.yade_oedometer import material
from studies.under_yade import serve

O = yade.O  # noqa: E741
NATIVE = yade.Law2_ScGeom_MindlinPhys_Mindlin()
BLOCK = 2  # steps timed in a row: short, so that some blocks are not interrupted
VISIT = 5  # rounds in a scene before the next has its turn


def spheres(side, radius, overlap, stone):
    """A close packing of side³ spheres with 4 to 5 contacts each, overlapping by `overlap` [m]."""
    O.materials.append(stone)
    for place in close_packing(side, radius, overlap).tolist():
        O.bodies.append(utils.sphere(place, radius * (1 + 1e-9 * np.sin(len(O.bodies))), material=stone))
    O.dt = 1e-9


def scene(side, given, way):
    """A new scene with a packing under one way: (its number, its functor)."""
    number = O.addScene()
    O.switchToScene(number)
    stone = material(given, "grains", 0.5, way["model"])
    spheres(side, given["radius"], given["overlap"], stone)
    law, physics = functor(given, way, f"law{number}")
    O.engines = [
        yade.ForceResetter(),
        yade.InsertionSortCollider([yade.Bo1_Sphere_Aabb()], verletDist=0.2 * given["radius"]),
        yade.InteractionLoop([yade.Ig2_Sphere_Sphere_ScGeom()], [physics], [law]),
        yade.NewtonIntegrator(damping=0.3, gravity=(0, 0, -9.81)),
    ]
    for _ in range(3):
        O.step()
    O.timingEnabled = True
    return number, law


def functor(given, way, label="demlaws"):
    """(Law2, Ip2) functors of a way."""
    if way["model"] == "hertz":
        return yade.Law2_ScGeom_MindlinPhys_Mindlin(), yade.Ip2_FrictMat_FrictMat_MindlinPhys()
    if way["model"] == "cdm":
        return yade.Law2_ScGeom_MindlinPhysCDM_HertzMindlinCDM(), yade.Ip2_FrictMatCDM_FrictMatCDM_MindlinPhysCDM()
    surface = dl.Surface(**given["surface"])
    law = Law2_ScGeom_MindlinPhys_Demlaws(
        way["given"], way["unloading"], {"grains": surface}, label=label, **way["options"], **way.get("spans", {})
    )
    return law, yade.Ip2_FrictMat_FrictMat_MindlinPhys()


def undisturbed(samples):
    """Lower decile: other processes can only add time."""
    return float(np.quantile(samples, 0.1))


def clock():
    """Processor time with one thread, which other processes disturb less."""
    return time.process_time() if O.numThreads == 1 else time.perf_counter()


def loop_time(steps=BLOCK):
    """Nanoseconds a step of the interaction loop alone."""
    for engine in O._currEngines:  # the guard, too, which would put our code back
        engine.dead = not isinstance(engine, (yade.InteractionLoop, yade.ForceResetter))  # the spheres stand still
    O.step()  # not O.run, which waits for 40 ms before it looks whether a run has ended
    started = clock()
    for _ in range(steps):
        O.step()
    return 1e9 * (clock() - started) / steps


def rest_time(steps=20):
    """Nanoseconds a step of everything but the interaction loop."""
    for engine in O._currEngines:
        engine.dead, engine.execTime = False, 0
    for _ in range(steps):
        O.step()
    return sum(e.execTime for e in O._currEngines if not isinstance(e, yade.InteractionLoop)) / steps


@numba.cfunc(types.uint8(*[types.int64] * 4))
def do_nothing(this, geom, phys, interaction):
    """A `go` without forces."""
    return 1


def silent(attachment):
    """A table of virtual functions as the attachment's, but with a `go` that does nothing."""
    table = attachment.table.copy()
    table[2 + attachment.layout.slot[1]] = do_nothing.address
    return table


def measure(given, ways, side, repeats):
    """One dict per way: contacts, ns per step of the loop and of the rest, of Mindlin's own code, of no code (the last two:
    None for YADE's own models and the public way)."""
    made, keep = [], []
    for way in ways:
        number, law = scene(side, given, way)
        attachment = law.binding.attachment if hasattr(law, "binding") else None
        tables = [None]
        if attachment is not None:
            table = silent(attachment)
            keep.append(table)
            mindlin = ctypes.c_uint64.from_address(native.address(NATIVE) + attachment.layout.find_slot(NATIVE)[0]).value
            tables = [attachment.table.ctypes.data + 16, mindlin, table.ctypes.data + 16]
        rest = [rest_time() for _ in range(5)]
        made.append((number, law, tables, [[] for _ in tables], undisturbed(rest), O.interactions.countReal()))
    place = native.layout().slot[0] if any(tables[0] is not None for _, _, tables, *_ in made) else 0
    for _ in range(-(-repeats // VISIT)):
        for number, law, tables, times, _, _ in made:
            O.switchToScene(number)
            loop_time(4)  # its memory comes back from behind the other scenes'
            for _ in range(VISIT):
                for table, samples in zip(tables, times, strict=True):
                    if table is not None:
                        ctypes.c_uint64.from_address(native.address(law) + place).value = table
                    samples.append(loop_time())
            if tables[0] is not None:
                ctypes.c_uint64.from_address(native.address(law) + place).value = tables[0]
    found = []
    for _, _, _, times, rest, contacts in made:
        loops = [undisturbed(samples) for samples in times] + [None] * (3 - len(times))
        found.append({"contacts": contacts, "rest": rest, "loop": loops[0], "mindlin": loops[1], "nothing": loops[2]})
    return found


def one_contact(given, way, paths, steps=300):
    """Normal forces [N] of one contact of two grains at the overlaps [m] of each path, reached in small steps from 0."""
    result = []
    for path in paths:
        O.reset()
        stone = material(given, "grains", 0.5, way["model"])
        O.materials.append(stone)
        radius = given["radius"]
        O.bodies.append([utils.sphere((0, 0, z), radius, material=stone, fixed=True) for z in (0.0, 2.0 * radius)])
        law, physics = functor(given, way)
        O.engines = [
            yade.ForceResetter(),
            yade.InsertionSortCollider([yade.Bo1_Sphere_Aabb()], verletDist=0.1 * radius),
            yade.InteractionLoop([yade.Ig2_Sphere_Sphere_ScGeom()], [physics], [law]),
            yade.NewtonIntegrator(),  # the collider asks for it; the spheres are fixed
        ]
        O.dt = 1e-9
        forces = []
        for start, end in zip([0.0, *path[:-1]], path, strict=True):
            for overlap in np.linspace(start, end, steps if start == 0.0 else steps // 10)[1:]:
                O.bodies[1].state.pos = (0, 0, 2.0 * radius - overlap)
                O.step()
            forces.append(O.forces.f(1)[2])
        result.append(forces)
    return result


def answer(given):
    """Forces on paths, or costs."""
    if "paths" in given:
        return [one_contact({**given, "cdm": way["cdm"]}, way, given["paths"]) for way in given["ways"]]
    return measure(given, given["ways"], given["side"], given["repeats"])


if __name__ == "__main__":
    serve(answer)
