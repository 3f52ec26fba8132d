"""A curve of first loading from measured points, checked before it becomes a table (`Table.from_points`)."""

import itertools
import json
import math
from typing import Any, NamedTuple

import numpy as np

from demlaws.errors import Argument, DemlawsError
from demlaws.units import as_float, number

FEWEST = 6
"""Overlaps from which on a curve is smoothed; fewer are interpolated."""
MOST_PLACES = 160
"""More overlaps are averaged to so many before they are smoothed."""
SHOWN = 24
"""Knots of a smoothed curve whose force and uncertainty a table keeps."""


class Knots(NamedTuple):
    """What a table keeps of the points that it was made of: the knots of its curve, and how far the points lie from it."""

    overlap: np.ndarray  # [m]
    force: np.ndarray  # [N]
    uncertainty: np.ndarray  # standard uncertainty of the force [N]; NaN where nothing tells it
    points: int
    departure: float  # largest distance of a point's force from the curve [N]
    smoothing: str

    def text(self) -> str:
        """As one line of a table file."""
        values = [None if isinstance(v, float) and v != v else v for v in self.uncertainty.tolist()]
        columns = {"overlap": self.overlap.tolist(), "force": self.force.tolist(), "uncertainty": values}
        return json.dumps({**columns, "points": self.points, "departure": self.departure, "smoothing": self.smoothing})

    @classmethod
    def from_text(cls, text: str) -> "Knots":
        """The reverse of `text`."""
        content = json.loads(text)
        overlap, force, uncertainty = (np.array(content[n], float) for n in ("overlap", "force", "uncertainty"))
        return cls(overlap, force, uncertainty, content["points"], content["departure"], content["smoothing"])


