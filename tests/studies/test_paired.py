"""Paired changes and intervals, against scipy, and the pairs of kept runs that pages name."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

from studies import paired

RUNS = Path(paired.__file__).parent / "shear" / "vibration.jsonl"


def test_intervals_are_students():
    values = np.array([1.3, 1.7, 0.9, 1.1])
    found = paired.interval(values)
    test = stats.ttest_1samp(values, 0.0)
    assert found == pytest.approx((values.mean(), *test.confidence_interval(0.95), 4, test.pvalue), rel=1e-12)
    other = paired.interval(values, expected=1.0)
    assert other.p == pytest.approx(stats.ttest_1samp(values, 1.0).pvalue) and other[:4] == found[:4]
    alone = paired.interval([2.0])
    assert alone.mean == 2.0 and np.isnan(alone.low) and np.isnan(alone.p)


def test_clear_effects_are_those_of_benjamini_and_hochberg():
    """Against the procedure step by step, at the limit, and with effects that have no p."""
    random = np.random.default_rng(7)
    for count in (1, 2, 20, 48):
        p = np.where(random.random(count) < 0.4, 1e-3 * random.random(count), random.random(count))
        estimates = [paired.Estimate(1.0, 0.0, 2.0, 3, value) for value in p]
        found = next((k for k in range(count, 0, -1) if sorted(p)[k - 1] <= 0.05 * k / count), 0)
        assert list(paired.clear(estimates)) == [value in sorted(p)[:found] for value in p]
    p = (0.04, 0.05, np.nan, 0.6)  # 0.05 is above 0.05 · 2/3
    estimates = [None, *(paired.Estimate(1.0, 0.0, 2.0, 3, value) for value in p)]
    assert not paired.clear(estimates).any()
    p = (0.03, 0.001, 0.05, 0.06)  # 0.03 is above 0.025
    assert list(paired.clear([paired.Estimate(1.0, 0.0, 2.0, 3, value) for value in p])) == [False, True, False, False]
    p = (0.04, 0.045, 0.03)  # the largest is below its limit, so that all are
    assert paired.clear([paired.Estimate(1.0, 0.0, 2.0, 3, value) for value in p]).all()


def test_a_change_is_that_of_pairs():
    """A factor that every pair has is found exactly, however the samples differ; the t-test on logarithms has its interval."""
    before = np.array([3.0, 40.0, 500.0])
    assert paired.change(before, 1.31 * before)[:3] == pytest.approx((0.31, 0.31, 0.31))
    after = before * [1.2, 1.5, 1.3]
    test = stats.ttest_rel(np.log(after), np.log(before))
    expected = *np.expm1(test.confidence_interval(0.95)), 3, test.pvalue
    assert paired.change(before, after)[1:] == pytest.approx(expected, rel=1e-12)


def test_scatter_is_pooled_by_degrees_of_freedom():
    groups = ([1.0, 3.0], [10.0, 10.0], [5.0], [0.0, 1.0, 2.0])
    deviation, freedom = paired.pooled(groups)
    assert (deviation, freedom) == pytest.approx((1.0, 4))
    found = paired.interval([0.0, 2.0], deviation, freedom)
    assert found.high == pytest.approx(1.0 + stats.t.ppf(0.975, 4) / np.sqrt(2.0))


def test_oedometers_with_levels_and_with_history():
    """Settlement [µm] in 300 cycles from the same places: the difference of docs/shear.md."""
    rows = [json.loads(line) for line in RUNS.read_text().splitlines()]
    settled = {
        (row["model"], row["shaken"]): 1e6 * (row["rows"][0][2] - row["rows"][-1][2])
        for row in rows
        if row["scene"] == "oedometer" and row["cycles"] == 300
    }
    found = paired.interval(settled["3 levels", seed] - settled["own", seed] for seed in range(8))
    assert found[:3] == pytest.approx((3.9, -11.7, 19.5), abs=0.06)
