"""Machine code on disk: compiled loops are loaded by every later process unless their source has changed."""

import contextlib
import ctypes
import functools
import mmap
import os
import pickle
import shutil
import signal
import sys
import tempfile
import threading
import time
import warnings
from hashlib import sha256
from pathlib import Path

import numba
import numpy as np
from numba import types


def _digest(*contents):
    return sha256(b"\0".join(c if isinstance(c, bytes) else repr(c).encode() for c in contents)).hexdigest()


def _core_tag():
    """Digest of everything that a cached loop may have inlined, by content: equal checkouts have equal tags."""
    folder = Path(__file__).parent
    files = sorted([*folder.glob("*.py"), *folder.parent.glob("laws/*.py")])
    return _digest(numba.__version__, *(f"{f.parent.name}/{f.name}".encode() + f.read_bytes() for f in files))[:16]


_TAG = _core_tag()
_UNUSED = 86400.0  # [s] after which another version's folder is taken for abandoned


def _cache_folder():
    """Where machine code is kept, one folder a version of the core: below NUMBA_CACHE_DIR, else beside this file, else in
    the user's own cache. None where none of them may be written."""
    places = (numba.config.CACHE_DIR,) if numba.config.CACHE_DIR else (Path(__file__).parent / "__pycache__", *_of_user())
    for place in places:
        folder = Path(place, f"loops-{_TAG}-{sys.implementation.cache_tag}")
        try:
            new = not folder.is_dir()
            folder.mkdir(parents=True, exist_ok=True)
            tempfile.TemporaryFile(dir=folder).close()  # may be written; and marks the folder as used now
        except OSError:
            continue
        if new:
            _remove_abandoned(folder)
        return folder
    return None


def _of_user():
    """The user's own cache, if there is one: in a container a user may have neither a HOME nor a name."""
    with contextlib.suppress(RuntimeError):
        yield Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache", "demlaws")


def _remove_abandoned(folder):
    """Remove the machine code of versions that no process has used for a day: one that has just been written may belong to
    another checkout, or to a process that is still at work with the files that this one has replaced."""
    for other in folder.parent.glob("loops-*"):
        with contextlib.suppress(OSError):
            if other != folder and time.time() - other.stat().st_mtime > _UNUSED:
                shutil.rmtree(other, ignore_errors=True)


FOLDER = _cache_folder()
_SOURCES = {}  # NamedTuple that kernels are bound to → digests of these, None among them where one cannot be known again
_OURS = ("numba", "numpy", "math", "cmath", "builtins", "operator", "typing", "demlaws.core", "demlaws.laws")
"""Modules that the folder's name stands for, or whose functions do not change while this version of numba is installed."""


def follow(cls, *functions):
    """Machine code made for arguments whose type is the NamedTuple `cls` is good only as long as these compiled functions, all
    that they call or use as a global, and the file that defines the class stay as they are.

    Read now, not when a loop is compiled: the file may have been edited meanwhile, and a notebook has none. Code of the core
    and the laws is followed anyway. Returns a digest of all that, or None where something in it cannot be known again.
    """
    digests = _SOURCES.setdefault(cls, set())
    if not is_ours(cls.__module__):
        digests.add(_file_digest(getattr(sys.modules.get(cls.__module__), "__file__", None)) or f"fields {cls._fields}")
    for function in functions:
        digests.add(_meaning(function, set()))
    return None if None in digests else _digest(*sorted(digests))


def digest_of(*functions):
    """Digest of functions: their code and everything that they call or use; None if it cannot be determined."""
    parts = [_meaning(function, set()) for function in functions]
    return None if None in parts else _digest(*parts)


def is_ours(module):
    """Whether the name of the cache's folder stands for what this module holds."""
    return module in _OURS or (module or "").startswith(tuple(f"{name}." for name in _OURS))


