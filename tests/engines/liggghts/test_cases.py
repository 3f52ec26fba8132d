"""Every case of liggghts_inputs, at its quick size, with its own check."""

import sys
from pathlib import Path

import pytest

INPUTS = Path(__file__).parents[3] / "liggghts_inputs"
CASES = sorted(path.parent.name for path in INPUTS.glob("*/run.py"))

pytestmark = pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")


@pytest.fixture
def common(monkeypatch):
    monkeypatch.syspath_prepend(str(INPUTS))
    monkeypatch.delitem(sys.modules, "common", raising=False)
    import common

    return common


def simulate_and_check(common, case, folder, ranks=1, **options):
    folder = common.copy_inputs(INPUTS / case / "run.py", folder)
    common.load(INPUTS / case / "run.py").simulate(folder, ranks, quick=True, **options)
    return common.load(INPUTS / case / "check.py").check(folder)


def assert_good(findings):
    for what, value, limit in findings:
        assert value <= limit, f"{what}: {value:.3g}, allowed {limit:g}"


def test_every_case_named_by_the_documentation_is_there():
    assert CASES == ["ballast", "compression", "energy", "impact", "migration", "packing", "restart", "two_spheres", "walls"]


LONG = ("migration", "packing", "ballast", "compression", "energy", "impact")


@pytest.mark.parametrize("case", [pytest.param(c, marks=[pytest.mark.slow] if c in LONG else []) for c in CASES])
def test_case(common, tmp_path, case):
    assert_good(simulate_and_check(common, case, tmp_path, 2 if case in ("energy", "migration", "packing") else 1))


@pytest.mark.parametrize(
    "case", ["two_spheres", "walls", "restart", pytest.param("migration", marks=pytest.mark.slow), "energy"]
)
@pytest.mark.parametrize("unloading", ["elastic", "table", pytest.param("thornton", marks=pytest.mark.slow)])
def test_case_with_other_unloading(common, tmp_path, case, unloading):
    folder = common.copy_inputs(INPUTS / case / "run.py", tmp_path)
    if case == "two_spheres" and unloading == "elastic":
        text = (folder / "in.two_spheres").read_text()  # an elastic law has no history to look at
        text = text.replace("c_contacts[6] c_contacts[4] c_contacts[5]", "c_contacts[4] c_contacts[4] c_contacts[4]")
        (folder / "in.two_spheres").write_text(text)
    common.load(INPUTS / case / "run.py").simulate(folder, 2 if case == "migration" else 1, True, unloading=unloading)
    assert_good(common.load(INPUTS / case / "check.py").check(folder, unloading))


def test_fine_table_in_the_engine(common, tmp_path):
    folder = common.copy_inputs(INPUTS / "two_spheres" / "run.py", tmp_path)
    common.load(INPUTS / "two_spheres" / "run.py").simulate(folder, 1, True, rtol=1e-9)
    assert_good(common.load(INPUTS / "two_spheres" / "check.py").check(folder, limit=1e-8))
