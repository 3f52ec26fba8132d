"""Laws fitted to measured points: parameters with intervals, and a ranking of the laws.

The points are a history of (displacement, force), loading and unloading in any order. A law predicts the overlap at each
force from the largest force before it. The displacement at first touch ("zero") is a free parameter. The noise is that of
the displacement; noise of the force is converted with the stiffness (effective variance). Laws are ranked by Akaike's
information criterion, corrected for few points (AICc). The apparatus may be compliant: `compliance` [m/N] times the force
adds to the displacement, known or fitted.
"""

import copy
import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from demlaws.contact import Contact
from demlaws.core import cache, loops
from demlaws.core.history import history as forces_history
from demlaws.core.unloading import GIVEN
from demlaws.errors import DemlawsError, quiet
from demlaws.law import Law
from demlaws.laws.definition import OF_CONTACT, Parameter
from demlaws.laws.registry import find, registry
from demlaws.make import law as bind_law
from demlaws.points import columns_of, in_contact, refuse_other_units
from demlaws.results import Tabular
from demlaws.units import number

ZERO = "zero"
COMPLIANCE = "compliance"
"""The only fitted quantity of the apparatus, not of a law."""
_COMPLIANCE = Parameter("m/N", False, lambda c: (0.0, 1e-4), lambda c: [0.0])
_ENDS = {"fractal_dimension", COMPLIANCE}
"""Quantities with a natural end of their range (2 ≤ Df ≤ 3, compliance ≥ 0), not one of the search."""
_CONFIDENCE = 0.95
_DECISIVE = 10.0  # decrease of AICc from which a note mentions a fixed quantity
_STEP = 1e-4  # of the derivatives, in the fitted coordinates: mostly logarithms
_FAMILY_PART = 0.7  # of ln(roughness), for which one family of solved curves is prepared


def parameters():
    """Name → `Parameter` of every quantity that a fit of some law may vary."""
    tables = [definition.fitting.parameters for definition in registry().values()]
    return {**OF_CONTACT, COMPLIANCE: _COMPLIANCE, **{n: one for quantities in tables for n, one in quantities.items()}}


def __getattr__(name):
    """`PARAMETERS`: `parameters()` of the laws that are registered now."""
    if name == "PARAMETERS":
        return parameters()
    raise AttributeError(name)


class Estimate(NamedTuple):
    """A fitted value, SI. low and high: 95 % interval.

    From Student's t in the fitted coordinate. If a quantity lies at or near the end of its range, all intervals of that law
    come from the profile likelihood. If the deviations of neighbouring points are correlated (drift, or a wrong law), the
    intervals are widened: `Fit.notes`. `note` reports an interval that ends at the limit of the search.
    """

    value: float
    error: float  # standard error; nan if the points do not determine it
    low: float
    high: float
    note: str = ""


class Fit(NamedTuple):
    """One fitted law."""

    name: str
    unloading: str
    parameters: dict  # name → Estimate; "zero" is the displacement [m] at first touch
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

    @property
    def contact(self) -> Contact:
        """Contact with the fitted quantities."""
        return self.law.contact


class Ranking(Tabular, list):
    """Fits from the best to the worst, and the laws that were not fitted; `print(ranking)` shows them as a table."""

    def __init__(self, fits, skipped, points):
        super().__init__(fits)
        self.skipped = skipped  # law or points left out → reason
        self.points = points  # displacement and force of the points used, in their order

    @property
    def best(self) -> Fit:
        """The fit of lowest AICc, the first of the list."""
        return self[0]

    def columns(self) -> dict:
        """Law, unloading, misfit, ΔAICc, weight and parameters, each a list."""
        titles = {"law": "name", "unloading": "unloading", "misfit (m)": "misfit", "ΔAICc": "delta", "weight": "weight"}
        columns = {title: [getattr(fit, name) for fit in self] for title, name in titles.items()}
        texts = ["; ".join(f"{n} {e.value:.4g}" for n, e in fit.parameters.items()) for fit in self]
        return {**columns, "parameters": texts}

    __repr__ = Tabular.__str__


def history(law, force):
    """Overlap [m] and tangent stiffness [N/m] at each force > 0 [N] of a history that starts with first loading."""
    return forces_history(law.unloads.rule, law.params, np.array(force, float))


# --- one law


