"""Pages that the site makes of the records: formulae, symbols, links."""

import json

import pytest
from making import formula, pages, reference
from making.symbols import meaning

from demlaws.laws.registry import registry


def test_formulae():
    assert formula.latex("P = (4/3) E* √R δ^1.5") == r"P = (4/3) E^{*} \sqrt{R} \delta ^{1.5}"
    assert formula.latex("a*²/(2 R_12)") == r"a^{* 2}/(2 R_{12})"
    assert formula.latex("w from there") == r"w \ \text{from there}"
    assert formula.latex("K^(0.5 Df) to F") == r"K^{0.5 D_{f}} \ \text{to}\ F"
    assert formula.latex("δp Pmax k1") == r"\delta_{p} P_{\mathrm{max}} k_{1}"
    assert formula.lines("P = a, b = min(c, d), then more") == ["P = a", "b = min(c, d), then more"]
    assert formula.symbols_of("δ/δ_H = p0' tan³β E*² to F, one a patch's") == ["δ", "δ_H", "p0'", "β", "E*", "F"]


@pytest.mark.parametrize("name", registry())
def test_equations_are_translated_and_their_symbols_explained(name):
    equation = registry()[name].equation
    for line in formula.lines(equation):
        written = formula.latex(line)
        assert written.count("{") == written.count("}"), written
        assert not [sign for sign in written if sign in "αβγδεκλμνπρσφω√²³"], written
    unknown = [symbol for symbol in formula.symbols_of(equation) if meaning(name, symbol) is None]
    assert unknown == [], f"{equation}: say in docs/making/symbols.py what {unknown} are"


def test_every_page_belongs_to_a_section():
    listed = {page for section in pages.SECTIONS for page in pages.members(section)}
    missing = [p.stem for p in pages.DOCS.glob("*.md") if p.stem not in listed and p.stem not in ("index", "paper")]
    assert missing == []


def test_messages_are_found_by_the_syntax_tree():
    assert any(text.startswith("unknown law") for _, _, text in reference.messages())


@pytest.mark.parametrize("tutorial", pages.TUTORIALS)
def test_tutorials_become_notebooks(tutorial):
    text = (pages.DOCS / "tutorials" / f"{tutorial}.md").read_text()
    cells = json.loads(pages.notebook(text))["cells"]
    code = [cell["source"] for cell in cells if cell["cell_type"] == "code"]
    assert code and all(source.startswith(("%%writefile ", "!", "import ")) for source in code)
    assert sum(source.startswith("%%writefile") for source in code) == text.count("<!-- file: ")
