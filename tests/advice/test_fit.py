"""Fits: known parameters come back within the stated uncertainty, and the law that made the points ranks first."""

import math
from types import SimpleNamespace

import bench_fit
import numpy as np
import pytest
from bench_fit import history
from examples import shared

import demlaws as dl
from demlaws import granite
from demlaws.advice.fit_model import FORCE_ZERO
from demlaws.advice.fit_report import _aicc
from demlaws.curves.point_files import creeping_holds

PAIR = dl.Contact(4.35e-3, 32.32e9, 2.4e-6, 2.22, 6.266e9)
CYCLE = np.concatenate([np.linspace(1, 60, 20), np.linspace(58, 2, 12), np.linspace(4, 100, 20), np.linspace(95, 3, 12)])


def points(law, force, noise, seed, zero=3.1e-6):
    random = np.random.default_rng(seed)
    overlap, _ = history(law, force)
    return np.column_stack([overlap + zero + noise * random.standard_normal(force.size), force])


@pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")
def test_history_follows_the_driver():
    for name, rule in (("pohrt-popov", "hertz"), ("rough-plastic", "thornton"), ("rms", "elastic")):
        law = dl.law(name, PAIR, rule, **({"yield_pressure": 1.66e9} if name == "rough-plastic" else {}))
        path = dl.driver.force_controlled(law, [50, 5, 100, 20], 40)
        overlap, stiffness = history(law, path.force[1:])
        np.testing.assert_allclose(overlap, path.overlap[1:], rtol=1e-9)
        turning = np.isclose(path.force[1:], np.maximum.accumulate(path.force[1:]), rtol=1e-9)
        np.testing.assert_allclose(stiffness[~turning], path.stiffness[1:][~turning], rtol=1e-6)


REGULAR = ("hertz", "inside", "yield")
COVERED = [case for case in bench_fit.CASES if case.name in (*REGULAR, "at its bound", "compliance", "from afar")]


@pytest.mark.parametrize(
    "case",
    shared([(case,) for case in COVERED], lambda one: one[0].name not in ("inside", "yield", "at its bound")),
    ids=lambda case: case.name,
)
def test_coverage(case):
    """95 % intervals hold the truth in 95 % of the sets, within what 40 sets can tell; more cases and sets: `make bench`."""
    held, bias, spread = bench_fit.coverage(case, range(40))
    for name, share in held.items():
        assert share >= 0.825, (name, share)  # 38 of 40 expected; fewer than 33 has probability 1e-3
    assert abs(bias.get("modulus", 0.0)) < 0.02
    assert all(0.65 < spread[name] < 1.5 for name in case.truth if case.name in REGULAR), spread


@pytest.mark.parametrize(("kind", "least"), [("drift", 34), ("force", 30)])
def test_coverage_of_unequal_and_of_correlated_noise(kind, least):
    force = bench_fit.LOADING if kind == "drift" else CYCLE
    name, rule, key = ("hertz", "elastic", "modulus") if kind == "drift" else ("rms", "hertz", "sigma")
    law, held = dl.law(name, PAIR, rule), 0
    for seed in range(40):
        random = np.random.default_rng(seed)
        noise = random.standard_normal(force.size)
        if kind == "drift":
            for i in range(1, noise.size):
                noise[i] = 0.9 * noise[i - 1] + math.sqrt(1.0 - 0.81) * noise[i]
        measured = force + (0.3 * random.standard_normal(force.size) if kind == "force" else 0.0)
        rows = np.column_stack([history(law, force)[0] + 5e-8 * noise, measured])
        best = dl.fit(rows, PAIR.with_values(sigma=4e-6), laws=name, unloading=rule).best
        held += best.parameters[key].low <= getattr(PAIR, key) <= best.parameters[key].high
    assert held >= least


