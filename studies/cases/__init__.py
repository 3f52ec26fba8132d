"""Cases of lammps_inputs and liggghts_inputs, with the tables and pictures of the documentation, and the engines' own examples.

`run_input` runs an input as a user does: with the tables that the comments `# Table: demlaws table ...` of its header make.
"""

import importlib
import re
import shlex
import shutil
from pathlib import Path

from demlaws import cli
from demlaws.errors import DemlawsError

ROOT = Path(__file__).resolve().parents[2]
ENGINES = ("liggghts", "lammps")


def prepared(engine, case, folder):
    """`folder`, with a copy of the case and the tables of its headers."""
    folder = Path(folder)
    shutil.copytree(ROOT / f"{engine}_inputs" / case, folder, dirs_exist_ok=True)
    texts = [path.read_text() for path in sorted(folder.glob("in.*"))]
    for line in sorted({line for text in texts for line in re.findall(r"^# Table: demlaws (.+)$", text, re.MULTILINE)}):
        words = shlex.split(line)
        words[-1] = str(folder / words[-1])
        if words[-2] != "--out" or cli.main(words):
            raise DemlawsError(f"{engine}_inputs/{case}: no table from `demlaws {line}`")
    return folder


def run_input(engine, script, ranks=1, variables=None, **options):
    """The log of an input."""
    return importlib.import_module(f"demlaws.{engine}").run(script, ranks, variables, **options)


def defaults(script):
    """{name: value} of the variables at the top of an input."""
    return dict(re.findall(r"^variable\s+(\w+) index (\S+)", Path(script).read_text(), re.MULTILINE))
