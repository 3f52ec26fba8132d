"""Rough sphere on an elastic half-space: the implicit axisymmetric models and their master curves.

Both models squeeze a thin layer of Gaussian asperities between a smooth sphere and an elastic bulk. With the radius
r* = r / sqrt(2 R sigma), heights in units of sigma and pressure q = 2 p sqrt(2 R / sigma) / E* they are one problem,

    s(r*) = r*^2 - U + w(r*),          w(r*) = (2/pi) int_0^inf t/(t + r*) K(k) q(t) dt,   k^2 = 4 r* t / (r* + t)^2,
    q = A g(s),                        f = P / (E* sqrt(R) sigma^1.5) = pi sqrt(2) int_0^inf q r* dr*,

with U = w(0) - s(0) the approach of the bodies in units of sigma, counted from the position where the undeformed sphere
touches the mean plane of the roughness. They differ in the law of the layer only:

    Yip & Venart (1971), plastic asperities    A = N_H = (H_m / E*) sqrt(8 R / sigma),  g = erfc(s / sqrt 2) / 2
    Greenwood & Tripp (1967), elastic ones     A = mu = (8/3) eta sigma sqrt(2 R beta), g = int_s^inf (z - s)^1.5 phi dz

N_L = 2 P / (sigma E* sqrt(2 R sigma)) of Yip & Venart is sqrt(2) f. Hertz is f = (4/3) U^1.5, contact radius
a* = sqrt(U/2), central pressure q0 = 8 a*/pi. One number (A) fixes the whole curve f(U).

K is below Hertz's at the same force at every load, for both models and every A from 0.05 to 1e5 (measured), so Hertz
unloading is passive. A Gaussian has no highest peak, so a contact never carries zero load: the overlap of a grain is
U - U(f_seat) with a declared seating load. Above p(0) = 0.6 H_m the bulk yields (Jamari & Schipper) and Yip-Venart
no longer applies: `Curve.bulk_yield_force`.

Sources: F. C. Yip and J. E. S. Venart, J. Phys. D: Appl. Phys. 4 (1971) 1470; J. A. Greenwood and J. H. Tripp, J. Appl.
Mech. 34 (1967) 153. The common form, the discretisation, the exact tangent and the far tail are our derivation.
"""

from __future__ import annotations

import contextlib
import ctypes
import math
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from demlaws.errors import DemlawsError
from demlaws.solvers.master_curves import ELASTIC_LAYER, PLASTIC_LAYER
from studies.half_space.influence import ORDER, influence_matrix, nodes_of, panel_edges, reference_rules

if TYPE_CHECKING:
    from scipy.interpolate import BPoly

LOWEST_FORCE = 1e-9  # below it the elastic bulk moves by less than 1e-8 sigma and the closed form of the tail is exact
HIGHEST_FORCE = 1e7

_INNER = 9  # panels from the axis to the flank of the pressure
_OUTER = 4  # panels from the flank to the end of the tail
_FLANK = math.log(1e-3)  # pressure over central pressure where the inner panels end
_END = math.log(1e-14)  # and where the outer ones do
_STEP = 0.5  # nodes of a curve, in ln f
_RANGE = (0.03, 2e5)  # of N_H and of mu: somewhat wider than the range of the package's data


class MasterCurve(NamedTuple):
    """Points of a dimensionless master curve; arrays, one entry per force."""

    approach: np.ndarray  # U = w(0) - s(0), in units of sigma
    force: np.ndarray  # f = P / (E* sqrt(R) sigma^1.5)
    stiffness: np.ndarray  # df/dU, exact tangent of the discrete system
    central_pressure: np.ndarray  # p(0) / p0 of Hertz at the same force
    effective_radius: np.ndarray  # a* / a_H, a* = 3 pi int r p dr / (4 int p dr)
    alpha: np.ndarray  # sigma R / a_H^2 = (3 f / 4)^(-2/3)
    curvature: np.ndarray  # d2f/dU2, exact as well


