"""Tables: a law's dimensionless curve on a bit-indexed semi-logarithmic grid, certified; `table_file` has their text.

With u = δ/length and f = P/(E* √R length^1.5) a table holds s(u) = (3f/4)^(2/3), the Hertz-equivalent overlap, as one
cubic a cell. Then f = (4/3) s^1.5, df/du = 2 √s ds/du and the plastic overlap of Hertz unloading is u - s: no power, no
cube root. Each octave of u is cut into 2^bits equal cells, whose number stands in the exponent and the top mantissa
bits of u. A cell with a kink is split there, and all cells right of it move up by one.
"""

import functools
import json
import math
import os
import re
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from demlaws import table_file
from demlaws.contact import Contact
from demlaws.core.curve import BulkYield
from demlaws.core.grid import MOST_BITS, NO_YIELD, Nodes, grid, quick_to_invert, shape_from_nodes
from demlaws.core.loops import inverse_loop
from demlaws.core.params import (
    SMOOTHEST,
    bind_params,
    clamped_roughness,
    clamped_roughnesses,
    first_loading,
    loading_part,
    one_of,
)
from demlaws.core.unloading import GIVEN, JoinedShape
from demlaws.errors import DemlawsError
from demlaws.files import as_path, write_atomically, write_together
from demlaws.given import Called, GivenCurve, Knots, MeasuredCurve, residual_overlap
from demlaws.joining import joined_law
from demlaws.law import Law, _as_given
from demlaws.laws.definition import Definition
from demlaws.laws.registry import find, is_own, mark, registry
from demlaws.soundness import refuse_unless_collapses
from demlaws.table_file import UNLOADING, Rows
from demlaws.units import SMALL_OVERLAP, check_overlaps, number


class Source(NamedTuple):
    """A curve to tabulate, of one contact, and the scales of the table."""

    exact: Callable  # overlaps [m] → force [N], stiffness [N/m]
    length: float  # [m]
    hertz_coefficient: float  # [N/m^1.5]
    kinks: list  # u
    solved: bool
    aside: float = 1e-14  # how far beside a kink its one-sided stiffness is read, over its overlap

    def curve(self, u):
        """s(u) and ds/du."""
        force, stiffness = self.exact(u * self.length)
        equivalent = np.cbrt(force / self.hertz_coefficient) ** 2
        return equivalent / self.length, stiffness / (1.5 * self.hertz_coefficient * np.sqrt(equivalent))

    def nodes(self, lowest, highest, bits_per_octave):
        """Rows of the table from `lowest` to `highest` u."""
        u, kinks = grid(lowest, highest, self.kinks, bits_per_octave)
        place = u.copy()
        for kink in kinks:  # one-sided stiffness: just left and just right of the kink
            first, second = np.flatnonzero(u == kink)
            place[first] = kink * (1.0 - self.aside)
            place[second] = kink * (1.0 + self.aside)
        s, slope = self.curve(place)
        for kink in kinks:
            second = np.flatnonzero(u == kink)[1]
            if abs(s[second] / s[second - 1] - 1.0) < 1e-10:  # no jump of force: one value for both sides
                s[second] = s[second - 1]
        return Nodes.from_curve(u, s, slope)

    def lowest(self, rtol, largest):
        """Largest u, but at least 2^-30, below which the curve is its own power law within a small part of rtol."""
        u = 2.0 ** np.arange(-30.0, 1.0)
        u = u[u <= max(largest, u[0])]
        s, slope = self.curve(u)
        exponent = u * slope / s
        with np.errstate(all="ignore"):
            bend = np.abs(exponent - exponent[0])
        good = np.flatnonzero(bend <= 0.02 * rtol)
        return float(u[good[-1]]) if good.size else float(u[0])

    def certify(self, shape, table):
        """`Certificate` of a table's shape, bound to the contact as `table`."""
        starts = shape.grid.starts
        u = np.append(starts[:, 3] + starts[:, 4] * starts[:, 0], shape.grid.highest)
        # where cubics through exact ends err most in value and in slope; closer together for laws that have cells of their own
        fractions = np.unique([0.2113, 0.5, 0.7887, *np.linspace(0.0, 1.0, 32 if self.solved else 12)[1:-1]])
        width = np.diff(u)
        points = (u[:-1, None] + width[:, None] * fractions).ravel() * self.length
        force, stiffness = _curve_of(table)(points)
        exact_force, exact_stiffness = self.exact(points)
        with np.errstate(divide="ignore", invalid="ignore"):
            errors = np.abs(force / exact_force - 1.0), np.abs(stiffness / exact_stiffness - 1.0)
        return Certificate(float(np.max(errors[0])), float(np.max(errors[1])))


