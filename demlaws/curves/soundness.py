"""Whether a curve of first loading is one that engines can use: finite, rising, continuous, its derivative and inverse right.

One error names the fault, the overlap [m] and the value before any engine uses the law: for user-defined laws when they are
bound to a contact, for a function when it becomes a table. `dl.check_law` lists the same checks, each with a narrower limit.
"""

import math
import re
from collections import Counter
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np

from demlaws.core.dispatch import energy, first_loading, inverse, kernels_of
from demlaws.core.loops import bind_params, follow_loop, force_loop, params_at
from demlaws.core.numba_compat import loop
from demlaws.errors import DemlawsError

LOWEST, HIGHEST = 1e-9, 0.1
"""Range of the overlaps over the radius that are checked."""
_POINTS, _THINNED = 1801, 30
"""Some 64 panels in an octave: of a kernel without a kink their integrals are exact to rounding."""
_DENSE = 200_000
"""Overlaps at which only the values are checked: a feature narrower than 1e-4 of its overlap may pass."""
_SEATED = 0.05
"""K δ/P at the lowest overlap below which a force does not go to 0 with the overlap."""
_RETURN = 1e-3
"""Work over the largest energy held by which a law's own rule may miss its balance: the paths are summed up by trapezoids."""
EPS = float(np.finfo(float).eps)
_X, _W = np.polynomial.legendre.leggauss(4)
DERIVATIVE = 1e-4
"""Relative difference of stiffness and derivative of the force from which a law is refused."""
INVERSE, ENERGY, EQUIVALENT = 1e-7, 1e-4, 1e-7
_passed = Counter()  # types of a law, or of a law and its rule → contacts on which it was found sound
_FULLY = 30
"""Contacts on which a law is fully checked in a process; then only for values that are not finite, negative or falling:
a fit binds it thousands of times."""
_NEEDED = {"Shape": ("scale",), "Params": ("first_loading", "inverse", "energy")}


@loop
def curve_loop(p, overlap):
    """All that `first_loading` says of one contact, a row each."""
    values = np.empty((4, overlap.size))
    for i in range(overlap.size):
        values[0, i], values[1, i], values[2, i], values[3, i] = first_loading(p, overlap[i])
    return values


@loop
def back_loop(p, overlap):
    """Overlap of the force at each overlap, and the work up to it."""
    back, work = np.empty(overlap.size), np.empty(overlap.size)
    for i in range(overlap.size):
        force = first_loading(p, overlap[i])[0]
        back[i] = inverse(p, force) if force > 0.0 else 0.0
        work[i] = energy(p, overlap[i])
    return back, work


class Check(NamedTuple):
    """A measured property of a law."""

    what: str
    value: float  # measured; the check passes at `allowed` or below
    allowed: float
    where: float = math.nan  # overlap [m] of the worst
    note: str = ""
    fault: str | None = None  # why a user-defined law is refused for it

    @property
    def passed(self) -> bool:
        """Whether the value is within what is allowed."""
        return self.value <= self.allowed


class Values(NamedTuple):
    """A curve at some overlaps."""

    force: np.ndarray
    stiffness: np.ndarray
    equivalent: np.ndarray
    area: np.ndarray


def values_of(params, overlap):
    """`Values` of one contact's params."""
    return Values(*curve_loop(params, overlap))