class _Model:
    """A law with free quantities. Coordinates are these (ln of positive ones) and, last, the zero in units of `scale`."""

    def __init__(self, name, rule, free, contact, options, displacement, force, noise):
        self.definition, self.unloading, self.free = find(name), rule, tuple(free)
        self.rule = self.definition.rule(rule)
        self.parameters = {**OF_CONTACT, COMPLIANCE: _COMPLIANCE, **self.definition.fitting.parameters}
        fill = {}
        for field in self.definition.needed(**options):
            if getattr(contact, field) is None:
                if field not in free:
                    raise DemlawsError(f"{name} needs the contact's {field}: give it, or fit it")
                fill[field] = float(OF_CONTACT[field].starts(contact)[0])
        self.contact = contact.with_values(**fill)
        unseen = {n: one for n, one in self.definition.fitting.parameters.items() if one.unloading and n not in free}
        self.options = {n: float(np.ravel(one.starts(self.contact))[0]) for n, one in unseen.items()} | dict(options)
        self.measured, self.force = displacement, force
        self.scale = float(np.ptp(displacement)) or float(np.max(np.abs(displacement))) or 1.0
        self.sigma = np.full(force.size, noise or self.scale)
        ends = [self._coordinate(n, self.parameters[n].bounds(self.contact)) for n in free]
        self.low, self.high = np.array([*ends, (-np.inf, np.inf)]).T
        # a law whose curve is solved: families of curves over parts of the roughness, in place of a solution for each trial
        self.families = {} if set(self.definition.fitting.family) & {"roughness"} & set(free) else None

    def _coordinate(self, name, value):
        return np.log(value) if self.parameters[name].logarithmic else np.asarray(value, float)

    def values(self, x):
        """Name → value of the free quantities."""
        return {n: math.exp(v) if self.parameters[n].logarithmic else float(v) for n, v in zip(self.free, x, strict=False)}

    def inputs(self, x):
        """Contact and options of the law. The bounds guarantee admissible values: they are not checked for each trial."""
        contact, options = copy.copy(self.contact), dict(self.options)
        for name, value in self.values(x).items():
            if self.parameters[name].option:
                options[name] = value
            elif name != COMPLIANCE:
                contact.__dict__[name] = value
        return contact, options

    def shape(self, contact, options):
        """Shape of the law for a trial."""
        if self.families is None:
            return self.definition.prepare(contact, **options)
        part = math.floor(math.log(contact.roughness) / _FAMILY_PART)
        key = part, contact.modulus, contact.hardness
        if key not in self.families:
            ends = np.minimum(np.exp(_FAMILY_PART * np.array([part, part + 1.0])), 0.1 * contact.radius)
            many = contact.with_values(radius=np.full(2, contact.radius), roughness=ends)
            self.families[key] = self.definition.prepare(many, **{"rtol": 2e-3, **options})
        return self.families[key]

    def overlap(self, x):
        """Overlap [m] and tangent stiffness [N/m] at each force."""
        contact, options = self.inputs(x)
        params = loops.bind_params(self.shape(contact, options), contact)
        overlap, stiffness = forces_history(self.rule, params, self.force)
        # outside the range of a curve: far away, not NaN
        return np.where(np.isfinite(overlap), overlap, 1e3 * contact.radius), stiffness

    def displacement(self, x):
        """Displacement [m] at each force, apparatus included."""
        return self.overlap(x)[0] + self.values(x).get(COMPLIANCE, 0.0) * self.force + x[-1] * self.scale

    def residual(self, x):
        return (self.measured - self.displacement(x)) / self.sigma

    def jacobian(self, x):
        """Derivatives of `residual`: central differences for quantities of the law, exact for those of the apparatus."""
        columns = []
        for i, name in enumerate(self.free):
            if name == COMPLIANCE:
                columns.append(self.force)
                continue
            ends = np.array([x, x])
            ends[:, i] = np.clip(x[i] + np.array([-_STEP, _STEP]), self.low[i], self.high[i])
            columns.append((self.overlap(ends[1])[0] - self.overlap(ends[0])[0]) / (ends[1, i] - ends[0, i]))
        return -np.column_stack([*columns, np.full(self.force.size, self.scale)]) / self.sigma[:, None]

    def starts(self, most=4):
        """The best starting points, one for each value of the last quantity: a yield pressure above all loads has no slope."""
        choices = []
        for name, low, high in zip(self.free, self.low, self.high, strict=False):
            margin = 1e-9 * (high - low)
            start = self._coordinate(name, np.atleast_1d(self.parameters[name].starts(self.contact)))
            start = start[:1] if self.families is not None else start  # a solved curve costs as much as hundreds of trials
            choices.append(np.clip(start, low + margin, high - margin))
        best = {}
        for values in itertools.product(*choices):
            x = np.array([*values, 0.0])
            x[-1] = np.average(self.residual(x) * self.sigma, weights=self.sigma**-2.0) / self.scale
            cost = float(np.sum(self.residual(x) ** 2))
            key = values[-1] if values else 0.0
            if cost < best.get(key, (math.inf,))[0]:
                best[key] = cost, x
        return [x for _, x in sorted(best.values(), key=lambda pair: pair[0])[:most]]

    def solve(self, x, fixed=None, tolerance=1e-12, steps=None):
        """(x, sum of squares) of the least squares from `x`, with all coordinates free or all but one."""
        from scipy.optimize import least_squares

        free, whole = np.arange(x.size) != fixed, x.copy()

        def at(part):
            whole[free] = part
            return whole

        solution = least_squares(
            lambda part: self.residual(at(part)),
            np.clip(x[free], self.low[free], self.high[free]),
            jac=lambda part: self.jacobian(at(part))[:, free],
            bounds=(self.low[free], self.high[free]),
            x_scale="jac",
            **dict.fromkeys(("xtol", "ftol", "gtol"), tolerance),
            max_nfev=steps,
        )
        return at(solution.x).copy(), 2.0 * float(solution.cost)

    def minimise(self):
        """Least squares from several starts; only the two most promising ones run to the end."""
        trials = sorted((self.solve(x, steps=6) for x in self.starts()), key=lambda trial: trial[1])
        return min((self.solve(x) for x, cost in trials[:2] if cost <= 1.5 * trials[0][1]), key=lambda trial: trial[1])

    def profile(self, x, least, index, step, limit):
        """Ends of the interval of coordinate `index` in which the least sum of squares stays below `least` + `limit`²."""
        from scipy.optimize import brentq

        ends = []
        for bound in (self.low[index], self.high[index]):
            points = {x[index]: (-limit, x)}

            def excess(place, points=points):
                if place not in points:
                    start = points[min(points, key=lambda other: abs(other - place))][1].copy()
                    start[index] = place
                    start, cost = self.solve(start, index, 1e-6, 40)
                    away = math.sqrt(max(cost - least, 0.0)) - limit
                    points[place] = away if abs(away) > 0.005 * limit else 0.0, start
                return points[place][0]

            near, place, width = x[index], x[index], math.copysign(step, bound - x[index])
            while place != bound and excess(place) < 0.0:
                near, place = place, (min if width > 0.0 else max)(place + width, bound)
                width *= 2.0
            if near != place and excess(place) >= 0.0:
                # where the least sum of squares jumps, no place has the limit
                place = brentq(excess, near, place, xtol=1e-3 * abs(place - near))
            ends.append(place)
        return ends