@pytest.mark.parametrize("name", shared(["pohrt-popov", "rough-plastic", "goddard"], lambda name: name != "rough-plastic"))
def test_points_without_noise(name):
    contact = PAIR.with_values(fractal_dimension=2.0)
    rows = points(dl.law("pohrt-popov", contact, "hertz"), CYCLE, 0.0, 0)
    best = dl.fit(rows, contact, laws=name, unloading="hertz").best
    if name == "pohrt-popov":
        assert best.parameters["sigma"].value == pytest.approx(2.4e-6, rel=1e-4)


def test_a_compliance_that_is_left_out_is_reported():
    case = next(case for case in bench_fit.CASES if case.name == "compliance")
    data = bench_fit.made(case, 1)
    silent = dl.fit(data, PAIR, laws="hertz").best
    assert silent.parameters["modulus"].value < 0.9 * 32.32e9
    assert any("µm/N" in note for note in silent.notes)
    for best in (
        dl.fit(data, PAIR, laws="hertz", compliance=1e-8).best,
        dl.fit(data, PAIR, laws="hertz", compliance="0.01um/N").best,
        dl.fit(data, PAIR, laws="hertz", free=("modulus", "compliance")).best,
    ):
        assert best.parameters["modulus"].low < 32.32e9 < best.parameters["modulus"].high
        assert not any("pattern" in note for note in best.notes)


def test_a_wrong_fixed_modulus_is_said():
    law = dl.law("rms", PAIR, "hertz")
    wrong = PAIR.with_values(modulus=40e9)
    best = dl.fit(points(law, CYCLE, 5e-8, 1), wrong, laws="rms", unloading="hertz").best
    assert any("E* = 40 GPa" in note for note in best.notes)
    best = dl.fit(points(law, CYCLE, 5e-8, 1), PAIR, laws="rms", unloading="hertz").best
    assert not any("pattern" in note for note in best.notes)


@pytest.mark.parametrize("told", [False, True])
def test_points_before_contact_are_cut(told):
    case = next(c for c in bench_fit.CASES if c.name.startswith("from afar") and c.told == told)
    data = bench_fit.made(case, 3)
    noise = {"displacement_noise": case.noise, "force_noise": case.force_noise} if told else {}
    ranking = dl.fit(data, PAIR, laws="hertz", **noise)
    ((count, reason),) = ranking.skipped.items()
    assert 55 <= int(count.split()[0]) <= 70
    assert ("given" in reason) == told
    assert np.all(ranking.points[0] > -1e-6 + bench_fit.MEET)


@pytest.mark.slow
def test_what_is_not_determined_is_said():
    """A yield pressure that no load reaches has a lower end only; two quantities that do the same have none that is useful."""
    law = dl.law("pohrt-popov", PAIR, "hertz")
    best = dl.fit(points(law, CYCLE, 1e-8, 1), PAIR, laws="rough-plastic", unloading="hertz").best
    estimate = best.parameters["yield_pressure"]
    assert estimate.open_end == "upper" and 2e8 < estimate.low < 1.4e9
    assert estimate.high == pytest.approx(PAIR.modulus, rel=1e-9)  # the end of the range
    few = np.linspace(90.0, 100.0, 9)
    best = dl.fit(points(dl.law("hertz", PAIR), few, 1e-6, 1), PAIR, laws="rms", free=("sigma", "modulus")).best
    assert best.parameters["sigma"].open_end == "both"


@pytest.mark.slow
def test_ranking_finds_the_law():
    law = dl.law("pohrt-popov", PAIR, "hertz")
    ranking = dl.fit(points(law, CYCLE, 5e-8, 3), PAIR.with_values(sigma=4e-6, fractal_dimension=2.4))
    assert (ranking.best.name, ranking.best.unloading) in {("pohrt-popov", "hertz"), ("rough-plastic", "hertz")}
    pohrt = next(f for f in ranking if (f.name, f.unloading) == ("pohrt-popov", "hertz"))
    assert pohrt.delta < 6.0
    assert next(f for f in ranking if (f.name, f.unloading) == ("hertz", "elastic")).delta > 50.0
    assert sum(f.weight for f in ranking) == pytest.approx(1.0)
    assert pohrt.misfit == pytest.approx(5e-8, rel=0.3)
    assert pohrt.law.force(pohrt.law.overlap(50.0)) == pytest.approx(50.0)


