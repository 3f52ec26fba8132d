"""A law with free quantities, fitted to measured points by least squares in the displacement.

The search begins from a few places, chosen by cheap evaluations. Most quantities have a slope everywhere, and a start or two
are enough. A pressure at which the bulk yields, or another quantity that moves the joint of the curve, has none where the joint
lies above all loads: it starts where the joint lies at the shares `JOINTS` of the largest load.
"""

import itertools
import math

import numpy as np

from demlaws.contact import replace_unchecked
from demlaws.core import loops
from demlaws.core.history import history
from demlaws.errors import DemlawsError, quiet
from demlaws.laws.definition import OF_CONTACT, Parameter
from demlaws.laws.registry import find, registry
from demlaws.make import law as bind_law

ZERO = "zero"
COMPLIANCE = "compliance"
DRIFT = "drift"
"""Displacement [m] by which the apparatus moves from the first row to the last, in proportion to the rows."""
CREEP = Parameter("m", False, lambda c: (-0.1 * c.radius, 0.1 * c.radius), lambda c: [0.0])
"""Displacement [m] that a hold adds to all later rows; a fit has one for each hold."""
FORCE_ZERO = "force_zero"
"""Reading of the load cell [N] without a load."""
APPARATUS = {
    COMPLIANCE: Parameter("m/N", False, lambda c: (0.0, 1e-4), lambda c: [0.0]),
    DRIFT: Parameter("m", False, lambda c: (-0.01 * c.radius, 0.01 * c.radius), lambda c: [0.0]),
    FORCE_ZERO: Parameter("N", False, lambda c: (-math.inf, math.inf), lambda c: [0.0]),
}
"""Fitted quantities of the apparatus, not of a law; the range of the force zero is that of the points."""
LARGEST_FORCE_ZERO = 0.05
"""Part of the largest force up to which the zero of the force is searched, to both sides."""
_LEAST_FORCE = 1e-6  # over the largest: points with less, after the zero is subtracted, count as touching
JOINTS = (0.02, 0.06, 0.12, 0.2, 0.35, 0.5, 0.65, 0.8, 2.0)
"""Loads of a curve's joint from which a fit starts, over the largest load."""
_STARTS = 4  # starts that are followed for a few steps; two of them to the end
_SCALE = 2.0  # factor of the overlap by which a promising start may be wrong
_STEP = 1e-4  # of the derivatives, in the fitted coordinates: mostly logarithms


def parameters():
    """Name → `Parameter` of every quantity that a fit of some law may vary."""
    tables = [definition.fitting.parameters for definition in registry().values()]
    return {**OF_CONTACT, **APPARATUS, **{n: one for quantities in tables for n, one in quantities.items()}}


def largest_compliance(contact):
    """End of the range [m/N] in which the compliance of the apparatus is searched."""
    return APPARATUS[COMPLIANCE].bounds(contact)[1]


