"""The scene of `python -m studies.trade` in LAMMPS, what a law costs there, and `choose` for it."""

import pytest

import demlaws as dl
from demlaws.cli import main
from demlaws.errors import DemlawsError
from demlaws.lammps import export, run
from demlaws.liggghts import Grain

pytestmark = pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")


SCENE = """\
engine = "lammps"
classes = [3e-3, 5e-3]
force = [50.0, 800.0]
quantity = "overlap"
cyclic = true
yield_pressure = 1.66e9
[material]
young = 60.6e9
poisson = 0.25
hardness = 6.266e9
density = 2650.0
[surface]
roughness = 1.7e-6
fractal_dimension = 2.22
"""


@pytest.mark.slow
def test_choose_writes_a_case(tmp_path, capsys):
    (tmp_path / "scene.toml").write_text(SCENE)
    assert main(["choose", str(tmp_path / "scene.toml"), "--out", str(tmp_path / "case")]) == 0
    said = capsys.readouterr().out
    assert "chosen: rough-plastic" in said
    case = tmp_path / "case" / "in.case"
    assert f"wrote {case} and 5 table(s)" in said
    text = case.read_text()
    assert "pair_coeff 1 2 demlaws/table rough-plastic.1-2.tbl" in text
    case.write_text(text.replace("steps index 20000", "steps index 20"))
    assert run(case)["Step"][-1] == 20


def test_hertz_of_lammps_itself_as_a_case(tmp_path):
    """Two materials: E* and G* of unlike types as the table's mixing has them; stock binary, no plugin."""
    soft, stiff = dl.Material(5e9, 0.3, density=1200.0), dl.Material(60.6e9, 0.25, density=2650.0)
    grains = [Grain(r, m, dl.Surface(0.0, 2.2)) for r, m in ((0.004, soft), (0.005, stiff))]
    final = {}
    for stock in ("hertz", None):
        folder = tmp_path / str(stock)
        path = export(folder, "hertz", grains, "elastic", count=60, stock=stock, restitution=1.0)
        path.write_text(path.read_text().replace("steps index 20000", "steps index 4000"))
        if stock:
            assert not list(folder.glob("*.tbl")) and "demlaws/" not in path.read_text().split("pair_style", 1)[1]
        final[stock] = run(path, plugin=not stock)["KinEng"][-1]
    assert final["hertz"] == pytest.approx(final[None], rel=1e-4)
    with pytest.raises(DemlawsError, match="stock = 'hertz' with law 'rms'"):
        export(tmp_path, "rms", grains, stock="hertz")
