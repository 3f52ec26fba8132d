"""All rows, and the page that shows them."""

import math
import re
from pathlib import Path

from demlaws import __version__
from demlaws.files import write_atomically
from studies.validation import engines as engine_rows
from studies.validation.maps import read_csv
from studies.validation.published import GROUPS
from studies.validation.row import EQUATIONS, KINDS, METHODS, SOURCES


def collect(engines=True):
    """Group → rows, in the order of the page; with a bar that shows progress."""
    from tqdm import tqdm

    groups = {}
    for name, rows in tqdm(GROUPS.items(), desc="published answers", leave=False, disable=None):
        groups[name] = list(rows())
    if engines:
        for name, row in tqdm(engine_rows.rows(), desc="engines", leave=False, disable=None):
            groups.setdefault(name, []).append(row)
    return groups


def _number(row):
    """What was found, with the digits that its tolerance asks for."""
    fine = row.high - row.low < 1e-9 * abs(row.found)
    return "–" if math.isnan(row.found) else f"{row.found:{'.15g' if fine else '.7g'}}"


CONCLUSIONS = {row["law"]: (row["rows"], row["result"]) for row in read_csv("conclusions.csv")}
"""Law → regular expression of the rows that concern it (in "group: what"), and what they show."""


def evidence(groups, pattern):
    """(kind, rows) of the rows whose "group: what" the pattern finds, the strongest kind first."""
    chosen = [row for name, group in groups.items() for row in group if re.search(pattern, f"{name}: {row.what}")]
    return [(kind, rows) for kind in KINDS if (rows := [row for row in chosen if SOURCES[row.source].kind == kind])]


def conclusions(groups):
    """Lines of the table with one line per law."""
    yield "| law | result of the comparisons | rows passed, by type of reference |"
    yield "|---|---|---|"
    for law, (pattern, sentence) in CONCLUSIONS.items():
        counts = []
        for kind, rows in evidence(groups, pattern):
            passed, failed = (sum(row.verdict == verdict for row in rows) for verdict in ("pass", "FAIL"))
            counts.append(f"{kind[0].lower()}{kind[1:]} {passed}/{passed + failed}" + (" **FAIL**" if failed else ""))
        yield f"| `{law}` | {sentence.rstrip('.')}. | {'; '.join(counts) or 'none'} |"


def table(rows):
    """Rows as a Markdown table."""
    titles = ["what", "where", "expected", "found", "unit", "verdict", "source"]
    noted = any(row.note for row in rows)
    titles += ["note"] if noted else []
    yield f"| {' | '.join(titles)} |"
    yield "|" + "---|" * len(titles)
    for row in rows:
        cells = (row.what, row.where, row.expected, _number(row), row.unit, row.verdict, row.source)
        yield f"| {' | '.join((*cells, row.note) if noted else cells)} |"


def page(groups):
    """The report as Markdown: one line per law, the picture, then the rows by whose answer they are compared with."""
    rows = [row for group in groups.values() for row in group]
    count = {verdict: sum(row.verdict == verdict for row in rows) for verdict in ("pass", "FAIL", "not run")}
    lines = [
        f"# Validation of demlaws {__version__}",
        "",
        "Every row compares a result of demlaws with a published or third-party result. `make validation` generates this page.",
        "",
        f"**{count['pass']} pass, {count['FAIL']} fail, {count['not run']} not run.**",
        "",
        "## One line per law",
        "",
        *conclusions(groups),
        "",
        "See also [glass beads in an oedometer](small-strain.md#glass-beads-in-an-oedometer), and "
        "[wrong numbers that these rows detect](mutations.md).",
        "",
        "![Deviation over tolerance of every row](deviations.png)",
        "",
        "Each mark is a row of report.csv: its distance from the expected value over the tolerance, 1 at the limit. "
        "Tolerances are relative. A range in place of a value is a known limit of a model, not an agreement.",
    ]
    for kind in KINDS:
        chosen = {name: [row for row in group if SOURCES[row.source].kind == kind] for name, group in groups.items()}
        if not any(chosen.values()):
            continue
        folded = kind in (EQUATIONS, METHODS)
        number = sum(map(len, chosen.values()))
        lines += ["", f"## {kind}", ""]
        if folded:
            lines += [FOLDED[kind], "", f"<details><summary>{number} rows</summary>", ""]
        for name, group in chosen.items():
            if group:
                lines += [f"**{name}**", "", *table(group), ""]
        lines += ["</details>"] if folded else []
    lines += ["", "## Sources", "", "| | whose answer | terms |", "|---|---|---|"]
    used = {row.source for row in rows}
    lines += [f"| {key} | {source.text} | {source.licence} |" for key, source in SOURCES.items() if key in used]
    return "\n".join(lines) + "\n"


FOLDED = {
    EQUATIONS: "Consistency, not validation: both sides are ours, the law and a second evaluation of the printed equation.",
    METHODS: "Consistency between two programs of ours, on inputs that papers print.",
}


def write(groups, folder):
    """Write folder/validation.md and its figures; the page's path."""
    from demlaws.plots import save
    from studies.validation.figure import boundary_element_figure, deviations

    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    save(deviations(groups), folder / "deviations.png")
    save(boundary_element_figure(read_csv("asperity_bem.csv")), folder / "asperity.png")
    text = page(groups)
    text += "\n![Load and contact area of the asperity model over boundary elements](asperity.png)\n\n"
    text += "*Load (left) and contact area (right) of the law `asperity` over those of elastic boundary elements on the\n"
    text += "same map, at equal overlap.*\n"
    return write_atomically(folder / "validation.md", text)
