"""Pages of engines have one order of sections; that of YADE's functor names every argument with its default."""

import ast
import re
from pathlib import Path

import pytest

PROJECT = Path(__file__).resolve().parents[2]
PAGE = (PROJECT / "docs" / "reference" / "yade.md").read_text()


ENGINES = ("yade_scripts/README", *(f"docs/{name}" for name in ("liggghts", "lammps")))
REFERENCES = [f"docs/reference/{name}" for name in ("yade", "liggghts", "lammps")]


@pytest.mark.parametrize("page", [*ENGINES, *REFERENCES])
def test_sections(page):
    text = re.sub(r"^```.*?^```", "", (PROJECT / f"{page}.md").read_text(), flags=re.MULTILINE | re.DOTALL)
    assert re.findall(r"^## (.*)", text, re.MULTILINE) == ["Syntax", "Example", "Arguments", "Output", "Restrictions"]


def signature(file, name):
    """{argument: default, as source} of a function of a file of demlaws/yade."""
    tree = ast.parse((PROJECT / "demlaws" / "yade" / file).read_text())
    function = next(node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef) and node.name == name)
    arguments = function.args
    plain = arguments.args[len(arguments.args) - len(arguments.defaults) :]
    pairs = [*zip(plain, arguments.defaults, strict=True), *zip(arguments.kwonlyargs, arguments.kw_defaults, strict=True)]
    return {argument.arg: ast.unparse(default) for argument, default in pairs}


def rows(heading):
    """First cells of the table rows below a heading or bold line, split at commas."""
    text = re.split(r"\n(?:## |\*\*)", PAGE[PAGE.index(heading) + len(heading) :])[0]
    return {name for cell in re.findall(r"^\| (`.*?) \|", text, re.MULTILINE) for name in re.findall(r"`(\w+)`", cell)}


@pytest.mark.parametrize(
    ("file", "name", "heading"),
    [("functor.py", "__init__", "## Arguments"), ("scene.py", "engines", "**Arguments of `engines`**")],
)
def test_every_argument_is_described(file, name, heading):
    assert set(signature(file, name)) == rows(heading)


def test_defaults_of_the_syntax():
    known = {"HERTZ": '"hertz"', "DEFAULT": '"elastic"'}
    for file, name in (("functor.py", "__init__"), ("scene.py", "engines")):
        for argument, default in signature(file, name).items():
            shown = known.get(default, default).replace("'", '"')
            assert f"{argument}={shown}" in PAGE, argument
