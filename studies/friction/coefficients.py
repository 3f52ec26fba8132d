"""Frictions of the runs: by pressure with two sets of coefficients, and constant ones."""

from typing import NamedTuple

import numpy as np

import demlaws as dl

YOUNG, POISSON = 60.6e9, 0.25
"""Of granite."""
PLANE = YOUNG / (1 - POISSON**2)
YADE = 1e7 / (1 - 0.3**2)
"""E/(1 - ν²) of the grains in the example of YADE's Conical Damage Model [Pa]."""
SETS = {
    "assumed": dl.PressureFriction(mu0=0.3, c1=0.6, c2=4e-9),
    "example": dl.PressureFriction(mu0=0.25, c1=1.3, c2=1.26e-5 * (YADE / PLANE) ** (2 / 3)),
}
"""assumed: not measured. example: of the script of a periodic simple shear test that came with YADE's Conical Damage Model
(merge request 705, by the authors of the model), whose grains have 10 MPa. At equal stress Hertz's pressures grow as E*^(2/3):
c2 falls as much."""


class Constant(NamedTuple):
    """A constant coefficient, of the contact pressure [Pa] from which it was computed (NaN: of none)."""

    mu: float
    pressure: float = np.nan


def softer(friction, times):
    """The same coefficients at equal forces for a modulus so many times smaller."""
    return dl.PressureFriction(friction.mu0, friction.c1, friction.c2 * times ** (2 / 3))


def words(friction):
    """(words of the contact model, friction coefficient of the tangential model) in LAMMPS."""
    if isinstance(friction, Constant):
        return "", friction.mu
    return f" friction_pressure {friction.c1:.9g} {friction.c2:.9g}", friction.mu0


def mean_pressure(forces, radius, modulus):
    """Mean pressure [Pa] of contacts by Hertz's law, each weighted with its force [N]; modulus: E* [Pa]."""
    law = dl.law("hertz", dl.Contact(radius, modulus))
    return float(np.sum(forces * forces / (np.pi * radius * law.overlap(forces))) / np.sum(forces))


def at_mean(friction, forces, radius, modulus):
    """The `Constant` of a friction by pressure at the mean pressure of contacts."""
    pressure = mean_pressure(forces, radius, modulus)
    return Constant(float(friction.coefficient(pressure)), pressure)


FORCES = "compute force all pair/local force\ndump forces all local 1 post/forces.txt c_force\nrun 0 post no\nundump forces\n"


def read_forces(path):
    """Sizes of the forces [N] of contacts between grains in a dump of FORCES."""
    forces = np.abs(np.loadtxt(path, skiprows=9))
    return forces[forces > 1e-9]
