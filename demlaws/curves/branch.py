"""A fitted unloading curve that is softer than first loading, within the noise of its points or beyond them: made stiffer."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from demlaws.core.loops import force_loop, inverse_loop, params_at
from demlaws.curves.table import TableCurve
from demlaws.curves.table_file import definition_of_table
from demlaws.curves.tabulate import tabulate_given
from demlaws.errors import NotPassive, warn

_RTOL = 1e-5
"""Tolerance of the table of the curve."""
_MARGIN = 5.0 * _RTOL
"""Part by which the curve is stiffer than first loading: both tables, and the one in the other's scales, err by `_RTOL`."""
_CELLS = 4000
_LOWEST, _HIGHEST = 2.0**-32, 0.1
"""Overlaps of first loading over R between whose loads the curve is computed."""
_ASIDE = 1e-11
"""Distance of the nodes beside a kink, over its load: within that of the one-sided stiffness of a table."""


class Measured(NamedTuple):
    """The points that a law was fitted to."""

    low: float  # smallest load [N]
    high: float  # largest load [N]
    noise: float  # standard deviation of the displacement [m]; 0 where the misfit is not noise


class StiffenedCurve:
    """The curve of a flexibility dδ/dP [m/N], a function of the loads [N], between the ends of `loads`, which are its nodes.

    At a load between two nodes, ln P is a cubic of ln δ; beyond the ends the curve is a power law. kinks: loads of the nodes
    beside which the flexibility may jump; largest: load [N] at which the table ends.
    """

    def __init__(self, loads: np.ndarray, flexibility: Callable, kinks: np.ndarray, largest: float):
        from scipy.interpolate import CubicHermiteSpline

        loads = np.sort(np.concatenate([loads, kinks * (1.0 - _ASIDE), kinks * (1.0 + _ASIDE)]))
        x = np.log(loads)
        middle = np.exp(0.5 * (x[1:] + x[:-1]))
        ends, between = loads * flexibility(loads), middle * flexibility(middle)  # dδ/d ln P
        cells = np.diff(x) / 6.0 * (ends[1:] + 4.0 * between + ends[:-1])
        start = ends[0] * (x[1] - x[0]) / np.log(ends[1] / ends[0])  # a power law below
        self.loads, self.overlaps = loads, start + np.append(0.0, np.cumsum(cells))
        self._force = CubicHermiteSpline(np.log(self.overlaps), x, self.overlaps / ends)
        self._exponent = self._force.derivative()
        self.kinks = [float(np.interp(np.log(kink), x, self.overlaps)) for kink in kinks]
        self.largest = float(np.interp(np.log(largest), x, self.overlaps))

    def evaluate(self, overlap: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Force [N] and stiffness [N/m] at overlaps [m] > 0."""
        x = np.log(overlap)
        inside = np.clip(x, self._force.x[0], self._force.x[-1])
        exponent = self._exponent(inside)
        force = np.exp(self._force(inside) + exponent * (x - inside))
        return force, exponent * force / overlap


def stiffened(loading: Any, branch: Any, refusal: NotPassive) -> TableCurve:
    """The table of a fitted elastic law `branch`, nowhere softer than the elastic law `loading`. [our derivation]

    A contact returns no more work than it took where the flexibility of unloading at each load is at most that of first
    loading: the curve has the lower of both. Its zero is free, as in the fit: between the smallest and the largest load of the
    points the overlap changes by half the difference of the two curves there, at most. `refusal` is raised again, with this
    change, where it exceeds the noise of the points.
    """
    points = branch.measured
    below, above = _along(loading), _along(branch)
    radius = float(loading.contact.radius)
    ends = np.array([_LOWEST, min(_HIGHEST, 0.999 * loading.largest_overlap / radius)]) * radius
    (low, high), _ = force_loop(loading.shape, params_at(loading.params, 0), ends)
    loads = np.geomspace(low, 4.0 * high, _CELLS)  # beyond the last row of a table of first loading, too

    def flexibility(load):
        return np.fmin(above(load)[1], below(load)[1] / (1.0 + _MARGIN))

    own = above(loads)[1]
    if not (np.all(own > 0.0) and np.all(flexibility(loads) > 0.0)):  # ends, or begins with a force at overlap 0
        raise refusal
    kinks = _crossings(lambda load: np.nan_to_num(below(load)[1] / (1.0 + _MARGIN) / above(load)[1], nan=2.0) - 1.0, loads)
    steps = [law.force(np.array(law.kinks())) for law in (loading, branch) if law.kinks()]
    kinks = np.unique(np.concatenate([kinks, *steps]))
    curve = StiffenedCurve(loads, flexibility, kinks[(kinks > loads[1]) & (kinks < loads[-2])], 2.0 * high)
    inside = (curve.loads >= points.low) & (curve.loads <= points.high)
    overlap = above(curve.loads[inside])[0]
    change = 0.5 * float(np.ptp(curve.overlaps[inside] - overlap))
    slight = 2.0 * _MARGIN * float(np.ptp(overlap))
    share = f"{change / points.noise:.2g} times the noise of its points" if points.noise else "its points have no noise"
    if change > max(points.noise, slight):
        raise NotPassive(
            f"{refusal}; a curve that is nowhere softer than {loading.name!r} is off by {change:.2g} m from "
            f"{points.low:.3g} to {points.high:.3g} N ({share})"
        )
    text = f"{branch.name} fitted to {points.low:.3g} to {points.high:.3g} N, made nowhere softer than {loading.name}: "
    text += f"the overlap changes by up to {change:.2g} m there ({share})" if change > slight else "not changed there"
    if change > slight:
        warn(f"unloading curve: {text}")
    definition = definition_of_table(f"fitted-{branch.name}", "fitted", text, "radius", False, unloading=("elastic",))
    return tabulate_given(curve, definition, branch.contact, _RTOL)


def _along(law):
    """Loads [N] → overlap [m], dδ/dP [m/N] of a law's first loading; NaN beyond its end."""
    p = params_at(law.params, 0)

    def at(load):
        overlap = inverse_loop(law.shape, p, load)
        return overlap, 1.0 / force_loop(law.shape, p, overlap)[1]

    return at


def _crossings(difference, loads):
    """Loads [N] at which a function of the load changes its sign, between neighbours of `loads`."""
    from scipy.optimize import brentq

    sign = np.sign(difference(loads))
    pairs = [loads[k : k + 2] for k in np.flatnonzero(sign[1:] * sign[:-1] < 0.0)]
    return np.array(
        [brentq(lambda load: float(difference(np.array([load]))[0]), *pair, xtol=1e-14 * pair[0], rtol=1e-14) for pair in pairs]
    )