OFF = [case for case in bench_fit.CASES if case.name.startswith("load cell off by 0.5 N")]


@pytest.mark.parametrize("case", OFF, ids=lambda case: case.law)
def test_a_load_cell_that_is_off(case):
    """By 0.5 % of the largest force: the interval of the roughness held the truth in none of 40 sets, without a mark."""
    held, _, _ = bench_fit.coverage(case, range(40))
    assert min(held.values()) >= 0.825, held  # as above
    data = bench_fit.made(case, 0)
    free = [name for name in case.truth if name != FORCE_ZERO]
    tared = dl.fit(data - [0.0, case.truth[FORCE_ZERO]], case.contact, laws=case.law, unloading=case.unloading, free=free).best
    unknown = bench_fit.fitted(case, 0)
    for name in free:
        one, other = tared.parameters[name], unknown.parameters[name]
        assert other.high - other.low > one.high - one.low


@pytest.mark.parametrize("seed", [0, 1])
def test_the_zero_of_the_force_is_released_last(seed):
    """With a law that is not that of the points: fitted from the first step on, the zero leads to a misfit 15 % larger."""
    contact = granite.find_test("SS(12-18)").contact
    force = np.geomspace(0.05, 100.0, 60)
    rows = points(dl.law("greenwood-tripp", contact, "elastic"), force, 2e-8, seed)
    best = dl.fit(rows, contact, laws="pohrt-popov", unloading="elastic").best
    assert best.misfit < 1.93e-7, best.parameters


def test_a_straight_line_has_one_zero():
    """The zeros of displacement and force are the same along it: that of the force is not fitted."""
    law = dl.law("walton-braun", PAIR, loading_stiffness=5e6, stiffness_ratio=2.0)
    best = dl.fit(points(law, np.linspace(1, 100, 40), 1e-8, 0), PAIR, laws="walton-braun", unloading="elastic").best
    assert FORCE_ZERO not in best.parameters and best.parameters["loading_stiffness"].value == pytest.approx(5e6, rel=0.01)


def test_few_points_do_not_show_where_they_scatter_more():
    """Ten points: 62 of 150 sets were weighted as with noise of the force, and intervals held the roughness in 85 %."""
    law, force = dl.law("pohrt-popov", PAIR, "elastic"), np.linspace(1.0, 80.0, 10)
    for seed in range(6):
        best = dl.fit(points(law, force, 1e-7, seed), PAIR, laws="pohrt-popov", unloading="elastic").best
        assert not any("soft" in note for note in best.notes)


def test_rows_out_of_the_order_of_the_test():
    """Sorted by force the rows of a cycle alternate between loading and unloading: intervals of a wrong law, unmarked."""
    law = dl.law("pohrt-popov", PAIR, "hertz")
    rows = points(law, np.concatenate([np.linspace(1, 80, 60), np.linspace(78, 4, 60)]), 3e-8, 0)
    best = dl.fit(rows[np.argsort(rows[:, 1])], PAIR, laws="pohrt-popov").best
    assert best.systematic and any("deviate to opposite sides" in note for note in best.notes)
    assert not dl.fit(rows, PAIR, laws="pohrt-popov", unloading="hertz").best.systematic


def test_rows_sorted_by_displacement():
    """2 of 20 fits were wrong without a mark: a cycle with little hysteresis is then a curve with scatter of the force."""
    law = dl.law("rms", PAIR, "hertz")
    for seed in range(4):
        rows = points(law, CYCLE, 3e-8, seed)
        best = dl.fit(rows[np.argsort(rows[:, 0])], PAIR, laws="rms").best
        assert any("sorted by displacement" in note for note in best.notes)
    loading = points(dl.law("rms", PAIR, "elastic"), np.linspace(1.0, 100.0, 60), 3e-8, 0)
    for honest in (rows, loading):
        assert not any("sorted" in note for note in dl.fit(honest, PAIR, laws="rms").best.notes)


