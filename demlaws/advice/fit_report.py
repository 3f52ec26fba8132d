"""What a least-squares solution says: intervals, notes, and Akaike's criterion.

Intervals come from Student's t in the fitted coordinates or, near the end of a range, from the profile likelihood. They are
widened where the deviations of neighbouring points are correlated.
"""

import math
from typing import NamedTuple

import numpy as np

from demlaws.advice.fit_model import COMPLIANCE, FORCE_ZERO, ZERO
from demlaws.contact import Contact
from demlaws.curves.branch import Measured
from demlaws.law import Law

_ENDS = {"fractal_dimension", COMPLIANCE}
"""Quantities with a natural end of their range (2 ≤ Df ≤ 3, compliance ≥ 0), not one of the search."""
_CONFIDENCE = 0.95
WEAK = "not separately identifiable from these points"
SYSTEMATIC = "systematic misfit (drift, or a wrong law): do not trust these intervals"
ALTERNATING = "neighbouring points deviate to opposite sides: are the rows in the order of the test, not sorted?"
UNEVEN = (
    "the scatter is {:.2g} times larger where the contact is soft, more than a noise of the force explains: are the rows in "
    "the order of the test, not sorted?"
)
MOST_UNEVEN = 50.0
"""Ratio of the largest weight's scatter to the smallest above which the law does not describe the points."""
SORTED = (
    "the displacement never falls, while the force falls in {} of {} rows: if these are sorted by displacement, do not trust "
    "the fit; give them in the order of the test"
)
OUTLIER = 6.0
"""Distance from the law, over the robust scatter, from which on a point is named: of normal noise one in 5e8."""
FEW_POINTS = 15
"""Points beyond the number of quantities from which on their scatter shows where it is larger."""
_IMPROBABLE = 1e-3  # probability of a larger χ², with the given noise, below which a misfit is systematic


class Estimate(NamedTuple):
    """A fitted value, SI. low and high: 95 % interval.

    From Student's t in the fitted coordinate. If a quantity lies at or near the end of its range, all intervals of that law
    come from the profile likelihood. If the deviations of neighbouring points are correlated (drift, or a wrong law), the
    intervals are widened (`Fit.systematic`). `open_end` names the end that is the limit of the search, not of the points.
    """

    value: float
    error: float  # standard error; nan if the points do not determine it
    low: float
    high: float
    cause: str = ""  # why the points determine it badly
    open_end: str = ""  # "lower", "upper" or "both": the points do not limit it there

    @property
    def note(self) -> str:
        """Open ends and their cause."""
        if self.open_end == "both":
            return "not determined" + (f": {self.cause}" if self.cause else "")
        return ", ".join(part for part in (self.open_end and f"no {self.open_end} end", self.cause) if part)


class Fit(NamedTuple):
    """One fitted law."""

    name: str
    unloading: str
    parameters: dict  # name → Estimate; "zero" is the displacement [m] at first touch, "force_zero" the load cell's reading [N]
    covariance: np.ndarray  # of the fitted coordinates: ln(value) of positive quantities, else the value
    coordinates: tuple  # names, in the order of covariance
    misfit: float  # root mean square difference in displacement [m]
    aicc: float
    delta: float  # aicc minus that of the best law
    weight: float  # Akaike weight: probability of being the best of these laws
    chi_squared: float  # per degree of freedom; nan unless the noise was given
    law: Law
    displacement: np.ndarray  # predicted [m], for each point used
    notes: tuple
    systematic: bool  # the misfit is no scatter: such a law does not describe the points, whatever its weight among the others

    @property
    def contact(self) -> Contact:
        """Contact with the fitted quantities."""
        return self.law.contact


