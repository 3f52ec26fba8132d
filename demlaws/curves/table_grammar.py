"""The text of a table file: keys, rows, checksum. docs/inside/table-format.md is its grammar, `table_file` interprets it.

`demlaws/cpp/demlaws_reader.h` reads the same files in the same steps, by the same keys (`make facts`); tests/cpp compares the
two by verdict and line.
"""

import functools
import inspect
import json
import math
import re
import zlib
from typing import NamedTuple

import numpy as np

from demlaws.contact import LOWEST_HARDNESS, Contact
from demlaws.core.grid import MOST_BITS, MOST_KINKS, Nodes, node, node_number
from demlaws.core.unloading import GIVEN, RULES
from demlaws.errors import DemlawsError
from demlaws.laws import POHRT_POPOV
from demlaws.laws.definition import Numbers
from demlaws.laws.registry import registry
from demlaws.units import LARGEST_ROUGHNESS, RANGES

FORMAT = "# demlaws-table 4"
"""The first line. A change of meaning gets a new number."""
MOST_ROWS = 2_000_000
LARGEST_OVERLAP, LARGEST_FORCE = 1e20, 1e60
"""Of rows, dimensionless; the smallest are the reciprocals, and a stiffness is like a force."""
STEEPEST, JUMP, ROUNDING = 10.0, 2.0, 1e-9
"""Of rows: d ln f/d ln u, also between two rows, where f may jump by this factor besides; share of s that is rounding."""
_NUMBER = re.compile(r"[+-]?[0-9]+(\.[0-9]*)?([eE][+-]?[0-9]+)?")


def plain_number(text):
    """A finite number in decimal digits, NaN for all else, also for what float() would take."""
    value = float(text) if _NUMBER.fullmatch(text) else math.nan
    return value if value - value == 0.0 else math.nan


# --- keys

TEXT, TRIPLES = (), ("#",)
"""Values of a key: any text, numbers three by three. Others: `Numbers`, or the words that it can be."""


class Key(NamedTuple):
    """A key of table files."""

    name: str
    values: Numbers | tuple
    need: str = "always"  # "always", "" (optional), or a rule or another key of the file: with this one, and only with it
    both: bool = False  # of an unloading curve, too

    def read(self, text):
        """The value that a text means; ValueError with the admissible ones."""
        if isinstance(self.values, Numbers):
            value, (low, high, included) = plain_number(text), self.values
            if not ((value >= low if included else value > low) and value <= high):
                raise ValueError(f"{text:.60} is not a number {'from' if included else 'above'} {low:g} up to {high:g}")
            return value
        if self.values == TRIPLES:
            value = [plain_number(word) for word in text.split(" ")]
            if len(value) % 3 or any(map(math.isnan, value)):
                raise ValueError("these are not numbers, three by three, with a blank between")
            return value
        if text not in self.values if self.values else not text:
            raise ValueError(f"{text[:60]!r} is not one of {', '.join(self.values)}" if self.values else "a text is missing")
        return text


def rules():
    """Name → the rules that a file may name: the general ones, and those of single laws that readers in C++ have, too."""
    special = (rule for definition in registry().values() for rule in definition.rules.own if rule.number is not None)
    return RULES | {rule.name: rule for rule in special}


_LENGTH, _SCALE, _NOT_NEGATIVE = Numbers(1e-30, 1e30, True), Numbers(1e-60, 1e60, True), Numbers(0.0, 1e60, True)
_ERROR = Numbers(0.0, 0.1, True)
OF_CONTACT = {
    "radius": Key("radius", _LENGTH, both=True),
    "modulus": Key("modulus", Numbers(RANGES["modulus"].low, 1e30), both=True),
    "sigma": Key("sigma", Numbers(0.0, 1e30, True), "", both=True),
    "fractal_dimension": Key("fractal_dimension", Numbers(*RANGES["fractal_dimension"][1:3], True), "", both=True),
    "hardness": Key("hardness", Numbers(0.0, 1e30), "", both=True),
}
"""Field of a `Contact` → its key."""