def test_systematic_misfit_is_said():
    law = dl.law("pohrt-popov", PAIR, "elastic")
    force = np.linspace(1, 100, 60)
    best = dl.fit(points(law, force, 1e-9, 0), PAIR, laws="hertz").best
    assert any("systematic" in note for note in best.notes)


MISSED = {
    ("bahrami", "elastic"): (5,),
    ("rough-plastic", "elastic"): (19, 34),
    ("rough-plastic", "hertz"): (11, 32),
    ("rough-plastic", "thornton"): (22, 33),
    ("conical-damage", "elastic"): (1, 39),
    ("conical-damage", "thornton"): (12, 38),
    ("luding", "elastic"): (0, 39),
    ("luding", "linear"): (3, 39),
}
"""Truths that the search missed when it started from one set of pressures for all loads."""


@pytest.mark.parametrize("name", shared(bench_fit.fitted_rules(), lambda name: name not in ("yip-venart", "rough-plastic")))
def test_a_law_finds_itself(name):
    misfits = {}
    for rule in bench_fit.fitted_rules()[name]:
        for number, misfit in bench_fit.recovery(name, rule, MISSED.get((name, rule), (0,))):
            misfits[rule, number] = misfit
    assert misfits and max(misfits.values()) <= bench_fit.RECOVERED, misfits


def test_the_law_that_made_the_points_is_not_rejected():
    law, force = dl.law("rough-plastic", PAIR, yield_pressure=0.8e9), np.linspace(1.5, 148.0, 50)  # yields at 52 N
    rows = points(law, force, 2e-8, 1)
    ranking = dl.fit(rows, PAIR, laws=["hertz", "goddard", "rough-plastic"])
    assert ranking.best.name == "rough-plastic" and not ranking.best.systematic
    estimate = ranking.best.parameters["yield_pressure"]
    assert estimate.low < 0.8e9 < estimate.high < 0.81e9
    wrong = dl.fit(rows, PAIR, laws=["hertz", "goddard"])
    assert wrong.best.weight > 0.999 and wrong.best.systematic
    text = str(wrong).splitlines()
    assert "no law" in text[0]
    assert all("systematic" in line for line in text[2:])
    told = dl.fit(rows, PAIR, laws=["hertz", "rough-plastic"], displacement_noise=2e-8)
    assert [fit.systematic for fit in told] == [False, True]


GOOD = points(dl.law("hertz", PAIR), np.linspace(1, 9, 9), 0.0, 0)
MASKED = np.ma.array(GOOD, mask=np.arange(18).reshape(9, 2) == 8)


@pytest.mark.parametrize(
    ("rows", "options"),
    [
        ([1.0, 2.0, 3.0], {}),
        ([[1e-6, np.nan]] * 9, {}),
        ([[1e-6, 1.0], [2e-6, 2.0]], {}),
        ([[1e-6, 1.0]] * 9, {"free": ["colour"]}),
        ([[1e-6, 1.0]] * 9, {}),
        ([[1e-6, 1.0]] * 9, {"force_noise": 0.1}),
        *((GOOD, {"options": bad}) for bad in ({"hertzz": {}}, {"hertz": 3}, [1])),
        (MASKED, {}),
    ],
)
def test_bad_points(rows, options):
    dl.fit(GOOD, PAIR, laws="hertz")
    with pytest.raises(dl.DemlawsError):
        dl.fit(rows, PAIR, laws="hertz", **options)


def test_rounding_is_no_systematic_misfit():
    """Of points without noise the law that made them was marked, with a misfit of 4e-16 µm."""
    exact = points(dl.law("hertz", PAIR), np.linspace(0.01, 9, 59), 0.0, 0)
    assert not dl.fit(exact, PAIR, laws="hertz").best.systematic
    assert dl.fit(exact, PAIR, laws="rms").best.systematic


