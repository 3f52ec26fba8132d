"""Whether a curve of first loading is one that engines can use: finite, rising, continuous, its derivative and inverse right.

Each property is a `Check` with two limits: `dl.check_law` reports it above the first, a user-defined law is refused above the
second when it is bound to a contact. A function is checked by the same measurements when it becomes a table.
"""

import math
import re
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numba
import numpy as np

from demlaws.core.dispatch import energy, first_loading, inverse
from demlaws.core.loops import bind_params, follow_loop, params_at
from demlaws.core.numba_compat import loop
from demlaws.errors import DemlawsError

LOWEST, HIGHEST = 1e-9, 0.1
"""Range of the overlaps over the radius that are checked."""
_POINTS, _THINNED = 1801, 30
"""64 panels per octave: of a kernel without a kink their integrals are exact to rounding."""
_DENSE = 200_000
"""Overlaps at which only the values are checked: a feature narrower than 1e-4 of its overlap may pass."""
_SEATED = 0.05
"""K δ/P at the lowest overlap below which a force does not go to 0 with the overlap."""
EPS = float(np.finfo(float).eps)
_X, _W = np.polynomial.legendre.leggauss(4)
DERIVATIVE = 1e-4
"""Relative difference of stiffness and derivative of the force from which a law is refused."""


@loop
def curve_loop(shape, p, overlap):
    """All that `first_loading` says of one contact, a row each: force, stiffness, Hertz-equivalent overlap, a²/R."""
    values = np.empty((4, overlap.size))
    for i in range(overlap.size):
        values[0, i], values[1, i], values[2, i], values[3, i] = first_loading(shape, p, overlap[i])
    return values


@loop
def back_loop(shape, p, overlap):
    """Overlap of the force at each overlap, and the work up to it."""
    back, work = np.empty(overlap.size), np.empty(overlap.size)
    for i in range(overlap.size):
        force = first_loading(shape, p, overlap[i])[0]
        back[i] = inverse(shape, p, force) if force > 0.0 else 0.0
        work[i] = energy(shape, p, overlap[i])
    return back, work


class Check(NamedTuple):
    """A measured property of a law."""

    what: str
    value: float
    allowed: float  # the check passes at this value or below
    where: float = math.nan  # overlap [m] of the worst
    note: str = ""
    refused: float = math.inf  # a user-defined law is refused above this value

    @property
    def passed(self) -> bool:
        """Whether the value is within what is allowed."""
        return self.value <= self.allowed

    @property
    def fault(self) -> str | None:
        """Why a user-defined law is refused, or None."""
        if self.value <= self.refused:
            return None
        return self.note or f"at overlap {self.where:.6g} m, {self.what}: {self.value:.3g}, at most {self.refused:g} is allowed"


def _refusal(what, fault):
    """A `Check` of a property that a law has or has not: `fault` (text) or None."""
    return Check(what, float(fault is not None), 0.0, note=fault or "", refused=0.0)


def fault_of_values(overlap: np.ndarray, force: np.ndarray, stiffness: np.ndarray | None = None) -> str | None:
    """What is wrong with forces [N] (and stiffnesses) at rising overlaps [m] > 0, or None."""
    falls = np.flatnonzero(force[1:] < force[:-1] * (1.0 - 1e-12))
    first_fall = int(falls[0]) + 1 if falls.size else force.size
    for name, unit, values in (("force", "N", force), ("stiffness", "N/m", stiffness)):
        if values is None:
            continue
        bad = np.flatnonzero(~np.isfinite(values) | (values < 0.0))
        if bad.size and bad[0] <= first_fall:
            value = float(values[bad[0]])
            return f"at overlap {overlap[bad[0]]:.6g} m the {name} is {value:g} {unit}: it must be finite and not negative"
    if falls.size:
        i = first_fall - 1
        return (
            f"from overlap {overlap[i]:.6g} m to {overlap[i + 1]:.6g} m the force falls from {force[i]:.6g} N to "
            f"{force[i + 1]:.6g} N: it must rise with the overlap"
        )
    if not force[-1] > 0.0:
        return f"up to overlap {overlap[-1]:.6g} m the force is 0 N: it must rise with the overlap"
    return None


