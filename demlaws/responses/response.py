"""Response of contacts to overlaps: forces, stiffnesses, energies, paths and batches of a bound law."""

import functools
import math
from typing import TYPE_CHECKING, Any, NamedTuple, overload

import numpy as np
from numpy.typing import ArrayLike, DTypeLike

from demlaws.contact import Contact
from demlaws.core.loops import (
    FINITE,
    UNBOUNDED,
    batch_loop,
    bind_params,
    energy_loop,
    follow_loop,
    force_loop,
    gather,
    inverse_loop,
    loading_part,
    unloaded_loop,
)
from demlaws.core.shear import CHOICES, DEFAULT, shear_loop
from demlaws.curves.unloading import ELASTIC, BoundLaw, Unloading
from demlaws.errors import DemlawsError, LargeOverlap, warn
from demlaws.units import LARGEST_OVERLAP, SMALL_OVERLAP, as_float, as_given, as_typed, check_overlaps, number, typed

if TYPE_CHECKING:
    from demlaws.curves.closed import FormulaCurve
    from demlaws.curves.table import TableCurve
    from demlaws.responses.batch import State
    from demlaws.responses.path import Path


class Breach(NamedTuple):
    """A force [N] outside a limit of a law's source.

    >>> granite = dl.Contact(4.35e-3, 32.32e9, 2.4e-6, 2.22, hardness=6.266e9)
    >>> dl.law("hertz", granite).breaches(1.0, 1e4)[0].range
    'above 4.98e+03 N'
    """

    value: float
    bound: float
    reason: str

    @property
    def range(self) -> str:
        """The range as text."""
        return f"{'above' if self.value > self.bound else 'below'} {self.bound:.3g} N"

    def __str__(self):
        return f"{self.value:.4g} N, {self.range}: {self.reason}"


