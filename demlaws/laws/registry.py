"""The registry of laws: those of the package, and user-defined laws."""

import contextlib
import copyreg
import importlib
import importlib.util
import os
import re
import sys
import traceback
import zlib
from collections import defaultdict
from pathlib import Path
from types import ModuleType
from typing import Any

from demlaws.errors import DemlawsError, did_you_mean
from demlaws.laws import MODULES
from demlaws.laws.definition import Definition, check_name

_user_laws: dict[str, Definition] = {}
_homes: dict[str, str] = {}  # law → file or module that registered it
_marks: dict[str, str] = defaultdict(str)  # law → check value of that file when it registered
_loaded: dict[str, None] = {}  # files, in their order


_BUILT_IN = {module.replace("_", "-"): module for module in MODULES}
"""Name of a law of the package → its module, which is imported when the law is needed."""


def _built_in(name: str) -> Definition:
    return importlib.import_module(f"demlaws.laws.{_BUILT_IN[name]}").LAW


def registry() -> dict[str, Definition]:
    """Name → Definition of every law, in the order in which figures and tables show them; registered ones last."""
    return {**{name: _built_in(name) for name in _BUILT_IN}, **_user_laws}


def laws() -> list[str]:
    """Names of all laws.

    >>> dl.laws()[:3]
    ['hertz', 'rms', 'pohrt-popov']
    """
    return [*_BUILT_IN, *_user_laws]


def find(name: str) -> Definition:
    """The law of this name, or an error that lists the names."""
    if isinstance(name, str) and name in _BUILT_IN:
        return _built_in(name)
    if not isinstance(name, str):
        raise DemlawsError(
            f"a law's name must be text, got {name!r:.60}: dl.law(NAME, contact); the laws are {', '.join(laws())}"
        )
    if name not in _user_laws:
        raise DemlawsError(f"unknown law {name!r:.60}{did_you_mean(name, laws())} The laws are {', '.join(laws())}")
    return _user_laws[name]


def is_user_defined(definition: Definition) -> bool:
    """Whether a user registered this definition."""
    return _user_laws.get(definition.name) is definition


def home_of(name: str) -> str:
    """File or module that registered the law."""
    return _homes.get(name, "demlaws")


# --- user-defined laws


def register(definition: Definition, replace: bool = False) -> Definition:
    """Register a law, so that it is found by its name.

    Parameters
    ----------
    definition : Definition
        The law; see `demlaws.define`.
    replace : bool
        Replace a law of the same name from another file.

    Returns
    -------
    Definition
        The same.

    Raises
    ------
    DemlawsError
        For names of the package or of another file, and invalid definitions.

    Notes
    -----
    A law that is registered again from the same file, module or notebook replaces the old one; laws that are bound already
    do not change.

    Examples
    --------
    >>> mine = dl.register(dl.define("spring", lambda p, x: 1e6 * x, lambda p, x: 1e6))
    >>> law = dl.law("spring", dl.Contact(radius=4e-3, modulus=32e9))
    >>> round(law.force(1e-6), 9), dl.laws()[-1]
    (1.0, 'spring')
    """
    names = sys._getframe(1).f_globals  # of the code that registers: its file, or the name of its module
    file = names.get("__file__")
    return _register(definition, os.path.realpath(file) if file else str(names.get("__name__", "?")), replace)


def _register(definition: Definition, home: str, replace: bool = False) -> Definition:
    _check(definition)
    name = definition.name
    if name in _user_laws and _homes[name] != home and not replace:
        raise DemlawsError(
            f"law {name!r} of {home} is already registered by {_homes[name]}: give one of them another name, or register "
            "with replace=True"
        )
    others = (*map(_built_in, _BUILT_IN), *_user_laws.values()) if definition.advice.rank else ()
    ranks = {d.advice.rank: d.name for d in others if d.advice.rank and d.name != name}
    if definition.advice.rank in ranks:
        raise DemlawsError(
            f"law {name!r}: rank {definition.advice.rank} is that of {ranks[definition.advice.rank]!r}: give another, or 0"
        )
    if _user_laws.get(name) != definition:
        _user_laws[name] = definition
    _homes[name] = home
    with contextlib.suppress(OSError):
        _marks[name] = _check_value(Path(home).read_bytes())
    return _user_laws[name]


def _check(definition: Any) -> None:
    """Refuse an invalid definition, with the wrong field."""
    if not isinstance(definition, Definition):
        raise DemlawsError(f"register takes a demlaws.Definition, got {definition!r:.60}")
    name = definition.name
    if isinstance(name, str) and name in _BUILT_IN:
        raise DemlawsError(f"law {name!r} is a law of demlaws: use another name")
    check_name(name)
    for field in ("equation", "source", "description"):
        text = getattr(definition, field)
        if not isinstance(text, str) or not text.isprintable():
            raise DemlawsError(f"law {name!r}: {field} must be one line of text, got {text!r:.60}")
    functions = {field: getattr(definition, field) for field in ("prepare", "limits", "kinks")}
    for field, function in (functions | {"advise": definition.advice.advise}).items():
        if not callable(function):
            raise DemlawsError(f"law {name!r}: {field} must be a function, got {function!r:.60}")
    if definition.length not in ("roughness", "radius"):
        raise DemlawsError(f"law {name!r}: length must be 'roughness' or 'radius', got {definition.length!r:.60}")
    known_fields = ("roughness", "fractal_dimension", "hardness")
    if wrong := [n for n in definition.needs if n not in known_fields]:
        raise DemlawsError(f"law {name!r}: needs {', '.join(map(repr, wrong))}: a contact has {', '.join(known_fields)}")
    if not definition.unloading or definition.unloading[0] != "elastic":
        raise DemlawsError(f"law {name!r}: unloading = {definition.unloading!r:.60}: the first rule must be 'elastic'")
    available = definition.offered()
    if wrong := [rule for rule in (*definition.unloading, definition.default_rule()) if rule not in available]:
        raise DemlawsError(f"law {name!r}: unloading {wrong[0]!r:.40} is none of its rules, {', '.join(available)}")
    if wrong := sorted({*definition.fitting.free} - {"modulus", *definition.fitting.parameters}):
        raise DemlawsError(f"law {name!r}: free names {', '.join(wrong)}, which fitted does not describe")


