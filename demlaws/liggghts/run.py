"""Run a case: the stock binary with the plugin preloaded, on one rank or many."""

import functools
import os
import re
import shutil
import subprocess
from pathlib import Path

from demlaws.errors import DemlawsError, EngineStopped
from demlaws.liggghts.build import PACKAGES, build
from demlaws.processes import output, thermo, thermo_of_log

VERSION = "3.8.0"
HEAD = """\
atom_style      granular
atom_modify     map array
boundary        f f f
newton          off
communicate     single vel yes
units           si
hard_particles  yes
"""
"""How our own inputs begin: spheres, SI units, moduli of stone."""

ALONE = {"OMPI_MCA_ess_singleton_isolated": "1", "OMPI_MCA_pml": "ob1", "OMPI_MCA_btl": "self"}
"""Of a process that is its only rank: without a daemon and a look for networks, which Open MPI starts with, half a second."""


def executable():
    """Path of the liggghts binary (DEMLAWS_LIGGGHTS or the first on PATH); DemlawsError where there is none."""
    name = os.environ.get("DEMLAWS_LIGGGHTS", "liggghts")
    found = shutil.which(name)
    if not found:
        raise DemlawsError(f"{name!r} not found: {PACKAGES}, or set DEMLAWS_LIGGGHTS to the binary")
    return os.path.abspath(found)  # it is started in the input's folder


@functools.lru_cache
def _versions_of(binary):
    """Version line of the binary; raises where it is not the one the plugin is for, or a superquadric build."""
    asked = subprocess.run([binary, "-h"], capture_output=True, text=True)
    line = asked.stdout
    if asked.returncode and not line:  # a library that it does not find
        raise DemlawsError(f"{binary} does not start: {asked.stderr.strip()[:300]}")
    found = re.search(r"Version (LIGGGHTS\S*) (\S+?),", line)
    if not found or found.group(2) != VERSION:
        raise DemlawsError(f"the plugin is for LIGGGHTS {VERSION}, the binary says {found.group(0) if found else line[:80]!r}")
    styles = line.split("Atom styles", 1)[-1].split("* Integrate", 1)[0]
    if "superquadric" in styles or "convexhull" in styles:
        raise DemlawsError("this LIGGGHTS is a superquadric or convex build: its data differ; use Debian's package liggghts")
    return f"{found.group(1)} {found.group(2)}"


def versions():
    """Version of the binary; raises where it is not the one that the plugin is for, or a superquadric build."""
    return _versions_of(executable())


def command(script, ranks=1, variables=None, log="log.liggghts", plugin=True, portable=False, arguments=()):
    """The command line and the environment of a run; portable: with the plugin that `build(portable=True)` makes.

    arguments: more of LIGGGHTS's own, such as ("-echo", "screen").
    Root needs --allow-run-as-root and --oversubscribe of mpirun, more ranks than cores the latter.
    """
    if ranks < 1:
        raise DemlawsError(f"ranks = {ranks}: at least 1")
    environment = dict(os.environ)
    if plugin:
        versions()  # loaded into another LIGGGHTS, the plugin would crash it or worse
        environment["LD_PRELOAD"] = ":".join(p for p in (str(build(portable)), environment.get("LD_PRELOAD")) if p)
    line = [executable(), "-in", str(script), "-log", str(log)]
    for name, value in (variables or {}).items():
        line += ["-var", name, *(map(str, value) if isinstance(value, (list, tuple)) else [str(value)])]
    line += map(str, arguments)
    if ranks > 1:
        if not shutil.which("mpirun"):
            raise DemlawsError("mpirun not found: sudo apt install openmpi-bin")
        mpirun = ["mpirun", "-np", str(ranks)]
        if plugin:
            mpirun += ["-x", f"LD_PRELOAD={environment.pop('LD_PRELOAD')}"]  # for the ranks only, not for mpirun
        root = os.geteuid() == 0
        if root:
            mpirun += ["--allow-run-as-root"]
        if root or ranks > len(os.sched_getaffinity(0)):
            mpirun += ["--oversubscribe"]
        line = mpirun + line
    elif not any(name.startswith(("OMPI_COMM_", "PMIX_", "PMI_")) for name in environment):  # alone, not under an mpirun
        environment = ALONE | environment
    return line, environment


def run(
    script,
    ranks=1,
    variables=None,
    folder=None,
    log="log.liggghts",
    plugin=True,
    echo=False,
    timeout=None,
    portable=False,
    arguments=(),
):
    """Run `script` in `folder` (default: the script's own) and return what the thermo tables of its output hold.

    variables: {name: value} for the script's ${name}; echo: show LIGGGHTS's output as it comes; portable: the plugin
    without -march=native, for a cluster of unlike nodes; arguments: more of LIGGGHTS's own command line.
    Returns a dict column → array over all rows (see `read_log`); empty where the input has no run, or no thermo output.
    Raises DemlawsError with LIGGGHTS's own error.
    """
    script = Path(script)
    if folder is None:
        folder, script = script.resolve().parent, Path(script.name)
    if not (Path(folder) / script).is_file():
        raise DemlawsError(f"input {Path(folder) / script} does not exist; `demlaws liggghts export` writes one")
    line, environment = command(script, ranks, variables, log, plugin, portable, arguments)
    # a screen must stay: LIGGGHTS dies in mesh cases with -screen none
    status, lines = output(line, folder, environment, echo, timeout)
    if status:
        errors = [text.strip() for text in lines if text.startswith("ERROR")]
        reason = errors[-1] if errors else "".join(lines[-8:]).strip()
        raise EngineStopped(f"LIGGGHTS stopped (exit {status}): {reason}")
    return thermo(lines, _BEGINS)  # not of the log file: the input may have named another


_BEGINS = "Memory usage"
"""The line above a thermo table."""


def read_log(path):
    """Thermo output of a LIGGGHTS log: dict column → array, the rows of all runs one after another.

    Rows that a run repeats (its first step is the last one of the run before) are kept once; where the columns change,
    only the rows after the last change are returned.
    """
    return thermo_of_log(path, _BEGINS)


def timings(path):
    """(loop seconds, pair seconds) of the last run in a log."""
    text = Path(path).read_text(errors="replace")
    loop = re.findall(r"Loop time of (\S+)", text)
    pair = re.findall(r"Pair +time \(%\) = (\S+)", text)
    if not loop or not pair:
        raise DemlawsError(f"{path} holds no timing of a run")
    return float(loop[-1]), float(pair[-1])
