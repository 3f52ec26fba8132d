"""The list of mutations and the code agree: `make mutations` can make each of them."""

import csv
from pathlib import Path

import mutations


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