def _curve_of(params):
    """`Source.exact` of a law's params."""

    def exact(overlap):
        force, stiffness = np.empty(overlap.size), np.empty(overlap.size)
        first_loading(params, overlap, force, stiffness)
        return force, stiffness

    return exact


class Certificate(NamedTuple):
    """Largest relative errors measured between the nodes against the law itself."""

    force_error: float
    stiffness_error: float


RADII_SERVED = 10.0  # a table that collapses reaches to a tenth of so many times its contact's radius


def _length(definition, contact):
    """Dimensionless length of a law's table: multiples of σ and of R."""
    smooth = np.all(np.asarray(contact.roughness) <= SMOOTHEST * np.asarray(contact.radius))
    return (0.0, 1.0) if definition.length == "radius" or smooth else (1.0, 0.0)


def tabulate(law: Law, rtol: float = 1e-5, max_force: float | None = None) -> "Table":
    """The smallest `Table` of `law` whose force and stiffness lie within `rtol`, measured between the nodes.

    The range ends at the overlap of `max_force` [N] or at a tenth of the radius, and goes down to where the law is a
    power law within `rtol`. A law whose curve collapses gives one table for every radius, modulus and roughness; without
    `max_force` it ends at a tenth of a radius ten times as large.
    """
    rtol = _tolerance(rtol)
    definition, contact = law.definition, law.contact
    _refuse_too_fine(law, rtol)
    if is_own(definition) and law.collapses and type(law) is Law:
        refuse_unless_collapses(law)
    if contact.size is not None and not law.collapses:
        raise DemlawsError(
            f"law {law.name!r} has no single dimensionless curve for contacts that differ: tabulate one contact of each kind"
        )
    if law.unloading_law is not None:
        return with_curve(tabulate(law.joined("elastic"), rtol, max_force), law.unloading_law)
    if definition.rule(law.unloading).curve == "law" and not isinstance(law, Table):
        return with_own_rule(tabulate(law.joined("elastic"), rtol, max_force), definition.rule(law.unloading))
    largest = 0.1 * np.max(np.asarray(contact.radius) / _lengths(definition, contact))
    index, one = _pick(contact)
    over_roughness, over_radius = _length(definition, one)
    if law.collapses:
        largest *= RADII_SERVED
    roughness = clamped_roughness(one.roughness, one.radius)
    length = over_roughness * roughness + over_radius * one.radius
    if max_force is not None:
        force = number(max_force, "max_force", "N")
        largest = float(np.max(law.overlap(np.broadcast_to(force, contact.size or ()))) / length) * (1.0 + 1e-9)
    params = loading_part(bind_params(law.shape, one))
    kinks = [k / length for k in _kinks_of_one(law, index)]
    source = Source(_curve_of(params), length, params.hertz_coefficient, kinks, definition.solved)
    smallest = min(source.lowest(rtol, largest), largest / 64.0)
    straight = _starts_from_force(law)
    for bits_per_octave in range(1, MOST_BITS + 1):
        nodes = source.nodes(smallest, largest, bits_per_octave)
        bulk = _bulk_yield(law, params, length, nodes.u[-1])
        shape = shape_from_nodes(nodes, bits_per_octave, over_roughness, over_radius, bulk, straight)
        certificate = source.certify(shape, bind_params(shape, one))
        if max(certificate) <= rtol:
            return Table(law, shape, nodes, certificate, rtol)
    raise _out_of_reach(law.name, rtol, certificate)


def _tolerance(rtol):
    try:
        rtol = float(rtol)
    except (TypeError, ValueError):
        rtol = math.nan
    if not 1e-12 <= rtol <= 0.1:
        raise DemlawsError(f"rtol = {rtol:g}: give a relative tolerance from 1e-12 to 0.1")
    return rtol


def _out_of_reach(name, rtol, certificate):
    return DemlawsError(
        f"rtol = {rtol:g} is out of reach: with {2**MOST_BITS} cells an octave the table of {name!r} errs by "
        f"{max(certificate):.2g}; ask for more than that"
    )


def _refuse_too_fine(law, rtol):
    if law.definition.solved and rtol < 1e-5:
        raise DemlawsError(
            f"rtol = {rtol:g}: the curve of {law.name!r} comes from a solver, to 1e-6 itself; ask for 1e-5 or more"
        )


def _pick(contact):
    """The contact of an array of contacts for which its one table is made: the smoothest has the longest range."""
    if contact.size is None:
        return 0, contact
    index = int(np.argmin(np.broadcast_to(contact.roughness, contact.size)))
    names = ("radius", "modulus", "roughness")
    return index, contact.with_values(**{n: float(np.broadcast_to(getattr(contact, n), contact.size)[index]) for n in names})


