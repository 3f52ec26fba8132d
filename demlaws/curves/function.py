"""A curve of first loading from a user's function force(overlap), checked before it becomes a table (`Table.from_function`)."""

import itertools
import math
from collections.abc import Callable
from typing import Any

import numpy as np

from demlaws.curves.soundness import fault_of_slope, fault_of_values
from demlaws.errors import DemlawsError
from demlaws.units import positive

_STEPS = 2e-3, 5e-4
"""Distance of the samples in ln δ, the second where the first does not do."""
_AGREE, _MOST = 1e-8, 1e-6
"""Relative distance of a sample from a spline through its neighbours, from which on there is a kink, or no derivative."""
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


def _refuse(fault):
    """Raise DemlawsError where there is a fault (text)."""
    if fault is not None:
        raise DemlawsError(f"the force function cannot be used: {fault}")


class GivenCurve:
    """force(overlap) with its stiffness, given or derived, up to `largest` [m]; beyond, a power law with the exponent there.

    The derivative is that of splines of degree 5 over ln δ, one between any two kinks, from 2^-31 of `largest` or of the
    table's `length` [m] on. Kinks are located where a spline through every second sample misses the others.
    """

    def __init__(
        self,
        force: Callable,
        largest: float,
        stiffness: Callable | None = None,
        kinks: Any = (),
        length: float = math.inf,
    ):
        self.largest = largest
        scan = largest * np.geomspace(2.0**-30, 1.0, _SCAN)
        self.force = Called(force, "force", "N", scan)
        self.slope = None if stiffness is None else Called(stiffness, "stiffness", "N/m", scan)
        _refuse(fault_of_values(scan, self.force(scan), None if self.slope is None else self.slope(scan)))
        self.kinks = sorted(float(k) for k in np.atleast_1d(positive(kinks, "kinks", "m")) if k < largest)
        start, later = self.force(scan[[0, 40]])
        if later < start * (scan[40] / scan[0]) ** 0.05 or start == 0.0:
            _refuse(
                "towards overlap 0 the force must go to 0 N, and be 0 N nowhere else; "
                f"at overlap {scan[0]:.3g} m it is {start:.6g} N"
            )
        self._fit(2.0**-31 * min(largest, length))
        _refuse(fault_of_slope(self.evaluate, scan[:: 5 if self.slope is None else 1]))
        last, tangent = (float(v[0]) for v in self._inside(np.array([largest])))
        self.end = last, tangent * largest / last

    # --- derivative

    def _fit(self, lowest):
        """Make the splines from the overlap `lowest` [m] on, and find the kinks between them."""
        self.kinks = [kink for kink in self.kinks if kink > lowest]
        for again in (True, True, True, False):
            self.splines, found, worst = [], [], (0.0, 0.0)
            for a, b in itertools.pairwise([lowest, *self.kinks, self.largest]):
                overlap, missed = self._add_spline(a, b)
                worst = max(worst, (float(missed.max()), float(overlap[2 * np.argmax(missed) + 1])))
                wrong = np.flatnonzero(missed > _AGREE)
                for group in np.split(wrong, np.flatnonzero(np.diff(wrong) > 1) + 1) if wrong.size else ():
                    kink = self._located(overlap[2 * group[0]], overlap[2 * group[-1] + 2])
                    if all(abs(kink / k - 1.0) > 1e-6 for k in (*self.kinks, *found, self.largest)):
                        found.append(kink)
            if not (found and again):
                break
            self.kinks = sorted([*self.kinks, *found])
            if len(self.kinks) > _MOST_KINKS:
                raise DemlawsError(
                    f"the force function has more than {_MOST_KINKS} kinks, or noise, between overlap {self.kinks[0]:.6g} m "
                    f"and {self.kinks[-1]:.6g} m: give a smooth one, or its points to Table.from_points"
                )
        if self.slope is None and worst[0] > _MOST:
            raise DemlawsError(
                f"the force function has no derivative to be found at overlap {worst[1]:.6g} m (it is {worst[0]:.1g} off a "
                "curve through its neighbours): it is noisy or has a kink there; give kinks=[...] or stiffness=..."
            )

    def _add_spline(self, a, b):
        """Add the spline between two overlaps; returns its samples, and by how much one through every second misses others."""
        from scipy.interpolate import make_interp_spline

        for step in _STEPS:
            count = max(8, math.ceil(math.log(b / a) / (2.0 * step)))
            x = np.linspace(math.log(a), math.log(b), 2 * count + 1)
            overlap = np.clip(np.exp(x), a, b)
            force = self.force(overlap)
            _refuse(fault_of_values(overlap, force))
            missed = np.abs(make_interp_spline(x[::2], force[::2], 5)(x[1::2]) / force[1::2] - 1.0)
            if missed.max() <= _AGREE:
                break
        self.splines.append(make_interp_spline(x, force, 5))
        return overlap, missed

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
            _refuse(f"at overlap {b:.6g} m the force jumps from {low:.6g} N to {high:.6g} N: it must be continuous")
        return 0.5 * (a + b)

    # --- as a table's source reads it

    def _inside(self, overlap):
        force = self.force(overlap)
        if self.slope is not None:
            return force, self.slope(overlap)
        x, exponent = np.log(overlap), np.empty(overlap.size)
        piece = np.searchsorted(self.kinks, overlap, side="left")  # on a kink: the part below it
        for n, spline in enumerate(self.splines):
            here = np.maximum(x[piece == n], spline.t[0])  # a power law below the samples
            exponent[piece == n] = spline(here, 1) / spline(here)
        return force, exponent * force / overlap

    def evaluate(self, overlap: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Force [N] and stiffness [N/m] at overlaps [m] > 0."""
        overlap = np.asarray(overlap, float)
        inside = overlap <= self.largest * (1.0 + 1e-15)
        force, stiffness = np.empty(overlap.size), np.empty(overlap.size)
        if np.any(inside):
            force[inside], stiffness[inside] = self._inside(np.minimum(overlap[inside], self.largest))
            order = np.argsort(overlap[inside], kind="stable")
            _refuse(fault_of_values(overlap[inside][order], force[inside][order]))
        if not np.all(inside):
            relative = overlap[~inside] / self.largest
            last, exponent = self.end
            force[~inside] = last * relative**exponent
            stiffness[~inside] = exponent * force[~inside] / overlap[~inside]
        return force, stiffness
