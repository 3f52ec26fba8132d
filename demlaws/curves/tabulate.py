"""Making tables: the fewest cells whose force and stiffness lie within a tolerance of a curve."""

import functools
import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from demlaws.contact import Contact, contact_at
from demlaws.core.dispatch import first_loading
from demlaws.core.grid import MOST_BITS, Nodes, grid, node, node_number, shape_from_nodes
from demlaws.core.loops import bind_params, clamped_roughness, clamped_roughnesses, force_loop, inverse_loop
from demlaws.core.table_types import NO_YIELD
from demlaws.curves.closed import Certificate
from demlaws.curves.soundness import refuse_unless_collapses
from demlaws.curves.table import TableCurve, plain_params
from demlaws.curves.unloading import Unloading, joined_shape
from demlaws.errors import DemlawsError
from demlaws.laws.definition import Definition
from demlaws.laws.registry import is_user_defined


class CurveSampler(NamedTuple):
    """A curve to tabulate, of one contact, and the scales of the table."""

    exact: Callable  # overlaps [m] → force [N], stiffness [N/m]
    rows: Callable  # the same, digit by digit on every processor
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
        force, stiffness = self.rows(place * self.length)
        scale = 0.75 * self.hertz_coefficient * math.sqrt(self.length)
        force, stiffness = force / (scale * self.length), stiffness / scale
        if self.solved:  # by numpy and scipy, whose last digits differ between processors
            force, stiffness = (np.array([float(f"{x:.8g}") for x in values]) for values in (force, stiffness))
        nodes = Nodes(u, force, stiffness)
        for kink in kinks:
            second = np.flatnonzero(u == kink)[1]
            if abs(force[second] / force[second - 1] - 1.0) < 1e-10:  # no jump of force: one value for both sides
                nodes.force[second] = nodes.force[second - 1]
        return nodes

    def lowest(self, rtol, largest):
        """Largest u, but at least 2^-30, below which the curve is its own power law within a small part of rtol."""
        u = 2.0 ** np.arange(-30.0, 1.0)
        u = u[u <= max(largest, u[0])]
        s, slope = self.curve(u)
        exponent = u * slope / s
        with np.errstate(all="ignore"):
            bend = np.abs(exponent - exponent[0])
        good = np.flatnonzero(bend <= 0.02 * rtol)
        return min(float(u[good[-1]]) if good.size else float(u[0]), largest / 64.0)

    def certify(self, shape, table):
        """`Certificate` of a table's shape, bound to the contact as `table`."""
        starts = shape.grid.starts
        u = np.append(starts[:, 3] + starts[:, 4] * starts[:, 0], shape.grid.highest)
        # where cubics through exact ends err most in value and in slope; closer together for laws that have cells of their own
        fractions = np.unique([0.2113, 0.5, 0.7887, *np.linspace(0.0, 1.0, 32 if self.solved else 12)[1:-1]])
        width = np.diff(u)
        points = (u[:-1, None] + width[:, None] * fractions).ravel() * self.length
        force, stiffness = force_loop(shape, table, points)
        exact_force, exact_stiffness = self.exact(points)
        with np.errstate(divide="ignore", invalid="ignore"):
            errors = np.abs(force / exact_force - 1.0), np.abs(stiffness / exact_stiffness - 1.0)
        return Certificate(*(_rounded_up(float(np.max(error))) for error in errors))


def _rounded_up(error):
    """An error with two digits: the others, and those of rounding, differ between processors."""
    digits = f"{max(error, 1e-13):.1e}"
    return float(digits) if float(digits) >= error else float(f"{1.05 * error:.1e}")


def _interpreted(shape, params):
    """The curve of a Shape and Params as Python computes it: sums and products that each are rounded by themselves.

    Compiled code may fuse them, where the processor can, and so differ in the last digits.
    """

    def curve(overlap):
        with np.errstate(all="ignore"):
            return np.array([first_loading(shape, params, x)[:2] for x in overlap]).T

    return curve


