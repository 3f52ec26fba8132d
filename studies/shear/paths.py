"""Random paths of overlap and displacement: no step dissipates less than nothing, no force exceeds Coulomb's limit."""

import itertools
from typing import NamedTuple

import numpy as np

from demlaws.errors import quiet
from demlaws.shear import sheared

RATIO, LOAD = 0.857, 10.0


class Worst(NamedTuple):
    """Over all paths of a law: relative to the largest work, and to Coulomb's limit."""

    returned: float  # largest fall of the dissipated energy in a step, over the largest work of the path
    excess: float  # largest shear force over Coulomb's limit, minus 1


def random_path(random, overlap, sliding):
    """Overlaps and displacements in the plane [m] through up to 9 random corners, closed in displacement."""
    count = random.integers(2, 10)
    corners = np.zeros((count + 1, 3))
    corners[1:-1] = random.uniform([-0.1, -1, -1], 1, (count - 1, 3))
    corners[-1, 0] = corners[-2, 0]  # the last leg brings the displacement back to 0
    if random.random() < 0.3:
        corners[1:, 0] = random.uniform(0.1, 1)  # shear at constant overlap
    scale = np.array([overlap, *[sliding * 10.0 ** random.uniform(-2, 1)] * 2])
    legs = [np.linspace(a, b, 15)[1:] for a, b in itertools.pairwise(corners)]
    path = np.concatenate([corners[:1], *legs]) * scale
    return path[:, 0], path[:, 1:]


def worst(law, shear, paths, seed=1):
    """`Worst` of a law over random paths."""
    random = np.random.default_rng(seed)
    returned = excess = -np.inf
    with quiet():
        overlap = float(law.overlap(LOAD))
        for _ in range(paths):
            friction = 10.0 ** random.uniform(-1, 1)
            depth, plane = random_path(random, overlap, friction * overlap / RATIO)
            result = sheared(law, depth, plane, RATIO, shear, friction, 16)
            size = np.abs(result.work).max()
            if size > 0.0:
                returned = max(returned, float(-np.diff(result.dissipated).min() / size))
            limit = friction * result.force
            touching = limit > 1e-9 * friction * LOAD
            if np.any(touching):
                force = np.hypot(*result.shear_force[touching].T)
                excess = max(excess, float((force / limit[touching]).max() - 1.0))
    return Worst(returned, excess)
