"""Every case of lammps_inputs, at its quick size, with its own check; an exported case."""

import sys
from pathlib import Path

import pytest
from examples import shared

import demlaws as dl

INPUTS = Path(__file__).parents[3] / "lammps_inputs"
CASES = sorted(path.parent.name for path in INPUTS.glob("*/run.py"))
GRANITE = dl.Material(young=60.6e9, poisson=0.25, hardness=6.266e9, density=2650.0)

pytestmark = pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")


@pytest.fixture
def common(monkeypatch):
    monkeypatch.syspath_prepend(str(INPUTS))
    monkeypatch.delitem(sys.modules, "common", raising=False)
    import common

    yield common
    sys.modules.pop("common", None)


def simulate_and_check(common, case, folder, ranks=1, check=None, **options):
    folder = common.copy_inputs(INPUTS / case / "run.py", folder)
    common.load(INPUTS / case / "run.py").simulate(folder, ranks, quick=True, **options)
    findings = common.load(INPUTS / case / "check.py").check(folder, **(check or {}))
    for what, value, limit in findings:
        assert value <= limit, f"{what}: {value:.3g}, allowed {limit:g}"


def test_every_case_named_by_the_documentation_is_there():
    assert [name for name in CASES if name not in (INPUTS / "README.md").read_text()] == []


@pytest.mark.parametrize(
    "case", shared(CASES, lambda case: case not in ("ballast", "compression", "packing", "energy", "impact", "migration"))
)
def test_case(common, tmp_path, case):
    simulate_and_check(common, case, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("unloading", ["elastic", "thornton", "table"])
def test_energy_on_two_ranks_with_other_unloading(common, tmp_path, unloading):
    """The sphere slides from one rank to the other in its first contact."""
    simulate_and_check(common, "energy", tmp_path, 2, {"unloading": unloading}, unloading=unloading)


@pytest.mark.parametrize("unloading", shared(["elastic", "thornton", "table"], "thornton".__eq__))
def test_restart_with_other_unloading(common, tmp_path, unloading):
    simulate_and_check(common, "restart", tmp_path, check={"unloading": unloading}, unloading=unloading)


@pytest.mark.slow
def test_the_impact_is_that_of_python(common):
    """LAMMPS's leg of the four-way comparison; YADE's and LIGGGHTS's are in test_four_way.py."""
    rows = common.load(INPUTS / "impact" / "four_way.py").compare(others=False)
    assert len(rows) == 3
    for name, unloading, engine, _, _, force, speed in rows:
        assert engine == "LAMMPS" and max(force, speed) <= 1e-9, (name, unloading, force, speed)
