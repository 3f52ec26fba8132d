"""The numbers that README and docs state, recomputed: `make readme-check` fails where text and run differ.

A number is marked by a comment behind it, which no reader sees:

    1.2–4.1 µm<!-- check: granite.seating 0.05 --> per decade

The name stands for one value or for several, in which case the mark speaks of as many numbers before it; the tolerance is
absolute, or with % relative to the number stated. `python tools/readme_check.py --list` prints names, values and commands.
"""

import argparse
import csv
import functools
import itertools
import os
import re
import sys
import warnings
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parent.parent
MARK = re.compile(r"<!--\s*check:\s*(.*?)\s*-->", re.DOTALL)
NUMBER = re.compile(r"(?<![\w.])(?:[-−](?=\d))?\d[\d,]*(?:\.\d+)?(?:e[-+]?\d+)?|(?<=[-–×(/])\d[\d,]*(?:\.\d+)?(?:e[-+]?\d+)?")


# --- what is recomputed


@functools.cache
def _granite():
    from demlaws.granite import claims

    return claims.granite_claims()


@functools.cache
def _jamari():
    from studies.jamari.claims import jamari_claims

    return jamari_claims()


def _seating():
    """Shift [µm] of the absolute overlap per decade of the seating load, smallest and largest of the rough tests and laws."""
    from demlaws import granite, laws
    from demlaws.laws.registry import registry
    from demlaws.make import law

    shifts = []
    for name in laws():
        if "seating_share" not in registry()[name].options:
            continue
        for test in granite.ROUGH_SPHERES:
            contact = granite.find_test(test).contact
            overlaps = [float(law(name, contact, seating_share=s).overlap(10.0)) for s in (0.00025, 0.0025, 0.025)]
            shifts += [1e6 * (first - second) for first, second in itertools.pairwise(overlaps)]
    return min(shifts), max(shifts)


def _regime(column):
    from studies.jamari.published import published_ratios

    return tuple(getattr(row, column) for row in published_ratios() if row.solved == row.solved)


def _memory(memory):
    """Lowest and highest change of ten maps in cycle 2 [% of cycle 1's], isotropic surface."""
    from studies.jamari.cycles import second_changes

    changes = [100.0 * change for change in second_changes(memory)]
    return min(changes), max(changes)


def _boundary_elements(column):
    """Least, median, largest of the asperity model over the boundary elements, rough maps."""
    import numpy as np

    from studies.validation.maps import load_ratios, read_csv

    if column == "area":
        rows = [row for row in read_csv("asperity_bem.csv") if row["case"] != "smooth ball" and float(row["bem_area"]) > 0]
        ratios = [float(row["model_area"]) / float(row["bem_area"]) for row in rows]
    else:
        ratios = [ratio for case, ratio in load_ratios() if case != "smooth ball"]
    return float(min(ratios)), float(np.median(ratios)), float(max(ratios))


def _packing(law):
    """Error [%] of a packing's stiffness at 75 kPa in YADE and LIGGGHTS, as kept in docs/tables: the packings take an hour."""
    with open(ROOT / "docs" / "tables" / "trade-packing.csv", encoding="utf-8") as file:
        rows = {row["engine"]: row for row in csv.DictReader(file) if row["law"] == law and row["stresses"].startswith("75 ")}
    return tuple(float(rows[engine]["error of the stiffness to the first stress (%)"]) for engine in ("YADE", "LIGGGHTS"))


class Check(NamedTuple):
    """A value, or several, and the command of the user's that shows it."""

    value: object
    command: str


