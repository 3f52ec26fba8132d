"""The paper's draft cites what its bibliography holds, and holds nothing that it does not cite."""

import re
from pathlib import Path

DOCS = Path(__file__).resolve().parents[2] / "docs"


def test_citations():
    cited = set(re.findall(r"@([a-z]\w+)", (DOCS / "paper.md").read_text().split("\n---\n", 1)[1]))
    held = re.findall(r"^@\w+\{(\w+),", (DOCS / "paper.bib").read_text(), re.MULTILINE)
    assert sorted(held) == sorted(cited)


def test_sections_that_journals_ask_for():
    headings = re.findall(r"^# (.*)$", (DOCS / "paper.md").read_text(), re.MULTILINE)
    assert {"Summary", "Statement of need", "State of the field", "References"} <= set(headings)
