"""Commands and studies with a law from a file outside the package: `--law-file FILE.py`."""

import csv

import pytest
from own_spring import registered

from demlaws.cli import main

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