def _smallest_table(source, contact, lengths, *, rtol, name, span, first_bits=1, bulk=None, straight=False, floor=None):
    """(shape, nodes, certificate) of the table with the fewest cells whose certificate is within rtol.

    span: bits per octave → largest u; bulk: largest u of the nodes → `BulkYield`.
    """
    certificate = (math.inf,)
    for bits_per_octave in range(first_bits, MOST_BITS + 1):
        largest = span(bits_per_octave)
        nodes = source.nodes(source.lowest(rtol, largest), largest, bits_per_octave)
        if not np.all(np.isfinite(nodes.force)):  # an unloading curve that is a table ends within the last cell
            continue
        yields = NO_YIELD if bulk is None else bulk(nodes.u[-1])
        shape = shape_from_nodes(nodes, bits_per_octave, *lengths, bulk=yields, straight=straight, floor=floor)
        certificate = source.certify(shape, bind_params(shape, contact))
        if max(certificate) <= rtol:
            return shape, nodes, certificate
    raise DemlawsError(
        f"rtol = {rtol:g} cannot be reached: with {2**MOST_BITS} cells per octave the table of {name!r} errs by "
        f"{max(certificate):.2g}; use a larger tolerance, or name the overlaps of its kinks (kinks=...)"
    )


_BITS_TO_AN_END = 5  # cells of at most a 32nd of an octave: so much of the overlap, at most, is lost below the end of a law
RADII_SERVED = 10.0  # a table that collapses reaches to a tenth of so many times its contact's radius


def tabulate(contact: Contact, curve: Any, rtol: float, largest_overlap: float | np.ndarray | None = None) -> TableCurve:
    """The smallest table of a curve whose force and stiffness are within `rtol`, measured between the nodes.

    The range ends at `largest_overlap` [m], one per contact, or at a tenth of the radius (of ten times the radius where the
    curve collapses), and goes down to where the curve is a power law within `rtol`.
    """
    rtol = tolerance(rtol)
    definition = curve.definition
    _refuse_too_fine(definition, rtol)
    if is_user_defined(definition) and definition.collapses and not curve.tabulated:
        refuse_unless_collapses(curve, contact)
    _, one = _one_contact(contact)
    lengths = (0.0, 1.0) if definition.length == "radius" or np.all(contact.is_smooth) else (1.0, 0.0)
    roughness = clamped_roughness(one.sigma_or_zero, one.radius)
    length = lengths[0] * roughness + lengths[1] * one.radius
    if largest_overlap is None:
        every = np.asarray(contact.radius) if lengths[1] else clamped_roughnesses(contact)
        radius = np.asarray(definition.bulk_radius(contact, **curve.options))
        largest = 0.1 * np.max(radius / every) * (RADII_SERVED if curve.collapses else 1.0)
    else:
        largest = float(np.max(largest_overlap) / length) * (1.0 + 1e-9)
    params, plain = bind_params(curve.shape, one), plain_params(curve.shape, one)
    end = math.inf if curve.tabulated else float(np.min(curve.end(params))) / length

    def span(bits):
        # the last cell ends below the end of a law with a largest force
        return min(largest, node(node_number(end, bits), bits) * (1.0 - 1e-12)) if end < 1.001 * largest else largest

    kinks = [k / length for k in curve.kinks(plain)]
    coefficient = 4.0 * float(one.modulus) * math.sqrt(one.radius) / 3.0  # a law's own may be that of a blunter bulk
    exact, rows = functools.partial(force_loop, curve.shape, params), _interpreted(curve.shape, plain)
    source = CurveSampler(exact, rows, length, coefficient, kinks, definition.solved)
    shape, nodes, certificate = _smallest_table(
        source,
        one,
        lengths,
        rtol=rtol,
        name=definition.name,
        span=span,
        first_bits=_BITS_TO_AN_END if end < math.inf else 1,
        bulk=lambda highest: curve.bulk(plain, coefficient, length, highest),
        straight=curve.starts_from_force,
    )
    known = curve.area_known if curve.tabulated else _keeps_area(curve.shape, plain, coefficient, length, shape, nodes.u, rtol)
    return TableCurve(definition, curve.options, shape, nodes, certificate, rtol, contact, curve.collapses, area_known=known)


