"""A curve of first loading from measured points, checked before it becomes a table (`Table.from_points`)."""

import itertools
import json
import math
from typing import Any, NamedTuple

import numpy as np

from demlaws.errors import DemlawsError
from demlaws.units import as_float

FEWEST = 6
"""Overlaps from which on a curve is smoothed."""
MOST_PLACES = 160
"""More overlaps are averaged to so many before they are smoothed."""
SHOWN = 24
"""Knots of a smoothed curve whose force and uncertainty a table keeps."""


class Knots(NamedTuple):
    """What a table keeps of the points that it was made of: the knots of its curve, and how far the points lie from it."""

    overlap: np.ndarray  # [m]
    force: np.ndarray  # [N]
    uncertainty: np.ndarray  # standard uncertainty of the force [N]
    points: int
    departure: float  # largest distance of a point's force from the curve [N]
    smoothing: str

    def text(self) -> str:
        """As one line of a table file."""
        columns = {name: getattr(self, name).tolist() for name in ("overlap", "force", "uncertainty")}
        return json.dumps({**self._asdict(), **columns})

    @classmethod
    def from_text(cls, text: str) -> "Knots":
        """The reverse of `text`."""
        content = json.loads(text)
        overlap, force, uncertainty = (np.array(content[n], float) for n in ("overlap", "force", "uncertainty"))
        return cls(overlap, force, uncertainty, content["points"], content["departure"], content["smoothing"])