def fitted(model, displacement_noise, force_noise):
    """The `Fit` of a model: least squares, weights and intervals."""
    # the stiffness that converts force noise comes from the fit itself: two more rounds
    x, squares = model.minimise()
    if displacement_noise is not None and force_noise:
        for _ in range(2):
            model.sigma = np.hypot(displacement_noise, force_noise / model.overlap(x)[1])
            x, squares = model.minimise()
    notes = []
    enough = x.size + FEW_POINTS <= model.force.size
    if displacement_noise is None and enough and not _correlation(model.residual(x)):
        for _ in range(2):
            stiffness = model.overlap(x)[1]
            model.sigma = model.scale * np.hypot(1.0, _noise_ratio(model, x, stiffness) / stiffness)
            x, squares = model.refine(x)
        uneven = float(np.max(model.sigma)) / model.scale
        if uneven > MOST_UNEVEN:
            notes.append(UNEVEN.format(uneven))
        elif uneven > 2.0:
            notes.append(
                f"scatter up to {uneven:.2g} times larger where the contact is soft: points are weighted as with noise of the "
                "force; intervals contained the true value in 81 to 98 % of tests: give the noise of force and displacement "
                "if known"
            )
    return _report(model, x, squares, displacement_noise is not None, notes)


def _falls_of_sorted(displacement, force):
    """Rows in which the force falls, of rows in the order of their displacement; 0 where these are fewer than a tenth."""
    falls = int(np.sum(np.diff(force) < 0.0))
    return falls if np.all(np.diff(displacement) >= 0.0) and 10 * falls >= force.size else 0


def _outliers(model, residual):
    """A note that names the points whose residual is far above the scatter of the others (1.48 times the median)."""
    size = np.abs(residual)
    far = np.flatnonzero(size > OUTLIER * 1.4826 * np.median(size))
    if not 0 < far.size < 0.1 * size.size or not np.median(size) * model.scale > 1e-9 * np.ptp(model.measured):
        return []
    places = ", ".join(f"{model.force[k]:.4g} N at {1e6 * model.measured[k]:.4g} µm" for k in far[:3])
    more = ", ..." if far.size > 3 else ""
    what = "1 point is" if far.size == 1 else f"{far.size} points are"
    return [f"{what} far from the law ({places}{more}), above {OUTLIER:g} times the scatter: outliers? Leave them out"]


def _correlation(residual, significance=2.0):
    """Correlation of neighbouring residuals; 0 unless it is significant (2.5 % to each side; 0.1 % with 3 deviations)."""
    spread = float(np.sum(residual**2))
    correlation = float(np.sum(residual[1:] * residual[:-1])) / spread if spread > 0.0 else 0.0
    return correlation if abs(correlation) > significance / math.sqrt(residual.size) else 0.0


def _noise_ratio(model, x, stiffness):
    """Noise of the force over that of the displacement [N/m], 0 unless the points show it: restricted maximum likelihood
    (Patterson & Thompson 1971) of the linearised fit."""
    from scipy.optimize import minimize_scalar

    jacobian, residual = model.jacobian(x) * model.sigma[:, None], model.residual(x) * model.sigma
    size = np.linalg.norm(jacobian, axis=0)
    sensitive = size > 1e-10 * size[-1]
    jacobian = jacobian[:, sensitive] / size[sensitive]

    def cost(exponent):
        weights = np.hypot(1.0, math.exp(exponent) / stiffness)
        q, r = np.linalg.qr(jacobian / weights[:, None])
        z = residual / weights
        squares = max(float(z @ z - np.sum((q.T @ z) ** 2)), 1e-300)
        scales = np.append(weights, np.abs(np.diag(r)) + 1e-300)
        return (z.size - r.shape[0]) * math.log(squares) + 2.0 * np.sum(np.log(scales))

    ends = math.log(1e-3 * float(np.min(stiffness))), math.log(1e2 * float(np.max(stiffness)))
    best = minimize_scalar(cost, bounds=ends, method="bounded")
    return math.exp(best.x) if best.fun < cost(ends[0]) else 0.0


