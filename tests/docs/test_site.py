"""The site is built as `make docs` does, warnings as errors; equations of its pages are translated and explained."""

import importlib.util
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from making.equations import EQUATIONS
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
def test_equations_are_those_of_the_laws_and_their_symbols_explained(name):
    """Every number of `Definition.equation` comes in the LaTeX, in the same order."""
    text = registry()[name].equation.translate(str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")).replace("½", "1/2")
    written = " ".join(EQUATIONS[name].lines)
    assert re.findall(r"\d+(?:\.\d+)?", text) == re.findall(r"\d+(?:\.\d+)?", written)
    assert all(meaning(name, symbol) for symbol in EQUATIONS[name].symbols.split())
    assert all(symbol in registry()[name].equation.replace("′", "'") for symbol in EQUATIONS[name].symbols.split())