def _fit_law(model, displacement_noise, force_noise):
    # the stiffness that converts force noise comes from the fit itself: two more rounds
    x, squares = model.minimise()
    if displacement_noise is not None and force_noise:
        for _ in range(2):
            model.sigma = np.hypot(displacement_noise, force_noise / model.overlap(x)[1])
            x, squares = model.minimise()
    notes = []
    if displacement_noise is None and not _correlation(model.residual(x)):
        for _ in range(2):
            stiffness = model.overlap(x)[1]
            model.sigma = model.scale * np.hypot(1.0, _noise_ratio(model, x, stiffness) / stiffness)
            x, squares = model.solve(x)
        uneven = float(np.max(model.sigma)) / model.scale
        if uneven > 2.0:
            notes.append(
                f"the points scatter up to {uneven:.2g} times as much where the contact is soft, as with noise of the force: "
                "they are weighted accordingly; such intervals, nominally 95 %, held the true value in 81 to 98 % of tests: "
                "give force_noise and displacement_noise if known"
            )
    return _report(model, x, squares, displacement_noise is not None, notes)


def _correlation(residual):
    """Correlation of neighbouring residuals; 0 unless it is significant (2.5 %)."""
    spread = float(np.sum(residual**2))
    correlation = float(np.sum(residual[1:] * residual[:-1])) / spread if spread > 0.0 else 0.0
    return correlation if correlation > 2.0 / math.sqrt(residual.size) else 0.0


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
    if correlation:
        correlation = min(correlation + (1.0 + (count + 3.0) * correlation) / residual.size, 0.95)
    return math.sqrt((1.0 + correlation) / (1.0 - correlation)), correlation