def _drift(residual, count):
    """Widening of the intervals where neighbouring points deviate alike, and the correlation ρ of neighbours.

    √((1 + ρ)/(1 - ρ)), from the effective number of points under a first-order autoregression; ρ is corrected for few points.
    """
    correlation = _correlation(residual)
    if correlation > 0.0:
        correlation = min(correlation + (1.0 + (count + 3.0) * correlation) / residual.size, 0.95)
    return math.sqrt((1.0 + max(correlation, 0.0)) / (1.0 - max(correlation, 0.0))), correlation


class _Solution(NamedTuple):
    """A least-squares solution and its statistics."""

    x: np.ndarray
    squares: float
    jacobian: np.ndarray
    variance: float  # of the weighted residuals
    widening: float  # of the intervals, for correlated deviations
    at_bound: np.ndarray  # a quantity at its bound, or without effect, is left out of the covariance
    idle: np.ndarray
    weak: np.ndarray  # not told from others


def _report(model, x, squares, absolute, notes):
    """The `Fit` of a solution. absolute: the noise is given."""
    from scipy import special

    n, k = model.force.size, x.size
    jacobian, residual = model.jacobian(x), model.residual(x)
    size = np.linalg.norm(jacobian, axis=0)
    width = np.where(np.isfinite(model.high), model.high - model.low, 1.0)
    at_bound = np.minimum(x - model.low, model.high - x) < 1e-6 * width
    idle = size <= 1e-10 * max(size[-1], 1e-300)
    active = ~(at_bound | idle)
    weak = active & (np.linalg.cond(jacobian[:, active] / size[active]) >= 1e7)
    widening, correlation = _drift(residual, k)
    systematic = correlation > 0.5 or _correlation(residual, 3.0) != 0.0
    systematic |= bool(absolute and special.chdtrc(n - k, squares) < _IMPROBABLE)
    systematic |= not absolute and float(np.max(model.sigma)) > MOST_UNEVEN * model.scale
    predicted, unit = model.displacement(x), np.append(np.ones(k - 1), model.scale)
    misfit = float(np.sqrt(np.mean((model.measured - predicted) ** 2)))
    systematic &= misfit > 1e-9 * np.ptp(model.measured)  # below it is rounding: a law of points without noise
    variance, widening = (1.0, 1.0) if absolute else (squares / (n - k), widening)
    if falls := _falls_of_sorted(model.measured, model.force):
        notes.append(SORTED.format(falls, n - 1))
    if systematic:
        notes.append(SYSTEMATIC)
    if systematic and correlation < 0.0:
        notes.append(ALTERNATING)
    if not systematic:
        notes += _outliers(model, residual)
    solution = _Solution(x, squares, jacobian, variance, widening, at_bound, idle, weak)
    errors, ends, covariance = _intervals(model, solution, width, absolute)
    estimates = _estimates(model, solution, errors, ends)
    share = estimates["modulus"].value / float(model.contact.modulus) if "modulus" in estimates else 1.0
    if not 0.02 < share < 50.0:
        notes.append(f"the fitted modulus is {share:.2g} times the given one: give displacement in m and force in N")
    law, aicc = model.law(x), _aicc(model, squares, k, absolute)
    loads = model.force - model.values(x).get(FORCE_ZERO, 0.0)
    noise = 0.0 if systematic else float(np.min(model.sigma)) * math.sqrt(variance)
    law.measured = Measured(float(np.min(loads)), float(np.max(loads)), noise)
    chi_squared, covariance = squares / (n - k) if absolute else math.nan, covariance * np.outer(unit, unit)
    facts = estimates, covariance, (*model.free, ZERO), misfit, aicc, 0.0, 1.0, chi_squared, law, predicted, tuple(notes)
    return Fit(law.name, model.unloading, *facts, systematic)


