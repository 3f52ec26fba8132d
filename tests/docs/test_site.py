"""The site is built as `make docs` does, warnings as errors; equations of its pages are translated and explained."""

import importlib.util
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from making import formula
from making.symbols import meaning

from demlaws.laws.registry import registry

PROJECT = Path(__file__).resolve().parents[2]
NEEDED = ("sphinx", "myst_parser", "furo", "latex2mathml")


@pytest.mark.slow
def test_site(tmp_path):
    missing = [name for name in NEEDED if importlib.util.find_spec(name) is None]
    if missing:
        said = f"{', '.join(missing)} not installed: pip install -e '.[docs]'"
        assert not os.environ.get("CI"), said
        pytest.skip(said)
    line = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "-b", "html", "-d", tmp_path / "doctrees"]
    built = subprocess.run([*line, PROJECT / "docs", tmp_path / "site"], capture_output=True, text=True, cwd=PROJECT)
    assert built.returncode == 0, built.stderr
    for name in registry():
        page = (tmp_path / "site" / "made" / "theory" / f"{name}.html").read_text()
        assert "<math" in page and "<h2>Limits" in page
    for page in (tmp_path / "site").rglob("*.html"):
        loaded = re.findall(r'<(?:script|link|img)[^>]+(?:src|href)="(https?://[^"]*)"', page.read_text())
        assert loaded == [], f"{page} loads {loaded} from the network"


@pytest.mark.parametrize("name", registry())
def test_equations_are_translated_and_their_symbols_explained(name):
    equation = registry()[name].equation
    for line in formula.lines(equation):
        written = formula.latex(line)
        assert written.count("{") == written.count("}"), written
        assert not [sign for sign in written if sign in "αβγδεκλμνπρσφω√²³"], written
    unknown = [symbol for symbol in formula.symbols_of(equation) if meaning(name, symbol) is None]
    assert unknown == [], f"{equation}: say in docs/making/symbols.py what {unknown} are"
