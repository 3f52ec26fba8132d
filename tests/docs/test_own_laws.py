"""docs/own-laws.md does what it says, from files outside the package."""

import re
from pathlib import Path

import listings
import pytest
from test_pages import DOCS, follow

PAGE = DOCS / "own-laws.md"


@pytest.mark.slow
def test_the_page(tmp_path):
    follow(PAGE, tmp_path)


def test_its_examples_are_short():
    """Ten lines a door, blank ones aside."""
    for listing in listings.listings(PAGE):
        if listing.kind == "python":
            lines = [line for line in listing.text.splitlines() if line.strip()]
            assert len(lines) <= 10, listing.mark
    assert len(re.findall(r"<!-- file: \w+\.py -->", Path(PAGE).read_text())) == 3