def test_points_in_other_units_are_not_fitted():
    """Micrometres, columns exchanged, approach counted as negative: fits gave a modulus at its bound, contacts 10 m deep."""
    good = points(dl.law("hertz", PAIR), np.linspace(1, 90, 20), 0.0, 0)
    for other in (good * [1e6, 1.0], good[:, ::-1], good * [1e3, 1.0] * 1e2):
        with pytest.raises(dl.DemlawsError):
            dl.fit(other, PAIR, laws="hertz")
    with pytest.raises(dl.DemlawsError):
        dl.fit(good * [-1.0, 1.0], PAIR, laws="hertz")
    far = good + np.outer(good[:, 1], [9e-5, 0.0])  # an apparatus that gives way by more than R, and is fitted
    best = dl.fit(far, PAIR, laws="hertz", free=["compliance"]).best
    assert best.parameters["compliance"].value == pytest.approx(9e-5, rel=1e-6)


def test_nothing_but_the_zero_is_fitted_where_nothing_is_free():
    rows = points(dl.law("rms", PAIR), np.linspace(1, 90, 20), 1e-8, 0)
    best = dl.fit(rows, PAIR, laws="rms", free=[]).best
    assert best.coordinates == ("zero",)
    assert best.contact == PAIR


def test_a_fitted_unloading_branch_is_a_curve_to_unload_along():
    """Points of an unloading branch alone, of a contact that loading has made smoother: fitted, then joined to the law."""
    law = dl.law("pohrt-popov", PAIR, dl.law("pohrt-popov", PAIR.with_values(sigma=0.2 * PAIR.sigma)))
    path = dl.driver.force_controlled(law, [50.0, 0.2], 40)
    branch = np.column_stack([path.overlap, path.force])[41:]
    best = dl.fit(branch, PAIR, laws="pohrt-popov", unloading="elastic", free=["sigma"]).best
    assert best.law.contact.sigma == pytest.approx(0.2 * PAIR.sigma, rel=1e-4)
    assert best.parameters["zero"].value == pytest.approx(path.plastic_overlap[-1], rel=1e-4)
    again = dl.law("pohrt-popov", PAIR, unloading=best.law).follow(path.overlap)
    np.testing.assert_allclose(again.force, path.force, atol=1e-4 * path.force.max())
    with pytest.raises(dl.DemlawsError):
        dl.fit(branch, PAIR, laws="pohrt-popov", unloading="table")


@pytest.mark.parametrize("count", [1, 3])
def test_akaikes_criterion_counts_the_scatter(count):
    """-2 ln L + 2k + 2k(k+1)/(n-k-1); k: parameters, the scatter where it is not known. (Fits print differences only.)"""
    sigma, squares = np.full(12, 0.2), 7.0
    model = SimpleNamespace(force=np.ones(12), sigma=sigma)

    def corrected(minus_two_log, k):
        return minus_two_log + 2.0 * k + 2.0 * k * (k + 1.0) / (12.0 - k - 1.0)

    known = squares + 2.0 * np.sum(np.log(sigma)) + 12.0 * math.log(2.0 * math.pi)
    assert _aicc(model, squares, count, True) == pytest.approx(corrected(known, count), rel=1e-12)
    estimated = 12.0 * (math.log(2.0 * math.pi * 0.2**2 * squares / 12.0) + 1.0)
    assert _aicc(model, squares, count, False) == pytest.approx(corrected(estimated, count + 1), rel=1e-12)


