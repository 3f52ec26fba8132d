#!/usr/bin/env python3
"""Wheel and sdist in dist/, each installed and tried in clean environments outside the checkout: `make dist`.

    python tests/machines/dist.py                     # build, then try on Python 3.10 and the newest that this machine has
    python tests/machines/dist.py --python 3.12       # on others
    python tests/machines/dist.py --built             # try what dist/ holds

Pythons are looked for in the folders of pyenv, uv, GitHub and the system; one that is missing makes the exit status 1.
Tried: versions agree, every file of the package that git knows is inside, a law, a table and an impact are computed, the
command answers, and the C++ sources that engines need lie where the code looks. Standard library only, but for `build`.
"""

import argparse
import re
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
pair = dl.Contact(radius=4.35e-3, modulus=32.32e9, roughness=2.4e-6, fractal_dimension=2.22, hardness=6.266e9)
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


def say(text):
    """Progress, at once."""
    print(f"dist: {text}", flush=True)


def works(python):
    """Whether this interpreter can make environments and reach a registry."""
    return not subprocess.run([python, "-c", "import venv, ensurepip, ssl"], capture_output=True).returncode


def pythons():
    """Version (3, 11) → path of an interpreter that can make environments."""
    found = {}
    for pattern in FOLDERS:
        base = Path(pattern).expanduser()
        anchor = Path(base.anchor)
        for folder in sorted(anchor.glob(base.relative_to(anchor).as_posix())):
            for path in sorted(folder.glob("python3.*")):
                match = re.fullmatch(r"python3\.(\d+)", path.name)
                version = (3, int(match.group(1))) if match else None
                if version and version not in found and works(path):
                    found[version] = path
    return found


def known(prefix):
    """Files below `prefix` that git knows."""
    listed = subprocess.run(["git", "ls-files", prefix], cwd=ROOT, capture_output=True, text=True, check=True)
    return listed.stdout.split()


def build(folder):
    """Build sdist, and the wheel from it; returns their paths."""
    say(f"building into {folder}")
    shutil.rmtree(folder, ignore_errors=True)
    subprocess.run([sys.executable, "-m", "build", "--outdir", folder, ROOT], check=True, stdout=subprocess.DEVNULL)


def contents(path):
    """Names in a wheel or sdist, the sdist's without its first folder."""
    if path.suffix == ".whl":
        return set(zipfile.ZipFile(path).namelist())
    with tarfile.open(path) as archive:
        return {name.partition("/")[2] for name in archive.getnames()}


def tried(python, archive, files, scratch):
    """Install `archive` with `python` into an environment of its own and try it; True if all went well."""
    environment = scratch / f"{python.name}-{archive.suffix.lstrip('.')}"
    where = environment / "work"
    subprocess.run([python, "-m", "venv", environment], check=True)
    where.mkdir()
    there = environment / "bin" / "python"
    pip = [there, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", archive]
    if subprocess.run(pip, cwd=where).returncode:
        say(f"FAILED: {python} cannot install {archive.name}")
        return False
    script = where / "trial.py"
    script.write_text(TRIAL)
    for line in ([there, script, ROOT, " ".join(files)], [environment / "bin" / "demlaws", "laws", "pohrt-popov"]):
        if subprocess.run(line, cwd=where, stdout=None if line[0] == there else subprocess.DEVNULL).returncode:
            say(f"FAILED: {python}, {archive.name}: {' '.join(str(w)[:60] for w in line)}")
            return False
    return True


def main():
    """Build, look inside, try; exit status 1 if anything is not as it must be."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--python", action="append", help="version to try on, such as 3.12 (may be repeated)")
    parser.add_argument("--built", action="store_true", help="do not build: try what dist/ holds")
    arguments = parser.parse_args()
    folder = ROOT / "dist"
    files = known("demlaws")
    if not arguments.built:
        build(folder)
    archives = sorted(folder.glob("*.whl")) + sorted(folder.glob("*.tar.gz"))
    good = len(archives) == 2
    for archive in archives:
        missing = sorted(set(files) - contents(archive))
        say(f"{archive.name}: {archive.stat().st_size / 1e6:.1f} MB" + (f", FAILED: without {missing}" if missing else ""))
        surplus = [name for name in contents(archive) if archive.suffix == ".whl" and not name.startswith("demlaws")]
        if surplus:
            say(f"FAILED: the wheel holds {', '.join(sorted(surplus)[:5])}")
        good &= not missing and not surplus
    found = pythons()
    newest = max(found, default=None)
    wanted = arguments.python or [OLDEST, ".".join(map(str, newest))]
    say(f"Pythons here: {', '.join('.'.join(map(str, v)) for v in sorted(found))}; trying {', '.join(wanted)}")
    with tempfile.TemporaryDirectory(prefix="demlaws-dist-") as scratch:
        for version in dict.fromkeys(wanted):
            python = found.get(tuple(map(int, version.split("."))))
            if python is None:
                say(f"FAILED: no Python {version} here")
                good = False
                continue
            for archive in archives:
                good &= tried(python, archive.resolve(), files, Path(scratch))
    say("all is well" if good else "FAILED")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