@functools.cache
def keys():
    """Keys that do not depend on the law, but options and limits."""
    of_rules = [  # the second number of a rule is a growth, which may be 0
        Key(name, _NOT_NEGATIVE if number == 1 else _SCALE, rule.name)
        for rule in rules().values()
        for number, name in enumerate(rule.keys)
    ]
    return (
        Key("law", TEXT, both=True),
        Key("description", TEXT, "", both=True),
        *OF_CONTACT.values(),
        Key("length", ("sigma", "radius")),
        Key("collapses", ("yes", "no")),
        Key("unloading", tuple(rules())),
        Key("below", ("power", "straight"), both=True),
        Key("bits", tuple(str(n) for n in range(1, MOST_BITS + 1)), both=True),
        Key("force_error", _ERROR, both=True),
        Key("stiffness_error", _ERROR, both=True),
        Key("rtol", _ERROR),
        Key("yield_area", _SCALE, ""),
        Key("yield_slope", _SCALE, "yield_area"),
        Key("area", ("known",), ""),
        Key("points", Numbers(1.0, 1e9, True), ""),
        Key("departure", Numbers(0.0, 1e60, True), "points"),
        Key("smoothing", TEXT, "points"),
        Key("knots", TRIPLES, "points"),
        *of_rules,
    )


@functools.cache
def law_keys():
    """Law of demlaws → its options, and the keys of the contact that it needs."""
    found = {}
    for name, definition in registry().items():
        if (definition.prepare.__module__ or "").startswith("demlaws.laws."):
            options = list(inspect.signature(definition.prepare).parameters.values())[1:]
            needed = [one.name for one in options if one.default is one.empty and one.kind is not one.VAR_KEYWORD]
            found[name] = [
                Key(
                    f"option_{option}",
                    record.values if isinstance(record.values, Numbers) else Numbers(-1e60) if record.unit else TEXT,
                    "always" if option in needed else "",
                    both=True,
                )
                for option, record in definition.options.items()
            ] + [OF_CONTACT[field]._replace(need="always") for field in definition.loading.needs]
    return found


INNER = ("option_loading", POHRT_POPOV)
"""Key and default of the law that another one holds before the bulk yields."""


def keys_of_law(law, header):
    """Its `law_keys`, with those of the law before yield; None: not of demlaws, so that any option may be there."""
    laws = [law]
    if any(key.name == INNER[0] for key in law_keys().get(law, ())):
        laws.append(header.get(*INNER))
    return None if any(one not in law_keys() for one in laws) else [key for one in laws for key in law_keys()[one]]


# --- reading


def parse(data, name):
    """(`Section`s of loading and perhaps unloading, checksum) of a file's bytes; DemlawsError that names file and line."""
    lines = data.replace(b"\r\n", b"\n").removesuffix(b"\n").split(b"\n")
    sections = [Section(name)]
    fail = sections[0].fail
    if lines[0] != FORMAT.encode():
        ours = lines[0].startswith(FORMAT.encode()[:-1])
        again = "a table of another format: make it again with 'demlaws table --law NAME ... --out FILE'"
        fail(1, again if ours else f"not a demlaws table (the first line must be {FORMAT!r})")
    checksum = zlib.crc32(b"\n".join(lines[:-1]) + b"\n")
    if not re.fullmatch(b"crc: [0-9a-f]{8}", lines[-1]):
        fail(len(lines), "the last line is not the checksum, 'crc: ...': the file was cut short")
    if lines[-1] != b"crc: %08x" % checksum:
        fail(len(lines), "the checksum does not match: the text above was changed; make the table again")
    for line, raw in enumerate(lines[1:-1], start=2):
        body = raw.decode(errors="backslashreplace")
        if ": " not in body:
            sections[-1].read_row(line, body)
            continue
        if sections[-1].rows and len(sections) < 2:
            sections.append(Section(name, sections[0]))
        sections[-1].read_key(line, body)
    given = sections[0].values.get("unloading") == GIVEN
    for section in sections if (len(sections) == 2) == given else [Section(name)]:
        section.finish(len(lines))
    return sections, checksum


