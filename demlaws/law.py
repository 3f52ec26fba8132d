"""What a law is to its user: force, stiffness, inverse, energy, paths and batches, and the registry of laws.

The compiled loops at the top know any law and any unloading rule through `demlaws.dispatch`; `Law` checks input, keeps
units and shapes, and raises errors.
"""

import importlib
import math
import os
import warnings
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np

from demlaws import dispatch
from demlaws.dispatch import gather, scatter, stored_and_dissipated
from demlaws.errors import DemlawsError, ValidityWarning
from demlaws.fastmath import interleave, loop
from demlaws.laws.definition import Definition
from demlaws.unloading import GIVEN, RULES, STATE_NAMES, Elastic, JoinedParams, JoinedShape

SMOOTHEST = 1e-40
"""σ/R below which roughness counts as this: no effect left in double precision, and no division by zero at σ = 0."""


@loop
def scale_one(shape, radius, modulus, roughness):
    return dispatch.scale(shape, radius, modulus, roughness)


@loop
def scale_loop(shape, radius, modulus, roughness, params):
    for i in range(radius.size):
        scatter(params, i, dispatch.scale(shape, radius[i], modulus[i], roughness[i]))


@loop
def evaluate_loop(rule, params, overlap, state, force, stiffness):
    finite = True
    params = dispatch.fix_tables(params)
    interleave(4)
    for i in range(overlap.size):
        p = gather(params, i)
        new_force, new_stiffness, new_state = dispatch.step(rule, p, float(overlap[i]), gather(state, i))
        scatter(state, i, new_state)
        force[i] = new_force
        stiffness[i] = new_stiffness
        # last, because LLVM loses the hint where the loop ends in an inlined call
        finite &= new_force - new_force == 0.0
    return finite


@loop
def inverse_loop(params, force, overlap):
    for i in range(force.size):
        overlap[i] = dispatch.inverse(gather(params, i), force[i]) if force[i] > 0.0 else 0.0


@loop
def energy_loop(params, overlap, energy):
    for i in range(overlap.size):
        energy[i] = dispatch.energy(gather(params, i), overlap[i]) if overlap[i] > 0.0 else 0.0


@loop
def unload_loop(rule, p, force, state, overlap):
    for i in range(force.size):
        overlap[i] = dispatch.unloaded(rule, p, force[i], gather(state, 0))


@loop
def follow_loop(rule, p, overlap, state, history, force, stiffness, stored, dissipated):
    """One contact along a path; `state` (arrays of length 1) goes in as it is and comes out as the path leaves it."""
    banked = 0.0
    for i in range(overlap.size):
        old = gather(state, 0)
        if overlap[i] <= 0.0:
            banked += stored_and_dissipated(rule, p, overlap[i], old)[1]
        force[i], stiffness[i], new = dispatch.step(rule, p, overlap[i], old)
        scatter(state, 0, new)
        scatter(history, i, new)
        energies = stored_and_dissipated(rule, p, overlap[i], new)
        stored[i] = energies[0]
        dissipated[i] = banked + energies[1]


class State:
    """History of n contacts: one array for each quantity that the unloading rule remembers; all zeros is virgin."""

    def __init__(self, names, size, dtype=np.float64):
        self.names = tuple(names)
        self.arrays = tuple(np.zeros(size, dtype) for _ in self.names)

    def __getattr__(self, name):
        if name != "names" and name in self.names:
            return self.arrays[self.names.index(name)]
        raise AttributeError(f"this state has {', '.join(self.names) or 'no quantities'}, not {name!r}")

    def copy(self):
        twin = State(self.names, 0)
        twin.arrays = tuple(array.copy() for array in self.arrays)
        return twin


class Path(NamedTuple):
    """What one contact does along a path: arrays with one entry an overlap, SI units."""

    overlap: np.ndarray
    force: np.ndarray
    stiffness: np.ndarray
    maximum_overlap: np.ndarray
    plastic_overlap: np.ndarray
    stored: np.ndarray
    dissipated: np.ndarray

    @property
    def work(self):
        """Work done on the contact since the path began [J]: ∫P dδ, exact between the points of the path."""
        return self.stored + self.dissipated


