"""Start YADE on a script with this package importable."""

import importlib.metadata
import os
import re
import shutil
import signal
import subprocess
import sys
from pathlib import Path

from demlaws.errors import DemlawsError, handling_signals

INSTALL = "sudo apt install yade, or set YADE to its start script"
SCENES = tuple(name + packed for name in (".xml", ".yade", ".bin") for packed in ("", ".gz", ".bz2"))
"""How names of saved scenes end."""


def executable(name="yade"):
    """Path of the system's yade (or yade-batch); the environment variable YADE names another."""
    command = os.environ.get("YADE") or "yade"
    path = shutil.which(command)
    if path is None:
        raise DemlawsError(f"{command!r} not found: {INSTALL}")
    if name != "yade":
        batch = shutil.which(f"{path}-batch")
        if batch is None:
            raise DemlawsError(f"'{path}-batch' not found: {INSTALL}")
        return batch
    return path


def python_of(yade):
    """(major, minor) of the Python that a yade start script asks for in its first line, or None where it does not say."""
    with open(yade, "rb") as script:
        first = script.readline().decode(errors="replace").strip()
    interpreter = first.removeprefix("#!").split()[-1] if first.startswith("#!") else ""
    version = os.path.basename(os.path.realpath(interpreter or "/"))  # /usr/bin/python3 is a link
    version = version.removeprefix("python").split(".")
    return tuple(int(part) for part in version) if len(version) == 2 and all(part.isdigit() for part in version) else None


def numpy_built_for(folder="/usr/lib/python3/dist-packages"):
    """Major version of the numpy that the system's Python packages, YADE among them, are built for; None if there is none."""
    versions = [d.version for d in importlib.metadata.distributions(name="numpy", path=[folder])]
    return int(versions[0].split(".")[0]) if versions else None


def environment():
    """Environment in which YADE's Python finds this package and the numba and numpy that it runs on."""
    import numba
    import numpy

    import demlaws

    version = python_of(executable())
    if version is not None and version != sys.version_info[:2]:
        raise DemlawsError(
            f"YADE runs on Python {version[0]}.{version[1]}, this is {sys.version_info[0]}.{sys.version_info[1]}: install "
            "demlaws in a venv of that Python (/usr/bin/python3 -m venv --system-site-packages)"
        )
    system_major, major = numpy_built_for(), int(numpy.__version__.split(".")[0])
    if system_major is not None and major > system_major:
        raise DemlawsError(
            f"this system's YADE is built for numpy {system_major}, this is numpy {numpy.__version__}: "
            f"pip install 'numpy<{system_major + 1}' in this venv"
        )
    folders = []
    for module in (demlaws, numba, numpy):
        folder = str(Path(module.__file__).resolve().parent.parent)
        if folder not in folders and not folder.startswith("/usr/lib/python3"):
            folders.append(folder)
    folders.insert(0, str(Path(__file__).parent / "startup"))
    old = os.environ.get("PYTHONPATH")
    return {**os.environ, "PYTHONPATH": os.pathsep.join([*folders, *([old] if old else [])])}


def command(script, arguments=(), threads=1, *, gui=False, batch=None, stay=False, options=()):
    """The command line that runs `script`.

    gui: with the graphical interface; batch: a parameter table for yade-batch; stay: keep the interpreter when the script has
    ended, as `yade` does by itself; options: further options of yade (or yade-batch).
    """
    script = str(script)
    if not os.path.isfile(script):
        raise DemlawsError(f"no script {script}" + (": this is a folder" if os.path.isdir(script) else ""))
    if not script.endswith((".py", *SCENES)):
        raise DemlawsError(
            f"{script}: YADE runs scripts named *.py and saved scenes (*.xml, *.yade, *.bin, each also with .gz or .bz2); "
            "it ignores other files silently: give this one such a name"
        )
    if batch is not None:
        if not os.path.exists(batch):
            raise DemlawsError(f"no parameter table {batch}")
        if arguments:
            raise DemlawsError("a batch takes its parameters from the table, not from arguments")
        return [executable("yade-batch"), f"--job-threads={threads}", *options, batch, script]
    ours = [*([] if gui else ["-n"]), *([] if stay else ["-x"]), f"-j{threads}"]
    return [executable(), *ours, *options, script, *map(str, arguments)]


FAILED = re.compile(r"#\d+ \(.*\) FAILED ")
"""How a line of yade-batch about a job that failed begins; its own exit status is 0 nevertheless."""


def run(script, arguments=(), threads=1, **options):
    """Run a script under YADE: the `subprocess.CompletedProcess`, whatever its exit status; options: of `subprocess.run`."""
    return subprocess.run(command(script, arguments, threads), env=environment(), **options)


def become(line):
    """Replace this process by one of a command line of YADE, which then gets the signals, and whose exit status counts."""
    variables = environment()
    sys.stdout.flush()
    os.execvpe(line[0], line, variables)


def run_batch(line):
    """Run a command line of yade-batch; returns its exit status, 1 if a job has failed. Signals go to it and its jobs."""
    failed = 0
    unbuffered = environment() | {"PYTHONUNBUFFERED": "1"}
    with (
        subprocess.Popen(line, env=unbuffered, stdout=subprocess.PIPE, text=True, start_new_session=True) as process,
        handling_signals(lambda number, _: os.killpg(process.pid, number), signal.SIGTERM, signal.SIGHUP, signal.SIGINT),
    ):
        for text in process.stdout:
            print(text, end="", flush=True)
            failed += FAILED.match(text) is not None
    if failed:
        print(f"demlaws: {failed} of the jobs failed: their lines above name the log files", file=sys.stderr)
    return process.returncode or int(failed > 0)
