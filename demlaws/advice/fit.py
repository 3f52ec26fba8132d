"""Laws fitted to measured points: parameters with uncertainty, and which law the points speak for.

The points are a history of (displacement, force), loading and unloading in any order. A law predicts the overlap of
each force, given the largest force before it; the displacement at which the bodies first touch is a free parameter, so
that the zero of the measurement does not matter. Noise is taken as that of the displacement; noise of the force enters
through the stiffness (effective variance). Laws are ranked by Akaike's information criterion, corrected for few points.
The apparatus may give way as a spring: `compliance` [m/N] times the force adds to the displacement, known or fitted.
"""

import itertools
import math
import warnings
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from demlaws.contact import Contact
from demlaws.core.loops import evaluate_loop, inverse_loop, unloaded_loop
from demlaws.core.params import loading_part
from demlaws.core.unloading import GIVEN
from demlaws.curves.closed import ClosedForm
from demlaws.errors import DemlawsError, ValidityWarning
from demlaws.law import Law
from demlaws.laws.definition import OF_CONTACT, Parameter
from demlaws.laws.registry import find, registry
from demlaws.make import law as bind_law
from demlaws.units import LARGEST_OVERLAP, number, unmasked
from demlaws.unloading import Unloading

ZERO = "zero"
COMPLIANCE = "compliance"
"""The one quantity of the apparatus, not of a law, that can be fitted."""
_COMPLIANCE = Parameter("m/N", False, lambda c: (0.0, 1e-4), lambda c: [0.0])
_ENDS = {"fractal_dimension", COMPLIANCE}
"""Quantities whose range ends by nature (2 ≤ Df ≤ 3, no negative compliance), not where the search does."""
_CONFIDENCE = 0.95
_DECISIVE = 10.0  # fall of AICc from which a quantity that was kept fixed is mentioned
_NOISE_WIDTHS = 3.0  # of a load cell: a force below so many standard deviations may be no force


def parameters():
    """Name → `Parameter` of every quantity that some law lets a fit vary."""
    return {
        **OF_CONTACT,
        COMPLIANCE: _COMPLIANCE,
        **{name: one for definition in registry().values() for name, one in definition.fitting.parameters.items()},
    }


def __getattr__(name):
    """`PARAMETERS`, `parameters()` of the laws that are registered when it is asked for."""
    if name == "PARAMETERS":
        return parameters()
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


_FAMILY_SPAN = 12.0  # Yip-Venart's curves are solved once over this factor of roughness either way


class Estimate(NamedTuple):
    """A fitted value, SI. low and high: 95 % interval.

    By Student's t in the fitted coordinate; where a quantity of the law lies at or near the end of its range, all
    intervals of that law are those of the profile likelihood: the values at which the points, with all else fitted
    anew, would be as unlikely as the interval's confidence says. An end that is the end of the range is not told by the
    points; where both are, `note` says "not determined".
    """

    value: float
    error: float  # standard error; nan where the points do not determine it
    low: float
    high: float
    note: str = ""


class Fit(NamedTuple):
    """One law, fitted."""

    name: str
    unloading: str
    parameters: dict  # name → Estimate; "zero" is the displacement [m] at which the bodies touch
    covariance: np.ndarray  # of the fitted coordinates: ln(value) of positive quantities, else the value
    coordinates: tuple  # names, in the order of covariance
    misfit: float  # root mean square difference in displacement [m]
    aicc: float
    delta: float  # aicc less the best law's
    weight: float  # Akaike weight: probability of being the best of the laws tried
    chi_squared: float  # per degree of freedom, where the noise was given; else nan
    law: Law
    displacement: np.ndarray  # predicted [m], for each point used
    notes: tuple

    @property
    def contact(self) -> Contact:
        """Contact with the fitted quantities."""
        return self.law.contact


