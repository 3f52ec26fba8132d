"""A folder for machine code, in files named by the content of all that the code depends on.

numba's cache (`cache=True`) keeps machine code beside the file that a function is in, or below NUMBA_CACHE_DIR in a folder
named by that file's, and notices a change of this file, not of the kernels that a loop inlines. So a loop is compiled as if it
were in a file of this folder, under a name of its own for it and the types of its arguments. numba keeps no checksum, and
damaged machine code gives wrong numbers or ends the process: digests of its files are kept beside them. No setting of numba is
changed: other threads share it. No folder is removed: `demlaws-…` of former versions may be deleted at any time.
"""

import contextlib
import fcntl
import functools
import itertools
import os
import sys
import tempfile
from hashlib import sha256
from pathlib import Path
from types import FunctionType

import llvmlite.binding
import numba
import numpy as np

_PACKAGE = Path(__file__).parents[1]
_SHARED = ("core", "laws", "solvers", "curves")
"""Folders of the package whose functions are compiled into those of others."""
_KNOWN = {"demlaws", "numba", "numpy", "math", "cmath", "builtins", "operator", "typing"}
"""Packages whose functions are identified by their names: the digest of its files, or numba's version, stands for the rest."""
UNKNOWN = "unknown"
"""In the names of types that each process compiles again."""
_MOST = 3000
"""Machine codes that are kept, the newest (about 0.1 MB each): a program may define laws without end."""
_count = itertools.count(1)


@functools.cache
def _common_folder():
    """Where machine code is kept, one folder per processor and version of the package's kernels: below NUMBA_CACHE_DIR, else
    beside this file, else in the user's cache. None where none of them may be written."""
    processor = llvmlite.binding.get_host_cpu_name(), llvmlite.binding.get_host_cpu_features().flatten()
    settings = numba.__version__, sys.implementation.cache_tag, numba.config.CPU_NAME, numba.config.CPU_FEATURES
    shared = digest(*map(_folder_digest, (_PACKAGE / name for name in _SHARED)))  # a process runs one version of them
    name = f"demlaws-{digest(*processor, *settings, shared)[:16]}"
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


def name_of(function, kinds, constants):
    """Name for the machine code of a function for arguments of these numba types, with these values (a dict) of its globals;
    None if the code must be compiled in every process: something that it depends on is unknown, or no folder may be written.
    The names of users' types contain what their kernels depend on (`tag_of`).
    """
    arguments = repr((kinds, constants))
    if (function.__module__ or "").startswith("demlaws."):  # with the files beside it
        loop = _folder_digest(Path(sys.modules[function.__module__].__file__).parent)
    else:
        loop = content_key(function)
    if loop is None or UNKNOWN in arguments or _common_folder() is None:
        return None
    return f"{function.__name__}_{digest(function.__qualname__, loop, arguments)[:24]}"


def is_whole(name):
    """Whether the machine code of this name is kept, every byte as it was written."""
    try:
        lines = _digests(name).read_text().splitlines()
        return bool(lines) and all(_file_digest(_common_folder().parent / file) == key for key, file in map(str.split, lines))
    except (OSError, ValueError):
        return False


def _digests(name):
    return _common_folder() / f"{name}.digests"


@contextlib.contextmanager
def placed(function, name, whole=False):
    """The same function as if it were of this name in a file of the folder, whose machine code numba loads or keeps within this
    block; other processes that want the same code wait. Damaged or half-written files are removed before.

    whole: `is_whole` has just said so.
    """
    folder = _common_folder()
    if whole:
        yield _as_in_file(function, name)
        return
    with open(folder / "lock", "ab") as lock:
        with contextlib.suppress(OSError):  # a file system without locks: they compile at the same time
            fcntl.lockf(lock, fcntl.LOCK_EX, 1, int(digest(name)[:15], 16))  # one byte for each name
        if is_whole(name):
            yield _as_in_file(function, name)
            return
        _remove(name)
        yield _as_in_file(function, name)
        kept = {file.relative_to(folder.parent): _file_digest(file) for file in _files(f"demlaws.{name}-*")}
        _digests(name).write_text("".join(f"{key} {file}\n" for file, key in kept.items()))
        for old in sorted(folder.glob("*.digests"), key=os.path.getmtime)[:-_MOST]:
            _remove(old.stem)


def _files(pattern):
    """Files of numba's in the folder: in its __pycache__, or in one beside it that is named by it (NUMBA_CACHE_DIR)."""
    folder = _common_folder()
    return [file for place in folder.parent.glob(f"{folder.name}*") for file in place.rglob(pattern)]


def _remove(name):
    for file in _files(f"*{name}*"):
        file.unlink(missing_ok=True)


