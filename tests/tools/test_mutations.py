"""The list of mutations and the code agree: `make mutations` can make each of them."""

import csv
from pathlib import Path

import mutations
import pytest


def test_each_mutation_matches_its_source_once(capsys):
    assert mutations.main(["--list"]) == 0, capsys.readouterr().err


def test_a_run_of_some_mutations_changes_their_rows_only(tmp_path):
    known = mutations.read_mutations(Path(mutations.__file__).with_suffix(".txt"))[:3]
    table = tmp_path / "mutations.csv"
    old = f"{known[0].name},1.0 → 1.02,test_old,yes: Granite\n"
    table.write_text(",".join(mutations.HEADS) + f"\nContact,{old}Contact,one that is no longer there,a,b,no\n")
    mutations.keep(table, known, {known[1].name: "tests/test_a.py::test_new[1]"}, report=False)
    mutations.keep(table, known, {known[1].name: None, known[2].name: "x.py::test_b[Granite]"}, report=True)
    with open(table, newline="") as file:
        rows = [(row["changed"], row["detected by the test"], row["by the report"]) for row in csv.DictReader(file)]
    found = [("test_old", "yes: Granite"), ("test_new[1]", "no"), ("not tried", "yes: Granite")]
    assert rows == [(mutation.name, *cells) for mutation, cells in zip(known, found, strict=True)]
    assert known[2].part == "Contact: sums and parameters" and known[2].change == "1.0 → 1.02"


def test_results_are_kept_as_they_come_and_the_rest_can_be_run_later(tmp_path, monkeypatch):
    """A run that is stopped in its third part; then those that are missing."""
    known = mutations.read_mutations(Path(mutations.__file__).with_suffix(".txt"))[:5]
    table, tried = tmp_path / "mutations.csv", []
    table.write_text(",".join(mutations.HEADS) + "\n")

    def failing(tree, mutation):
        tried.append(mutation.name)
        if len(tried) == 5:
            raise KeyboardInterrupt
        return "time limit"

    monkeypatch.setattr(mutations, "PART", 2)
    monkeypatch.setattr(mutations, "failing", failing)
    monkeypatch.setattr(mutations, "copy_tree", lambda folder: folder)
    monkeypatch.setattr(mutations, "read_mutations", lambda path: known)
    with pytest.raises(KeyboardInterrupt):
        mutations.main(["--table", str(table)])
    assert tried == [mutation.name for mutation in known]
    assert mutations.main(["--table", str(table), "--missing"]) == 0
    assert tried[5:] == [known[4].name]
    assert {row["detected by the test"] for row in mutations.rows_of(table).values()} == {"time limit"}


def test_a_test_whose_parameters_a_mutation_made_is_not_repeated(tmp_path):
    """Parameters are often names of laws and options, which a mutation may change."""
    tree = tmp_path / "tree"
    tree.mkdir()
    (tree / "test_one.py").write_text("import pytest\n@pytest.mark.parametrize('n', [1])\ndef test_a(n): pass\n")
    names = [f"test_one.py::test_a[{n}]" for n in (1, 2)]
    assert mutations.collected(tree, names) == names[:1] and mutations.collected(tree, []) == []


def test_the_page_counts_its_table():
    """Changes, results and rows of the report, by part; the number of the validation page."""
    docs = Path(mutations.PROJECT) / "docs"
    rows = list(mutations.rows_of(docs / "tables" / "mutations.csv").values())
    assert "no" not in {row["detected by the test"] for row in rows}

    def counts(some):
        tests, reports = ([row[name] for row in some if row[name] != "not tried"] for name in mutations.HEADS[3:])
        return len(some), len(tests), len(reports), sum(report != "no" for report in reports)

    page = " ".join((docs / "inside" / "mutations.md").read_text().split())
    for part in {row["part"] for row in rows}:
        numbers = counts([row for row in rows if row["part"] == part])
        assert f"| {part} | {' | '.join(map(str, numbers))} |" in page
    number, tried, reported, detected = counts(rows)
    assert f"the table has {number} changes. **Results of {tried} are kept: all are detected**" in page
    assert f"**{detected} of {reported}**" in page and (
        tried == number or f"other {number - tried} have no kept result" in page
    )
    assert f"{tried} small changes" in (docs / "validation" / "index.md").read_text()