def _report(model, x, squares, absolute, notes):
    """The `Fit` of a solution: intervals, notes, AICc."""
    from scipy import special

    n, k = model.force.size, x.size
    low, high, jacobian, residual = model.low, model.high, model.jacobian(x), model.residual(x)
    variance = 1.0 if absolute else squares / (n - k)
    # a quantity at its bound, or without effect, is left out of the covariance
    size = np.linalg.norm(jacobian, axis=0)
    width = np.where(np.isfinite(high), high - low, 1.0)
    at_bound = np.minimum(x - low, high - x) < 1e-6 * width
    idle = size <= 1e-10 * max(size[-1], 1e-300)
    active = ~(at_bound | idle)
    weak = active & (np.linalg.cond(jacobian[:, active] / size[active]) >= 1e7)
    widening, correlation = (1.0, 0.0) if absolute else _drift(residual, k)
    if correlation > 0.5:
        cause = f"the misfit is systematic or drifts (correlation of neighbours {correlation:.2f}), it is not scatter"
        notes.append(f"{cause}: intervals are {widening:.1f} times as wide as for scatter; they do not hold for a wrong law")
    covariance = np.full((k, k), np.nan)
    if not np.any(weak):
        inverse = np.linalg.pinv(jacobian[:, active] / size[active]) / size[active, None]
        covariance[np.ix_(active, active)] = variance * widening**2 * inverse @ inverse.T
    half = 0.5 + 0.5 * _CONFIDENCE
    quantile = float(special.ndtri(half) if absolute else special.stdtrit(n - k, half))
    errors = np.sqrt(np.diag(covariance))
    ends = np.array([x - quantile * errors, x + quantile * errors]).T
    outside = ~((ends[:, 0] > low) & (ends[:, 1] < high))
    if variance > 0.0 and np.any(outside):
        # near the end of a range the likelihood is not a parabola, for this quantity and those correlated with it
        steps = np.minimum(np.where(np.isfinite(errors) & (errors > 0.0), 2.0 * errors, 0.02 * width), high - low)
        limit = quantile * math.sqrt(variance) * widening
        for i in np.flatnonzero(outside if np.all(idle[outside]) else np.ones(k, bool)):
            ends[i] = model.profile(x, squares, i, float(steps[i]), limit)
    stopped = ends == np.stack([low, high], 1)
    unit = np.append(np.ones(k - 1), model.scale)
    estimates, coordinates = {}, (*model.free, ZERO)
    for i, name in enumerate(coordinates):
        causes = "not separately identifiable from these points", "at its bound", "without effect on these points"
        note = next((cause for cause, holds in zip(causes, (weak, at_bound, idle), strict=True) if holds[i]), "")
        if np.all(stopped[i]):
            note = "not determined" + (f": {note}" if note else "")
        elif name not in _ENDS and np.any(stopped[i]):
            note = f"the points give no {'lower' if stopped[i][0] else 'upper'} end" + (f", {note}" if note else "")
        value, error, lower, upper = (float(v * unit[i]) for v in (x[i], errors[i], *ends[i]))
        if name != ZERO and model.parameters[name].logarithmic:
            with np.errstate(over="ignore"):
                value, lower, upper = (float(np.exp(v)) for v in (value, lower, upper))
            error *= value
        estimates[name] = Estimate(value, error, lower, upper, note)
    share = estimates["modulus"].value / float(model.contact.modulus) if "modulus" in estimates else 1.0
    if not 0.02 < share < 50.0:
        notes.append(f"the fitted modulus is {share:.2g} times the given one: give displacement in m and force in N")
    predicted = model.displacement(x)
    misfit = float(np.sqrt(np.mean((model.measured - predicted) ** 2)))
    # Gaussian likelihood: with known noise, or with the scatter as one more parameter
    if absolute:
        minus_two_log = squares + 2.0 * float(np.sum(np.log(model.sigma))) + n * math.log(2.0 * math.pi)
        count = k
    else:
        # points without any noise would have an infinite likelihood
        likely = model.sigma * max(math.sqrt(squares / n), 1e-15)
        minus_two_log = 2.0 * float(np.sum(np.log(likely))) + n * (math.log(2.0 * math.pi) + 1.0)
        count = k + 1 + (np.ptp(model.sigma) > 0.0)
    aicc = minus_two_log + 2.0 * count + (2.0 * count * (count + 1.0) / (n - count - 1.0) if n > count + 1 else math.inf)
    with quiet():
        contact, options = model.inputs(x)
        # checked now: refuses a pair that is not passive
        law = bind_law(model.definition.name, contact.with_values(), model.unloading, **options)
    chi_squared, covariance = squares / (n - k) if absolute else math.nan, covariance * np.outer(unit, unit)
    facts = estimates, covariance, coordinates, misfit, aicc, 0.0, 1.0, chi_squared, law, predicted, tuple(notes)
    return Fit(law.name, model.unloading, *facts)


