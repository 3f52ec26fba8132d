"""Pages made of the output of a command."""

from making import measured


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