def _kinks_of_one(law, index):
    """Overlaps [m] of the kinks of contact `index`."""
    if isinstance(law, Table):
        return list(law.nodes.kinks * np.ravel(law.length)[min(index, np.size(law.length) - 1)])
    if law.contact.size is None:
        return law.kinks()
    return list(law.definition.kinks(one_of(loading_part(law.params), index), **law.options))


def take(law, rule, curve=None):
    """A law or a table with another unloading rule, and its curve where the rule is "table"; see `Law.joined`."""
    if not isinstance(law, Table):
        return joined_law(law, rule, curve)
    shape, certificate = law.loading_shape, (law.force_error, law.stiffness_error)
    elastic = Law(law.definition, law.contact, "elastic", law.options, shape, loading_part(law.params))
    own = law.definition.rule(rule).curve == "law"
    joined = elastic if curve is not None or own else joined_law(elastic, rule)
    plain = Table(joined, shape, law.nodes, certificate, law.rtol)
    plain.knots = law.knots
    if law.unloading_law is None:
        plain.said_to_collapse = law.said_to_collapse
    if own:
        return with_own_rule(plain, law.definition.rule(rule))
    return plain if curve is None else with_curve(plain, curve)


def with_own_rule(table, rule, numbers=None):
    """A `Table` of an elastic one and a rule of the law's own.

    The rule reads beside the curve what its numbers make (from a file, else the law's for this contact), or, of a rule
    without numbers, the law itself.
    """
    definition, options, own = table.definition, table.options, table.loading_shape
    beside = definition.shape(table.contact, **options) if numbers is None else None
    if rule.shape is not None:
        if numbers is None:
            params = one_of(bind_params(beside, table.contact), 0)
            error = table.force_error + table.stiffness_error
            numbers = definition.rule_numbers(params, float(np.ravel(table.length)[0]), error)
        beside = rule.shape(*map(float, numbers), own.length_over_roughness, own.length_over_radius)
    shape = JoinedShape(own, beside, 1.0, 1.0, 1.0)
    law = Law(definition, table.contact, rule.name, options, shape)
    joined = Table(law, shape, table.nodes, (table.force_error, table.stiffness_error), table.rtol)
    joined.said_to_collapse = table.said_to_collapse
    return joined


def with_curve(table, curve):
    """A `Table` of an elastic one and an unloading curve; the curve's rows are its own, in the table's scales."""
    _refuse_too_fine(curve, table.rtol)
    joined = joined_law(table, GIVEN, curve)
    index, one = _pick(table.contact)
    own = loading_part(table.shape)
    params = bind_params(joined.shape, one)
    length, coefficient = params.loading.length, params.hertz_coefficient
    kinks = [k / length for k in _kinks_of_one(curve, index)]
    source = Source(_curve_of(params.unloading), length, coefficient, kinks, curve.definition.solved)
    end, top = 0.75 * coefficient * length**1.5 * table.nodes.force[-1], np.empty(1)
    for bits_per_octave in range(52 - own.grid.shift, MOST_BITS + 1):
        # some cells beyond the end of the loading, so that the reverse, which ends with a whole cell, reaches it, too
        inverse_loop(params.unloading, np.array([end * (1.0 + 4.0 * 0.5**bits_per_octave)]), top)
        if not np.isfinite(top[0]):
            raise DemlawsError(
                f"the unloading curve, a table of {curve.name!r}, must reach beyond this table's {end:.4g} N: make it with a "
                "larger max_force, or this one with a smaller"
            )
        largest = top[0] / length
        nodes = source.nodes(min(source.lowest(table.rtol, largest), largest / 64.0), largest, bits_per_octave)
        if not np.all(np.isfinite(nodes.force)):  # a table as the curve ends within the last cell
            continue
        lengths = own.length_over_roughness, own.length_over_radius
        shape = shape_from_nodes(nodes, bits_per_octave, *lengths, straight=_starts_from_force(curve), floor=_floor(own))
        certificate = source.certify(shape, bind_params(shape, one))
        if max(certificate) <= table.rtol:
            law = Law(curve.definition, table.contact, "elastic", curve.options, shape)
            rows = Table(law, shape, nodes, certificate, table.rtol)
            rows.made_for = curve.made_for if isinstance(curve, Table) else curve.contact
            return _joined_table(table, rows)
    raise _out_of_reach(curve.name, table.rtol, certificate)


def _floor(shape):
    """s where the power law of a loading curve ends below: the unloading curve's ends there, too, and stays the stiffer one."""
    return None if shape.grid.seat > 0.0 else float(shape.grid.cells[0, 1])