class Ranking(list):
    """Fits from the best to the worst, with what was left aside."""

    def __init__(self, fits, skipped, points):
        super().__init__(fits)
        self.skipped = skipped  # name → reason
        self.points = points  # displacement and force of the points used, in their order

    @property
    def best(self) -> Fit:
        """The fit of lowest AICc; the list's first."""
        return self[0]


def history(law, force):
    """Overlap [m] and tangent stiffness [N/m] at each force > 0 [N] of a history that starts on a virgin contact."""
    peak = np.maximum.accumulate(force)
    top, load, stiffness = (np.empty(force.size) for _ in range(3))
    inverse_loop(loading_part(law.params), peak, top)
    state = law.new_state(force.size)
    evaluate_loop(law.rule, law.params, top, state.arrays, load, stiffness)
    overlap = np.empty(force.size)
    unloaded_loop(law.rule, law.params, force, state.arrays, overlap)
    overlap = np.where(force < peak, overlap, top)
    # below a seating load the curve goes on to overlaps under 0, where `evaluate` sees no contact
    evaluate_loop(law.rule, law.params, np.maximum(overlap, 1e-300), state.arrays, load, stiffness)
    return overlap, stiffness


def _arrays(points):
    """Displacement and force of (n, 2) values or granite.Points, without the points that carry no force."""
    if hasattr(points, "displacement"):
        displacement, force = (np.asarray(unmasked(one), float) for one in (points.displacement, points.force))
    else:
        try:
            array = np.asarray(unmasked(points), dtype=float)
        except (TypeError, ValueError):
            raise DemlawsError("points must be numbers: an array of shape (n, 2), displacement in m and force in N") from None
        if array.ndim != 2 or array.shape[1] != 2:
            raise DemlawsError(f"points have shape {array.shape}: give (n, 2), displacement in m and force in N")
        displacement, force = array.T
    if not (np.all(np.isfinite(displacement)) and np.all(np.isfinite(force))):
        raise DemlawsError("points contain NaN or infinite values: remove those rows")
    return displacement, force


def _refuse_other_units(displacement, force, contact, give):
    """An error for points in contact that no law can follow: in other units, columns exchanged, or of the other sign.

    give: how far the apparatus may give way [m/N]."""
    travel, most = np.ptp(displacement), LARGEST_OVERLAP * contact.radius + give * np.ptp(force)
    if travel > most:
        raise DemlawsError(
            f"points in contact lie {travel:.3g} m apart, more than the effective radius R = {contact.radius:g} m, beyond "
            "which no law answers: give displacement in m, first, and force in N, without points from before contact"
        )
    if travel > 0.0 and np.ptp(force) > 0.0 and np.corrcoef(displacement, force)[0, 1] < -0.5:
        raise DemlawsError("the displacement falls where the force rises: count the approach of the bodies as positive, in m")


def _in_contact(displacement, force, noise):
    """The points that are in contact, why the others were left out (or None), and the noise of the force [N].

    A force at or below 0 can only be noise or no contact. From the negative forces comes the noise of the load cell,
    unless it is known; before first contact about half of the points carry a positive force by chance, and a single one,
    far from where the bodies meet, tilts the whole fit. What lies below three standard deviations is left out, and on
    first loading everything before the last such point.
    """
    negative = force[force < 0.0]
    known = noise > 0.0
    if not known and negative.size >= 3:
        noise = float(np.sqrt(np.mean(negative**2)))
    keep = force > _NOISE_WIDTHS * noise
    if noise > 0.0 and np.any(keep):
        first = int(np.argmax(force > 0.1 * np.max(force)))
        keep[: np.max(np.flatnonzero(~keep[:first]), initial=-1) + 1] = False
    dropped = int(np.sum(~keep))
    if not dropped:
        return keep, None, noise
    reason = "they carry no force: any displacement before contact fits them"
    if noise > 0.0:
        said = "given" if known else f"from {negative.size} negative forces"
        reason = f"they may be no contact: before it or below {_NOISE_WIDTHS:g} times the load cell's {noise:.2g} N ({said})"
    return keep, f"{dropped} points: {reason}", noise