def fault_of_values(overlap: np.ndarray, force: np.ndarray, stiffness: np.ndarray | None = None) -> str | None:
    """What is wrong with forces [N] (and stiffnesses) at rising overlaps [m] > 0, or None."""
    falls = np.flatnonzero(force[1:] < force[:-1] * (1.0 - 1e-12))
    first_fall = int(falls[0]) + 1 if falls.size else force.size
    for name, unit, values in (("force", "N", force), ("stiffness", "N/m", stiffness)):
        if values is None:
            continue
        bad = np.flatnonzero(~np.isfinite(values) | (values < 0.0))
        if bad.size and (bad[0] < first_fall or (name == "force" and bad[0] == first_fall)):
            value = float(values[bad[0]])
            what = "must not be negative" if math.isfinite(value) else "must be a finite number"
            return f"at overlap {overlap[bad[0]]:.6g} m the {name} is {value:g} {unit}: it {what}"
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

    In each interval the rise of the force is compared with the integral of the stiffness; one where they differ is halved
    until the jump or the wrong derivative stands alone. A kink of the stiffness is neither.
    """

    def differences(edges):
        """Rise of the force and integral of the stiffness in each panel, force at its end."""
        force = evaluate(edges)[0]
        return np.diff(force), integrals(lambda at: evaluate(at)[1], edges), force[1:]

    rise, integral, force = differences(overlap)
    with np.errstate(invalid="ignore", divide="ignore"):
        off = np.where(force > 0.0, np.abs(rise - integral) / force, 0.0)
    for i in np.argsort(-off)[:6]:
        if not off[i] > 1e-6:
            break
        a, b = float(overlap[i]), float(overlap[i + 1])
        while b - a > 1e-9 * b:
            middle = 0.5 * (a + b)
            rise, integral, force = differences(np.array([a, middle, b]))
            worse = int(np.argmax(np.abs(rise - integral)))
            if abs(rise[worse] - integral[worse]) <= DERIVATIVE * max(rise[worse], integral[worse]) + 1e-15 * force[worse]:
                break
            a, b = (a, middle) if worse == 0 else (middle, b)
        else:
            (low, high), (first, second) = evaluate(np.array([a, b]))
            slope = (high - low) / (b - a)
            if high - low > 30.0 * max(first, second) * (b - a) and high - low > 1e-7 * high:
                return f"at overlap {b:.6g} m the force jumps from {low:.6g} N to {high:.6g} N: it must be continuous"
            least, most = min(first, second), max(first, second)
            if not least * (1.0 - DERIVATIVE) <= slope <= most * (1.0 + DERIVATIVE):
                return f"at overlap {b:.6g} m the stiffness is {second:.6g} N/m, the derivative of the force {slope:.6g} N/m"
    return None


def largest_of(what, errors, at, allowed, fault=None):
    """A `Check` of the largest error."""
    errors = np.where(np.isfinite(errors), errors, np.inf)
    k = int(np.argmax(errors))
    return Check(what, float(errors[k]), allowed, float(at[k]) if errors[k] > 0.0 else math.nan, fault=fault)


def _relative(values, expected):
    """|values/expected - 1|; 0 where both are 0, as below the overlap at which a force begins."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(values == expected, 0.0, np.abs(values / expected - 1.0))


def _panel_errors(rise, integral):
    """Relative difference in each panel, the least of three neighbours: a kink falsifies the integral of its own panel."""
    off = np.pad(_relative(rise, integral), 1, mode="edge")
    return np.min([off[:-2], off[1:-1], off[2:]], axis=0)


def curve_checks(params: Any, radius: float, solved: bool = False) -> Iterator[Check]:
    """`Check`s of the curve of one contact's params, the cheapest first. solved: read from cells, whose edges are kinks."""
    overlap = radius * np.geomspace(LOWEST, HIGHEST, _POINTS)
    sample = values_of(params, overlap)
    for at, values in ((overlap, sample), (radius * np.geomspace(LOWEST, HIGHEST, _DENSE), None)):
        fault = fault_of_values(at, *(values or values_of(params, at))[:2])
        yield Check(f"force not finite, negative or falling, of {at.size}", float(fault is not None), 0.0, fault=fault)

    def curve(at):
        return values_of(params, at)[:2]

    first, slope = sample.force[0], sample.stiffness[0]
    fault = None
    if not solved and first > 0.0 and slope * overlap[0] < _SEATED * first:
        fault = (
            f"at overlap {overlap[0]:.6g} m the force is {first:.6g} N and the stiffness {slope:.6g} N/m: the force must go "
            "to 0 with the overlap"
        )
    yield Check("force at overlap 0 is not 0", float(fault is not None), 0.0, fault=fault)
    fault = fault_of_slope(curve, overlap)
    yield Check("force jumps, or stiffness is not its derivative", float(fault is not None), 0.0, fault=fault)
    errors = _panel_errors(np.diff(sample.force), integrals(lambda at: curve(at)[1], overlap))
    yield largest_of("stiffness against derivative, relative", errors, overlap, 1e-5 if solved else 1e-11)
    hertz = np.cbrt(sample.force / params.hertz_coefficient) ** 2
    for name, values, off in (
        ("Hertz-equivalent overlap", sample.equivalent, _relative(sample.equivalent, hertz)),
        ("a²/R", sample.area, np.where(sample.area < math.inf, _relative(np.minimum(sample.area, hertz), hertz), math.inf)),
    ):
        fault, k = None, int(np.argmax(~(off <= EQUIVALENT)))
        if not off[k] <= EQUIVALENT:
            fault = (
                f"at overlap {overlap[k]:.6g} m, where the force is {sample.force[k]:.6g} N, the third or fourth value of its "
                f"`first_loading`, the {name}, is {values[k]:.6g} m; Hertz's overlap at that force is {hertz[k]:.6g} m"
            )
        yield largest_of(f"{name} against the force, relative", off, overlap, EQUIVALENT, fault)
    yield from _return_checks(params, overlap, sample, solved)


