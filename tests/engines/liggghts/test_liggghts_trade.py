"""The scene of `python -m studies.trade` in LIGGGHTS, what a law costs there, and stock edinburgh on one contact."""

import numpy as np
import pytest
from natives import edinburgh_input

import demlaws as dl
from demlaws.liggghts import run, stock_fit
from studies.trade import candidates, packings, peers, trade
from studies.trade.__main__ import main
from studies.trade.liggghts_oedometer import edinburgh_lines

pytestmark = pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")


def test_scene():
    by_label = {way.label: way for way in candidates.ways("liggghts")}
    wanted = [by_label[n] for n in ("rough-plastic, thornton", "the same, shaken", "hertz", "LIGGGHTS's hertz")]
    rough, shaken, table, stock = packings.run("liggghts", packings.QUICK, wanted)
    # Hertz as a table is LIGGGHTS's own: the same law from the same state
    same = packings.errors(table, stock)
    assert abs(same.height) < 1e-9
    assert max(abs(same.low), abs(same.loading)) < 0.02
    chance, law = packings.errors(shaken, rough), packings.errors(table, rough)
    assert abs(chance.height) < 1e-7 < 3e-6 < law.height < 3e-5
    assert abs(chance.low) < 0.1 < 0.25 < law.low < 1.0
    assert rough.stress == pytest.approx(packings.QUICK.stress, rel=0.05)
    assert rough.low < rough.loading < rough.unloading
    assert rough.forces.mean() == pytest.approx(0.1 * packings.QUICK.largest_force, rel=0.4)


@pytest.mark.slow
def test_command(tmp_path, capsys):
    files = [tmp_path / "scene.csv", tmp_path / "scene.png"]
    assert (
        main(["--scene", "liggghts", "--quick", "--stress", "500kPa", "--csv", str(files[0]), "--figure", str(files[1])]) == 0
    )
    said = capsys.readouterr().out
    for way in candidates.ways("liggghts"):
        assert way.label in said
    rows = files[0].read_text().splitlines()
    assert len(rows) == 1 + len(candidates.ways("liggghts"))
    assert files[1].stat().st_size > 20_000


@pytest.mark.slow
def test_costs():
    found = trade.engine_trade("liggghts", quick=True)
    labels = {e.cost.way.label: e for e in found}
    # what they are is for `make bench`: no time decides here
    assert all(e.cost.step > 0.0 and 0.0 < e.cost.model < 1.0 for e in found)
    assert labels["LIGGGHTS's hertz"].error == pytest.approx(labels["hertz"].error, rel=1e-9)
    assert labels["hertz"].error > 1.0
    assert 0.5 < labels["LIGGGHTS's edinburgh"].error < labels["hertz"].error
    assert labels[candidates.RICHEST.label].error < 1e-5


def test_edinburgh_is_what_its_formula_says(tmp_path, granite_pair):
    """The force that `peers` puts on the picture against stock LIGGGHTS, loading, unloading and reloading."""
    law = dl.law("pohrt-popov", granite_pair, "hertz")
    fit = stock_fit(law, 10.0, "edinburgh")
    loading, unloading, exponent = (
        f"{fit.parameters[name]:.15g}" for name in ("LoadingStiffness", "UnloadingStiffness", "overlapExponent")
    )
    (tmp_path / "in.edinburgh").write_text(edinburgh_input(edinburgh_lines(f"1 {loading}", f"1 {unloading}", exponent)))
    young = 2.0 * granite_pair.modulus * (1.0 - 0.25**2)
    variables = {"young": repr(young), "radius": repr(2.0 * granite_pair.radius)}
    log = run(tmp_path / "in.edinburgh", 1, variables, plugin=False)
    overlap, force = log["overlap"], log["force"]
    top = int(np.argmax(overlap[: overlap.size // 3]))  # the first peak
    bottom = top + int(np.argmin(overlap[top : top + 100]))
    path = np.concatenate([[overlap[top]], overlap[top:bottom]])
    expected = peers.edinburgh_force(fit, path[None])[0, 1:]
    assert np.max(np.abs(force[top:bottom] - expected)) < 1e-6 * force[top]
    loading = overlap[1:top]
    expected = fit.parameters["LoadingStiffness"] * np.maximum(loading, 0.0) ** fit.parameters["overlapExponent"]
    assert np.max(np.abs(force[1:top] - expected)) < 1e-6 * force[top]