class _Model:
    """A law with some quantities free: coordinates in, predicted displacement out."""

    def __init__(self, name, contact, unloading, free, options):
        self.definition = find(name)
        self.unloading, self.free = unloading, tuple(free)
        self.parameters = {**OF_CONTACT, COMPLIANCE: _COMPLIANCE, **self.definition.fitting.parameters}
        fill = {}
        for field in self.definition.needed(**options):
            if getattr(contact, field) is None:
                if field not in free:
                    raise DemlawsError(f"{name} needs the contact's {field}: give it, or let it be fitted")
                fill[field] = float(OF_CONTACT[field].starts(contact)[0])
        self.contact = contact.with_values(**fill)
        unseen = {n: one for n, one in self.definition.fitting.parameters.items() if one.unloading and n not in free}
        self.options = {n: float(np.ravel(one.starts(self.contact))[0]) for n, one in unseen.items()} | dict(options)
        self.family = None
        if set(self.definition.fitting.family) & set(free):
            self._solve_family()

    def _solve_family(self):
        """One family of curves over the roughnesses in question, in place of a solution for each trial."""
        start = float(OF_CONTACT["roughness"].starts(self.contact)[0])
        span = np.array([start / _FAMILY_SPAN, min(start * _FAMILY_SPAN, 0.09 * self.contact.radius)])
        many = self.contact.with_values(radius=np.full(2, self.contact.radius), roughness=span)
        self.family = self.definition.prepare(many, **{"rtol": 1e-3, **self.options})
        self.span = span

    def bounds(self):
        pairs = []
        for name in self.free:
            low, high = self.parameters[name].bounds(self.contact)
            if self.family is not None and name == "roughness":
                low, high = self.span * (1.001, 0.999)
            pairs.append((math.log(low), math.log(high)) if self.parameters[name].logarithmic else (low, high))
        return np.array(pairs).reshape(-1, 2).T

    def starts(self):
        low, high = self.bounds()
        free = [self.parameters[n] for n in self.free]
        choices = [np.atleast_1d(one.starts(self.contact)).astype(float) for one in free]
        choices = [np.log(c) if one.logarithmic else c for one, c in zip(free, choices, strict=True)]
        inside = [np.clip(c, a + 1e-9 * (b - a), b - 1e-9 * (b - a)) for c, a, b in zip(choices, low, high, strict=True)]
        return [np.array(s) for s in itertools.product(*inside)]

    def values(self, coordinates):
        return {
            n: float(math.exp(x) if self.parameters[n].logarithmic else x)
            for n, x in zip(self.free, coordinates[: len(self.free)], strict=True)
        }

    def law(self, coordinates):
        values = self.values(coordinates)
        values.pop(COMPLIANCE, None)
        contact = self.contact.with_values(**{n: v for n, v in values.items() if not self.parameters[n].option})
        options = {**self.options, **{n: v for n, v in values.items() if self.parameters[n].option}}
        if self.family is not None and "hardness" not in values:
            shape = self.family
        else:
            shape = self.definition.prepare(contact, **options)
        rule = Unloading(self.definition.rule(self.unloading))
        return Law(contact, ClosedForm(self.definition, contact, options, shape), rule)

    def displacement(self, coordinates, force):
        """Displacement [m] from first touch, apparatus included, and the contact's tangent stiffness, at each force."""
        overlap, stiffness = self.overlap(coordinates, force)
        return overlap + self.values(coordinates).get(COMPLIANCE, 0.0) * force, stiffness

    def overlap(self, coordinates, force):
        overlap, stiffness = history(self.law(coordinates), force)
        bad = ~np.isfinite(overlap)
        if np.any(bad):  # out of a curve's range: far away rather than not a number
            overlap = np.where(bad, 1e3 * self.contact.radius, overlap)
        return overlap, stiffness


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
    """Fit laws to measured points and rank them: a `Ranking` of `Fit`, the best first.

    points: (n, 2) values, displacement [m] and force [N] in the order of the test, or `granite.Points`; contact: a
    `Contact` with what is known, and starting values for what is fitted; laws: names (default: all that need no height
    map, but for those whose parameters are calibrated, not measured); unloading: a rule or several (default: each that the law
    takes, if the points unload; else elastic); free: names of the fitted quantities among `fit.PARAMETERS` (default:
    `Definition.free`; none: []); options: law name → options that stay as
    they are; displacement_noise [m], force_noise [N]: standard deviations, where they are known: they then set the
    uncertainty, else the scatter of the points about the law does; compliance [m/N]: how far the apparatus gives way, taken
    off the displacement (to fit it, name "compliance" in `free`); progress: wraps the list of fits, as tqdm does.

    Points that may be no contact (no force, or one within the noise of the load cell) are left out, which `.skipped` says.
    Where the misfit of the best law has a pattern that another E* or a compliance would explain, its notes say so.

    Raises DemlawsError for points that cannot determine anything. A law that cannot be fitted is listed in `.skipped`.

    >>> pair = dl.Contact(radius=4e-3, modulus=32e9)
    >>> path = dl.driver.force_controlled(dl.law("hertz", pair), [50.0], steps=30)
    >>> points = [(x, p) for x, p in zip(path.overlap, path.force)][1:]
    >>> best = dl.fit(points, pair.with_values(modulus=20e9), laws="hertz", free=["modulus"]).best
    >>> round(best.contact.modulus / 1e9, 3)
    32.0
    """
    if not isinstance(contact, Contact) or contact.size is not None:
        raise DemlawsError("contact must be one demlaws.Contact: the one that was tested")
    displacement, force = _arrays(points)
    names = [find(n).name for n in _texts(laws, "laws") or _default_laws()]
    free, options = _texts(free, "free"), _checked_options(options)
    if displacement_noise is not None:
        displacement_noise = number(displacement_noise, "displacement_noise", "m", 1e-13, 1e-2, allow_low=True)
    force_noise = number(force_noise, "force_noise", "N", allow_low=True)
    displacement = displacement - number(compliance, "compliance", "m/N", 0.0, 1e-3, allow_low=True) * force
    if force_noise and displacement_noise is None:
        raise DemlawsError("force_noise needs displacement_noise [m] beside it: only their ratio weighs the points")
    keep, dropped, _ = _in_contact(displacement, force, force_noise)
    displacement, force = displacement[keep], force[keep]
    if force.size:
        give = _COMPLIANCE.bounds(contact)[1] if COMPLIANCE in (free or ()) else 0.0
        _refuse_other_units(displacement, force, contact, give)
    known = parameters()
    if unknown := [n for n in free or () if n not in known]:
        raise DemlawsError(f"cannot fit {', '.join(unknown)}: what can be fitted is {', '.join(known)}")
    falls = bool(np.any(force < 0.98 * np.maximum.accumulate(force))) if force.size else False
    jobs, fits, skipped = [], [], {}
    # a given curve has no parameters of the law's
    rules = [rule for rule in dict.fromkeys(r for name in names for r in find(name).offered()) if rule != GIVEN]
    asked = _texts(unloading, "unloading")
    for rule in asked or ():
        if rule not in rules:
            raise DemlawsError(f"unknown unloading rule {rule!r}: the rules that a fit takes are {', '.join(rules)}")
    for name in names:
        definition = find(name)
        varied = [
            n
            for n in (definition.fitting.free if free is None else free)
            if n in ("modulus", COMPLIANCE) or n in definition.fitting.parameters
        ]
        if force.size < len(varied) + 4:
            raise DemlawsError(
                f"{force.size} points with a force above 0 (compression): at least {len(varied) + 4} are needed for {name}"
            )
        for rule in asked or (definition.unloading if falls else ("elastic",)):
            jobs.append((name, rule, [n for n in varied if rule != "elastic" or not _on_unloading(definition, n)]))
    measured = displacement, force, displacement_noise, force_noise

    def one(name, rule, varied):
        return _fit_one(_Model(name, contact, rule, varied, options.get(name, {})), *measured)

    for job in progress(jobs):
        name, rule, _ = job
        try:
            fits.append(one(*job))
        except DemlawsError as error:
            skipped[name if rule == "elastic" else f"{name}, {rule} unloading"] = str(error)
    if not fits:
        raise DemlawsError("no law could be fitted: " + "; ".join(f"{k}: {v}" for k, v in skipped.items()))
    if dropped is not None:
        count, reason = dropped.split(": ", 1)
        skipped[count] = reason
    fits.sort(key=lambda f: f.aicc)
    fits[0] = fits[0]._replace(notes=(*fits[0].notes, *_suspicions(fits[0], one, contact, displacement)))
    best = fits[0].aicc
    total = sum(math.exp(-0.5 * (f.aicc - best)) for f in fits)
    ranked = [f._replace(delta=f.aicc - best, weight=math.exp(-0.5 * (f.aicc - best)) / total) for f in fits]
    return Ranking(ranked, skipped, (displacement, force))


