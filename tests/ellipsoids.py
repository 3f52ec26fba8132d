"""Elastic-plastic ellipsoids one by one, by the compiled functions of the map's patches."""

from typing import NamedTuple

import numpy as np

from demlaws.solvers import ellipsoid


class Ellipsoids(NamedTuple):
    """Arrays, one entry each, SI units."""

    force: np.ndarray
    area: np.ndarray
    state: np.ndarray  # 0 elastic, 1 elastic-plastic, 2 plastic
    first_yield: np.ndarray  # ω1
    full_plasticity: np.ndarray  # ω2
    residual: np.ndarray  # indentation that stays after unloading from here


def ellipsoids(material, radius_x, radius_y, indentation):
    """Principal radii Rx, Ry [m], pressed in by ω [m]; numbers become arrays of length 1."""
    rows = []
    for rx, ry, w in zip(*(np.ravel(v) for v in np.broadcast_arrays(radius_x, radius_y, indentation)), strict=True):
        alpha, beta, gamma, _ = ellipsoid.shape_factors(max(rx, ry) / min(rx, ry))
        mean, geometric = rx * ry / (rx + ry), np.sqrt(rx * ry)
        given = material, alpha * beta, gamma, mean, geometric, float(w), material.yield_factor
        force, area, state, first, full, _, over, _ = ellipsoid.ellipsoid(*given)
        rows.append((force, area, state, first, full, ellipsoid.residual(material, mean, force, area, w, over, gamma, state)))
    return Ellipsoids(*np.array(rows, float).T)
