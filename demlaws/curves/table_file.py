"""Table files: a law of tables as bytes, and the parts of a law from a file."""

import json
import math
import os
from typing import Any

import numpy as np

from demlaws.contact import Contact, contact_at
from demlaws.core.grid import shape_from_nodes
from demlaws.core.table_types import NO_YIELD, BulkYield
from demlaws.curves import table_grammar
from demlaws.curves.closed import Certificate
from demlaws.curves.points import Knots
from demlaws.curves.table import TableCurve
from demlaws.curves.table_grammar import UNLOADING
from demlaws.curves.unloading import Unloading
from demlaws.errors import DemlawsError
from demlaws.files import as_path, read_bytes
from demlaws.laws.definition import Definition, Rules, no_limits
from demlaws.laws.registry import find
from demlaws.solvers.criterion import YIELD_RATIO


def compose(contact: Contact, curve: TableCurve, unloading: Unloading, collapses: bool) -> tuple:
    """(bytes of the file, fingerprint) of a law of tables."""
    from demlaws import __version__

    shape, rule = curve.shape, unloading.rule
    if rule.number is None:
        raise DemlawsError(
            f"a table file of law {curve.definition.name!r} with its user-defined unloading rule {rule.name!r}: files contain "
            "tables and rules of demlaws only; take elastic or hertz, or an unloading curve (unloading=...)"
        )
    length = shape.length_over_roughness * np.asarray(contact.sigma) + shape.length_over_radius * np.asarray(contact.radius)
    header = {
        "law": curve.definition.name,
        "description": _about(curve.definition),
        "source": curve.definition.source,
        "unloading": rule.name,
        "options": json.dumps(curve.options, default=lambda value: value.record()),
        **table_grammar.describe_contact(contact),
        "collapses": "yes" if collapses else "no",
        "scales": "overlap/length, force/(E* sqrt(R) length^1.5), stiffness/(E* sqrt(R length)), R and E* effective",
        "length": repr(float(np.ravel(length)[0])),
        "length_over_roughness": repr(shape.length_over_roughness),
        "length_over_radius": repr(shape.length_over_radius),
        **table_grammar.describe_rows(curve.rows, curve.certificate),
        "rtol": repr(curve.rtol),
        **({} if curve.knots is None else {"points": curve.knots.text()}),
        **_limits(curve, contact),
        "demlaws": __version__,
    }
    if math.isfinite(shape.bulk.area):
        u, s, _ = curve.nodes.curve()
        header["yield_overlap"] = repr(float(u[np.argmin(np.abs(s - shape.bulk.area))]))  # a kink of these laws: a row
        header["yield_force"] = repr(4.0 / 3.0 * shape.bulk.area**1.5)
        header["yield_area"] = repr(shape.bulk.area)
        header["yield_area_slope"] = repr(0.75 * shape.bulk.slope)  # by f, not by s^1.5
    if rule.keys:
        header |= {key: repr(value) for key, value in zip(rule.keys, unloading.rule_parameters, strict=False)}
    along = unloading.curve
    if along is not None:
        about = {
            "law": along.definition.name,
            "description": _about(along.definition),
            "source": along.definition.source,
            "options": json.dumps(along.options, default=lambda value: value.record()),
            **table_grammar.describe_contact(along.made_for),
            **table_grammar.describe_rows(along.rows, along.certificate),
        }
        header |= {UNLOADING + key: value for key, value in about.items()}
    return table_grammar.compose(header, curve.rows, None if along is None else along.rows)


