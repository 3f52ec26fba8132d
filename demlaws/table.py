"""Tables: a law's dimensionless curve on a bit-indexed semi-logarithmic grid, certified, saved as readable text.

With u = δ/length and f = P/(E* √R length^1.5) a table holds s(u) = (3f/4)^(2/3), the Hertz-equivalent overlap, as one
cubic a cell. Then f = (4/3) s^1.5, df/du = 2 √s ds/du and the plastic overlap of Hertz unloading is u - s: no power, no
cube root. Each octave of u is cut into 2^bits equal cells, whose number stands in the exponent and the top mantissa
bits of u. A cell with a kink is split there, and all cells right of it move up by one.
"""

import json
import math
import os
import zlib
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from demlaws.checks import number
from demlaws.contact import Contact
from demlaws.core.curve import SEATED
from demlaws.core.grid import MOST_BITS, Nodes, grid, node, node_number, quick_to_invert, shape_from_nodes
from demlaws.core.loops import evaluate_loop, inverse_loop
from demlaws.core.params import SMOOTHEST, bind_params, clamped_roughness, clamped_roughnesses, loading_part, one_of
from demlaws.core.unloading import GIVEN, RULES, Elastic, JoinedShape
from demlaws.errors import DemlawsError
from demlaws.files import write_atomically
from demlaws.joining import joined_law
from demlaws.law import Law
from demlaws.laws.registry import find

FORMAT = "# demlaws-table 1"
_TITLES = "overlap force stiffness"
_UNLOADING_TITLES = "unloading overlap force stiffness"


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
        u = np.append(shape.starts[:, 3] + shape.starts[:, 4] * shape.starts[:, 0], shape.highest)
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


def _length(definition, contact):
    """Dimensionless length of a law's table: multiples of σ and of R."""
    smooth = np.all(np.asarray(contact.roughness) <= SMOOTHEST * np.asarray(contact.radius))
    return (0.0, 1.0) if definition.length == "radius" or smooth else (1.0, 0.0)


def tabulate(law: Law, rtol: float = 1e-5, max_force: float | None = None) -> "Table":
    """The smallest `Table` of `law` whose force and stiffness lie within `rtol`, measured between the nodes.

    The range ends at the overlap of `max_force` [N] or at a tenth of the radius, and goes down to where the law is a
    power law within `rtol`. A law whose curve collapses gives one table for every radius, modulus and roughness.
    """
    try:
        rtol = float(rtol)
    except (TypeError, ValueError):
        rtol = math.nan
    if not 1e-12 <= rtol <= 0.1:
        raise DemlawsError(f"rtol = {rtol:g}: give a relative tolerance from 1e-12 to 0.1")
    definition, contact = law.definition, law.contact
    _refuse_too_fine(law, rtol)
    if contact.size is not None and not law.collapses:
        raise DemlawsError(
            f"law {law.name!r} has no single dimensionless curve for contacts that differ: tabulate one contact of each kind"
        )
    if law.unloading_law is not None:
        return with_curve(tabulate(law.joined("elastic"), rtol, max_force), law.unloading_law)
    largest = 0.1 * np.max(np.asarray(contact.radius) / _lengths(definition, contact))
    index, one = _pick(contact)
    over_roughness, over_radius = _length(definition, one)
    roughness = clamped_roughness(one.roughness, one.radius)
    length = over_roughness * roughness + over_radius * one.radius
    if max_force is not None:
        force = number(max_force, "max_force", "N")
        largest = float(np.max(law.overlap(np.broadcast_to(force, contact.size or ()))) / length) * (1.0 + 1e-9)
    params = loading_part(bind_params(law.shape, one))
    kinks = [k / length for k in _kinks_of_one(law, index)]
    source = Source(params, length, params.hertz_coefficient, kinks, definition.solved)
    smallest = min(source.lowest(rtol), largest / 64.0)
    bulk_yield = _bulk_yield(params, length)
    for bits_per_octave in range(1, MOST_BITS + 1):
        nodes = source.nodes(smallest, largest, bits_per_octave)
        shape = shape_from_nodes(nodes, bits_per_octave, over_roughness, over_radius, bulk_yield)
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
    plain = Table(elastic if curve is not None else joined_law(elastic, rule), shape, law.nodes, certificate, law.rtol)
    return plain if curve is None else with_curve(plain, curve)


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
    for bits_per_octave in range(52 - own.shift, MOST_BITS + 1):
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
        shape = shape_from_nodes(nodes, bits_per_octave, *lengths, floor=_floor(own))
        certificate = source.certify(shape, bind_params(shape, one))
        if max(certificate) <= table.rtol:
            law = Law(curve.definition, table.contact, "elastic", curve.options, shape)
            rows = Table(law, shape, nodes, certificate, table.rtol)
            rows.made_for = curve.made_for if isinstance(curve, Table) else curve.contact
            return _joined_table(table, rows)
    raise _out_of_reach(curve, table.rtol, certificate)


