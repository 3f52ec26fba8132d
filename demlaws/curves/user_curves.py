"""Curves of first loading of a user: a function force(overlap), or measured points, as the parts of a `Table`."""

import functools
import itertools
import math
import re
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from demlaws.contact import Contact
from demlaws.core.loops import bind_params, params_at
from demlaws.curves.point_files import columns_of
from demlaws.curves.points import MeasuredCurve
from demlaws.curves.soundness import fault_of_slope, fault_of_values
from demlaws.curves.table import TableCurve
from demlaws.curves.table_file import definition_of_table
from demlaws.curves.tabulate import tabulate_given
from demlaws.curves.unloading import unloading_curve_at
from demlaws.errors import DemlawsError, warn
from demlaws.laws.registry import registry
from demlaws.units import SMALL_OVERLAP, check_overlaps, number, positive

_STEP = 5e-4
"""Distance of the samples of a function in ln δ."""
_SMOOTH = 1e-8
"""Relative distance of a sample from a spline through its neighbours from which on there is a kink, or noise."""
_SCAN = 1500


def curve_of_function(force, contact, largest_overlap, *, stiffness, kinks, scales_with, rtol, name, description) -> TableCurve:
    """The curve of `Table.from_function`."""
    definition = _definition(contact, name, description, scales_with)
    end = SMALL_OVERLAP * float(contact.radius)
    if largest_overlap is not None:
        end = number(largest_overlap, "largest_overlap", "m", 1e-9 * float(contact.radius), float(contact.radius))
    length = float(contact.sigma_or_zero if definition.length == "roughness" else contact.radius)
    table = tabulate_given(FunctionCurve(force, end, stiffness, kinks, length), definition, contact, rtol)
    _warn_of_other_units(table, contact, end)
    return table


def curve_of_points(points, contact, *, uncertainty, scales_with, rtol, name, description) -> tuple:
    """(curve of `Table.from_points`, the `MeasuredCurve` that it is made of)."""
    definition = _definition(contact, name, description, scales_with)
    overlap, force = columns_of(points)
    _check_loading_alone(overlap, force)
    curve = MeasuredCurve(overlap, force, uncertainty)
    check_overlaps(curve.largest, contact.radius)
    table = replace(tabulate_given(curve, definition, contact, rtol), knots=curve.knots)
    _warn_of_other_units(table, contact, curve.largest)
    return table, curve


def limited_by_unloading(table: TableCurve, measured: MeasuredCurve, law: Any) -> TableCurve:
    """A table of measured points that `law` joins with an unloading which it exceeds in stiffness, limited to that stiffness.

    NotPassive where the noise of the points does not explain the excess.
    """
    from demlaws.curves.limited import limited

    along = functools.partial(unloading_curve_at, law, params_at(law.params, 0))
    curve, knots = limited(measured, along, table.rtol, f"unloading {law.unloading!r}")
    return replace(tabulate_given(curve, table.definition, law.contact, table.rtol), knots=knots)


def _check_loading_alone(overlap, force):
    """Refuse a whole test, whose unloading would be averaged with its loading.

    Points may be in any order, and of several tests. A test in its own order makes short steps, and its overlap, averaged over
    blocks, falls by more than a tenth of its range, also if read from its end.
    """
    span, steps = np.ptp(overlap), np.diff(overlap)
    if overlap.size < 10 or np.sum(np.abs(steps)) > overlap.size / 6.0 * span:
        return
    course = np.cumsum(np.where(np.abs(steps) > 0.1 * span, 0.0, steps))  # without jumps to another test
    blocks = np.array([block.mean() for block in np.array_split(course, min(20, course.size))])
    if min(np.max(np.maximum.accumulate(b) - b) for b in (blocks, blocks[::-1])) > 0.1 * span:
        peak = int(np.argmax(force))
        raise DemlawsError(
            f"points: the overlap rises and falls (the largest force, {force[peak]:.6g} N, is point {peak}): give those of "
            "first loading alone; dl.fit takes the whole test"
        )


def _definition(contact, name, description, scales_with):
    """`Definition` of a user's curve, its description checked."""
    if not isinstance(contact, Contact) or contact.size is not None:
        raise DemlawsError(f"contact must be one demlaws.Contact, that of the curve, got {contact!r:.60}")
    if scales_with not in (None, "radius", "roughness"):
        raise DemlawsError(f"scales_with={scales_with!r}: None (this contact only), 'radius' or 'roughness'")
    if not isinstance(name, str) or not re.fullmatch(r"[A-Za-z][\w.-]*", name, re.ASCII) or name in registry():
        raise DemlawsError(f"name={name!r:.60}: use one word, not the name of a registered law ({', '.join(registry())})")
    if not isinstance(description, str) or not description.isprintable():
        raise DemlawsError(f"description must be one line of text, got {description!r:.60}")
    rough = scales_with == "roughness"
    if rough and contact.is_smooth:
        raise DemlawsError(
            "scales_with='roughness', but the contact's roughness is 0 m or not given: give it, or scales_with=None"
        )
    length = "roughness" if rough else "radius"
    return definition_of_table(name, "user-defined", description, length, scales_with is not None, unloading=("elastic",))


