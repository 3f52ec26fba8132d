"""Every case of lammps_inputs, at its quick size, with its own check; an exported case."""

import subprocess
import sys
from pathlib import Path

import pytest
from examples import shared

import demlaws as dl
import demlaws.lammps as lm
from demlaws import cli
from demlaws.errors import DemlawsError
from demlaws.liggghts import Grain

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


@pytest.mark.parametrize(
    "law, options, surfaces, materials, tables",
    [
        ("pohrt-popov", {}, [dl.Surface(1.7e-6, 2.22)] * 2, [GRANITE, GRANITE], 1),
        ("pohrt-popov", {}, [dl.Surface(1.7e-6, 2.22), dl.Surface(3e-6, 2.22)], [GRANITE, GRANITE], 1),
        ("rough-plastic", {"yield_pressure": 1.66e9}, [dl.Surface(1.7e-6, 2.22)] * 2, [GRANITE, dl.Material(200e9, 0.3)], 5),
    ],
)
def test_exported_case_runs(tmp_path, law, options, surfaces, materials, tables):
    """In a folder with a space in its name, started as a user does."""
    grains = [Grain(r, m, s) for r, m, s in zip((0.004, 0.005), materials, surfaces, strict=True)]
    path = lm.export(tmp_path / "my case", law, grains, options=options, count=60)
    assert len(list(path.parent.glob("*.tbl"))) == tables
    path.write_text(path.read_text().replace("steps index 20000", "steps index 5000"))
    result = subprocess.run([str(path.parent / "run.sh")], capture_output=True, text=True)
    assert result.returncode == 0, result.stdout[-1500:] + result.stderr
    log = lm.read_log(path.parent / "log.lammps")
    assert log["Step"][-1] == 5000 and log["KinEng"][-1] > 0
    assert list((path.parent / "post").glob("contacts.*")) and list((path.parent / "post").glob("grains.*"))


def test_export_refuses_nonsense(tmp_path, capsys):
    with pytest.raises(DemlawsError, match="grains is empty"):
        lm.export(tmp_path, grains=[])
    smooth = [Grain(0.004, GRANITE, dl.Surface(1.7e-6, 2.22)), Grain(0.005, GRANITE, dl.Surface(0.0, 2.22))]
    with pytest.raises(DemlawsError, match=r"smooth grain beside a rough one|roughness"):
        lm.export(tmp_path, grains=smooth)
    words = ["lammps", "export", str(tmp_path / "case"), "--radius", "0.004", "0.005", "0.006", "--sq", "1e-6", "2e-6"]
    assert cli.main(words) == 2
    assert "--sq has 2 values for 3 radii" in capsys.readouterr().err
    words = ["lammps", "export", str(tmp_path / "case"), "--radius", "0.004", "--sq", "1e-6", "--fractal-dimension", "2.2"]
    assert cli.main([*words, "--count", "40"]) == 0
    assert cli.main(["lammps", "run", str(tmp_path / "case" / "in.case"), "-var", "steps", "50"]) == 0
    assert "Loop time" in capsys.readouterr().out
