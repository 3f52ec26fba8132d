"""What a law is to its user: force, stiffness, inverse, energy, paths and batches.

The compiled loops know any law and any unloading rule; `Law` checks input, keeps units and shapes, and raises errors.
"""

import importlib
import itertools
import math
import os
import warnings
from concurrent.futures import ThreadPoolExecutor
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, DTypeLike

from demlaws.contact import Contact
from demlaws.core.curve import TableShape
from demlaws.core.grid import quick_to_invert
from demlaws.core.loops import FINITE, UNBOUNDED, batch_loop, energy_loop, follow_loop, inverse_loop, unloaded_loop
from demlaws.core.params import bind_params, first_loading, loading_part, map_leaves, one_of
from demlaws.core.shear import CHOICES, DEFAULT, shear_loop
from demlaws.errors import DemlawsError, LargeOverlap, ValidityWarning
from demlaws.laws.registry import is_own
from demlaws.soundness import refuse_unsound, refuse_unsound_rule
from demlaws.units import LARGEST_OVERLAP, SMALL_OVERLAP, check_overlaps, number, unmasked


class State:
    """History of n contacts: one array for each quantity that the unloading rule remembers; all zeros is virgin.

    `state.maximum_overlap` is that array; `state.maximum_overlap = saved` sets its values. A state can be copied and
    pickled, to go on later.
    """

    def __init__(self, names, size, dtype=np.float64):
        try:
            if np.ndim(size) or np.dtype(dtype) not in (np.float64, np.float32):  # whole numbers would lose the history
                raise TypeError
            arrays = tuple(np.zeros(size, dtype) for _ in names)
        except (TypeError, ValueError, MemoryError):
            raise DemlawsError(
                f"a state of n = {size!r} contacts in {dtype!r}: give a whole number and float64 or float32"
            ) from None
        self.__dict__.update(names=tuple(names), arrays=arrays)

    def __getattr__(self, name: str) -> np.ndarray:
        # of an object that pickle or copy has not filled yet there is nothing to look up
        names = self.__dict__.get("names", ())
        if name in names:
            return self.arrays[names.index(name)]
        raise AttributeError(f"this state has {', '.join(names) or 'no quantities'}, not {name!r}")

    def __setattr__(self, name: str, values: ArrayLike) -> None:
        if name in ("names", "arrays"):
            raise AttributeError(f"{name} belongs to the state that law.new_state made: set the values of its quantities")
        array = getattr(self, name)
        new = self._values(name, values)
        if new.shape not in ((), array.shape):
            raise DemlawsError(f"{name} holds {array.size} contacts, got values of shape {new.shape}: one entry each")
        array[...] = new

    @staticmethod
    def _values(name, values):
        try:
            return np.asarray(values, dtype=float)
        except (TypeError, ValueError):
            raise DemlawsError(f"{name} must be numbers, one a contact, got {values!r}") from None

    def __repr__(self):
        return f"demlaws.State({', '.join(f'{n}={a!r}' for n, a in zip(self.names, self.arrays, strict=True))})"

    def copy(self) -> "State":
        """A state of its own with the same values."""
        twin = State(self.names, 0)
        twin.__dict__["arrays"] = tuple(array.copy() for array in self.arrays)
        return twin


class Path(NamedTuple):
    """What one contact does along a path: arrays with one entry an overlap, SI units.

    plastic_overlap is NaN where a law's own rule remembers no quantity of that name. stored and dissipated [J] are the
    contact's: where the path goes on from a state, what was done to it before since it last closed is in them, too.
    """

    overlap: np.ndarray
    force: np.ndarray
    stiffness: np.ndarray
    maximum_overlap: np.ndarray
    plastic_overlap: np.ndarray
    stored: np.ndarray
    dissipated: np.ndarray

    @property
    def work(self) -> np.ndarray:
        """Work done on the contact [J], ∫P dδ, exact between the points of the path: from virgin, or from where a contact whose
        state was given last closed; of a part of a path take the difference of two entries."""
        return self.stored + self.dissipated


