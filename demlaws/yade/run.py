"""Start YADE on a script with this package importable."""

import contextlib
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


def _signal_name(number):
    """Name and meaning of a signal."""
    try:
        return f"signal {signal.Signals(number).name} ({signal.strsignal(number)})"
    except ValueError:
        return f"signal {number}"


FAILED = re.compile(r"#\d+ \(.*\) FAILED ")
"""How a line of yade-batch about a job that failed begins; its own exit status is 0 nevertheless."""


def run(script, arguments=(), threads=1, *, gui=False, batch=None, stay=False, yade_options=(), **options):
    """Run a script under YADE; returns the `subprocess.CompletedProcess`, whatever its exit status (a batch of which a job has
    failed: 1). Signals that would end or interrupt this process go to YADE."""
    line = command(script, arguments, threads, gui=gui, batch=batch, stay=stay, options=yade_options)
    if batch is None or options:
        return _told(_run(line, env=environment(), **options))
    failed = 0
    unbuffered = environment() | {"PYTHONUNBUFFERED": "1"}
    with (
        subprocess.Popen(line, env=unbuffered, stdout=subprocess.PIPE, text=True, start_new_session=True) as process,
        _signals_to(process.pid, os.killpg),  # its jobs, too
    ):
        for text in process.stdout:
            print(text, end="", flush=True)
            failed += FAILED.match(text) is not None
    if failed:
        print(f"demlaws: {failed} of the jobs failed: their lines above name the log files", file=sys.stderr)
    return _told(subprocess.CompletedProcess(line, process.returncode or int(failed > 0)))


def _told(done):
    """A process that has ended, whose signal, if one has ended it, is printed; its status is then that of a shell."""
    if done.returncode < 0:
        print(f"demlaws: YADE was ended by {_signal_name(-done.returncode)}", file=sys.stderr)
        done.returncode = 128 - done.returncode
    return done


def _run(line, *, capture_output=False, timeout=None, **options):
    """`subprocess.run`, of a process that gets the signals of this one."""
    if capture_output:
        options |= {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with subprocess.Popen(line, **options) as process, _signals_to(process.pid, os.kill):
        try:
            out, error = process.communicate(timeout=timeout)
        except BaseException:
            process.kill()
            raise
    return subprocess.CompletedProcess(line, process.returncode, out, error)


def _signals_to(process, send):
    """Signals that would end or interrupt this process are sent to another one, unless a terminal has sent them to both."""

    def pass_on(number, frame):
        if number != signal.SIGINT or send is os.killpg or not _in_foreground():
            with contextlib.suppress(ProcessLookupError):
                send(process, number)

    return handling_signals(pass_on, signal.SIGTERM, signal.SIGHUP, signal.SIGINT)


def _in_foreground():
    """Whether this process has a terminal whose Ctrl-C goes to all processes of its group."""
    try:
        terminal = os.open("/dev/tty", os.O_RDONLY)
    except OSError:
        return False
    try:
        return os.tcgetpgrp(terminal) == os.getpgrp()
    finally:
        os.close(terminal)