# ---- the two asperity layers ---------------------------------------------------------------------


class _YipVenart:
    name = PLASTIC_LAYER
    parameter = "hardness number N_H = (H_m / E*) sqrt(8 R / sigma)"

    @staticmethod
    def flat(s):
        """Positive where the asperities are crushed: p(0) > 0.9974 H_m."""
        return -2.8 - s

    @staticmethod
    def layer(s):
        """g, g', g'' of g = erfc(s / sqrt 2) / 2."""
        from scipy.special import erfc

        phi = np.exp(-0.5 * s * s) / math.sqrt(2 * math.pi)
        return 0.5 * erfc(s / math.sqrt(2)), -phi, s * phi

    @staticmethod
    def tail(d):
        """int_d^inf g ds = phi(d) - d Q(d), and g(d), g'(d); for d >= 0."""
        from scipy.special import erfcx

        phi = np.exp(-0.5 * d * d) / math.sqrt(2 * math.pi)
        mills = math.sqrt(math.pi / 2) * erfcx(d / math.sqrt(2))
        return phi * (1 - d * mills), phi * mills, -phi


class _GreenwoodTripp:
    name = ELASTIC_LAYER
    parameter = "mu = (8/3) eta sigma sqrt(2 R beta)"

    @staticmethod
    def flat(s):
        return -math.inf

    @staticmethod
    def layer(s):
        """g, g', g'' of g = F_{3/2}(s); F_n' = -n F_{n-1}."""
        f32, f12, fm12 = half_moments(s, (1.5, 0.5, -0.5))
        return f32, -1.5 * f12, 0.75 * fm12

    @staticmethod
    def tail(d):
        f52, f32, f12 = half_moments(d, (2.5, 1.5, 0.5))
        return 0.4 * f52, f32, -1.5 * f12


_MODELS = {m.name: m for m in (_YipVenart, _GreenwoodTripp)}


def half_moments(s, orders):
    """F_n(s) = int_0^inf x^n phi(s + x) dx for half-integer n >= -1/2, to about 1e-14 relative, s from -1e8 to 38.

    With x = y^2 the integrand is entire and even in y, so the trapezoidal rule converges geometrically; below s = -12
    the moment expansion |s|^n sum_k binom(n, 2k) (2k-1)!! / s^2k has reached rounding (our derivation).
    """
    s = np.asarray(s, float)
    if s.ndim == 0:
        return [values[0] for values in half_moments(s[None], orders)]
    y2 = (0.1 * np.arange(47)) ** 2
    x = np.maximum(s, -12.0)[..., None] + y2
    phi = np.exp(-0.5 * x * x) * (0.2 / math.sqrt(2 * math.pi))
    phi[..., 0] *= 0.5
    result = [phi @ y2 ** (n + 0.5) for n in orders]
    deep = s < -12
    if deep.any():
        depth = -s[deep]
        for n, values in zip(orders, result, strict=True):
            total, term = np.ones_like(depth), np.ones_like(depth)
            for k in range(10):
                term = term * ((n - 2 * k) * (n - 2 * k - 1) / (2 * k + 2) / depth**2)
                total = total + term
            values[deep] = depth**n * total
    return result


def _tail_separation(model, parameter, log_force):
    """d of the undeformed bulk, f = (pi/sqrt 2) A int_d^inf g ds, and -dd/d ln f; arrays."""
    target = log_force - math.log(math.pi / math.sqrt(2) * parameter)
    d = np.sqrt(np.maximum(1.0, -2 * target))
    for _ in range(50):
        total, g, _ = model.tail(d)
        step = (np.log(np.maximum(total, 1e-308)) - target) * total / np.maximum(g, 1e-308)
        d = d + step
        if np.abs(step).max() < 1e-13:
            break
    return d, total / g