class Section:
    """Keys and rows of one curve; `Table::Section` in demlaws_reader.h has the same steps."""

    def __init__(self, name, loading=None):
        self.name, self.loading = name, loading  # loading: the section before this one, which is an unloading curve's
        self.header, self.lines, self.values, self.options = {}, {}, {}, {}  # key → text, line, value; option → value
        self.limits, self.rows, self.first_row = [], [], 0

    def fail(self, line, why):
        """Raise the error of a line."""
        raise DemlawsError(f"{self.name}, line {line}: {why}")

    def read_key(self, line, body):
        """A key and its text."""
        key, _, value = body.partition(": ")
        if self.rows:
            self.fail(line, f"{key[:60]!r} follows the rows of the last curve")
        if key in self.header:
            self.fail(line, f"key {key[:60]!r} occurs twice")
        self.header[key], self.lines[key] = value, line

    def check_header(self, line):
        """Values of the keys, all of which this curve needs or takes. line: that of the first row."""
        header, of_law, wanted = self.header, keys_of_law(self.header.get("law"), self.header), {}
        for key in (*keys(), *(of_law or ())):
            if self.loading is not None and not key.both:
                continue
            if key.need in ("", "always", header.get("unloading")) or key.need in header:
                wanted[key.name] = key
        for name, text in header.items():
            if self.loading is None and name == f"limit_{len(self.limits) + 1}":
                self.limits.append(self.read_limit(name, text))
                continue
            key = wanted.get(name) or (Key(name, TEXT) if of_law is None and name.startswith("option_") else None)
            if key is None:
                self.fail(self.lines[name], f"{name[:60]!r} is not a key of this law and rule of unloading")
            try:
                self.values[name] = key.read(text)
            except ValueError as error:
                self.fail(self.lines[name], f"{name}: {error}")
        missing = next((key.name for key in wanted.values() if key.need and key.name not in header), None)
        if missing is not None:
            self.fail(line, f"the lines above lack {missing!r}")
        self.check_contact(line)

    def check_contact(self, line):
        """Quantities of the contact against one another, and the length that overlaps are divided by."""
        values = self.values
        sigma, of_loading = values.get("sigma"), (self.loading or self).values
        if of_loading["length"] == "sigma" and not (sigma or 0.0) >= _LENGTH.low:
            self.fail(self.lines.get("sigma", line), f"overlaps over sigma need a sigma from {_LENGTH.low:g} m on")
        if sigma is not None and sigma > LARGEST_ROUGHNESS * values["radius"]:
            self.fail(self.lines["sigma"], f"sigma is above {LARGEST_ROUGHNESS:g} of the radius")
        if values.get("hardness", math.inf) < LOWEST_HARDNESS * values["modulus"]:
            self.fail(self.lines["hardness"], f"hardness is below {LOWEST_HARDNESS:g} of the modulus: both are in Pa")

    def read_limit(self, name, text):
        """(kind, value, reason) of a limit of force, or of the central pressure."""
        kind, _, rest = text.partition(" ")
        value, _, reason = rest.partition(" ")
        if kind not in ("above", "below", "pressure") or not reason or not plain_number(value) > 0.0:
            self.fail(self.lines[name], f"{name}: {text[:60]!r} is not above, below or pressure, a positive number, a reason")
        return kind, float(value), reason

    def read_row(self, line, body):
        """u, f, k of a line, which must continue the rows before it."""
        if not self.rows:
            self.check_header(line)
            self.first_row = line
        row = [plain_number(word) for word in body.split(" ")]
        if len(row) != 3 or any(math.isnan(value) for value in row):
            self.fail(line, f"{body[:60]!r} is neither 'key: value' nor three numbers with a blank between")
        for value, largest in zip(row, (LARGEST_OVERLAP, LARGEST_FORCE, LARGEST_FORCE), strict=True):
            if not 1.0 / largest <= value <= largest:
                self.fail(line, f"{value!r} is not between {1.0 / largest:g} and {largest:g}")
        if row[0] * row[2] > STEEPEST * row[1]:
            self.fail(line, f"the stiffness is that of a force that grows faster than overlap^{STEEPEST:g}")
        if self.rows:
            self.check_step(line, self.rows[-1], row)
        self.rows.append(row)

    def check_step(self, line, before, row):
        """A row against the one before: order, growth, and that the cubic between them does not fall."""
        (u0, f0, k0), (u1, f1, k1) = before, row
        if not (u1 > u0 and f1 > f0) and not (u1 == u0 and f1 >= f0):
            self.fail(line, "overlap and force must increase from row to row")
        if math.log(f1 / f0) > math.log(JUMP) + STEEPEST * math.log(u1 / u0):
            self.fail(line, f"the force grows faster than overlap^{STEEPEST:g} from the row before")
        roots = np.cbrt(0.75 * f0), np.cbrt(0.75 * f1)  # √s
        rise = 3.0 * (roots[1] ** 2 - roots[0] ** 2) + ROUNDING * roots[1] ** 2
        if max(k0 / roots[0], k1 / roots[1]) * (u1 - u0) > 2.0 * rise:
            self.fail(line, "a stiffness here or before is above three times the slope between them: the curve falls")

    def finish(self, end):
        """Whether the rows are a curve. end: the file's last line."""
        if len(self.rows) < 2:
            self.fail(end, "two or more rows of a curve are missing; 'unloading: table', and only it, has a second curve")
        if len(self.rows) > MOST_ROWS:
            self.fail(end, f"more than {MOST_ROWS} rows")
        wrong = off_grid(np.array(self.rows)[:, 0], int(self.values["bits"]))
        if wrong is not None:
            self.fail(self.first_row + wrong[0], wrong[1])
        (u, f, k), straight = self.rows[0], self.values["below"] == "straight"
        if straight and u * k > 1.5 * (1.0 + 1e-9) * f:
            self.fail(self.lines["below"], "straight below the first row, this curve would have a force below 0 at overlap 0")

    @property
    def nodes(self):
        """`Nodes` of the curve."""
        return Nodes(*np.array(self.rows).T)

    @property
    def contact(self):
        """The `Contact` that the curve was made for."""
        return Contact(**{field: self.values.get(key.name) for field, key in OF_CONTACT.items()})


