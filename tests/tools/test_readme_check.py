"""The check of the README's numbers: marks are read, a wrong number is found; what our texts mark is known."""

import pytest
import readme_check as check

KNOWN = {
    "one": check.Check(lambda: 57.47, ""),
    "pair": check.Check(lambda: (1.32, 4.09), ""),
    "none": check.Check(lambda: float("nan"), ""),
}


def run(tmp_path, monkeypatch, text):
    monkeypatch.setattr(check, "checks", lambda: KNOWN)
    (tmp_path / "text.md").write_text(text)
    return check.main([str(tmp_path / "text.md")])


@pytest.mark.parametrize(
    "text",
    [
        "SS(18–18) crosses at 57.5 N<!-- check: one 0.05 --> by its equations",
        "shift of 1.3–4.1 µm<!-- check: pair 0.05 --> a decade, 57.5<!-- check: one 0.05 -->",
        "from 1.3 × to 4.1 ×<!-- check: pair 5% -->",
    ],
)
def test_marked_numbers_that_hold(tmp_path, monkeypatch, text):
    assert run(tmp_path, monkeypatch, text) == 0


@pytest.mark.parametrize(
    "text",
    [
        "crosses at 57.6 N<!-- check: one 0.05 -->",
        "another paragraph 1.3\n\n4.1<!-- check: pair 0.05 -->",
        "57.5<!-- check: two 0.05 -->",
        "57.5<!-- check: one -->",
        "1<!-- check: none 100% -->",
    ],
)
def test_what_does_not_hold(tmp_path, monkeypatch, text):
    assert run(tmp_path, monkeypatch, text) == 1


def test_the_marks_of_the_texts_can_be_read():
    known = check.checks()
    assert not [mark for path in check.texts() for mark in check.marks(path) if check.fault(mark, known)]
