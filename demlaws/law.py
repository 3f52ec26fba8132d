"""What a law is to its user: force, stiffness, inverse, energy, paths and batches, and the registry of laws.

The compiled loops at the top know any law and any unloading rule through `demlaws.dispatch`; `Law` checks input, keeps
units and shapes, and raises errors.
"""

import importlib
import math
import warnings
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np

from demlaws import dispatch
from demlaws.dispatch import gather, scatter, stored_and_dissipated
from demlaws.errors import DemlawsError, ValidityWarning
from demlaws.fastmath import interleave, loop
from demlaws.laws.definition import Definition
from demlaws.unloading import RULES, STATE_NAMES, Elastic

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

    def __init__(self, definition, contact, unloading, options, shape, params=None):
        self.definition = definition
        self.name = definition.name
        self.contact = contact
        self.options = dict(options)
        self.unloading = unloading
        self.rule = RULES[unloading]
        self.state_names = STATE_NAMES[unloading]
        self.state_size = len(self.state_names)
        self.shape = shape
        self.params = bind_params(shape, contact) if params is None else params
        self._limits = None
        self._warned = set()

    def __repr__(self):
        options = "".join(f", {k}={v!r}" for k, v in self.options.items())
        return f"demlaws.law({self.name!r}, {self.contact!r}, unloading={self.unloading!r}{options})"

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
        return f"overlap up to {overlap:g} m gives a force that is not finite: the contact's radius is {radius:g} m"

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
    """Bind law `name` to `contact` and join it with the rule `unloading` ("elastic", "hertz", "thornton").

    Raises DemlawsError for an unknown name, option or missing quantity, and where the pair is not passive.
    """
    definition = find(name)
    if unloading not in RULES:
        raise DemlawsError(f"unknown unloading rule {unloading!r}: the rules are {', '.join(RULES)}")
    for field in definition.needs:
        if getattr(contact, field) is None:
            raise DemlawsError(f"law {name!r} needs the contact's {field}: give Contact(..., {field}=...)")
    try:
        shape = definition.prepare(contact, **options)
    except TypeError as error:
        if options and "argument" in str(error):
            raise DemlawsError(f"law {name!r}: {str(error).split(') ')[-1]}") from None
        raise
    result = Law(definition, contact, unloading, options, shape)
    if unloading != "elastic":
        _refuse_unless_passive(result)
    return result


def _refuse_unless_passive(law):
    """Hertz-like unloading is passive exactly where K(P) ≤ K_H(P), that is dδ_H/dδ ≤ 1, at every load."""
    excess, force = largest_stiffness_ratio(law)
    if excess > 1.0 + 1e-9:
        raise DemlawsError(
            f"law {law.name!r} cannot take {law.unloading!r} unloading: at {force:.3g} N its stiffness is {excess:.4g} times "
            "Hertz's, so that unloading would return more work than loading took; use unloading='elastic'"
        )


def largest_stiffness_ratio(law, points=2000):
    """Largest K(P)/K_H(P) of first loading over 1e-12 to 0.1 of the radius, and the force [N] where it occurs."""
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
        ratio = stiffness[usable] / (1.5 * p.hertz_coefficient ** (2 / 3) * force[usable] ** (1 / 3))
        k = int(np.argmax(ratio))
        if ratio[k] > worst:
            worst, where = float(ratio[k]), float(force[usable][k])
    return worst, where


def one_of(params, index):
    """Params of contact `index` of an array of contacts (of a single one: its own)."""
    return _map_leaves(lambda v: float(v[index]) if isinstance(v, np.ndarray) and v.ndim == 1 else v, params)