def _on_unloading(definition, name):
    """Whether a quantity shows on unloading only."""
    return name in definition.fitting.parameters and definition.fitting.parameters[name].unloading


def _texts(given, name):
    """None, or a list of the words that were given, one or several."""
    if given is None or isinstance(given, str):
        return None if given is None else [given]
    if not isinstance(given, list | tuple | set) or not all(isinstance(one, str) for one in given):
        raise DemlawsError(f"{name} must be a name or a list of names, got {given!r:.60}")
    return list(given)


def _checked_options(options):
    """{} or law name → its options, as it was given."""
    if options is None:
        return {}
    if not isinstance(options, Mapping) or not all(isinstance(one, Mapping) for one in options.values()):
        raise DemlawsError(f"options must be {{law: {{option: value}}}}, got {options!r:.60}")
    return {find(name).name: one for name, one in options.items()}


def _default_laws():
    return [name for name, definition in registry().items() if definition.fitting.identifiable and not definition.needs_map]


def _suspicions(best, one, contact, displacement):
    """Notes on quantities that were kept fixed and whose misfit has a pattern: E*, and the compliance of the apparatus."""
    left = displacement - best.displacement
    spread = float(np.sum(left**2))
    if best.law.definition.solved or not float(np.sum(left[1:] * left[:-1])) > 1.7 / math.sqrt(left.size) * spread > 0.0:
        return
    varied = [name for name in best.coordinates if name != ZERO]
    given = f"speaks against the given E* = {contact.modulus * 1e-9:.4g} GPa"
    hints = {
        "modulus": (1e-9, "GPa", given, "fit the modulus, too"),
        COMPLIANCE: (1e6, "µm/N", "an apparatus makes that gives way", "measure the compliance and give it, or fit it, too"),
    }
    for name, (unit, symbol, meaning, remedy) in hints.items():
        if name in varied:
            continue
        try:
            other = one(best.name, best.unloading, [*varied, name])
        except DemlawsError:
            continue
        value, low, high = (other.parameters[name][n] * unit for n in (0, 2, 3))
        if value > 0.0 and other.aicc < best.aicc - _DECISIVE:
            yield (
                f"the misfit has a pattern that {meaning}: with {value:.4g} {symbol} [{low:.4g}, {high:.4g}] it falls from "
                f"{best.misfit * 1e6:.3g} to {other.misfit * 1e6:.3g} µm; {remedy}"
            )