def _joined_table(table, rows):
    """`table` with another table in its scales as its unloading curve."""
    shape = JoinedShape(loading_part(table.shape), quick_to_invert(rows.shape, rows.nodes.kinks), 1.0, 1.0, 1.0)
    law = Law(table.definition, table.contact, GIVEN, table.options, shape, None, rows)
    result = Table(law, shape, table.nodes, (table.force_error, table.stiffness_error), table.rtol)
    result.knots = table.knots
    return result


def _starts_from_force(law):
    """Whether the law's force at overlap 0+ is not 0: its curve then goes on straight below the first row."""
    if isinstance(law, Table):
        return law.loading_shape.grid.seat > 0.0
    return law.definition.seated(**law.options)


def _bulk_yield(law, params, length, highest):
    """`BulkYield` of a law whose bulk yields within the table."""
    if isinstance(law, Table):
        return law.loading_shape.bulk
    if law.definition.bulk is None:
        return NO_YIELD
    overlap, area, slope = law.definition.bulk(params)
    if not overlap / length < highest:
        return NO_YIELD
    slope = slope * params.hertz_coefficient * math.sqrt(length)
    while 0.75 * slope / 0.75 != slope:  # a file holds three quarters of it, and gives back the same
        slope = math.nextafter(slope, 0.0)
    return BulkYield(area / length, slope)


def _lengths(definition, contact):
    if _length(definition, contact)[1]:
        return np.asarray(contact.radius)
    return clamped_roughnesses(contact)


# --- curves that a user brings


def _given(curve, contact, name, description, scales_with, rtol):
    """The `Table` of a curve (`given.GivenCurve` or `MeasuredCurve`), elastic."""
    rtol = _tolerance(rtol)
    if scales_with not in (None, "radius", "roughness"):
        raise DemlawsError(f"scales_with={scales_with!r}: None (this contact only), 'radius' or 'roughness'")
    if not isinstance(name, str) or not re.fullmatch(r"[A-Za-z][\w.-]*", name, re.ASCII) or name in registry():
        raise DemlawsError(f"name={name!r:.60}: one word that is no law's name ({', '.join(registry())})")
    if not isinstance(description, str) or not description.isprintable():
        raise DemlawsError(f"description must be one line of text, got {description!r:.60}")
    rough = scales_with == "roughness"
    if rough and contact.roughness == 0.0:
        raise DemlawsError("scales_with='roughness', but the contact's roughness is 0 m: give it, or scales_with=None")
    length = contact.roughness if rough else contact.radius
    definition = Definition(
        name=name,
        prepare=_not_here,
        equation="",
        source="its user",
        description=description,
        limits=_no_limits,
        length="roughness" if rough else "radius",
        collapses=scales_with is not None,
        unloading=("elastic",),
    )
    coefficient = 4.0 * contact.modulus * math.sqrt(contact.radius) / 3.0
    source = Source(curve.evaluate, length, coefficient, [k / length for k in curve.kinks], False, 1e-10)
    largest = curve.largest / length * (1.0 - 1e-12)
    smallest = min(source.lowest(rtol, largest), largest / 64.0)
    start, slope = (float(v[0]) for v in curve.evaluate(np.array([smallest * length])))
    exponent = slope * smallest * length / start
    if exponent < 1.0 - 1e-6:
        raise DemlawsError(
            f"{name}: towards overlap 0 the force goes as δ^{exponent:.4g} (at overlap {smallest * length:.3g} m it is "
            f"{start:.3g} N), and the stiffness grows without bound: it must go as δ or a higher power"
        )
    for bits_per_octave in range(1, MOST_BITS + 1):
        nodes = source.nodes(smallest, largest, bits_per_octave)
        shape = shape_from_nodes(nodes, bits_per_octave, float(rough), float(not rough))
        certificate = source.certify(shape, bind_params(shape, contact))
        if max(certificate) <= rtol:
            return Table(Law(definition, contact, "elastic", {}, shape), shape, nodes, certificate, rtol)
    raise _out_of_reach(name, rtol, certificate)


_REACH = 3.2  # of an unloading curve beyond its table's end, whose last cells are wide where the table is rough


def _unloading_along(table, curve, scales_with):
    """`table` with another curve of the user's to unload along; its rows are certified against that curve."""
    name = f"{table.name}-unloading"
    other = _given(curve, table.contact, name, f"unloading of {table.name}", scales_with, max(0.1 * table.rtol, 1e-11))
    result = table.joined(other)
    result.unloading_law.force_error += other.force_error
    result.unloading_law.stiffness_error += other.stiffness_error
    return result


