#!/usr/bin/env python3
"""A row of the table of tested systems in docs/inside/machines.md: versions, and whether a wheel draws its first plot.

    .venv/bin/python tools/machines/versions.py                       # the venv's numpy and numba, the installed engines
    python3.13 tools/machines/versions.py --newest                    # newest numpy and numba of PyPI instead, without engines

The wheel is built from this checkout, installed into a fresh environment with matplotlib, and docs/gallery/quickstart.py is run
there. Exit status 1 if it draws no picture. Standard library only.
"""

import argparse
import datetime
import os
import platform
import re
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
HEAD = ("date", "demlaws", "system", "Python", "numpy", "numba", "YADE", "LIGGGHTS", "LAMMPS", "first plot of the wheel")
IMPORTED = "import importlib.metadata as m; print(*(m.version(n) for n in ('demlaws', 'numpy', 'numba')))"


def output(*command, **options):
    """What a command prints; "" where it is not installed or fails."""
    try:
        done = subprocess.run(command, capture_output=True, text=True, stdin=subprocess.DEVNULL, timeout=120, **options)
    except (OSError, subprocess.TimeoutExpired):
        return ""
    return done.stdout + done.stderr


def system():
    """Name of the distribution."""
    fields = dict(re.findall(r'^(\w+)="?(.*?)"?$', Path("/etc/os-release").read_text(), re.MULTILINE))
    return fields.get("PRETTY_NAME", platform.system()).replace("GNU/Linux ", "")


def engines():
    """Versions of the engines that `demlaws` would run, or –."""
    folder = os.environ.get("DEMLAWS_LAMMPS") or ROOT / ".venv-lammps"
    binary = next((path for path in (Path(folder, "bin", "lmp"), Path("/usr/bin/lmp")) if path.exists()), "lmp")
    patterns = (
        (("yade", "--version"), r"[Yy]ade(?: version)?:? +(\S+?),?\s"),
        (("dpkg-query", "-W", "-f=liggghts ${Version}\n", "liggghts"), r"^liggghts (\S+)"),
        ((binary, "-help"), r"- (\d+ \w+ \d{4})"),
    )
    found = (re.search(pattern, output(*command), re.MULTILINE) for command, pattern in patterns)
    return [match[1] if match else "–" for match in found]


def first_plot(scratch, newest):
    """(versions of demlaws, numpy and numba in a fresh environment with the wheel, whether it draws the first plot)."""
    python, wheels = Path(scratch) / "fresh" / "bin" / "python", Path(scratch) / "wheels"
    quiet = {"check": True, "stdout": subprocess.DEVNULL}
    pip = [python, "-m", "pip", "--quiet", "--disable-pip-version-check"]
    subprocess.run([sys.executable, "-m", "venv", Path(scratch) / "fresh"], **quiet)
    subprocess.run([*pip, "wheel", "--no-deps", "--wheel-dir", wheels, ROOT], **quiet)
    own = output(sys.executable, "-c", IMPORTED).split()
    fixed = [] if newest or len(own) != 3 else [f"numpy=={own[1]}", f"numba=={own[2]}"]
    subprocess.run([*pip, "install", *wheels.glob("*.whl"), "matplotlib", *fixed], **quiet)
    environment = {"PATH": os.environ["PATH"], "HOME": scratch, "MPLBACKEND": "agg"}
    subprocess.run([python, ROOT / "docs" / "gallery" / "quickstart.py"], cwd=scratch, env=environment, check=False)
    return output(python, "-c", IMPORTED).split(), (Path(scratch) / "quickstart.png").is_file()


def main():
    """Print the row."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--newest", action="store_true", help="newest numpy and numba, no engines")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        (own, numpy, numba), drawn = first_plot(scratch, arguments.newest)
    shown = ["–"] * 3 if arguments.newest else engines()
    date = datetime.date.today().isoformat()
    cells = (date, own, system(), platform.python_version(), numpy, numba, *shown, "drawn" if drawn else "FAILED")
    print(f"| {' | '.join(HEAD)} |\n|{'---|' * len(HEAD)}\n| {' | '.join(cells)} |")
    return 0 if drawn else 1


if __name__ == "__main__":
    sys.exit(main())
