"""Pages that are measured and kept: each says by what, where and when; the text is made of the command's output."""

import re
from pathlib import Path

import pytest
from making import measured

DOCS = Path(__file__).resolve().parents[2] / "docs"
KEPT = sorted((DOCS / "validation").glob("*.md"))


def test_claims_are_counted(tmp_path):
    (tmp_path / "claims.csv").write_text(
        "test,claim,run gives,verdict\nA,a*b,1,reproduced\nB,c,2,not reproduced\nC,d,3,reproduced\n"
    )
    text = measured.claims(tmp_path, tmp_path, "")
    assert "**2 reproduced; 1 not reproduced.**" in text and "| A | a\\*b | 1 | reproduced |" in text


def test_the_report_comes_below_our_title(tmp_path):
    out = tmp_path / "out"
    out.mkdir()
    (out / "validation.md").write_text("# Validation of demlaws 1\n\nAnswers.\n## Impacts\n")
    (out / "deviations.png").write_bytes(b"picture")
    assert measured.report(tmp_path, out, "").startswith("Answers.\n## Impacts")
    assert (tmp_path / "deviations.png").read_bytes() == b"picture"


@pytest.mark.parametrize("page", [page for page in KEPT if page.stem != "index"], ids=lambda page: page.stem)
def test_a_kept_page_says_by_what_and_when(page):
    assert page.stem in measured.PAGES
    head = page.read_text().split("\n")[2]
    assert re.match(r"Measured 20\d\d-\d\d-\d\d in \d+ s: demlaws [\d.]+ \(.+\), Python [\d.]+, numpy .*`.+`", head), head
