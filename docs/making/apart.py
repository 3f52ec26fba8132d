"""Long tables of a measured page, kept in files beside it: the page has conclusions, and a summary of ten rows at most."""

import csv
import io
import re

TABLE = re.compile(r"^\|.*\n\|[-|: ]+\|\n(?:\|.*\n?)*", re.MULTILINE)


def cells(line):
    """Cells of a row of a Markdown table."""
    return [cell.strip().replace("\\|", "|") for cell in re.split(r"(?<!\\)\|", line.strip())[1:-1]]


def csv_of(rows):
    """CSV text."""
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerows(rows)
    return out.getvalue()


def report_apart(text):
    """(page, rows.csv, sources.csv) of the report: tables with a verdict as CSV, a summary per kind of reference."""
    rows, summary, sources, rest = [], [], [], []
    for part in re.split(r"(?m)^(?=## )", text):
        title = part.partition("\n")[0].removeprefix("## ").strip()
        found = list(TABLE.finditer(part))
        kept = [(m, cells(m.group().splitlines()[0])) for m in found]
        if title == "Sources" and found:
            sources = [cells(line) for k, line in enumerate(found[0].group().splitlines()) if k != 1]
            rest.append(TABLE.sub("[All sources, with their terms](report-sources.csv).\n", part, count=1))
        elif any("verdict" in names for _, names in kept):
            groups, count, passed = [], 0, 0
            for match, names in kept:
                group = re.findall(r"^\*\*(.+?)\*\*$", part[: match.start()], re.MULTILINE)
                groups += group[-1:]
                for line in match.group().splitlines()[2:]:
                    row = dict(zip(names, cells(line), strict=False))
                    count, passed = count + 1, passed + (row["verdict"] == "pass")
                    rows.append([title, group[-1] if group else "", *(row.get(name, "") for name in COLUMNS)])
            summary.append((title, str(count), str(passed)))
        elif title == "One line per law":
            lines = [cells(line) for line in found[0].group().splitlines()[2:]]
            rest.append(
                TABLE.sub("\n".join(f"- {law}: {result} ({passed})" for law, result, passed in lines) + "\n", part, count=1)
            )
        else:
            rest.append(part)
    lines = ["## What was compared\n", "| type of reference | rows | pass |", "|---|---:|---:|"]
    lines += [f"| {' | '.join(row)} |" for row in summary]
    lines += ["\n[Every row](report.csv): expected and found value, unit, verdict, source, note.\n\n"]
    place = next((k for k, part in enumerate(rest) if part.startswith("## Sources")), len(rest))
    page = "".join([*rest[:place], "\n".join(lines), *rest[place:]])
    return page, csv_of([["type of reference", "comparison", *COLUMNS], *rows]), csv_of(sources)


COLUMNS = ("what", "where", "expected", "found", "unit", "verdict", "source", "note")


def printed_apart(tables, wanted, name):
    """A printed table with the wanted rows only, and a link to all of it; up to the first blank line its head stays."""
    lines = tables.splitlines()
    first = next(k for k, line in enumerate(lines) if wanted(line))
    shown = [*lines[:first], *(line for line in lines[first:] if wanted(line))]
    return "\n".join(shown), f"[All {len(lines) - first} rows]({name}.txt)."