@pytest.mark.parametrize("name", shared(["thornton-ning", "rough-plastic"], lambda name: name == "thornton-ning"))
def test_no_yield_is_found_where_there_is_none(name):
    """Hertz to 100 N, yield from 428 N: p_y = 0.98 [0.95, 1.00] GPa; 17 of 40 intervals were closed above and wrong."""
    smooth = PAIR.with_values(sigma=0.0, fractal_dimension=None, hardness=None)
    law = dl.law("hertz", smooth) if name == "thornton-ning" else dl.law("pohrt-popov", PAIR, "hertz")
    rule, held = ("thornton", 0) if name == "thornton-ning" else ("hertz", 0)
    for seed in range(8):
        rows = points(law, CYCLE, 5e-8, 1000 + seed)
        best = dl.fit(rows, smooth if name == "thornton-ning" else PAIR, laws=name, unloading=rule).best
        held += best.parameters["yield_pressure"].high >= 1.66e9
    assert held >= 7


def test_a_hold_and_a_line_without_a_second_zero():
    """KeyError: 'force_zero'."""
    with pytest.raises(dl.DemlawsError, match="a hold"):
        dl.fit(np.column_stack([np.linspace(1e-6, 1.2e-6, 40), np.full(40, 5.0)]), PAIR, laws="rms")
    curved = points(dl.law("hertz", PAIR), np.linspace(1, 100, 40), 5e-8, 0)
    assert dl.fit(curved, PAIR, laws="luding").best.systematic


HOLDS = [case for case in bench_fit.CASES if case.name.startswith("holds")]


@pytest.mark.parametrize(
    "case", shared([(case,) for case in HOLDS], lambda one: "pohrt" in one[0].name), ids=lambda case: case.name
)
def test_creeping_holds_are_left_out(case):
    """With them 71 of 100 intervals contained the fractal dimension, 17 tests without a note; more sets: `make bench`."""
    held, _, _ = bench_fit.coverage(case, range(24))
    assert min(held.values()) >= 0.79, held  # 19 of 24 have probability 1e-2
    points = bench_fit.made(case, 0)
    ranking = dl.fit(points, PAIR, laws=case.law, unloading=case.unloading)
    assert "58 rows at constant force" in ranking.skipped and not ranking.best.systematic
    assert "at 60 N" in ranking.skipped["58 rows at constant force"] and ranking.points[1].size == points.shape[0] - 58
    # nothing crept: all rows stay
    silent = case._replace(truth={name: value for name, value in case.truth.items() if "creep" not in name})
    assert dl.fit(bench_fit.made(silent, 2), PAIR, laws=case.law, unloading=case.unloading).skipped == {}


@pytest.mark.parametrize("noise", [0.0, 0.05, 0.3])
def test_holds_are_found_and_nothing_else(noise):
    """A hold of 15 rows by its creep of 0.1 µm; none in tests without holds, dense ones and ones of small forces too."""
    random, found = np.random.default_rng(3), []
    held = np.insert(CYCLE, 20, np.full(15, 60.0))
    creep = 1e-7 * np.interp(np.arange(held.size), np.arange(19, 35), np.log1p(np.arange(16)) / math.log(16.0))
    for _ in range(20):
        for force in (CYCLE, np.geomspace(0.5, 100.0, 60), np.linspace(0.1, 100.0, 2000), held):
            overlap = 5e-6 * (force / 100.0) ** (2 / 3) + (creep if force is held else 0.0)
            rows = overlap + 2e-8 * random.standard_normal(force.size), force + noise * random.standard_normal(force.size)
            found.append(creeping_holds(*rows))
    assert sum(map(len, found[::4] + found[1::4] + found[2::4])) <= 1
    exact = [one for one in found[3::4] if len(one) == 1 and abs(one[0][0] - 19) <= 2 and abs(one[0][1] - 34) <= 2]
    assert len(exact) >= 16


def test_a_hold_at_an_end_of_the_test():
    """No creep to fit before the first row of the test or behind the last one."""
    law = dl.law("hertz", PAIR)
    force = np.concatenate([np.full(20, 5.0), np.linspace(8.0, 100.0, 30), np.full(20, 100.0)])
    rows = points(law, force, 5e-9, 1)
    rows[:20, 0] -= 1e-7 * np.linspace(1.0, 0.0, 20)
    rows[49:, 0] += 1e-7 * np.linspace(0.0, 1.0, 21)
    ranking = dl.fit(rows, PAIR, laws="hertz")
    assert not any("creep" in name for name in ranking.best.parameters) and "39 rows at constant force" in ranking.skipped
    assert ranking.best.parameters["modulus"].low < PAIR.modulus < ranking.best.parameters["modulus"].high