# --- all laws


def fit(
    points: ArrayLike,
    contact: Contact,
    laws: str | Sequence[str] | None = None,
    unloading: str | Sequence[str] | None = None,
    free: Sequence[str] | None = None,
    options: dict | None = None,
    displacement_noise: float | None = None,
    force_noise: float = 0.0,
    compliance: float = 0.0,
    progress: Callable = iter,
) -> Ranking:
    """Fit laws to measured points and rank them by Akaike's criterion.

    Parameters
    ----------
    points : array_like, shape (n, 2), or Points
        Displacement [m] and force [N] in the order of the test.
    contact : Contact
        Known quantities, and starting values of the fitted ones.
    laws : str or sequence of str, optional
        Names of laws. Default: all laws without a height map whose parameters such a test determines.
    unloading : str or sequence of str, optional
        Unloading rules. Default: each rule of the law if the points unload, else "elastic".
    free : sequence of str, optional
        Names of the fitted quantities among `fit.PARAMETERS`; [] for none. Default: `Definition.free`.
    options : dict, optional
        Name of the law → fixed options.
    displacement_noise : float, optional
        Standard deviation of the displacement [m]. Default: from the scatter of the points about the law.
    force_noise : float
        Standard deviation of the force [N].
    compliance : float
        Compliance of the apparatus [m/N], subtracted from the displacement; to fit it, name "compliance" in `free`.
    progress : callable
        Wraps the list of fits, like tqdm.

    Returns
    -------
    Ranking
        Fits from the best to the worst; `.skipped` lists points and laws that are not used.

    Raises
    ------
    DemlawsError
        For points that determine nothing.

    Notes
    -----
    If another E* or a compliance would explain the pattern of the best law's misfit, the notes of the fit mention it.

    Examples
    --------
    >>> pair = dl.Contact(radius=4e-3, modulus=32e9)
    >>> path = dl.driver.force_controlled(dl.law("hertz", pair), [50.0], steps=30)
    >>> points = [(x, p) for x, p in zip(path.overlap, path.force)][1:]
    >>> best = dl.fit(points, pair.with_values(modulus=20e9), laws="hertz", free=["modulus"]).best
    >>> round(best.contact.modulus / 1e9, 3)
    32.0
    """
    if not isinstance(contact, Contact) or contact.size is not None:
        raise DemlawsError("contact must be one demlaws.Contact: that of the test")
    displacement, force = columns_of(points)
    usual = [n for n, definition in registry().items() if definition.fitting.identifiable and not definition.needs_map]
    names = [find(n).name for n in _texts(laws, "laws") or usual]
    free, rules, options = _texts(free, "free"), _texts(unloading, "unloading"), _checked_options(options or {})
    if displacement_noise is not None:
        displacement_noise = number(displacement_noise, "displacement_noise", "m", 1e-13, 1e-2, allow_low=True)
    force_noise = number(force_noise, "force_noise", "N", allow_low=True)
    if force_noise and displacement_noise is None:
        raise DemlawsError("force_noise needs displacement_noise [m] beside it: only their ratio weights the points")
    displacement = displacement - number(compliance, "compliance", "m/N", 0.0, 1e-3, allow_low=True) * force
    keep, skipped = in_contact(force, force_noise)
    displacement, force = displacement[keep], force[keep]
    quantities = parameters()
    if unknown := [n for n in free or () if n not in quantities]:
        raise DemlawsError(f"cannot fit {', '.join(unknown)}: the quantities that a fit can vary are {', '.join(quantities)}")
    if force.size:
        refuse_other_units(displacement, force, contact, _COMPLIANCE.bounds(contact)[1] if COMPLIANCE in (free or ()) else 0.0)
    jobs = list(_jobs(names, rules, free, force))

    def run(job):
        name, rule, variables = job
        model = _Model(name, rule, variables, contact, options.get(name, {}), displacement, force, displacement_noise)
        return _fit_law(model, displacement_noise, force_noise)

    def fit_or_reason(job):
        try:
            return run(job)
        except DemlawsError as error:
            return str(error)

    outcomes = list(cache.shared(jobs, fit_or_reason, progress))
    fits = [one for one in outcomes if isinstance(one, Fit)]
    failed = {
        name if rule == "elastic" else f"{name}, {rule} unloading": one
        for (name, rule, _), one in zip(jobs, outcomes, strict=True)
        if not isinstance(one, Fit)
    }
    if not fits:
        raise DemlawsError("no law could be fitted: " + "; ".join(f"{k}: {v}" for k, v in failed.items()))
    fits.sort(key=lambda f: f.aicc)
    fits[0] = fits[0]._replace(notes=(*fits[0].notes, *_suspicions(fits[0], run, contact, displacement)))
    relative = [math.exp(-0.5 * (f.aicc - fits[0].aicc)) for f in fits]
    ranking = [f._replace(delta=f.aicc - fits[0].aicc, weight=w / sum(relative)) for f, w in zip(fits, relative, strict=True)]
    return Ranking(ranking, failed | skipped, (displacement, force))