def integrals(function: Callable, edges: np.ndarray) -> np.ndarray:
    """∫ function dδ over each panel between `edges`, by Gauss's rule."""
    half = 0.5 * np.diff(edges)
    nodes = edges[:-1, None] + half[:, None] * (1.0 + _X)
    return half * (function(nodes.ravel()).reshape(nodes.shape) @ _W)


def fault_of_slope(evaluate: Callable, overlap: np.ndarray) -> str | None:
    """Jump of the force, or stiffness that is not its derivative, of `evaluate` (overlaps → force, stiffness); or None.

    In each panel the rise of the force is compared with the integral of the stiffness. One where they differ is divided, and
    its worst part again, until the jump or the wrong derivative stands alone: a kink of the stiffness is neither.
    """

    def differences(edges):
        force = evaluate(edges)[0]
        return np.abs(np.diff(force) - integrals(lambda at: evaluate(at)[1], edges)), force[1:]

    difference, force = differences(overlap)
    off = difference / np.where(force > 0.0, force, np.inf)
    for i in np.argsort(-off)[:6]:
        if not off[i] > 1e-6:
            break
        a, b = float(overlap[i]), float(overlap[i + 1])
        while b - a > 1e-9 * b:
            edges = np.linspace(a, b, 11)
            worst = int(np.argmax(differences(edges)[0]))
            a, b = float(edges[worst]), float(edges[worst + 1])
        (low, high), slopes = evaluate(np.array([a, b]))
        derivative = (high - low) / (b - a)
        if not (1.0 - DERIVATIVE) * min(slopes) <= derivative <= (1.0 + DERIVATIVE) * max(slopes):
            return (
                f"at overlap {b:.6g} m the stiffness is {slopes[1]:.6g} N/m, the derivative of the force {derivative:.6g} N/m, "
                f"from {low:.6g} N to {high:.6g} N: the force must be continuous and the stiffness its derivative"
            )
    return None


def largest_of(what, errors, at, allowed, refused=math.inf):
    """A `Check` of the largest error."""
    errors = np.where(np.isfinite(errors), errors, np.inf)
    k = int(np.argmax(errors))
    return Check(what, float(errors[k]), allowed, float(at[k]) if errors[k] > 0.0 else math.nan, refused=refused)


def _relative(values, expected):
    """|values/expected - 1|; 0 where both are 0, as below the overlap at which a force begins."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(values == expected, 0.0, np.abs(values / expected - 1.0))


def _panel_errors(rise, integral):
    """Relative difference in each panel, the least of three neighbours: a kink falsifies the integral of its own panel."""
    off = np.pad(_relative(rise, integral), 1, mode="edge")
    return np.min([off[:-2], off[1:-1], off[2:]], axis=0)


def curve_checks(shape: Any, params: Any, radius: float, solved: bool = False) -> Iterator[Check]:
    """`Check`s of the curve of one contact's params, the cheapest first. solved: read from cells, whose edges are kinks."""
    end = getattr(params, "largest_overlap", math.inf)
    top = min(HIGHEST * radius, end * (1.0 - 1e-12))
    overlap, dense = (np.geomspace(LOWEST * radius, top, count) for count in (_POINTS, _DENSE))
    force, stiffness, equivalent, area = curve_loop(shape, params, overlap)
    yield _refusal("force not finite, negative or falling", fault_of_values(overlap, force, stiffness))
    yield _refusal("the same at 200,000 overlaps", fault_of_values(dense, *curve_loop(shape, params, dense)[:2]))
    fault = None
    if not solved and force[0] > 0.0 and stiffness[0] * overlap[0] < _SEATED * force[0]:
        fault = f"at overlap {overlap[0]:.6g} m the force is {force[0]:.6g} N: it must go to 0 with the overlap"
    yield _refusal("force at overlap 0 is not 0", fault)
    fault = fault_of_slope(lambda at: curve_loop(shape, params, at)[:2], overlap)
    yield _refusal("force jumps, or stiffness is not its derivative", fault)
    errors = _panel_errors(np.diff(force), integrals(lambda at: curve_loop(shape, params, at)[1], overlap))
    yield largest_of("stiffness against derivative, relative", errors, overlap, 1e-5 if solved else 1e-11)
    hertz = np.cbrt(force / params.hertz_coefficient) ** 2
    contact_area = np.where(area < math.inf, np.minimum(area, hertz), math.nan)
    for name, values in (("Hertz-equivalent overlap", equivalent), ("a²/R", contact_area)):
        yield largest_of(f"{name} against the force, relative", _relative(values, hertz), overlap, 1e-7, 1e-7)
    yield from _return_checks(shape, params, overlap, solved)