class Response(BoundLaw):
    """Methods of `Law` that evaluate compiled loops: they check input, keep units and shapes, and raise errors."""

    curve: "FormulaCurve | TableCurve"

    def __init__(self, contact: Contact, curve: "FormulaCurve | TableCurve", unloading: Unloading = ELASTIC):
        super().__init__(contact, curve, unloading)
        self.rule_tag, self.state_names = unloading.rule.tag, unloading.rule.state
        self.state_size = len(self.state_names)
        self._radius = self.definition.bulk_radius(contact, **self.options)  # of the range of overlaps

    def plot(self, ax: Any = None, **style: Any) -> Any:
        """Draw force against overlap; returns matplotlib's axes.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Axes to draw on; default: those of a new figure, which notebooks show.
        **style
            For a law `overlap`, its largest overlap [m], and `unload_at`, the force [N] at which it is unloaded; other
            keywords go to `Axes.plot`.

        Returns
        -------
        matplotlib.axes.Axes
            Its figure is written by `ax.figure.savefig(...)`.

        Raises
        ------
        DemlawsError
            Without matplotlib.
        """
        from demlaws import plots

        return plots.plot(self, ax, **style)

    # --- first loading

    def _shaped(self, value, name, unit):
        array = _numbers(value, name, unit).astype(float, copy=False)
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

    def _force_and_stiffness(self, overlap):
        values, shape = self._shaped(overlap, "overlap", "m")
        self._check_range(values, overlap)
        force, stiffness = force_loop(self.shape, self.params, values.ravel())
        if not np.all(np.isfinite(force)):
            raise DemlawsError(self._out_of_range(typed(values.max(), overlap, "m")))
        self._warn_of_limits(force)
        return force.reshape(shape), stiffness.reshape(shape)

    def _out_of_range(self, overlap):
        radius = float(np.max(self.contact.radius))
        last = self.curve.largest_force(loading_part(self.params))
        if overlap > float(np.min(self.curve.end(loading_part(self.params)))):
            text = f"overlap {as_typed(overlap, 'm')} is beyond that of max_force = {last:g} N"
            return f"{text}, up to which law {self.name!r} is defined"
        text = f"overlap up to {as_typed(overlap, 'm')} gives a force that is not finite: the contact's radius is {radius:g} m"
        end = self._largest_unloading_force()
        return text if end == math.inf else f"{text}, and its unloading curve is a table that ends at {end:g} N"

    @overload
    def force(self, overlap: float | str) -> float: ...

    @overload
    def force(self, overlap: ArrayLike) -> np.ndarray: ...

    def force(self, overlap: ArrayLike) -> Any:
        """Force P of first loading.

        Parameters
        ----------
        overlap : float, str or array_like
            Overlap δ [m], or text with a unit ("1um").

        Returns
        -------
        float or ndarray
            Force [N], 0 at δ ≤ 0.
        """
        return as_given(self._force_and_stiffness(overlap)[0])

    @overload
    def stiffness(self, overlap: float | str) -> float: ...

    @overload
    def stiffness(self, overlap: ArrayLike) -> np.ndarray: ...

    def stiffness(self, overlap: ArrayLike) -> Any:
        """Tangent stiffness K = dP/dδ of first loading.

        Parameters
        ----------
        overlap : float, str or array_like
            Overlap δ [m].

        Returns
        -------
        float or ndarray
            Stiffness [N/m], 0 at δ ≤ 0.
        """
        return as_given(self._force_and_stiffness(overlap)[1])

    @overload
    def overlap(self, force: float | str) -> float: ...

    @overload
    def overlap(self, force: ArrayLike) -> np.ndarray: ...

    def overlap(self, force: ArrayLike) -> Any:
        """Overlap δ at which first loading carries a force.

        Parameters
        ----------
        force : float, str or array_like
            Force P [N].

        Returns
        -------
        float or ndarray
            Overlap [m], 0 at P ≤ 0.
        """
        return as_given(self._overlap(force, force))

    def _overlap(self, force, source, name="force"):
        """Overlaps at forces; an error shows the user's own, `source`, with their name."""
        values, shape = self._shaped(force, "force", "N")
        result = inverse_loop(self.shape, self.params, values.ravel())
        if not np.all(np.isfinite(result)):
            raise DemlawsError(self._force_out_of_range(typed(values.max(), source, "N")))
        try:
            self._check_range(result)
        except DemlawsError as error:
            text = as_typed(typed(values.max(), source, "N"), "N")
            raise DemlawsError(f"{name} = {text} is too large for this contact: {error}") from None
        self._warn_of_limits(values)
        return result.reshape(shape)

    def _force_out_of_range(self, force):
        last = self.curve.largest_force(loading_part(self.params))
        beyond = f": law {self.name!r} is defined up to max_force = {last:g} N" if force > last else ""
        return f"force up to {as_typed(force, 'N')} has no finite overlap{beyond}"

    @overload
    def energy(self, overlap: float | str) -> float: ...

    @overload
    def energy(self, overlap: ArrayLike) -> np.ndarray: ...

    def energy(self, overlap: ArrayLike) -> Any:
        """Work ∫P dδ of first loading.

        Parameters
        ----------
        overlap : float, str or array_like
            Overlap δ [m].

        Returns
        -------
        float or ndarray
            Work [J].
        """
        values, shape = self._shaped(overlap, "overlap", "m")
        self._check_range(values, overlap)
        result = energy_loop(self.shape, self.params, values.ravel())
        return as_given(result.reshape(shape))

    # --- history

    def new_state(self, n: int | None = None, dtype: DTypeLike = np.float64) -> "State":
        """State of contacts that have not been loaded.

        Parameters
        ----------
        n : int, optional
            Number of contacts; default: that of the contact array, or 1.
        dtype : dtype_like
            float64 or float32.

        Returns
        -------
        State
        """
        from demlaws.responses.batch import State

        return State(self.state_names, (self.contact.size or 1) if n is None else n, dtype)

    def evaluate(
        self,
        overlap: ArrayLike,
        state: "State | None" = None,
        out: tuple[np.ndarray, np.ndarray] | None = None,
        *,
        parallel: bool = False,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Force and tangent stiffness of a batch of contacts; `state` is updated in place.

        Parameters
        ----------
        overlap : array_like, shape (n,)
            Overlaps [m] of one contact each; arithmetic is double throughout, results are float32 for float32 overlaps.
        state : State, optional
            History from `new_state`; elastic laws need none.
        out : pair of ndarray, optional
            Arrays for force and stiffness, which saves the time for new memory.
        parallel : bool
            One thread per core for more than 131,072 contacts; fewer would take longer.

        Returns
        -------
        force, stiffness : ndarray
            In N and N/m.

        Raises
        ------
        DemlawsError
            After the loop, if an overlap is NaN, infinite, beyond the effective radius or beyond a table's range: the force
            of that contact is not finite and its history is unchanged; all other contacts are complete.
        """
        from demlaws.responses.batch import PIECE, in_threads, writable

        overlap = _numbers(overlap, "overlap", "m")
        if overlap.ndim != 1:
            raise DemlawsError(f"overlap must be a 1-D array in m, one entry per contact, got shape {overlap.shape}")
        n = overlap.size
        if self.contact.size not in (None, n):
            raise DemlawsError(f"{n} overlaps for a law that holds {self.contact.size} contacts: one entry each")
        arrays = self._arrays_of(state, n)
        force, stiffness = (np.empty_like(overlap), np.empty_like(overlap)) if out is None else writable(out, overlap, arrays)
        ends, (lowest, most) = self._largest_overlaps

        def part(piece):
            states, params = tuple(array[piece] for array in arrays), gather(self.params, piece)
            at = overlap[piece], states, lowest, most, force[piece], stiffness[piece]
            return batch_loop(self.rule_tag, self.shape, params, *at)

        good = all(in_threads(part, n)) if parallel and n >= 16 * PIECE else part(slice(None))
        if not good and arrays and self.contact.size is not None:
            self._answer_between_ends(overlap, ends, arrays, force, stiffness)
        if not good:
            bad = np.flatnonzero(~np.isfinite(force) | ~(overlap <= ends))
            if bad.size:
                force[bad] = math.nan
                where = f"contact {bad[0]}" if bad.size == 1 else f"contact {bad[0]} (one of {bad.size})"
                raise DemlawsError(f"{where}: {self._why_not_finite(overlap[bad[0]], bad[0])}")
            self._check_range(overlap)
        return force, stiffness

    def _answer_between_ends(self, overlap, ends, arrays, force, stiffness):
        """Evaluate contacts beyond the lowest end of all but not beyond their own; their history is as it was before."""
        again = np.flatnonzero(np.isnan(force) & (overlap <= ends))
        states = tuple(array[again] for array in arrays)
        results = np.empty(again.size, force.dtype), np.empty(again.size, stiffness.dtype)
        pair = self.shape, gather(self.params, again)
        batch_loop(self.rule_tag, *pair, overlap[again], states, UNBOUNDED, FINITE, *results)
        for array, values in zip((force, stiffness, *arrays), (*results, *states), strict=True):
            array[again] = values

    @functools.cached_property
    def _largest_overlaps(self):
        """Largest valid overlap [m], one number or one per contact; then the lowest of all contacts' and the largest expected
        value, for `batch_loop`: with one end per contact a batch of tables took a tenth longer."""
        radius = np.asarray(self._radius)
        end = np.minimum(LARGEST_OVERLAP * radius, self._curve_end())
        small = np.minimum(SMALL_OVERLAP * radius, end).ravel()
        most = force_loop(self.shape, self.params, small)[0] if self.state_size else small
        return end, (float(np.min(end)), float(min(np.min(most), FINITE)))

    def _largest_unloading_force(self):
        """Force [N] at the end of the unloading curve."""
        curve, contact = self.unloading_parts.curve, self.unloading_parts.contact
        return math.inf if curve is None or contact is None else curve.largest_force(bind_params(curve.shape, contact))

    def _curve_end(self):
        """Overlap [m] at which the curve ends, or its unloading curve in force; one number or one per contact."""
        force = self._largest_unloading_force()
        end = self.curve.end(loading_part(self.params))
        if force == math.inf:
            return end
        result = inverse_loop(self.shape, self.params, np.full(self.contact.size or 1, force))
        result[np.isnan(result)] = math.inf
        return np.minimum(end, result if self.contact.size is not None else float(result[0]))

    def _arrays_of(self, state, n):
        """The arrays of a batch's state, checked."""
        from demlaws.responses.batch import State

        if state is not None and not isinstance(state, State):
            raise DemlawsError(f"state must be what law.new_state({n}) returns, got {state!r}")
        names = () if state is None else state.names
        if names != self.state_names:
            suffix = "" if state is None else f"; this one has {', '.join(names) or 'no quantities'}"
            raise DemlawsError(f"{self.unloading} unloading needs the state that law.new_state({n}) returns{suffix}")
        arrays = () if state is None else state.arrays
        if any(array.size != n for array in arrays):
            raise DemlawsError(f"the state holds {arrays[0].size} contacts, overlap has {n}")
        return arrays

    def _why_not_finite(self, overlap, index):
        overlap, radius = float(overlap), float(np.broadcast_to(self._radius, self.contact.size or index + 1)[index])
        if not math.isfinite(overlap):
            return f"overlap is {overlap:g} m: give finite values"
        try:
            check_overlaps(overlap, radius)
        except DemlawsError as error:
            return str(error)
        return self._out_of_range(overlap)

    def _check_range(self, overlap, source=()):
        """Refuse overlaps beyond R, and warn of those beyond a tenth of it: with one text per law, as Python's filters need."""
        if check_overlaps(overlap, self._radius, source) is not None:
            radius = float(np.min(self._radius))
            warn(
                f"{self.name}: overlap above {SMALL_OVERLAP * radius:.6g} m, {SMALL_OVERLAP:g} of the effective radius "
                f"R = {radius:g} m: contact laws are valid up to there; check units, loads and the step",
                LargeOverlap,
            )

    def single_params(self) -> tuple:
        """Params of the one contact; DemlawsError if the law has an array of contacts."""
        if self.contact.size is not None:
            raise DemlawsError("a path is followed by one contact; this law holds an array of contacts: use evaluate")
        return self.params

    def _path_of(self, overlap, state, source):
        """Overlaps [m] of one contact's path, the shape in which they were given, and the arrays of its state."""
        self.single_params()
        values, shape = self._shaped(overlap, "overlap", "m")
        if values.ndim > 1:
            raise DemlawsError(f"a path is a 1-D sequence of overlaps in m, got an array of shape {values.shape}")
        self._check_range(values, source)
        return values.ravel(), shape, self._arrays_of(self.new_state(1) if state is None else state, 1)

    def follow(self, overlap: ArrayLike, state: "State | None" = None) -> "Path":
        """Compute one contact along a sequence of overlaps.

        Parameters
        ----------
        overlap : array_like
            Overlaps [m].
        state : State, optional
            History at the start, which is updated; default: a contact that has not been loaded.

        Returns
        -------
        Path
        """
        return self._follow(overlap, state, overlap)

    def _follow(self, overlap, state, source):
        """As `follow`; source: the user's own overlaps, which an error shows."""
        state = self.new_state(1) if state is None else state
        values, _, arrays = self._path_of(overlap, state, source)
        columns = [np.empty(values.size) for _ in range(4)]
        history = tuple(np.zeros(values.size) for _ in self.state_names)
        banked = follow_loop(self.rule_tag, self.shape, self.params, values, arrays, history, *columns)
        force, stiffness, stored, dissipated = columns
        dissipated += state.banked
        state.banked += max(banked, 0.0)  # rounding of an elastic contact
        if not np.all(np.isfinite(force)):
            raise DemlawsError(self._out_of_range(typed(values.max(), source, "m")))
        self._warn_of_limits(force)
        quantities = dict(zip(self.state_names, history, strict=True))
        maximum = quantities.get("maximum_overlap", np.maximum.accumulate(np.maximum(values, 0.0)))
        plastic = quantities.get("plastic_overlap", np.full(values.size, math.nan if self.state_names else 0.0))
        from demlaws.responses.path import Path

        return Path(values, force, stiffness, maximum, plastic, stored, dissipated)

    @overload
    def shear_stiffness(
        self, overlap: float | str, ratio: float, shear: str = ..., *, state: "State | None" = ...
    ) -> float: ...

    @overload
    def shear_stiffness(
        self, overlap: ArrayLike, ratio: float, shear: str = ..., *, state: "State | None" = ...
    ) -> np.ndarray: ...

    def shear_stiffness(self, overlap: ArrayLike, ratio: float, shear: str = DEFAULT, *, state: "State | None" = None) -> Any:
        """Tangential stiffness K_t [N/m] of one contact along a sequence of overlaps [m]; `state` is updated.

        K_t = ratio K_s, where ratio is that of an elastic contact, 2(1-ν)/(2-ν) for two bodies of one material (Mindlin 1949),
        and K_s by `shear`: "elastic", the tangent stiffness of unloading, or "loading", that of first
        loading at the present force.
        """
        if not isinstance(shear, str) or shear not in CHOICES:
            raise DemlawsError(
                f"shear must be {', '.join(map(repr, CHOICES))}, got {shear!r}: the normal stiffness used to compute K_t"
            )
        ratio = number(ratio, "ratio")
        values, shape, arrays = self._path_of(overlap, state, overlap)
        result = shear_loop(CHOICES[shear].tag, self.rule_tag, self.shape, self.params, values, arrays)
        if not np.all(np.isfinite(result)):
            raise DemlawsError(self._out_of_range(typed(values.max(), overlap, "m")))
        return as_given(ratio * result.reshape(shape))

    @overload
    def unloading_overlap(self, force: float | str, state: "State") -> float: ...

    @overload
    def unloading_overlap(self, force: ArrayLike, state: "State") -> np.ndarray: ...

    def unloading_overlap(self, force: ArrayLike, state: "State") -> Any:
        """Overlap [m] at which a contact with this history, below its maximum overlap, carries `force` ≥ 0 [N]."""
        values, shape = self._shaped(force, "force", "N")
        states = tuple(np.full(values.size, float(array[0])) for array in self._arrays_of(state, 1))
        result = unloaded_loop(self.rule_tag, self.shape, self.single_params(), values.ravel(), states)
        return as_given(result.reshape(shape))

    # --- range

    def limits(self) -> list:
        """The validity ranges of the law in force [N], each with its reason."""
        return self._limits

    @functools.cached_property
    def _limits(self):
        return self.definition.limits(self.contact, **self.options)

    def breaches(self, smallest: float, largest: float) -> list[Breach]:
        """Limits of the law exceeded by forces from `smallest` to `largest` [N], the largest excess first."""
        smallest, largest = float(as_float(smallest, "smallest", "N")), float(as_float(largest, "largest", "N"))
        if smallest != smallest or largest != largest:
            raise DemlawsError(f"smallest = {smallest}, largest = {largest}: give two forces in N")
        pairs = []
        for limit in self.limits():
            if largest > limit.maximum_force:
                pairs.append((largest / max(limit.maximum_force, 1e-300), Breach(largest, limit.maximum_force, limit.reason)))
            elif smallest < limit.minimum_force:
                pairs.append((limit.minimum_force / max(smallest, 1e-300), Breach(smallest, limit.minimum_force, limit.reason)))
        return [breach for _, breach in sorted(pairs, key=lambda one: -one[0])]

    def _warn_of_limits(self, force):
        touching = np.extract(force > 0.0, force)
        for breach in self.breaches(float(np.min(touching, initial=math.inf)), float(np.max(touching, initial=0.0))):
            warn(f"{self.name} {breach.range}: {breach.reason}")


def _numbers(value: Any, name: str, unit: str) -> np.ndarray:
    """A user's array of float64 or float32 as it is, anything else as float64."""
    if type(value) is np.ndarray and value.dtype in (np.float64, np.float32):
        return value
    return as_float(value, name, unit, array=True)
