"""Table files: a law of tables as bytes, and the parts of a law from a file."""

import json
import math
import os
from typing import Any

import numpy as np

from demlaws.contact import Contact, contact_at
from demlaws.core.grid import shape_from_nodes
from demlaws.core.loops import loading_part
from demlaws.core.table_types import NO_YIELD, BulkYield
from demlaws.curves import table_grammar
from demlaws.curves.closed import Certificate
from demlaws.curves.points import Knots
from demlaws.curves.table import TableCurve
from demlaws.curves.table_grammar import OF_CONTACT, ROUNDING
from demlaws.curves.unloading import BoundLaw, Unloading, after_loading
from demlaws.errors import DemlawsError
from demlaws.files import as_path, read_bytes
from demlaws.laws.definition import Definition, Rules, no_limits
from demlaws.laws.registry import find
from demlaws.solvers.criterion import YIELD_RATIO

_OCTAVES_BELOW = 40
"""Of overlaps below the first row at which it is checked that no work is returned."""


def compose(contact: Contact, curve: TableCurve, unloading: Unloading, collapses: bool) -> tuple:
    """(bytes of the file, fingerprint) of a law of tables; DemlawsError where `read` would refuse it."""
    shape, rule = curve.shape, unloading.rule
    if rule.number is None:
        raise DemlawsError(
            f"a table file of law {curve.definition.name!r} with its user-defined unloading rule {rule.name!r}: files contain "
            "tables and rules of demlaws only; take elastic or hertz, or an unloading curve (unloading=...)"
        )
    header = {
        **_curve_keys(curve, contact),
        "unloading": rule.name,
        "collapses": "yes" if collapses else "no",
        "length": "sigma" if shape.length_over_roughness else "radius",
        "rtol": curve.rtol,
        **_limits(curve, contact),
    }
    if math.isfinite(shape.bulk.area):
        header |= {"yield_area": shape.bulk.area, "yield_slope": shape.bulk.slope}
    if curve.area_known:
        header["area"] = "known"
    if rule.keys:
        header |= dict(zip(rule.keys, unloading.rule_parameters, strict=False))
    if curve.knots is not None:
        knots = curve.knots
        columns = np.column_stack([knots.overlap, knots.force, np.nan_to_num(knots.uncertainty)])  # 0: unknown
        header |= {"points": knots.points, "departure": knots.departure, "smoothing": knots.smoothing}
        header["knots"] = columns.ravel().tolist()
    sections = [(header, curve.nodes)]
    if unloading.curve is not None:
        sections.append((_curve_keys(unloading.curve, unloading.curve.made_for), unloading.curve.nodes))
    composed = table_grammar.compose(sections)
    table_grammar.parse(composed[0], f"table of {curve.definition.name}")
    return composed


def _curve_keys(curve, contact):
    """Keys that describe a curve, for the contact that it was made for: of an array of contacts the first rough one."""
    definition = curve.definition
    one = contact_at(contact, int(np.argmax(np.ravel(contact.sigma_or_zero) > 0.0)))
    keys = {"law": definition.name}
    if definition.name not in table_grammar.law_keys() and definition.description:
        keys["description"] = definition.description
    keys |= {f"option_{name}": value for name, value in curve.options.items() if value is not None}
    keys |= {key.name: getattr(one, field) for field, key in OF_CONTACT.items() if getattr(one, field) is not None}
    return keys | {
        "below": "straight" if curve.starts_from_force else "power",
        "bits": str(curve.bits),
        "force_error": curve.certificate.force_error,
        "stiffness_error": curve.certificate.stiffness_error,
    }


def read(path: str | os.PathLike) -> tuple[Contact, TableCurve, Unloading]:
    """Contact, curve and unloading of a table file; DemlawsError with the line where it is truncated, edited or foreign."""
    path = as_path(path)
    sections, _ = table_grammar.parse(read_bytes(path, "table "), path)
    values, given = sections[0].values, len(sections) == 2
    rule = table_grammar.rules()[values["unloading"]]
    collapses, over_radius = values["collapses"] == "yes", values["length"] == "radius"

    def curve(section, bulk=NO_YIELD, floor=None):
        """The curve of a section."""
        nodes, own = section.nodes, section.values
        lengths = float(not over_radius), float(over_radius)
        straight = own["below"] == "straight"
        shape = shape_from_nodes(nodes, int(own["bits"]), *lengths, bulk=bulk, straight=straight, floor=floor)
        certificate = Certificate(own["force_error"], own["stiffness_error"])
        definition, options = _definition(section, rule, collapses, values["length"])
        alike = collapses or (section is sections[0] and given and definition.collapses)
        knots = None
        if "points" in own:
            overlap, force, uncertainty = np.reshape(own["knots"], (-1, 3)).T
            uncertainty = np.where(uncertainty > 0.0, uncertainty, math.nan)
            knots = Knots(overlap, force, uncertainty, round(own["points"]), own["departure"], own["smoothing"])
        known = "area" in values
        return TableCurve(definition, options, shape, nodes, certificate, values["rtol"], section.contact, alike, knots, known)

    bulk, contact = NO_YIELD, sections[0].contact
    if values.get("yield_area", math.inf) < sections[0].nodes.curve()[1][-1]:
        bulk = BulkYield(values["yield_area"], values["yield_slope"])
    loading = curve(sections[0], bulk)
    unloading = Unloading(rule)
    if given:
        unloading = Unloading(rule, curve(sections[1], floor=loading.floor), contact)
    elif rule.curve == "law":
        unloading = Unloading(rule, rule_parameters=loading.numbers_beside(rule, values))
    _refuse_unless_passive(sections, BoundLaw(contact, loading, unloading))
    return contact, loading, unloading


