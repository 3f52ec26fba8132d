"""Deflection of an elastic half-space under an axisymmetric pressure, a polynomial on each of a few ring-shaped panels."""

import math
from functools import lru_cache

import numpy as np

ORDER = 10  # Gauss-Legendre nodes per panel


@lru_cache
def reference_rules(order):
    """Rules on [0, 1] for one panel: nodes and weights, and per target the singular and near-singular rules, each with
    the values of the panel's Lagrange polynomials at its points."""
    x, weights = np.polynomial.legendre.leggauss(order)
    x, weights = 0.5 * (x + 1), 0.5 * weights
    v, dv = np.polynomial.legendre.leggauss(3 * order)
    v, dv = 0.5 * (v + 1), 0.5 * dv
    # t = v^5 turns the logarithm at v = 0 into v^4 log v, which Gauss-Legendre integrates to 1e-12
    t, dt = v**5, 5 * v**4 * dv
    barycentric = 1 / np.prod(x[:, None] - x + np.eye(order), axis=1)

    def lagrange(points):
        difference = points[..., None] - x
        ratio = barycentric / difference
        return ratio / ratio.sum(axis=-1, keepdims=True)

    own = np.concatenate([x[:, None] * (1 - t), x[:, None] + (1 - x[:, None]) * t], axis=1)
    own_weights = np.concatenate([x[:, None] * dt, (1 - x[:, None]) * dt], axis=1)
    own_distance = np.concatenate([-x[:, None] * t, (1 - x[:, None]) * t], axis=1)
    at_left, at_right = lagrange(np.array([0.0]))[0], lagrange(np.array([1.0]))[0]
    return {
        "x": x,
        "weights": weights,
        "own_distance": own_distance,
        "own": own_weights[..., None] * lagrange(own),
        "t": t,
        "from_left": dt[:, None] * lagrange(t),
        "from_right": dt[:, None] * lagrange(1 - t),
        "at_left": at_left,
        "at_right": at_right,
    }


def _kernel(r, t, difference):
    """(2/pi) t/(t + r) K(k) = (2/pi) (t / hi) K(lo / hi), difference = t - r (Landen)."""
    from scipy.special import ellipkm1

    hi = np.maximum(r, t)
    return (2 / math.pi) * (t / hi) * ellipkm1(np.abs(difference) * (r + t) / (hi * hi))


def influence_matrix(edges, order=ORDER):
    """Nodes r, weights dr and the matrix W of w(r_i) = sum_j W_ij q(r_j) for panels between edges (edges[0] = 0).

    The pressure is a polynomial of degree order - 1 on each panel; its product with the complete elliptic kernel is
    integrated with the logarithmic singularity resolved on the target's own panel and on both neighbours.
    """
    ref = reference_rules(order)
    edges = np.asarray(edges, float)
    left, width = edges[:-1], np.diff(edges)
    panels = width.size
    nodes = left[:, None] + width[:, None] * ref["x"]
    weights = width[:, None] * ref["weights"]
    r = nodes.ravel()
    same = np.eye(panels * order, dtype=bool)
    difference = r - r[:, None] + same  # the diagonal is overwritten below
    matrix = _kernel(r[:, None], r, difference) * weights.ravel()
    blocks = matrix.reshape(panels, order, panels, order)
    distance = width[:, None, None] * ref["own_distance"]
    target = nodes[:, :, None]
    own = np.einsum("ijq,jqk->ijk", _kernel(target, target + distance, distance), ref["own"])
    i = np.arange(panels)
    blocks[i, :, i, :] = own * width[:, None, None]
    t = width[:, None] * ref["t"]
    # source panels 1.. seen from targets in the panel to their left, then 0.. from their right
    point = (left[1:, None] + t[1:])[:, None, :]
    target = nodes[:-1, :, None]
    blocks[i[:-1], :, i[1:], :] = (
        np.einsum("ijq,qk->ijk", _kernel(target, point, point - target), ref["from_left"]) * width[1:, None, None]
    )
    point = (edges[1:-1, None] - t[:-1])[:, None, :]
    target = nodes[1:, :, None]
    blocks[i[1:], :, i[:-1], :] = (
        np.einsum("ijq,qk->ijk", _kernel(target, point, point - target), ref["from_right"]) * width[:-1, None, None]
    )
    return r, weights.ravel(), matrix


def nodes_of(edges):
    """Gauss-Legendre nodes of all panels."""
    return (edges[:-1, None] + np.diff(edges)[:, None] * reference_rules(ORDER)["x"]).ravel()


def _graded(length, smallest, panels):
    """Widths in geometric progression, the first equal to smallest, that add up to length."""
    from scipy.optimize import brentq

    steps, ratio = np.arange(panels), max(length / smallest, float(panels))
    widths = brentq(lambda growth: np.sum(growth**steps) - ratio, 1.0, 50.0) ** steps
    return widths * (length / widths.sum())


def panel_edges(levels, inner, outer):
    """Equal panels from the flank of the pressure to its end (levels: their ln r), growing ones back to the axis."""
    flank, end = np.exp(levels)
    h = (end - flank) / outer
    widths = np.concatenate([_graded(flank, h, inner)[::-1], np.full(outer, h)])
    return np.concatenate([[0.0], np.cumsum(widths)])
