"""Rows of oblique impacts: measured, computed by finite elements, and computed by another discrete-element code."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

import demlaws as dl
from studies.shear.oblique import ANGLE, MEASURED, misfit, rebound, table
from studies.validation.row import NUMBERS, PYTHON, between

SLIP, KEPT = "slip", "displacement kept"
CODE = NUMBERS["test 4"]
"""Chung & Ooi's test 4: angle [degrees], tangential restitution, spin [rad/s], rebound angle of the contact [degrees]."""
ELEMENTS = NUMBERS["test 5"]
"""Chung & Ooi's test 5, finite elements: V_t/(μ V_n), ω R/(μ V_n) afterwards."""


def impact(sphere, radius, friction, velocity, model):
    """Tangential velocity and surface velocity of the spin [m/s] after an impact on a rigid plane; velocity: down, sideways."""
    law = dl.law("hertz", dl.Contact(radius, sphere.plane_modulus))
    mass, ratio = sphere.density * 4.0 / 3.0 * math.pi * radius**3, 2.0 * (1.0 - sphere.poisson) / (2.0 - sphere.poisson)
    return rebound(law, mass, friction, ratio=ratio, velocity=velocity, model=model)


def code_motions():
    """Speed of approach, velocity sideways and ω R [m/s] of CODE."""
    angle = np.radians([row[0] for row in CODE])
    return np.transpose([3.9 * np.cos(angle), 3.9 * np.sin(angle), 0.0 * angle]).tolist()


def code_rows(where, found):
    """Rows of CODE: tangential restitution, spin over the largest spin, rebound angle [degrees]."""
    _, tangential, spin, rebound = np.array(CODE).T
    normal, sideways, _ = np.transpose(code_motions())
    velocity, _, surface = np.transpose(found)
    errors = (
        velocity / sideways - tangential,
        (surface / 2.5e-3 - spin) / spin.max(),
        np.degrees(np.arctan2(velocity - surface, 0.98 * normal)) - rebound,
    )
    limits = (("tangential restitution", "", 0.02), ("spin over the largest", "", 0.02), ("rebound angle", "°", 1.5))
    for (what, unit, limit), error in zip(limits, errors, strict=True):
        what = f"test 4 at {len(CODE)} angles, {what}: largest difference"
        yield between(
            what,
            0.0,
            limit,
            np.abs(error).max(),
            "kratos",
            unit=unit,
            note="the usual shear model, displacement kept",
            where=where,
        )


def spins(model):
    """ω R/(μ V_n) after the impacts of ELEMENTS."""
    steel = dl.Material(young=208e9, poisson=0.3, density=7850.0)
    return [impact(steel, 1e-5, 0.3, (1.0, 0.3 * x), model)[1] / 0.3 for x, _ in ELEMENTS]


def spin_row(where, spins):
    """Row of the spins ω R/(μ V_n) at each of ELEMENTS, with partial slip."""
    largest = max(abs(found - wanted) / 5.0 for found, (_, wanted) in zip(spins, ELEMENTS, strict=True))
    what = "test 5: spin over that of full sliding, largest difference: shear slip"
    return between(what, 0.0, 0.03, largest, "wu-thornton", where=where)


# --- series of collisions in the engines


STOCK = "stock"
"""In place of a shear model of ours: the engine's own that keeps the displacement (LIGGGHTS `history`, LAMMPS `mindlin`)."""


class Series(NamedTuple):
    """Collisions that engines compute in one run."""

    job: dict
    motions: list  # speed of approach, velocity sideways, ω R [m/s]
    rows: Callable  # (engine, velocities sideways and away and ω R of each afterwards) → rows


def _job(solid, radius, friction, restitution, shear, **more):
    young, poisson, density = solid
    job = {"kind": "collisions", "law": "hertz", "unloading": "elastic", "options": {}, "surface": {"roughness": 0.0}}
    job |= {"young": young, "poisson": poisson, "density": density, "radius": radius, "friction": friction}
    return job | {"restitution": restitution, "shear": shear, "other": 0.0} | more