class MeasuredCurve:
    """Rising curve of measured points of first loading: a smoothing spline in ln δ, ln P (`_smooth`).

    Points whose force is further from the curve than 25 % (of it, or of a twentieth of the largest) and 4 to 6 standard
    uncertainties are refused, also those without an overlap or without a force. Below the first place the curve is a power law
    with the exponent there, from 1 to 4; beyond the last, one with the exponent there.
    """

    FURTHEST = 0.25
    LARGEST_NOISE = 0.02
    """Most constant noise of the force that is estimated from the points and allowed for, over the largest force."""

    def __init__(self, overlap: Any, force: Any, uncertainty: Any = None):
        (overlap, force, sigma), without = _columns(overlap, force, uncertainty)
        order = np.argsort(overlap, kind="stable")
        overlap, force, sigma = overlap[order], force[order], sigma[order]
        fit = self._set_curve(overlap, force, sigma)
        departure = np.abs(self.evaluate(overlap)[0] - force)
        self._refuse_departures(overlap, force, sigma, without, departure, fit.noise)
        at = np.unique(np.linspace(0, self.x.size - 1, min(self.x.size, SHOWN)).round().astype(int))
        curve = np.exp(fit.values)
        text = f"smoothing spline by restricted likelihood, {fit.freedom:.1f} degrees of freedom"
        sigmas = (fit.relative_error * curve)[at]
        self.knots = Knots(np.exp(self.x[at]), curve[at], sigmas, int(sigma.size), float(departure.max()), text)

    def _set_curve(self, overlap, force, sigma):
        """Set the curve through points in the order of their overlaps; returns the smoothing."""
        groups = _equal_groups(overlap)
        self.x = np.array([np.mean(np.log(overlap[g])) for g in groups])
        means = np.array([np.mean(force[g]) for g in groups])
        errors = np.array([math.sqrt(float(np.sum(sigma[g] ** 2))) / g.size for g in groups])
        fit = _smooth(self.x, means, errors, np.array([g.size for g in groups]))
        if fit is None:
            raise DemlawsError(
                f"first loading: the forces do not rise with the overlap (from {force[0]:.6g} N at {overlap[0]:.6g} m to "
                f"{force[-1]:.6g} N at {overlap[-1]:.6g} m)"
            )
        self._spline = fit.spline
        self._slope = float(self._spline(self.x[0], 1))
        self.first = min(max(1.0, self._slope), 4.0)
        self.last = max(float(self._spline(self.x[-1], 1)), 1e-3)
        self.largest = float(overlap[-1])
        return fit

    def _refuse_departures(self, overlap, force, sigma, without, departure, noise):
        """Refuse a point too far from the curve; `without`: columns of those without an overlap or a force."""
        most = self.LARGEST_NOISE * float(force.max())
        noise = min(noise, most)
        at_touch = min(max(1.5 * noise, float(np.sqrt(np.mean(departure**2)))), 1.5 * most)
        expected = np.zeros(without[0].size)
        expected[without[0] > 0.0] = self.evaluate(without[0][without[0] > 0.0])[0]
        widths = max(4.0, math.sqrt(2.0 * math.log(1e3 * sigma.size)))  # of one in a thousand sets of so many points
        floor = 0.05 * self.FURTHEST * force.max()
        far = np.append(departure, np.abs(without[1] - expected))
        near = np.maximum(np.maximum(self.FURTHEST * force, floor), np.maximum(widths * np.nan_to_num(sigma), 6.0 * noise))
        allowed = np.append(near, np.maximum(floor, widths * np.fmax(without[2], at_touch)))
        worst = int(np.argmax(far / allowed))
        if far[worst] > allowed[worst]:
            raise DemlawsError(
                f"first loading: at overlap {np.append(overlap, without[0])[worst]:.6g} m the force is "
                f"{np.append(force, without[1])[worst]:.6g} N, {far[worst]:.3g} N from a rising curve through the points: give "
                "points of first loading only, in m and N, or their uncertainty. Overlaps count from where the bodies touch; "
                "subtract the displacement at which they do (demlaws table: --zero)"
            )

    def evaluate(self, overlap: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Force [N] and stiffness [N/m] at overlaps [m] > 0."""
        overlap = np.asarray(overlap, float)
        at = np.log(overlap)
        inside = np.clip(at, self.x[0], self.x[-1])
        below, above = at < self.x[0], at > self.x[-1]
        slope = np.where(below, self.first, np.where(above, self.last, self._spline(inside, 1)))
        force = np.exp(self._spline(inside) + slope * (at - inside))
        return force, slope * force / overlap

    @property
    def kinks(self) -> list[float]:
        """Overlap [m] of the one knot where the stiffness may jump: the first."""
        return [float(np.exp(self.x[0]))] if abs(self.first - self._slope) > 1e-9 else []


class _Smoothed(NamedTuple):
    values: np.ndarray  # ln P at the places
    spline: Any
    freedom: float  # trace of the smoother
    noise: float  # part of the force's noise that is the same at all forces [N]; 0 where uncertainties are given
    relative_error: np.ndarray  # standard uncertainty of ln P at the places


def _smooth(x, force, sigma, counts):
    """Natural cubic smoothing spline η(x) of ln P, rising; None where no rising one is found.

    force, sigma: mean force of each place and its standard uncertainty [N]; unknown ones (NaN, 0) are a² + b² P², found from
    the residuals; counts: points that each place stands for. Residuals are those of the force, P - exp η, so that noise does
    not shift the logarithm (Green & Silverman 1994, ch. 5). The curve is the mean over smoothings, weighted by their
    restricted likelihood (Wood 2011), and the uncertainty includes the spread of these.
    """
    from scipy.interpolate import CubicSpline
    from scipy.optimize import nnls

    penalty, fine, top, noise = _penalty(x), np.linspace(x[0], x[-1], 8 * x.size), float(np.max(force)), 0.0
    known = bool(np.all(sigma > 0.0))
    error = sigma if known else 0.02 * top / np.sqrt(counts)
    values = np.log(np.maximum(force, 0.03 * top))
    for turn in range(40):
        curve = np.exp(values)
        relative, response = error / curve, values + (force - curve) / curve
        stiffness, vectors = np.linalg.eigh(penalty * relative * relative[:, None])
        stiffness[:2], data = 0.0, vectors.T @ (response / relative)
        smoothing = np.geomspace(1e-4 / stiffness[-1], 10.0 / stiffness[2], 120)[:, None]  # no mere power law [our choice]
        shrinkage = 1.0 / (1.0 + smoothing * stiffness)
        squares = np.sum((1.0 - shrinkage) * data**2, axis=1)
        score = squares if known else (x.size - 2.0) * np.log(np.maximum(squares, 1e-300))
        score = score - np.sum(np.log(smoothing * stiffness[2:] * shrinkage[:, 2:]), axis=1)
        curves = relative * ((shrinkage * data) @ vectors.T)
        rising = np.min(CubicSpline(x, curves.T, bc_type="natural")(fine, 1), axis=0) > 0.0
        if not np.any(rising):
            return None
        weight = np.where(rising, np.exp(-0.5 * (score - np.min(score[rising]))), 0.0)
        weight /= np.sum(weight)
        best, scale = weight @ curves, 1.0 if known else float(weight @ squares) / (x.size - 2.0)
        variance = scale * (weight @ (shrinkage @ (vectors**2).T)) * relative**2 + weight @ (curves - best) ** 2
        step = np.clip(best - values, -1.0, 1.0)
        values, freedom = values + step, float(weight @ np.sum(shrinkage, axis=1))
        if np.max(np.abs(step)) < 1e-9 or (turn > 12 and np.max(np.abs(step)) < 1e-4):
            break
        if not known and turn > 1:
            curve = np.exp(values)
            square = (force - curve) ** 2 * counts / max(1.0 - freedom / x.size, 0.2)
            model = np.column_stack([np.ones(x.size), curve**2])
            inverse = 1.0 / (model @ [1e-6 * top**2, 1e-4])
            (constant, share), _ = nnls(model * inverse[:, None], square * inverse)
            noise = math.sqrt(constant)
            error = np.sqrt((constant + share * curve**2 + 1e-12 * curve**2) / counts)
    return _Smoothed(values, CubicSpline(x, values, bc_type="natural"), freedom, noise, np.sqrt(variance))


def _penalty(x):
    """Matrix of ∫η'' ² dx of a natural cubic spline with the values η at x (Green & Silverman 1994, ch. 2)."""
    h, rows = np.diff(x), np.arange(x.size - 2)
    second = np.zeros((x.size - 2, x.size))
    second[rows, rows], second[rows, rows + 2] = 1.0 / h[:-1], 1.0 / h[1:]
    second[rows, rows + 1] = -(1.0 / h[:-1] + 1.0 / h[1:])
    band = np.diag((h[:-1] + h[1:]) / 3.0) + np.diag(h[1:-1] / 6.0, 1) + np.diag(h[1:-1] / 6.0, -1)
    return second.T @ np.linalg.solve(band, second)


def _equal_groups(overlap):
    """Places of points of one overlap, or of neighbours in equal number where there are more than MOST_PLACES."""
    edges = np.flatnonzero(np.diff(overlap) > 1e-9 * overlap[1:]) + 1  # closer ones differ by rounding
    groups = np.split(np.arange(overlap.size), edges)
    if len(groups) <= MOST_PLACES:
        return groups
    bounds = np.linspace(0, len(groups), MOST_PLACES + 1).astype(int)
    return [np.concatenate(groups[a:b]) for a, b in itertools.pairwise(bounds)]


def _columns(overlap, force, uncertainty):
    """Overlaps, forces and uncertainties of points with an overlap and a force above 0, and those of the others."""
    sigma = np.full(force.size, np.nan)
    if uncertainty is not None:
        value = as_float(uncertainty, "uncertainty", "N", array=True)
        if value.ndim and value.size != force.size:
            raise DemlawsError(f"{value.size} uncertainties [N] for {force.size} points: one each, or one for all")
        sigma = np.broadcast_to(value, force.shape).copy()
        highest = 1e3 * float(np.max(force, initial=0.0))
        good = (sigma >= 0.0) & (sigma <= highest)
        if not np.all(good):
            bad = float(sigma[int(np.argmin(good))])
            raise DemlawsError(f"uncertainty = {bad:g} N: must be from 0 to a thousand times the largest force, {highest:g} N")
    keep = (overlap > 0.0) & (force > 0.0)
    places = len(_equal_groups(np.sort(overlap[keep])))
    if places < FEWEST:
        raise DemlawsError(
            f"first loading: {places} overlaps above 0 with a force above 0; at least {FEWEST} are needed: measure more, or "
            "give a function through them to Table.from_function (scipy.interpolate.PchipInterpolator)"
        )
    columns = (overlap, force, sigma)
    return tuple(one[keep] for one in columns), tuple(one[~keep] for one in columns)