def test_scatter_that_no_load_cell_has_is_systematic():
    """Rows sorted by displacement: σ = 0.0004 µm for 2.4 µm, with weights that differ 10,000-fold, unmarked."""
    law = dl.law("rms", PAIR, "hertz")
    rows = points(law, CYCLE, 3e-8, 1)
    best = dl.fit(rows[np.argsort(rows[:, 0])], PAIR, laws="rms").best
    assert best.systematic and any("order of the test" in note for note in best.notes)


DRIFTS = [case for case in bench_fit.CASES if case.name.startswith("drift")]


@pytest.mark.parametrize(
    "case", shared([(case,) for case in DRIFTS], lambda one: "rms" in one[0].name), ids=lambda case: case.name
)
def test_a_steady_drift_is_fitted(case):
    """By 0.4 µm over a cycle, unless it is left out: intervals of 20 of 40 sets missed the roughness, 10 of them unmarked."""
    held, _, _ = bench_fit.coverage(case, range(24))
    assert min(held.values()) >= 0.79, held  # 19 of 24 have probability 1e-2
    tared = dl.fit(bench_fit.made(case, 0), PAIR, laws=case.law, unloading=case.unloading, free=["sigma", "force_zero"]).best
    if case.truth["drift"] != 0.0:
        assert any("may drift" in note for note in tared.notes) or tared.systematic


def test_loading_alone_does_not_show_a_drift():
    rows = points(dl.law("rms", PAIR, "elastic"), np.linspace(1.0, 100.0, 60), 2e-8, 0)
    assert "drift" not in dl.fit(rows, PAIR, laws="rms").best.parameters
    few = points(dl.law("rms", PAIR, "hertz"), CYCLE[::11], 2e-8, 0)
    assert "drift" not in dl.fit(few, PAIR, laws="rms", unloading="hertz").best.parameters


def test_unloading_alone_does_not_show_a_drift():
    """A drift in proportion to the rows is a compliance there: the modulus was 23 GPa for 32.32."""
    loads = np.linspace(100.0, 1.0, 30)
    overlap = dl.law("hertz", PAIR).overlap(loads) + 5e-8 * np.random.default_rng(8).standard_normal(loads.size)
    best = dl.fit(np.column_stack([overlap, loads]), PAIR, "hertz", unloading="elastic").best
    assert "drift" not in best.parameters
    assert best.contact.modulus == pytest.approx(PAIR.modulus, rel=0.02)


def test_outliers_are_named():
    """Two readings of 64 were off by 0.5 µm: intervals 10 times as wide, without a word."""
    law = dl.law("rms", PAIR, "hertz")
    rows = points(law, CYCLE, 2e-8, 0)
    assert not any("far from" in note for note in dl.fit(rows, PAIR, laws="rms", unloading="hertz").best.notes)
    rows[[10, 40], 0] += [5e-7, -5e-7]
    notes = dl.fit(rows, PAIR, laws="rms", unloading="hertz").best.notes
    text = next(note for note in notes if "far from" in note)
    assert f"{rows[10, 1]:.4g} N at {1e6 * rows[10, 0]:.4g} µm" in text and f"{rows[40, 1]:.4g} N" in text
    assert text.startswith("2 points")


def test_repeated_readings_are_no_systematic_misfit():
    """Each row four times: neighbours deviate alike, by which the right law was marked."""
    rows = points(dl.law("hertz", PAIR), np.linspace(1, 100, 40), 5e-8, 0)
    ranking = dl.fit(np.repeat(rows, 4, axis=0), PAIR, laws="hertz")
    assert not ranking.best.systematic and "120 repeated rows" in ranking.skipped