@contextlib.contextmanager
def _one_thread():
    """Solve with one thread of OpenBLAS: for 130 rows its threads only wait, on a busy machine fifty times the solution's
    time. Another library of linear algebra keeps its threads."""
    from scipy.linalg import _flapack

    library = ctypes.CDLL(_flapack.__file__)
    for name in ("openblas_{}_num_threads", "scipy_openblas_{}_num_threads"):
        with contextlib.suppress(AttributeError):
            read, write = (getattr(library, name.format(verb)) for verb in ("get", "set"))
            break
    else:
        yield
        return
    threads = read()
    write(1)
    try:
        yield
    finally:
        write(threads)


# ---- Newton and continuation ---------------------------------------------------------------------


class _State(NamedTuple):
    log_force: float
    approach: float
    separation: np.ndarray  # at the nodes
    nodes: np.ndarray
    levels: np.ndarray  # ln r where the pressure has dropped to _FLANK and to _END


class _Solver:
    """Marches along one curve with ln f; Newton on (s, U) at given load, polynomial predictor on moving nodes."""

    def __init__(self, model, parameter):
        self.model, self.parameter = _MODELS[model], float(parameter)
        self.history = []
        self.points = []
        self.flat = False

    def _guess(self, log_force):
        """Separation, approach and panel edges to start Newton from: the tail, or past states extrapolated in ln f.

        Nodes keep their place relative to the flank and the tail of the pressure, so s at a node varies slowly."""
        if not self.history:
            d = float(_tail_separation(self.model, self.parameter, np.array([log_force]))[0][0])
            s = np.linspace(d, d + 60, 60001)
            log_g = np.log(np.maximum(self.model.layer(s)[0], 1e-300))
            level = np.interp([-_FLANK, -_END], log_g[0] - log_g, s)
            edges = panel_edges(0.5 * np.log(level - d), _INNER, _OUTER)
            r = nodes_of(edges)
            return d + r * r, -d, edges
        past = self.history[-4:]
        x = np.array([state.log_force for state in past])
        weights = [np.prod((log_force - np.delete(x, i)) / (x[i] - np.delete(x, i))) for i in range(x.size)]
        _, approach, s, r, levels = (
            sum(w * item for w, item in zip(weights, items, strict=True)) for items in zip(*past, strict=True)
        )
        edges = panel_edges(levels, _INNER, _OUTER)
        return s + np.gradient(s, r) * (nodes_of(edges) - r), approach, edges

    def _newton(self, log_force, s, approach, edges):
        """Solve at one load; (state, point) or None when Newton does not converge."""
        from scipy.linalg import lu_factor, lu_solve

        r, dr, influence = influence_matrix(edges)
        load = math.pi * math.sqrt(2) * r * dr
        diagonal = np.arange(r.size)
        for _ in range(30):
            g, g1, g2 = (self.parameter * x for x in self.model.layer(s))
            force = load @ g
            if not force > 0:
                return None
            jacobian = influence * -g1
            jacobian[diagonal, diagonal] += 1
            # einsum: the threads of BLAS stall on a busy machine, and a product costs less than waking them
            correction = r * r + np.einsum("ij,j->i", influence, g) - s - approach
            factors = lu_factor(jacobian, overwrite_a=True, check_finite=False)
            # sinking: minus ds/dU
            correction, sinking = lu_solve(factors, np.stack([correction, np.ones_like(r)], 1), check_finite=False).T
            load_slope = load * g1
            d_approach = (force * (log_force - math.log(force)) - load_slope @ correction) / -(load_slope @ sinking)
            ds = correction - d_approach * sinking
            size = np.abs(ds[s > -6]).max(initial=0.0)
            if not np.isfinite(ds).all():
                return None
            limit = 1.0 / max(1.0, size)
            s = s + limit * ds
            approach = approach + limit * d_approach
            if size < 3e-8:
                break
        else:
            return None
        g, g1, g2 = (self.parameter * x for x in self.model.layer(s))
        ds = -sinking
        stiffness = (load * g1) @ ds
        bend = lu_solve(factors, np.einsum("ij,j->i", influence, g2 * ds * ds), check_finite=False)
        curvature = load @ (g2 * ds * ds + g1 * bend)
        central = self.parameter * self.model.layer(reference_rules(ORDER)["at_left"] @ s[:ORDER])[0]
        force = load @ g
        hertz_radius = (3 * force / (8 * math.sqrt(2))) ** (1 / 3)
        radius = 3 * math.pi * (r * dr @ g) / (4 * (dr @ g))
        point = (
            approach,
            force,
            stiffness,
            float(central) / (8 * hertz_radius / math.pi),
            radius / hertz_radius,
            1 / (2 * hertz_radius**2),
            curvature,
        )
        drop = np.log(float(central)) - np.log(np.maximum(g, 1e-300))
        keep = np.concatenate([[True], np.diff(np.maximum.accumulate(drop)) > 0])
        drop, radii = drop[keep], r[keep]
        levels = np.array([-_FLANK, -_END])
        edge_radii = np.interp(levels, drop, radii)
        if drop[-1] < levels[1]:
            edge_radii[1] = radii[-1] + (levels[1] - drop[-1]) * (radii[-1] - radii[-3]) / (drop[-1] - drop[-3])
        return _State(log_force, approach, s, r, np.log(edge_radii)), point

    def reach(self, log_force):
        """March to log_force; all accepted points are appended to self.points. Stops short where the core is flat."""
        with _one_thread():
            return self._march(log_force)

    def _march(self, log_force):
        while not self.flat and (not self.history or self.history[-1].log_force < log_force - 1e-12):
            here = self.history[-1].log_force if self.history else log_force
            # the rim of a flattening core is the one feature sharper than the lattice
            flattening = self.history and self.model.flat(self.history[-1].separation[0]) > -3
            # twice as far where the bulk is nearly rigid or the layer nearly thin: the errors at the nodes between are the same
            widest = _STEP / 3 if flattening else _STEP if -9.0 <= here < 7.0 else 2.0 * _STEP
            pieces = max(1, math.ceil((log_force - here) / widest - 1e-9))
            step = (log_force - here) / pieces
            for _ in range(12):
                result = self._newton(here + step, *self._guess(here + step))
                if result is not None and self.model.flat(result[0].separation[0]) <= 0:
                    break
                step *= 0.5
            else:
                raise ArithmeticError(f"{self.model.name} {self.parameter:g}: no solution at f = {math.exp(here):g}")
            state, point = result
            self.history.append(state)
            self.points.append(point)
            self.flat = self.model.flat(state.separation[0]) > -0.5
        return self.points[-1]