def _leaves(params):
    """The per-contact arrays and shared values of a nested tuple, flat."""
    for value in params:
        if isinstance(value, tuple):
            yield from _leaves(value)
        else:
            yield value


def _map_leaves(function, params):
    values = [_map_leaves(function, v) if isinstance(v, tuple) else function(v) for v in params]
    return type(params)(*values) if hasattr(params, "_fields") else tuple(values)


def loading_part(params):
    """Of a law's Shape or Params what belongs to first loading: all of it, unless it has an unloading curve joined to it."""
    return params.loading if isinstance(params, JoinedShape | JoinedParams) else params


def bind_params(shape, contact):
    """Params of a contact, or of an array of contacts: values that differ become arrays, the others stay numbers."""
    roughness = np.maximum(contact.roughness, SMOOTHEST * np.asarray(contact.radius))
    if contact.size is None:
        return scale_one(shape, contact.radius, contact.modulus, float(roughness))
    columns = [
        np.ascontiguousarray(np.broadcast_to(v, contact.size), float) for v in (contact.radius, contact.modulus, roughness)
    ]
    if contact.size == 0:
        raise DemlawsError("the contact's arrays are empty: give at least one contact")
    first = scale_one(shape, *(float(c[0]) for c in columns))
    arrays = _map_leaves(lambda v: np.empty(contact.size) if isinstance(v, float) else v, first)
    scale_loop(shape, *columns, arrays)

    def shared(value):
        one = isinstance(value, np.ndarray) and value.ndim == 1 and np.all(value == value[0])
        return float(value[0]) if one else value

    return _map_leaves(shared, arrays)


