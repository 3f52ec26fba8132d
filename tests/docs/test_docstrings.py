"""Every public function and class says what it is; every public name of `demlaws` shows it in an example that runs."""

import dataclasses
import doctest
import importlib
import inspect
import re
import sys
import types
import warnings
from pathlib import Path

import pytest

import demlaws as dl


def examples(name):
    """Doctests of a public name: of a module those of its public functions, of a class its own and its methods'."""
    value = getattr(dl, name)
    if isinstance(value, types.ModuleType):
        functions = [
            f for n, f in vars(value).items() if not n.startswith("_") and getattr(f, "__module__", "") == value.__name__
        ]
        return [t for f in functions if isinstance(f, types.FunctionType) for t in doctest.DocTestFinder().find(f, f.__name__)]
    home = sys.modules[value.__module__]
    return [t for t in doctest.DocTestFinder().find(value, name, module=home) if t.examples]


@pytest.mark.parametrize("name", dl.__all__)
def test_public_names_show_an_example_that_runs(name, registered_here):
    found = [test for test in examples(name) if test.examples]
    assert found, f"demlaws.{name} shows no example"
    for test in found:
        test.globs = {"dl": dl}
        said = []
        runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", dl.ValidityWarning)
            runner.run(test, out=said.append)
        assert not said, "".join(said)


def in_numpydoc_form():
    """Public names, their methods and functions, and functions of the module of time steps, whose docstring has sections."""
    for name in dl.__all__:
        value = importlib.import_module("demlaws.timestep") if name == "timestep" else getattr(dl, name)
        yield from [name] if "\n    -----" in (getattr(dl, name).__doc__ or "") else []
        for part in dir(value) if isinstance(value, type | types.ModuleType) else ():
            routine = inspect.isroutine(getattr(value, part)) and not part.startswith("_")
            if routine and "\n    -----" in (getattr(value, part).__doc__ or "").replace("\n        ", "\n    "):
                yield f"{name}.{part}"


FAULTS = {"GL03", "GL06", "GL07", "PR01", "PR02", "PR03", "PR06", "PR07", "RT01", "SS01", "SS03", "YD01"}
PARTIAL = {"Law", "Table", "Definition", "Option", "Parameter"}  # made by functions, or for maintainers


@pytest.mark.parametrize("name", sorted(set(in_numpydoc_form()) - PARTIAL))
def test_public_names_are_documented_in_numpydoc_form(name):
    """Checks of numpydoc's validator: every parameter, in order and described; Returns; order of the sections."""
    validate = pytest.importorskip("numpydoc.validate").validate
    assert [fault for fault in validate(f"demlaws.{name}")["errors"] if fault[0] in FAULTS] == []


POSITIONAL = {"driver.impact": 4, "driver.sheared": 5}
"""More than three arguments without a keyword, as documented from the start."""


def public_functions():
    """Public functions, also those of public modules, and the methods of public classes, by name."""
    for name in dl.__all__:
        value = importlib.import_module("demlaws.timestep") if name == "timestep" else getattr(dl, name)
        if inspect.isfunction(value):
            yield name, value
            continue
        for part in [part for part in dir(value) if not part.startswith("_")]:
            function = getattr(value, part)
            ours = isinstance(value, type) or getattr(function, "__module__", "") in (value.__name__, "demlaws.shear")
            if ours and (inspect.isfunction(function) or inspect.ismethod(function)) and not hasattr(function, "py_func"):
                yield f"{name}.{part}", function


@pytest.mark.parametrize(("name", "function"), [*public_functions()])
def test_arguments_beyond_the_third_have_keywords(name, function):
    kinds = (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)
    parameters = inspect.signature(function).parameters.values()
    count = len([p for p in parameters if p.kind in kinds and p.name not in ("self", "cls")])
    assert count <= POSITIONAL.get(name, 3)


API = (Path(__file__).resolve().parents[2] / "docs" / "reference" / "api.md").read_text()


def test_the_page_of_the_api_has_the_fields_of_a_scene():
    """The page refers to the scene file for their meaning, and gives their defaults."""
    shown = re.search(r"py:class:: Scene\((.*)\)$", API, re.MULTILINE)[1]
    defaults = {
        field.name: field.default_factory() if field.default is dataclasses.MISSING else field.default
        for field in dataclasses.fields(dl.Scene)
    }
    assert eval(f"dict({shown})") == defaults
