"""The text of a table file: header, rows, check marks. docs/table-format.md is its grammar, `saved` interprets it.

`demlaws/cpp/demlaws_reader.h` reads the same files in the same steps; tests/cpp compares the two by verdict and line,
and writes the keys for C++ from those here.
"""

import itertools
import json
import math
import re
import zlib
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from demlaws.contact import Contact
from demlaws.core.grid import MOST_BITS, MOST_KINKS, Nodes, node, node_number
from demlaws.core.unloading import GIVEN, RULES
from demlaws.curves.table import Rows
from demlaws.errors import DemlawsError
from demlaws.laws.registry import registry

FORMAT = "# demlaws-table 3"
"""The first line. A change of meaning gets a new number."""
TITLES = "overlap force stiffness"
UNLOADING_TITLES = "unloading overlap force stiffness"
UNLOADING = "unloading_"
"""Before the keys that describe an unloading curve and its rows."""
BELOW = "below_first_row"
MOST_ROWS = 2_000_000
LARGEST_OVERLAP, LARGEST_FORCE = 1e60, 1e200
"""Of rows, dimensionless; the smallest are the reciprocals, and a stiffness is like a force."""
_NUMBER = re.compile(r"[+-]?[0-9]+(\.[0-9]*)?([eE][+-]?[0-9]+)?")
_DEEPEST = 64


# --- values


def _number(text):
    """A finite number in decimal digits; ValueError for all else, also for what float() would take."""
    value = float(text) if _NUMBER.fullmatch(text) else math.nan
    if value - value != 0.0:
        raise ValueError(f"{text!r} is not a finite number")
    return value


def _positive(text):
    value = _number(text)
    if not value > 0.0:
        raise ValueError(f"{text} is not positive")
    return value


def _not_negative(text):
    value = _number(text)
    if not value >= 0.0:
        raise ValueError(f"{text} is negative")
    return value


def _whole(low, high):
    def read(text):
        if not re.fullmatch("[1-9][0-9]{0,8}", text) or not low <= int(text) <= high:
            raise ValueError(f"{text!r} is not a whole number from {low} to {high}")
        return int(text)

    return read


def _one_of(*words):
    def read(text):
        if text not in words:
            raise ValueError(f"{text!r} is none of {', '.join(words)}")
        return text

    return read


def rules():
    """Name → the rules that a file may name: the general ones, and those of single laws that readers in C++ have, too."""
    special = (rule for definition in registry().values() for rule in definition.rules.own if rule.number is not None)
    return RULES | {rule.name: rule for rule in special}


def rule_named(name):
    """The rule of this name, or None; laws are loaded only for other rules than the general ones."""
    return RULES.get(name) or rules().get(name)


def _rule(text):
    return text if text in RULES else _one_of(*rules())(text)


def _limit(text):
    """A limit of force, or of the central pressure, with its reason."""
    kind, _, rest = text.partition(" ")
    value, _, reason = rest.partition(" ")
    if kind not in ("above", "below", "pressure") or not reason or not _positive(value):
        raise ValueError(f"{text!r} is not above, below or pressure, a positive number, a reason")
    return kind, float(value), reason


def _name(text):
    if not text:
        raise ValueError("a name is missing")
    return text


def _depth(value):
    inside = value.values() if isinstance(value, dict) else value if isinstance(value, list) else None
    return 0 if inside is None else 1 + max(map(_depth, inside), default=0)


def _object(text):
    """A JSON object, as a dict."""

    def no_number(word):
        raise ValueError(f"{word} is not JSON")

    try:
        value = json.loads(text, parse_constant=no_number)
        if isinstance(value, dict) and _depth(value) <= _DEEPEST:
            return value
    except (ValueError, RecursionError):
        pass
    raise ValueError("this is not a JSON object")


# --- keys


class Key(NamedTuple):
    """A key that readers need, and what its text means."""

    name: str
    read: Callable