# ---- whole curves --------------------------------------------------------------------------------


class Curve(NamedTuple):
    """One master curve f(U), twice differentiable, for every U.

    Between the solved points V = U - (3f/4)^(2/3) is a quintic in ln f through exact values, slopes and curvatures, so
    that the Hertz part of the approach carries no interpolation error. Below `points.force[0]` the bulk is as good as
    rigid and f = (pi/sqrt 2) A int_{-U}^inf g ds. Above the last point ds/dU = K/K_Hertz keeps its value; for
    Yip-Venart, whose pressure cannot exceed H_m, a flat-topped contact of radius a, f = pi A a^2 / sqrt 2,
    U = a^2 + 2 A a / pi + c(f), where c fades and makes value and slope continuous (our derivation; measured against
    the solved contact for N_H = 1, 10, 23: force 2e-4, stiffness 5e-4).

    Relative errors in the solved range: f(U) 2e-7, stiffness 1e-6 (tests/studies/test_half_space.py).
    """

    model: str
    parameter: float
    points: MasterCurve
    log_force: np.ndarray  # nodes of the quintics
    offset: BPoly  # V as a function of ln f
    flat: bool  # the last point is one of a flattened (fully crushed) contact

    # -- U(f) --

    def approach(self, force):
        """U(f) in units of sigma; f > 0."""
        return self._approach(np.log(_positive(force, "force")))[0]

    def _approach(self, log_force):
        """U, dU/d ln f, at any ln f."""
        log_force = np.asarray(log_force, float)
        t = np.atleast_1d(log_force)
        u, du = np.empty_like(t), np.empty_like(t)
        low, high = t < self.log_force[0], t > self.log_force[-1]
        middle = ~(low | high)
        if middle.any():
            hertz = np.exp((t[middle] + math.log(0.75)) * (2 / 3))
            u[middle] = self.offset(t[middle]) + hertz
            du[middle] = self.offset(t[middle], 1) + (2 / 3) * hertz
        if low.any():
            d, du[low] = _tail_separation(_MODELS[self.model], self.parameter, t[low])
            u[low] = -d
        if high.any():
            u[high], du[high] = self._far_approach(t[high])
        return u.reshape(log_force.shape), du.reshape(log_force.shape)

    def _far_approach(self, t):
        last = MasterCurve(*(column[-1] for column in self.points))
        if not self.flat:
            s, slope = _hertz_overlap(last.force, last.stiffness)
            here = np.exp((t + math.log(0.75)) * (2 / 3))
            return last.approach + (here - s) / slope, (2 / 3) * here / slope
        u0, du0 = _flat_approach(np.float64(last.force), self.parameter)
        gap = last.approach - u0
        steepness = last.force / last.stiffness - du0 + 3 * gap
        x = np.exp(t) / last.force
        u, du = _flat_approach(np.exp(t), self.parameter)
        return u + (gap + steepness * (x - 1)) / x**3, du + (steepness * x - 3 * (gap + steepness * (x - 1))) / x**3

    # -- f(U) --

    def evaluate(self, approach):
        """Force f(U) and tangent stiffness df/dU; any U (0 where the tail is below 1e-290)."""
        approach = np.asarray(approach, float)
        u = np.atleast_1d(approach)
        f, k = np.zeros_like(u), np.zeros_like(u)
        low = u < self.points.approach[0]
        if low.any():
            d = np.minimum(-u[low], 40.0)
            total, g, _ = _MODELS[self.model].tail(d)
            scale = math.pi / math.sqrt(2) * self.parameter * (d < 36)
            f[low], k[low] = scale * total, scale * g
        if not low.all():
            f[~low], k[~low] = self._invert(u[~low])
        return f.reshape(approach.shape), k.reshape(approach.shape)

    def _invert(self, u):
        nodes = self.points.approach
        i = np.clip(np.searchsorted(nodes, u, side="right") - 1, 0, nodes.size - 2)
        low, high = self.log_force[i], self.log_force[i + 1]
        t = low + (high - low) * (u - nodes[i]) / (nodes[i + 1] - nodes[i])
        beyond = u > nodes[-1]
        t = np.where(beyond, self.log_force[-1] + 1.5 * np.log(np.maximum(u / nodes[-1], 1.0)), t)
        for _ in range(50):
            here, slope = self._approach(t)
            step = (u - here) / slope
            t = t + np.clip(step, -1.0, 1.0)
            if not (np.abs(step) >= 1e-9).any():  # quadratic: the next step would be below 1e-16
                break
        force = np.exp(t)
        return force, force / self._approach(t)[1]

    def hertz_overlap(self, approach):
        """s = (3f/4)^(2/3), the Hertz overlap of the same force in units of sigma, and ds/dU."""
        return _hertz_overlap(*self.evaluate(approach))

    def bulk_yield_force(self, ratio=0.6):
        """f at which p(0) = ratio H_m, to 1e-4: from there on the bulk yields, not only asperities (Yip-Venart).

        Infinite where the curve does not reach it, and for Greenwood-Tripp, which knows no hardness."""
        from scipy.interpolate import CubicSpline

        hertz_radius = np.cbrt(3 * self.points.force / (8 * math.sqrt(2)))
        pressure = self.points.central_pressure * (8 / math.pi) * hertz_radius / self.parameter
        if _MODELS[self.model] is _GreenwoodTripp or pressure[-1] < ratio:
            return math.inf
        crossings = CubicSpline(self.log_force, np.log(pressure / ratio)).roots(extrapolate=False)
        return float(np.exp(crossings[0]))


