"""LAMMPS's own granular examples with demlaws/table, against stock Hertz; a minute or two.

    python -m studies.cases.examples FOLDER [--steps 2000]

FOLDER holds files of LAMMPS's sources, which are not part of demlaws: from examples/granular in.chute, in.pour.drum,
in.pour.flatwall, in.triaxial.compaction.12 with spheres12.data. Each one is run twice: with its normal models as
hertz/material, and as a table of Hertz's law; kinetic energies must agree as long as rounding has not grown. Rolling and
twisting models keep a history whose sign stock LAMMPS turns whenever a pair changes its order; demlaws does not, so an example
with such models is run as it is, and once more without them, and only that is judged. Grains that overlap by more than their
effective radius, as soft ones poured from high do, get no answer from the plugin; such an example is run with `extrapolation
on`, as the message says, under which Hertz's power law goes on. Units `lj` become `si` and cohesion is left out, for tables
are in metres and have none; every pair_coeff line gets the rolling and twisting model that one of them has. LAMMPS's unit
tests are rows of `make validation` (studies/validation/lammps_tests.py).
"""

import argparse
import re
import shutil
import sys
import tempfile
import warnings
from pathlib import Path
from typing import NamedTuple

import numpy as np

import demlaws as dl
from demlaws.lammps import run

warnings.simplefilter("ignore", dl.ValidityWarning)  # the examples' grains are softer than Hertz's law allows
NUMBER = r"(\S+)"
LIMIT = 1e-6
LONG = {"in.chute": 20, "in.triaxial.compaction.12": 5}  # few grains, which touch late
ROLLS = r" rolling \S+ \S+ \S+ \S+| twisting marshall"
TITLES = f"{'':44}{'spheres':>8}{'contacts':>9}{'depth/R':>9}{'extrapolated':>13}{'from stock':>12}{'in all':>9}"
MODELS = (  # a normal model's words, and E, eta, nu
    (rf"\bhertz/material {NUMBER} {NUMBER} {NUMBER}", r"\1 \2 \3"),
    (rf"\bjkr {NUMBER} {NUMBER} {NUMBER} {NUMBER}", r"\1 \2 \3"),
    (rf"\bmdr {NUMBER} {NUMBER} {NUMBER} {NUMBER} {NUMBER} {NUMBER}", r"\1 \6 \2"),
    (rf"(?<=[ *\d] )(?:hertz|hooke) {NUMBER} {NUMBER}", r"\1 \2 0.25"),
    (rf"(?<=granular )(?:hertz|hooke) {NUMBER} {NUMBER}", r"\1 \2 0.25"),
)


def rewritten(text, normal, more=""):
    """The input with every normal model replaced by `normal E eta nu more`."""
    text = re.sub(r"&\s*\n\s*", "", text)
    text = re.sub(r"^units\s+lj", "units si", text, flags=re.MULTILINE)
    text = re.sub(r"^(log|dump|dump_modify)\s.*$", "", text, flags=re.MULTILINE)
    text = text.replace("damping none", "damping viscoelastic")
    extra = re.search(r"^pair_coeff.*?( rolling \S+ \S+ \S+ \S+)( twisting marshall)", text, re.MULTILINE)
    late = re.findall(r"^fix\s.*\sbalance\s.*$", text, re.MULTILINE)  # LAMMPS wants it after the pair style
    lines = []
    for line in text.splitlines():
        if line in late:
            continue
        if line.startswith("thermo_style") and late:
            lines.append(late.pop())
        for words, values in MODELS:
            line, count = re.subn(words, f"{normal} {values}{more}", line)
            if count:
                break
        if line.startswith("pair_coeff") and extra and " rolling " not in line:
            line += extra.group(1) + extra.group(2)
        lines.append(line)
    return "\n".join(lines) + "\n"