class _Problem:
    """One model and the points: coordinates are the model's and, last, the zero in units of `scale`."""

    def __init__(self, model, displacement, force, displacement_noise):
        self.model, self.measured, self.force = model, displacement, force
        self.scale = float(np.ptp(displacement)) or float(np.max(np.abs(displacement))) or 1.0
        self.sigma = np.full(force.size, displacement_noise or self.scale)
        low, high = model.bounds()
        self.low, self.high = np.append(low, -np.inf), np.append(high, np.inf)

    def residual(self, x):
        return (self.measured - x[-1] * self.scale - self.model.displacement(x, self.force)[0]) / self.sigma

    def start(self, s):
        """Cost and coordinates with the zero that suits these values best."""
        x = np.append(s, 0.0)
        r = self.residual(x) * self.sigma
        weights = 1.0 / self.sigma**2
        x[-1] = float(np.sum(weights * r) / np.sum(weights)) / self.scale
        return float(np.sum(self.residual(x) ** 2)), x

    def solve(self, x, fixed=None, **options):
        """Least squares from `x`, with all coordinates free or all but one."""
        from scipy.optimize import least_squares

        free = np.arange(x.size) != fixed
        whole = x.copy()

        def residual(part):
            whole[free] = part
            return self.residual(whole)

        inside = np.clip(x[free], self.low[free], self.high[free])
        found = least_squares(residual, inside, bounds=(self.low[free], self.high[free]), x_scale="jac", **options)
        whole[free] = found.x
        return found, whole.copy()

    def profile(self, x, index, step, variance, quantile):
        """Ends of the profile likelihood's interval of coordinate `index`: where the points, with all else fitted again, lie
        `quantile` standard deviations from the best fit `x`, or the end of the range."""
        from scipy.optimize import brentq

        least = float(np.sum(self.residual(x) ** 2))
        ends = []
        for bound in (self.low[index], self.high[index]):
            start = x.copy()

            def beyond(trial, start=start):
                start[index] = trial
                start[:] = self.solve(start, index, xtol=1e-10, ftol=1e-10, gtol=1e-10, max_nfev=40)[1]
                away = math.sqrt(max(float(np.sum(self.residual(start) ** 2)) - least, 0.0) / variance) - quantile
                return away if abs(away) > 0.005 * quantile else 0.0

            place, width, outside = x[index], math.copysign(step, bound - x[index]), False
            while place != bound and not outside:
                near, place = place, (min if width > 0.0 else max)(place + width, bound)
                width *= 2.0
                outside = beyond(place) >= 0.0
            if outside:
                place = brentq(lambda trial: beyond(trial) if trial != x[index] else -quantile, near, place)
            ends.append(place)
        return ends


