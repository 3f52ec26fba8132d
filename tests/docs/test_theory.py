"""Pages that the site makes of the records: formulae, symbols, links."""

import pytest
from making import formula
from making.symbols import meaning

from demlaws.laws.registry import registry


@pytest.mark.parametrize("name", registry())
def test_equations_are_translated_and_their_symbols_explained(name):
    equation = registry()[name].equation
    for line in formula.lines(equation):
        written = formula.latex(line)
        assert written.count("{") == written.count("}"), written
        assert not [sign for sign in written if sign in "αβγδεκλμνπρσφω√²³"], written
    unknown = [symbol for symbol in formula.symbols_of(equation) if meaning(name, symbol) is None]
    assert unknown == [], f"{equation}: say in docs/making/symbols.py what {unknown} are"