def _refuse_unless_passive(sections, law):
    """DemlawsError with the line of the row up to which loading makes less heat than up to the one before."""
    rule, section, u = law.unloading_parts.rule, sections[0], law.curve.nodes.u
    if not rule.state:
        return
    if rule.curve == "given":
        reverse, grid = law.shape.unloading.reverse.grid, law.curve.shape.grid
        ratio, seat = law.params.equivalent_ratio, law.shape.unloading.loading.grid.seat
        if float(grid.cells[-1, 0]) * ratio - seat > reverse.highest:
            sections[1].fail(sections[1].first_row, "the unloading curve ends below the last force of the loading")
    width = np.diff(u)
    aside = 1e-12 * (np.append(0.0, width == 0.0) - np.append(width == 0.0, 1.0))  # of kinks, and before the last row
    place = np.concatenate([u[0] * 0.5 ** np.arange(_OCTAVES_BELOW, 0, -1), u * (1.0 + aside)])
    overlap = place * float(loading_part(law.params).length)
    _, stored, dissipated = after_loading(law, law.params, overlap)
    work = stored + dissipated
    share = ROUNDING + 2.0 * sum(one.values["force_error"] + one.values["stiffness_error"] for one in sections)
    with np.errstate(invalid="ignore"):
        good = np.diff(dissipated) >= -share * np.diff(work) - ROUNDING * work[1:]
    good[_OCTAVES_BELOW:] |= width == 0.0
    if not np.all(good):
        row = max(int(np.argmin(good)) + 1 - _OCTAVES_BELOW, 0)
        section.fail(
            section.first_row + row,
            f"unloading {rule.name!r} returns more work from here than loading took from the row before: this table "
            "cannot take that rule",
        )


def _limits(curve, contact):
    """Keys of the range of force that the law's source supports, over E* √R length^1.5; of an array: the first.

    Nine digits: those after the thirteenth are other ones with other releases of numpy and scipy.
    """
    one = contact_at(contact, 0)
    length = curve.shape.length_over_roughness * one.sigma_or_zero + curve.shape.length_over_radius * one.radius
    scale, lines = one.modulus * math.sqrt(one.radius * length) * length, []
    for limit in curve.definition.limits(one, **curve.options):
        if limit.pressure:
            lines.append(f"pressure {YIELD_RATIO!r} {limit.reason}")
        elif limit.minimum_force > 0.0:
            lines.append(f"below {limit.minimum_force / scale:.9g} {limit.reason}")
        elif math.isfinite(limit.maximum_force):
            lines.append(f"above {limit.maximum_force / scale:.9g} {limit.reason}")
    return {f"limit_{number}": line for number, line in enumerate(lines, start=1)}


def _definition(section, rule, collapses, length):
    """(`Definition`, options) of a file's law, or of a law that is not installed, as the file describes it."""
    name, rules = section.values["law"], Rules(own=(rule,) if rule.curve == "law" else ())
    options = {key.removeprefix("option_"): _option(v) for key, v in section.values.items() if key.startswith("option_")}
    try:
        definition = find(name)
        options = definition.read_options(options)
    except DemlawsError:  # also where the law that it takes before yield is not installed
        length = "radius" if length == "radius" else "roughness"
        description = section.values.get("description", "")
        return definition_of_table(name, "", description, length, collapses, rules=rules), options
    if rule.name not in definition.offered():
        definition = definition._replace(rules=rules)
    return definition, options


def _option(value):
    """The value of an option: a number, or a text that may be JSON."""
    try:
        return json.loads(value) if isinstance(value, str) else value
    except (ValueError, RecursionError):
        return value


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
