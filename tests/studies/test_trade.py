"""The trade of speed for accuracy: errors fall with table size and with the step, the front is a front."""

import itertools

import numpy as np
import pytest

import demlaws as dl
from demlaws.liggghts import stock_fit
from studies.trade import candidates, packings, peers, trade
from studies.trade.__main__ import main


@pytest.fixture(scope="module")
def measured():
    return trade.measure(["hertz", "pohrt-popov", "rough-plastic"], count=20_000, rounds=2)


@pytest.mark.slow
def test_entries(measured):
    entries, floor = measured
    assert floor > 0.0
    assert all(e.ns > 0.0 for e in entries)
    closed = {e[:2]: e for e in entries if e.evaluation == "closed form"}
    assert closed["rough-plastic", "thornton"].richest["force"] < 1e-12
    assert closed["pohrt-popov", "hertz"].richest["stiffness"] > 0.01  # the bulk yields
    given = {e.evaluation: e for e in entries if e[:2] == ("pohrt-popov", "table")}  # along a given curve
    assert {"closed form", "table"} <= set(given) and given["closed form"].own["force"] < 1e-12
    assert given["closed form"].state_bytes == 16 and given["closed form"].richest["energy"] > 0.0
    tables = [e for e in entries if e[:3] == ("pohrt-popov", "hertz", "table")]
    assert len(tables) >= 4
    errors = [e.own["stiffness"] for e in tables]
    assert all(a > b for a, b in itertools.pairwise(errors))
    assert [e.rows for e in tables] == sorted(e.rows for e in tables)


@pytest.mark.slow
def test_front(measured):
    entries, _ = measured
    front = sorted((e for e in entries if e.front), key=lambda e: e.ns)
    assert len(front) >= 2
    for e in entries:
        assert any(f.ns <= e.ns and trade.GAIN * f.richest["force"] <= e.richest["force"] for f in front)


def test_steps():
    entries = trade.steps_trade(2.0, speeds=(0.1,), phases=2)
    gains = np.array([e.gain for e in entries])
    assert gains[0] > 1e-2
    assert gains[-1] < 1e-9
    assert entries[-1].rebound_error < 1e-6


def test_command(tmp_path, capsys):
    arguments = ["--law", "hertz", "--contacts", "1e4", "--rounds", "2"]
    assert main([*arguments, "--csv", str(tmp_path / "t.csv"), "--figure", str(tmp_path / "t.png")]) == 0
    assert "Pareto" in capsys.readouterr().out
    assert main(["--law", "nonsense"]) == 2
    assert dl.laws()[0] in capsys.readouterr().err


def test_pareto():
    points = [(2.0, 1.0), (1.0, 5.0), (3.0, 0.999), (4.0, 0.5), (2.0, 0.9)]
    assert trade.pareto(points) == {1, 4, 3}


def test_scene_figures_of_merit():
    height = np.linspace(0.1, 0.0999, 50)
    stress = 3e8 * (0.1 - height) / 0.1
    assert packings.slope(height, stress, 0.0, 1e9, 0.1) == pytest.approx(3e8, rel=1e-9)
    with pytest.raises(dl.DemlawsError, match="rows of the run"):
        packings.slope(height, stress, 1e9, 2e9, 0.1)
    forces = np.random.default_rng(1).exponential(5.0, 4000)
    one = packings.Outcome(candidates.RICHEST, 1e-2, 1e8, 2e8, 3e8, 5e5, forces, 100, 1.0)
    other = one._replace(height=1.1e-2, low=1.2e8, forces=2.0 * forces)
    found = packings.errors(other, one)
    assert found.height == pytest.approx(1e-3)
    assert found.low == pytest.approx(0.2)
    assert found.distance == 0.0  # forces count over their mean
    narrow = one._replace(forces=np.full(4000, 5.0))
    assert packings.errors(narrow, one).distance == pytest.approx(1.0 - np.exp(-1.0), abs=0.02)
    assert "rough-plastic, thornton" in packings.table([one, other], packings.QUICK)


@pytest.mark.parametrize("setup", [packings.QUICK, packings.Setup()])
def test_packing(setup):
    """What every way starts from: the grains that the setup names, touching by less than granite's overlap at rest."""
    radii, centres = packings.packing(setup)
    assert len(radii) == setup.count
    assert np.allclose(radii, setup.start()[1], atol=1e-11)
    gap = np.linalg.norm(centres[:, None] - centres[None], axis=2) - radii[:, None] - radii[None]
    touching = np.sum(np.triu(gap < 0.0, 1))
    assert touching > 1.6 * setup.count
    assert np.min(gap[~np.eye(setup.count, dtype=bool)]) > -1e-6
    assert centres.min() > 0.0
    assert centres[:, :2].max() < setup.width


def test_edinburgh_meets_the_law_at_its_load():
    law = dl.law("pohrt-popov", trade.GRANITE, "hertz")
    fit = stock_fit(law, 20.0, "edinburgh")
    overlaps, _ = peers.reference_paths(law, np.array([20.0]))
    found = peers.edinburgh_force(fit, overlaps)
    assert found[0, 0] == pytest.approx(20.0, rel=1e-12)
    assert np.all(np.diff(found[0]) <= 0.0)
    largest, mean, load = peers.edinburgh_error(law, np.geomspace(5.0, 20.0, 5))
    assert 0.0 < mean < largest < 0.2
    assert 5.0 <= load <= 20.0


def test_missing_engines_are_one_line(monkeypatch, capsys):
    monkeypatch.setenv("YADE", "nowhere")
    monkeypatch.setenv("DEMLAWS_LIGGGHTS", "nowhere")
    monkeypatch.setenv("DEMLAWS_LAMMPS", "nowhere")
    for arguments, named in (
        (["--scene", "yade"], "no 'nowhere' command was found"),
        (["--scene", "liggghts"], "'nowhere' not found"),
        (["--engines", "liggghts"], "'nowhere' not found"),
        (["--engines"], "no 'nowhere' command was found"),
    ):
        assert main([*arguments]) == 2
        said = capsys.readouterr().err
        assert named in said
        assert len(said.strip().splitlines()) == 1
