"""Tables: a dimensionless curve on a bit-indexed semi-logarithmic grid, certified; `curves.saved` reads and writes their files.

With u = δ/length and f = P/(E* √R length^1.5) a table holds s(u) = (3f/4)^(2/3), the Hertz-equivalent overlap, as one
cubic per cell. Then f = (4/3) s^1.5, df/du = 2 √s ds/du and the plastic overlap of Hertz unloading is u - s: no power, no
cube root. Each octave of u is cut into 2^bits equal cells, whose number is in the exponent and the top mantissa bits of u.
A cell with a kink is split there, and all cells right of it move up by one.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from demlaws.contact import Contact, as_contact
from demlaws.core.curve import BulkYield, TableShape
from demlaws.core.grid import MOST_BITS, NO_YIELD, Nodes, grid, quick_to_invert, shape_from_nodes
from demlaws.core.loops import inverse_loop
from demlaws.core.params import bind_params, clamped_roughness, clamped_roughnesses, first_loading, loading_part, one_of
from demlaws.core.unloading import Rule
from demlaws.curves.points import Knots
from demlaws.errors import DemlawsError
from demlaws.laws.definition import Definition
from demlaws.unloading import Unloading, joined_shape


class Rows(NamedTuple):
    """Rows of one curve."""

    nodes: Nodes
    bits: int
    straight: bool  # below the first row; else a power law


class Certificate(NamedTuple):
    """Largest relative errors measured between the nodes against the law itself."""

    force_error: float
    stiffness_error: float


@dataclass(frozen=True, eq=False)
class TableCurve:
    """A curve of first loading that is read from certified rows."""

    definition: Definition
    options: dict
    shape: TableShape
    nodes: Nodes
    certificate: Certificate
    rtol: float
    made_for: Contact
    collapses: bool  # whether one dimensionless curve serves all contacts
    knots: Knots | None = None  # of a table made of points

    tabulated = True

    @property
    def force_error(self) -> float:
        """Largest relative error of the force."""
        return self.certificate.force_error

    @property
    def stiffness_error(self) -> float:
        """Largest relative error of the stiffness."""
        return self.certificate.stiffness_error

    @property
    def rows(self) -> Rows:
        """The content of a file's rows."""
        return Rows(self.nodes, 52 - self.shape.grid.shift, self.starts_from_force)

    @property
    def starts_from_force(self) -> bool:
        """Whether the force at overlap 0+ is not 0: the curve is straight below the first row."""
        return self.shape.grid.seat > 0.0

    def kinks(self, p: Any) -> list[float]:
        """Overlaps [m] at which the stiffness of one contact's curve jumps or has a kink."""
        return list(self.nodes.kinks * p.length)

    def end(self, params: Any) -> float | np.ndarray:
        """Overlap [m] at which the curve ends, one per contact."""
        return self.shape.grid.highest * np.asarray(params.length)

    def largest_force(self, params: Any) -> float:
        """Force [N] at the end of the curve, the smallest of all contacts'."""
        scale = 0.75 * np.min(params.hertz_coefficient * np.asarray(params.length) ** 1.5)
        return float(scale * self.nodes.force[-1])

    def bulk(self, p: Any, length: float, highest: float) -> BulkYield:
        """`BulkYield`, in units of the table's length."""
        return self.shape.bulk

    def quick_shape(self) -> Any:
        """The Shape with which this table serves as an unloading curve."""
        return quick_to_invert(self.shape, self.nodes.kinks)

    def check(self, contact: Contact) -> None:
        """Nothing to check: the law was checked in closed form."""

    check_collapse = check

    def bound_to(self, contact: Contact, surface_matters: bool = True) -> Contact:
        """The contact, with what this curve was made for, to which the same curve applies; DemlawsError where it does not."""
        as_contact(contact)
        if not self.collapses:
            raise DemlawsError(
                f"the table of {self.definition.name!r} holds for the contact it was made for only: make one for this contact"
            )
        if self.shape.length_over_roughness and np.any(np.asarray(contact.roughness) == 0.0):
            raise DemlawsError("roughness = 0 m: this table scales with roughness; use law 'hertz' for a smooth contact")
        for name in ("fractal_dimension", "hardness"):  # what the curve's form depends on
            made_for, wanted = getattr(self.made_for, name), getattr(contact, name)
            if not surface_matters:
                contact = contact.with_values(**{name: made_for})
                continue
            if made_for is None or name not in self.definition.needed(**self.options):
                continue
            if wanted is not None and not math.isclose(wanted, made_for, rel_tol=1e-6):
                raise DemlawsError(f"the table is for {name} = {made_for:g}, the contact has {wanted:g}: make one for that")
            contact = contact.with_values(**{name: made_for})
        return contact

    # --- unloading

    def with_unloading(self, contact: Contact, unloading: Unloading) -> Unloading:
        """The unloading in the form that this table is joined with: the rows of its curve, or the numbers of the law's rule."""
        if unloading.curve is not None:
            return unloading._replace(curve=self._scaled(contact, unloading), contact=contact)
        if unloading.rule.curve == "law" and unloading.beside is None:
            return unloading._replace(beside=self._beside(contact, unloading.rule))
        return unloading

    def numbers_beside(self, rule: Rule, numbers: Any) -> Any:
        """The Shape that a rule of the law's own reads beside the table."""
        return rule.shape(*map(float, numbers), self.shape.length_over_roughness, self.shape.length_over_radius)  # type: ignore[misc]

    def _beside(self, contact, rule):
        shape = self.definition.shape(contact, **self.options)
        if rule.shape is None:
            return shape  # the law itself
        length = float(np.ravel(bind_params(self.shape, contact).length)[0])
        params = one_of(bind_params(shape, contact), 0)
        return self.numbers_beside(rule, self.definition.rule_numbers(params, length, sum(self.certificate)))

    def _scaled(self, contact, unloading):
        """`TableCurve` of an unloading curve in the scales of this table, as far as this one reaches in force."""
        curve = unloading.curve
        _refuse_too_fine(curve.definition, self.rtol)
        index, one = _one_contact(contact)
        joined = joined_shape(self.shape, contact, unloading)
        params = bind_params(joined, one)
        length, coefficient = params.loading.length, params.hertz_coefficient
        own = one_of(bind_params(curve.shape, unloading.contact), index)
        kinks = [k / length for k in curve.kinks(own)]
        source = Source(_curve_of(params.unloading), length, coefficient, kinks, curve.definition.solved)
        end, top = 0.75 * coefficient * length**1.5 * self.nodes.force[-1], np.empty(1)

        def span(bits):
            # some cells beyond the end of the loading, so that the reverse, which ends with a whole cell, reaches it, too
            inverse_loop(params.unloading, np.array([end * (1.0 + 4.0 * 0.5**bits)]), top)
            if not np.isfinite(top[0]):
                raise DemlawsError(
                    f"the unloading curve, a table of {curve.definition.name!r}, must reach beyond this table's {end:.4g} N: "
                    "make it with a larger max_force, or this one with a smaller"
                )
            return top[0] / length

        shape, nodes, certificate = _smallest_table(
            source,
            one,
            (self.shape.length_over_roughness, self.shape.length_over_radius),
            self.rtol,
            curve.definition.name,
            span,
            first_bits=52 - self.shape.grid.shift,
            straight=curve.starts_from_force,
            floor=self.floor,
        )
        made_for, knots = unloading.contact, None
        if curve.tabulated:
            made_for, knots = curve.made_for, curve.knots
        return TableCurve(
            curve.definition, curve.options, shape, nodes, certificate, self.rtol, made_for, curve.collapses, knots
        )

    @property
    def floor(self) -> float | None:
        """s where the power law of this curve ends below: an unloading curve's ends there, too, and stays the stiffer one."""
        return None if self.starts_from_force else float(self.shape.grid.cells[0, 1])

    def with_errors_of(self, other: "TableCurve") -> "TableCurve":
        """This table of the table `other`, certified against the curve of that."""
        errors = zip(self.certificate, other.certificate, strict=True)
        return replace(self, certificate=Certificate(*(a + b for a, b in errors)))