def _return_checks(shape, params, overlap, solved):
    """`Check`s of the inverse and of the energy, of which a user's law may have to search and integrate for."""
    expected = integrals(lambda at: curve_loop(shape, params, at)[0], overlap).reshape(-1, _THINNED).sum(axis=1)
    overlap = overlap[::_THINNED]
    force, stiffness = curve_loop(shape, params, overlap)[:2]
    back, work = back_loop(shape, params, overlap)
    carries = force > 0.0
    at, load, back = overlap[carries], force[carries], back[carries]
    again = curve_loop(shape, params, np.where(back > 0.0, back, math.nan))[0]
    slope = stiffness[carries] * at / load  # what an error of the overlap is multiplied by in the force
    errors = _relative(again, load) / (EPS * (64.0 + 16.0 * slope))
    yield largest_of("force of the overlap of a force (1: rounding)", errors, at, 3.0, 1e6)
    with np.errstate(divide="ignore"):  # a stiffness of 0
        errors = _relative(back, at) / (EPS * (16.0 + 64.0 / slope))
    yield largest_of("overlap of the force of an overlap (1: rounding)", errors, at, 10.0 if solved else 1.0)
    errors = _panel_errors(np.diff(work), expected)
    if not 0.0 <= work[0] <= force[0] * overlap[0] * (1.0 + 1e-9):
        errors[0] = math.inf
    yield largest_of("energy against ∫P dδ, relative", errors, overlap, 1e-8 if solved else 1e-10, 1e-4)


def refuse_unsound(definition, shape, contact, options) -> None:
    """Raise DemlawsError for an inadmissible law on this contact: one fault, with its overlap and value."""
    name = f"law {definition.name!r}"
    try:
        params = bind_params(shape, contact)
        for index in contact.representatives():
            radius = float(np.broadcast_to(contact.radius, contact.size or 1)[index])
            checks = curve_checks(shape, params_at(params, index), radius)
            text = next((check.fault for check in checks if check.fault), None)
            if text is not None:
                arguments = "".join(f", {n} = {v!r:.40}" for n, v in options.items())
                raise DemlawsError(f"{name} cannot be used (R = {radius:g} m{arguments}): {text}")
    except (numba.errors.NumbaError, AttributeError) as error:  # a kernel, or a field of its Params, that is missing, too
        raise DemlawsError(f"{name}: its functions do not compile: {_first_line(error)}") from error


def refuse_unsound_rule(name, rule, shape, params, radius) -> None:
    """Raise DemlawsError where a law's own rule (its `Rule`) is none on one contact."""
    for share in (1e-7, 1e-5, 1e-3, 2e-2):
        top = min(share * radius, 0.999 * getattr(params, "largest_overlap", math.inf))
        text = _fault_of_rule(rule, shape, params, top)
        if text is not None:
            raise DemlawsError(f"law {name!r} cannot be used with its rule {rule.name!r} (R = {radius:g} m): {text}")


