"""Folders for machine code, each named by the content of all that the code depends on.

numba's cache (`cache=True`) notices a change of the file that a loop is in, not of the kernels that the loop inlines: it is
given a folder for each loop and types of its arguments, in which processes that write at once write the same. No folder is
removed: `demlaws-…` of former versions may be deleted at any time.
"""

import contextlib
import functools
import os
import sys
import tempfile
from pathlib import Path

import llvmlite.binding
import numba

from demlaws.core.content import dependencies, digest, file_digest
from demlaws.core.content import source_digest as source_digest

_CORE = [
    (f"{file.parent.name}/{file.name}", file_digest(file))
    for folder in ("core", "laws")
    for file in sorted(Path(__file__).parents[1].glob(f"{folder}/*.py"))
]


@functools.cache
def _common_folder():
    """Where machine code is kept, one folder per processor and version of core and laws: below NUMBA_CACHE_DIR, else beside
    this file, else in the user's cache. None where none of them may be written."""
    processor = llvmlite.binding.get_host_cpu_name(), llvmlite.binding.get_host_cpu_features().flatten()
    settings = numba.__version__, sys.implementation.cache_tag, numba.config.CPU_NAME, numba.config.CPU_FEATURES
    name = f"demlaws-{digest(*processor, *settings, *_CORE)[:16]}"
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
    """
    keys = dependencies(function, kinds, constants)
    if keys is None or _common_folder() is None:
        return None
    return _common_folder() / f"{function.__qualname__}-{digest(kinds, *keys)[:24]}"
