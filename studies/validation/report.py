"""All rows, and the page that shows them."""

import math
from pathlib import Path

from demlaws import __version__
from demlaws.files import write_atomically
from studies.validation import engines as engine_rows
from studies.validation.maps import read_csv
from studies.validation.published import GROUPS
from studies.validation.row import SOURCES


def collect(engines=True, packing=True):
    """Group → rows, in the order of the page; with a bar that shows progress."""
    from tqdm import tqdm

    groups = {}
    for name, rows in tqdm(GROUPS.items(), desc="published answers", leave=False, disable=None):
        groups[name] = list(rows())
    if engines:
        for name, row in tqdm(engine_rows.rows(packing), desc="engines", leave=False, disable=None):
            groups.setdefault(name, []).append(row)
    return groups


def _number(row):
    """What was found, with the digits that its tolerance asks for."""
    fine = row.high - row.low < 1e-9 * abs(row.found)
    return "–" if math.isnan(row.found) else f"{row.found:{'.15g' if fine else '.7g'}}"


def page(groups):
    """The report as Markdown."""
    rows = [row for group in groups.values() for row in group]
    count = {verdict: sum(row.verdict == verdict for row in rows) for verdict in ("pass", "FAIL", "not run")}
    lines = [
        f"# Validation of demlaws {__version__}",
        "",
        "Answers that others wrote, and ours. Tolerances are relative; a range is a limit of a model that is known, not an "
        "agreement. Made by `make validation`.",
        "",
        f"**{count['pass']} pass, {count['FAIL']} fail, {count['not run']} not run.**",
    ]
    for name, group in groups.items():
        titles = ["what", "where", "expected", "found", "unit", "verdict", "source"]
        noted = any(row.note for row in group)
        titles += ["note"] if noted else []
        lines += ["", f"## {name}", "", f"| {' | '.join(titles)} |", "|" + "---|" * len(titles)]
        for row in group:
            cells = (row.what, row.where, row.expected, _number(row), row.unit, row.verdict, row.source)
            lines.append(f"| {' | '.join((*cells, row.note) if noted else cells)} |")
    lines += ["", "## Sources", "", "| | who wrote the answer | terms |", "|---|---|---|"]
    used = {row.source for row in rows}
    lines += [f"| {key} | {source.text} | {source.licence} |" for key, source in SOURCES.items() if key in used]
    return "\n".join(lines) + "\n"


def write(groups, folder):
    """Write folder/validation.md and its figures; the page's path."""
    from demlaws.plots import save
    from studies.validation.figure import boundary_element_figure, deviations

    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    save(deviations(groups), folder / "deviations.png")
    save(boundary_element_figure(read_csv("asperity_bem.csv")), folder / "asperity.png")
    text = page(groups) + "\n![Deviation over tolerance of every row](deviations.png)\n"
    text += "\n![Load and contact area of the asperity model over boundary elements](asperity.png)\n"
    return write_atomically(folder / "validation.md", text)