def _fault_of_rule(rule, shape, params, top):
    """Fault on a path from a new contact to the overlap `top`, half unloading, reloading, separation and loading again.

    First loading is the law's, work is stored or dissipated, the energy dissipated never falls, and no state outlives contact.
    """
    steps = 400
    rise, back = np.linspace(0.0, 1.0, steps + 1)[1:], np.linspace(1.0, 0.5, steps + 1)[1:]
    off = np.linspace(1.0, 0.0, 2 * steps + 1)[1:]
    path = top * np.concatenate([rise, [1.0 - 1e-9], back, back[::-1], [1.0], off, [-1e-3], rise])
    apart = path.size - steps - 1
    state = tuple(np.zeros(1) for _ in rule.state)
    history = np.zeros((len(rule.state), path.size))
    force, stiffness, stored, loss = np.empty((4, path.size))
    follow_loop(rule.tag, shape, params, path, state, tuple(history), force, stiffness, stored, loss)
    work = np.cumsum(0.5 * np.diff(path, prepend=0.0) * (force + np.append(0.0, force[:-1])))
    peak, first = work[steps - 1], curve_loop(shape, params, path[:steps])[0]
    expected = np.concatenate([first, force[steps : apart + 1], first])
    tolerance = 5e-3 * peak  # trapezoids
    for what, good in (
        ("finite, positive numbers are needed", np.isfinite(stiffness) & (force >= 0.0) & (stored >= -1e-9 * peak)),
        ("first loading must be the law's", np.abs(force - expected) <= 1e-9 * expected + 1e-12 * first[-1]),
        ("work must be stored or dissipated", np.abs(stored + loss - work)[:apart] <= tolerance),
        ("work must not be returned", np.diff(loss[:apart], prepend=0.0) >= -1e-9 * peak),
        ("a state must be 0 after the bodies have parted", np.all(history[:, apart : apart + 1] == 0.0, axis=0)),
    ):
        if not np.all(good):
            k = apart if good.size == 1 else int(np.argmin(good))
            return (
                f"at overlap {path[k]:.6g} m (point {k} of its path to {top:.6g} m and back) the rule gives {force[k]:.6g} N, "
                f"{stored[k]:.6g} J stored and {loss[k]:.6g} J dissipated, where ∫P dδ is {work[k]:.6g} J: {what}"
            )
    return None


_TELLING = ("Unknown attribute", "Untyped global", "NameError", "No implementation of function", "Cannot unify")


def _first_line(error):
    """The line of numba's message that states the fault, without colours."""
    text = re.sub(r"\x1b\[\d*m", "", str(error))
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    informative = [line for line in lines if line.startswith(_TELLING)]
    text = (informative[-1:] or lines or [type(error).__name__])[0][:200]
    if helper := re.match(r"Untyped global name '(\w+)': .*<class 'function'>", text):
        return f"{helper[1]} is a plain Python function: put @numba.njit before it"
    return text


def refuse_unless_collapses(law, contact) -> None:
    """Raise DemlawsError where the curve of a law (anything with its definition and options) differs between contacts."""
    definition = law.definition
    if contact.size is not None:
        return
    rough = definition.length == "roughness" and not contact.is_smooth
    length = contact.sigma if rough else contact.radius
    u = np.geomspace(1e-6, 0.05 * contact.radius / length, 60)

    def curve(other):
        scale = other.sigma if rough else other.radius
        shape = definition.shape(other, **law.options)
        params = bind_params(shape, other)
        return curve_loop(shape, params, u * scale)[0] / (params.hertz_coefficient * scale**1.5)

    base = curve(contact)
    factors = {"radius": 2.0, "modulus": 3.0, "sigma": 1.7}
    for changes in (
        {name: factor * getattr(contact, name)} for name, factor in factors.items() if getattr(contact, name) is not None
    ):
        other = curve(contact.with_values(**changes))
        off = np.abs(other / base - 1.0)
        k = int(np.nanargmax(off)) if not np.all(np.isnan(off)) else 0
        if not off[k] <= 1e-9:
            what = ", ".join(f"{name} = {value:g}" for name, value in changes.items())
            raise DemlawsError(
                f"law {definition.name!r} declares one curve for all contacts (collapses=True), but with {what} the force that "
                f"this contact has at overlap {u[k] * length:.6g} m, made dimensionless, is {other[k] / base[k]:.6g} times as "
                "large: give its Definition collapses=False"
            )
