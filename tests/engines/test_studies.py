"""What the studies ask of YADE, LIGGGHTS and LAMMPS, in small: the trade's scene, the extremes, kept places."""

import numpy as np
import pytest
from examples import shared

from studies.extremes import extremes, report
from studies.extremes.plugin_extremes import Plugin
from studies.trade import candidates, lammps_oedometer, liggghts_oedometer, packings
from studies.validation import engines
from studies.validation.jobs import kept_jobs
from studies.validation.published import KEPT, kept_rows

NATIVE = {"yade": "YADE's Hertz-Mindlin", "liggghts": "LIGGGHTS's hertz", "lammps": "LAMMPS's hertz/material"}
NAMES = {"yade": "YADE", "liggghts": "LIGGGHTS", "lammps": "LAMMPS"}
each = pytest.mark.parametrize("engine", NATIVE)
plugins = pytest.mark.parametrize("engine", ["liggghts", "lammps"])


@pytest.mark.parametrize("engine", shared(NATIVE, "liggghts".__eq__))
def test_scene_of_the_trade(engine):
    by_label = {way.label: way for way in candidates.ways(engine)}
    wanted = [by_label[n] for n in (candidates.RICHEST.label, "the same, shaken", "hertz", NATIVE[engine])]
    rough, shaken, hertz, native = packings.run(engine, packings.QUICK, wanted)
    # Hertz by our functor or as a table is the engine's own, but for its passive shear: the same law from the same state
    same = packings.errors(hertz, native)
    assert abs(same.height) < 1e-7
    assert max(abs(same.low), abs(same.loading)) < 0.02
    # chance is less than what the law makes; grains on rough contacts sink by micrometres
    chance, law = packings.errors(shaken, rough), packings.errors(hertz, rough)
    assert abs(chance.height) < 1e-7 < 3e-6 < law.height < 3e-5
    assert abs(chance.low) < 0.1 < 0.2 < law.low < 1.0
    assert rough.stress == pytest.approx(packings.QUICK.stress, rel=0.05)
    assert rough.low < rough.loading < rough.unloading
    # the mean force of a packing under this stress (Rothenburg & Bathurst)
    assert rough.forces.mean() == pytest.approx(0.1 * packings.QUICK.largest_force, rel=0.4)


@pytest.mark.slow
@pytest.mark.parametrize("engine", ["lammps"])
def test_stiffness_of_the_packing_on_two_ranks_and_in_liggghts(engine, tmp_path):
    """Within the scatter of runs from shaken positions; at least 2 %, since one slip changes a slope by as much."""
    setup, way = packings.QUICK, candidates.RICHEST._replace(rtol=1e-5)
    radii, centres = packings.packing(setup)
    given, words = setup.given(radii, centres), {**way._asdict(), "options": dict(way.options)}
    runs = [(lammps_oedometer, {"ranks": 2}, 0), (liggghts_oedometer, {}, 0)]
    runs += [(lammps_oedometer, {}, seed) for seed in (0, 1, 2, 3)]
    outcomes = []
    for number, (module, options, seed) in enumerate(runs):
        shift = packings.SHAKEN * np.random.default_rng(seed).uniform(-1.0, 1.0, centres.shape) * radii.min() * (seed > 0)
        places = {**given, "centres": (centres + shift).tolist()}
        outcomes.append(packings.outcome(way, setup, module.oedometer(tmp_path / str(number), places, words, **options)))
    for quantity in ("low", "loading", "unloading"):
        others, chance = np.split([getattr(outcome, quantity) for outcome in outcomes], [2])
        limit = max(0.02, 2 * np.ptp(chance) / chance.mean())
        assert others == pytest.approx(np.full(2, chance.mean()), rel=limit), quantity
    assert max(abs(outcome.height - outcomes[2].height) for outcome in outcomes[:2]) <= 1e-7


@pytest.mark.slow
@each
def test_extremes(engine):
    figures = list(extremes.run(NAMES[engine], ["pohrt-popov", "rough-plastic"], ["hertz"], quick=True, stops=False))
    assert [(f.engine, f.law) for f in figures] == [(NAMES[engine], law) for law in ("pohrt-popov", "rough-plastic")]
    assert report.failures(figures) == []
    assert all(p.contacts > 100 for f in figures for p in f.packings.values())


@pytest.mark.parametrize(
    "touching, where, value, messages",
    [
        pytest.param(True, "velocity", "nan", ["particle 3 is at (nan, 0, 0) m"] * 2, marks=pytest.mark.slow),
        (False, "position", "nan", ["particle 3 is at (nan, 0, 0) m"] * 2),
        # the engines' own checks, of a particle beyond the box and of coordinates
        pytest.param(True, "position", "inf", ["Lost atoms", "Non-numeric atom coords"], marks=pytest.mark.slow),
    ],
)
@plugins
def test_numbers_that_are_not_finite_stop(engine, touching, where, value, messages):
    assert messages[engine == "lammps"] in Plugin(NAMES[engine]).stopped_by(touching, where, value)


@pytest.mark.parametrize("engine", [pytest.param("yade", marks=pytest.mark.slow), "liggghts", "lammps"])
def test_the_places_that_lammps_keeps_are_met(engine):
    """LAMMPS's own DEM tests 02 and 03, with the law in place of stock hertz."""
    found = getattr(engines, f"in_{engine}")(kept_jobs())
    rows = [row for one, answer in zip(KEPT, found, strict=True) for row in kept_rows(one, NAMES[engine], answer["places"])]
    assert len(rows) == 6 and [row for row in rows if row.verdict != "pass"] == []
