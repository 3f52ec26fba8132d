"""The text of a table file: header, rows, check marks. docs/table-format.md is its grammar, `saved` interprets it.

`demlaws/cpp/demlaws_table.h` reads the same files; tests/cpp compares the two, verdict by verdict and line by line.
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

FORMAT = "# demlaws-table"
VERSIONS = (1, 2, 3)
TITLES = "overlap force stiffness"
UNLOADING_TITLES = "unloading overlap force stiffness"
OWN = "own"
"""For `unloading`: a user-defined rule of the law; its code is in an object beside the file (`rule_object`)."""
OF_OWN_RULE = ("rule", "rule_object")
UNLOADING = "unloading_"
"""Before the keys that describe an unloading curve and its rows."""
BELOW = "below_first_row"
MOST_ROWS = 2_000_000
_STRAIGHT_BELOW = 0.5
"""Version 1 has no key BELOW: there a curve whose d ln s/d ln u at the first row is less than this starts from a force."""
_OVERLAPS, _OTHERS = (1e-60, 1e60), (1e-200, 1e200)
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
    special = (rule for definition in registry().values() for rule in definition.rules if rule.number is not None)
    return RULES | {rule.name: rule for rule in special}


def rule_named(name):
    """The rule of this name, or None; laws are loaded only for other rules than the general ones."""
    return RULES.get(name) or rules().get(name)


def _rule(text):
    return text if text in RULES else _one_of(*rules(), OWN)(text)


def _mark(text):
    """Check value and size of a file."""
    if not re.fullmatch("[0-9a-f]{8} [1-9][0-9]{0,8}", text):
        raise ValueError(f"{text!r} is not 8 hexadecimal digits and a size")
    return text


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


def _contact_of_json(text):
    """The contact that a table of versions 1 and 2 was made for."""
    fields = _object(text)
    for name, value in fields.items():
        optional = name in ("fractal_dimension", "hardness")
        if not (optional and value is None) and (not isinstance(value, int | float) or isinstance(value, bool)):
            raise ValueError(f"{name!r} of the contact is not a number")
    try:
        return Contact(**fields)
    except (TypeError, OverflowError) as error:
        raise ValueError(f"this is not a contact with radius and modulus ({error})") from None


# --- keys


class Key(NamedTuple):
    """A key that readers need: what its text means, and the versions of the format that have it."""

    name: str
    read: Callable
    version: int = 1
    last_version: int = VERSIONS[-1]


CURVE = (
    Key("law", _name),
    Key("options", _object),
    Key("contact", _contact_of_json, 1, 2),
    Key("effective_radius", _positive, 3),
    Key("effective_modulus", _positive, 3),
    Key("roughness", _not_negative, 3),
    Key("bits", _whole(1, MOST_BITS)),
    Key("rows", _whole(2, MOST_ROWS)),
    Key("force_error", _not_negative),
    Key("stiffness_error", _not_negative),
    Key(BELOW, _one_of("power", "straight"), 2),
)
_OF_CONTACT = {"effective_radius": "radius", "effective_modulus": "modulus", "roughness": "roughness"}
_PERHAPS_OF_CONTACT = (Key("fractal_dimension", _positive), Key("hardness", _positive))
SHARED = (
    Key("unloading", _rule),
    Key("collapses", _one_of("yes", "no")),
    Key("length", _positive),
    Key("length_over_roughness", _not_negative),
    Key("length_over_radius", _not_negative),
    Key("rtol", _not_negative),
)
_YIELD = (
    Key("yield_overlap", _positive),
    Key("yield_force", _positive),
    Key("yield_area", _positive),
    Key("yield_area_slope", _positive),
)


class TableFile(NamedTuple):
    """A file that is a table: values of its keys, and its rows."""

    version: int
    header: dict  # key → text, all keys
    values: dict  # key → value, the keys that readers need
    loading: Rows
    unloading: Rows | None
    fingerprint: int  # CRC-32 of the text up to the last check mark


def exponent(nodes):
    """d ln s/d ln u of the first row."""
    u, s, slope = (v[0] for v in Nodes(*(v[:1] for v in nodes)).curve())
    return float(u * slope / s)


# --- reading


def parse(data, name):
    """`TableFile` of the bytes of a file, which messages call `name`; DemlawsError with the line of what is wrong."""

    def refuse(line, why):
        raise DemlawsError(f"{name}, line {line}: {why}")

    lines = data.replace(b"\r\n", b"\n").split(b"\n")
    whole = len(lines) > 1 and not lines[-1]  # the last line has its end
    if whole:
        lines.pop()
    version = _version(lines[0].decode(errors="replace"), refuse)
    check = zlib.crc32(lines[0] + b"\n")
    header, places, rows, first_row, complete = {}, {}, {}, {}, False
    reading = None
    for place, raw in enumerate(lines[1:], start=2):
        if complete:
            refuse(place, "text after the last line ('end: ...')")
        body, separator, mark = raw.rpartition(b" ")
        check = zlib.crc32(body, check)
        if not separator or mark != b"%08x" % check:
            what = "the file ends here: it was cut short" if place == len(lines) else "this line was changed"
            refuse(place, f"{what} (its check mark does not fit); write the table again with Table.save or demlaws table")
        fingerprint, check = check, zlib.crc32(b" " + mark + b"\n", check)
        line = body.decode(errors="replace")
        if line.startswith("end: "):
            complete = True
            places["end"] = place
            count = sum(map(len, rows.values()))
            if line != f"end: {count} rows":
                refuse(place, f"{count} rows were read, {line.removeprefix('end: ')!r} were promised")
        elif line == TITLES and reading is None:
            reading, places[TITLES] = "", place
            rows[reading], first_row[reading] = [], place + 1
        elif line == UNLOADING_TITLES and reading == "":
            reading = UNLOADING
            rows[reading], first_row[reading] = [], place + 1
        elif reading is not None:
            try:
                rows[reading].append(_row(line, rows[reading]))
            except ValueError as error:
                refuse(place, str(error))
        else:
            key, separator, value = line.partition(": ")
            key = key if separator else key.removesuffix(":")
            if not key or (not separator and not line.endswith(":")):
                refuse(place, f"{line!r} is not 'key: value'")
            if key in header:
                refuse(place, f"key {key!r} occurs twice")
            header[key], places[key] = value, place
    if not complete:
        refuse(len(lines) + whole, "the file ends without its 'end:' line: it was cut short")

    of_curve = [key for key in CURVE if key.version <= version <= key.last_version]
    keys = [*of_curve, *SHARED]
    if any(key.name in header for key in _YIELD):
        keys += _YIELD
    rule = rule_named(header.get("unloading"))
    # the second number of each rule is a growth, which may be 0
    keys += [Key(name, _not_negative if n == 1 else _positive) for n, name in enumerate(rule.keys if rule else ())]
    if header.get("unloading") == OWN:
        keys += [Key(name, read) for name, read in zip(OF_OWN_RULE, (_name, _mark), strict=True)]
    if header.get("unloading") == GIVEN:
        keys += [key._replace(name=UNLOADING + key.name) for key in of_curve]
    if version > 2:
        prefixes = ("", UNLOADING) if header.get("unloading") == GIVEN else ("",)
        optional = [key._replace(name=prefix + key.name) for prefix in prefixes for key in _PERHAPS_OF_CONTACT]
        keys += [key for key in optional if key.name in header]
    keys += [Key(name, _limit) for name in itertools.takewhile(header.__contains__, (f"limit_{n}" for n in itertools.count(1)))]
    values = {}
    for key in keys:
        if key.name not in header:
            refuse(places.get(TITLES, places["end"]), f"the lines above lack {key.name!r}")
        try:
            values[key.name] = key.read(header[key.name])
        except (ValueError, DemlawsError) as error:
            refuse(places[key.name], f"{key.name}: {error}")
    if (values["length_over_roughness"] > 0.0) == (values["length_over_radius"] > 0.0):
        refuse(places["length_over_radius"], "one of length_over_roughness and length_over_radius is positive, the other 0")
    if "yield_area" in values:
        expected = (0.75 * values["yield_force"]) ** (2.0 / 3.0)
        if not abs(values["yield_area"] - expected) <= 1e-9 * expected:
            refuse(places["yield_area"], f"yield_area: with this yield_force it is {expected!r}")
    for prefix in (("", UNLOADING) if values["unloading"] == GIVEN else ("",)) if version > 2 else ():
        fields = {field: values[prefix + key] for key, field in _OF_CONTACT.items()}
        fields |= {key.name: values.get(prefix + key.name) for key in _PERHAPS_OF_CONTACT}
        try:
            values[prefix + "contact"] = Contact(**fields)
        except DemlawsError as error:
            refuse(places[prefix + "roughness"], str(error))
    if (UNLOADING in rows) != (values["unloading"] == GIVEN):
        what = "has no rows of its own" if UNLOADING in rows else f"needs rows below {UNLOADING_TITLES!r}"
        refuse(places["unloading"], f"unloading {values['unloading']!r} {what}")

    def curve(prefix):
        points, count, bits = rows.get(prefix, []), values[f"{prefix}rows"], values[f"{prefix}bits"]
        if len(points) != count:
            refuse(places[f"{prefix}rows"], f"{len(points)} rows were read, the header states {count}")
        nodes = Nodes(*np.array(points).T)
        wrong = _off_grid(nodes.u, bits)
        if wrong is not None:
            refuse(first_row[prefix] + wrong[0], wrong[1])
        p = exponent(nodes)
        if version == 1:
            return Rows(nodes, bits, p < _STRAIGHT_BELOW)
        straight = values[prefix + BELOW] == "straight"
        if straight and p > 1.0 + 1e-9:
            refuse(places[prefix + BELOW], "straight below the first row, this curve would have a force below 0 at overlap 0")
        return Rows(nodes, bits, straight)

    loading = curve("")
    return TableFile(version, header, values, loading, curve(UNLOADING) if UNLOADING in rows else None, fingerprint)


def _version(line, refuse):
    versions = f"this version of demlaws reads {', '.join(map(str, VERSIONS))}"
    words = line.rpartition(" ")
    if words[0] != FORMAT or not re.fullmatch("[1-9][0-9]{0,8}", words[2]):
        refuse(1, f"not a demlaws table (the first line must be '{FORMAT} {VERSIONS[0]}' or '... {VERSIONS[-1]}')")
    if int(words[2]) not in VERSIONS:
        refuse(1, f"a table of format {words[2]}; {versions}: install a newer one, or write the table again with this one")
    return int(words[2])


def _row(line, rows):
    """u, f, k of a line; ValueError where it cannot follow the rows before it."""
    tokens = line.split(" ")
    if len(tokens) != 3:
        raise ValueError(f"{line!r} is not three numbers with a blank between")
    row = [_number(token) for token in tokens]
    for value, (low, high) in zip(row, (_OVERLAPS, _OTHERS, _OTHERS), strict=True):
        if not low <= value <= high:
            raise ValueError(f"{value!r} in {line!r} is not between {low:g} and {high:g}")
    if rows and not (row[0] > rows[-1][0] and row[1] > rows[-1][1]) and not (row[0] == rows[-1][0] and row[1] >= rows[-1][1]):
        raise ValueError(f"{line!r} does not increase")
    return row


def _off_grid(u, bits_per_octave):
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
    parts = [f"{FORMAT} {VERSIONS[-1]}\n".encode()]
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
