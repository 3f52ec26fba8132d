"""The tables of laws in README.md and docs/laws.md are those of the records; a law without words is an error."""

import pytest
from making import tables, words


@pytest.mark.parametrize("file", tables.MADE)
def test_tables_of_laws_are_those_of_the_records(file):
    written = (tables.ROOT / file).read_text(encoding="utf-8")
    assert tables.made(file) == written, "python docs/making/tables.py --write"


def test_another_use_of_a_law_changes_both_tables(monkeypatch):
    monkeypatch.setitem(words.WORDS, "rms", words.WORDS["rms"]._replace(brief="another use"))
    for file in tables.MADE:
        assert "another use" in tables.made(file)


def test_a_law_without_words_or_group_is_an_error(monkeypatch):
    monkeypatch.delitem(words.WORDS, "rms")
    with pytest.raises(SystemExit, match=r"words.py: write words, and a group, for rms"):
        tables.laws()
    monkeypatch.undo()
    monkeypatch.setitem(words.GROUPS, "Laws of rough contacts", ("hertz",))
    with pytest.raises(SystemExit, match=r"for rms, pohrt-popov, goddard"):
        tables.laws()


def test_a_file_without_its_table_is_an_error(monkeypatch, tmp_path):
    (tmp_path / "README.md").write_text("no table")
    monkeypatch.setattr(tables, "ROOT", tmp_path)
    with pytest.raises(SystemExit, match="0 tables"):
        tables.made("README.md")