class Law:
    """A law of first loading bound to a contact, joined with an unloading rule. Made by `demlaws.law(...)`.

    Overlaps in m, forces in N, stiffnesses in N/m, energies in J. The methods take a number or an array and return the
    same; with a contact that is an array of contacts, arrays have one entry a contact.
    """

    def __init__(self, definition, contact, unloading, options, shape, params=None, unloading_law=None):
        self.definition = definition
        self.name = definition.name
        self.contact = contact
        self.options = dict(options)
        self.unloading = unloading
        self.unloading_law = unloading_law  # the curve of rule "table", else None
        self.rule = RULES[unloading]
        self.state_names = STATE_NAMES[unloading]
        self.state_size = len(self.state_names)
        self.shape = shape
        self.params = bind_params(shape, contact) if params is None else params
        self._limits = None
        self._warned = set()

    def __repr__(self):
        options = "".join(f", {k}={v!r}" for k, v in self.options.items())
        unloading = self.unloading if self.unloading_law is None else self.unloading_law
        return f"demlaws.law({self.name!r}, {self.contact!r}, unloading={unloading!r}{options})"

    # --- joining with a rule

    def joined(self, unloading):
        """The same law of first loading with another unloading rule: a name, or a law or a `Table` as the curve to follow.

        Raises DemlawsError where the pair is not passive.
        """
        rule, curve = rule_and_curve(unloading)
        shape, params = loading_part(self.shape), loading_part(self.params)
        if curve is not None:
            shape, params = joined_shape(self, curve), None
        result = Law(self.definition, self.contact, rule, self.options, shape, params, curve)
        if rule != "elastic":
            # a table's stiffness is what its certificate says, not more exact
            _refuse_unless_passive(
                result, *(getattr(law, "stiffness_error", 0.0) for law in (self, curve) if curve is not None)
            )
        return result

    @property
    def collapses(self):
        """Whether one dimensionless curve (with a given unloading curve: one pair of curves) serves all contacts."""
        if self.unloading_law is None or not self.definition.collapses:
            return self.definition.collapses
        curve = self.unloading_law
        # Hertz's curve has no length of its own
        return curve.collapses and (curve.name == "hertz" or curve.definition.length == self.definition.length)

    def kinks(self):
        """Overlaps [m] at which the stiffness of first loading (of one contact) jumps or has a kink."""
        return list(self.definition.kinks(loading_part(self.params), **self.options))

    # --- first loading

    def _shaped(self, value, name, unit):
        try:
            array = np.asarray(value, dtype=float)
        except (TypeError, ValueError):
            raise DemlawsError(f"{name} must be a number or an array in {unit}, got {value!r}") from None
        if not np.all(np.isfinite(array)):
            raise DemlawsError(f"{name} contains {array[~np.isfinite(array)].flat[0]} {unit}: give finite values")
        size = self.contact.size
        if size is not None:
            try:
                array = np.broadcast_to(array, (size,))
            except ValueError:
                raise DemlawsError(
                    f"{name} has shape {array.shape}, but the law holds {size} contacts: one entry each"
                ) from None
        return np.ascontiguousarray(array), array.shape

    def _both(self, overlap):
        values, shape = self._shaped(overlap, "overlap", "m")
        force, stiffness = np.empty(values.size), np.empty(values.size)
        finite = evaluate_loop(Elastic(), self.params, values.ravel(), (), force, stiffness)
        if not finite:
            raise DemlawsError(self._out_of_range(float(values.max())))
        self._advise(force)
        return force.reshape(shape), stiffness.reshape(shape)

    def _out_of_range(self, overlap):
        radius = float(np.max(self.contact.radius))
        text = f"overlap up to {overlap:g} m gives a force that is not finite: the contact's radius is {radius:g} m"
        end = getattr(self.unloading_law, "largest_force", None)
        return text if end is None else f"{text}, and its unloading curve is a table that ends at {end:g} N"

    def force(self, overlap):
        """Force P [N] of first loading at `overlap` δ [m]; 0 at δ ≤ 0."""
        return _as_given(self._both(overlap)[0])

    def stiffness(self, overlap):
        """Tangent stiffness K = dP/dδ [N/m] of first loading at `overlap` [m]; 0 at δ ≤ 0."""
        return _as_given(self._both(overlap)[1])

    def overlap(self, force):
        """Overlap δ [m] at which first loading carries `force` [N]; 0 at P ≤ 0."""
        values, shape = self._shaped(force, "force", "N")
        result = np.empty(values.size)
        inverse_loop(self.params, values.ravel(), result)
        if not np.all(np.isfinite(result)):
            raise DemlawsError(self._force_out_of_range(float(values.max())))
        self._advise(values)
        return _as_given(result.reshape(shape))

    def _force_out_of_range(self, force):
        return f"force up to {force:g} N has no finite overlap"

    def energy(self, overlap):
        """Work ∫P dδ [J] of first loading to `overlap` [m]."""
        values, shape = self._shaped(overlap, "overlap", "m")
        result = np.empty(values.size)
        energy_loop(self.params, values.ravel(), result)
        return _as_given(result.reshape(shape))

    # --- history

    def new_state(self, n=None, dtype=np.float64):
        """State of n virgin contacts (n: the contact's own size, or 1), kept as float64 or float32."""
        return State(self.state_names, (self.contact.size or 1) if n is None else n, dtype)

    def evaluate(self, overlap, state=None, out=None, parallel=False):
        """Force [N] and tangent stiffness [N/m] of a batch of contacts; `state` is updated in place.

        overlap: 1-D array, float64 or float32 (arithmetic is double throughout), one entry a contact; state: what
        `new_state` returned (not needed by elastic laws); out: (force, stiffness) arrays to write to; parallel=True:
        one thread a core. No input is checked before the loop. An overlap that is NaN, infinite or beyond a table's
        range raises DemlawsError after it: that contact's force is not finite, all others are good.
        """
        overlap = np.asarray(overlap)
        if overlap.ndim != 1 or overlap.dtype not in (np.float64, np.float32):
            raise DemlawsError(f"overlap must be a 1-D float64 or float32 array, got {overlap.dtype} of shape {overlap.shape}")
        n = overlap.size
        if self.contact.size not in (None, n):
            raise DemlawsError(f"{n} overlaps for a law that holds {self.contact.size} contacts: one entry each")
        arrays = () if state is None else state.arrays
        if len(arrays) != len(self.state_names):
            raise DemlawsError(f"{self.unloading} unloading needs the state that law.new_state({n}) returns")
        if any(array.size != n for array in arrays):
            raise DemlawsError(f"the state holds {arrays[0].size} contacts, overlap has {n}")
        force, stiffness = (np.empty_like(overlap), np.empty_like(overlap)) if out is None else out
        if force.shape != overlap.shape or stiffness.shape != overlap.shape:
            raise DemlawsError(f"out holds arrays of shape {force.shape} and {stiffness.shape}, overlap has {overlap.shape}")

        def part(piece):
            params = _map_leaves(lambda v: v[piece] if isinstance(v, np.ndarray) and v.ndim == 1 else v, self.params)
            states = tuple(array[piece] for array in arrays)
            return evaluate_loop(self.rule, params, overlap[piece], states, force[piece], stiffness[piece])

        if parallel and n >= 4096:
            workers, pool = _threads()
            edges = np.linspace(0, n, workers + 1).astype(int)
            finite = all(list(pool.map(part, map(slice, edges[:-1], edges[1:]))))
        else:
            finite = part(slice(None))
        if not finite:
            bad = np.flatnonzero(~np.isfinite(force))
            raise DemlawsError(f"contact {bad[0]} (of {bad.size}): {self._out_of_range(float(overlap[bad[0]]))}")
        return force, stiffness

    def _single(self):
        if self.contact.size is not None:
            raise DemlawsError("a path is followed by one contact; this law holds an array of contacts: use evaluate")
        return self.params

    def follow(self, overlap, state=None):
        """Take one contact along a sequence of overlaps [m], from virgin (or from `state`, updated): a `Path`."""
        values = np.atleast_1d(self._shaped(overlap, "overlap", "m")[0])
        state = self.new_state(1) if state is None else state
        columns = [np.empty(values.size) for _ in range(4)]
        history = tuple(np.zeros(values.size) for _ in self.state_names)
        follow_loop(self.rule, self._single(), values, state.arrays, history, *columns)
        force, stiffness, stored, dissipated = columns
        if not np.all(np.isfinite(force)):
            raise DemlawsError(self._out_of_range(float(values.max())))
        self._advise(force)
        known = dict(zip(self.state_names, history, strict=True))
        maximum = known.get("maximum_overlap", np.maximum.accumulate(np.maximum(values, 0.0)))
        plastic = known.get("plastic_overlap", np.zeros(values.size))
        return Path(values, force, stiffness, maximum, plastic, stored, dissipated)

    def unloading_overlap(self, force, state):
        """Overlap [m] at which a contact with this history, below its maximum overlap, carries `force` ≥ 0 [N]."""
        values, shape = self._shaped(force, "force", "N")
        result = np.empty(values.size)
        unload_loop(self.rule, self._single(), values.ravel(), state.arrays, result)
        return _as_given(result.reshape(shape))

    # --- range

    def limits(self):
        """The ranges of force [N] in which the law's source supports it, each with its reason."""
        if self._limits is None:
            self._limits = self.definition.limits(self.contact, **self.options)
        return self._limits

    def _advise(self, force):
        touching = force[force > 0.0] if np.ndim(force) else force
        largest, smallest = float(np.max(touching, initial=0.0)), float(np.min(touching, initial=math.inf))
        for limit in self.limits():
            if limit.reason in self._warned:
                continue
            if largest > limit.maximum_force:
                range_left = f"above {limit.maximum_force:.3g} N"
            elif smallest < limit.minimum_force:
                range_left = f"below {limit.minimum_force:.3g} N"
            else:
                continue
            self._warned.add(limit.reason)
            warnings.warn(f"{self.name} {range_left}: {limit.reason}", ValidityWarning, stacklevel=3)

    def tabulate(self, rtol=1e-5, max_force=None):
        """A `Table` of this law whose force and stiffness are within `rtol`, measured between its nodes."""
        from demlaws.table import tabulate

        return tabulate(self, rtol=rtol, max_force=max_force)


