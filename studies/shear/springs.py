"""Errors of partial slip with few springs: against Mindlin & Deresiewicz (1953), and 3,000 springs on an oblique path."""

import numpy as np

import demlaws as dl
from demlaws.errors import quiet
from demlaws.make import example
from demlaws.shear import sheared
from studies.shear.gas import CONTACT

RATIO, FRICTION, LOAD = 2 * (1 - 0.25) / (2 - 0.25), 0.5, 10.0
SHARES = (0.3, 0.6, 0.99)
"""Of Coulomb's limit, between which a loop goes at constant normal force."""
LAWS = (("hertz", "elastic"), ("pohrt-popov", "elastic"), ("pohrt-popov", "hertz"))


def mindlin(springs):
    """(largest error of the force over μP, error of the loss of a whole cycle at each of SHARES) for Hertz."""
    law = dl.law("hertz", CONTACT)
    overlap = law.overlap(LOAD)
    limit, onset = FRICTION * LOAD, RATIO * law.stiffness(overlap)
    sliding = FRICTION * overlap / RATIO
    along = np.linspace(0.0, 1.2 * sliding, 1500)
    force = sheared(law, np.full(along.size, overlap), along, RATIO, "slip", FRICTION, springs).shear_force
    exact = limit * (1.0 - np.maximum(1.0 - 2.0 * onset * along / (3.0 * limit), 0.0) ** 1.5)
    losses = []
    for share in SHARES:
        left = 1.0 - share
        way = sliding * (1.0 - left ** (2 / 3))
        corners = np.concatenate([np.linspace(0, way, 1500), np.linspace(way, -way, 1500), np.linspace(-way, way, 1500)])
        path = sheared(law, np.full(corners.size, overlap), corners, RATIO, "slip", FRICTION, springs)
        # Johnson 1985, Eq. 7.57
        loss = 7.2 * limit**2 / onset * (1.0 - left ** (5 / 3) - 5.0 * share / 6.0 * (1.0 + left ** (2 / 3)))
        losses.append(float((path.work[-1] - path.work[1499]) / loss - 1.0))
    return float(np.abs(force - exact).max() / limit), losses


def oblique(name, rule, springs):
    """Largest error of the force over the largest μP, with slip in the plane and a normal force that rises and falls."""
    law = example(name, CONTACT, rule)
    turn = np.linspace(0.0, 6.0, 500)
    with quiet():
        overlap = law.overlap(LOAD)
        depth = overlap * (0.2 + 0.13 * turn) * (1.0 - 0.3 * np.sin(3.0 * turn) ** 2)
        plane = 0.7 * FRICTION * overlap / RATIO * np.stack([np.sin(2.0 * turn), np.cos(3.0 * turn) - 1.0], -1)
        few, many = (sheared(law, depth, plane, RATIO, "slip", FRICTION, n) for n in (springs, 3000))
    return float(np.abs(few.shear_force - many.shear_force).max() / (FRICTION * many.force.max()))
