"""Curves that a user brings: a function force(overlap), or measured points. `Table.from_function` and `from_points` read them.

Both are checked before they become a table: what is no curve of first loading is one DemlawsError with its overlap and value.
"""

import json
import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from demlaws.errors import DemlawsError
from demlaws.soundness import fault_of_slope, fault_of_values
from demlaws.units import number, real, whole

_STEPS = (1e-2, 1e-3, 1e-4)  # of ln δ, tried in turn
_AGREE = 1e-7  # of derivatives with one step and with twice that
_CENTRAL = np.array([-1.0, 9.0, -45.0, 0.0, 45.0, -9.0, 1.0]) / 60.0
_FORWARD = np.array([-147.0, 360.0, -450.0, 400.0, -225.0, 72.0, -10.0]) / 60.0
_PLACES = np.arange(-3, 4)
_AHEAD = np.arange(7)
_SCAN = 1500
_MOST_KINKS = 30


class Called:
    """A function of the user's, called with arrays where it takes them, else number by number."""

    def __init__(self, function, what, unit, overlap):
        if not callable(function):
            raise DemlawsError(f"{what} must be a function of the overlap in m, got {function!r:.60}")
        self.function, self.what, self.unit = function, what, unit
        self.takes_arrays = self._tried(overlap)

    def _tried(self, overlap):
        try:
            values = np.asarray(self.function(overlap.copy()))
            if values.shape != overlap.shape or values.dtype.kind not in "fiu":
                return False
            some = [0, overlap.size // 2, overlap.size - 1]
            return all(
                values[k] == float(self.function(float(overlap[k]))) or values[k] != values[k] for k in some
            ) or np.allclose(values[some], [float(self.function(float(overlap[k]))) for k in some], rtol=1e-12, atol=0.0)
        except Exception:
            return False

    def __call__(self, overlap):
        if self.takes_arrays:
            try:
                return np.array(self.function(overlap.copy()), dtype=float).reshape(overlap.shape)
            except Exception:
                self.takes_arrays = False
        return np.array([self._one(float(x)) for x in overlap.ravel()]).reshape(overlap.shape)

    def _one(self, overlap):
        try:
            value = self.function(overlap)
        except Exception as error:
            raise DemlawsError(
                f"the {self.what} function raises {type(error).__name__} at overlap {overlap:.6g} m: "
                f"{' '.join(str(error).split())}"
            ) from error
        array = np.asarray(value)
        if array.size != 1 or array.dtype.kind not in "fiu":
            raise DemlawsError(
                f"the {self.what} function gives {value!r:.60} at overlap {overlap:.6g} m: one number in {self.unit} is needed"
            )
        return float(array.reshape(())) if array.ndim == 0 else float(array.ravel()[0])


class GivenCurve:
    """force(overlap) with its stiffness, given or derived, up to `largest` [m]; beyond, a power law with the exponent there.

    The derivative is that of polynomials of degree 6 in ln δ, with two steps that must agree to 1e-7, on one side of a kink.
    Kinks are looked for where they do not.
    """

    def __init__(self, force: Callable, largest: float, stiffness: Callable | None = None, kinks: Any = ()):
        self.largest = largest
        scan = largest * np.geomspace(2.0**-30, 1.0, _SCAN)
        self.force = Called(force, "force", "N", scan)
        self.slope = None if stiffness is None else Called(stiffness, "stiffness", "N/m", scan)
        self._check(scan)
        self.kinks = sorted(float(k) for k in np.atleast_1d(real(list(kinks), "kinks", "m", array=True)) if 0.0 < k < largest)
        start, later = self.force(scan[[0, 40]])
        if later < start * (scan[40] / scan[0]) ** 0.05:
            raise DemlawsError(
                "the force function cannot be used: towards overlap 0 the force must go to 0 N; "
                f"at overlap {scan[0]:.3g} m it is {start:.6g} N"
            )
        self._find_kinks(scan)
        text = fault_of_slope(self.evaluate, scan[:: 5 if self.slope is None else 1])
        if text is not None:
            raise DemlawsError(f"the force function cannot be used: {text}")
        last, tangent = (float(v[0]) for v in self._inside(np.array([largest])))
        self.end = last, tangent * largest / last

    def _check(self, overlap):
        text = fault_of_values(overlap, self.force(overlap), None if self.slope is None else self.slope(overlap))
        if text is not None:
            raise DemlawsError(f"the force function cannot be used: {text}")

    # --- derivative

    def _stencil(self, overlap, step, factor):
        """dP/d ln δ with nodes `factor` steps apart; one-sided where a kink or the end lies within reach."""
        x, barriers = np.log(overlap), np.array([*self.kinks, self.largest])
        reach = 6.0 * step  # of the central one with two steps
        next_one = np.searchsorted(barriers, overlap, side="left")  # on a kink: what lies below it
        logs = np.concatenate([[-np.inf], np.log(barriers), [np.inf]])
        on_left = logs[next_one + 1] - x <= reach  # look back
        on_right = (x - logs[next_one] <= reach) & ~on_left
        places = np.where(on_left[:, None], -_AHEAD, np.where(on_right[:, None], _AHEAD, _PLACES)) * (step * factor)
        weights = np.where(on_left[:, None], -_FORWARD, np.where(on_right[:, None], _FORWARD, _CENTRAL)) / (step * factor)
        at = np.exp(x[:, None] + places)
        at[places == 0.0] = np.broadcast_to(overlap[:, None], at.shape)[places == 0.0]
        force = self.force(np.minimum(at, self.largest).ravel()).reshape(at.shape)
        return np.sum(weights * force, axis=1), force

    def _derived(self, overlap):
        """K and how far two steps disagree, relative."""
        slope, doubt = np.full(overlap.size, np.nan), np.full(overlap.size, np.inf)
        open_ = np.arange(overlap.size)
        for step in _STEPS:
            one, _ = self._stencil(overlap[open_], step, 1.0)
            two, _ = self._stencil(overlap[open_], step, 2.0)
            with np.errstate(all="ignore"):
                off = np.abs(two / one - 1.0)
            better = off < doubt[open_]
            slope[open_[better]], doubt[open_[better]] = one[better], off[better]
            open_ = open_[~(off <= _AGREE)]
            if not open_.size:
                break
        return slope / overlap, doubt

    def _find_kinks(self, scan):
        """Kinks of the force: places where derivatives with a wide step disagree, narrowed down by fourth differences."""
        for _ in range(3):
            one, _ = self._stencil(scan, _STEPS[0], 1.0)
            two, _ = self._stencil(scan, _STEPS[0], 2.0)
            flagged = np.flatnonzero(np.abs(two - one) > 1e-6 * np.abs(one))
            if not flagged.size:
                return
            found = []
            for group in np.split(flagged, np.flatnonzero(np.diff(flagged) > 1) + 1):
                a, b = scan[max(group[0] - 1, 0)], scan[min(group[-1] + 1, scan.size - 1)]
                kink = self._located(a, b)
                if all(abs(kink / k - 1.0) > 1e-6 for k in (*self.kinks, *found, self.largest)):
                    found.append(kink)
            if not found:
                return
            self.kinks = sorted([*self.kinks, *found])
            if len(self.kinks) > _MOST_KINKS:
                raise DemlawsError(
                    f"the force function has more than {_MOST_KINKS} kinks, or noise, between overlap {self.kinks[0]:.6g} m "
                    f"and {self.kinks[-1]:.6g} m: give a smooth one, or its points to Table.from_points"
                )

    def _located(self, a, b):
        """The kink between two overlaps."""
        while b - a > 1e-12 * b:
            at = np.linspace(a, b, 41)
            force = self.force(at)
            fourth = np.abs(np.diff(force, 4))
            if fourth.max() < 2e-14 * force[-1]:
                break
            k = int(np.argmax(fourth)) + 2
            a, b = at[max(k - 3, 0)], at[min(k + 3, 40)]
        low, high = self.force(np.array([a, b]))
        if high - low > 1e-6 * high + 50.0 * high / b * (b - a):
            raise DemlawsError(
                f"the force function cannot be used: at overlap {b:.6g} m the force jumps from {low:.6g} N to {high:.6g} N: "
                "it must be continuous"
            )
        return 0.5 * (a + b)

    # --- as a table's source reads it

    def _inside(self, overlap):
        force = self.force(overlap)
        if self.slope is not None:
            return force, self.slope(overlap)
        stiffness, doubt = self._derived(overlap)
        worst = int(np.argmax(doubt))
        if doubt[worst] > 1e-4:
            raise DemlawsError(
                f"the force function has no derivative to be found at overlap {overlap[worst]:.6g} m (two steps differ by "
                f"{doubt[worst]:.1g}): it is noisy or has a kink there; give kinks=[...] or stiffness=..."
            )
        return force, stiffness

    def evaluate(self, overlap: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Force [N] and stiffness [N/m] at overlaps [m] > 0."""
        overlap = np.asarray(overlap, float)
        inside = overlap <= self.largest * (1.0 + 1e-15)
        force, stiffness = np.empty(overlap.size), np.empty(overlap.size)
        if np.any(inside):
            force[inside], stiffness[inside] = self._inside(np.minimum(overlap[inside], self.largest))
            order = np.argsort(overlap[inside], kind="stable")
            text = fault_of_values(overlap[inside][order], force[inside][order])
            if text is not None:
                raise DemlawsError(f"the force function cannot be used: {text}")
        if not np.all(inside):
            relative = overlap[~inside] / self.largest
            last, exponent = self.end
            force[~inside] = last * relative**exponent
            stiffness[~inside] = exponent * force[~inside] / overlap[~inside]
        return force, stiffness


# --- points


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
    """Monotone curve through measured points: cubics in ln δ, ln P with Fritsch and Carlson's slopes through knots.

    Up to `knots` points, each is a knot (points of one overlap become their mean); more are averaged in ln δ, ln P over so
    many intervals of equal ratio. Neighbours whose forces fall are averaged (pool adjacent violators). Points whose force is
    further from the curve than 25 % (of it, or of a twentieth of the largest) and 4 standard uncertainties are refused, those
    without an overlap or without a force, which make no knot, too. Below the first knot the curve is a power law with the
    exponent there, from 1 to 4; beyond the last, one with the exponent there.
    """

    FURTHEST = 0.25
    MOST = 0.05
    """Difference of the forces with which loading ends and unloading begins, relative."""

    def __init__(self, overlap: Any, force: Any, uncertainty: Any = None, knots: int = 24, what: str = "first loading"):
        (overlap, force, sigma), without = _columns(overlap, force, uncertainty, what)
        knots = whole(knots, "knots", 2, 30)
        order = np.argsort(overlap, kind="stable")
        overlap, force, sigma = overlap[order], force[order], sigma[order]
        groups = _groups(overlap, knots)
        x = np.array([np.mean(np.log(overlap[g])) for g in groups])
        y = np.array([np.mean(np.log(force[g])) for g in groups])
        x, y, groups = _rising(x, y, groups)
        if x.size < 2:
            raise DemlawsError(
                f"{what}: the forces do not rise with the overlap (from {force[0]:.6g} N at {overlap[0]:.6g} m to "
                f"{force[-1]:.6g} N at {overlap[-1]:.6g} m)"
            )
        self.x, self.y, self.m = x, y, _slopes(x, y)
        self.first = min(max(1.0, float(self.m[0])), 4.0)
        self.last = max(float(self.m[-1]), 1e-3)
        self.largest = float(overlap[-1])
        departure = np.abs(self.evaluate(overlap)[0] - force)
        allowed = self._allowed(force, sigma, force.max())
        self._check_touch(without, force.max(), what)
        worst = int(np.argmax(departure / allowed))
        if departure[worst] > allowed[worst]:
            raise DemlawsError(
                f"{what}: at overlap {overlap[worst]:.6g} m the force is {force[worst]:.6g} N, {departure[worst]:.3g} N from "
                f"a rising curve through the points: give points of {what} only, in m and N, or their uncertainty [N]"
            )
        smoothed = len(groups) < overlap.size
        known = np.array([_uncertainty(sigma[g], departure[g], smoothed) for g in groups])
        text = f"{overlap.size} points averaged to {len(groups)} knots" if smoothed else f"none: a knot a point, {len(groups)}"
        self.knots = Knots(np.exp(x), np.exp(y), known, int(overlap.size), float(departure.max()), text)

    def _allowed(self, force, sigma, largest):
        """How far points may lie from the curve [N]."""
        return np.maximum(self.FURTHEST * np.maximum(force, 0.05 * largest), 4.0 * np.nan_to_num(sigma))

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
        k = np.clip(np.searchsorted(self.x, at, side="right") - 1, 0, self.x.size - 2)
        h = np.diff(self.x)[k]
        t = np.clip((at - self.x[k]) / h, 0.0, 1.0)
        y0, y1, m0, m1 = self.y[k], self.y[k + 1], self.m[k] * h, self.m[k + 1] * h
        c, d = 3.0 * (y1 - y0) - 2.0 * m0 - m1, m0 + m1 - 2.0 * (y1 - y0)
        y = y0 + t * (m0 + t * (c + t * d))
        slope = (m0 + t * (2.0 * c + t * 3.0 * d)) / h
        below, above = at < self.x[0], at > self.x[-1]
        y = np.where(
            below, self.y[0] + self.first * (at - self.x[0]), np.where(above, self.y[-1] + self.last * (at - self.x[-1]), y)
        )
        slope = np.where(below, self.first, np.where(above, self.last, slope))
        force = np.exp(y)
        return force, slope * force / overlap

    @property
    def kinks(self) -> list[float]:
        """Overlap [m] of the one knot where the stiffness may jump: the first."""
        return [float(np.exp(self.x[0]))] if abs(self.first - self.m[0]) > 1e-9 else []


def _columns(overlap, force, uncertainty, what):
    """Overlaps, forces and uncertainties of points with an overlap and a force above 0, and those of the others."""
    overlap = np.atleast_1d(
        real(overlap if isinstance(overlap, np.ndarray) else list(_listed(overlap, what)), f"{what}: overlap", "m", array=True)
    )
    force = np.atleast_1d(
        real(force if isinstance(force, np.ndarray) else list(_listed(force, what)), f"{what}: force", "N", array=True)
    )
    if overlap.size != force.size:
        raise DemlawsError(f"{what}: {overlap.size} overlaps [m] and {force.size} forces [N]: one force each")
    for name, unit, values in (("overlap", "m", overlap), ("force", "N", force)):
        if not np.all(np.isfinite(values)):
            k = int(np.argmin(np.isfinite(values)))
            raise DemlawsError(f"{what}: {name} of point {k} is {values[k]:g} {unit}: give finite values")
    sigma = np.full(force.size, np.nan)
    if uncertainty is not None:
        given = real(
            uncertainty if isinstance(uncertainty, np.ndarray | float | int | str) else list(uncertainty),
            "uncertainty",
            "N",
            array=True,
        )
        if given.ndim and given.size != force.size:
            raise DemlawsError(f"{given.size} uncertainties [N] for {force.size} points: one each, or one for all")
        sigma = np.broadcast_to(given, force.shape).copy()
        if not np.all(np.isfinite(sigma) & (sigma >= 0.0)):
            bad = float(sigma[int(np.argmin(np.isfinite(sigma) & (sigma >= 0.0)))])
            raise DemlawsError(f"uncertainty = {bad:g} N: a standard uncertainty is 0 or more")
    keep = (overlap > 0.0) & (force > 0.0)
    if np.unique(overlap[keep]).size < 2:
        raise DemlawsError(
            f"{what}: {np.unique(overlap[keep]).size} points with an overlap and a force above 0; at least 2 are needed"
        )
    columns = (overlap, force, sigma)
    return tuple(one[keep] for one in columns), tuple(one[~keep] for one in columns)


def _listed(values, what):
    if isinstance(values, str) or not hasattr(values, "__iter__"):
        raise DemlawsError(f"{what}: overlaps [m] and forces [N] are two rows of numbers, got {values!r:.60}")
    return values


def _groups(overlap, knots):
    """Rows of places that become one knot each."""
    edges = np.flatnonzero(np.diff(overlap) > 0.0) + 1
    groups = np.split(np.arange(overlap.size), edges)
    if len(groups) <= knots:
        return groups
    x = np.log(overlap)
    number = np.minimum((knots * (x - x[0]) / (x[-1] - x[0])).astype(int), knots - 1)
    least, result = overlap.size // (3 * knots), []
    for group in np.split(np.arange(overlap.size), np.flatnonzero(np.diff(number) > 0) + 1):
        if result and min(result[-1].size, group.size) < least:  # too few for a mean of their own
            result[-1] = np.concatenate([result[-1], group])
        else:
            result.append(group)
    return result


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


def _slopes(x, y):
    """Fritsch and Carlson's slopes of a rising cubic interpolant, those at the ends with three points."""
    h, d = np.diff(x), np.diff(y) / np.diff(x)
    if d.size == 1:
        return np.array([d[0], d[0]])
    one, two = 2.0 * h[1:] + h[:-1], h[1:] + 2.0 * h[:-1]
    middle = (one + two) / (one / d[:-1] + two / d[1:])

    def end(h0, h1, d0, d1):
        slope = ((2.0 * h0 + h1) * d0 - h0 * d1) / (h0 + h1)
        return min(max(slope, 0.5 * d0), 2.0 * d0)

    return np.concatenate([[end(h[0], h[1], d[0], d[1])], middle, [end(h[-1], h[-2], d[-1], d[-2])]])


def _uncertainty(sigma, departure, smoothed):
    """Standard uncertainty [N] of a knot: given, or from the scatter of the points that it is the mean of."""
    n = sigma.size
    given = math.sqrt(float(np.sum(sigma**2))) / n
    if given == given or not smoothed or n < 3:
        return given
    return float(np.sqrt(np.mean(departure**2) / (n - 1)))


def residual_overlap(overlap: Any, force: Any, residual: Any = None) -> tuple[np.ndarray, np.ndarray, float]:
    """Unloading points as overlaps past their foot δp [m], forces [N], and δp.

    δp is given, or the largest overlap without force, or where Hertz's straight line in P^(2/3) through the two lowest points
    with a force meets 0.
    """
    what = "unloading"
    overlap = np.atleast_1d(real(list(_listed(overlap, what)), "unloading: overlap", "m", array=True))
    force = np.atleast_1d(real(list(_listed(force, what)), "unloading: force", "N", array=True))
    if overlap.size != force.size:
        raise DemlawsError(f"unloading: {overlap.size} overlaps [m] and {force.size} forces [N]: one force each")
    order = np.argsort(overlap, kind="stable")
    overlap, force = overlap[order], force[order]
    carries = force > 0.0
    if np.unique(overlap[carries]).size < 2:
        raise DemlawsError(f"unloading: {np.unique(overlap[carries]).size} points with a force above 0; at least 2 are needed")
    lowest = float(overlap[carries][0])
    if residual is not None:
        foot = number(residual, "residual", "m", -math.inf)
    elif np.any(~carries & (overlap < lowest)):
        foot = float(np.max(overlap[~carries & (overlap < lowest)]))
    else:
        (d0, d1), (s0, s1) = overlap[carries][:2], np.cbrt(force[carries][:2]) ** 2
        foot = float(d0 - s0 * (d1 - d0) / (s1 - s0)) if s1 > s0 and d1 > d0 else lowest - 1e-3 * float(np.ptp(overlap))
    if not foot < lowest:
        raise DemlawsError(f"residual = {foot:g} m: unloading still carries {force[carries][0]:g} N at overlap {lowest:g} m")
    return overlap[carries] - foot, force[carries], foot