def _one_contact(contact):
    if not isinstance(contact, Contact) or contact.size is not None:
        raise DemlawsError(f"contact must be one demlaws.Contact, that of the curve, got {contact!r:.60}")
    return contact


# --- the table as a law, and its file


class Table(Law):
    """A law read from its certified table: all methods of `Law`, and `force_error`, `stiffness_error`, `save`, `load`.

    >>> law = dl.law("pohrt-popov", dl.Contact(4e-3, 32e9, roughness=2e-6, fractal_dimension=2.2), unloading="hertz")
    >>> table = law.tabulate(rtol=1e-5)
    >>> bool(table.force_error < 1e-5), table.collapses, abs(table.force(1e-6) / law.force(1e-6) - 1) < 1e-5
    (True, True, True)
    """

    def __init__(self, law, shape, nodes, certificate, rtol, contact=None):
        curve = law.unloading_law
        if curve is not None and contact is not None:
            curve = curve.lent_to(contact)
        super().__init__(law.definition, contact or law.contact, law.unloading, law.options, shape, None, curve)
        self.nodes = nodes
        self.force_error, self.stiffness_error = certificate
        self.rtol = rtol
        self.said_to_collapse = None  # what a file says, where the table comes from one
        self.knots: Knots | None = getattr(law, "knots", None)  # of a table made of points
        self.made_for = self.contact  # of a table that is the unloading curve of another: the contact of its law

    def __repr__(self):
        text = (
            f"demlaws.Table of {self.name!r}: {self.nodes.u.size} rows, force within {self.force_error:.1e}, "
            f"stiffness within {self.stiffness_error:.1e}"
        )
        return text if self.unloading_law is None else f"{text}; unloading along {self.unloading_law!r}"

    def quick_shape(self) -> Any:
        """The Shape with which this table serves as an unloading curve."""
        return quick_to_invert(self.shape, self.nodes.kinks)

    def kinks(self) -> list[float]:
        """Overlaps [m] at which the stiffness jumps or has a kink."""
        return list(self.nodes.kinks * np.ravel(self.length)[0])

    @property
    def collapses(self) -> bool:
        """Whether one dimensionless curve serves all contacts of this law."""
        return super().collapses if self.said_to_collapse is None else self.said_to_collapse

    @classmethod
    def from_function(
        cls,
        force: Callable,
        contact: Contact,
        largest_overlap: float | None = None,
        stiffness: Callable | None = None,
        unloading: Any = "elastic",
        kinks: Any = (),
        scales_with: str | None = None,
        rtol: float = 1e-5,
        name: str = "function",
        description: str = "a function of its user's",
    ) -> "Table":
        """The smallest `Table` of any rising force(overlap) [N] of overlap [m], within `rtol` of it and of its derivative.

        force: takes one number or an array; from overlap 0, where it is 0 and goes as δ or a higher power, to
        largest_overlap [m] (default a tenth of R; the last cell may go on a little, as a power law). stiffness(overlap) [N/m]:
        its derivative, checked, else found from the force; kinks: overlaps [m] where it jumps (those that are not given are
        looked for). unloading: a rule, a law or a `Table` as `law` takes it, or another function of the overlap past the foot
        δp, the curve that the contact unloads along. The table holds for `contact` only, unless scales_with says that P/(E* R²)
        is a function of δ/R ("radius"), or P/(E* √R σ^1.5) of δ/σ ("roughness").

        Raises DemlawsError, with the overlap and the value, where the function raises, is not finite, negative, falls, jumps,
        or has another derivative.
        """
        _one_contact(contact)
        end = SMALL_OVERLAP * float(contact.radius)
        if largest_overlap is not None:
            end = number(largest_overlap, "largest_overlap", "m", 0.0, float(contact.radius))
        table = _given(GivenCurve(force, end, stiffness, kinks), contact, name, description, scales_with, rtol)
        if not callable(unloading):
            return table if unloading == "elastic" else table.joined(unloading)
        # as far as the loading in force, and some more for the last cell
        called = Called(unloading, "unloading", "N", np.array([end]))
        other = GivenCurve(unloading, _overlap_of(lambda d: called(np.array([d]))[0], _REACH * table.largest_force, end))
        return _unloading_along(table, other, scales_with)

    @classmethod
    def from_points(
        cls,
        overlap: ArrayLike,
        force: ArrayLike,
        contact: Contact,
        unloading: Any = "elastic",
        uncertainty: ArrayLike | None = None,
        residual: float | None = None,
        knots: int = 24,
        scales_with: str | None = None,
        rtol: float = 1e-3,
        name: str = "points",
        description: str = "measured points",
    ) -> "Table":
        """`Table` of a rising curve through measured points: overlaps [m] and forces [N] of first loading, in any order.

        Up to `knots` points are interpolated as they are, more are averaged (`given.MeasuredCurve`); `table.knots` holds the
        knots with the standard uncertainty of their force, from `uncertainty` [N] (one, or one a point) or from the scatter,
        and what was smoothed; `rtol` is the table's distance from that curve. unloading: a rule, a law, a `Table`, or
        (overlaps, forces) measured after the largest force, whose curve past their foot δp (`residual` [m]; else found,
        `given.residual_overlap`) the contact then unloads along from any largest force. Below the first point the curve is a
        power law. The table holds for `contact` only, see `from_function`.

        Raises DemlawsError, with overlap and force, where points do not follow a rising curve or unloading does not begin where
        loading ends.
        """
        _one_contact(contact)
        curve = MeasuredCurve(overlap, force, uncertainty, knots)
        check_overlaps(curve.largest, contact.radius)
        table = _given(curve, contact, name, description, scales_with, rtol)
        if isinstance(unloading, tuple | list) and len(unloading) == 2:
            past, back, foot = residual_overlap(unloading[0], unloading[1], residual)
            other = MeasuredCurve(past, back, None, knots, "unloading")
            top, reached = float(past.max() + foot), float(back.max())
            expected = float(curve.evaluate(np.array([min(top, curve.largest)]))[0][0])
            if abs(reached / expected - 1.0) > MeasuredCurve.MOST:
                raise DemlawsError(
                    f"unloading begins at overlap {top:.6g} m with {reached:.6g} N, where loading has {expected:.6g} N: "
                    "both must be of one test, with one zero of the overlap"
                )
            reach = _overlap_of(lambda d: other.evaluate(np.array([d]))[0][0], _REACH * table.largest_force, float(past.max()))
            other.largest = max(other.largest, reach)
            table = _unloading_along(table, other, scales_with)
            table.unloading_law.knots = other.knots
        elif unloading != "elastic":
            table = table.joined(unloading)
        table.knots = curve.knots
        return table

    def uncertainty(self, overlap: ArrayLike) -> float | np.ndarray:
        """Standard uncertainty [N] of the force at overlaps [m], between those of the knots; NaN where unknown."""
        if self.knots is None:
            raise DemlawsError(
                f"the table of {self.name!r} was not made of measured points: it has no uncertainty but its certificate"
            )
        at, shape = self._shaped(overlap, "overlap", "m")
        with np.errstate(divide="ignore", invalid="ignore"):
            found = np.interp(np.log(at), np.log(self.knots.overlap), self.knots.uncertainty)
        return _as_given(found.reshape(shape))

    @property
    def rows(self) -> Rows:
        """What a file holds of the curve of first loading."""
        grid = self.loading_shape.grid
        return Rows(self.nodes, 52 - grid.shift, grid.seat > 0.0)

    @property
    def loading_shape(self) -> Any:
        """`TableShape` of first loading."""
        return loading_part(self.shape)

    @property
    def length(self) -> float | np.ndarray:
        """Length [m] that makes overlaps dimensionless, one a contact."""
        return loading_part(self.params).length

    @property
    def largest_overlap(self) -> float:  # type: ignore[override]
        """End of the table [m]."""
        return self.loading_shape.grid.highest * np.min(self.length)

    @property
    def largest_force(self) -> float:  # type: ignore[override]
        """Force [N] at the end of the table."""
        scale = 0.75 * np.min(self.params.hertz_coefficient * np.asarray(self.length) ** 1.5)
        return float(scale * self.nodes.force[-1])

    def _curve_end(self):
        return np.minimum(super()._curve_end(), self.loading_shape.grid.highest * np.asarray(self.length))

    def _out_of_range(self, overlap):
        return (
            f"overlap {overlap:g} m is beyond the table, which ends at {self.largest_overlap:g} m ({self.largest_force:g} N): "
            "make it with a larger max_force"
        )

    def _force_out_of_range(self, force):
        return f"force {force:g} N is beyond the table, which ends at {self.largest_force:g} N: make it with a larger max_force"

    def bound_to(self, contact: Contact) -> "Table":
        """The same curve for another contact (or array of contacts); only a law whose curve collapses allows that."""
        if not isinstance(contact, Contact):
            raise DemlawsError(f"contact must be a demlaws.Contact, got {contact!r:.60}")
        if not self.collapses:
            raise DemlawsError(
                f"the table of {self.name!r} holds for the contact it was made for only: make one for this contact"
            )
        if self.loading_shape.length_over_roughness and np.any(np.asarray(contact.roughness) == 0.0):
            raise DemlawsError("roughness = 0 m: this table scales with roughness; use law 'hertz' for a smooth contact")
        for name in ("fractal_dimension", "hardness"):  # what the curve's form depends on
            made_for, wanted = getattr(self.contact, name), getattr(contact, name)
            if made_for is None or name not in self.definition.needed(**self.options):
                continue
            if wanted is not None and not math.isclose(wanted, made_for, rel_tol=1e-6):
                raise DemlawsError(f"the table is for {name} = {made_for:g}, the contact has {wanted:g}: make one for that")
            contact = contact.with_values(**{name: made_for})
        bound = Table(self, self.shape, self.nodes, (self.force_error, self.stiffness_error), self.rtol, contact)
        bound.said_to_collapse = self.said_to_collapse
        return bound

    def lent_to(self, contact: Contact) -> "Table":
        """`bound_to` of an unloading curve, whose surface is its own: only radius, modulus and roughness are the contact's."""
        own = {name: getattr(self.contact, name) for name in ("fractal_dimension", "hardness")}
        return self.bound_to(contact.with_values(**own) if isinstance(contact, Contact) else contact)

    def save(self, path: str | os.PathLike) -> Path:
        """Write the table as text with its certificate, its unloading curve below it; see `Table.load`.

        Of a rule that a user brought with the law the code is written, too, beside the file: PATH.so (takes g++); both files
        or none.
        """
        data = self._compose()[0]
        if self._native_rule is None:
            return write_atomically(path, data)
        return write_together((f"{os.fspath(as_path(path))}.so", self._native_rule), (path, data))

    @functools.cached_property
    def _native_rule(self):
        """Object with the code of a rule that a user brought, or None where the file says all."""
        rule = self.definition.rule(self.unloading)
        if rule.number is not None:
            return None
        from demlaws.rule_object import rule_object

        return rule_object(rule, self.shape.unloading)

    @property
    def fingerprint(self) -> int:
        """Check value (CRC-32) of the file that `save` writes: tables with one fingerprint are one table."""
        return self._compose()[1]

    def _compose(self):
        from demlaws import __version__

        shape, curve = self.loading_shape, self.unloading_law
        rule = self.definition.rule(self.unloading)
        header = {
            "law": self.name,
            "description": _about(self.definition),
            "source": self.definition.source,
            "unloading": self.unloading if rule.number is not None else table_file.OWN,
            "options": json.dumps(self.options, default=lambda value: value.record()),
            **table_file.describe_contact(self.contact),
            "collapses": "yes" if self.collapses else "no",
            "scales": "overlap/length, force/(E* sqrt(R) length^1.5), stiffness/(E* sqrt(R length)), R and E* effective",
            "length": repr(float(np.ravel(self.length)[0])),
            "length_over_roughness": repr(shape.length_over_roughness),
            "length_over_radius": repr(shape.length_over_radius),
            **table_file.describe_rows(self.rows, (self.force_error, self.stiffness_error)),
            "rtol": repr(self.rtol),
            **({} if self.knots is None else {"points": self.knots.text()}),
            "demlaws": __version__,
        }
        if math.isfinite(shape.bulk.area):
            u, s, _ = self.nodes.curve()
            header["yield_overlap"] = repr(float(u[np.argmin(np.abs(s - shape.bulk.area))]))  # a kink of these laws: a row
            header["yield_force"] = repr(4.0 / 3.0 * shape.bulk.area**1.5)
            header["yield_area"] = repr(shape.bulk.area)
            header["yield_area_slope"] = repr(0.75 * shape.bulk.slope)  # by f, not by s^1.5
        if self._native_rule is not None:
            header |= dict(zip(table_file.OF_OWN_RULE, (rule.name, _check_value(self._native_rule)), strict=True))
            header["rule_source"] = mark(self.definition) or "-"
        elif rule.keys:
            header |= {key: repr(value) for key, value in zip(rule.keys, self.shape.unloading, strict=False)}
        if curve is not None:
            about = {
                "law": curve.name,
                "description": _about(curve.definition),
                "source": curve.definition.source,
                "options": json.dumps(curve.options, default=lambda value: value.record()),
                **table_file.describe_contact(curve.made_for),
                **table_file.describe_rows(curve.rows, (curve.force_error, curve.stiffness_error)),
            }
            if isinstance(curve, Table) and curve.knots is not None:
                about["points"] = curve.knots.text()
            header |= {UNLOADING + key: value for key, value in about.items()}
        return table_file.compose(header, self.rows, None if curve is None else curve.rows)

    @classmethod
    def load(cls, path: str | os.PathLike) -> "Table":
        """Read a table written by `save`. A truncated, edited or foreign file is refused with its line number.

        A law that this version of demlaws does not have is no error: its table is its curve.
        """
        path = as_path(path)
        try:
            data = path.read_bytes()
        except OSError as error:
            raise DemlawsError(f"cannot read table {path}: {error.strerror or error}") from error
        file = table_file.parse(data, path)
        values = file.values
        lengths = values["length_over_roughness"], values["length_over_radius"]

        def table(prefix, unloading, contact, bulk=NO_YIELD, floor=None):
            """What the rows and the keys with this prefix make."""
            rows = file.unloading if prefix else file.loading
            shape = shape_from_nodes(rows.nodes, rows.bits, *lengths, bulk, rows.straight, floor)
            # bound to the file's curve, not to the law's own: a solved law would be solved again, a measured one is not here
            source = Law(_definition(file, prefix), contact, unloading, values[f"{prefix}options"], shape)
            certificate = Certificate(values[f"{prefix}force_error"], values[f"{prefix}stiffness_error"])
            made = cls(source, shape, rows.nodes, certificate, values["rtol"])
            if f"{prefix}points" in file.header:
                made.knots = _knots(file.header[f"{prefix}points"], path)
            return made

        bulk = NO_YIELD
        if values.get("yield_area", math.inf) < file.loading.nodes.curve()[1][-1]:
            bulk = BulkYield(values["yield_area"], values["yield_area_slope"] / 0.75)
        rule = _rule_of(file, path)
        if rule.name == values.get("rule"):
            result = with_own_rule(table("", "elastic", values["contact"], bulk), rule)
        elif rule.curve == "law":
            result = with_own_rule(table("", "elastic", values["contact"], bulk), rule, [values[key] for key in rule.keys])
        elif file.unloading is None:
            result = table("", values["unloading"], values["contact"], bulk)
        else:
            first = table("", "elastic", values["contact"], bulk)
            curve = table(UNLOADING, "elastic", values["contact"], floor=_floor(first.shape))
            curve.made_for = values["unloading_contact"]
            result = _joined_table(first, curve)
        result.said_to_collapse = values["collapses"] == "yes"
        return result


