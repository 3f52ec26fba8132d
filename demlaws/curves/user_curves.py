"""Tables of users' curves: the parts of the law of a function, or of measured points."""

import contextlib
import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from demlaws.contact import Contact
from demlaws.core.loops import bind_params
from demlaws.curves.function import Called, GivenCurve
from demlaws.curves.point_files import Points, columns_of
from demlaws.curves.points import MeasuredCurve, past_plastic_overlap
from demlaws.curves.table import TableCurve
from demlaws.curves.table_file import definition_of_table
from demlaws.curves.tabulate import tabulate_given, tolerance
from demlaws.errors import DemlawsError, NotPassive, warn
from demlaws.laws.registry import registry
from demlaws.units import SMALL_OVERLAP, check_overlaps, number

_REACH = 3.2  # of an unloading curve beyond its table's end, whose last cells are wide where the table is rough


def from_function(
    force, contact, largest_overlap, *, stiffness, unloading, kinks, scales_with, rtol, name, description
) -> tuple[Contact, TableCurve, Any]:
    """(contact, curve, unloading) of `Table.from_function`; the unloading is a `TableCurve` where it is a function."""
    definition = _definition(contact, name, description, scales_with)
    end = SMALL_OVERLAP * float(contact.radius)
    if largest_overlap is not None:
        end = number(largest_overlap, "largest_overlap", "m", 1e-9 * float(contact.radius), float(contact.radius))
    tolerance(rtol)
    length = float(contact.sigma if definition.length == "roughness" else contact.radius)
    table = tabulate_given(GivenCurve(force, end, stiffness, kinks, length), definition, contact, rtol)
    _warn_of_other_units(table, contact, end)
    if callable(unloading):
        force_of = Called(unloading, "unloading", "N", np.array([end]))
        reach = _overlap_of(lambda d: force_of(np.array([d]))[0], _REACH * _largest_force(table, contact), end)
        unloading = _unloading_table(GivenCurve(unloading, reach, length=length), table, contact)
    return contact, table, unloading


def from_points(
    points, contact, unloading, *, uncertainty, plastic_overlap, scales_with, rtol, name, description
) -> tuple[Contact, TableCurve, Any]:
    """(contact, curve, unloading) of `Table.from_points`; the unloading is a `TableCurve` where it is points."""
    definition = _definition(contact, name, description, scales_with)
    overlap, force = columns_of(points)
    _check_loading_alone(overlap, force)
    curve = MeasuredCurve(overlap, force, uncertainty)
    check_overlaps(curve.largest, contact.radius)
    table = replace(tabulate_given(curve, definition, contact, rtol), knots=curve.knots)
    _warn_of_other_units(table, contact, curve.largest)
    if _are_points(unloading):
        overlap, force = columns_of(unloading)
        past, back, foot = past_plastic_overlap(overlap, force, plastic_overlap)
        other = MeasuredCurve(past, back, None, "unloading")
        top, peak = float(past.max() + foot), float(back.max())
        expected = float(curve.evaluate(np.array([min(top, curve.largest)]))[0][0])
        if abs(peak / expected - 1.0) > MeasuredCurve.MOST:
            raise DemlawsError(
                f"unloading begins at overlap {top:.6g} m with {peak:.6g} N, where loading has {expected:.6g} N: "
                "both must come from one test, with the same zero of the overlap"
            )
        most = _REACH * _largest_force(table, contact)
        other.largest = max(other.largest, _overlap_of(lambda d: other.evaluate(np.array([d]))[0][0], most, float(past.max())))
        unloading = replace(_unloading_table(other, table, contact), knots=other.knots)
    return contact, table, unloading


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
            f"first loading alone, and those of unloading as unloading=points[{peak}:]; dl.fit takes the whole test"
        )


def _are_points(value):
    """Whether an unloading is neither a rule (a tuple with fields), a law nor a table."""
    plain = isinstance(value, Points | Mapping | np.ndarray | list) or type(value) is tuple
    return plain or hasattr(value, "to_numpy")


@contextlib.contextmanager
def along_points(unloading) -> Iterator[None]:
    """A refusal of measured points of unloading names what helps, beside elastic unloading."""
    try:
        yield
    except NotPassive as error:
        if not isinstance(unloading, TableCurve):
            raise
        raise NotPassive(
            error.args[0],  # without its remedy
            ". If this is noise: fit laws to all points (demlaws fit), whose loading and unloading belong together, and "
            "tabulate the best; or take 'elastic' unloading",
        ) from None


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


def _unloading_table(curve, table, contact):
    """`TableCurve` of a second curve of the user's to unload along, finer than the first."""
    name = table.definition.name
    definition = table.definition._replace(name=f"{name}-unloading", description=f"unloading of {name}")
    return tabulate_given(curve, definition, contact, max(0.1 * table.rtol, 1e-11))


def _warn_of_other_units(table, contact, overlap):
    """Warn where the largest force is far from Hertz's, as by a unit."""
    force, hertz = _largest_force(table, contact), 4.0 / 3.0 * contact.modulus * math.sqrt(contact.radius * overlap**3)
    if not 1.0 / 300.0 < force / hertz < 30.0:
        warn(
            f"at the largest overlap, {overlap:.3g} m, the force is {force:.3g} N, {force / hertz:.2g} of Hertz's: forces are "
            "in N, overlaps in m, the modulus in Pa"
        )


def _largest_force(table, contact):
    return table.largest_force(bind_params(table.shape, contact))


def _overlap_of(function, force, start):
    """An overlap [m] at which a user's rising function carries `force` [N], or as near as it comes."""
    overlap = start
    for _ in range(200):
        value = float(np.asarray(function(overlap)).ravel()[0])
        if not value < force:
            break
        overlap *= 1.1
    return overlap
