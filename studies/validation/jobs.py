"""What is asked of the engines."""

import math

from demlaws.contact import Contact
from demlaws.core.shear import CHOICES
from demlaws.driver import elastic_contact, impact
from demlaws.laws import HERTZ, POHRT_POPOV, ROUGH_PLASTIC
from studies.validation.arrays import RIGID
from studies.validation.oblique import SERIES, STOCK
from studies.validation.published import BRANCHES, IMPACTS, KEPT, SPEEDS, YIELD_RATIO, bound, quiet, yield_speed

SMOOTH = 1e-12
"""Roughness [m] that stands for none: engines take a pair of smooth surfaces for Hertz, whatever the law."""
ARRAYS = ("SC", "FCC")
ARRAY = {"radius": 0.005, "young": 60e9, "poisson": 0.25, "density": 2600.0}
PEAK = 2e-5
"""Largest overlap of the arrays' contacts over their distance."""
STEPS = 400
PROBE = 1e-9
"""Strain of the probes for C11, C12, C44."""
ROUGH = {"roughness": 1.0e-6, "fractal_dimension": 2.22, "hardness": 6.27e9}
LAWS = ((HERTZ, "elastic"), (POHRT_POPOV, "elastic"), (POHRT_POPOV, "hertz"))


def contact_of(job):
    """Contact of two grains of a job."""
    modulus = 0.5 * job["young"] / (1.0 - job["poisson"] ** 2)
    sigma = math.sqrt(2.0) * job["surface"]["roughness"]
    return Contact(0.5 * job["radius"], modulus, sigma, job["surface"].get("fractal_dimension"), job["surface"].get("hardness"))


def _impact(job, contact, mass, steps, rounds):
    """A job with the step, duration and overlap of its impact in Python."""
    one = bound(job["law"], contact, job["unloading"], **job["options"])
    exact = quiet(impact, one, mass, job["speed"], steps)
    about = {"dt": exact.duration / exact.time.size, "steps": exact.time.size, "overlap": exact.peak_overlap}
    return {"kind": "impact", **job, **about, "rounds": rounds}


def impact_jobs():
    """The printed impacts, then the yielding ones."""
    jobs = []
    for one in IMPACTS:
        job = {name: getattr(one, name) for name in ("young", "poisson", "density", "radius", "speed", "plane")}
        job |= {"law": HERTZ, "unloading": "elastic", "options": {}, "surface": {"roughness": 0.0}}
        jobs.append(_impact(job, one.contact, one.mass, 2000, 4))
    job = {"young": 60e9, "poisson": 0.0, "density": 2500.0, "radius": 0.01, "plane": False, "surface": {"roughness": SMOOTH}}
    contact, mass = contact_of(job), 0.5 * 4.0 / 3.0 * math.pi * job["radius"] ** 3 * job["density"]
    pressure = YIELD_RATIO * contact.modulus
    for ratio in SPEEDS:
        own = {"law": ROUGH_PLASTIC, "unloading": "thornton", "options": {"yield_pressure": pressure, "loading": HERTZ}}
        jobs.append(_impact({**job, **own, "speed": ratio * yield_speed(contact, pressure, mass)}, contact, mass, 4000, 8))
    for name, unloading, options, _ in BRANCHES:
        own = {"law": name, "unloading": unloading, "options": options, "speed": 0.1}
        jobs.append(_impact({**job, **own}, contact, mass, 2000, 8))
    return jobs


def kept_jobs():
    """LAMMPS's own tests."""
    jobs = []
    for one in KEPT:
        # the plane's modulus is not without bound
        young = one.modulus * (1.0 + 1.0 / RIGID) if one.plane else 2.0 * one.modulus
        job = {"kind": "impact", "law": HERTZ, "unloading": "elastic", "options": {}, "surface": {"roughness": 0.0}}
        job |= {"young": young, "poisson": 0.0, "density": one.density, "radius": one.radius, "speed": one.speed}
        gap = (one.place - one.radius) * (1.0 if one.plane else 2.0)
        jobs.append(job | {"plane": one.plane, "dt": one.dt, "gap": gap, "after": one.after, "steps": one.after[-1]})
    return jobs


def collision_jobs(engine):
    """The series of collisions that an engine computes, those with `STOCK` shear where its stock model is Chung & Ooi's."""
    jobs = []
    for one in SERIES:
        if one.job["shear"] == STOCK and engine == "YADE":
            continue
        law = bound(HERTZ, Contact(one.job["radius"], contact_of(one.job).modulus))
        mass = 4.0 / 3.0 * math.pi * one.job["radius"] ** 3 * one.job["density"]
        # two spheres touch for 1.5 of the time at most, of one on a rigid plane
        times = [elastic_contact(law, mass, motion[0])[1] for motion in one.motions]
        dt = min(times) / 2000
        jobs.append(one.job | {"motions": one.motions, "dt": dt, "steps": int(max(times) / dt)})
    return jobs


# --- regular arrays


def diagonal(strain):
    """Strain tensor of equal strain along all axes."""
    return [[strain, 0.0, 0.0], [0.0, strain, 0.0], [0.0, 0.0, strain]]


PATH = {
    "loading": diagonal(-PEAK),
    "uniaxial": [[-PROBE, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]],
    "shear": [[0.0, PROBE, 0.0], [PROBE, 0.0, 0.0], [0.0, 0.0, 0.0]],
    "unloading": diagonal(0.25 * PEAK),
}


def array_jobs():
    """Jobs of the regular arrays: each with each law and its unloading."""
    jobs = []
    for array in ARRAYS:
        for name, unloading in LAWS:
            job = {"kind": "lattice", "array": array, **ARRAY, "law": name, "unloading": unloading, "options": {}}
            job["surface"] = ROUGH if name != HERTZ else {"roughness": 0.0}
            # probes of a contact with history would leave its loading curve: for those compression and back alone
            path = PATH if unloading == "elastic" else {k: v for k, v in PATH.items() if k in ("loading", "unloading")}
            jobs.append({**job, "path": path, "steps": STEPS, "dt": 1e-9})
    return jobs


def shear_jobs():
    """FCC of rough grains, compressed and then sheared, for each choice of the normal stiffness that K_t is computed from."""
    jobs = []
    for choice in CHOICES:
        job = {"kind": "lattice", "array": "FCC", **ARRAY, "law": POHRT_POPOV, "unloading": "hertz", "surface": ROUGH}
        path = {name: PATH[name] for name in ("loading", "shear")}
        jobs.append({**job, "options": {"shear": choice}, "path": path, "steps": STEPS, "dt": 1e-9})
    return jobs