def _meaning(thing, ids):
    """Text that identifies a function or a global for compiled code; None if it cannot be identified."""
    if isinstance(thing, (bool, int, float, complex, str, bytes, type(None), np.generic)):
        return repr(thing)
    if isinstance(thing, np.ndarray):
        return None if thing.dtype.hasobject else _digest(str(thing.dtype), thing.shape, np.ascontiguousarray(thing).tobytes())
    if isinstance(thing, tuple | list):
        parts = [_meaning(part, ids) for part in thing]
        return None if None in parts else f"{type(thing).__qualname__}({','.join(parts)})"
    if isinstance(thing, dict):
        return _meaning([*thing, *thing.values()], ids)
    if isinstance(thing, types.Type):
        return repr(thing)
    function = getattr(thing, "py_func", None) or getattr(thing, "_defn", None) or thing  # of a dispatcher, an intrinsic
    module = getattr(function, "__module__", None)
    if isinstance(thing, type):
        return f"{module}.{thing.__qualname__}{getattr(thing, '_fields', '')}"
    closure = getattr(function, "__closure__", None) or ()
    if (is_ours(module) and not closure) or isinstance(thing, np.ufunc):
        return f"{module}.{getattr(function, '__qualname__', repr(function))}"
    code = getattr(function, "__code__", None)
    if code is None:
        return None
    if id(function) in ids:
        return "itself"
    ids.add(id(function))
    # the whole file as well: the code of a numba stub does not identify its implementation
    parts = [_code_digest(code), _file_digest(code.co_filename) or "no file", _meaning(function.__defaults__, ids)]
    parts += [_meaning(cell.cell_contents, ids) for cell in closure]
    names = sorted(_names(code))
    for name in names:
        if name in function.__globals__:
            value = function.__globals__[name]
            if isinstance(value, type(sys)):
                ours = is_ours(value.__name__)
                parts += [] if ours else [_meaning(getattr(value, n), ids) for n in names if hasattr(value, n)]
            else:
                parts.append(_meaning(value, ids))
    meaning = None if None in parts else _digest(*parts)
    if function is not thing and hasattr(thing, "recompile"):  # a user's helper whose globals may have changed
        if getattr(thing, "demlaws_meaning", meaning) != meaning:
            thing.recompile()
        thing.demlaws_meaning = meaning
    return meaning


def _names(code):
    """Names of globals and attributes that a function, or one inside it, uses."""
    inside = [constant for constant in code.co_consts if isinstance(constant, type(code))]
    return set(code.co_names).union(*map(_names, inside))


def _code_digest(code):
    constants = [_code_digest(c) if isinstance(c, type(code)) else repr(c) for c in code.co_consts]
    return _digest(code.co_code, code.co_names, code.co_varnames, code.co_freevars, *constants)


def _file_digest(file):
    """Digest of a file; None if it does not exist."""
    try:
        return _digest(Path(file).read_bytes())
    except (OSError, TypeError):
        return None


source_digest = functools.cache(_file_digest)  # of the file of a loop: a process runs one version of it


def classes(kinds):
    """The NamedTuples in (nested) tuples of numba types, also where a type itself is the argument."""
    for kind in kinds:
        kind = getattr(kind, "instance_type", kind)
        if isinstance(kind, types.BaseNamedTuple):
            yield kind.instance_class
        if isinstance(kind, types.BaseTuple):
            yield from classes(kind)


@functools.cache
def _files_behind(name):
    """Files of the package, other than core and laws, from which a module takes functions or constants, directly or not."""
    files, todo = set(), [name]
    while todo:
        module = sys.modules.get(todo.pop())
        file = getattr(module, "__file__", None)
        if module is None or not module.__name__.startswith("demlaws.") or module.__name__.startswith(_OURS) or file in files:
            continue
        files.add(file)
        todo += {getattr(value, "__module__", None) or getattr(value, "__name__", None) for value in vars(module).values()}
    return frozenset(files)


