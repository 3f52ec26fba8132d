"""Rows of oblique impacts: measured, computed by finite elements, and computed by another discrete-element code."""

import math

import numpy as np

import demlaws as dl
from studies.shear.oblique import ANGLE, MEASURED, MODELS, misfit, oblique_loop, table
from studies.validation.row import between

PYTHON = "Python"
SLIP, KEPT = "slip", "displacement kept"
CODE = (
    # angle from the normal [degrees], tangential restitution, spin afterwards [rad/s], rebound angle of the contact [degrees]
    *((5, 0.94811, 19.266, 3.7613), (10, 0.68699, 212.997, -1.5559), (15, 0.62438, 377.829, -5.5438)),
    *((20, 0.61614, 510.550, -7.5378), (25, 0.63427, 599.388, -7.5378), (30, 0.68369, 616.514, -3.5498)),
    *((35, 0.73723, 582.263, 3.4290), (40, 0.78089, 544.801, 11.571), (50, 0.84514, 457.034, 29.350)),
    *((60, 0.89292, 357.492, 47.795), (70, 0.93163, 246.177, 64.577), (80, 0.96623, 126.300, 78.701)),
    (85, 0.98270, 63.150, 84.517),
)
"""Chung & Ooi 2011, test 4: alumina sphere of 5 mm on a rigid plane at 3.9 m/s, friction 0.092, as Kratos keeps it."""
ELEMENTS = (
    # V_t/(μ V_n), ω R/(μ V_n) afterwards
    *((0.31792, 0.18657), (0.59538, 0.40563), (0.89017, 0.66529), (1.18497, 0.98177), (1.53179, 1.35506)),
    *((1.89595, 1.79329), (2.27746, 2.32083), (2.76301, 2.85642), (3.30058, 3.44071), (3.89017, 4.04120)),
    *((4.68786, 4.56851), (5.65896, 4.94146), (7.02890, 4.94072), (9.04046, 4.97211), (12.3353, 4.97032)),
)
"""Chung & Ooi 2011, test 5: finite elements of an elastic steel sphere on a rigid plane, friction 0.3, as Kratos keeps them."""


def impact(sphere, density, radius, friction, normal, sideways, model, steps=2000, springs=64):
    """Tangential velocity and surface velocity of the spin [m/s] after an impact on a rigid plane."""
    law = dl.law("hertz", dl.Contact(radius, sphere.plane_modulus))
    mass = density * 4.0 / 3.0 * math.pi * radius**3
    peak, duration = dl.driver.elastic_contact(law, mass, normal)
    ratio = 2.0 * (1.0 - sphere.poisson) / (2.0 - sphere.poisson)
    number, largest = list(MODELS).index(model), 1.01 * float(law.stiffness(peak))
    return oblique_loop(
        law.rule, law.params, mass, normal, sideways, ratio, friction, duration / steps, number, springs, largest
    )


def code_errors(model):
    """Differences from CODE: tangential restitution, spin over the largest spin, rebound angle [degrees]."""
    alumina, radius, restitution = dl.Material(young=380e9, poisson=0.23), 2.5e-3, 0.98
    angle, tangential, spin, rebound = np.array(CODE).T
    normal, sideways = 3.9 * np.cos(np.radians(angle)), 3.9 * np.sin(np.radians(angle))
    velocity, surface = np.transpose(
        [impact(alumina, 4000.0, radius, 0.092, n, s, model) for n, s in zip(normal, sideways, strict=True)]
    )
    angles = np.degrees(np.arctan2(velocity - surface, restitution * normal))
    return velocity / sideways - tangential, (surface / radius - spin) / spin.max(), angles - rebound


def spins(model):
    """ω R/(μ V_n) after the impacts of ELEMENTS."""
    steel = dl.Material(young=208e9, poisson=0.3)
    return [impact(steel, 7850.0, 1e-5, 0.3, 1.0, 0.3 * x, model)[1] / 0.3 for x, _ in ELEMENTS]


def spin_row(where, spins):
    """Row of the spins ω R/(μ V_n) at each of ELEMENTS, with partial slip."""
    largest = max(abs(found - wanted) / 5.0 for found, (_, wanted) in zip(spins, ELEMENTS, strict=True))
    what = "spin of oblique impacts over that of full sliding, largest difference: shear slip"
    return between(what, where, 0.0, 0.02, largest, "wu-thornton")


def rows():
    """Rows: tangential restitution and spin of oblique impacts."""
    measured = table()
    what = (
        f"tangential restitution at {len(ANGLE)} angles, root mean square difference from {MEASURED.min():g}–{MEASURED.max():g}"
    )
    yield between(f"{what}: shear slip", PYTHON, 0.0, 0.02, misfit(measured[SLIP]), "kharaz")
    note = "a limit of contacts without partial slip"
    yield between(f"{what}: shear elastic", PYTHON, 0.04, 0.08, misfit(measured["elastic"]), "kharaz", note=note)
    yield spin_row(PYTHON, spins(SLIP))
    value = max(abs(found - wanted) / 5.0 for found, (_, wanted) in zip(spins("elastic"), ELEMENTS, strict=True))
    what = "spin of oblique impacts over that of full sliding, largest difference: shear elastic"
    yield between(what, PYTHON, 0.06, 0.11, value, "wu-thornton", note=note)
    note = "LIGGGHTS' and LAMMPS' usual shear model"
    limits = (("tangential restitution", "", 0.02), ("spin over the largest", "", 0.02), ("rebound angle", "°", 1.5))
    for (what, unit, limit), found in zip(limits, code_errors(KEPT), strict=True):
        what = f"test 4 at {len(CODE)} angles, {what}: largest difference"
        yield between(what, PYTHON, 0.0, limit, np.abs(found).max(), "kratos", unit, note)