def _spinning(name, *solid, **more):
    x, wanted = np.array(NUMBERS[name]).T
    spin = 3.5 * 0.4 * 1.5 * 0.2 / x

    def rows(where, found):
        velocity, _, surface = np.transpose(found)
        value = np.abs((surface - velocity) / -spin - wanted).max()
        what = f"{name}: tangential surface velocity after over before, largest difference"
        note = "codes differ in whether friction limits the dashpot of the shear force"
        yield between(what, 0.0, 0.2, value, "kratos-spin", note=note, where=where)

    job = _job(solid, 0.1, 0.4, 0.5, STOCK, **more)
    return Series(job, [[0.2, 0.0, s] for s in spin.tolist()], rows)


def _restitution(wanted):
    def rows(where, found):
        what = f"test 3: restitution of a damped sphere on a plane, set to {wanted}"
        yield between(what, wanted - 0.005, wanted + 0.005, found[0][1] / 3.9, "chung-ooi", where=where)

    return Series(_job((380e9, 0.23, 4000.0), 2.5e-3, 0.0, wanted, "elastic"), [[3.9, 0.0, 0.0]], rows)


def _like_spheres():
    spin = [0.2 * math.tan(math.radians(angle)) for angle in (5.0, 45.0, 85.0)]

    def rows(where, found):
        velocity, _, surface = np.transpose(found)
        value = np.max(np.maximum(np.abs(velocity), np.abs(surface - spin)) / spin)
        yield between("test 7: change of the spin of like spheres that roll", 0.0, 1e-9, value, "kratos-spin", where=where)

    job = _job((70e9, 0.33, 2700.0), 0.1, 0.4, 0.5, "elastic", other=0.1, other_density=2700.0, other_spin=-1.0)
    return Series(job, [[0.4, 0.0, s] for s in spin], rows)


def _rebound():
    x, wanted = np.array(NUMBERS["rebound"]).T

    def rows(where, found):
        value = np.abs(np.transpose(found)[2] / (0.095 * 5.0) - wanted).max() / 5.0
        what = f"oblique rebound at {len(x)} angles, e = 0.9, spin over that of full sliding, largest difference: shear elastic"
        yield between(what, 0.0, 0.03, value, "thornton-2013", where=where)

    return Series(
        _job((70e9, 0.25, 2650.0), 0.025, 0.1, 0.9, "elastic"), [[5.0, 5.0 * 0.095 * v, 0.0] for v in x.tolist()], rows
    )


SERIES = (
    *map(_restitution, (0.2, 0.4, 0.6, 0.8, 1.0)),
    Series(_job((380e9, 0.23, 4000.0), 2.5e-3, 0.092, 0.98, STOCK), code_motions(), code_rows),
    Series(
        _job((208e9, 0.3, 7850.0), 0.01, 0.3, 1.0, "slip"),
        [[0.1, 0.03 * x, 0.0] for x, _ in ELEMENTS],
        lambda where, found: [spin_row(where, np.transpose(found)[2] / 0.03)],
    ),
    _spinning("test 6, aluminium", 70e9, 0.33, 2700.0),
    _spinning("test 6, nylon", 2.5e9, 0.4, 1140.0),
    _like_spheres(),
    _spinning("test 8, aluminium", 70e9, 0.33, 2700.0, other=0.5, other_density=2.7e6, other_spin=0.0),
    _rebound(),
)


def collision_rows(where, jobs, found):
    """Rows of the series that an engine has computed."""
    series = iter(SERIES)
    for job, answer in zip(jobs, found, strict=True):
        one = next(one for one in series if one.job.items() <= job.items())
        yield from one.rows(where, answer)


# --- Python


