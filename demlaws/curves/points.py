"""A curve of first loading from measured points, checked before it becomes a table (`Table.from_points`)."""

import itertools
import math
from typing import Any, NamedTuple

import numpy as np

from demlaws.errors import DemlawsError
from demlaws.units import as_float

FEWEST = 6
"""Overlaps from which on a curve is smoothed."""
FEWEST_FOR_UNCERTAINTY = 20
"""Overlaps from which on a curve has an uncertainty: of 12 noisy points of a bending curve it held 74 % of the true forces."""
MOST_PLACES = 160
"""More overlaps are averaged to about so many before they are smoothed."""
WIDEST = 0.25
"""Largest distance in ln δ of points that are averaged, by the errors of `studies/smoothing.py`."""
SHOWN = 24
"""Places of a smoothed curve whose force and uncertainty a table keeps."""
SHARES = (0.0, 1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3, 10.0)
"""Constant part of the noise, over its relative part and the largest force."""
SMOOTHINGS = np.geomspace(1e-6, 1e10, 33)
"""Variances of the bending of ln P over its noise."""
FREEDOM = 2.1
"""Least degrees of freedom of a curve: no mere power law, which has 2. [our choice]"""


class Knots(NamedTuple):
    """What a table keeps of the points that it was made of: places of its curve, and how far the points lie from it."""

    overlap: np.ndarray  # [m]
    force: np.ndarray  # [N]
    uncertainty: np.ndarray  # standard uncertainty of the force [N]; NaN of fewer than FEWEST_FOR_UNCERTAINTY overlaps
    points: int
    departure: float  # largest distance of a point's force from the curve [N]
    smoothing: str


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
        curve, text = np.exp(fit.curve), "smoothing spline by restricted likelihood"
        self.points, self.error = (overlap, force), fit.error * curve
        error = self.error if self.x.size >= FEWEST_FOR_UNCERTAINTY else np.full(curve.size, np.nan)
        self.knots = Knots(np.exp(fit.at), curve, error, int(sigma.size), float(departure.max()), text)

    def _set_curve(self, overlap, force, sigma):
        """Set the curve through points in the order of their overlaps; returns the smoothing."""
        from scipy.interpolate import CubicSpline

        groups = _groups(overlap)
        self.x = np.array([np.log(np.mean(overlap[g])) for g in groups])
        means = np.array([np.mean(force[g]) for g in groups])
        errors = np.array([math.sqrt(float(np.sum(sigma[g] ** 2))) / g.size for g in groups])
        fit = _smooth(self.x, means, errors, np.array([g.size for g in groups]))
        if fit is None:
            raise DemlawsError(
                f"first loading: the forces do not rise with the overlap (from {force[0]:.6g} N at {overlap[0]:.6g} m to "
                f"{force[-1]:.6g} N at {overlap[-1]:.6g} m)"
            )
        self._spline = CubicSpline(self.x, fit.values, bc_type="natural")
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
    values: np.ndarray  # ln P at the places of the points
    noise: float  # part of the force's noise that is the same at all forces [N]; 0 where uncertainties are given
    at: np.ndarray  # SHOWN places, in ln δ, as dense as the points
    curve: np.ndarray  # ln P there
    error: np.ndarray  # its standard uncertainty


def _smooth(x, force, sigma, counts):
    """Natural cubic smoothing spline of ln P over x = ln δ, rising; None where no rising one is found.

    force, sigma: mean force of each place and its standard uncertainty [N]; counts: points of each place. Where an uncertainty
    is unknown (NaN, 0), the noise of all points is s² (P² + r² P_max²) with each r of `SHARES`. The curve is the mean over
    smoothings and shares, weighted by their restricted likelihood (Wood 2011), and its uncertainty includes their spread.
    Residuals are those of the force, P - exp η, by the working response η + (P - exp η)/exp η: noise does not shift the
    logarithm (Green & Silverman 1994, ch. 5).
    """
    from scipy.interpolate import CubicSpline

    known, top, values = bool(np.all(sigma > 0.0)), float(np.max(force)), np.log(np.maximum(force, 0.03 * np.max(force)))
    unit, fine = (x - x[0]) / (x[-1] - x[0]), np.linspace(x[0], x[-1], 4 * x.size)
    for _ in range(15):
        curve = np.exp(values)
        shares = [sigma] if known else [np.sqrt((curve**2 + (r * top) ** 2) / (1.0 + r * r) / counts) for r in SHARES]
        splines = [_Splines(unit, values + (force - curve) / curve, one / curve, known) for one in shares]
        curves = np.concatenate([one.mean(unit) for one in splines])
        score = np.concatenate([one.score for one in splines])
        rising = np.min(CubicSpline(x, curves.T, bc_type="natural")(fine, 1), axis=0) > 0.0
        rising &= np.isfinite(score)
        if not np.any(rising):
            return None
        weight = np.where(rising, np.exp(-0.5 * (score - np.min(score[rising]))), 0.0)
        weight /= np.sum(weight)
        step = np.clip(weight @ curves - values, -1.0, 1.0)
        values = values + step
        if np.max(np.abs(step)) < 1e-6:
            break
    at = np.interp(np.linspace(0.0, x.size - 1.0, SHOWN), np.arange(x.size), unit)
    means = np.concatenate([one.mean(at) for one in splines])
    variances = np.concatenate([one.variance(at) for one in splines])
    mean = weight @ means
    error = np.sqrt(weight @ (variances + (means - mean) ** 2))
    noises = [r * top / math.sqrt(1.0 + r * r) * np.sqrt(one.scale) for r, one in zip(SHARES, splines, strict=False)]
    noise = 0.0 if known else float(weight @ np.concatenate(noises))
    return _Smoothed(values, noise, x[0] + at * (x[-1] - x[0]), mean, error)