def _positive(value, name):
    value = np.asarray(value, float)
    if not np.all(value > 0):
        raise DemlawsError(f"{name} must be positive and finite, got {np.min(value)!r} (dimensionless)")
    return value


def _hertz_overlap(f, k):
    s = np.cbrt(0.75 * f) ** 2
    with np.errstate(invalid="ignore", divide="ignore"):
        return s, np.where(f > 0, 2 * s / (3 * f) * k, 0.0)


def _flat_approach(f, parameter):
    """U and dU/d ln f of the pressure H_m on a disc of radius a, without the constant: rim on the sphere's surface."""
    a = np.sqrt(math.sqrt(2) * f / (math.pi * parameter))
    return a * a + 2 * parameter * a / math.pi, a * a + parameter * a / math.pi


@lru_cache(maxsize=512)
def curve(model, parameter, lowest=LOWEST_FORCE, highest=HIGHEST_FORCE):
    """The Curve of one parameter, solved once (0.1 to 0.3 s) and kept.

    model: "yip-venart" (parameter N_H) or "greenwood-tripp" (mu); the force range is that of the solved points.
    """
    from scipy.interpolate import BPoly

    solver = _Solver(model, _check(model, parameter))
    low, high = math.log(lowest), math.log(highest)
    solver.reach(low)
    solver.reach(high)
    points = _columns(solver.points)
    f, k = points.force, points.stiffness
    s = np.cbrt(0.75 * f) ** 2
    slope = f / k - (2 / 3) * s
    bend = f / k - f * f * points.curvature / k**3 - (4 / 9) * s
    offset = BPoly.from_derivatives(np.log(f), np.stack([points.approach - s, slope, bend], 1))
    return Curve(model, float(parameter), points, np.log(f), offset, bool(solver.flat))