def source_checksum(definition: Definition) -> str:
    """Checksum of the functions or of the file of a definition, to distinguish edited versions."""
    if not is_user_defined(definition):
        return ""
    return getattr(definition.prepare, "mark", None) or _marks[definition.name]


def _reduced(definition: Definition) -> tuple:
    """Pickled by name and file: it holds functions that have no name, and a law that comes back is to be the same law."""
    if definition.name in _BUILT_IN or definition.name in _user_laws:
        home = home_of(definition.name)
        return _of_name, (definition.name, source_checksum(definition), home if home in _loaded else "")
    return Definition, tuple(definition)  # of a table whose law is not here


def _of_name(name: str, checksum: str = "", file: str = "") -> Definition:
    if file and name not in laws() and os.path.isfile(file):  # a worker process
        load_laws(file)
    definition = find(name)
    if source_checksum(definition) != checksum:
        raise DemlawsError(f"law {name!r} differs from the law that was pickled: make it again")
    return definition


copyreg.pickle(Definition, _reduced)


# --- files


def load_laws(file: str | os.PathLike) -> list[str]:
    """Run a Python file that registers laws, or has a `LAW = Definition(...)`.

    Parameters
    ----------
    file : str or path
        The file.

    Returns
    -------
    list of str
        Names of its laws.

    Raises
    ------
    DemlawsError
        If the file cannot be run.

    Notes
    -----
    A file that is loaded or imported already is not run again; a copy of it is refused. Processes that unpickle its laws load
    it, too. A script of YADE calls this function itself.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "mine.py"
    >>> text = "import demlaws as dl; dl.register(dl.define('mine', lambda p, x: 1e6 * x, lambda p, x: 1e6))"
    >>> _ = file.write_text(text)
    >>> dl.load_laws(file)
    ['mine']
    """
    from demlaws.files import as_path

    path = os.path.realpath(as_path(file))
    module = _imported(path)
    if path not in _loaded and module is not None:  # registered what it calls `register` with; a LAW waits to be
        _register_law_of(module, path)
    elif path not in _loaded:
        _loaded[path] = None
        try:
            _run(path)
        except BaseException:
            _loaded.pop(path, None)
            raise
    return [name for name, home in _homes.items() if home == path]


def _check_value(content: bytes) -> str:
    return f"{zlib.crc32(content):08x}"


def _imported(path: str) -> ModuleType | None:
    """The module that is this file; also one that is being run now."""
    for module in list(sys.modules.values()):
        if isinstance(module, ModuleType) and os.path.realpath(module.__dict__.get("__file__") or "/") == path:
            return module
    return None


def _run(path: str) -> None:
    if not os.path.isfile(path):
        raise DemlawsError(f"no law file {path:.200}: give a Python file that registers laws")
    # stable, so that machine code is found again, and different for files of one name
    name = f"demlaws_own_{re.sub(r'[^A-Za-z0-9]', '_', Path(path).stem)}_{zlib.crc32(path.encode()):08x}"
    spec = importlib.util.spec_from_file_location(name, path)
    before = dict(_user_laws), dict(_homes)
    if spec is None or spec.loader is None:
        raise DemlawsError(f"{path} is not a Python file: the name of a law file ends in .py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    folder = os.path.dirname(path)  # modules beside the file, as for a script
    sys.path.insert(0, folder)
    try:
        spec.loader.exec_module(module)
        _register_law_of(module, path)
    except KeyboardInterrupt:
        raise
    except BaseException as error:
        sys.modules.pop(name, None)
        for table in (_user_laws, _homes):
            table.clear()
        _user_laws.update(before[0])
        _homes.update(before[1])
        raise DemlawsError(_format_load_error(path, error)) from error
    finally:
        with contextlib.suppress(ValueError):
            sys.path.remove(folder)
    if not any(home == path for home in _homes.values()):
        sys.modules.pop(name, None)
        raise DemlawsError(f"{path} registers no law: call demlaws.register(...) in it")


def _register_law_of(module: ModuleType, path: str) -> None:
    """Register the definition that a module has as LAW, if it has one."""
    law = getattr(module, "LAW", None)
    if isinstance(law, Definition):
        _register(law, path)


def _format_load_error(path: str, error: BaseException) -> str:
    """One line about what went wrong in a file of laws."""
    if isinstance(error, SyntaxError) and error.filename == path:
        return f"{path}, line {error.lineno}: {error.msg}"
    lines = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == path]
    where = f"{path}, line {lines[-1]}" if lines else path
    text = str(error) if isinstance(error, DemlawsError) else f"{type(error).__name__}: {error}"
    return f"{where}: {' '.join(text.split())}"