bits, rows_of_file = _whole(1, MOST_BITS), _whole(2, MOST_ROWS)
power_or_straight, yes_or_no = _one_of("power", "straight"), _one_of("yes", "no")
CURVE = (
    Key("law", _name),
    Key("options", _object),
    Key("effective_radius", _positive),
    Key("effective_modulus", _positive),
    Key("bits", bits),
    Key("rows", rows_of_file),
    Key("force_error", _not_negative),
    Key("stiffness_error", _not_negative),
    Key(BELOW, power_or_straight),
)
_OF_CONTACT = {"effective_radius": "radius", "effective_modulus": "modulus"}
_PERHAPS_OF_CONTACT = (Key("roughness", _not_negative), Key("fractal_dimension", _positive), Key("hardness", _positive))
SHARED = (
    Key("unloading", _rule),
    Key("collapses", yes_or_no),
    Key("length", _positive),
    Key("length_over_roughness", _not_negative),
    Key("length_over_radius", _not_negative),
    Key("rtol", _not_negative),
)
YIELD = (
    Key("yield_overlap", _positive),
    Key("yield_force", _positive),
    Key("yield_area", _positive),
    Key("yield_area_slope", _positive),
)


class TableFile(NamedTuple):
    """A file that is a table: values of its keys, and its rows."""

    header: dict  # key → text, all keys
    values: dict  # key → value, the keys that readers need
    loading: Rows
    unloading: Rows | None
    fingerprint: int  # CRC-32 of the text up to the last check mark


# --- reading


def parse(data, name):
    """`TableFile` of the bytes of a file, which messages call `name`; DemlawsError with the line of what is wrong."""
    reader = Reader(name)
    reader.read_lines(data)
    reader.check_keys()
    reader.check_scales()
    loading = reader.build("")
    unloading = reader.build(UNLOADING) if UNLOADING in reader.rows else None
    return TableFile(reader.header, reader.values, loading, unloading, reader.fingerprint)


