"""Errors of partial slip with few springs: against Mindlin & Deresiewicz (1953), and against 3,000 springs."""

import itertools

import numpy as np

import demlaws as dl
from demlaws.errors import quiet
from demlaws.make import example_law
from demlaws.shear import sheared
from studies.shear.gas import CONTACT

RATIO, FRICTION, LOAD = 2 * (1 - 0.25) / (2 - 0.25), 0.5, 10.0
SHARES = (0.05, 0.1, 0.3, 0.6, 0.99)
"""Of Coulomb's limit, between which a loop goes at constant normal force."""
LAWS = (
    ("hertz", "elastic"),
    ("pohrt-popov", "elastic"),
    ("pohrt-popov", "hertz"),
    ("rms", "elastic"),
    ("yip-venart", "elastic"),
)


def mindlin(springs):
    """(largest error of the force over μP, error of the loss of a whole cycle at each of SHARES) for Hertz."""
    law = dl.law("hertz", CONTACT)
    overlap = law.overlap(LOAD)
    limit, onset = FRICTION * LOAD, RATIO * law.stiffness(overlap)
    sliding = FRICTION * overlap / RATIO
    along = np.linspace(0.0, 1.2 * sliding, 1500)
    force = sheared(law, np.full(along.size, overlap), along, RATIO, "slip", friction=FRICTION, springs=springs).shear_force
    exact = limit * (1.0 - np.maximum(1.0 - 2.0 * onset * along / (3.0 * limit), 0.0) ** 1.5)
    losses = []
    for share in SHARES:
        left = 1.0 - share
        way = sliding * (1.0 - left ** (2 / 3))
        corners = np.concatenate([np.linspace(0, way, 1500), np.linspace(way, -way, 1500), np.linspace(-way, way, 1500)])
        path = sheared(law, np.full(corners.size, overlap), corners, RATIO, "slip", friction=FRICTION, springs=springs)
        # Johnson 1985, Eq. 7.57
        loss = 7.2 * limit**2 / onset * (1.0 - left ** (5 / 3) - 5.0 * share / 6.0 * (1.0 + left ** (2 / 3)))
        losses.append(float((path.work[-1] - path.work[1499]) / loss - 1.0))
    return float(np.abs(force - exact).max() / limit), losses


def legs(corners, steps):
    """Points on straight lines between corners."""
    parts = [np.linspace(a, b, steps + 1)[1:] for a, b in itertools.pairwise(np.array(corners, float))]
    return np.concatenate([corners[:1], *parts])


def paths():
    """Kind → paths of (overlap over the largest, two displacements over that at which the whole contact slides)."""
    start = [(0.02, 0.0, 0.0), (1.0, 0.0, 0.0)]
    loops = [(1.0, sense * size, 0.0) for size in (0.25, 0.5, 0.9) for sense in (1.0, -1.0, 1.0)]
    walks, oblique = [], []
    for seed in range(3):
        random = np.random.default_rng(seed)
        walks.append(legs(start + [(1.0, *random.uniform(-1.12, 1.12, 2)) for _ in range(30)], 40))
        corners = [(random.uniform(0.2, 1.0), *random.uniform(-0.8, 0.8, 2)) for _ in range(30)]
        oblique.append(legs([(0.02, 0.0, 0.0), *corners], 40))
    first = legs([*start, (1.0, 1.2, 0.0)], 300)
    return {"first loading": [first], "loops": [legs(start + loops, 200)], "walk in the plane": walks, "oblique walk": oblique}


def errors(name, rule, counts):
    """Kind of path → largest error of the force over the largest μP of the path, for each number of springs."""
    with quiet():
        law = example_law(name, CONTACT, rule)
        depth = law.overlap(LOAD)
    unit = depth * np.array([1.0, FRICTION / RATIO, FRICTION / RATIO])

    def follow(path, springs):
        with quiet():
            return sheared(law, unit[0] * path[:, 0], unit[1:] * path[:, 1:], RATIO, "slip", friction=FRICTION, springs=springs)

    largest = {}
    for kind, group in paths().items():
        exact = [follow(path, 3000) for path in group]
        largest[kind] = [
            max(
                np.hypot(*(follow(path, count).shear_force - right.shear_force).T).max() / (FRICTION * right.force.max())
                for path, right in zip(group, exact, strict=True)
            )
            for count in counts
        ]
    return largest
