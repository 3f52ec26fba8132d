"""The list of mutations and the code agree: `make mutations` can make each of them."""

import mutations


def test_each_mutation_matches_its_source_once(capsys):
    assert mutations.main(["--list"]) == 0, capsys.readouterr().err
