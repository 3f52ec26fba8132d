"""Oblique impacts of a sphere on a plate, compared with those that Kharaz, Gorham & Salman (2001) measured.

Kharaz, Gorham & Salman, Powder Technology 120 (2001) 281: aluminium oxide spheres of 5 mm on thick soda-lime glass at 3.9 m/s.
Properties as in Chung & Ooi (2011), test 5. The normal contact is elastic Hertz; the measured normal restitution is 0.98.
"""

import math
from typing import NamedTuple

import numpy as np

import demlaws as dl
from demlaws.core.dispatch import step
from demlaws.core.levels import move
from demlaws.core.numba_compat import loop
from demlaws.core.shear import DEFAULT_LEVELS
from demlaws.core.slip import compressions, set_springs, slip

ANGLE = np.array([1.84, 3.7, 9.5, 20.0, 30.1, 39.4, 49.7, 60.0])
"""Angles of impact from the normal [degrees]."""
MEASURED = np.array([0.793, 0.745, 0.673, 0.597, 0.688, 0.771, 0.848, 0.901])
"""Tangential velocity of the centre after the impact over before it, as measured."""
RADIUS, DENSITY, SPEED, FRICTION = 2.5e-3, 4000.0, 3.9, 0.092
SPHERE, PLATE = dl.Material(young=380e9, poisson=0.23), dl.Material(young=70e9, poisson=0.25)
MODELS = {
    "displacement kept": "LIGGGHTS history, LAMMPS mindlin: Q = K_t s",
    "force kept": "YADE's Hertz-Mindlin: dQ = K_t ds, Q kept while K_t falls",
    "one level": "demlaws with levels=1: dQ = K_t ds, Q falls with K_t",
    "elastic": "demlaws: the same with three levels",
    "slip": "demlaws: partial slip",
}


class Impact(NamedTuple):
    """What an impact leaves."""

    tangential: float  # velocity of the centre after over before
    spin: float  # surface velocity of the spin after, ω R, over the tangential velocity before
    energy: float  # tangential and rotational energy after over before


@loop
def oblique_loop(rule, shape, p, mass, normal, sideways, ratio, friction, dt, model, levels, springs):
    """Velocity Verlet from touch to separation: tangential velocity of the centre and ω R afterwards [m/s].

    model: 0 displacement kept, 1 force kept, 2 levels, 3 springs.
    """
    overlap, approach, velocity, spin = 0.0, normal, sideways, 0.0
    force, shear, stretch = 0.0, 0.0, 0.0
    bound, stretches = np.zeros(levels), np.zeros((levels, 3))
    row = np.zeros((6, springs))
    for _ in range(10_000_000):
        approach -= 0.5 * dt * force / mass
        velocity -= 0.5 * dt * shear / mass
        spin += 0.5 * dt * shear / (0.4 * mass)
        overlap += dt * approach
        moved = dt * (velocity - spin)
        if overlap <= 0.0:
            break
        force, stiffness, _ = step(rule, shape, p, overlap, ())
        if model == 3:
            set_springs(False, stiffness, force, overlap, row[0], row[1], row[2:4])
            compressions(False, overlap, row[0], row[1], row[4], row[5])
            shear = slip(friction * force, ratio, moved, 0.0, row[0], row[2:4], row[4], row[5])[0]
        elif model == 2:
            shear = move(bound, stretches, ratio * stiffness, (moved, 0.0, 0.0), friction * force)[0][0]
        else:
            stretch += moved
            shear = ratio * stiffness * stretch if model == 0 else shear + ratio * stiffness * moved
            if abs(shear) > friction * force:
                shear = math.copysign(friction * force, shear)
                stretch = shear / (ratio * stiffness)
        approach -= 0.5 * dt * force / mass
        velocity -= 0.5 * dt * shear / mass
        spin += 0.5 * dt * shear / (0.4 * mass)
    return velocity, spin


def rebound(law, mass, friction, *, ratio, velocity, model, steps=2000, springs=64):
    """(tangential velocity, ω R) [m/s] after an impact with one of MODELS, or with a number of levels.

    ratio: K_t/K; velocity: normal and tangential [m/s].
    """
    _, duration = dl.driver.elastic_contact(law, mass, velocity[0])
    levels = {"one level": 1, "elastic": DEFAULT_LEVELS}.get(model, model)
    number = 2 if isinstance(levels, int) else {"displacement kept": 0, "force kept": 1, "slip": 3}[model]
    return oblique_loop(
        law.rule_tag,
        law.shape,
        law.params,
        mass,
        *velocity,
        ratio,
        friction,
        duration / steps,
        number,
        levels if number == 2 else 1,
        springs,
    )


def impact(angle, model, friction=FRICTION, steps=4000, springs=64):
    """`Impact` at an angle from the normal [degrees] with one of MODELS."""
    pair = dl.Contact.between(SPHERE, PLATE, radius1=RADIUS, radius2=math.inf)
    mass = DENSITY * 4.0 / 3.0 * math.pi * RADIUS**3
    normal, sideways = SPEED * math.cos(math.radians(angle)), SPEED * math.sin(math.radians(angle))
    # 1/G* = (2 - ν1)/G1 + (2 - ν2)/G2, K_t/K = 4 G*/E*
    compliance = sum((2.0 - m.poisson) * 2.0 * (1.0 + m.poisson) / m.young for m in (SPHERE, PLATE))
    ratio = 4.0 / (compliance * pair.modulus)
    law, before = dl.law("hertz", pair), (normal, sideways)
    velocity, spin = rebound(law, mass, friction, ratio=ratio, velocity=before, model=model, steps=steps, springs=springs)
    return Impact(velocity / sideways, spin / sideways, (velocity**2 + 0.4 * spin**2) / sideways**2)


def table():
    """Model → tangential restitution at each of ANGLE."""
    return {model: np.array([impact(angle, model).tangential for angle in ANGLE]) for model in MODELS}


def misfit(values):
    """Root mean square of the difference from MEASURED."""
    return float(np.sqrt(np.mean((values - MEASURED) ** 2)))
