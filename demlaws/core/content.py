"""Identification of compiled code by content: functions with all that they call or use, types with what is bound to them."""

import functools
import sys
from hashlib import sha256
from pathlib import Path

import numba
import numpy as np
from numba import types

_OURS = ("numba", "numpy", "math", "cmath", "builtins", "operator", "typing", "demlaws.core", "demlaws.laws")
"""Modules that the name of the cache's folder stands for, or that change with numba's version only."""
_DEPENDENCIES = {}  # NamedTuple that kernels are bound to → digests of these, None among them where one is unknown


def digest(*contents):
    """SHA-256 of bytes, and of the text of anything else, in hexadecimal."""
    return sha256(b"\0".join(c if isinstance(c, bytes) else repr(c).encode() for c in contents)).hexdigest()


def file_digest(file):
    """Digest of a file; None if it does not exist."""
    try:
        return digest(Path(file).read_bytes())
    except (OSError, TypeError):
        return None


source_digest = functools.cache(file_digest)  # of the file of a loop: a process runs one version of it


def is_our_module(module):
    """Whether the name of the cache's folder stands for the content of this module."""
    return module in _OURS or (module or "").startswith(tuple(f"{name}." for name in _OURS))


def record_dependencies(cls, *functions):
    """Record that code for the NamedTuple `cls` depends on these functions, on all that they call or use as a global, and on
    the file of the class. Read now, not when a loop is compiled: the file may be edited meanwhile, and a notebook has none.

    Returns a digest of all that, or None where something in it is unknown.
    """
    keys = _DEPENDENCIES.setdefault(cls, set())
    if not is_our_module(cls.__module__):
        keys.add(file_digest(getattr(sys.modules.get(cls.__module__), "__file__", None)) or f"fields {cls._fields}")
    keys.update(map(content_key, functions))
    return None if None in keys else digest(*sorted(keys))


def content_key(thing, visited=None):
    """Text that identifies a value or a function, with all that it calls or uses, for compiled code; None if unknown."""
    visited = set() if visited is None else visited
    if isinstance(thing, (bool, int, float, complex, str, bytes, type(None), np.generic, np.dtype, types.Type)):
        return repr(thing)
    if isinstance(thing, np.ndarray):
        return None if thing.dtype.hasobject else digest(str(thing.dtype), thing.shape, np.ascontiguousarray(thing).tobytes())
    if isinstance(thing, tuple | list | dict):
        parts = [content_key(part, visited) for part in (thing.items() if isinstance(thing, dict) else thing)]
        return None if None in parts else f"{type(thing).__qualname__}({','.join(parts)})"
    function = getattr(thing, "py_func", None) or getattr(thing, "_defn", None) or thing  # of a dispatcher, an intrinsic
    module, code = getattr(function, "__module__", None), getattr(function, "__code__", None)
    if isinstance(thing, type):
        return f"{module}.{thing.__qualname__}{getattr(thing, '_fields', '')}"
    if isinstance(thing, np.ufunc) or (is_our_module(module) and not getattr(function, "__closure__", None)):
        return f"{module}.{getattr(function, '__qualname__', repr(function))}"
    if (module or "").startswith("demlaws.") and code and not function.__closure__:
        return f"{module}.{function.__qualname__} {_files_of(module)}"
    if code is None or function in visited:
        return None if code is None else "itself"
    visited.add(function)
    parts = _parts_of_function(function, code, visited)
    key = None if None in parts else digest(*parts)
    if hasattr(thing, "recompile"):  # a user's helper whose globals may have changed
        if getattr(thing, "demlaws_key", key) != key:
            thing.recompile()
        thing.demlaws_key = key
    return key


@functools.cache
def _files_of(module):
    """Digest of the files of a module of the package, with those beside it in its folder: a process runs one version of it."""
    file = Path(sys.modules[module].__file__)
    return digest(*map(source_digest, sorted(file.parent.glob("*.py")) if module.count(".") > 1 else [file]))


def digest_of(*things):
    """Digest of their `content_key`; None if it is unknown."""
    key = content_key(things)
    return key and digest(key)


def _parts_of_function(function, code, visited):
    # the whole file as well: the code of a numba stub does not identify its implementation
    parts = [_code_digest(code), file_digest(code.co_filename) or "no file", content_key(function.__defaults__, visited)]
    parts += [content_key(cell.cell_contents, visited) for cell in function.__closure__ or ()]
    names = sorted(_names(code))
    for value in (function.__globals__[name] for name in names if name in function.__globals__):
        if not isinstance(value, type(sys)):
            parts.append(content_key(value, visited))
        elif not is_our_module(value.__name__):
            parts += [content_key(getattr(value, name), visited) for name in names if hasattr(value, name)]
    return parts


def _names(code):
    """Names of globals and attributes that a function, or one inside it, uses."""
    return set(code.co_names).union(*(_names(constant) for constant in code.co_consts if isinstance(constant, type(code))))


def _code_digest(code):
    constants = [_code_digest(c) if isinstance(c, type(code)) else repr(c) for c in code.co_consts]
    return digest(code.co_code, code.co_names, code.co_varnames, code.co_freevars, *constants)


def dependencies(function, kinds, constants):
    """Texts that identify a function, the values of some of its globals (a dict), and what is bound to the NamedTuples in the
    numba types of its arguments; None if one is unknown."""
    classes = [*_classes([*kinds, *(numba.typeof(value) for value in constants.values() if isinstance(value, tuple))])]
    for cls in classes:
        if cls not in _DEPENDENCIES:  # part of a law's params, bound to nothing itself
            record_dependencies(cls)
    keys = {content_key([function, *constants.items()])}.union(*(_DEPENDENCIES[cls] for cls in classes))
    return None if None in keys else [*sorted(keys), *((cls.__module__, cls.__qualname__, cls.__name__) for cls in classes)]


def _classes(kinds):
    """The NamedTuples in (nested) tuples of numba types, also where a type itself is the argument."""
    for kind in kinds:
        kind = getattr(kind, "instance_type", kind)
        if isinstance(kind, types.BaseNamedTuple):
            yield kind.instance_class
        if isinstance(kind, types.BaseTuple):
            yield from _classes(kind)