def _return_checks(params, overlap, sample, solved):
    """`Check`s of the inverse and of the energy, of which a user's law may have to search and integrate for.

    `sample`: `Values` at `overlap`, of which one in `_THINNED` is taken.
    """
    expected = integrals(lambda at: values_of(params, at).force, overlap).reshape(-1, _THINNED).sum(axis=1)
    overlap, force, stiffness = (values[::_THINNED] for values in (overlap, sample.force, sample.stiffness))
    back, work = back_loop(params, overlap)
    carries = force > 0.0
    at, load, back = overlap[carries], force[carries], back[carries]
    good = np.isfinite(back) & (back > 0.0)
    again = np.zeros(at.size)
    again[good] = values_of(params, back[good]).force
    slope = stiffness[carries] * at / load  # what an error of the overlap is multiplied by in the force
    off = _relative(again, load)
    fault, k = None, int(np.argmax(~(off <= INVERSE)))
    if not off[k] <= INVERSE:
        fault = f"at overlap {at[k]:.6g} m the force is {load[k]:.6g} N, but the inverse gives {back[k]:.6g} m for it"
    yield largest_of("force of the overlap of a force (1: rounding)", off / (EPS * (64.0 + 16.0 * slope)), at, 3.0, fault)
    with np.errstate(divide="ignore"):  # a stiffness of 0
        off = _relative(back, at) / (EPS * (16.0 + 64.0 / slope))
    yield largest_of("overlap of the force of an overlap (1: rounding)", off, at, 10.0 if solved else 1.0)

    increments, fault = np.diff(work), None
    wrong = ~(np.abs(increments - expected) <= ENERGY * expected)
    if np.any(wrong):
        k = int(np.argmax(wrong))
        a, b = overlap[k], overlap[k + 1]
        fault = f"from overlap {a:.6g} m to {b:.6g} m the energy grows by {increments[k]:.6g} J, ∫P dδ by {expected[k]:.6g} J"
    elif not 0.0 <= work[0] <= force[0] * overlap[0] * (1.0 + 1e-9):
        at = overlap[0]
        fault = f"at overlap {at:.6g} m the energy is {work[0]:.6g} J, the force {force[0]:.6g} N: ∫P dδ cannot be that"
    errors = _panel_errors(increments, expected)
    yield largest_of("energy against ∫P dδ, relative", errors, overlap, 1e-8 if solved else 1e-10, fault)


def refuse_unsound(definition, shape, contact, options) -> None:
    """Raise DemlawsError for an inadmissible law on this contact: one fault, with its overlap and value."""
    name = f"law {definition.name!r}"
    _refuse_unbound(name, "Shape", type(shape))
    try:
        params = bind_params(shape, contact)
        _refuse_unbound(name, "Params", type(params))
        if "hertz_coefficient" not in getattr(params, "_fields", ()):
            raise DemlawsError(
                f"{name}: its Params, {type(params).__qualname__}, must hold hertz_coefficient = (4/3) E* √R [N/m^1.5]"
            )
        content = definition.prepare, type(shape), type(params)
        for index in contact.representatives():
            radius = float(np.broadcast_to(contact.radius, contact.size or 1)[index])
            one, fully = params_at(params, index), _passed[content] < _FULLY
            checks = curve_checks(one, radius)
            text = next((check.fault for check in (checks if fully else [next(checks)]) if check.fault), None)
            if text is not None:
                arguments = "".join(f", {n} = {v!r:.40}" for n, v in options.items())
                raise DemlawsError(f"{name} cannot be used (R = {radius:g} m{arguments}): {text}")
        _refuse_array(name, params, contact)
        _passed[content] += 1
    except Exception as error:
        if type(error).__module__.startswith("numba"):
            raise DemlawsError(f"{name}: its functions do not compile: {_first_line(error)}") from error
        raise


def _refuse_array(name, params, contact):
    """Each of an array of contacts at a few overlaps: those that stand for all may miss one."""
    if contact.size is None:
        return
    for share in (1e-6, 1e-4, 1e-2):
        overlap = share * np.broadcast_to(np.asarray(contact.radius, float), contact.size).copy()
        force, stiffness = force_loop(params, overlap)
        bad = np.flatnonzero(~(np.isfinite(force) & np.isfinite(stiffness) & (force >= 0.0) & (stiffness >= 0.0)))
        if bad.size:
            k = int(bad[0])
            raise DemlawsError(
                f"{name} cannot be used on contact {k} (R = {overlap[k] / share:g} m): at overlap {overlap[k]:.6g} m the force "
                f"is {force[k]:g} N, the stiffness {stiffness[k]:g} N/m"
            )