def rows():
    """Rows: tangential restitution and spin of oblique impacts."""
    measured = table()
    what = (
        f"tangential restitution at {len(ANGLE)} angles, root mean square difference from {MEASURED.min():g}–{MEASURED.max():g}"
    )
    yield between(f"{what}: shear slip", 0.0, 0.02, misfit(measured[SLIP]), "kharaz")
    note = "a limit of contacts without partial slip"
    yield between(f"{what}: shear elastic", 0.02, 0.03, misfit(measured["elastic"]), "kharaz", note=note)
    yield spin_row(PYTHON, spins(SLIP))
    value = max(abs(found - wanted) / 5.0 for found, (_, wanted) in zip(spins("elastic"), ELEMENTS, strict=True))
    what = "test 5: spin over that of full sliding, largest difference: shear elastic"
    yield between(what, 0.05, 0.09, value, "wu-thornton", note=note)
    alumina = dl.Material(young=380e9, poisson=0.23, density=4000.0)
    motions = [impact(alumina, 2.5e-3, 0.092, motion[:2], KEPT) for motion in code_motions()]
    yield from code_rows(PYTHON, [(velocity, math.nan, surface) for velocity, surface in motions])


# --- imposed motions


MOTION = (2652.97724125704, 179924.037666691, 85830.6275631949, 39861.7165520913, 198964.984055012, 19927.8963456105)
"""Shear force [N] of motion 01 after 1, 25, 50, 75, 100 and 125 of 200 steps."""


def pairwise_motions():
    """Rows: shear force of linear contacts (k_n = 1e7, k_t = 5e6 N/m, μ = 0.5) along the motions of ON-DEM.

    Motion 01 is one step ahead with its displacement, and increments in 03 and 04 are chords. The pairs of 03, 04, 15, 18 and
    20 turn, which changes only the direction of the force. `sources.csv` states commits, by which the motions' numbers differ,
    and why the other motions are missing here.
    """
    law = dl.law("walton-braun", dl.Contact(1.0, 1e9), loading_stiffness=1e7, stiffness_ratio=1.0)
    step = 6.0 * math.pi / 200
    one = np.append(0.0, np.cumsum(0.02 * np.sin(step * np.arange(1, 202)) * step))
    time = 6e-4 * math.pi * np.arange(10001)

    def path(speed, damping=0.0, phase=0.0, rate=1.0):
        """Integral of speed sin(rate t + phase) exp(damping t)."""
        wave = damping * np.sin(rate * time + phase) - rate * np.cos(rate * time + phase)
        wave = speed * wave * np.exp(damping * time) / (rate * rate + damping * damping)
        return wave - wave[0]

    fifth = path(0.03, rate=4.0 / 3.0)
    swing = 0.04 + path(0.03, phase=math.pi / 2, rate=4.0 / 3.0)
    motions = (
        ("01, stick", 0.05, one, dict(zip([2, 26, 51, 76, 101, 126], MOTION, strict=True))),
        ("02, sliding to and fro", 0.04, path(0.08), {10000: -2e5}),
        (
            "03 and 04, turning out of and in the plane of contact",
            0.04,
            0.02 * time * np.sinc(3e-4),
            {413: 77848.65443092302, 10000: 2e5},
        ),
        ("05, sliding under a changing force", swing, fifth, {10000: -71598.90014743463}),
        (
            "15, turning, sliding under a changing force",
            0.03 + path(0.01, -0.1),
            path(0.5, -0.1),
            {2253: -216932.5341843676, 5643: -207105.05487079528, 10000: -191988.3266346223},
        ),
        ("18, turning, spheres of 4 and 0.5 m", 0.09, path(0.045, phase=math.pi / 2), {1942: -111600.97827159689}),
        ("20, turning about two axes", 0.05, 0.01 * time, {10000: 2.5e5}),
    )
    for name, overlap, displacement, stored in motions:
        overlap = np.broadcast_to(overlap, displacement.shape)
        force = dl.driver.sheared(law, overlap, displacement, 0.5, "elastic", friction=0.5).shear_force
        difference = max(abs(force[place] - value) for place, value in stored.items())
        what = f"motion {name}: shear force, largest of {len(stored)} differences over the largest force"
        yield between(what, 0.0, 1e-11, difference / max(map(abs, stored.values())), "on-dem")
