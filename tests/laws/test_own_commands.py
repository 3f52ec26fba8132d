"""Commands and studies with a law from a file outside the package: `--law-file FILE.py`."""

import csv

import numpy as np
import pytest
from own_spring import SPRING, registered

from demlaws.cli import main
from studies.extremes.__main__ import main as extremes
from studies.trade.__main__ import main as trade

NEAR = """
    import demlaws as dl
    from demlaws.core.fastmath import sqrt

    def force(p, overlap):
        return p.factor * p.hertz_coefficient * overlap * sqrt(overlap)

    def stiffness(p, overlap):
        return 1.5 * p.factor * p.hertz_coefficient * sqrt(overlap)

    FACTOR = dl.Parameter("", True, lambda c: (0.1, 10.0), lambda c: [0.5, 1.0], option=True)
    dl.register(dl.define(
        "near-hertz", force, stiffness, options={"factor": 0.9}, description="Hertz but for a factor", collapses=True,
        candidate=True, fitted={"factor": FACTOR}, free=("factor",), unloading=("elastic", "hertz"), smooth=True,
    ))
"""


@pytest.fixture
def file(tmp_path):
    with registered(tmp_path, NEAR, "near.py") as path:
        yield str(path)


@pytest.mark.slow
def test_stability_of_a_law_with_a_rule_of_its_own(tmp_path, capsys):
    with registered(tmp_path, SPRING) as path:
        assert extremes(["--law-file", str(path), "--law", "spring", "--paths", "4e3", "--cycles", "1e3"]) == 0
    lines = [line.split() for line in capsys.readouterr().out.splitlines() if line.startswith("spring")]
    rules = ("elastic", "table", "slack")
    assert {(line[1], line[2]) for line in lines} == {(rule, form) for rule in rules for form in ("closed", "table")}


@pytest.mark.slow
def test_trade(file, capsys):
    assert trade(["--law-file", file, "--law", "near-hertz", "--contacts", "1000", "--rounds", "1"]) == 0
    said = capsys.readouterr().out
    assert "near-hertz" in said


@pytest.mark.slow
def test_fit(file, tmp_path, capsys):
    force = np.geomspace(1.0, 100.0, 30)
    coefficient = 4.0 / 3.0 * 32e9 * 4e-3**0.5
    overlap = (force / (0.8 * coefficient)) ** (2 / 3)
    rows = "\n".join(f"{1e6 * d:.9g},{p:.9g}" for d, p in zip(overlap, force, strict=True))
    (tmp_path / "points.csv").write_text(f"displacement (um),force (N)\n{rows}\n")
    arguments = ["fit", str(tmp_path / "points.csv"), "--law-file", file, "--law", "near-hertz", "--law", "hertz"]
    assert main([*arguments, "--effective-radius", "4mm", "--modulus", "32GPa"]) == 0
    lines = capsys.readouterr().out.splitlines()
    first = next(line for line in lines if line.startswith(("near-hertz", "hertz")))
    assert first.startswith("near-hertz") and "factor 0.8 " in first


SCENE = """
quantity = "force"
tolerance = 0.2
engine = "python"
radii = 0.005
force = [1, 10]
[material]
young = 210e9
poisson = 0.3
"""


@pytest.mark.slow
def test_choose(file, tmp_path):
    """Among the candidates, closed form and table, with the error that it has: 0.9 of Hertz's force."""
    (tmp_path / "scene.toml").write_text(SCENE)
    assert main(["choose", str(tmp_path / "scene.toml"), "--law-file", file, "--all", "--csv", str(tmp_path / "all.csv")]) == 0
    with open(tmp_path / "all.csv", newline="") as written:
        rows = [row for row in csv.DictReader(written) if row["choice"].startswith("near-hertz")]
    assert {"closed form", "table"} <= {kind for row in rows for kind in ("closed form", "table") if kind in row["choice"]}
    for row in rows:
        assert 0.1 <= float(row["error"]) <= 0.15 and row["meets"] == "True", row