def _as_given(array):
    return float(array) if array.ndim == 0 else array


_pool = None


def _threads():
    """Number of threads and the pool that runs them, made on first use."""
    global _pool
    import numba

    workers = numba.config.NUMBA_NUM_THREADS
    if _pool is None or _pool._max_workers != workers:
        _pool = ThreadPoolExecutor(workers)
    return workers, _pool


def registry():
    """Name → Definition of every law, in the order in which figures and tables show them."""
    from demlaws.laws import MODULES

    definitions = [importlib.import_module(f"demlaws.laws.{module}").LAW for module in MODULES]
    return {definition.name: definition for definition in definitions}


def laws():
    """Names of all laws."""
    return list(registry())


def find(name) -> Definition:
    """The law of this name, or an error that lists the names."""
    known = registry()
    if name not in known:
        raise DemlawsError(f"unknown law {name!r}: the laws are {', '.join(known)}")
    return known[name]


def law(name, contact, unloading="elastic", **options):
    """Bind law `name` to `contact` and join it with a rule `unloading`: "elastic", "hertz", "thornton", or a curve.

    A curve is a law, a `Table` or the path of a saved table: the contact then unloads along that law's curve of first
    loading through its largest overlap (rule "table"). Its contact is this one, or one in a constant ratio to it.
    Raises DemlawsError for an unknown name, option or missing quantity, and where the pair is not passive.
    """
    definition = find(name)
    rule, curve = rule_and_curve(unloading)
    for field in definition.needs:
        if getattr(contact, field) is None:
            raise DemlawsError(f"law {name!r} needs the contact's {field}: give Contact(..., {field}=...)")
    try:
        shape = definition.prepare(contact, **options)
    except TypeError as error:
        if options and "argument" in str(error):
            raise DemlawsError(f"law {name!r}: {str(error).split(') ')[-1]}") from None
        raise
    result = Law(definition, contact, "elastic", options, shape)
    return result if rule == "elastic" else result.joined(rule if curve is None else curve)


