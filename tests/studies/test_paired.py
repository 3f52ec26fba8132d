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
    low, high = stats.ttest_1samp(values, 0.0).confidence_interval(0.95)
    assert found == pytest.approx((values.mean(), low, high, 4), rel=1e-12)
    assert found.excludes(0.0) and not found.excludes(1.0)
    alone = paired.interval([2.0])
    assert alone.mean == 2.0 and np.isnan(alone.low) and not alone.excludes(0.0)


def test_a_change_is_that_of_pairs():
    """A factor that every pair has is found exactly, however the samples differ; the t-test on logarithms has its interval."""
    before = np.array([3.0, 40.0, 500.0])
    assert paired.change(before, 1.31 * before)[:3] == pytest.approx((0.31, 0.31, 0.31))
    after = before * [1.2, 1.5, 1.3]
    low, high = stats.ttest_rel(np.log(after), np.log(before)).confidence_interval(0.95)
    assert paired.change(before, after)[1:3] == pytest.approx((np.expm1(low), np.expm1(high)), rel=1e-12)


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