def _check(model, parameter):
    if model not in _MODELS:
        raise DemlawsError(f"unknown model {model!r}: choose one of {', '.join(_MODELS)}")
    low, high = _RANGE
    if not (low <= parameter <= high):
        raise DemlawsError(
            f"{model}: {_MODELS[model].parameter} = {parameter!r} is outside {low:g} to {high:g} (dimensionless); "
            "check hardness, roughness and radius"
        )
    return float(parameter)


def _columns(rows):
    return MasterCurve(*(np.array(column, float) for column in zip(*rows, strict=True)))


def solve(model, parameter, forces):
    """MasterCurve at the dimensionless forces f, for N_H = (H_m / E*) sqrt(8 R / sigma) or mu from 0.05 to 1e5.

    More accurate than `curve` only in that each load is solved for; beyond p(0) = 0.997 H_m the flat-topped closed form.
    """
    parameter = _check(model, parameter)
    forces = np.atleast_1d(_positive(forces, "force"))
    if forces.min() < 1e-13 or forces.max() > 1e8:
        raise DemlawsError(f"force {forces.min():g} to {forces.max():g} is outside 1e-13 to 1e8 (dimensionless)")
    solver = _Solver(model, parameter)
    solver.reach(min(math.log(LOWEST_FORCE), math.log(forces.min())))
    rows = {}
    for force in np.unique(forces):
        row = solver.reach(math.log(force))
        solved = solver.history[-1].log_force > math.log(force) - 1e-9
        rows[force] = row if solved else _flat_point(curve(model, parameter), force)
    return _columns([rows[force] for force in forces])


def _flat_point(whole, force):
    """A point of a crushed contact: uniform pressure H_m on a disc."""
    u, du = whole._approach(np.log(force))
    hertz_radius = (3 * force / (8 * math.sqrt(2))) ** (1 / 3)
    radius = math.sqrt(math.sqrt(2) * force / (math.pi * whole.parameter))
    central = whole.parameter / (8 * hertz_radius / math.pi)
    return u, force, force / du, central, 3 * math.pi / 8 * radius / hertz_radius, 1 / (2 * hertz_radius**2), math.nan
