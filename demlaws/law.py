"""What a law is to its user: force, stiffness, inverse, energy, paths and batches.

The compiled loops know any law and any unloading rule; `Law` checks input, keeps units and shapes, and raises errors.
"""

import math
import warnings
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np

from demlaws.core.grid import quick_to_invert
from demlaws.core.loops import energy_loop, evaluate_loop, follow_loop, inverse_loop, unload_loop
from demlaws.core.params import bind_params, loading_part, map_leaves
from demlaws.core.unloading import RULES, STATE_NAMES, Elastic
from demlaws.errors import DemlawsError, ValidityWarning


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


class Law:
    """A law of first loading bound to a contact, joined with an unloading rule. Made by `demlaws.law(...)`.

    Overlaps in m, forces in N, stiffnesses in N/m, energies in J. The methods take a number or an array and return the
    same; with a contact that is an array of contacts, arrays have one entry a contact.
    """

    stiffness_error = 0.0  # relative: a law is exact, a `Table` is what its certificate says
    largest_overlap, largest_force = math.inf, math.inf  # [m], [N]: where a table ends
    _maker = None  # the module demlaws.make, which stands above laws and tables and makes the ones of the others

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
        return self._maker.joined(self, unloading)

    def bound_to(self, contact):
        """The same law and options for another contact (or array of contacts), elastic."""
        return Law(self.definition, contact, "elastic", self.options, self.definition.prepare(contact, **self.options))

    def quick_shape(self):
        """The Shape with which this law serves as an unloading curve: one whose inverse costs no search."""
        return quick_to_invert(self.shape)

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
        end = math.inf if self.unloading_law is None else self.unloading_law.largest_force
        return text if end == math.inf else f"{text}, and its unloading curve is a table that ends at {end:g} N"

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
            params = map_leaves(lambda v: v[piece] if isinstance(v, np.ndarray) and v.ndim == 1 else v, self.params)
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
        return self._maker.tabulate(self, rtol=rtol, max_force=max_force)


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
