"""Rows that engines compute: impacts, restitution, regular arrays."""

import math
import tempfile

import numpy as np

from studies.cases import chain
from studies.engines import available, under_yade
from studies.validation import lammps_tests
from studies.validation.in_lammps import answer as in_lammps
from studies.validation.in_liggghts import answer as in_liggghts
from studies.validation.jobs import (
    PROBE,
    array_jobs,
    collision_jobs,
    contact_of,
    impact_jobs,
    kept_jobs,
    shear_jobs,
)
from studies.validation.oblique import collision_rows
from studies.validation.published import (
    BRANCHES,
    IMPACT_TOLERANCE,
    IMPACTS,
    KEPT,
    SPEEDS,
    bound,
    kept_rows,
    quiet,
    restitution_of,
)
from studies.validation.row import between, missing, near


def impact_rows(engine, _, found):
    """Rows of the published impacts in an engine."""
    for one, answer in zip(IMPACTS, found, strict=False):
        yield near(f"peak force: {one.name}", one.peak, answer["peak"], IMPACT_TOLERANCE, "chung-ooi", unit="N", where=engine)
    first, second = len(IMPACTS), len(IMPACTS) + len(SPEEDS)
    for ratio, answer in zip(SPEEDS, found[first:second], strict=True):
        wanted = restitution_of(ratio)
        yield near(f"restitution at V/V_y = {ratio:g}", wanted, answer["restitution"], 1e-4, "thornton", where=engine)
    for (name, _, _, wanted), answer in zip(BRANCHES, found[second:], strict=True):
        yield near(f"{name}: restitution", wanted, answer["restitution"], 1e-4, name, where=engine)


# --- regular arrays


COUNT = {"SC": 3, "FCC": 6}  # contacts a sphere
VOLUME = {"SC": 1.0, "FCC": math.sqrt(0.5)}  # a sphere's share of the cell over the cube of the distance


def pressure_of(array, force, distance):
    """p = n P D/(3 V): Duffy & Mindlin's arrays under equal pressure from all sides."""
    return COUNT[array] * force * distance / (3.0 * VOLUME[array] * distance**3)


def moduli(array, normal, shear, distance):
    """C11, C12, C44 of the array from the stiffnesses of its contacts (Duffy & Mindlin 1957, as lattice sums)."""
    if array == "SC":
        return normal / distance, 0.0, 0.5 * shear / distance
    whole = math.sqrt(2.0) * (normal + shear) / distance
    return whole, (normal - shear) / (math.sqrt(2.0) * distance), 0.5 * whole


def array_rows(engine, jobs, found):
    """Rows of the regular arrays in an engine."""
    for job, answer in zip(jobs, found, strict=True):
        array, unloading = job["array"], job["unloading"]
        one = bound(job["law"], contact_of(job), unloading)
        label = f"{array}, {job['law']}" + ("" if unloading == "elastic" else f", {unloading} unloading")
        overlap, stress = _columns(answer["loading"])
        force = quiet(one.force, overlap[-1])
        distance = 2.0 * job["radius"] - overlap[-1]
        pressure = -np.trace(stress, axis1=1, axis2=2) / 3.0
        yield near(
            f"{label}: pressure",
            pressure_of(array, force, distance),
            pressure[-1],
            1e-6,
            "duffy-mindlin",
            unit="Pa",
            where=engine,
        )
        yield _bulk(f"{label}: bulk modulus, loading", engine, array, job, one, overlap=overlap[-20:], pressure=pressure[-20:])
        if "uniaxial" in answer:
            # the array has moved on by a step before the probe begins
            tangent = quiet(one.stiffness, _columns(answer["uniaxial"])[0].mean())
            ratio = 2.0 * (1.0 - job["poisson"]) / (2.0 - job["poisson"])
            c11, c12, c44 = moduli(array, tangent, ratio * tangent, distance)
            along = _slopes(answer["uniaxial"], PROBE)
            yield near(f"{label}: C11", c11, -along[0, 0], 1e-3, "duffy-mindlin", unit="Pa", where=engine)
            if c12:
                yield near(f"{label}: C12", c12, -along[1, 1], 2e-3, "duffy-mindlin", unit="Pa", where=engine)
        if "shear" in answer:
            yield near(
                f"{label}: C44",
                c44,
                0.5 * _slopes(answer["shear"], PROBE)[0, 1],
                1e-3,
                "duffy-mindlin",
                unit="Pa",
                where=engine,
            )
        overlap, stress = _columns(answer["unloading"])
        pressure = -np.trace(stress, axis1=1, axis2=2) / 3.0
        yield _bulk(f"{label}: bulk modulus, unloading", engine, array, job, one, overlap=overlap[:20], pressure=pressure[:20])


def shear_modulus(job, answer):
    """Mean pressure [Pa], C44 that the engine has, and the smallest and largest that the lattice sum gives [Pa].

    Shear in a plane of the cube loads half of the plane's contacts and unloads the other half; the other contacts are sheared
    at a constant normal force.
    """
    one = bound(job["law"], contact_of(job), job["unloading"])
    overlap, stress = _columns(answer["shear"])
    here = float(overlap.mean())
    distance = 2.0 * job["radius"] - here
    along = quiet(one.follow, [here, here * (1.0 - 1e-9)]).stiffness
    ratio = 2.0 * (1.0 - job["poisson"]) / (2.0 - job["poisson"])
    path = [here, here * (1.0 - 1e-9)]
    sideways = quiet(one.shear_stiffness, path, ratio, job["options"]["shear"])
    sums = [moduli(job["array"], along.mean(), value, distance)[2] for value in sideways]
    pressure = -float(np.trace(stress.mean(axis=0))) / 3.0
    return pressure, 0.5 * float(_slopes(answer["shear"], PROBE)[0, 1]), min(sums), max(sums)


