"""Start YADE on a script with this package importable."""

import functools
import glob
import os
import re
import shutil
import signal
import subprocess
import sys
from pathlib import Path

from demlaws.errors import DemlawsError, handling_signals, page

SCENES = tuple(name + packed for name in (".xml", ".yade", ".bin") for packed in ("", ".gz", ".bz2"))
"""How names of saved scenes end."""


def executable(name="yade"):
    """Path of yade (or yade-batch): the one that the variable YADE names, else `yade` on the path, else the one program
    there that is named as other builds of YADE are, `yade-…` or `yadedaily`.
    """
    wanted = os.environ.get("YADE")
    path = shutil.which(wanted or "yade")
    others = [] if path else other_builds()
    if path is None and not wanted and len(others) == 1:
        path = others[0]
    if path is None:
        there = f"; there is {', '.join(others)}: set YADE to one of them" if others else f": {remedy()}"
        raise DemlawsError(f"{wanted or 'yade'!r} not found{there}")
    if name != "yade":
        batch = shutil.which(f"{path}-batch")
        if batch is None:
            raise DemlawsError(f"'{path}-batch' not found: it belongs to {path}")
        return batch
    return path


PROGRAMS = ("yade", "yade-*", "yadedaily*")
"""How programs of Debian's package, of YADE's own builds and of its daily packages are named."""


def other_builds():
    """Paths of programs on the path with names of YADE.

    `…-batch` is another program, `….py` a link to the first that YADE's cmake installs.
    """
    found = {}
    for folder in map(glob.escape, os.get_exec_path()):  # glob passes over a folder that cannot be read, Path.glob may not
        for path in sorted(Path(file) for name in PROGRAMS for file in glob.glob(os.path.join(folder, name))):
            if not path.name.endswith(("-batch", ".py")) and os.access(path, os.X_OK) and path.is_file():
                found.setdefault(path.name, str(path))
    return list(found.values())


def remedy():
    """How YADE gets onto this system: by its package, where the lists of the system have one."""
    try:
        names = subprocess.run(["apt-cache", "pkgnames", "yade"], capture_output=True, text=True).stdout.split()
    except OSError:
        names = []
    package = "sudo apt install yade" if "yade" in names else f"this system has no package yade ({page('install')})"
    return f"{package}, or set YADE to its start script"


def interpreter_of(yade):
    """The Python program that a yade start script names in its first line, or None where it does not."""
    with open(yade, "rb") as script:
        first = script.readline().decode(errors="replace").strip()
    words = first.removeprefix("#!").split() if first.startswith("#!") else []
    return shutil.which(words[-1]) if words and "python" in os.path.basename(words[-1]) else None


@functools.lru_cache
def python_of(yade):
    """(major, minor) of the Python of a yade start script and the major version of its numpy, or None, asked without this
    process's environment; None where none answers.

    Of several installations of numpy the last one found is the system's, for which YADE is built.
    """
    interpreter = interpreter_of(yade)
    asked = (
        "import sys\nfrom importlib.metadata import distributions\n"
        "print(*sys.version_info[:2], *[d.version.split('.')[0] for d in distributions(name='numpy')][-1:])"
    )
    if interpreter is None:
        return None
    answer = subprocess.run([interpreter, "-Ic", asked], capture_output=True, text=True).stdout.split()
    numbers = [int(word) for word in answer if word.isdigit()]
    return (tuple(numbers[:2]), next(iter(numbers[2:]), None)) if len(numbers) > 1 else None


def environment():
    """Environment in which YADE's Python finds this package and the numba and numpy that it runs on."""
    import numba
    import numpy

    import demlaws

    python, of_yade = python_of(executable()) or (None, None)
    if python is not None and python != sys.version_info[:2]:
        version = ".".join(map(str, python))
        raise DemlawsError(
            f"{executable()} runs on Python {version}, this is {sys.version_info[0]}.{sys.version_info[1]}: install "
            f"demlaws in a venv of that Python ({interpreter_of(executable())} -m venv --system-site-packages)"
        )
    if of_yade is not None and int(numpy.__version__.split(".")[0]) > of_yade:
        raise DemlawsError(
            f"{executable()} is built for numpy {of_yade}, this is numpy {numpy.__version__}: "
            f"pip install 'numpy<{of_yade + 1}' in this venv"
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


def exec_yade(line):
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