def _floor(shape):
    """s where the power law of a loading curve ends below: the unloading curve's ends there, too, and stays the stiffer one."""
    return None if shape.exponent < SEATED else float(shape.cells[0, 1])


def _joined_table(table, rows):
    """`table` with another table in its scales as its unloading curve."""
    shape = JoinedShape(loading_part(table.shape), quick_to_invert(rows.shape, rows.nodes.kinks), 1.0, 1.0, 1.0)
    law = Law(table.definition, table.contact, GIVEN, table.options, shape, None, rows)
    return Table(law, shape, table.nodes, (table.force_error, table.stiffness_error), table.rtol)


def _bulk_yield(params, length):
    """What Thornton's rule needs of a law whose bulk yields, dimensionless; see `TableShape`."""
    if not hasattr(params, "area_slope"):
        return math.inf, 0.0, 0.0
    slope = params.area_slope * params.hertz_coefficient * math.sqrt(length)
    return params.yield_overlap / length, params.yield_area / length, slope


def _lengths(definition, contact):
    if _length(definition, contact)[1]:
        return np.asarray(contact.radius)
    return clamped_roughnesses(contact)


# --- the table as a law, and its file


class Table(Law):
    """A law read from its certified table: all methods of `Law`, and `force_error`, `stiffness_error`, `save`, `load`."""

    def __init__(self, law, shape, nodes, certificate, rtol, contact=None):
        curve = law.unloading_law
        if curve is not None and contact is not None:
            curve = curve.bound_to(contact)
        super().__init__(law.definition, contact or law.contact, law.unloading, law.options, shape, None, curve)
        self.nodes = nodes
        self.force_error, self.stiffness_error = certificate
        self.rtol = rtol
        self.made_for = self.contact  # of a table that is the unloading curve of another: the contact of its law

    def __repr__(self):
        text = (
            f"demlaws.Table of {self.name!r}: {self.nodes.u.size} rows, force within {self.force_error:.1e}, "
            f"stiffness within {self.stiffness_error:.1e}"
        )
        return text if self.unloading_law is None else f"{text}; unloading along {self.unloading_law!r}"

    def quick_shape(self) -> Any:
        return quick_to_invert(self.shape, self.nodes.kinks)

    def kinks(self) -> list[float]:
        return list(self.nodes.kinks * np.ravel(self.length)[0])

    @property
    def loading_shape(self) -> Any:
        """`TableShape` of first loading."""
        return loading_part(self.shape)

    @property
    def length(self) -> float | np.ndarray:
        """Length [m] that makes overlaps dimensionless, one a contact."""
        return loading_part(self.params).length

    @property
    def largest_overlap(self) -> float:
        """End of the table [m]."""
        return self.loading_shape.highest * np.min(self.length)

    @property
    def largest_force(self) -> float:  # type: ignore[override]
        """Force [N] at the end of the table."""
        scale = 0.75 * np.min(self.params.hertz_coefficient * np.asarray(self.length) ** 1.5)
        return float(scale * self.nodes.force[-1])

    def _curve_end(self):
        return np.minimum(super()._curve_end(), self.loading_shape.highest * np.asarray(self.length))

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
        return Table(self, self.shape, self.nodes, (self.force_error, self.stiffness_error), self.rtol, contact)

    def save(self, path: str | os.PathLike) -> None:
        """Write the table as text with its certificate, its unloading curve below it; see `Table.load`."""
        from demlaws import __version__

        shape, curve = self.loading_shape, self.unloading_law
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
            **_describe_rows(self),
            "rtol": repr(self.rtol),
            "demlaws": __version__,
        }
        if math.isfinite(shape.yield_overlap):  # f at yield, and d(a²/(R length))/df after it
            header["yield_overlap"] = repr(shape.yield_overlap)
            header["yield_force"] = repr(4.0 / 3.0 * shape.yield_area**1.5)
            header["yield_area"] = repr(shape.yield_area)
            header["yield_area_slope"] = repr(0.75 * shape.yield_area_slope)
        if curve is not None:
            about = {
                "law": curve.name,
                "description": f"{curve.definition.description}; {curve.definition.equation}",
                "source": curve.definition.source,
                "options": json.dumps(curve.options, default=lambda value: value.record()),
                "contact": json.dumps(_first(curve.made_for).as_dict()),
                **_describe_rows(curve),
            }
            header |= {f"unloading_{key}": value for key, value in about.items()}
        lines = [*(f"{key}: {value}".rstrip() for key, value in header.items()), _TITLES, *_text_rows(self.nodes)]
        if curve is not None:
            lines += [_UNLOADING_TITLES, *_text_rows(curve.nodes)]
        lines.append(f"end: {self.nodes.u.size + (0 if curve is None else curve.nodes.u.size)} rows")
        text, check = FORMAT + "\n", zlib.crc32((FORMAT + "\n").encode())
        parts = [text]
        for line in lines:
            check = zlib.crc32(line.encode(), check)
            tail = f" {check:08x}\n"
            check = zlib.crc32(tail.encode(), check)
            parts.append(line + tail)
        return write_atomically(path, "".join(parts))

    @classmethod
    def load(cls, path: str | os.PathLike) -> "Table":
        """Read a table written by `save`. A truncated, edited or foreign file is refused with its line number."""
        path = Path(path)
        try:
            lines = path.read_bytes().split(b"\n")
        except OSError as error:
            raise DemlawsError(f"cannot read table {path}: {error.strerror or error}") from error

        def refuse(number, why):
            raise DemlawsError(f"{path}, line {number}: {why}")

        if lines[0].decode(errors="replace") != FORMAT:
            refuse(1, f"not a demlaws table (the first line must be {FORMAT!r})")
        check = zlib.crc32(lines[0] + b"\n")
        header, rows, curve_rows, ended, places = {}, [], [], None, {}
        reading = None
        for place, raw in enumerate(lines[1:], start=2):
            if ended is not None:
                if raw:
                    refuse(place, f"text after the last line ({ended})")
                continue
            body, separator, mark = raw.rpartition(b" ")
            check = zlib.crc32(body, check)
            if not separator or mark != b"%08x" % check:
                what = "the file ends here: it was cut short" if place >= len(lines) - 1 else "this line was changed"
                refuse(place, f"{what} (its check mark does not fit); write the table again with Table.save or demlaws table")
            check = zlib.crc32(b" " + mark + b"\n", check)
            try:
                line = body.decode()
                places[line.partition(":")[0]] = place
                if line.startswith("end: "):
                    ended = line
                    count = len(rows) + len(curve_rows)
                    if line != f"end: {count} rows" or header.get("rows") != str(len(rows)):
                        refuse(place, f"{len(rows)} rows were read, {header.get('rows')} were promised")
                    if header.get("unloading_rows", "0") != str(len(curve_rows)):
                        promised = header.get("unloading_rows", "none")
                        refuse(place, f"{len(curve_rows)} rows of unloading were read, {promised} were promised")
                elif line == _UNLOADING_TITLES and reading is rows:
                    reading = curve_rows
                elif reading is not None:
                    reading.append(_row(line, reading))
                elif line == _TITLES:
                    reading = rows
                else:
                    key, _, value = line.partition(": ")
                    header[key.rstrip(":")] = value
            except DemlawsError:
                raise
            except ValueError as error:
                refuse(place, f"not a line of a table: {error}")
        if ended is None:
            refuse(len(lines), "the file ends without its 'end:' line: it was cut short")
        if len(rows) < 2:
            refuse(places["end"], f"a table needs 2 rows or more, this one has {len(rows)}")

        def read(key, convert, suits=lambda value: True):
            if key not in header:
                refuse(places[_TITLES], f"the lines above lack {key!r}")
            try:
                value = convert(header[key])
                if suits(value):
                    return value
            except (TypeError, ValueError):
                pass
            refuse(places[key], f"{header[key]!r} will not do")

        positive = (float, lambda value: 0.0 <= value < math.inf)
        lengths = (read("length_over_roughness", *positive), read("length_over_radius", *positive))
        rtol = read("rtol", *positive)

        def table(rows, prefix, unloading, contact, bulk_yield=(math.inf, 0.0, 0.0), floor=None):
            """What the rows and the keys with this prefix make."""
            nodes = Nodes(*np.array(rows).T)
            options = read(f"{prefix}options", json.loads, lambda value: isinstance(value, dict))
            definition = read(f"{prefix}law", find)
            suits = lambda value: 1 <= value <= MOST_BITS and _fits_grid(nodes.u, value)  # noqa: E731
            shape = shape_from_nodes(nodes, read(f"{prefix}bits", int, suits), *lengths, bulk_yield, floor=floor)
            # bound to the file's curve, not to the law's own: a solved law would be solved again, a measured one is not here
            source = Law(definition, contact, unloading, options, shape)
            certificate = Certificate(read(f"{prefix}force_error", *positive), read(f"{prefix}stiffness_error", *positive))
            return cls(source, shape, nodes, certificate, rtol)

        contact = read("contact", lambda text: Contact(**json.loads(text)))
        unloading = read("unloading", str, lambda value: value in RULES)
        bulk_yield = (math.inf, 0.0, 0.0)
        if "yield_overlap" in header:
            bulk_yield = (
                read("yield_overlap", *positive),
                read("yield_area", *positive),
                read("yield_area_slope", *positive) / 0.75,
            )
        if unloading != GIVEN:
            if curve_rows:
                refuse(places["unloading"], f"unloading {unloading!r} has no rows of its own, this file has {len(curve_rows)}")
            return table(rows, "", unloading, contact, bulk_yield)
        if len(curve_rows) < 2:
            refuse(
                places["end"], f"unloading {GIVEN!r} needs 2 rows or more below {_UNLOADING_TITLES!r}, got {len(curve_rows)}"
            )
        first = table(rows, "", "elastic", contact, bulk_yield)
        curve = table(curve_rows, "unloading_", "elastic", contact, floor=_floor(first.shape))
        curve.made_for = read("unloading_contact", lambda text: Contact(**json.loads(text)))
        return _joined_table(first, curve)