def refuse_unsound_rule(name, rule, params, radius) -> None:
    """Raise DemlawsError where a law's own rule (its `Rule`) is none on one contact: first loading that is not the law's, a
    jump where loading turns, work that is returned or that its energies do not account for, a state that outlives contact."""
    content = type(params), type(rule.tag)
    if _passed[content] >= _FULLY:
        return
    for share in (1e-7, 1e-5, 1e-3, 2e-2):
        text = _fault_of_rule(rule, params, share * radius)
        if text is not None:
            raise DemlawsError(f"law {name!r} cannot be used with its rule {rule.name!r} (R = {radius:g} m): {text}")
    _passed[content] += 1


def _fault_of_rule(rule, params, top):
    """Fault on a path from a virgin contact to the overlap `top`, half unloading, reloading, separation and loading again."""
    steps = 400
    rise = np.linspace(0.0, 1.0, steps + 1)[1:]
    back = np.linspace(1.0, 0.5, steps + 1)[1:]
    off = np.linspace(1.0, 0.0, 2 * steps + 1)[1:]
    path = top * np.concatenate([rise, [1.0 - 1e-9], back, back[::-1], [1.0], off, [-1e-3], rise])
    state = tuple(np.zeros(1) for _ in rule.state)
    history = tuple(np.zeros(path.size) for _ in rule.state)
    force, stiffness, stored, loss = (np.empty(path.size) for _ in range(4))
    follow_loop(rule.tag, params, path, state, history, force, stiffness, stored, loss)
    for what, unit, values in (("force", "N", force), ("stiffness", "N/m", stiffness), ("stored energy", "J", stored)):
        bad = np.flatnonzero(~np.isfinite(values) | (values < -1e-12 * np.nanmax(np.abs(values))))
        if bad.size:
            return f"at overlap {path[bad[0]]:.6g} m the {what} is {values[bad[0]]:.6g} {unit} (point {bad[0]} of its path)"
    first = values_of(params, path[:steps]).force
    again = slice(path.size - steps, None)
    for where, branch in (("on first loading", force[:steps]), ("on loading a contact that had parted", force[again])):
        wrong = np.abs(branch - first) > 1e-9 * first + 1e-12 * first[-1]
        if np.any(wrong):
            k = int(np.argmax(wrong))
            return f"{where}, at overlap {path[k]:.6g} m, the rule gives {branch[k]:.6g} N, the law {first[k]:.6g} N"
    # a rule may unload much more steeply than the law loads: a change that the stiffness explains is not a jump
    explained = 1.1 * abs(stiffness[steps]) * (path[steps - 1] - path[steps])
    if abs(force[steps] - force[steps - 1]) > 1e-6 * force[steps - 1] + explained:
        before, after = force[steps - 1], force[steps]
        return f"where loading turns, at overlap {top:.6g} m, the force jumps from {before:.6g} N to {after:.6g} N"
    apart = path.size - steps - 1
    last = {name: float(values[apart]) for name, values in zip(rule.state, history, strict=True)}
    rest = [f"{name} = {value:.6g}" for name, value in last.items() if value != 0.0]
    if rest:
        return f"at overlap {path[apart]:.6g} m, after the bodies have parted, it remembers {', '.join(rest)}: all must be 0"
    pieces = 0.5 * np.diff(path, prepend=0.0) * (force + np.concatenate([[0.0], force[:-1]]))
    work = np.cumsum(pieces)[:apart]
    peak_work = float(work[steps - 1])
    for begin, end, what in ((steps, 3 * steps + 1, "half unloaded and reloaded"), (0, apart - 1, "up and back to 0")):
        gain = float(work[end] - (work[begin] if begin else 0.0))
        if gain < -_RETURN * peak_work:
            return f"loaded to overlap {top:.6g} m and {what}, it returns {-gain:.6g} J more than it took ({peak_work:.6g} J)"
    total = (stored + loss)[:apart]
    wrong = np.abs(total - work) > 5.0 * _RETURN * peak_work
    if np.any(wrong):
        k = int(np.argmax(wrong))
        return (
            f"at overlap {path[k]:.6g} m (point {k} of its path) the rule gives {stored[k]:.6g} J stored and {loss[k]:.6g} J "
            f"dissipated, ∫P dδ is {work[k]:.6g} J"
        )
    return None


def _refuse_unbound(name, kind, cls):
    missing = [f for f in _NEEDED[kind] if f not in kernels_of(cls)]
    if missing:
        raise DemlawsError(
            f"{name}: its {kind}, {cls.__qualname__}, binds no {', '.join(missing)} (demlaws.core.dispatch.bind)"
        )


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
    length = contact.roughness if rough else contact.radius
    u = np.geomspace(1e-6, 0.05 * contact.radius / length, 60)

    def curve(other):
        scale = other.roughness if rough else other.radius
        params = bind_params(definition.shape(other, **law.options), other)
        return values_of(params, u * scale).force / (params.hertz_coefficient * scale**1.5)

    base = curve(contact)
    factors = {"radius": 2.0, "modulus": 3.0, "roughness": 1.7}
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