def _keeps_area(law_shape, plain, coefficient, length, table, u, rtol):
    """Whether a² of a law is that of its table: R δ_H, beyond the yield of the bulk as `BulkYield` has it."""
    bulk, blunter = table.bulk, (plain.hertz_coefficient / coefficient) ** 2
    with np.errstate(all="ignore"):
        rows = [first_loading(law_shape, plain, x * length) for x in u[:: max(len(u) // 32, 1)]]
        force, area = np.array([(row[0], row[3]) for row in rows]).T
        own = np.cbrt(force / coefficient) ** 2 / length
        yielded = bulk.area + bulk.slope * (own**1.5 - bulk.area**1.5)
        return bool(
            np.all(np.abs(blunter * area / length - np.where(own > bulk.area, yielded, own)) <= (1e-4 + 10.0 * rtol) * own)
        )


def rescaled(table: TableCurve, contact: Contact, unloading: Unloading) -> TableCurve:
    """`TableCurve` of an unloading curve in the scales of `table`, as far as this one reaches in force."""
    curve, other = unloading.curve, unloading.contact
    assert other is not None  # of a curve
    _refuse_too_fine(curve.definition, table.rtol)
    index, one = _one_contact(contact)
    pair_shape = joined_shape(table.shape, contact, unloading)
    params, plain = bind_params(pair_shape, one), plain_params(pair_shape, one)
    length, coefficient = plain.loading.length, plain.hertz_coefficient
    kinks = [k / length for k in curve.kinks(plain_params(curve.shape, contact_at(other, index)))]
    exact = functools.partial(force_loop, pair_shape.unloading, params.unloading)
    rows = _interpreted(pair_shape.unloading, plain.unloading)
    source = CurveSampler(exact, rows, length, coefficient, kinks, curve.definition.solved)
    end = 0.75 * coefficient * length**1.5 * table.nodes.force[-1]

    def span(bits):
        # some cells beyond the end of the loading, so that the reverse, which ends with a whole cell, reaches it, too
        (top,) = inverse_loop(pair_shape.unloading, params.unloading, np.array([end * (1.0 + 4.0 * 0.5**bits)]))
        if not np.isfinite(top):
            raise DemlawsError(
                f"the unloading curve, a table of {curve.definition.name!r}, must reach beyond this table's {end:.4g} N: "
                "make it with a larger max_force, or this one with a smaller one"
            )
        return top / length

    shape, nodes, certificate = _smallest_table(
        source,
        one,
        (table.shape.length_over_roughness, table.shape.length_over_radius),
        rtol=table.rtol,
        name=curve.definition.name,
        span=span,
        first_bits=table.bits,
        straight=curve.starts_from_force,
        floor=table.floor,
    )
    made_for: Any = curve.made_for if curve.tabulated else unloading.contact
    return TableCurve(curve.definition, curve.options, shape, nodes, certificate, table.rtol, made_for, curve.collapses)


def tabulate_given(curve: Any, definition: Definition, contact: Contact, rtol: float) -> TableCurve:
    """The table of a curve of a user's function or points (`curves.user_curves`, `curves.points`)."""
    rtol = tolerance(rtol)
    rough = definition.length == "roughness"
    length = float(contact.sigma_or_zero if rough else contact.radius)
    coefficient = 4.0 * float(contact.modulus) * math.sqrt(contact.radius) / 3.0
    source = CurveSampler(curve.evaluate, curve.evaluate, length, coefficient, [k / length for k in curve.kinks], False, 1e-10)
    largest = curve.largest / length * (1.0 - 1e-12)
    smallest = source.lowest(rtol, largest)
    start, slope = (float(v[0]) for v in curve.evaluate(np.array([smallest * length])))
    exponent = slope * smallest * length / start
    if exponent < 1.0 - 1e-6:
        raise DemlawsError(
            f"{definition.name}: towards overlap 0 the force goes as δ^{exponent:.4g} (at overlap {smallest * length:.3g} m it "
            f"is {start:.3g} N), and the stiffness grows without bound: it must go as δ or a higher power"
        )
    shape, nodes, certificate = _smallest_table(
        source, contact, (float(rough), float(not rough)), rtol=rtol, name=definition.name, span=lambda bits: largest
    )
    return TableCurve(definition, {}, shape, nodes, certificate, rtol, contact, definition.collapses)


def tolerance(rtol: Any) -> float:
    """A relative tolerance of a table, or DemlawsError."""
    try:
        rtol = float(rtol)
    except (TypeError, ValueError):
        rtol = math.nan
    if not 1e-12 <= rtol <= 0.1:
        raise DemlawsError(f"rtol = {rtol:g}: give a relative tolerance from 1e-12 to 0.1")
    return rtol


def _refuse_too_fine(definition, rtol):
    if definition.solved and rtol < 1e-5:
        raise DemlawsError(
            f"rtol = {rtol:g}: the curve of {definition.name!r} is a numerical solution, not exact below 1e-5; use 1e-5 or more"
        )


def _one_contact(contact):
    """(index, contact) of an array of contacts for which its one table is made: the smoothest has the longest range."""
    if contact.size is None:
        return 0, contact
    index = int(np.argmin(np.broadcast_to(contact.sigma_or_zero, contact.size)))
    return index, contact_at(contact, index)
