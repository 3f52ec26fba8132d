"""The check of the README's numbers: marks are read, a wrong number is found; what our texts mark is known."""

import pytest
import readme_check as check

KNOWN = {"one": check.Check(lambda: 57.47, ""), "pair": check.Check(lambda: (1.32, 4.09), "")}


def run(tmp_path, monkeypatch, capsys, text):
    monkeypatch.setattr(check, "checks", lambda: KNOWN)
    (tmp_path / "text.md").write_text(text)
    status = check.main([str(tmp_path / "text.md")])
    return status, capsys.readouterr().out


@pytest.mark.parametrize(
    "text",
    [
        "SS(18–18) crosses at 57.5 N<!-- check: one 0.05 --> by its equations",
        "1. The crossover\nis **57.5** <!--check: one 0.1%-->",
        "shift of 1.3–4.1 µm<!-- check: pair 0.05 --> a decade, 57.5<!-- check: one 0.05 -->",
        "| 1.3 | 4.1 |<!-- check: pair 0.05 -->",
        "from 1.3 × to 4.1 ×<!-- check: pair 5% -->",
    ],
)
def test_marked_numbers_that_hold(tmp_path, monkeypatch, capsys, text):
    assert run(tmp_path, monkeypatch, capsys, text) == (0, f"{text.count('check:')} marked numbers hold, 0 do not\n")


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("crosses at 57.6 N<!-- check: one 0.05 -->", "text.md:1: one: the text says 57.6, the run gives 57.47"),
        ("\n\n−57.5 N<!-- check: one 0.05 -->", "text.md:3: one: the text says -57.5"),
        ("a shift of 4.1<!-- check: pair 0.05 -->", "2 numbers are wanted before the mark, 1 stand there"),
        ("another paragraph 1.3\n\n4.1<!-- check: pair 0.05 -->", "2 numbers are wanted before the mark, 1 stand there"),
        ("57.5<!-- check: two 0.05 -->", "there is no check 'two'"),
        ("57.5<!-- check: one -->", "write <!-- check: NAME TOLERANCE -->"),
        ("57.5 and no mark", "no number is marked"),
    ],
)
def test_what_does_not_hold(tmp_path, monkeypatch, capsys, text, says):
    status, out = run(tmp_path, monkeypatch, capsys, text)
    assert status == 1 and says in out


def test_a_value_that_is_not_a_number_does_not_hold(tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(KNOWN, "none", check.Check(lambda: float("nan"), ""))
    assert run(tmp_path, monkeypatch, capsys, "1<!-- check: none 100% -->")[0] == 1


def test_the_marks_of_the_texts_can_be_read():
    known = check.checks()
    assert not [mark for path in check.texts() for mark in check.marks(path, known) if mark.fault]
