"""The scene of `python -m studies.trade` in LAMMPS, what a law costs there, and `choose` for it."""

import pytest

import demlaws as dl
from demlaws.cli import main
from demlaws.errors import DemlawsError
from demlaws.lammps import export, run
from demlaws.liggghts import Grain
from studies.trade import candidates, packings, trade
from studies.trade.__main__ import main as trade_command

pytestmark = pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")


def test_scene():
    by_label = {way.label: way for way in candidates.ways("lammps")}
    wanted = [by_label[n] for n in ("rough-plastic, thornton", "the same, shaken", "hertz", "LAMMPS's hertz/material")]
    rough, shaken, table, stock = packings.run("lammps", packings.QUICK, wanted)
    # Hertz as a table is LAMMPS's own: the same law from the same state
    same = packings.errors(table, stock)
    assert abs(same.height) < 1e-9
    assert max(abs(same.low), abs(same.loading)) < 0.02
    chance, law = packings.errors(shaken, rough), packings.errors(table, rough)
    assert abs(chance.height) < 1e-7 < 3e-6 < law.height < 3e-5
    assert abs(chance.low) < 0.1 < 0.25 < law.low < 1.0
    assert rough.stress == pytest.approx(packings.QUICK.stress, rel=0.05)
    assert rough.low < rough.loading < rough.unloading


@pytest.mark.slow
def test_costs_and_command(tmp_path, monkeypatch, capsys):
    """What they are is for `make bench`: no time decides here."""
    found = trade.engine_trade("lammps", quick=True)
    labels = {e.cost.way.label: e for e in found}
    assert all(e.cost.step > 0.0 and 0.0 < e.cost.model < 1.0 for e in found)
    assert labels["LAMMPS's hertz/material"].error == pytest.approx(labels["hertz"].error, rel=1e-9)
    assert labels[candidates.RICHEST.label].error < 1e-5
    monkeypatch.setattr(trade, "measure", lambda *a, **o: ([], 1.0))
    monkeypatch.setattr(trade, "engine_trade", lambda *a, **o: found)
    assert trade_command(["--engines", "lammps", "--law", "hertz", "--figure", str(tmp_path / "t.png")]) == 0
    said = capsys.readouterr().out
    assert "a step of LAMMPS" in said and "LAMMPS's hertz/material" in said


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