def _fit_one(model, displacement, force, displacement_noise, force_noise):
    problem = _Problem(model, displacement, force, displacement_noise)
    # the stiffness that turns force noise into displacement noise comes from the fit itself: two more rounds
    for _ in range(3 if force_noise else 1):
        trials = [problem.solve(x, max_nfev=12) for x in _spread(map(problem.start, model.starts()))]
        best = sorted(trials, key=lambda t: t[0].cost)[:2]
        solutions = [problem.solve(x, jac="3-point", xtol=1e-12, ftol=1e-12, gtol=1e-12)[0] for _, x in best]
        solution = min(solutions, key=lambda s: s.cost)
        if force_noise:
            problem.sigma = np.hypot(displacement_noise, force_noise / model.overlap(solution.x, force)[1])
    return _report(problem, solution, displacement_noise is not None)


def _spread(scored, most=6):
    """The best starts, one for each value of the last free quantity: a yield pressure that no load reaches has no slope."""
    chosen = {}
    for cost, x in scored:
        key = float(x[-2]) if x.size > 1 else 0.0
        if key not in chosen or cost < chosen[key][0]:
            chosen[key] = cost, x
    return [x for _, x in sorted(chosen.values(), key=lambda pair: pair[0])[:most]]


def _report(problem, solution, absolute):
    from scipy import stats

    model, displacement, force, scale = problem.model, problem.measured, problem.force, problem.scale
    n, k = force.size, solution.x.size
    rss = 2.0 * solution.cost
    freedom = n - k
    variance = 1.0 if absolute else rss / freedom
    # a parameter at its bound, or without effect, is left out of the covariance
    low, high = problem.low, problem.high
    size = np.linalg.norm(solution.jac, axis=0)
    width = np.where(np.isfinite(high), high - low, 1.0)
    at_bound = np.minimum(solution.x - low, high - solution.x) < 1e-6 * width
    idle = size <= 1e-10 * max(size[-1], 1e-300)
    used = ~(at_bound | idle)
    jacobian = solution.jac[:, used] / size[used]
    covariance = np.full((k, k), np.nan)
    weak = used & (np.linalg.cond(jacobian) >= 1e7)
    if not np.any(weak):
        inverse = np.linalg.pinv(jacobian) / size[used, None]
        covariance[np.ix_(used, used)] = variance * inverse @ inverse.T
    half = 0.5 + 0.5 * _CONFIDENCE
    quantile = float(stats.norm.ppf(half) if absolute else stats.t.ppf(half, freedom))
    errors = np.sqrt(np.diag(covariance))
    ends = np.array([solution.x - quantile * errors, solution.x + quantile * errors]).T
    if variance > 0.0 and not np.all((ends[:, 0] > low) & (ends[:, 1] < high)):
        # near an end of its range a quantity's likelihood is no parabola, nor is that of those that are tied to it
        steps = np.minimum(np.where(np.isfinite(errors) & (errors > 0.0), errors, 0.02 * width), high - low)
        ends = np.array([problem.profile(solution.x, i, float(steps[i]), variance, quantile) for i in range(k)])
    stopped = ends == np.stack([low, high], 1)
    unit = np.append(np.ones(k - 1), scale)
    covariance *= np.outer(unit, unit)
    estimates = {}
    coordinates = (*model.free, ZERO)
    final = solution.x * unit
    for i, name in enumerate(coordinates):
        error, (lower, upper) = errors[i] * unit[i], ends[i] * unit[i]
        note = "at its bound" if at_bound[i] else "without effect on these points" if idle[i] else ""
        note = "these points do not tell it from the others" if weak[i] else note
        if np.all(stopped[i]):
            note = "not determined" + (f": {note}" if note else "")
        elif name not in _ENDS and np.any(stopped[i]):
            note = f"the points give no {'lower' if stopped[i][0] else 'upper'} end" + (f", {note}" if note else "")
        if name != ZERO and model.parameters[name].logarithmic:
            value = math.exp(final[i])
            with np.errstate(over="ignore"):
                estimates[name] = Estimate(value, value * error, float(np.exp(lower)), float(np.exp(upper)), note)
        else:
            estimates[name] = Estimate(float(final[i]), float(error), float(lower), float(upper), note)
    # Gaussian likelihood: with known noise, or with the scatter as one more parameter
    if absolute:
        minus_two_log = rss + 2.0 * float(np.sum(np.log(problem.sigma))) + n * math.log(2.0 * math.pi)
        count = k
    else:
        floor = (1e-15 * scale) ** 2  # points without any noise would have an infinite likelihood
        minus_two_log = n * (math.log(2.0 * math.pi * max(rss / n * scale**2, floor)) + 1.0)
        count = k + 1
    aicc = minus_two_log + 2.0 * count + (2.0 * count * (count + 1.0) / (n - count - 1.0) if n > count + 1 else math.inf)
    predicted, _ = model.displacement(solution.x, force)
    difference = displacement - final[-1] - predicted
    notes = []
    spread = float(np.sum(difference**2))
    if n >= 20 and spread > 0 and float(np.sum(difference[1:] * difference[:-1])) > 0.5 * spread:
        notes.append("the misfit is systematic, not scatter: the stated uncertainty is too small")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ValidityWarning)
        best = model.law(solution.x)
        ready = bind_law(best.name, best.contact, best.unloading, **best.options)  # refuses a pair that is not passive
    return Fit(
        model.definition.name,
        model.unloading,
        estimates,
        covariance,
        coordinates,
        float(np.sqrt(np.mean(difference**2))),
        aicc,
        0.0,
        1.0,
        rss / freedom if absolute else math.nan,
        ready,
        predicted + final[-1],
        tuple(notes),
    )