class Law:
    """A law of first loading bound to a contact, joined with an unloading rule. Made by `demlaws.law(...)`.

    Overlaps in m, forces in N, stiffnesses in N/m, energies in J. The methods take a number or an array and return the
    same; with a contact that is an array of contacts, arrays have one entry a contact.

    >>> law = dl.law("hertz", dl.Contact(radius=4e-3, modulus=32e9))
    >>> print(f"{law.force(1e-6):.4f} N, {law.stiffness(1e-6):.0f} N/m, {law.overlap(10.0) * 1e6:.3f} µm")
    2.6985 N, 4047715 N/m, 2.395 µm
    >>> batch = dl.law("hertz", dl.Contact(radius=[1e-3, 4e-3], modulus=32e9), unloading="hertz")
    >>> state = batch.new_state(2)
    >>> force, stiffness = batch.evaluate([1e-6, 1e-6], state)
    >>> force.round(4), state.maximum_overlap
    (array([1.3492, 2.6985]), array([1.e-06, 1.e-06]))
    """

    stiffness_error = 0.0  # relative: a law is exact, a `Table` is what its certificate says
    largest_overlap, largest_force = math.inf, math.inf  # [m], [N]: where a table ends
    _maker: Any = None  # the module demlaws.make, which stands above laws and tables and makes the ones of the others

    @classmethod
    def _made_by(cls):
        if cls._maker is None:  # a table that was read or made of a function, before any law was
            importlib.import_module("demlaws.make")
        return cls._maker

    def __init__(self, definition, contact, unloading, options, shape, params=None, unloading_law=None):
        self.definition = definition
        self.name = definition.name
        self.contact = contact
        self.options = {n: v.item() if isinstance(v, np.generic) else v for n, v in options.items()}  # plain for repr and files
        self.unloading = unloading
        self.unloading_law = unloading_law  # the curve of rule "table", else None
        rule = definition.rule(unloading)
        self.rule = rule.tag
        self.state_names = rule.state
        self.state_size = len(self.state_names)
        self.shape = shape
        if params is None and is_own(definition) and not isinstance(loading_part(shape), TableShape):
            refuse_unsound(definition, loading_part(shape), contact, self.options)
        self.params = bind_params(shape, contact) if params is None else params
        if rule.curve == "law" and is_own(definition) and loading_part(shape) is shape:
            refuse_unsound_rule(definition.name, rule, one_of(self.params, 0), float(np.ravel(contact.radius)[0]))
        self._limits = None
        self._end = None
        self._warned = set()

    def __repr__(self):
        options = "".join(f", {k}={v!r}" for k, v in self.options.items())
        unloading = self.unloading if self.unloading_law is None else self.unloading_law
        return f"demlaws.law({self.name!r}, {self.contact!r}, unloading={unloading!r}{options})"

    # --- joining with a rule

    def joined(self, unloading: "str | Law") -> "Law":
        """The same law of first loading with another unloading rule: a name, or a law or a `Table` as the curve to follow.

        Raises DemlawsError where the pair is not passive.
        """
        return self._made_by().joined(self, unloading)

    def bound_to(self, contact: Contact) -> "Law":
        """The same law and options for another contact (or array of contacts), elastic."""
        return Law(self.definition, contact, "elastic", self.options, self.definition.prepare(contact, **self.options))

    def quick_shape(self) -> Any:
        """The Shape with which this law serves as an unloading curve: one whose inverse costs no search."""
        return quick_to_invert(self.shape)

    @property
    def collapses(self) -> bool:
        """Whether one dimensionless curve (with a given unloading curve: one pair of curves) serves all contacts."""
        if self.unloading_law is None or not self.definition.collapses:
            return self.definition.collapses
        curve = self.unloading_law
        # Hertz's curve has no length of its own
        return curve.collapses and (curve.definition.hertzian or curve.definition.length == self.definition.length)

    def kinks(self) -> list[float]:
        """Overlaps [m] at which the stiffness of first loading (of one contact) jumps or has a kink."""
        return list(self.definition.kinks(loading_part(self.params), **self.options))

    # --- first loading

    def _shaped(self, value, name, unit):
        try:
            array = np.asarray(unmasked(value))
            if array.dtype.kind not in "fiu":  # text, None, complex numbers, dates
                raise TypeError
            array = array.astype(float, copy=False)
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
        # a copy where it may not be written to: loops would be compiled once more for that
        return np.require(array, requirements="CW"), array.shape

    def _both(self, overlap):
        values, shape = self._shaped(overlap, "overlap", "m")
        self._check_range(values)
        force, stiffness = np.empty(values.size), np.empty(values.size)
        finite = first_loading(self.params, values.ravel(), force, stiffness)
        if not finite:
            raise DemlawsError(self._out_of_range(float(values.max())))
        self._advise(force)
        return force.reshape(shape), stiffness.reshape(shape)

    def _out_of_range(self, overlap):
        radius = float(np.max(self.contact.radius))
        text = f"overlap up to {overlap:g} m gives a force that is not finite: the contact's radius is {radius:g} m"
        end = math.inf if self.unloading_law is None else self.unloading_law.largest_force
        return text if end == math.inf else f"{text}, and its unloading curve is a table that ends at {end:g} N"

    def force(self, overlap: ArrayLike) -> float | np.ndarray:
        """Force P [N] of first loading at `overlap` δ [m]; 0 at δ ≤ 0."""
        return _as_given(self._both(overlap)[0])

    def stiffness(self, overlap: ArrayLike) -> float | np.ndarray:
        """Tangent stiffness K = dP/dδ [N/m] of first loading at `overlap` [m]; 0 at δ ≤ 0."""
        return _as_given(self._both(overlap)[1])

    def overlap(self, force: ArrayLike) -> float | np.ndarray:
        """Overlap δ [m] at which first loading carries `force` [N]; 0 at P ≤ 0."""
        values, shape = self._shaped(force, "force", "N")
        result = np.empty(values.size)
        inverse_loop(loading_part(self.params), values.ravel(), result)
        if not np.all(np.isfinite(result)):
            raise DemlawsError(self._force_out_of_range(float(values.max())))
        self._check_range(result.reshape(shape))
        self._advise(values)
        return _as_given(result.reshape(shape))

    def _force_out_of_range(self, force):
        return f"force up to {force:g} N has no finite overlap"

    def energy(self, overlap: ArrayLike) -> float | np.ndarray:
        """Work ∫P dδ [J] of first loading to `overlap` [m]."""
        values, shape = self._shaped(overlap, "overlap", "m")
        self._check_range(values)
        result = np.empty(values.size)
        energy_loop(loading_part(self.params), values.ravel(), result)
        return _as_given(result.reshape(shape))

    # --- history

    def new_state(self, n: int | None = None, dtype: DTypeLike = np.float64) -> State:
        """State of n virgin contacts (n: the contact's own size, or 1), kept as float64 or float32."""
        return State(self.state_names, (self.contact.size or 1) if n is None else n, dtype)

    def evaluate(
        self,
        overlap: np.ndarray,
        state: State | None = None,
        out: tuple[np.ndarray, np.ndarray] | None = None,
        parallel: bool = False,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Force [N] and tangent stiffness [N/m] of a batch of contacts; `state` is updated in place.

        overlap: 1-D array, float64 or float32 (arithmetic is double throughout), one entry a contact; state: what
        `new_state` returned (not needed by elastic laws); out: (force, stiffness), two float arrays to write to, which
        spares the time that new memory takes; parallel=True: one thread a core where there are more than 131,072 contacts,
        since fewer take longer so. The overlaps are looked at in the loop only. One that is NaN, infinite, beyond the
        contact's effective radius or beyond a table's range raises DemlawsError after it: that contact's force is not
        finite, its history is as it was; all others are good. Overlaps
        beyond a tenth of the radius give one warning.
        """
        if type(overlap) is not np.ndarray:
            overlap = np.asarray(unmasked(overlap))
        if overlap.ndim != 1 or overlap.dtype not in (np.float64, np.float32):
            raise DemlawsError(f"overlap must be a 1-D float64 or float32 array, got {overlap.dtype} of shape {overlap.shape}")
        n = overlap.size
        if self.contact.size not in (None, n):
            raise DemlawsError(f"{n} overlaps for a law that holds {self.contact.size} contacts: one entry each")
        arrays = self._arrays_of(state, n)
        force, stiffness = (np.empty_like(overlap), np.empty_like(overlap)) if out is None else _writable(out, overlap, arrays)
        ends, (lowest, most) = self._ends()

        def step(where, params, state, force, stiffness, end, limit):
            return batch_loop(self.rule, params, overlap[where], state, end, limit, force, stiffness)

        def part(piece):
            states = tuple(array[piece] for array in arrays)
            return step(piece, self._params_of(piece), states, force[piece], stiffness[piece], (lowest,), (most,))

        good = all(in_threads(part, n)) if parallel and n >= 16 * _PIECE else part(slice(None))
        if not good and arrays and self.contact.size is not None:
            # beyond the lowest of all ends, though not beyond their own: answered as NaN, their history as it was
            again = np.flatnonzero(np.isnan(force) & (overlap <= ends))
            states = tuple(array[again] for array in arrays)
            results = np.empty(again.size, force.dtype), np.empty(again.size, stiffness.dtype)
            step(again, self._params_of(again), states, *results, UNBOUNDED, FINITE)
            for array, values in zip((force, stiffness, *arrays), (*results, *states), strict=True):
                array[again] = values
        if not good:
            bad = np.flatnonzero(~np.isfinite(force) | ~(overlap <= ends))
            if bad.size:
                force[bad] = math.nan
                where = f"contact {bad[0]}" if bad.size == 1 else f"contact {bad[0]} (one of {bad.size})"
                raise DemlawsError(f"{where}: {self._why_not_finite(overlap[bad[0]], bad[0])}")
            self._check_range(overlap)
        return force, stiffness

    def _params_of(self, piece):
        """Params of some of the contacts."""
        return map_leaves(lambda v: v[piece] if isinstance(v, np.ndarray) and v.ndim == 1 else v, self.params)

    def _ends(self):
        """Largest overlap [m] that is answered, one number or one a contact; then the lowest of all contacts' for `batch_loop`,
        its `end` and `most`: with one for each contact a batch of tables took a tenth longer."""
        if self._end is None:
            radius = np.asarray(self.contact.radius)
            end = np.minimum(LARGEST_OVERLAP * radius, self._curve_end())
            small = np.minimum(SMALL_OVERLAP * radius, end).ravel()
            most, stiffness = small.copy(), np.empty(small.size)
            if self.state_size:
                first_loading(self.params, small, most, stiffness)
            self._end = end, (float(np.min(end)), float(min(np.min(most), FINITE[0])))
        return self._end

    def _curve_end(self):
        """Overlap [m] at which the curve ends: where a table that is the unloading curve does."""
        force = math.inf if self.unloading_law is None else self.unloading_law.largest_force
        if force == math.inf:
            return math.inf
        result = np.empty(self.contact.size or 1)
        inverse_loop(loading_part(self.params), np.full(result.size, force), result)
        result[np.isnan(result)] = math.inf
        return result if self.contact.size is not None else float(result[0])

    def _arrays_of(self, state, n):
        """The arrays of a batch's state, checked."""
        if state is not None and not isinstance(state, State):
            raise DemlawsError(f"state must be what law.new_state({n}) returns, got {state!r}")
        names = () if state is None else state.names
        if names != self.state_names:
            given = "" if state is None else f"; this one has {', '.join(names) or 'no quantities'}"
            raise DemlawsError(f"{self.unloading} unloading needs the state that law.new_state({n}) returns{given}")
        arrays = () if state is None else state.arrays
        if any(array.size != n for array in arrays):
            raise DemlawsError(f"the state holds {arrays[0].size} contacts, overlap has {n}")
        return arrays

    def _why_not_finite(self, overlap, index):
        overlap, radius = float(overlap), float(np.broadcast_to(self.contact.radius, self.contact.size or index + 1)[index])
        if not math.isfinite(overlap):
            return f"overlap is {overlap:g} m: give finite values"
        if overlap > radius:
            try:
                check_overlaps(overlap, radius)
            except DemlawsError as error:
                return str(error)
        return self._out_of_range(overlap)

    def _check_range(self, overlap):
        """Refuse overlaps beyond R, and warn once of those beyond a tenth of it."""
        text = check_overlaps(overlap, self.contact.radius)
        if text is not None and "large overlap" not in self._warned:
            self._warned.add("large overlap")
            warnings.warn(f"{self.name}: {text}", LargeOverlap, stacklevel=4)

    def _single(self):
        if self.contact.size is not None:
            raise DemlawsError("a path is followed by one contact; this law holds an array of contacts: use evaluate")
        return self.params

    def follow(self, overlap: ArrayLike, state: State | None = None) -> Path:
        """Take one contact along a sequence of overlaps [m], from virgin (or from `state`, updated): a `Path`."""
        self._single()
        values = np.atleast_1d(self._shaped(overlap, "overlap", "m")[0])
        if values.ndim != 1:
            raise DemlawsError(f"a path is a 1-D sequence of overlaps in m, got an array of shape {values.shape}")
        self._check_range(values)
        state = self.new_state(1) if state is None else state
        self._arrays_of(state, 1)
        columns = [np.empty(values.size) for _ in range(4)]
        history = tuple(np.zeros(values.size) for _ in self.state_names)
        follow_loop(self.rule, self._single(), values, state.arrays, history, *columns)
        force, stiffness, stored, dissipated = columns
        if not np.all(np.isfinite(force)):
            raise DemlawsError(self._out_of_range(float(values.max())))
        self._advise(force)
        known = dict(zip(self.state_names, history, strict=True))
        maximum = known.get("maximum_overlap", np.maximum.accumulate(np.maximum(values, 0.0)))
        plastic = known.get("plastic_overlap", np.full(values.size, math.nan if self.state_names else 0.0))
        return Path(values, force, stiffness, maximum, plastic, stored, dissipated)

    def shear_stiffness(
        self, overlap: ArrayLike, ratio: float, shear: str = DEFAULT, state: State | None = None
    ) -> float | np.ndarray:
        """Tangential stiffness K_t [N/m] of one contact along a sequence of overlaps [m], from virgin (or `state`, updated).

        K_t = ratio K_s, where ratio is that of an elastic contact, 2(1-ν)/(2-ν) for two bodies of one material (Mindlin 1949),
        and K_s by `shear`: "elastic", the stiffness with which the contact would unload now, or "loading", that of first
        loading at the force carried now (docs/shear.md).
        """
        if shear not in CHOICES:
            raise DemlawsError(f"shear must be {', '.join(map(repr, CHOICES))}, got {shear!r}: which stiffness K_t goes by")
        ratio = number(ratio, "ratio")
        self._single()
        values, shape = self._shaped(overlap, "overlap", "m")
        if values.ndim > 1:
            raise DemlawsError(f"a path is a 1-D sequence of overlaps in m, got an array of shape {values.shape}")
        self._check_range(values)
        state = self.new_state(1) if state is None else state
        arrays = self._arrays_of(state, 1)
        result = np.empty(values.size)
        shear_loop(CHOICES[shear].tag, self.rule, self._single(), values.ravel(), arrays, result)
        if not np.all(np.isfinite(result)):
            raise DemlawsError(self._out_of_range(float(values.max())))
        return _as_given(ratio * result.reshape(shape))

    def unloading_overlap(self, force: ArrayLike, state: State) -> float | np.ndarray:
        """Overlap [m] at which a contact with this history, below its maximum overlap, carries `force` ≥ 0 [N]."""
        values, shape = self._shaped(force, "force", "N")
        result = np.empty(values.size)
        states = tuple(np.full(values.size, float(array[0])) for array in self._arrays_of(state, 1))
        unloaded_loop(self.rule, self._single(), values.ravel(), states, result)
        return _as_given(result.reshape(shape))

    # --- range

    def limits(self) -> list:
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

    def tabulate(self, rtol: float = 1e-5, max_force: float | None = None) -> Any:
        """A `Table` of this law whose force and stiffness are within `rtol`, measured between its nodes."""
        return self._made_by().tabulate(self, rtol=rtol, max_force=max_force)


def _as_given(array):
    return float(array) if array.ndim == 0 else array


def _writable(out, overlap, state):
    """The two arrays of `out`, or an error where the loop could not write to them or would write over what it reads."""
    try:
        force, stiffness = out
    except (TypeError, ValueError):
        raise DemlawsError(f"out must be two float arrays, for force and stiffness, got {out!r}") from None
    for name, array in (("force", force), ("stiffness", stiffness)):
        if not isinstance(array, np.ndarray) or array.dtype not in (np.float64, np.float32):
            kind = array.dtype if isinstance(array, np.ndarray) else type(array).__name__
            raise DemlawsError(f"out's {name} must be a float64 or float32 array, got {kind}")
        if not array.flags.writeable:
            raise DemlawsError(f"out's {name} is read-only: give an array that may be written to")
    if force.shape != overlap.shape or stiffness.shape != overlap.shape:
        raise DemlawsError(f"out holds arrays of shape {force.shape} and {stiffness.shape}, overlap has {overlap.shape}")
    every = (overlap, force, stiffness, *state)
    if all(array.base is None for array in every) and len({id(array) for array in every}) == len(every):
        return force, stiffness  # each owns its memory
    read = (("overlap", overlap), *(("the state", array) for array in state))
    for mine, array, others in (("force", force, (*read, ("out's stiffness", stiffness))), ("stiffness", stiffness, read)):
        for name, other in others:
            if np.may_share_memory(array, other) and np.shares_memory(array, other):
                raise DemlawsError(f"out's {mine} shares memory with {name}: give an array of its own")
    return force, stiffness


_PIECE = 8192
"""Smallest number of contacts that is worth a thread's turn."""
_pool = None


def _forget_pool():
    """In a child made by fork the pool's threads do not exist: the next parallel call makes its own."""
    global _pool
    _pool = None


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget_pool)


def in_threads(part, n):
    """Results of part(slice) over all of range(n), in pieces that this thread and those of the pool take in turn."""
    global _pool
    import numba

    workers = numba.config.NUMBA_NUM_THREADS
    if _pool is None or _pool._max_workers != workers:
        _pool = ThreadPoolExecutor(workers)
    # several turns a thread: one that the system holds up then keeps the others waiting for a part of its share only
    piece = -(-n // (2 * workers * _PIECE)) * _PIECE
    numbers = itertools.count()  # next() is one operation for all threads

    def work():
        results = []
        while (start := next(numbers) * piece) < n:
            results.append(part(slice(start, min(start + piece, n))))
        return results

    others = [_pool.submit(work) for _ in range(workers - 1)]
    own = work()
    return [*own, *(result for other in others for result in other.result())]
