"""Start YADE on a script with this package importable."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

from demlaws.errors import DemlawsError

INSTALL = "install it with `sudo apt install yade`"


def executable(name="yade"):
    """Path of Debian's yade (or yade-batch); the environment variable YADE names another."""
    chosen = os.environ.get("YADE") or "yade"
    path = shutil.which(chosen)
    if path is None:
        raise DemlawsError(f"no {chosen!r} command was found: {INSTALL}")
    if name != "yade":
        batch = shutil.which(f"{path}-batch")
        if batch is None:
            raise DemlawsError(f"no {path}-batch command was found: {INSTALL}")
        return batch
    return path


def python_of(yade):
    """(major, minor) of the Python that a yade start script asks for in its first line, or None where it does not say."""
    with open(yade, "rb") as script:
        first = script.readline().decode(errors="replace").strip()
    interpreter = first.removeprefix("#!").split()[-1] if first.startswith("#!") else ""
    version = os.path.basename(interpreter).removeprefix("python").split(".")
    return tuple(int(part) for part in version) if len(version) == 2 and all(part.isdigit() for part in version) else None


def environment():
    """Environment in which YADE's Python finds this package and the numba and numpy that it runs on."""
    import numba
    import numpy

    import demlaws

    wanted = python_of(executable())
    if wanted is not None and wanted != sys.version_info[:2]:
        raise DemlawsError(
            f"YADE runs on Python {wanted[0]}.{wanted[1]}, this is {sys.version_info[0]}.{sys.version_info[1]}: install "
            "demlaws in a venv of that Python (/usr/bin/python3 -m venv --system-site-packages)"
        )
    if int(numpy.__version__.split(".")[0]) >= 2:
        raise DemlawsError(
            f"Debian's YADE needs numpy 1, this is numpy {numpy.__version__}: pip install 'numpy<2' in this venv"
        )
    folders = []
    for module in (demlaws, numba, numpy):
        folder = str(Path(module.__file__).resolve().parent.parent)
        if folder not in folders and not folder.startswith("/usr/lib/python3"):
            folders.append(folder)
    old = os.environ.get("PYTHONPATH")
    return {**os.environ, "PYTHONPATH": os.pathsep.join([*folders, *([old] if old else [])])}


def command(script, arguments=(), threads=1, gui=False, batch=None):
    """The command line that runs `script`."""
    script = str(script)
    if not os.path.exists(script):
        raise DemlawsError(f"no script {script}")
    if batch is not None:
        if not os.path.exists(batch):
            raise DemlawsError(f"no parameter table {batch}")
        if arguments:
            raise DemlawsError("a batch takes its parameters from the table, not from arguments")
        return [executable("yade-batch"), f"--job-threads={threads}", batch, script]
    return [executable(), *([] if gui else ["-n"]), "-x", f"-j{threads}", script, *map(str, arguments)]


def run(script, arguments=(), threads=1, gui=False, batch=None, **options):
    """Run a script under YADE; returns the `subprocess.CompletedProcess`, whatever its exit status."""
    line = command(script, arguments, threads, gui, batch)
    return subprocess.run(line, env=environment(), check=False, **options)