class Model:
    """A law with free quantities. Coordinates are these (ln of positive ones) and, last, the zero in units of `scale`."""

    def __init__(self, name, rule, free, *, contact, options, displacement, force, noise, course, creep):
        self.definition, self.unloading, self.free = find(name), rule, (*free, *creep)
        self.rule = self.definition.rule(rule)
        self.parameters = {**OF_CONTACT, **APPARATUS, **self.definition.fitting.parameters, **dict.fromkeys(creep, CREEP)}
        fill = {}
        for field in self.definition.needed(**options):
            if getattr(contact, field) is None:
                if field not in free:
                    raise DemlawsError(f"{name} needs the contact's {field}: give it, or fit it")
                fill[field] = float(OF_CONTACT[field].starts(contact)[0])
        self.contact = contact.with_values(**fill)
        unseen = {n: one for n, one in self.definition.fitting.parameters.items() if one.unloading and n not in free}
        self.options = {n: float(np.ravel(one.starts(self.contact))[0]) for n, one in unseen.items()}
        self.options |= self.definition.read_options(options)
        self.definition.refuse_missing({*self.options, *free})
        self.measured, self.force = displacement, force
        columns = {COMPLIANCE: force, DRIFT: course, **creep}
        self.linear = {n: column for n, column in columns.items() if n in self.free}
        self.scale = float(np.ptp(displacement)) or float(np.max(np.abs(displacement))) or 1.0
        self.sigma = np.full(force.size, noise or self.scale)
        ends = [self._coordinate(n, self.parameters[n].bounds(self.contact)) for n in self.free]
        if FORCE_ZERO in free:
            most = LARGEST_FORCE_ZERO * float(np.max(force))
            ends[self.free.index(FORCE_ZERO)] = -most, most
        self.low, self.high = np.array([*ends, (-np.inf, np.inf)]).T

    def _coordinate(self, name, value):
        return np.log(value) if self.parameters[name].logarithmic else np.asarray(value, float)

    def values(self, x):
        """Name → value of the free quantities."""
        return {n: math.exp(v) if self.parameters[n].logarithmic else float(v) for n, v in zip(self.free, x, strict=False)}

    def inputs(self, x):
        """Contact and options of the law. The bounds guarantee admissible values: they are not checked for each trial."""
        changes, options = {}, dict(self.options)
        for name, value in self.values(x).items():
            if name not in APPARATUS and name not in self.linear:
                (options if self.parameters[name].option else changes)[name] = value
        return replace_unchecked(self.contact, changes), options

    def overlap(self, x):
        """Overlap [m] and tangent stiffness [N/m] at each force."""
        contact, options = self.inputs(x)
        shape = self.definition.prepare(contact, **options)
        params = loops.bind_params(shape, contact)
        force = np.maximum(self.force - self.values(x).get(FORCE_ZERO, 0.0), _LEAST_FORCE * np.max(self.force))
        overlap, stiffness = history(self.rule, shape, params, force)
        # outside the range of a curve: far away, not NaN
        return np.where(np.isfinite(overlap), overlap, 1e3 * contact.radius), stiffness

    def displacement(self, x):
        """Displacement [m] at each force, apparatus included."""
        values = self.values(x)
        apparatus = sum(values[name] * column for name, column in self.linear.items())
        return self.overlap(x)[0] + apparatus + x[-1] * self.scale

    def residual(self, x):
        """Measured less predicted displacement, over the noise."""
        return (self.measured - self.displacement(x)) / self.sigma

    def jacobian(self, x):
        """Derivatives of `residual`: central differences for quantities of the law, exact for those of the apparatus."""
        columns = []
        for i, name in enumerate(self.free):
            if name in self.linear:
                columns.append(self.linear[name])
                continue
            step = _STEP * (self.high[i] if name == FORCE_ZERO else 1.0)
            ends = np.array([x, x])
            ends[:, i] = np.clip(x[i] + np.array([-step, step]), self.low[i], self.high[i])
            columns.append((self.overlap(ends[1])[0] - self.overlap(ends[0])[0]) / (ends[1, i] - ends[0, i]))
        return -np.column_stack([*columns, np.full(self.force.size, self.scale)]) / self.sigma[:, None]

    def project(self, x):
        """Zero, compliance and drift, in which the displacement is linear, of least squares at the other coordinates.

        Returns the sum of squares that a curve of the same shape has, scaled by up to `_SCALE`: the first steps of the search
        find a scale, but not a joint.
        """
        columns, places = [np.full(self.force.size, self.scale)], [len(self.free)]
        columns += self.linear.values()
        places += [self.free.index(name) for name in self.linear]
        matrix, overlap = np.array(columns).T / self.sigma[:, None], self.overlap(x)[0] / self.sigma
        measured = self.measured / self.sigma
        basis = np.linalg.qr(matrix)[0]
        curve, points = (one - basis @ (basis.T @ one) for one in (overlap, measured))
        factor = np.clip((curve @ points) / max(curve @ curve, 1e-300), 1.0 / _SCALE, _SCALE)
        best = np.linalg.lstsq(matrix, measured - overlap, rcond=None)[0]
        x[places] = np.clip(best, self.low[places], self.high[places])
        return float(np.sum((points - factor * curve) ** 2))

    def joint(self, x):
        """Load [N] at the last joint of the curve of first loading; NaN if it has none."""
        contact, options = self.inputs(x)
        shape = self.definition.prepare(contact, **options)
        params = loops.bind_params(shape, contact)
        kinks = self.definition.loading.kinks(params, **options)
        return float(loops.force_loop(shape, params, np.array([max(kinks)]))[0][0]) if kinks else math.nan

    def joint_places(self, x, index):
        """Coordinates `index` at which the joint of the curve lies at `JOINTS`; none where the joint does not rise or fall."""
        x, nodes = x.copy(), np.linspace(self.low[index], self.high[index], 13)[1:-1]
        loads = np.empty(nodes.size)
        for i, node in enumerate(nodes):
            x[index] = node
            loads[i] = self.joint(x)
        loads = np.log(np.maximum(loads, 1e-300))
        if not (np.all(np.diff(loads) > 0.0) or np.all(np.diff(loads) < 0.0)):
            return []
        order = np.argsort(loads)
        return np.interp(np.log(np.max(self.force) * np.array(JOINTS)), loads[order], nodes[order])

    def joint_index(self, x):
        """Index of the last option that moves the joint of the curve, or None."""
        if not math.isfinite(self.joint(x)):
            return None
        options = [i for i, name in enumerate(self.free) if self.parameters[name].option]
        return next((i for i in reversed(options) if len(self.joint_places(x, i))), None)

    def starts(self):
        """Starting points, the most promising first: the best for each place of the joint of the curve or, if it has none, for
        each value of the last quantity."""
        choices = []
        for name, low, high in zip(self.free, self.low, self.high, strict=False):
            margin = 1e-9 * (high - low)
            start = self._coordinate(name, np.atleast_1d(self.parameters[name].starts(self.contact)))
            choices.append(np.clip(start, low + margin, high - margin))
        jointed = self.joint_index(np.array([*(choice[0] for choice in choices), 0.0]))
        index = len(choices) - 1 if jointed is None else jointed
        if jointed is not None:
            choices[jointed] = choices[jointed][:1]
        best = {}
        for values in itertools.product(*choices):
            x = np.array([*values, 0.0])
            places = [x[index]] if jointed is None else self.joint_places(x, jointed)
            for key, place in zip(places if jointed is None else JOINTS, places, strict=False):
                x[index] = place
                cost = self.project(x)
                if cost < best.get(key, (math.inf,))[0]:
                    best[key] = cost, x.copy()
        return [x for _, x in sorted(best.values(), key=lambda pair: pair[0])[:_STARTS]]

    def solve(self, x, fixed=None, tolerance=1e-12, steps=None):
        """(x, sum of squares) of the least squares from `x`, with all coordinates free or all but one."""
        from scipy.optimize import least_squares

        free, whole = np.arange(x.size) != fixed, x.copy()

        def completed(part):
            whole[free] = part
            return whole

        solution = least_squares(
            lambda part: self.residual(completed(part)),
            np.clip(x[free], self.low[free], self.high[free]),
            jac=lambda part: self.jacobian(completed(part))[:, free],
            bounds=(self.low[free], self.high[free]),
            x_scale="jac",
            **dict.fromkeys(("xtol", "ftol", "gtol"), tolerance),
            max_nfev=steps,
        )
        return completed(solution.x).copy(), 2.0 * float(solution.cost)

    def law(self, x):
        """The law at `x`, all its values checked: a pair with the rule that would create energy is a `NotPassive`."""
        contact, options = self.inputs(x)
        with quiet():
            return bind_law(self.definition.name, contact.with_values(), self.unloading, **options)

    def minimise(self):
        """Least squares from several starts, the two most promising ones to the end: the best solution that is admissible.

        A quantity without effect may end where the law and the rule would create energy at loads beyond the points. The zero
        of the force is released last: with a wrong law it would go where the smallest forces touch only.
        """
        fixed = self.free.index(FORCE_ZERO) if FORCE_ZERO in self.free else None
        trials = (self.solve(x, fixed, steps=6) for x in self.starts())
        trials = sorted(
            trials if fixed is None else (self.solve(self.solve(x, fixed)[0]) for x, _ in trials), key=lambda t: t[1]
        )
        ends = [self.solve(x) for x, cost in trials[:2] if cost <= 1.5 * trials[0][1]]
        refused = None
        for x, cost in sorted(ends, key=lambda end: end[1]) + trials:
            try:
                self.law(x)
                return x, cost
            except DemlawsError as error:
                refused = refused or error
        raise refused

    def refine(self, x):
        """Least squares from an admissible solution, after a change of the weights; `x` itself if that leads to none."""
        solution = self.solve(x)
        try:
            self.law(solution[0])
        except DemlawsError:
            return x, float(np.sum(self.residual(x) ** 2))
        return solution

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
