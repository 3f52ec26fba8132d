"""The registry of laws: those of the package, and user-defined laws."""

import copyreg
import importlib.util
import os
import re
import sys
import traceback
import zlib
from pathlib import Path
from typing import Any

from demlaws.errors import DemlawsError, did_you_mean
from demlaws.laws import MODULES
from demlaws.laws.definition import Definition, check_name, with_sigma

_user_laws: dict[str, Definition] = {}
_homes: dict[str, str] = {}  # law → file or module that registered it
_checksums: dict[str, str] = {}  # law → that of this file when it registered
_loaded: set[str] = set()  # files

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
    if isinstance(definition, Definition):
        definition = with_sigma(definition)
    _check(definition)
    name = definition.name
    if name in _user_laws and _homes[name] != home and not replace:
        raise DemlawsError(
            f"law {name!r} of {home} is already registered by {_homes[name]}: give one of them another name, or register "
            "with replace=True"
        )
    if _user_laws.get(name) != definition:
        _user_laws[name] = definition
    _homes[name] = home
    _checksums[name] = f"{zlib.crc32(Path(home).read_bytes()):08x}" if os.path.isfile(home) else ""
    return _user_laws[name]


def _check(definition: Any) -> None:
    """Refuse an invalid definition, with the wrong field."""
    if not isinstance(definition, Definition):
        raise DemlawsError(f"register takes a demlaws.Definition, got {definition!r:.60}")
    name = definition.name
    if isinstance(name, str) and name in _BUILT_IN:
        raise DemlawsError(f"law {name!r} is a law of demlaws: use another name")
    check_name(name)
    rules = definition.offered()
    functions = {"prepare": definition.prepare, "limits": definition.limits, "kinks": definition.loading.kinks}
    texts = {field: getattr(definition, field) for field in ("equation", "source", "description")}
    fields = ("sigma", "fractal_dimension", "hardness")
    free = ("modulus", *definition.fitting.parameters)
    for field, value, right, needed in (
        *((field, text, isinstance(text, str) and text.isprintable(), "one line of text") for field, text in texts.items()),
        *((field, function, callable(function), "a function") for field, function in functions.items()),
        ("suits", definition.advice.suits, callable(definition.advice.suits), "a function"),
        ("rank", definition.advice.rank, definition.advice.rank == 0, "0: the references of choose are laws of the package"),
        ("length", definition.length, definition.length in ("roughness", "radius"), "'roughness' or 'radius'"),
        ("needs", definition.loading.needs, set(definition.loading.needs) <= set(fields), f"names of {', '.join(fields)}"),
        ("unloading", definition.unloading, definition.unloading[:1] == ("elastic",), "rules, the first one 'elastic'"),
        ("unloading", definition.unloading, set(definition.unloading) <= set(rules), f"names of {', '.join(rules)}"),
        ("default_unloading", definition.default_rule(), definition.default_rule() in rules, f"one of {', '.join(rules)}"),
        (
            "free",
            definition.fitting.free,
            set(definition.fitting.free) <= set(free),
            f"names of {', '.join(free)} (parameters)",
        ),
    ):
        if not right:
            raise DemlawsError(f"law {name!r}: {field} = {value!r:.60}: it must be {needed}")


def _reduced(definition: Definition) -> tuple:
    """Pickled by name: it holds functions that have no name, and a law that comes back is to be the same law."""
    if definition.name in _BUILT_IN or is_user_defined(definition):
        return _of_name, (definition.name, _checksums.get(definition.name, ""))
    return Definition, tuple(definition)  # of a table whose law is not here


def _of_name(name: str, checksum: str) -> Definition:
    definition = find(name)
    if _checksums.get(name, "") != checksum:
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
    A file that is loaded already is not run again; a copy of it is refused. Another process, as a script of YADE or one that
    unpickles a law, calls this function itself.

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
    if path not in _loaded:
        _run(path)
        _loaded.add(path)
    return [name for name, home in _homes.items() if home == path]


def _run(path: str) -> None:
    # the name is stable, so that machine code is found again, and different for files of one name
    name = f"demlaws_own_{re.sub(r'[^A-Za-z0-9]', '_', Path(path).stem)}_{zlib.crc32(path.encode()):08x}"
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None or not os.path.isfile(path):
        raise DemlawsError(f"no law file {path:.200}: give a Python file (.py) that registers laws")
    module = sys.modules[name] = importlib.util.module_from_spec(spec)
    folder = os.path.dirname(path)  # modules beside the file, as for a script
    sys.path.insert(0, folder)
    try:
        spec.loader.exec_module(module)
        if isinstance(getattr(module, "LAW", None), Definition):
            _register(module.LAW, path)
    except KeyboardInterrupt:
        raise
    except BaseException as error:  # SystemExit, too
        lines = [f", line {frame.lineno}" for frame in traceback.extract_tb(error.__traceback__) if frame.filename == path]
        text = " ".join(f"{type(error).__name__}: {error}".split())
        raise DemlawsError(f"{path}{''.join(lines[-1:])}: {text}") from error
    finally:
        sys.path.remove(folder)
    if path not in _homes.values():
        raise DemlawsError(f"{path} registers no law: call demlaws.register(...) in it")
