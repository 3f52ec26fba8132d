"""The scene of `python -m studies.trade` in YADE, what a law costs there, and its Conical Damage Model on one contact."""

import numpy as np
import pytest

import demlaws as dl
from studies.costs.costs import under_yade
from studies.trade import candidates, packings, peers, trade

HERTZ = candidates.Way("hertz", "hertz", shear="native")
NATIVE = candidates.Way("YADE's Hertz-Mindlin", model="hertz")
PAIR = dl.Contact(4.35e-3, 32.32e9, 2.40e-6, 2.22, 6.266e9)


@pytest.mark.slow
def test_scene():
    wanted = [candidates.RICHEST, candidates.RICHEST._replace(label="the same, shaken", shaken=True), HERTZ, NATIVE]
    said = []
    rough, shaken, hertz, native = packings.run("yade", packings.QUICK, wanted, said.append)
    assert len(said) == 4
    same = packings.errors(hertz, native)
    assert abs(same.height) < 1e-9
    assert max(abs(same.low), abs(same.loading)) < 0.01
    # chance is less than what the law makes
    chance, law = packings.errors(shaken, rough), packings.errors(hertz, rough)
    assert abs(chance.height) < 1e-7 < 3e-6 < law.height < 3e-5  # grains on rough contacts sink by micrometres
    assert abs(chance.low) < 0.05 < 0.2 < law.low < 1.0
    for found in (rough, hertz):
        assert found.stress == pytest.approx(packings.QUICK.stress, rel=0.05)
        assert found.low < found.loading < found.unloading
        assert 200 < found.forces.size < 400
        # the mean force of a packing under this stress (Rothenburg & Bathurst)
        assert found.forces.mean() == pytest.approx(0.1 * packings.QUICK.largest_force, rel=0.4)


@pytest.mark.slow
def test_the_conical_damage_model_is_hertz_until_it_yields():
    hertz = dl.law("hertz", PAIR)
    peaks = np.array([1.0, 30.0])
    assert peers.cdm_error(hertz, peaks, 5e9)[0] < 1e-6
    overlaps, forces = peers.reference_paths(hertz, peaks)
    given = {"young": 60.6e9, "poisson": 0.25, "density": 2650.0, "radius": 8.7e-3, "paths": overlaps.tolist()}
    weak = np.array(under_yade("costs/yade_cost.py", {**given, "ways": [{"model": "cdm", "cdm": (0.5e9, 0.5)}]}))[0]
    assert weak[1, 0] < 0.5 * forces[1, 0]
    assert np.all(np.diff(weak[1]) <= 0.0)


@pytest.mark.slow
def test_costs_and_peers_on_the_picture(tmp_path):
    from demlaws import plots
    from studies.trade import figure as pictures

    cdm = candidates.Way("YADE's Conical Damage Model", model="cdm")
    found = trade.engine_trade("yade", quick=True, chosen=[candidates.RICHEST, HERTZ, NATIVE, cdm])
    labels = {e.cost.way.label: e for e in found}
    native, cone = labels["YADE's Hertz-Mindlin"], labels["YADE's Conical Damage Model"]
    hertz, richest = labels["hertz"], labels[candidates.RICHEST.label]
    assert native.error == pytest.approx(hertz.error, rel=1e-9)
    assert native.error > 1.0
    assert 0.0 < cone.error <= 1.01 * native.error  # below its strength it is Hertz
    assert richest.error < 1e-12
    assert richest.front
    # what they are is for `make bench`: no time decides here
    assert all(e.cost.over_hertz > 0.0 and e.cost.step > 0.0 for e in found)
    figure = plots.save(pictures.trade_figure([], 1.0, (), {"yade": found}), tmp_path / "yade.png")
    assert figure.stat().st_size > 10_000
    assert "Law2" in trade.engine_table(found)