class _Splines:
    """Smoothing splines of y over x, from 0 to 1, one for each of `SMOOTHINGS`, as means of a Gaussian process.

    Points have the noise `sd`, times an unknown number unless `known`; the process is a straight line with unknown
    coefficients plus an integral of Brownian motion, of variance `SMOOTHINGS` (Rasmussen & Williams 2006, sections 2.7, 6.3).
    """

    def __init__(self, x, y, sd, known):
        eigenvalues, vectors = np.linalg.eigh(_bending(x, x) / sd / sd[:, None])
        self.x, self.basis = x, vectors / sd[:, None]
        y, self.line = y @ self.basis, self.basis.T @ _line(x)
        self.shrinkage = 1.0 / (1.0 + SMOOTHINGS[:, None] * np.maximum(eigenvalues, 0.0))
        self.matrix = np.einsum("li,ia,ib->lab", self.shrinkage, self.line, self.line)
        self.coefficients = np.linalg.solve(self.matrix, ((self.shrinkage * y) @ self.line)[..., None])[..., 0]
        misfit = y - self.coefficients @ self.line.T
        self.residual = self.shrinkage * misfit
        squares = np.maximum(np.sum(self.residual * misfit, axis=1), 1e-300)
        self.scale = np.ones(SMOOTHINGS.size) if known else squares / (x.size - 2.0)
        self.score = (squares if known else (x.size - 2.0) * np.log(squares)) + 2.0 * np.sum(np.log(sd))
        self.score += np.linalg.slogdet(self.matrix)[1] - np.sum(np.log(self.shrinkage), axis=1)
        squared = np.einsum("li,ia,ib->lab", self.shrinkage**2, self.line, self.line)
        left = np.sum(self.shrinkage, axis=1) - np.trace(np.linalg.solve(self.matrix, squared), axis1=1, axis2=2)
        self.score[x.size - left < FREEDOM] = np.inf

    def mean(self, x):
        """The splines at x, a row for each smoothing."""
        return self.coefficients @ _line(x).T + SMOOTHINGS[:, None] * (self.residual @ (self.basis.T @ _bending(self.x, x)))

    def variance(self, x):
        """Their variance at x."""
        cross = self.basis.T @ _bending(self.x, x)
        line = _line(x) - SMOOTHINGS[:, None, None] * np.einsum("ix,li,ia->lxa", cross, self.shrinkage, self.line)
        bending = SMOOTHINGS[:, None] * (np.diag(_bending(x, x)) - SMOOTHINGS[:, None] * (self.shrinkage @ cross**2))
        return self.scale[:, None] * np.maximum(bending + np.sum(line @ np.linalg.inv(self.matrix) * line, axis=2), 0.0)


def _line(x):
    return np.column_stack([np.ones(x.size), x])


def _bending(x, y):
    """Covariance of an integral of Brownian motion from 0."""
    low, high = np.minimum(x[:, None], y), np.maximum(x[:, None], y)
    return low**2 * (high / 2.0 - low / 6.0)


def _groups(overlap):
    """Places of points of one overlap; of neighbours in equal number, at most WIDEST apart, where there are more than
    MOST_PLACES: a mean of forces is far from the force at a mean overlap where overlaps differ by a factor."""
    edges = np.flatnonzero(np.diff(overlap) > 1e-9 * overlap[1:]) + 1  # closer ones differ by rounding
    groups = np.split(np.arange(overlap.size), edges)
    if len(groups) <= MOST_PLACES:
        return groups
    bounds = np.linspace(0, len(groups), MOST_PLACES + 1).astype(int)
    joined, x = [np.concatenate(groups[a:b]) for a, b in itertools.pairwise(bounds)], np.log(overlap)
    steps = (np.diff(np.floor((x[group] - x[group[0]]) / WIDEST)) for group in joined)
    return [part for group, step in zip(joined, steps, strict=True) for part in np.split(group, np.flatnonzero(step) + 1)]


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
    places = len(_groups(np.sort(overlap[keep])))
    if places < FEWEST:
        raise DemlawsError(
            f"first loading: {places} overlaps above 0 with a force above 0; at least {FEWEST} are needed: measure more, or "
            "give a function through them to Table.from_function (scipy.interpolate.PchipInterpolator)"
        )
    columns = (overlap, force, sigma)
    return tuple(one[keep] for one in columns), tuple(one[~keep] for one in columns)
