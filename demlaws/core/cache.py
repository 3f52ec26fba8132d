"""Machine code on disk: what was compiled once is loaded by every later process, and never yesterday's."""

import contextlib
import functools
import os
import pickle
import shutil
import sys
import tempfile
import threading
import time
from hashlib import sha256
from pathlib import Path

import numba
from numba import types
from numba.core import config, serialize
from numba.core.compiler import CompileResult

from demlaws.core import notice


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
    own = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    places = (config.CACHE_DIR,) if config.CACHE_DIR else (Path(__file__).parent / "__pycache__", Path(own, "demlaws"))
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


def _remove_abandoned(folder):
    """Remove the machine code of versions that no process has used for a day: one that has just been written may belong to
    another checkout, or to a process that is still at work with the files that this one has replaced."""
    for other in folder.parent.glob("loops-*"):
        with contextlib.suppress(OSError):
            if other != folder and time.time() - other.stat().st_mtime > _UNUSED:
                shutil.rmtree(other, ignore_errors=True)


FOLDER = _cache_folder()
_SOURCES = {}


def follow(cls, *functions):
    """Machine code made for arguments whose type is the NamedTuple `cls` is good only as long as the files that define it and
    these compiled functions stay as they are; those of the core and the laws are followed anyway."""
    home = getattr(sys.modules.get(cls.__module__), "__file__", None)
    files = {home, *(f.py_func.__code__.co_filename for f in functions)}
    _SOURCES.setdefault(cls, set()).update(files)


@functools.cache
def _source(file):
    """Digest of a file; of a function typed in by hand, which has none, None."""
    try:
        return _digest(Path(file).read_bytes())
    except (OSError, TypeError):
        return None


def _classes(kinds):
    """The NamedTuples in a (nested) tuple of numba types."""
    for kind in kinds:
        if isinstance(kind, types.BaseNamedTuple):
            yield kind.instance_class
        if isinstance(kind, types.BaseTuple):
            yield from _classes(kind)


class Cache:
    """Machine code on disk, in place of numba's own cache: one file for each function and types of its arguments.

    The file's name is a digest of all that the code depends on: version of numba, content of core and laws (in the folder's
    name), content of the file of the loop and of any law from elsewhere, types, processor. A file is written under another
    name and then renamed, and never changed: any number of processes may compile the same loop at once. numba's cache keeps
    an index and numbered files, which two processes that add to it can mix up, and knows nothing of what a loop inlines.
    """

    cache_path = str(FOLDER)

    def __init__(self, function, constants=None):
        self.function, self.constants = function, constants or {}

    def _place(self, signature, codegen):
        """The file and the key that it must hold; the file is None if the code cannot be known again."""
        code = self.function.__code__
        closure = [cell.cell_contents for cell in self.function.__closure__ or ()]
        arguments = getattr(signature, "args", signature)  # of a callback it is a Signature
        classes = [*_classes(arguments), *_classes(self.constants.values())]
        names = [(cls.__module__, cls.__qualname__) for cls in classes]
        files = {code.co_filename}.union(*(_SOURCES.get(cls, ()) for cls in classes))
        sources = sorted(map(_source, files), key=str)
        key = (codegen.magic_tuple(), signature)
        try:
            digest = _digest(key, names, sources, code.co_code, serialize.dumps(closure), self.constants)
        except (pickle.PicklingError, TypeError):
            return None, key
        name = f"{Path(code.co_filename).stem}.{self.function.__qualname__.replace('<', '').replace('>', '')}"
        return None if None in sources else FOLDER / f"{name}-{digest[:32]}.nbc", key

    def load_overload(self, signature, context):
        """The compiled loop for these types from disk, or None: numba then compiles it."""
        context.refresh()
        path, key = self._place(signature, context.codegen())
        try:
            stored, payload = pickle.loads(path.read_bytes())
            if stored == key:
                return CompileResult._rebuild(context, *payload)
        except Exception:  # absent, or spoilt in any of the ways in which a file can be
            pass
        notice.begin()
        return None

    def save_overload(self, signature, result):
        """Write a compiled loop to disk, whole or not at all; a folder that cannot be written is no error."""
        notice.end()
        path, key = self._place(signature, result.codegen)
        if path is None or result.library.has_dynamic_globals:
            return
        data = serialize.dumps((key, result._reduce()))
        temporary = path.with_name(f".{path.stem[-32:]}.{os.getpid()}.{threading.get_ident()}")
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            temporary.write_bytes(data)
            temporary.replace(path)
        except OSError:  # a full disk, say: the code works from memory
            with contextlib.suppress(OSError):
                temporary.unlink()

    def flush(self):
        """Nothing to write: each file is complete."""