def _intervals(model, solution, width, absolute):
    """Standard errors, ends of the intervals, and covariance, in the fitted coordinates."""
    from scipy import special

    x, jacobian, (n, k) = solution.x, solution.jacobian, solution.jacobian.shape
    size, active = np.linalg.norm(jacobian, axis=0), ~(solution.at_bound | solution.idle)
    covariance = np.full((k, k), np.nan)
    if not np.any(solution.weak):
        inverse = np.linalg.pinv(jacobian[:, active] / size[active]) / size[active, None]
        covariance[np.ix_(active, active)] = solution.variance * solution.widening**2 * inverse @ inverse.T
    half = 0.5 + 0.5 * _CONFIDENCE
    quantile = float(special.ndtri(half) if absolute else special.stdtrit(n - k, half))
    errors = np.sqrt(np.diag(covariance))
    ends = np.array([x - quantile * errors, x + quantile * errors]).T
    outside = ~((ends[:, 0] > model.low) & (ends[:, 1] < model.high))
    if solution.variance > 0.0 and np.any(outside):
        # near the end of a range the likelihood is not a parabola, for this quantity and those correlated with it
        steps = np.where(np.isfinite(errors) & (errors > 0.0), 2.0 * errors, 0.02 * width)
        steps = np.minimum(steps, model.high - model.low)
        limit = quantile * math.sqrt(solution.variance) * solution.widening
        for i in np.flatnonzero(outside if np.all(solution.idle[outside]) else np.ones(k, bool)):
            ends[i] = model.profile(x, solution.squares, i, float(steps[i]), limit)
    if solution.variance > 0.0:
        _open_without_joint(model, solution, ends, quantile**2 * solution.variance * solution.widening**2)
    return errors, ends, covariance


def _open_without_joint(model, solution, ends, most):
    """Open the interval of the quantity that moves the joint of the curve (a yield pressure) to an end of its range where the
    sum of squares there is larger by less than `most`: between, it may be larger, with a joint among the points."""
    index = model.joint_index(solution.x)
    for side, bound in enumerate(() if index is None else (model.low[index], model.high[index])):
        other = solution.x.copy()
        other[index] = bound
        if model.solve(other, index, 1e-8, 60)[1] < solution.squares + most:
            ends[index, side] = bound


def _estimates(model, solution, errors, ends):
    """Name → `Estimate`, in SI."""
    stopped, estimates = ends == np.stack([model.low, model.high], 1), {}
    for i, name in enumerate((*model.free, ZERO)):
        causes = WEAK, "at its bound", "without effect on these points"
        holds = solution.weak[i], solution.at_bound[i], solution.idle[i]
        cause = next((cause for cause, one in zip(causes, holds, strict=True) if one), "")
        open_end = "both" if np.all(stopped[i]) else ""
        if not open_end and name not in _ENDS and np.any(stopped[i]):
            open_end = "lower" if stopped[i][0] else "upper"
        unit = model.scale if name == ZERO else 1.0
        value, error, lower, upper = (float(v * unit) for v in (solution.x[i], errors[i], *ends[i]))
        if name != ZERO and model.parameters[name].logarithmic:
            with np.errstate(over="ignore"):
                value, lower, upper = (float(np.exp(v)) for v in (value, lower, upper))
            error *= value
        estimates[name] = Estimate(value, error, lower, upper, cause, open_end)
    return estimates


def _aicc(model, squares, count, absolute):
    """Akaike's criterion, corrected for few points: Gaussian likelihood, with the scatter as one more parameter if unknown."""
    n = model.force.size
    if absolute:
        minus_two_log = squares + 2.0 * float(np.sum(np.log(model.sigma))) + n * math.log(2.0 * math.pi)
    else:
        # points without any noise would have an infinite likelihood
        likely = model.sigma * max(math.sqrt(squares / n), 1e-15)
        minus_two_log = 2.0 * float(np.sum(np.log(likely))) + n * (math.log(2.0 * math.pi) + 1.0)
        count = count + 1 + (np.ptp(model.sigma) > 0.0)
    correction = 2.0 * count * (count + 1.0) / (n - count - 1.0) if n > count + 1 else math.inf
    return minus_two_log + 2.0 * count + correction
