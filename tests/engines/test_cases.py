"""Every case of liggghts_inputs and lammps_inputs, at its quick size, with its own check."""

import sys
from pathlib import Path

import pytest
from examples import shared

ROOT = Path(__file__).parents[2]
CASES = [(path.parts[-3].split("_")[0], path.parent.name) for path in sorted(ROOT.glob("l*_inputs/*/run.py"))]
LONG = ("ballast", "compression", "energy", "impact", "migration", "packing", "waves")


@pytest.fixture
def common(engine, monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / f"{engine}_inputs"))
    monkeypatch.delitem(sys.modules, "common", raising=False)
    import common

    yield common
    sys.modules.pop("common", None)


def simulate_and_check(common, engine, case, folder, ranks=1, check=None, **options):
    case = ROOT / f"{engine}_inputs" / case
    folder = common.copy_inputs(case / "run.py", folder)
    common.load(case / "run.py").simulate(folder, ranks, quick=True, **options)
    for what, value, limit in common.load(case / "check.py").check(folder, **(check or {})):
        assert value <= limit, f"{what}: {value:.3g}, allowed {limit:g}"


def test_the_readme_names_every_case():
    assert len(CASES) == 19
    assert not [case for engine, case in CASES if case not in (ROOT / f"{engine}_inputs" / "README.md").read_text()]


@pytest.mark.parametrize("engine, case", shared(CASES, lambda case: case[1] not in LONG))
def test_case(common, engine, case, tmp_path):
    simulate_and_check(common, engine, case, tmp_path, 2 if case in ("energy", "migration", "packing") else 1)


@pytest.mark.slow
@pytest.mark.parametrize("engine", ["lammps"])
def test_peak_force_and_rebound_agree_in_all_four(common, engine):
    rows = common.load(ROOT / "lammps_inputs" / "impact" / "four_way.py").compare()
    assert len(rows) == 12 and {row[2] for row in rows} == {"Python", "YADE", "LIGGGHTS", "LAMMPS"}
    for name, unloading, other, _, _, force, speed in rows:
        assert max(force, speed) <= 1e-9, (name, unloading, other, force, speed)