def _warn_of_other_units(table, contact, overlap):
    """Warn where the largest force is far from Hertz's, as by a unit."""
    force = table.largest_force(bind_params(table.shape, contact))
    hertz = 4.0 / 3.0 * contact.modulus * math.sqrt(contact.radius * overlap**3)
    if not 1.0 / 300.0 < force / hertz < 30.0:
        warn(
            f"at the largest overlap, {overlap:.3g} m, the force is {force:.3g} N, {force / hertz:.2g} of Hertz's: forces are "
            "in N, overlaps in m, the modulus in Pa"
        )


# --- a function


def _refuse(fault):
    """Raise DemlawsError where there is a fault (text)."""
    if fault is not None:
        raise DemlawsError(f"the force function cannot be used: {fault}")


class FunctionCurve:
    """force(overlap) with its stiffness, given or derived, up to `largest` [m]; beyond, a power law with the exponent there.

    The derivative is that of splines of degree 5 over ln δ, one between any two kinks, from 2^-31 of `largest` or of the
    table's `length` [m] on.
    """

    def __init__(
        self,
        force: Callable,
        largest: float,
        stiffness: Callable | None = None,
        kinks: Any = (),
        length: float = math.inf,
    ):
        self.largest, self._force, self._stiffness = largest, force, stiffness
        for what, function in (("force", force), ("stiffness", stiffness)):
            if not callable(function) and (function is not None or what == "force"):
                raise DemlawsError(f"{what} must be a function of the overlap in m, got {function!r:.60}")
        scan = largest * np.geomspace(2.0**-30, 1.0, _SCAN)
        values = _called(force, "force", scan)
        _refuse(fault_of_values(scan, values, None if stiffness is None else _called(stiffness, "stiffness", scan)))
        if values[0] == 0.0:
            _refuse(f"at overlap {scan[0]:.3g} m the force is 0 N: it must be 0 N at overlap 0 only")
        lowest = 2.0**-31 * min(largest, length)
        self.kinks = sorted(float(k) for k in np.atleast_1d(positive(kinks, "kinks", "m")) if lowest < k < largest)
        pieces = itertools.pairwise([lowest, *self.kinks, largest])
        self._splines = [self._spline(a, b) for a, b in pieces] if stiffness is None else []
        _refuse(fault_of_slope(self.evaluate, scan[:: 5 if stiffness is None else 1]))
        last, tangent = (float(v[0]) for v in self._inside(np.array([largest])))
        self._end = last, tangent * largest / last

    def _spline(self, a, b):
        """The force between two overlaps over ln δ; smooth where one through every second sample meets all."""
        from scipy.interpolate import make_interp_spline

        count = max(8, math.ceil(math.log(b / a) / (2.0 * _STEP)))
        x = np.linspace(math.log(a), math.log(b), 2 * count + 1)
        overlap = np.clip(np.exp(x), a, b)
        force = _called(self._force, "force", overlap)
        _refuse(fault_of_values(overlap, force))
        missed = np.abs(make_interp_spline(x[::2], force[::2], 5)(x[1::2]) / force[1::2] - 1.0)
        worst = int(np.argmax(missed))
        if missed[worst] > _SMOOTH:
            raise DemlawsError(
                f"the force function has no derivative to be found at overlap {overlap[2 * worst + 1]:.6g} m (it is "
                f"{missed[worst]:.1g} off a curve through its neighbours): it jumps, is noisy or has a kink there; give "
                "kinks=[...] or stiffness=..."
            )
        return make_interp_spline(x, force, 5)

    def _inside(self, overlap):
        force = _called(self._force, "force", overlap)
        if self._stiffness is not None:
            return force, _called(self._stiffness, "stiffness", overlap)
        x, exponent = np.log(overlap), np.empty(overlap.size)
        piece = np.searchsorted(self.kinks, overlap, side="left")  # on a kink: the part below it
        for n, spline in enumerate(self._splines):
            here = np.maximum(x[piece == n], spline.t[0])  # a power law below the samples
            exponent[piece == n] = spline(here, 1) / spline(here)
        return force, exponent * force / overlap

    def evaluate(self, overlap: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Force [N] and stiffness [N/m] at overlaps [m] > 0."""
        overlap = np.asarray(overlap, float)
        inside = np.minimum(overlap, self.largest)
        force, stiffness = self._inside(inside)
        order = np.argsort(inside, kind="stable")
        _refuse(fault_of_values(inside[order], force[order]))
        last, exponent = self._end if np.any(overlap > self.largest) else (0.0, 0.0)
        beyond = last * (overlap / self.largest) ** exponent
        above = overlap > self.largest
        return np.where(above, beyond, force), np.where(above, exponent * beyond / overlap, stiffness)


def _called(function, what, overlap):
    """Values of a user's function at overlaps [m], one call for each."""
    values = np.empty(overlap.size)
    for n, one in enumerate(overlap):
        try:
            values[n] = np.asarray(function(float(one))).item()
        except Exception as error:  # whatever a user's function raises, and a value that is not one number
            text = " ".join(str(error).split())
            raise DemlawsError(
                f"the {what} function does not give a number at overlap {one:.6g} m: {type(error).__name__}: {text}"
            ) from error
    return values