class Reader:
    """The steps of reading a file; `Table` in demlaws_reader.h has the same."""

    def __init__(self, name):
        self.name, self.fingerprint = name, 0
        self.header, self.lines, self.values = {}, {}, {}  # key → text, its line, value
        self.rows, self.first_line = {}, {}  # prefix of a curve's keys → rows, line of the first
        self.titles = self.end = 0  # lines

    def fail(self, line, why):
        """Raise the error of a line."""
        raise DemlawsError(f"{self.name}, line {line}: {why}")

    def read_lines(self, data):
        """Header and rows of a file whose check marks fit."""
        lines = data.replace(b"\r\n", b"\n").split(b"\n")
        whole = len(lines) > 1 and not lines[-1]  # the last line has its end
        if whole:
            lines.pop()
        if lines[0] != FORMAT.encode():
            what = "a table of another format: write it again with this version of demlaws"
            ours = lines[0].startswith(FORMAT.encode()[:-1])
            self.fail(1, what if ours else f"not a demlaws table (the first line must be {FORMAT!r})")
        check = zlib.crc32(lines[0] + b"\n")
        for line, raw in enumerate(lines[1:], start=2):
            if self.end:
                self.fail(line, "text after the last line ('end: ...')")
            body, separator, mark = raw.rpartition(b" ")
            check = zlib.crc32(body, check)
            if not separator or mark != b"%08x" % check:
                what = "the file ends here: it was cut short" if line == len(lines) else "this line was changed"
                self.fail(line, f"{what} (its check mark does not fit); write the table again with Table.save or demlaws table")
            self.fingerprint, check = check, zlib.crc32(b" " + mark + b"\n", check)
            self.read_line(line, body.decode(errors="replace"))
        if not self.end:
            self.fail(len(lines) + whole, "the file ends without its 'end:' line: it was cut short")

    def read_line(self, line, body):
        """A line without its mark: end, titles, row or key."""
        if body.startswith("end: "):
            count = sum(map(len, self.rows.values()))
            if body != f"end: {count} rows":
                self.fail(line, f"{count} rows were read, {body.removeprefix('end: ')!r} were promised")
            self.end = line
        elif body == TITLES and not self.rows:
            self.titles = line
            self.rows[""], self.first_line[""] = [], line + 1
        elif body == UNLOADING_TITLES and list(self.rows) == [""]:
            self.rows[UNLOADING], self.first_line[UNLOADING] = [], line + 1
        elif self.rows:
            self.read_row(line, body, list(self.rows.values())[-1])
        else:
            self.read_key(line, body)

    def read_row(self, line, body, rows):
        """u, f, k of a line, which must follow the rows before it."""
        tokens = body.split(" ")
        if len(tokens) != 3:
            self.fail(line, f"{body!r} is not three numbers with a blank between")
        try:
            u, force, stiffness = row = [_number(token) for token in tokens]
        except ValueError as error:
            self.fail(line, error)
        for value, largest in ((u, LARGEST_OVERLAP), (force, LARGEST_FORCE), (stiffness, LARGEST_FORCE)):
            if not 1.0 / largest <= value <= largest:
                self.fail(line, f"{value!r} in {body!r} is not between {1.0 / largest:g} and {largest:g}")
        if rows and not (u > rows[-1][0] and force > rows[-1][1]) and not (u == rows[-1][0] and force >= rows[-1][1]):
            self.fail(line, f"{body!r} does not increase")
        rows.append(row)

    def read_key(self, line, body):
        """A key and its text."""
        key, separator, value = body.partition(": ")
        key = key if separator else key.removesuffix(":")
        if not key or (not separator and not body.endswith(":")):
            self.fail(line, f"{body!r} is not 'key: value'")
        if key in self.header:
            self.fail(line, f"key {key!r} occurs twice")
        self.header[key], self.lines[key] = value, line

    def check_keys(self):
        """Values of the keys that this file needs."""
        unloading = self.header.get("unloading")
        rule, given = rule_named(unloading), unloading == GIVEN
        keys = [*CURVE, *SHARED]
        if any(key.name in self.header for key in YIELD):
            keys += YIELD
        # the second number of each rule is a growth, which may be 0
        keys += [Key(name, _not_negative if n == 1 else _positive) for n, name in enumerate(rule.keys if rule else ())]
        if given:
            keys += [key._replace(name=UNLOADING + key.name) for key in CURVE]
        optional = [
            key._replace(name=prefix + key.name) for prefix in ("", UNLOADING)[: 1 + given] for key in _PERHAPS_OF_CONTACT
        ]
        keys += [key for key in optional if key.name in self.header]
        limits = (f"limit_{n}" for n in itertools.count(1))
        keys += [Key(name, _limit) for name in itertools.takewhile(self.header.__contains__, limits)]
        for name, read in keys:
            if name not in self.header:
                self.fail(self.titles or self.end, f"the lines above lack {name!r}")
            try:
                self.values[name] = read(self.header[name])
            except (ValueError, DemlawsError) as error:
                self.fail(self.lines[name], f"{name}: {error}")

    def check_scales(self):
        """Values that depend on one another: lengths, bulk yield, contacts, the unloading curve."""
        values, given = self.values, self.values["unloading"] == GIVEN
        if (values["length_over_roughness"] > 0.0) == (values["length_over_radius"] > 0.0):
            what = "one of length_over_roughness and length_over_radius is positive, the other 0"
            self.fail(self.lines["length_over_radius"], what)
        for prefix in ("", UNLOADING)[: 1 + given]:
            fields = {field: values[prefix + key] for key, field in _OF_CONTACT.items()}
            fields |= {key.name: values.get(prefix + key.name) for key in _PERHAPS_OF_CONTACT}
            if values["length_over_roughness"] > 0.0 and fields["roughness"] is None:
                self.fail(
                    self.lines["length_over_roughness"], f"overlaps over the roughness, but no {prefix}roughness is given"
                )
            try:
                values[prefix + "contact"] = Contact(**fields)
            except DemlawsError as error:
                self.fail(self.lines.get(prefix + "roughness", self.lines[prefix + "effective_radius"]), error)
        if "yield_area" in values:
            expected = (0.75 * values["yield_force"]) ** (2.0 / 3.0)
            if not abs(values["yield_area"] - expected) <= 1e-9 * expected:
                self.fail(self.lines["yield_area"], f"yield_area: with this yield_force it is {expected!r}")
        if (UNLOADING in self.rows) != given:
            what = "has no rows of its own" if UNLOADING in self.rows else f"needs rows below {UNLOADING_TITLES!r}"
            self.fail(self.lines["unloading"], f"unloading {values['unloading']!r} {what}")

    def build(self, prefix):
        """`Rows` of a curve."""
        points, count, bits = self.rows.get(prefix, []), self.values[f"{prefix}rows"], self.values[f"{prefix}bits"]
        if len(points) != count:
            self.fail(self.lines[f"{prefix}rows"], f"{len(points)} rows were read, the header states {count}")
        nodes = Nodes(*np.array(points).T)
        wrong = off_grid(nodes.u, bits)
        if wrong is not None:
            self.fail(self.first_line[prefix] + wrong[0], wrong[1])
        straight = self.values[prefix + BELOW] == "straight"
        u, s, slope = (values[0] for values in nodes.curve())
        if straight and u * slope / s > 1.0 + 1e-9:
            what = "straight below the first row, this curve would have a force below 0 at overlap 0"
            self.fail(self.lines[prefix + BELOW], what)
        return Rows(nodes, bits, straight)


