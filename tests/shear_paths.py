"""Closed paths of normal force [N] and tangential displacement [m] of one contact, for tests of K_t."""

import itertools

import numpy as np

GRANITE_RATIO = 2 * (1 - 0.25) / (2 - 0.25)
_SHEAR = 1e-9


def _through(corners, steps):
    legs = [np.linspace(a, b, steps + 1)[1:] for a, b in itertools.pairwise(corners)]
    forces, displacements = np.concatenate([np.array([corners[0]]), *legs]).T
    return forces, displacements


def _wild(seed, corners=12):
    random = np.random.default_rng(seed)
    points = [(0.05, 0.0)]
    for _ in range(corners):
        points.append((float(np.exp(random.uniform(np.log(0.05), np.log(30.0)))), random.uniform(-_SHEAR, _SHEAR)))
    return _through([*points, (points[-1][0], 0.0)], 15)


PATHS = {
    "sheared at a high load, back at a low one": _through([(0.05, 0), (5, 0), (5, _SHEAR), (1, _SHEAR), (1, 0), (5, 0)], 20),
    "sheared at a low load, back at a high one": _through([(0.05, 0), (5, 0), (1, 0), (1, _SHEAR), (5, _SHEAR), (5, 0)], 20),
    "sheared just below the largest load, back just above": _through(
        [(0.05, 0), (5, 0), (4.999, 0), (4.999, _SHEAR), (5.001, _SHEAR), (5.001, 0)], 20
    ),
    "wild": _wild(1),
}
"""Name → forces, displacements."""


def overlaps_at(law, forces):
    """Overlaps [m] at which one contact carries the forces one after the other."""
    state, top, overlaps = law.new_state(1), 0.0, []
    for force in forces:
        overlap = law.overlap(float(force)) if force >= top else law.unloading_overlap(float(force), state)
        law.follow([overlap], state)
        top = max(top, force)
        overlaps.append(overlap)
    return np.array(overlaps)