def checks():
    """Name → `Check`."""
    from demlaws.granite.verdicts import BUILT_IN, NOT_REPRODUCED, REPRODUCED, UNDECIDED

    verdicts = {"reproduced": REPRODUCED, "not-reproduced": NOT_REPRODUCED, "built-in": BUILT_IN, "undecided": UNDECIDED}
    papers = (("claims", _granite, "demlaws granite"), ("jamari", _jamari, "python -m studies.jamari --claims"))
    found = {
        "granite.seating": Check(_seating, "demlaws curve --law yip-venart --option seating_share=0.00025"),
        "regime.solved": Check(lambda: _regime("solved"), "python -m studies.jamari"),
        "regime.fitted": Check(lambda: _regime("fitted"), "python -m studies.jamari"),
        "packing.hertz": Check(lambda: _packing("hertz"), "python -m studies.trade --scene yade liggghts --stress 500kPa"),
        "asperity.load": Check(lambda: _boundary_elements("load"), "make validation"),
        "asperity.area": Check(lambda: _boundary_elements("area"), "make validation"),
    }
    for paper, claims, command in papers:
        found[f"{paper}.all"] = Check(lambda claims=claims: len(claims()), command)
        for name, verdict in verdicts.items():
            count = functools.partial(lambda claims, verdict: sum(c.verdict == verdict for c in claims()), claims, verdict)
            found[f"{paper}.{name}"] = Check(count, command)
    for memory in ("pressure", "blunting", "none"):
        found[f"memory.{memory}"] = Check(functools.partial(_memory, memory), "python -m studies.jamari --memory")
    return found


# --- marks


class Marked(NamedTuple):
    """A mark of a text, and the numbers before it."""

    place: str
    name: str
    tolerance: str
    stated: list


def marks(path):
    """Marks of one file."""
    text = path.read_text()
    for found in MARK.finditer(text):
        place = f"{os.path.relpath(path, ROOT)}:{text.count(chr(10), 0, found.start()) + 1}"
        name, _, tolerance = found[1].partition(" ")
        before = MARK.sub(" ", text[max(0, text.rfind("\n\n", 0, found.start())) : found.start()])
        yield Marked(place, name, tolerance, [float(n.replace(",", "").replace("−", "-")) for n in NUMBER.findall(before)])


def fault(mark, known):
    """Why a mark cannot be read; empty if it can."""
    if not re.fullmatch(r"\d+(\.\d+)?(e-?\d+)?%?", mark.tolerance):
        return "write <!-- check: NAME TOLERANCE -->, the tolerance a number or a percentage"
    return "" if mark.name in known else f"there is no check {mark.name!r}: see python tools/readme_check.py --list"


def deviation(mark, values):
    """What is wrong with a mark, in words; empty if nothing is."""
    stated = mark.stated[-len(values) :]
    if len(stated) < len(values):
        return f"{len(values)} numbers are needed before the mark, the text has {len(stated)}"
    for number, value in zip(stated, values, strict=True):
        width = float(mark.tolerance.rstrip("%")) * (abs(number) / 100.0 if mark.tolerance.endswith("%") else 1.0)
        if not abs(number - value) <= width * (1.0 + 1e-9):
            return f"the text has {number:g}, the run gives {value:.6g} (tolerance {mark.tolerance})"
    return ""


def texts():
    return [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]


def main(arguments=None):
    parser = argparse.ArgumentParser(description="Recompute the numbers that README and docs state.")
    parser.add_argument("--list", action="store_true", help="print every check with its value and the command that shows it")
    parser.add_argument("files", nargs="*", type=Path, help="texts to read (default: README.md and docs)")
    options = parser.parse_args(arguments)
    known = checks()

    @functools.cache
    def values_of(name):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            value = known[name].value()
        return value if isinstance(value, tuple) else (value,)

    if options.list:
        for name, check in known.items():
            print(f"{name:24} {', '.join(f'{value:.4g}' for value in values_of(name)):45} {check.command}")
        return 0
    found = [mark for path in options.files or texts() for mark in marks(path.resolve())]
    wrong = [(mark, why) for mark in found if (why := fault(mark, known) or deviation(mark, values_of(mark.name)))]
    for mark, why in wrong:
        print(f"WRONG  {mark.place}: {mark.name}: {why}")
    print(f"{len(found) - len(wrong)} marked numbers hold, {len(wrong)} do not")
    return 1 if wrong or not found else 0


if __name__ == "__main__":
    sys.exit(main())