def shortened(text, steps):
    """Only the first run, and no more than `steps` of it."""
    head, _, tail = text.partition("compute Ac_1_12 ")  # the triaxial test moves its walls from here on
    if tail:
        text = head + "\n".join(line for line in tail.splitlines()[3:] if line.startswith("variable")) + "\nrun 1000000\n"
        text = text.replace("\nrun 0\n", "\n")
    at = re.search(r"^run\s+\S+", text, re.MULTILINE)
    watch = "compute motion all ke\ncompute touching all contact/atom\ncompute ends all reduce sum c_touching\n"
    watch += "thermo_style custom step atoms c_motion c_ends\nthermo_modify lost warn format float %.15g\n"
    return text[: at.start()] + f"{watch}thermo {steps // 200}\nrun {steps}\n"


class Row(NamedTuple):
    """A line of the table."""

    name: str
    spheres: int
    contacts: int  # the most that there were
    depth: float  # largest overlap over R
    extrapolated: bool
    early: float  # largest difference of the kinetic energy from stock's, of its largest, soon after the first contact
    late: float  # in all
    judged: bool


def table_run(text, folder):
    """The log of an input with the table, and whether it had to be extrapolated."""
    for more in ("", " extrapolation on"):
        (folder / "in.example").write_text(rewritten(text, "demlaws/table hertz.tbl", more))
        try:
            return run(folder / "in.example"), bool(more)
        except dl.DemlawsError as error:
            if more or "extrapolation on" not in str(error):
                raise


def compared(name, text, folder, judged=True):
    """One input with stock Hertz and with the table: its `Row`."""
    (folder / "in.example").write_text(rewritten(text, "hertz/material"))
    stock = run(folder / "in.example", plugin=False)["motion"]
    log, extrapolated = table_run(text, folder)
    told = re.findall(r"deeper than a tenth of R, by up to (\S+) times", (folder / "log.lammps").read_text())
    difference = np.abs(log["motion"] - stock) / np.abs(stock).max()
    ends = log["ends"]
    early = slice(0, max(2, np.argmax(ends > 0) + len(ends) // 10))
    depth = 0.1 * max(map(float, told), default=1.0)
    counts = int(log["Atoms"][-1]), int(ends.max() / 2)
    return Row(name, *counts, depth, extrapolated, difference[early].max(), difference.max(), judged)


def example(path, folder, steps):
    """`Row`s of one example: as it is, and, where it has them, without rolling and twisting models."""
    text = shortened(rewritten(path.read_text(), "hertz/material"), steps)
    found = re.search(ROLLS, text)
    rows = [compared(path.name, text, folder, not found)]
    if found:
        rows.append(compared("  without rolling and twisting", re.sub(ROLLS, "", text), folder))
    return rows


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--steps", type=int, default=2000)
    options = parser.parse_args(arguments)
    good = True
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        # from R = 1 mm: a tenth of ten times that, where a table of Hertz's law ends by itself, is R of any grain
        dl.law("hertz", dl.Contact(radius=1e-3, modulus=5e4)).tabulate(rtol=1e-9).save(folder / "hertz.tbl")
        for file in options.folder.glob("*.data"):
            shutil.copy(file, folder)
        print(TITLES)
        paths = sorted(options.folder.glob("in.*"))
        if not paths:
            parser.error(f"{options.folder} holds none of the files")
        for path in paths:
            try:
                rows = example(path, folder, LONG.get(path.name, 1) * options.steps)
            except dl.DemlawsError as error:
                good = False
                print(f"{path.name:44} FAIL {error}")
                continue
            for row in rows:
                passed = (row.early <= LIMIT or not row.judged) and row.contacts > 0
                good &= passed
                depth = f"{row.depth:.2f}" if row.depth > 0.1 else "<0.1"
                verdict = "pass" if passed and row.judged else "runs" if passed else "FAIL"
                print(
                    f"{row.name:44}{row.spheres:8d}{row.contacts:9d}{depth:>9}{'yes' if row.extrapolated else 'no':>13}"
                    f"{row.early:12.1e}{row.late:9.1e}  {verdict}"
                )
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