def off_grid(u, bits_per_octave):
    """(number of the first row that the grid does not allow, why), or None."""
    first = node_number(u[0], bits_per_octave)
    if float(node(first, bits_per_octave)) != u[0]:
        return 0, "the first overlap is not on the grid of the header's bits"
    number, kinks = first + 1, 0  # the grid node that comes next
    for i in range(1, u.size):
        grid_node = float(node(number, bits_per_octave))
        if u[i] == u[i - 1]:
            kinks += 1
            if i == 1 or i == u.size - 1 or u[i] == u[i - 2]:
                return i, "a kink, an overlap in two rows, lies between other rows"
            if kinks > MOST_KINKS:
                return i, f"more than {MOST_KINKS} kinks"
        elif u[i] == grid_node:
            number += 1
        elif u[i] > grid_node:
            return i, "a row is missing before this one"
        elif i == u.size - 1 or u[i + 1] != u[i]:
            return i, "the overlap is not on the grid of the header's bits"
    if float(node(number - 1, bits_per_octave)) != u[-1]:
        return u.size - 1, "the last overlap is not on the grid of the header's bits"
    return None


# --- writing


def describe_contact(contact):
    """Header lines of the contact that a curve was made for: of an array of contacts, which one curve serves, the first."""
    values = {key: getattr(contact, field) for key, field in _OF_CONTACT.items()}
    values |= {key.name: getattr(contact, key.name) for key in _PERHAPS_OF_CONTACT}
    return {key: repr(float(np.ravel(value)[0])) for key, value in values.items() if value is not None}


def describe_rows(rows, certificate):
    """Header lines of the rows of a curve."""
    u, force, _ = rows.nodes
    return {
        BELOW: "straight" if rows.straight else "power",
        "bits": str(rows.bits),
        "kinks": " ".join(repr(float(k)) for k in rows.nodes.kinks),
        "range_overlap": f"{float(u[0])!r} {float(u[-1])!r}",
        "range_force": f"{float(force[0])!r} {float(force[-1])!r}",
        "force_error": repr(certificate[0]),
        "stiffness_error": repr(certificate[1]),
        "rows": str(u.size),
    }


def compose(header, loading, unloading=None):
    """(bytes of the file, fingerprint) of these keys and `Rows`."""
    curves = [loading] if unloading is None else [loading, unloading]
    lines = [*(f"{key}: {value}".rstrip() for key, value in header.items()), TITLES, *_text_rows(loading.nodes)]
    if unloading is not None:
        lines += [UNLOADING_TITLES, *_text_rows(unloading.nodes)]
    lines.append(f"end: {sum(rows.nodes.u.size for rows in curves)} rows")
    parts = [f"{FORMAT}\n".encode()]
    check = fingerprint = zlib.crc32(parts[0])
    for line in lines:
        body = line.encode()
        fingerprint = zlib.crc32(body, check)
        tail = b" %08x\n" % fingerprint
        check = zlib.crc32(tail, fingerprint)
        parts += [body, tail]
    return b"".join(parts), fingerprint


def _text_rows(nodes):
    return [f"{u:.17g} {f:.17g} {k:.17g}" for u, f, k in zip(*nodes, strict=True)]