def read(path: str | os.PathLike) -> tuple[Contact, TableCurve, Unloading]:
    """Contact, curve and unloading of a table file; DemlawsError with the line where it is truncated, edited or foreign."""
    path = as_path(path)
    file = table_grammar.parse(read_bytes(path, "table "), path)
    values = file.values
    rule = table_grammar.rule_named(values["unloading"])
    collapses = values["collapses"] == "yes"

    def curve(prefix, rows, collapses, bulk=NO_YIELD, floor=None):
        """The curve that the rows and the keys with this prefix describe."""
        lengths = values["length_over_roughness"], values["length_over_radius"]
        shape = shape_from_nodes(rows.nodes, rows.bits, *lengths, bulk=bulk, straight=rows.straight, floor=floor)
        certificate = Certificate(values[f"{prefix}force_error"], values[f"{prefix}stiffness_error"])
        definition = _definition(file, rule, prefix, collapses)
        options = definition.read(values[f"{prefix}options"])
        knots = _knots(file.header.get("points"), path) if prefix == "" else None
        made_for = values[f"{prefix}contact"]
        collapses = collapses or (prefix == "" and file.unloading is not None and definition.collapses)
        return TableCurve(definition, options, shape, rows.nodes, certificate, values["rtol"], made_for, collapses, knots)

    bulk, contact = NO_YIELD, values["contact"]
    if values.get("yield_area", math.inf) < file.loading.nodes.curve()[1][-1]:
        bulk = BulkYield(values["yield_area"], values["yield_area_slope"] / 0.75)
    loading = curve("", file.loading, collapses, bulk)
    unloading = Unloading(rule)
    if file.unloading is not None:
        unloading = Unloading(rule, curve(UNLOADING, file.unloading, collapses, floor=loading.floor), contact)
    elif rule.curve == "law":
        unloading = Unloading(rule, rule_parameters=loading.numbers_beside(rule, values))
    return contact, loading, loading.with_unloading(contact, unloading) if unloading.curve is None else unloading


def _limits(curve, contact):
    """Header lines of the range of force that the law's source supports, over E* √R length^1.5; of an array: the first."""
    one = contact_at(contact, 0)
    length = curve.shape.length_over_roughness * one.sigma + curve.shape.length_over_radius * one.radius
    scale, lines = one.modulus * math.sqrt(one.radius * length) * length, []
    for limit in curve.definition.limits(one, **curve.options):
        if limit.pressure:
            lines.append(f"pressure {YIELD_RATIO!r} {limit.reason}")
        elif limit.minimum_force > 0.0:
            lines.append(f"below {limit.minimum_force / scale!r} {limit.reason}")
        elif math.isfinite(limit.maximum_force):
            lines.append(f"above {limit.maximum_force / scale!r} {limit.reason}")
    return {f"limit_{number}": line for number, line in enumerate(lines, start=1)}


def _about(definition):
    return "; ".join(filter(None, (definition.description, definition.equation)))


def _definition(file, rule, prefix, collapses):
    """`Definition` of a file's law, or of a law that is not installed, as the file describes it."""
    name, header = file.values[f"{prefix}law"], file.header
    rules = Rules(own=(rule,) if rule.curve == "law" else ())
    try:
        definition = find(name)
    except DemlawsError:
        return definition_of_table(
            name,
            header.get(f"{prefix}source", ""),
            header.get(f"{prefix}description", ""),
            "radius" if file.values["length_over_radius"] > 0.0 else "roughness",
            collapses,
            rules=rules,
        )
    return definition if rule.name in definition.offered() else definition._replace(rules=rules)


def definition_of_table(name: str, source: str, description: str, length: str, collapses: bool, **facts: Any) -> Definition:
    """`Definition` of a law that is known from its table only."""
    return Definition(
        name=name,
        prepare=_not_here,
        equation="",
        source=source,
        description=description,
        limits=no_limits,
        length=length,
        collapses=collapses,
        **facts,
    )


def _not_here(contact, **options):
    raise DemlawsError("this law comes from a table without its definition: it cannot be made for another contact")


def _knots(line, path):
    try:
        return None if line is None else Knots.from_text(line)
    except (ValueError, KeyError, TypeError):
        raise DemlawsError(f"{path}: the line 'points' does not contain the points of a table") from None
