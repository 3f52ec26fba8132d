"""Tables: a law's dimensionless curve on a bit-indexed semi-logarithmic grid, certified; `table_file` has their text.

With u = δ/length and f = P/(E* √R length^1.5) a table holds s(u) = (3f/4)^(2/3), the Hertz-equivalent overlap, as one
cubic a cell. Then f = (4/3) s^1.5, df/du = 2 √s ds/du and the plastic overlap of Hertz unloading is u - s: no power, no
cube root. Each octave of u is cut into 2^bits equal cells, whose number stands in the exponent and the top mantissa
bits of u. A cell with a kink is split there, and all cells right of it move up by one.
"""

import json
import math
import os
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from demlaws import table_file
from demlaws.checks import number
from demlaws.contact import Contact
from demlaws.core.curve import BulkYield
from demlaws.core.grid import MOST_BITS, NO_YIELD, Nodes, grid, quick_to_invert, shape_from_nodes
from demlaws.core.loops import evaluate_loop, inverse_loop
from demlaws.core.params import SMOOTHEST, bind_params, clamped_roughness, clamped_roughnesses, loading_part, one_of
from demlaws.core.unloading import GIVEN, Elastic, JoinedShape
from demlaws.errors import DemlawsError
from demlaws.files import as_path, write_atomically
from demlaws.joining import joined_law
from demlaws.law import Law
from demlaws.laws.definition import Definition
from demlaws.laws.registry import find, is_own
from demlaws.soundness import refuse_unless_collapses
from demlaws.table_file import UNLOADING, Rows


class Source(NamedTuple):
    """A curve to tabulate: Params of one contact, and the scales of the table."""

    params: tuple
    length: float  # [m]
    hertz_coefficient: float  # [N/m^1.5]
    kinks: list  # u
    solved: bool

    def curve(self, u):
        """s(u) and ds/du."""
        force, stiffness = np.empty(u.size), np.empty(u.size)
        evaluate_loop(Elastic(), self.params, u * self.length, (), force, stiffness)
        equivalent = np.cbrt(force / self.hertz_coefficient) ** 2
        return equivalent / self.length, stiffness / (1.5 * self.hertz_coefficient * np.sqrt(equivalent))

    def nodes(self, lowest, highest, bits_per_octave):
        """Rows of the table from `lowest` to `highest` u."""
        u, kinks = grid(lowest, highest, self.kinks, bits_per_octave)
        place = u.copy()
        for kink in kinks:  # one-sided stiffness: just left and just right of the kink
            first, second = np.flatnonzero(u == kink)
            place[first] = kink * (1.0 - 1e-14)
            place[second] = kink * (1.0 + 1e-14)
        s, slope = self.curve(place)
        for kink in kinks:
            second = np.flatnonzero(u == kink)[1]
            if abs(s[second] / s[second - 1] - 1.0) < 1e-10:  # no jump of force: one value for both sides
                s[second] = s[second - 1]
        return Nodes.from_curve(u, s, slope)

    def lowest(self, rtol):
        """Largest u, but at least 2^-30, below which the curve is its own power law within a small part of rtol."""
        u = 2.0 ** np.arange(-30.0, 1.0)
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
        force, stiffness, exact_force, exact_stiffness = (np.empty(points.size) for _ in range(4))
        evaluate_loop(Elastic(), table, points, (), force, stiffness)
        evaluate_loop(Elastic(), self.params, points, (), exact_force, exact_stiffness)
        with np.errstate(divide="ignore", invalid="ignore"):
            errors = np.abs(force / exact_force - 1.0), np.abs(stiffness / exact_stiffness - 1.0)
        return Certificate(float(np.max(errors[0])), float(np.max(errors[1])))


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
    try:
        rtol = float(rtol)
    except (TypeError, ValueError):
        rtol = math.nan
    if not 1e-12 <= rtol <= 0.1:
        raise DemlawsError(f"rtol = {rtol:g}: give a relative tolerance from 1e-12 to 0.1")
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
    source = Source(params, length, params.hertz_coefficient, kinks, definition.solved)
    smallest = min(source.lowest(rtol), largest / 64.0)
    straight = _starts_from_force(law)
    for bits_per_octave in range(1, MOST_BITS + 1):
        nodes = source.nodes(smallest, largest, bits_per_octave)
        bulk = _bulk_yield(law, params, length, nodes.u[-1])
        shape = shape_from_nodes(nodes, bits_per_octave, over_roughness, over_radius, bulk, straight)
        certificate = source.certify(shape, bind_params(shape, one))
        if max(certificate) <= rtol:
            return Table(law, shape, nodes, certificate, rtol)
    raise _out_of_reach(law, rtol, certificate)


