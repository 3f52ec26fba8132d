"""The granite paper's figures and the command that draws them."""

import pytest

from demlaws import granite
from demlaws.cli import main


@pytest.mark.slow
def test_the_whole_command(tmp_path, capsys):
    """What `make granite` runs: tables, paths, claims and every figure."""
    assert main(["granite", "--out", str(tmp_path)]) == 0
    assert f"{len(list(tmp_path.iterdir()))} files written" in capsys.readouterr().out
    drawn = {file.stem for file in tmp_path.glob("*.png")}
    assert {f"force-{test.key}" for test in granite.TESTS} < drawn
    assert {"stiffness", "crossover-ss-18-18", "roughness", "plastic-overlap", "effective-radius"} < drawn
    paths = {file.name for file in tmp_path.glob("*.csv")}
    assert {
        f"{test.key}-{name}.csv" for test in granite.TESTS for name in granite.laws_for_tests() if len(test.stages) == 1
    } < paths
    assert {"summary.csv", "claims.csv"} < paths