def _first(contact):
    """The contact that a file names: of an array of contacts, which one curve serves, the first."""
    if contact.size is None:
        return contact
    return contact.with_values(**{n: float(np.ravel(getattr(contact, n))[0]) for n in ("radius", "modulus", "roughness")})


def _describe_rows(table):
    """What the header says of a table's rows."""
    u, force, _ = table.nodes
    return {
        "bits": str(52 - table.loading_shape.shift),
        "kinks": " ".join(repr(float(k)) for k in table.nodes.kinks),
        "range_overlap": f"{u[0]!r} {u[-1]!r}",
        "range_force": f"{float(force[0])!r} {float(force[-1])!r}",
        "force_error": repr(table.force_error),
        "stiffness_error": repr(table.stiffness_error),
        "rows": str(u.size),
    }


def _text_rows(nodes):
    return [f"{u:.17g} {f:.17g} {k:.17g}" for u, f, k in zip(*nodes, strict=True)]


def _row(line, rows):
    """u, f, k of a line; ValueError where it cannot follow the rows before it."""
    row = [float(v) for v in line.split()]
    if len(row) != 3 or not all(0.0 < v < math.inf for v in row):
        raise ValueError(f"{line!r} is not three positive numbers")
    if rows and (row[0] < rows[-1][0] or row[1] < rows[-1][1]):
        raise ValueError(f"{line!r} does not increase")
    return row


def _fits_grid(u, bits_per_octave):
    """Whether every grid cell between the first and the last node has its node, and at most two kinks stand twice."""
    first, last = node_number(u[0], bits_per_octave), node_number(u[-1], bits_per_octave)
    grid_nodes = node(np.arange(first, last + 1), bits_per_octave) if last - first <= u.size else np.empty(0)
    kinks = u[:-1][np.diff(u) == 0.0]
    return grid_nodes.size > 1 and kinks.size <= 2 and np.array_equal(np.union1d(grid_nodes, kinks), np.unique(u))