def shear_rows(engine, jobs, found):
    """Rows of the shear modulus C44 of sheared arrays in an engine."""
    for job, answer in zip(jobs, found, strict=True):
        choice = job["options"]["shear"]
        _, seen, low, high = shear_modulus(job, answer)
        what = f"FCC, {job['law']}, {job['unloading']} unloading, shear={choice}: C44"
        if high - low > 1e-6 * high:
            note = "K_t of contacts at rest hangs on the last bit of their overlap"
            yield between(what, low * 0.999, high * 1.001, seen, "duffy-mindlin", unit="Pa", note=note, where=engine)
        else:
            yield near(what, 0.5 * (low + high), seen, 1e-3, "duffy-mindlin", unit="Pa", where=engine)


def _columns(rows):
    return np.array([row[0] for row in rows]), np.array([row[1] for row in rows])


def _slopes(rows, strain):
    """Change of stress with strain over the rows, by least squares."""
    _, stress = _columns(rows)
    x = strain * np.arange(len(rows)) / len(rows)
    return np.polyfit(x, stress.reshape(len(rows), 9), 1)[0].reshape(3, 3)


def _bulk(what, engine, array, job, one, *, overlap, pressure):
    """-V dp/dV from neighbouring rows against √2 K/(3 r) (FCC) or K/(6 r) (SC)."""
    distance = 2.0 * job["radius"] - overlap
    volume = 3.0 * np.log(distance)
    middle = len(overlap) // 2
    found = -(pressure[-1] - pressure[0]) / (volume[-1] - volume[0])
    force = quiet(one.follow, [float(overlap.max()), float(overlap[middle])]).force[-1]
    tangent = _tangent(one, overlap)
    # the array's own change of size: p = c P/D², so that -V dp/dV = (D/3) c (K/D² + 2 P/D³)
    c = COUNT[array] / (3.0 * VOLUME[array])
    wanted = c / 3.0 * (tangent + 2.0 * force / distance[middle]) / distance[middle]
    return near(what, float(wanted), float(found), 1e-4, "duffy-mindlin", unit="Pa", where=engine)


def _tangent(one, overlap):
    """Mean stiffness over the rows, from the law's own forces at their ends."""
    rising = overlap[-1] > overlap[0]
    ends = [float(overlap[0]), float(overlap[-1])]
    force = quiet(one.force, ends) if rising else quiet(one.follow, ends).force
    return (force[1] - force[0]) / (ends[1] - ends[0])


# --- running


def in_yade(jobs):
    """Answers of YADE to the jobs."""
    return under_yade("validation/in_yade.py", jobs)


ENGINES = {"YADE": ("yade", in_yade), "LIGGGHTS": ("liggghts", in_liggghts), "LAMMPS": ("lammps", in_lammps)}


def all_kept_rows(engine, _, found):
    """Rows of LAMMPS's own tests with the law in place of stock hertz."""
    for one, answer in zip(KEPT, found, strict=True):
        yield from kept_rows(one, engine, answer["places"])


def chain_rows(engine, name):
    """Rows of a small wave in a chain of beads in an engine: its speed, and the exponent of the speed over the force."""
    with tempfile.TemporaryDirectory() as folder:
        found = chain.measured(name, folder, (chain.FORCES[0], chain.FORCES[-1]))
    for (first, slow), (last, fast) in zip(found[::2], found[1::2], strict=True):
        label = f"chain of 80 beads, {first.law}"
        wanted = math.log(last.expected / first.expected) / math.log(last.force / first.force)
        exponent = math.log(fast / slow) / math.log(last.force / first.force)
        yield near(f"{label}: speed at {first.force:g} N", first.expected, slow, 0.015, "coste", unit="m/s", where=engine)
        yield near(f"{label}: exponent of the speed over the force", wanted, exponent, 0.01, "coste", where=engine)


def rows():
    """Group, row of every engine; a missing engine gives one row with the reason."""
    for engine, (name, ask) in ENGINES.items():
        why = available(name)
        if why:
            yield engine, missing("impacts and regular arrays", engine, "", "duffy-mindlin", why)
            continue
        asked = [
            ("Oblique impacts", collision_jobs(engine), collision_rows),
            ("LAMMPS's own tests", kept_jobs(), all_kept_rows),
            ("Impacts in the engines", impact_jobs(), impact_rows),
            ("Regular arrays", array_jobs(), array_rows),
        ]
        if name == "yade":
            asked.append(("Regular arrays", shear_jobs(), shear_rows))
        for group, jobs, rows_of in asked:
            yield from ((group, row) for row in rows_of(engine, jobs, ask(jobs)))
        yield from (("Wave in a chain", row) for row in chain_rows(engine, name))
        if name == "lammps":
            yield from (("LAMMPS's own tests", row) for row in lammps_tests.rows())