def _about(definition):
    return "; ".join(filter(None, (definition.description, definition.equation)))


def _definition(file, prefix):
    """`Definition` of a file's law, or what the file itself says of a law that is not here."""
    name, header = file.values[f"{prefix}law"], file.header
    if "rule" in file.values:
        return find(name)
    rule = table_file.rules()[file.values["unloading"]]
    try:
        definition = find(name)
        if rule.name in definition.offered():
            return definition
        return definition._replace(rules=(rule,) if rule.curve == "law" else (), refused={})  # the file knows it otherwise
    except DemlawsError:
        return Definition(
            rules=(rule,) if rule.curve == "law" else (),
            name=name,
            prepare=_not_here,
            equation="",
            source=header.get(f"{prefix}source", ""),
            description=header.get(f"{prefix}description", ""),
            limits=_no_limits,
            length="radius" if file.values["length_over_radius"] > 0.0 else "roughness",
            collapses=file.values["collapses"] == "yes",
        )


def _check_value(data):
    """What a table file says of the object beside it: CRC-32 and size."""
    return f"{zlib.crc32(data):08x} {len(data)}"


def _rule_of(file, path):
    """`Rule` of a file; one that a user brought is that of the law, which must be registered here as when it was written."""
    values = file.values
    if "rule" not in values:
        return table_file.rules()[values["unloading"]]
    definition = registry().get(values["law"])
    rule = None if definition is None else definition.offered().get(values["rule"])
    if rule is None:
        raise DemlawsError(
            f"{path}: its rule {values['rule']!r} comes with law {values['law']!r}, which is not registered here: name its "
            "file (--laws FILE.py, dl.load_laws)"
        )
    if file.header.get("rule_source", "-") not in ("-", mark(definition)):
        raise DemlawsError(
            f"{path}: law {values['law']!r} was another when the table was written: take that file of laws, or write it again"
        )
    return rule


def _knots(text, path):
    try:
        return Knots.from_text(text)
    except (ValueError, KeyError, TypeError):
        raise DemlawsError(f"{path}: the line 'points' does not hold the points of a table") from None


def _overlap_of(function, force, start):
    """An overlap [m] at which a user's rising function carries `force` [N], or as near as it comes."""
    overlap = start
    for _ in range(200):
        value = float(np.asarray(function(overlap)).ravel()[0])
        if not value < force:
            break
        overlap *= 1.1
    return overlap


def _not_here(contact, **options):
    raise DemlawsError("this law is known from a table only: it cannot be made for another contact")


def _no_limits(contact, **options):
    return []
