"""Folders for machine code, each named by the content of all that the code depends on.

numba's cache (`cache=True`) keeps machine code beside the file that a function is in, or below NUMBA_CACHE_DIR in a folder
named by that file's, and notices a change of this file, not of the kernels that a loop inlines. So a loop is compiled as if it
were in a file of its own, in a folder for it and the types of its arguments; processes that write at once write the same there.
No setting of numba is changed: other threads share it. No folder is removed: `demlaws-…` of former versions may be deleted at
any time.
"""

import contextlib
import functools
import os
import sys
import tempfile
from pathlib import Path
from types import FunctionType

import llvmlite.binding
import numba

from demlaws.core.content import UNKNOWN, digest, digest_of_loop, shared_digest


@functools.cache
def _common_folder():
    """Where machine code is kept, one folder per processor and version of the package's kernels: below NUMBA_CACHE_DIR, else
    beside this file, else in the user's cache. None where none of them may be written."""
    processor = llvmlite.binding.get_host_cpu_name(), llvmlite.binding.get_host_cpu_features().flatten()
    settings = numba.__version__, sys.implementation.cache_tag, numba.config.CPU_NAME, numba.config.CPU_FEATURES
    name = f"demlaws-{digest(*processor, *settings, shared_digest())[:16]}"
    places = [numba.config.CACHE_DIR] if numba.config.CACHE_DIR else [Path(__file__).parent / "__pycache__"]
    if not numba.config.CACHE_DIR:
        with contextlib.suppress(RuntimeError):  # in a container a user may have neither a HOME nor a name
            places.append(Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache", "demlaws"))
    return next((folder for folder in (Path(place, name) for place in places) if _is_writable(folder)), None)


def _is_writable(folder):
    try:
        folder.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=folder).close()
    except OSError:
        return False
    return True


def folder_of(function, kinds, constants):
    """Folder for the machine code of a function for arguments of these numba types, with these values (a dict) of its globals;
    None if the code must be compiled in every process: something that it depends on is unknown, or no folder may be written.
    The names of users' types contain what their kernels depend on (`content.tag_of`).
    """
    loop, arguments = digest_of_loop(function), repr((kinds, constants))
    if loop is None or UNKNOWN in arguments or _common_folder() is None:
        return None
    return _common_folder() / f"{function.__qualname__}-{digest(loop, arguments)[:24]}"


def _file_of(function, folder):
    return folder / f"{function.__name__}.py"


def is_placed(function, folder):
    """Whether a process has placed the function in this folder before: its machine code is there, or being compiled."""
    return _file_of(function, folder).exists()


def placed(function, folder):
    """The same function as if it were in a file of this folder, which is made: numba keeps its machine code there.

    The file is the same wherever it is made, so that code which another process kept is found again.
    """
    file = _file_of(function, folder)
    if not file.exists():
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile("w", dir=folder, delete=False) as temporary:
            temporary.write(f"# Machine code of {function.__module__}.{function.__qualname__} is kept beside this file.\n")
        os.utime(temporary.name, (0, 0))
        os.replace(temporary.name, file)
    code = function.__code__.replace(co_filename=str(file))
    copy = FunctionType(code, function.__globals__, function.__name__, function.__defaults__, function.__closure__)
    copy.__qualname__, copy.__module__ = function.__qualname__, function.__module__
    return copy


def discard(function):
    """Remove the index of the machine code that numba kept of a function: it is compiled again."""
    with contextlib.suppress(OSError, RuntimeError):
        for index in Path(numba.njit(cache=True)(function).stats.cache_path).glob("*.nbi"):
            index.unlink(missing_ok=True)