def off_grid(u, bits_per_octave):
    """(number of the first row that the grid does not allow, why), or None."""
    number, kinks, last = node_number(u[0], bits_per_octave), 0, u.size - 1
    for i in range(u.size):
        grid_node, ends = float(node(number, bits_per_octave)), i in (0, last)
        if i > 0 and u[i] == u[i - 1]:
            kinks += 1
            if ends or i == 1 or u[i] == u[i - 2]:
                return i, "a kink, an overlap in two rows, lies between other rows"
            if kinks > MOST_KINKS:
                return i, f"more than {MOST_KINKS} kinks"
        elif u[i] == grid_node:
            number += 1
        elif u[i] > grid_node or ends or u[i + 1] != u[i]:
            return i, "a row is missing before this one, or its overlap is not on the grid of 'bits'"
    return None


# --- writing


def compose(sections):
    """(bytes of the file, checksum) of curves: (key → value, `Nodes`) of loading, and perhaps of unloading."""
    lines = [FORMAT]
    for header, nodes in sections:
        lines += [f"{key}: {_text(value)}" for key, value in header.items()]
        lines += [" ".join(map(repr, row)) for row in np.column_stack(nodes).tolist()]
    text = "".join(f"{line}\n" for line in lines).encode()
    checksum = zlib.crc32(text)
    return text + b"crc: %08x\n" % checksum, checksum


def _text(value):
    """The text of a value, in one line."""
    if isinstance(value, str):
        return " ".join(value.split())
    if isinstance(value, list):
        return " ".join(map(_text, value))
    if isinstance(value, float):
        return repr(float(value))
    return json.dumps(value, default=lambda record: record.record())