def _as_in_file(function, name):
    file = _common_folder() / "demlaws.py"
    if not file.exists():
        file.touch()
        os.utime(file, (0, 0))  # some versions of numba compare its time
    code = function.__code__.replace(co_filename=str(file))
    copy = FunctionType(code, function.__globals__, name, function.__defaults__, function.__closure__)
    copy.__qualname__, copy.__module__ = name, function.__module__
    return copy


# --- what machine code depends on


def digest(*contents):
    """SHA-256 of bytes, and of the text of anything else, in hexadecimal."""
    return sha256(b"\0".join(c if isinstance(c, bytes) else repr(c).encode() for c in contents)).hexdigest()


@functools.cache
def _folder_digest(folder):
    return digest(*(part for file in sorted(folder.glob("*.py")) for part in (file.name, file.read_bytes())))


def is_known(module):
    """Whether functions of this module are identified by their names."""
    return (module or "").partition(".")[0] in _KNOWN


def tag_of(*things):
    """Text for the name of a user's type, whose machine code on disk depends on these functions and values.

    It is computed when the type is made: the file may be edited before a loop is compiled, and a notebook has none.
    """
    key = content_key(things)
    return f"{UNKNOWN}{next(_count)}" if key is None else digest(key)[:16]


def content_key(thing):
    """Text that identifies a value or a function, with all that it calls or uses, for compiled code; None if unknown.

    Users' helpers that numba compiled for Python are compiled again where a global that they use has changed.
    """
    seen = {}
    key = _key(thing, seen)
    for helper in seen.values():
        if hasattr(helper, "recompile"):
            own = _key(helper, {})
            if getattr(helper, "demlaws_key", own) != own:
                helper.recompile()
            helper.demlaws_key = own
    return key


def _key(thing, seen):
    """seen: functions met so far (function → what holds it); one that is met again is named by its number."""
    if isinstance(thing, (bool, int, float, complex, str, bytes, type(None), np.generic, np.dtype, numba.types.Type)):
        return repr(thing)
    if isinstance(thing, np.ndarray):
        return None if thing.dtype.hasobject else digest(str(thing.dtype), thing.shape, np.ascontiguousarray(thing).tobytes())
    if isinstance(thing, tuple | list | dict):
        parts = [_key(part, seen) for part in (thing.items() if isinstance(thing, dict) else thing)]
        return None if None in parts else f"{type(thing).__qualname__}({','.join(parts)})"
    function = getattr(thing, "py_func", None) or getattr(thing, "_defn", None) or thing  # of a dispatcher, an intrinsic
    module, code = getattr(function, "__module__", None), getattr(function, "__code__", None)
    if isinstance(thing, type):
        file = None if is_known(module) else _file_digest(getattr(sys.modules.get(module), "__file__", None))
        return f"{module}.{thing.__qualname__}{getattr(thing, '_fields', '')}{file}"
    if isinstance(thing, np.ufunc) or (is_known(module) and not getattr(function, "__closure__", None)):
        return f"{module}.{getattr(function, '__qualname__', repr(function))}"
    if code is None or function in seen:
        return None if code is None else f"function {list(seen).index(function)}"
    seen[function] = thing
    parts = _parts_of_function(function, code, seen)
    return None if None in parts else digest(*parts)


def _parts_of_function(function, code, seen):
    module = function.__module__  # numba imports it where it loads the code; a law file's is named by its place
    if module is not None and module not in sys.modules:
        return [None]
    # the whole file as well: the code of a numba stub does not identify its implementation
    parts = [_code_digest(code), _file_digest(code.co_filename), str(module), _key(function.__defaults__, seen)]
    parts += [_key(cell.cell_contents, seen) for cell in function.__closure__ or ()]
    names = sorted(_names(code))
    for value in (function.__globals__[name] for name in names if name in function.__globals__):
        if not isinstance(value, type(sys)):
            parts.append(_key(value, seen))
        elif not is_known(value.__name__):
            parts += [_key(getattr(value, name), seen) for name in names if hasattr(value, name)]
    return parts


def _file_digest(file):
    """Digest of a file, or a text for a missing file."""
    try:
        return digest(Path(file).read_bytes())
    except (OSError, TypeError):
        return "no file"


def _names(code):
    """Names of globals and attributes that a function, or one inside it, uses."""
    return set(code.co_names).union(*(_names(constant) for constant in code.co_consts if isinstance(constant, type(code))))


def _code_digest(code):
    constants = [_code_digest(c) if isinstance(c, type(code)) else repr(c) for c in code.co_consts]
    return digest(code.co_code, code.co_names, code.co_varnames, code.co_freevars, *constants)
