"""Every public function and class says what it is; every public name of `demlaws` shows it in an example that runs."""

import ast
import doctest
import inspect
import re
import types
import warnings
from pathlib import Path

import pytest

import demlaws as dl

PACKAGE = Path(dl.__file__).parent


def silent(path):
    """Public functions and classes of a file without a docstring; setters of a property speak through its getter."""
    found = []

    def look(node, prefix):
        for inner in node.body:
            if not isinstance(inner, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef) or inner.name.startswith("_"):
                continue
            setter = any(isinstance(d, ast.Attribute) and d.attr in ("setter", "deleter") for d in inner.decorator_list)
            if not setter and not ast.get_docstring(inner):
                found.append(f"{path.relative_to(PACKAGE.parent)}:{inner.lineno} {prefix}{inner.name}")
            if isinstance(inner, ast.ClassDef):
                look(inner, f"{prefix}{inner.name}.")

    look(ast.parse(path.read_text()), "")
    return found


def test_every_public_function_has_a_docstring():
    assert [line for path in sorted(PACKAGE.rglob("*.py")) for line in silent(path)] == []


def test_a_silent_function_is_found(tmp_path):
    file = PACKAGE / "made_up.py"
    tree = "class A:\n    '''A.'''\n    def b(self):\n        return 1\n    def _c(self):\n        return 2\n"
    path = types.SimpleNamespace(read_text=lambda: tree, relative_to=file.relative_to)
    assert silent(path) == ["demlaws/made_up.py:3 A.b"]


def examples(name):
    """Doctests of a public name: of a module those of its public functions, of a class its own and its methods'."""
    value = getattr(dl, name)
    if isinstance(value, types.ModuleType):
        functions = [
            f for n, f in vars(value).items() if not n.startswith("_") and getattr(f, "__module__", "") == value.__name__
        ]
        return [t for f in functions if isinstance(f, types.FunctionType) for t in doctest.DocTestFinder().find(f, f.__name__)]
    home = __import__("sys").modules[value.__module__]
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
        assert not runner.failures if hasattr(runner, "failures") else not said, "".join(said)


NUMPYDOC = [
    getattr(dl, name) for name in dl.__all__ if name not in ("Definition", "Law", "Option", "Parameter", "Table", "laws")
]
NUMPYDOC = [value for value in NUMPYDOC if not isinstance(value, types.ModuleType)]
NUMPYDOC = [value for value in NUMPYDOC if not (isinstance(value, type) and issubclass(value, Exception | Warning))]
NUMPYDOC += [dl.Contact.between, dl.driver.force_controlled, dl.driver.displacement_controlled, dl.driver.impact]
NUMPYDOC += [dl.driver.sheared, dl.regime.assess, dl.regime.advise, dl.plots.plot]


def sections(value):
    """Title → lines of the numpydoc sections of a docstring."""
    lines, found, title = inspect.getdoc(value).splitlines(), {}, ""
    for line, following in zip(lines, [*lines[1:], ""], strict=True):
        if re.fullmatch(r"-{4,}", following):
            title = line
            assert len(following) == len(title), f"{value}: underline of {title}"
        found.setdefault(title, []).append(line)
    return {title: lines[2:] for title, lines in found.items() if title}


@pytest.mark.parametrize("value", NUMPYDOC, ids=lambda value: value.__qualname__)
def test_public_names_are_documented_in_numpydoc_form(value):
    """All parameters in their order, Returns of functions; Examples."""
    found = sections(value)
    named = [line.partition(" : ")[0] for line in found["Parameters"] if line and not line.startswith(" ")]
    named = [name.strip("* ") for names in named for name in names.split(",")]
    taken = [name for name in inspect.signature(value).parameters if name not in ("self", "cls")]
    assert sorted(named) == sorted(taken)
    assert isinstance(value, type) or "Returns" in found
    assert "Examples" in found or value in (dl.Contact.between, dl.regime.advise)