def rule_and_curve(unloading):
    """(rule, unloading curve or None) of what a user gave as `unloading`."""
    if isinstance(unloading, os.PathLike) or (isinstance(unloading, str) and ("/" in unloading or "." in unloading)):
        from demlaws.table import Table

        unloading = Table.load(unloading)
    if isinstance(unloading, Law):
        if unloading.unloading != "elastic":
            raise DemlawsError(
                f"the unloading curve is elastic, this {unloading.name!r} has {unloading.unloading!r} unloading itself: "
                "give it with unloading='elastic' (law.joined('elastic'))"
            )
        return GIVEN, unloading
    if unloading == GIVEN:
        raise DemlawsError(
            f"unloading {GIVEN!r} needs its curve: give a law or a table, unloading=dl.law(...) or dl.Table.load(...)"
        )
    if not isinstance(unloading, str) or unloading not in RULES:
        raise DemlawsError(f"unknown unloading rule {unloading!r}: the rules are {', '.join(RULES)}")
    return unloading, None


def rebound(unloading, contact):
    """What `law` takes as `unloading`, for another contact: a law as the same law there, a table that collapses likewise."""
    rule, curve = rule_and_curve(unloading)
    if curve is None:
        return rule
    names = ("radius", "modulus", "roughness")
    if all(np.allclose(getattr(curve.contact, n), getattr(contact, n), rtol=1e-6, atol=0.0) for n in names):
        return curve
    if hasattr(curve, "bound_to"):
        return curve.bound_to(contact)
    return law(curve.name, contact, **curve.options)


def joined_shape(law, curve):
    """Shape of `law` and an unloading curve: their contacts may differ, in a ratio that is one for all contacts."""
    from demlaws.table import quick_to_invert

    ratios = {}
    for name in ("radius", "modulus", "roughness"):
        own, others = np.asarray(getattr(law.contact, name), float), np.asarray(getattr(curve.contact, name), float)
        with np.errstate(divide="ignore", invalid="ignore"):
            try:
                ratio = others / own
            except ValueError:
                raise DemlawsError(
                    f"the law holds {law.contact.size} contacts, its unloading curve {curve.contact.size}"
                ) from None
        if np.all(own == others):  # smooth contacts, too
            ratio = np.ones(1)
        low, high = float(np.nanmin(ratio)), float(np.nanmax(ratio))
        if not (math.isfinite(high) and high - low <= 1e-9 * high):
            raise DemlawsError(
                f"the {name} of the unloading curve's contact is {low:g} to {high:g} times the law's: it must be the law's own "
                "or in one ratio to it; make the curve for the same contact or array of contacts"
            )
        ratios[name] = low if high > low else high
    shape = curve.shape
    if hasattr(curve, "nodes"):  # a table, not a law that is one inside
        shape = quick_to_invert(shape, curve.nodes.kinks)
    return JoinedShape(loading_part(law.shape), quick_to_invert(shape), **ratios)