def place(function, key, arguments, constants):
    """The file for the machine code of a function for arguments of these types; None if the code cannot be known again.

    There is one file for each function and types of its arguments. Its name is a digest of all that the code depends on:
    version of numba, content of core and laws (in the folder's name), content of the function's file and of the files of the
    package behind it, of any law from elsewhere and of what that uses, types, processor. numba's own cache knows nothing of
    what a loop inlines.
    """
    code = function.__code__
    kinds = [*classes(arguments), *classes(constants.values())]
    names = [(cls.__module__, cls.__qualname__, cls.__name__) for cls in kinds]
    for cls in kinds:
        if cls not in _SOURCES:  # part of a law's params, bound to nothing itself
            follow(cls)
    digests = {*map(source_digest, _files_behind(function.__module__)), source_digest(code.co_filename)}
    sources = sorted(digests.union(*(_SOURCES[cls] for cls in kinds)), key=str)
    closure = _meaning([cell.cell_contents for cell in function.__closure__ or ()], set())
    if None in (closure, *sources):
        return None
    name = f"{Path(code.co_filename).stem}.{function.__qualname__.replace('<', '').replace('>', '')}"
    return FOLDER / f"{name}-{_digest(key, names, sources, code.co_code, closure, constants)[:32]}.nbc"


def read(path):
    """What `write` wrote, unpickled. Raises whatever an absent or corrupt file leads to."""
    return pickle.loads(path.read_bytes())


def write(path, data):
    """Write a file whole or not at all: under another name and then renamed, so that any number of processes may write it."""
    temporary = path.with_name(f".{path.stem[-32:]}.{os.getpid()}.{threading.get_ident()}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        temporary.write_bytes(data)
        temporary.replace(path)
    except OSError:  # a full disk, say: the code works from memory
        with contextlib.suppress(OSError):
            temporary.unlink()


def shared(jobs, work, progress=iter):
    """`work(job)` for each of `jobs` (a list), in their order. Where that takes longer than 0.2 s, a second process begins with
    the last jobs: it takes half of the time, also of compiling. What `work` returns must be picklable; it raises nothing."""
    begin, place, helper = time.monotonic(), mmap.mmap(-1, 16), None  # where this process and the helper are, as integers
    with tempfile.TemporaryDirectory() as folder:
        try:
            for number, job in enumerate(progress(jobs)):
                place[:8] = number.to_bytes(8, "little")
                if helper is None and time.monotonic() > begin + 0.2 and number + 2 < len(jobs) and _can_fork():
                    place[8:] = len(jobs).to_bytes(8, "little")
                    helper = _fork(jobs, work, place, Path(folder))
                result = Path(folder, str(number))
                limit = 2.0 * time.monotonic() - begin  # a lock of a thread that is not in the helper would stop it for good
                while helper and number >= int.from_bytes(place[8:], "little") and not result.exists():
                    if time.monotonic() > limit:
                        break
                    time.sleep(1e-3)
                    if os.waitpid(helper, os.WNOHANG)[0]:
                        helper = 0
                yield read(result) if result.exists() else work(job)
        finally:
            if helper:
                os.kill(helper, signal.SIGKILL)
                os.waitpid(helper, 0)


def _can_fork():
    return sys.platform == "linux" and len(os.sched_getaffinity(0)) > 1


def _fork(jobs, work, place, folder):
    """Process that does the jobs from the last on; it ends with this one and neither prints nor handles an interrupt."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # a progress bar has a thread; its locks are not needed here
        process = os.fork()
    if process:
        return process
    try:
        ctypes.CDLL(None).prctl(1, signal.SIGKILL)  # PR_SET_PDEATHSIG
        signal.signal(signal.SIGINT, signal.SIG_DFL)
        silence = os.open(os.devnull, os.O_WRONLY)
        os.dup2(silence, 1)
        os.dup2(silence, 2)
        for number in range(len(jobs) - 1, -1, -1):
            place[8:] = number.to_bytes(8, "little")
            if number <= int.from_bytes(place[:8], "little"):
                break
            write(folder / str(number), pickle.dumps(work(jobs[number])))
    finally:
        os._exit(0)