def _jobs(names, rules, free, force):
    """(law, rule, free quantities) of each fit."""
    # the curve of rule "table" has no parameters of the law
    available = [rule for rule in dict.fromkeys(r for name in names for r in find(name).offered()) if rule != GIVEN]
    if unknown := [rule for rule in rules or () if rule not in available]:
        raise DemlawsError(f"unknown unloading rule {unknown[0]!r}: the rules that a fit takes are {', '.join(available)}")
    unloads = np.any(force < 0.98 * np.maximum.accumulate(force)) if force.size else False
    for name in names:
        definition = find(name)
        fields = definition.fitting.parameters
        variables = [
            n for n in (definition.fitting.free if free is None else free) if n in ("modulus", COMPLIANCE) or n in fields
        ]
        if force.size < len(variables) + 4:
            few = f"{force.size} points with a force above 0 (compression)"
            raise DemlawsError(f"{few}: at least {len(variables) + 4} are needed for {name}")
        for rule in rules or (definition.unloading if unloads else ("elastic",)):
            # first loading alone does not show a quantity of the unloading curve
            yield name, rule, [n for n in variables if rule != "elastic" or n not in fields or not fields[n].unloading]


def _texts(value, name):
    """None, or a list of one or several words."""
    words = [value] if isinstance(value, str) else value
    if words is not None and not (isinstance(words, list | tuple | set) and all(isinstance(one, str) for one in words)):
        raise DemlawsError(f"{name} must be a name or a list of names, got {value!r:.60}")
    return None if words is None else list(words)


def _checked_options(options):
    """Law name → options."""
    if not isinstance(options, Mapping) or not all(isinstance(one, Mapping) for one in options.values()):
        raise DemlawsError(f"options must be {{law: {{option: value}}}}, got {options!r:.60}")
    return {find(name).name: one for name, one in options.items()}


def _suspicions(best, run, contact, displacement):
    """Notes on fixed quantities that explain a pattern of the misfit: E*, and the compliance of the apparatus."""
    misfit = displacement - best.displacement
    spread = float(np.sum(misfit**2))
    if best.law.definition.solved or not float(np.sum(misfit[1:] * misfit[:-1])) > 1.7 / math.sqrt(misfit.size) * spread > 0.0:
        return
    variables = [name for name in best.coordinates if name != ZERO]
    wrong = f"speaks against the given E* = {contact.modulus * 1e-9:.4g} GPa"
    hints = {
        "modulus": (1e-9, "GPa", wrong, "fit the modulus, too"),
        COMPLIANCE: (1e6, "µm/N", "a compliant apparatus makes", "measure the compliance and give it, or fit it, too"),
    }
    for name, (unit, symbol, meaning, remedy) in hints.items():
        if name in variables:
            continue
        try:
            other = run((best.name, best.unloading, [*variables, name]))
        except DemlawsError:
            continue
        value, low, high = (other.parameters[name][n] * unit for n in (0, 2, 3))
        if value > 0.0 and other.aicc < best.aicc - _DECISIVE:
            fall = f"from {best.misfit * 1e6:.3g} to {other.misfit * 1e6:.3g} µm"
            interval = f"{value:.4g} {symbol} [{low:.4g}, {high:.4g}]"
            yield f"the misfit has a pattern that {meaning}: with {interval} it falls {fall}; {remedy}"
