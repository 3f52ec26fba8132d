"""A curve of first loading from a user's function force(overlap), checked before it becomes a table (`Table.from_function`)."""

from collections.abc import Callable
from typing import Any

import numpy as np

from demlaws.curves.soundness import fault_of_slope, fault_of_values
from demlaws.errors import DemlawsError
from demlaws.units import positive

_STEPS = (1e-2, 1e-3, 1e-4)  # of ln δ, tried in turn
_AGREE = 1e-7  # of derivatives with one step and with twice that
_CENTRAL = np.array([-1.0, 9.0, -45.0, 0.0, 45.0, -9.0, 1.0]) / 60.0
_FORWARD = np.array([-147.0, 360.0, -450.0, 400.0, -225.0, 72.0, -10.0]) / 60.0
_PLACES = np.arange(-3, 4)
_AHEAD = np.arange(7)
_SCAN = 1500
_MOST_KINKS = 30


class Called:
    """A function of the user's, called with arrays where it takes them, else number by number."""

    def __init__(self, function, what, unit, overlap):
        if not callable(function):
            raise DemlawsError(f"{what} must be a function of the overlap in m, got {function!r:.60}")
        self.function, self.what, self.unit = function, what, unit
        self.takes_arrays = self._accepts_arrays(overlap)

    def _accepts_arrays(self, overlap):
        try:
            values = np.asarray(self.function(overlap.copy()))
            if values.shape != overlap.shape or values.dtype.kind not in "fiu":
                return False
            indices = [0, overlap.size // 2, overlap.size - 1]
            return all(
                values[k] == float(self.function(float(overlap[k]))) or values[k] != values[k] for k in indices
            ) or np.allclose(values[indices], [float(self.function(float(overlap[k]))) for k in indices], rtol=1e-12, atol=0.0)
        except Exception:  # a user's function of numbers may raise anything for an array
            return False

    def __call__(self, overlap):
        """Forces [N] at an array of overlaps [m]."""
        if self.takes_arrays:
            try:
                return np.array(self.function(overlap.copy()), dtype=float).reshape(overlap.shape)
            except Exception:  # as above; one number at a time then raises it again, with the overlap
                self.takes_arrays = False
        return np.array([self._value_at(float(x)) for x in overlap.ravel()]).reshape(overlap.shape)

    def _value_at(self, overlap):
        try:
            value = self.function(overlap)
        except Exception as error:
            raise DemlawsError(
                f"the {self.what} function raises {type(error).__name__} at overlap {overlap:.6g} m: "
                f"{' '.join(str(error).split())}"
            ) from error
        array = np.asarray(value)
        if array.size != 1 or array.dtype.kind not in "fiu":
            raise DemlawsError(
                f"the {self.what} function gives {value!r:.60} at overlap {overlap:.6g} m: one number in {self.unit} is needed"
            )
        return float(array.reshape(())) if array.ndim == 0 else float(array.ravel()[0])


class GivenCurve:
    """force(overlap) with its stiffness, given or derived, up to `largest` [m]; beyond, a power law with the exponent there.

    The derivative is that of polynomials of degree 6 in ln δ, with two steps that must agree to 1e-7, on one side of a kink.
    Kinks are looked for where they do not.
    """

    def __init__(self, force: Callable, largest: float, stiffness: Callable | None = None, kinks: Any = ()):
        self.largest = largest
        scan = largest * np.geomspace(2.0**-30, 1.0, _SCAN)
        self.force = Called(force, "force", "N", scan)
        self.slope = None if stiffness is None else Called(stiffness, "stiffness", "N/m", scan)
        self._check(scan)
        self.kinks = sorted(float(k) for k in np.atleast_1d(positive(kinks, "kinks", "m")) if k < largest)
        start, later = self.force(scan[[0, 40]])
        if later < start * (scan[40] / scan[0]) ** 0.05:
            raise DemlawsError(
                "the force function cannot be used: towards overlap 0 the force must go to 0 N; "
                f"at overlap {scan[0]:.3g} m it is {start:.6g} N"
            )
        self._find_kinks(scan)
        text = fault_of_slope(self.evaluate, scan[:: 5 if self.slope is None else 1])
        if text is not None:
            raise DemlawsError(f"the force function cannot be used: {text}")
        last, tangent = (float(v[0]) for v in self._inside(np.array([largest])))
        self.end = last, tangent * largest / last

    def _check(self, overlap):
        text = fault_of_values(overlap, self.force(overlap), None if self.slope is None else self.slope(overlap))
        if text is not None:
            raise DemlawsError(f"the force function cannot be used: {text}")

    # --- derivative

    def _stencil(self, overlap, step, factor):
        """dP/d ln δ with nodes `factor` steps apart; one-sided where a kink or the end lies within reach."""
        x, barriers = np.log(overlap), np.array([*self.kinks, self.largest])
        reach = 6.0 * step  # of the central one with two steps
        next_barrier = np.searchsorted(barriers, overlap, side="left")  # on a kink: the part below it
        logs = np.concatenate([[-np.inf], np.log(barriers), [np.inf]])
        on_left = logs[next_barrier + 1] - x <= reach  # look back
        on_right = (x - logs[next_barrier] <= reach) & ~on_left
        places = np.where(on_left[:, None], -_AHEAD, np.where(on_right[:, None], _AHEAD, _PLACES)) * (step * factor)
        weights = np.where(on_left[:, None], -_FORWARD, np.where(on_right[:, None], _FORWARD, _CENTRAL)) / (step * factor)
        at = np.exp(x[:, None] + places)
        at[places == 0.0] = np.broadcast_to(overlap[:, None], at.shape)[places == 0.0]
        force = self.force(np.minimum(at, self.largest).ravel()).reshape(at.shape)
        return np.sum(weights * force, axis=1), force

    def _derived(self, overlap):
        """K and how far two steps disagree, relative."""
        slope, doubt = np.full(overlap.size, np.nan), np.full(overlap.size, np.inf)
        open_ = np.arange(overlap.size)
        for step in _STEPS:
            one, _ = self._stencil(overlap[open_], step, 1.0)
            two, _ = self._stencil(overlap[open_], step, 2.0)
            with np.errstate(all="ignore"):
                off = np.abs(two / one - 1.0)
            better = off < doubt[open_]
            slope[open_[better]], doubt[open_[better]] = one[better], off[better]
            open_ = open_[~(off <= _AGREE)]
            if not open_.size:
                break
        return slope / overlap, doubt

    def _find_kinks(self, scan):
        """Kinks of the force: places where derivatives with a wide step disagree, narrowed down by fourth differences."""
        for _ in range(3):
            one, _ = self._stencil(scan, _STEPS[0], 1.0)
            two, _ = self._stencil(scan, _STEPS[0], 2.0)
            flagged = np.flatnonzero(np.abs(two - one) > 1e-6 * np.abs(one))
            if not flagged.size:
                return
            kinks = []
            for group in np.split(flagged, np.flatnonzero(np.diff(flagged) > 1) + 1):
                a, b = scan[max(group[0] - 1, 0)], scan[min(group[-1] + 1, scan.size - 1)]
                kink = self._located(a, b)
                if all(abs(kink / k - 1.0) > 1e-6 for k in (*self.kinks, *kinks, self.largest)):
                    kinks.append(kink)
            if not kinks:
                return
            self.kinks = sorted([*self.kinks, *kinks])
            if len(self.kinks) > _MOST_KINKS:
                raise DemlawsError(
                    f"the force function has more than {_MOST_KINKS} kinks, or noise, between overlap {self.kinks[0]:.6g} m "
                    f"and {self.kinks[-1]:.6g} m: give a smooth one, or its points to Table.from_points"
                )

    def _located(self, a, b):
        """The kink between two overlaps."""
        while b - a > 1e-12 * b:
            at = np.linspace(a, b, 41)
            force = self.force(at)
            fourth = np.abs(np.diff(force, 4))
            if fourth.max() < 2e-14 * force[-1]:
                break
            k = int(np.argmax(fourth)) + 2
            a, b = at[max(k - 3, 0)], at[min(k + 3, 40)]
        low, high = self.force(np.array([a, b]))
        if high - low > 1e-6 * high + 50.0 * high / b * (b - a):
            raise DemlawsError(
                f"the force function cannot be used: at overlap {b:.6g} m the force jumps from {low:.6g} N to {high:.6g} N: "
                "it must be continuous"
            )
        return 0.5 * (a + b)

    # --- as a table's source reads it

    def _inside(self, overlap):
        force = self.force(overlap)
        if self.slope is not None:
            return force, self.slope(overlap)
        stiffness, doubt = self._derived(overlap)
        worst = int(np.argmax(doubt))
        if doubt[worst] > 1e-4:
            raise DemlawsError(
                f"the force function has no derivative to be found at overlap {overlap[worst]:.6g} m (two steps differ by "
                f"{doubt[worst]:.1g}): it is noisy or has a kink there; give kinks=[...] or stiffness=..."
            )
        return force, stiffness

    def evaluate(self, overlap: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Force [N] and stiffness [N/m] at overlaps [m] > 0."""
        overlap = np.asarray(overlap, float)
        inside = overlap <= self.largest * (1.0 + 1e-15)
        force, stiffness = np.empty(overlap.size), np.empty(overlap.size)
        if np.any(inside):
            force[inside], stiffness[inside] = self._inside(np.minimum(overlap[inside], self.largest))
            order = np.argsort(overlap[inside], kind="stable")
            text = fault_of_values(overlap[inside][order], force[inside][order])
            if text is not None:
                raise DemlawsError(f"the force function cannot be used: {text}")
        if not np.all(inside):
            relative = overlap[~inside] / self.largest
            last, exponent = self.end
            force[~inside] = last * relative**exponent
            stiffness[~inside] = exponent * force[~inside] / overlap[~inside]
        return force, stiffness