def _out_of_reach(law, rtol, certificate):
    return DemlawsError(
        f"rtol = {rtol:g} is out of reach: with {2**MOST_BITS} cells an octave the table of {law.name!r} errs by "
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
            numbers = definition.rule_numbers(params, float(np.ravel(table.length)[0]))
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
    source = Source(params.unloading, length, coefficient, kinks, curve.definition.solved)
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
        nodes = source.nodes(min(source.lowest(table.rtol), largest / 64.0), largest, bits_per_octave)
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
    raise _out_of_reach(curve, table.rtol, certificate)


def _floor(shape):
    """s where the power law of a loading curve ends below: the unloading curve's ends there, too, and stays the stiffer one."""
    return None if shape.grid.seat > 0.0 else float(shape.grid.cells[0, 1])


def _joined_table(table, rows):
    """`table` with another table in its scales as its unloading curve."""
    shape = JoinedShape(loading_part(table.shape), quick_to_invert(rows.shape, rows.nodes.kinks), 1.0, 1.0, 1.0)
    law = Law(table.definition, table.contact, GIVEN, table.options, shape, None, rows)
    return Table(law, shape, table.nodes, (table.force_error, table.stiffness_error), table.rtol)


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
    return BulkYield(area / length, slope * params.hertz_coefficient * math.sqrt(length))


def _lengths(definition, contact):
    if _length(definition, contact)[1]:
        return np.asarray(contact.radius)
    return clamped_roughnesses(contact)


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
            curve = curve.bound_to(contact)
        super().__init__(law.definition, contact or law.contact, law.unloading, law.options, shape, None, curve)
        self.nodes = nodes
        self.force_error, self.stiffness_error = certificate
        self.rtol = rtol
        self.said_to_collapse = None  # what a file says, where the table comes from one
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
        if not self.collapses:
            raise DemlawsError(
                f"the table of {self.name!r} holds for the contact it was made for only: make one for this contact"
            )
        if self.loading_shape.length_over_roughness and np.any(np.asarray(contact.roughness) == 0.0):
            raise DemlawsError("roughness = 0 m: this table scales with roughness; use law 'hertz' for a smooth contact")
        bound = Table(self, self.shape, self.nodes, (self.force_error, self.stiffness_error), self.rtol, contact)
        bound.said_to_collapse = self.said_to_collapse
        return bound

    def save(self, path: str | os.PathLike) -> Path:
        """Write the table as text with its certificate, its unloading curve below it; see `Table.load`."""
        return write_atomically(path, self._compose()[0])

    @property
    def fingerprint(self) -> int:
        """Check value (CRC-32) of the file that `save` writes: tables with one fingerprint are one table."""
        return self._compose()[1]

    def _compose(self):
        from demlaws import __version__

        shape, curve = self.loading_shape, self.unloading_law
        rule = self.definition.rule(self.unloading)
        if rule.number is None:
            raise DemlawsError(
                f"rule {rule.name!r} of law {self.name!r} is its own and stands in no table file, since what reads such files "
                "does not have it: use the law itself (Python, YADE), or unload along a curve, unloading=dl.law(...)"
            )
        header = {
            "law": self.name,
            "description": f"{self.definition.description}; {self.definition.equation}",
            "source": self.definition.source,
            "unloading": self.unloading,
            "options": json.dumps(self.options, default=lambda value: value.record()),
            "contact": json.dumps(_first(self.contact).as_dict()),
            "collapses": "yes" if self.collapses else "no",
            "scales": "overlap/length, force/(E* sqrt(R) length^1.5), stiffness/(E* sqrt(R length)), R and E* effective",
            "length": repr(float(np.ravel(self.length)[0])),
            "length_over_roughness": repr(shape.length_over_roughness),
            "length_over_radius": repr(shape.length_over_radius),
            **table_file.describe_rows(self.rows, (self.force_error, self.stiffness_error)),
            "rtol": repr(self.rtol),
            "demlaws": __version__,
        }
        if math.isfinite(shape.bulk.area):
            u, s, _ = self.nodes.curve()
            header["yield_overlap"] = repr(float(u[np.argmin(np.abs(s - shape.bulk.area))]))  # a kink of these laws: a row
            header["yield_force"] = repr(4.0 / 3.0 * shape.bulk.area**1.5)
            header["yield_area"] = repr(shape.bulk.area)
            header["yield_area_slope"] = repr(0.75 * shape.bulk.slope)  # by f, not by s^1.5
        if rule.keys:
            header |= {key: repr(value) for key, value in zip(rule.keys, self.shape.unloading, strict=False)}
        if curve is not None:
            about = {
                "law": curve.name,
                "description": f"{curve.definition.description}; {curve.definition.equation}",
                "source": curve.definition.source,
                "options": json.dumps(curve.options, default=lambda value: value.record()),
                "contact": json.dumps(_first(curve.made_for).as_dict()),
                **table_file.describe_rows(curve.rows, (curve.force_error, curve.stiffness_error)),
            }
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
            return cls(source, shape, rows.nodes, certificate, values["rtol"])

        bulk = NO_YIELD
        if values.get("yield_area", math.inf) < file.loading.nodes.curve()[1][-1]:
            bulk = BulkYield(values["yield_area"], values["yield_area_slope"] / 0.75)
        rule = table_file.rules()[values["unloading"]]
        if rule.curve == "law":
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


def _definition(file, prefix):
    """`Definition` of a file's law, or what the file itself says of a law that is not here."""
    name, header = file.values[f"{prefix}law"], file.header
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


def _not_here(contact, **options):
    raise DemlawsError("this law is known from a table only: it cannot be made for another contact")


def _no_limits(contact, **options):
    return []


def _first(contact):
    """The contact that a file names: of an array of contacts, which one curve serves, the first."""
    if contact.size is None:
        return contact
    return contact.with_values(**{n: float(np.ravel(getattr(contact, n))[0]) for n in ("radius", "modulus", "roughness")})