class MeasuredCurve:
    """Rising curve of measured points: a smoothing spline in ln δ, ln P (`_smooth`).

    Fewer than 6 overlaps are interpolated, by Fritsch and Carlson's monotone cubics: points of one overlap become their mean,
    neighbours whose forces fall are averaged (pool adjacent violators). Points whose force is further from the curve than 25 %
    (of it, or of a twentieth of the largest) and 4 to 6 standard uncertainties are refused, also those without an overlap or
    without a force. Below the first knot the curve is a power law with the
    exponent there, from 1 to 4; beyond the last, one with the exponent there.
    """

    FURTHEST = 0.25
    LARGEST_NOISE = 0.02
    """Most constant noise of the force that is estimated from the points and allowed for, over the largest force."""
    MOST = 0.05
    """Difference of the forces with which loading ends and unloading begins, relative."""

    def __init__(self, overlap: Any, force: Any, uncertainty: Any = None, what: str = "first loading"):
        (overlap, force, sigma), without = _columns(overlap, force, uncertainty, what)
        order = np.argsort(overlap, kind="stable")
        overlap, force, sigma = overlap[order], force[order], sigma[order]
        groups, fit = self._set_curve(overlap, force, sigma, what)
        departure = np.abs(self.evaluate(overlap)[0] - force)
        most, noise, at_touch = self.LARGEST_NOISE * float(force.max()), 0.0, 0.0
        if fit is not None:
            noise = min(fit.noise, most)
            at_touch = min(max(1.5 * noise, float(np.sqrt(np.mean(departure**2)))), 1.5 * most)
        self._check_touch((*without[:2], np.fmax(without[2], at_touch)), force.max(), what)
        allowed = np.maximum(self._allowed(force, sigma, force.max()), 6.0 * noise)
        worst = int(np.argmax(departure / allowed))
        if departure[worst] > allowed[worst]:
            raise DemlawsError(
                f"{what}: at overlap {overlap[worst]:.6g} m the force is {force[worst]:.6g} N, {departure[worst]:.3g} N from "
                f"a rising curve through the points: give points of {what} only, in m and N, or their uncertainty [N]"
            )
        self.knots = self._knots(groups, fit, sigma, departure)

    def _set_curve(self, overlap, force, sigma, what):
        """Set the curve through points in the order of their overlaps; returns the points of each place, and the smoothing."""
        smooth, groups, fit = np.unique(overlap).size >= FEWEST, _equal_groups(overlap), None
        x = np.array([np.mean(np.log(overlap[g])) for g in groups])
        if smooth:
            means = np.array([np.mean(force[g]) for g in groups])
            errors = np.array([math.sqrt(float(np.sum(sigma[g] ** 2))) / g.size for g in groups])
            fit = _smooth(x, means, errors, np.array([g.size for g in groups]))
        else:
            x, y, groups = _rising(x, np.array([np.mean(np.log(force[g])) for g in groups]), groups)
        if x.size < 2 or (smooth and fit is None):
            raise DemlawsError(
                f"{what}: the forces do not rise with the overlap (from {force[0]:.6g} N at {overlap[0]:.6g} m to "
                f"{force[-1]:.6g} N at {overlap[-1]:.6g} m)"
            )
        self.x, self._spline = x, _monotone(x, y) if fit is None else fit.spline
        self._slope = float(self._spline(x[0], 1))
        self.first = min(max(1.0, self._slope), 4.0)
        self.last = max(float(self._spline(x[-1], 1)), 1e-3)
        self.largest = float(overlap[-1])
        return groups, fit

    def _knots(self, groups, fit, sigma, departure):
        """What a table keeps of the points."""
        overlap, force = np.exp(self.x), np.exp(self._spline(self.x))
        if fit is not None:
            at = np.unique(np.linspace(0, self.x.size - 1, min(self.x.size, SHOWN)).round().astype(int))
            text = f"smoothing spline by restricted likelihood, {fit.freedom:.1f} degrees of freedom"
            sigmas = fit.relative_error * force
            return Knots(overlap[at], force[at], sigmas[at], int(sigma.size), float(departure.max()), text)
        averaged = len(groups) < sigma.size
        sigmas = np.array([_uncertainty(sigma[g], departure[g], averaged) for g in groups])
        points = f"{sigma.size} points averaged to {len(groups)} knots"
        text = points if averaged else f"none: one knot per point ({len(groups)})"
        return Knots(overlap, force, sigmas, int(sigma.size), float(departure.max()), text)

    def _allowed(self, force, sigma, largest):
        """How far points may lie from the curve [N]."""
        widths = max(4.0, math.sqrt(2.0 * math.log(1e3 * max(sigma.size, 1))))  # of one in a thousand sets of so many points
        return np.maximum(self.FURTHEST * np.maximum(force, 0.05 * largest), widths * np.nan_to_num(sigma))

    def _check_touch(self, points, largest, what):
        """Points without overlap carry no force, and those without force lie where it has none."""
        overlap, force, sigma = points
        expected = np.zeros(overlap.size)
        expected[overlap > 0.0] = self.evaluate(overlap[overlap > 0.0])[0]
        bad = np.flatnonzero(np.abs(force - expected) > self._allowed(0.0, sigma, largest))
        if bad.size:
            k = bad[np.argmax(np.abs(overlap[bad]))]
            raise DemlawsError(
                f"{what}: at overlap {overlap[k]:.6g} m the force is {force[k]:.6g} N: overlaps count from where the bodies "
                "touch; subtract the displacement at which they do (demlaws table: --zero)"
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


def _columns(overlap, force, uncertainty, what):
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
    if np.unique(overlap[keep]).size < 2:
        raise DemlawsError(
            f"{what}: {np.unique(overlap[keep]).size} points with an overlap and a force above 0; at least 2 are needed"
        )
    columns = (overlap, force, sigma)
    return tuple(one[keep] for one in columns), tuple(one[~keep] for one in columns)


def _rising(x, y, groups):
    """Neighbours whose forces do not rise, joined into one knot (pool adjacent violators)."""
    blocks = []
    for one in zip(x, y, groups, strict=True):
        blocks.append(one)
        while len(blocks) > 1 and not blocks[-1][1] > blocks[-2][1] + 1e-12:
            (xb, yb, gb), (xa, ya, ga) = blocks.pop(), blocks.pop()
            a, b = ga.size / (ga.size + gb.size), gb.size / (ga.size + gb.size)
            blocks.append((a * xa + b * xb, a * ya + b * yb, np.concatenate([ga, gb])))
    return np.array([b[0] for b in blocks]), np.array([b[1] for b in blocks]), [b[2] for b in blocks]


def _monotone(x, y):
    """Monotone cubics through rising knots (`scipy.interpolate.PchipInterpolator`), the slopes at the ends kept positive."""
    from scipy.interpolate import CubicHermiteSpline, PchipInterpolator

    slopes, chords = PchipInterpolator(x, y).derivative()(x), np.diff(y) / np.diff(x)
    for end in (0, -1):
        slopes[end] = np.clip(slopes[end], 0.5 * chords[end], 2.0 * chords[end])
    return CubicHermiteSpline(x, y, slopes)


def _uncertainty(sigma, departure, smoothed):
    """Standard uncertainty [N] of a knot: given, or from the scatter of the points that it is the mean of."""
    n = sigma.size
    value = math.sqrt(float(np.sum(sigma**2))) / n
    if value == value or not smoothed or n < 3:
        return value
    return float(np.sqrt(np.mean(departure**2) / (n - 1)))


def past_plastic_overlap(overlap: Any, force: Any, plastic_overlap: Any = None) -> tuple[np.ndarray, np.ndarray, float]:
    """Unloading points as overlaps past their foot δp [m], forces [N], and δp.

    δp is given, or the largest overlap without force, or where Hertz's straight line in P^(2/3) through the two lowest points
    with a force meets 0.
    """
    order = np.argsort(overlap, kind="stable")
    overlap, force = overlap[order], force[order]
    carries = force > 0.0
    if np.unique(overlap[carries]).size < 2:
        raise DemlawsError(f"unloading: {np.unique(overlap[carries]).size} points with a force above 0; at least 2 are needed")
    lowest = float(overlap[carries][0])
    if plastic_overlap is not None:
        foot = number(plastic_overlap, "plastic_overlap", "m", -math.inf)
    elif np.any(~carries & (overlap < lowest)):
        foot = float(np.max(overlap[~carries & (overlap < lowest)]))
    else:
        (d0, d1), (s0, s1) = overlap[carries][:2], np.cbrt(force[carries][:2]) ** 2
        foot = float(d0 - s0 * (d1 - d0) / (s1 - s0)) if s1 > s0 and d1 > d0 else lowest - 1e-3 * float(np.ptp(overlap))
    if not foot < lowest:
        raise DemlawsError(
            Argument("plastic_overlap"),
            f" = {foot:g} m: unloading still carries {force[carries][0]:g} N at overlap {lowest:g} m",
        )
    return overlap[carries] - foot, force[carries], foot