# --- making tables


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
        return min(float(u[good[-1]]) if good.size else float(u[0]), largest / 64.0)

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


def _smallest_table(source, contact, lengths, rtol, name, span, first_bits=1, bulk=None, straight=False, floor=None):
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
        shape = shape_from_nodes(nodes, bits_per_octave, *lengths, yields, straight, floor)
        certificate = source.certify(shape, bind_params(shape, contact))
        if max(certificate) <= rtol:
            return shape, nodes, certificate
    raise DemlawsError(
        f"rtol = {rtol:g} is out of reach: with {2**MOST_BITS} cells an octave the table of {name!r} errs by "
        f"{max(certificate):.2g}; ask for more than that"
    )


RADII_SERVED = 10.0  # a table that collapses reaches to a tenth of so many times its contact's radius


def tabulate(contact: Contact, curve: Any, rtol: float, largest_overlap: float | np.ndarray | None = None) -> TableCurve:
    """The smallest table of a curve whose force and stiffness are within `rtol`, measured between the nodes.

    The range ends at `largest_overlap` [m], one per contact, or at a tenth of the radius (of ten times the radius where the
    curve collapses), and goes down to where the curve is a power law within `rtol`.
    """
    rtol = tolerance(rtol)
    definition = curve.definition
    _refuse_too_fine(definition, rtol)
    curve.check_collapse(contact)
    index, one = _one_contact(contact)
    lengths = (0.0, 1.0) if definition.length == "radius" or np.all(contact.is_smooth) else (1.0, 0.0)
    roughness = clamped_roughness(one.roughness, one.radius)
    length = lengths[0] * roughness + lengths[1] * one.radius
    if largest_overlap is None:
        every = np.asarray(contact.radius) if lengths[1] else clamped_roughnesses(contact)
        largest = 0.1 * np.max(np.asarray(contact.radius) / every) * (RADII_SERVED if curve.collapses else 1.0)
    else:
        largest = float(np.max(largest_overlap) / length) * (1.0 + 1e-9)
    params = loading_part(bind_params(curve.shape, one))
    kinks = [k / length for k in curve.kinks(one_of(bind_params(curve.shape, contact), index))]
    source = Source(_curve_of(params), length, params.hertz_coefficient, kinks, definition.solved)
    shape, nodes, certificate = _smallest_table(
        source,
        one,
        lengths,
        rtol,
        definition.name,
        lambda bits: largest,
        bulk=lambda highest: curve.bulk(params, length, highest),
        straight=curve.starts_from_force,
    )
    return TableCurve(definition, curve.options, shape, nodes, certificate, rtol, contact, curve.collapses)


def tabulate_given(curve: Any, definition: Definition, contact: Contact, rtol: float) -> TableCurve:
    """The table of a curve of a user's function or points (`curves.given`, `curves.points`)."""
    rtol = tolerance(rtol)
    rough = definition.length == "roughness"
    length = float(contact.roughness if rough else contact.radius)
    coefficient = 4.0 * float(contact.modulus) * math.sqrt(contact.radius) / 3.0
    source = Source(curve.evaluate, length, coefficient, [k / length for k in curve.kinks], False, 1e-10)
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
        source, contact, (float(rough), float(not rough)), rtol, definition.name, lambda bits: largest
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
            f"rtol = {rtol:g}: the curve of {definition.name!r} comes from a solver, to 1e-6 itself; ask for 1e-5 or more"
        )


def _one_contact(contact):
    """(index, contact) of an array of contacts for which its one table is made: the smoothest has the longest range."""
    if contact.size is None:
        return 0, contact
    index = int(np.argmin(np.broadcast_to(contact.roughness, contact.size)))
    names = ("radius", "modulus", "roughness")
    return index, contact.with_values(**{n: float(np.broadcast_to(getattr(contact, n), contact.size)[index]) for n in names})