def example_curve(name, contact, **options):
    """The unloading curve with which tests and measurements join law `name` to rule "table".

    The law itself on surfaces a quarter as rough (what first loading has flattened), with its definition's own changes.
    """
    definition = find(name)
    options = {**definition.example, **options, **definition.example_curve}
    return law(name, contact.with_values(roughness=0.25 * np.asarray(contact.roughness)), **options)


def example(name, contact, unloading="elastic", **options):
    """Law `name` as tests and measurements make it, joined with any rule of `unloading.RULES`."""
    curve = example_curve(name, contact, **options) if unloading == GIVEN else unloading
    return law(name, contact, curve, **{**find(name).example, **options})


def _refuse_unless_passive(law, *uncertainties):
    """Passive where at every load K(P) ≤ that of the unloading curve; for the Hertz-like rules dδ_H/dδ ≤ 1."""
    excess, force = largest_stiffness_ratio(law)
    curve = law.unloading_law
    if excess > 1.0 + 1e-9 + sum(uncertainties):
        whose = "Hertz's" if curve is None else f"that of its unloading curve ({curve.name!r})"
        ratio = f"{excess:.4g}" if excess > 1.001 else f"1 + {excess - 1.0:.1g}"
        raise DemlawsError(
            f"law {law.name!r} cannot take {law.unloading!r} unloading: at {force:.3g} N its stiffness is {ratio} times "
            f"{whose}, so that unloading would return more work than loading took; use unloading='elastic'"
        )


def largest_stiffness_ratio(law, points=2000):
    """Largest K(P)/K_U(P) of first loading over 1e-12 to 0.1 of the radius, and the force [N] where it occurs.

    K_U is the stiffness of the given unloading curve, or else Hertz's.
    """
    contact, worst, where = law.contact, 0.0, 0.0
    chosen = [0]
    if contact.size is not None:  # the extremes of relative roughness and the middle stand for the rest
        order = np.argsort(np.broadcast_to(contact.roughness, contact.size) / contact.radius)
        chosen = {int(order[0]), int(order[order.size // 2]), int(order[-1])}
    for index in chosen:
        p = one_of(law.params, index)
        radius = float(np.broadcast_to(contact.radius, contact.size or 1)[index])
        overlap = np.geomspace(1e-12 * radius, 0.1 * radius, points)
        force, stiffness = np.empty(points), np.empty(points)
        evaluate_loop(Elastic(), p, overlap, (), force, stiffness)
        usable = np.isfinite(force) & (force > 0)
        if isinstance(p, JoinedParams):
            place, own, other = (np.empty(points) for _ in range(3))
            inverse_loop(p.unloading, force, place)
            evaluate_loop(Elastic(), p.unloading, place, (), own, other)
            usable &= place > 0.0  # at a seating load the curve is a step; beyond its end there is none
            if not np.any(usable):
                raise DemlawsError("the unloading curve has no load in common with the law: is it for another contact?")
        else:
            other = 1.5 * p.hertz_coefficient ** (2 / 3) * np.cbrt(force)
        ratio = stiffness[usable] / other[usable]
        k = int(np.argmax(ratio))
        if ratio[k] > worst:
            worst, where = float(ratio[k]), float(force[usable][k])
    return worst, where


def one_of(params, index):
    """Params of contact `index` of an array of contacts (of a single one: its own)."""
    return _map_leaves(lambda v: float(v[index]) if isinstance(v, np.ndarray) and v.ndim == 1 else v, params)
