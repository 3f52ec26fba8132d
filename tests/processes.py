"""Programs in processes of their own: Python, how many functions numba compiled there, ranks in folders of their own."""

import contextlib
import os
import signal
import subprocess
import sys
import textwrap
from pathlib import Path

import demlaws

PACKAGE = Path(demlaws.__file__).parent

COUNT = """
from numba.core import event

class Count(event.Listener):
    compiled = []
    def on_start(self, e):
        self.compiled.append(str(e.data.get("dispatcher")))
    def on_end(self, e):
        pass

event.register("numba:compile", Count())
"""


def counted(code):
    """The program, in which numba tells `Count.compiled` of whatever it compiles."""
    return COUNT + textwrap.dedent(code)


def start(code, folder=PACKAGE.parent, **changes):
    """The program at work, with the package that lies in `folder` and these changes to the environment (None: not set)."""
    environment = {**os.environ, "PYTHONPATH": str(folder), **changes}
    return subprocess.Popen(
        [sys.executable, "-c", textwrap.dedent(code)],
        env={name: str(value) for name, value in environment.items() if value is not None},
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def finish(process):
    """What it has printed; it must end without an error."""
    out, error = process.communicate(timeout=600)
    assert process.returncode == 0, error
    return out.strip()


def python(code, folder=PACKAGE.parent, **changes):
    """What a program prints."""
    return finish(start(code, folder, **changes))


def parted(line, program, folder, rank=1):
    """A command line of mpirun of which one rank is in another folder, where none of the files are."""
    (folder / "elsewhere").mkdir()
    script = folder / "start.sh"
    script.write_text(f'#!/bin/sh\n[ "${{PMI_RANK:-$OMPI_COMM_WORLD_RANK}}" = {rank} ] && cd elsewhere\nexec "$@"\n')
    script.chmod(0o755)
    place = line.index(str(program))
    return [*line[:place], str(script), *line[place:]]


def usual_signals():
    """`preexec_fn` of a process that signals are to end: under nohup, and in the background, it would ignore them."""
    for number in (signal.SIGINT, signal.SIGHUP, signal.SIGTERM):
        signal.signal(number, signal.SIG_DFL)


def shared_memory():
    """Files of MPICH's processes."""
    return set(Path("/dev/shm").glob("mpich_shm_*_*"))


def remove_shared_memory(before):
    """Remove what processes of MPICH of this run left when they were killed: no later one of the same number could start.

    before: files of other programs; nor are those removed that a living process uses.
    """
    for file in shared_memory() - before:
        with contextlib.suppress(OSError):  # of another user, or removed by another process of the tests
            maps = (maps for maps in Path("/proc").glob("[0-9]*/maps") if os.access(maps, os.R_OK))
            if not any(str(file) in _text_of(each) for each in maps):
                file.unlink()


def _text_of(path):
    try:
        return path.read_text(errors="replace")
    except OSError:  # the process has ended
        return ""
