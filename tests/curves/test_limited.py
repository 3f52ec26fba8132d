"""Noisy points whose smoothed curve is stiffer than the unloading curve: limited within their noise, or refused."""

import re
import warnings

import numpy as np
import pytest

import demlaws as dl
from demlaws.errors import NotPassive, quiet

PAIR = dl.Contact(4.35e-3, 32.32e9, 2.4e-6, 2.22)
LOADS = np.linspace(1.0, 100.0, 40)


def noisy(share, seed, law="rms", loads=LOADS, contact=PAIR):
    """First loading of a law with noise of the force, over the force."""
    random = np.random.default_rng(seed)
    with quiet():
        overlap = np.asarray(dl.law(law, contact, "elastic").overlap(loads))
    return np.column_stack([overlap, loads * (1.0 + share * random.standard_normal(loads.size))])


def table_of(points, unloading="hertz", **keywords):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return dl.Table.from_points(points, PAIR, unloading, **keywords)


def returned(table, seed, cycles=12):
    """Largest work [J] that a closed cycle returns, by trapezoids of the force alone, and the largest that one takes."""
    random, end = np.random.default_rng(seed), 0.999 * table.largest_overlap
    most, taken = 0.0, 0.0
    for _ in range(cycles):
        turns = end * np.sort(random.uniform(0.0, 1.0, 2)) * 10.0 ** random.uniform(-3.0, 0.0)
        before = np.linspace(0.0, turns[0], 1500)
        cycle = np.concatenate([np.linspace(turns[0], turns[1], 1500), np.linspace(turns[1], turns[0], 1500)])
        path = table.follow(np.concatenate([before, cycle]))
        force, overlap = path.force[before.size :], path.overlap[before.size :]
        work = float(np.sum(0.5 * np.diff(overlap) * (force[1:] + force[:-1])))
        held = float(np.max(path.work))
        most, taken = max(most, -work / held), max(taken, work / held)
    return most, taken


@pytest.mark.parametrize("share", [0.01, 0.03])
def test_noise_does_not_refuse_a_pair_that_returns_no_work(share):
    """rms unloads along Hertz's curve; of 40 sets of its points 30 and 36 were refused, for 1.003 to 1.14 of its stiffness."""
    for seed in range(5):
        table = table_of(noisy(share, seed))
        most, taken = returned(table, seed)
        assert most < 1e-6 and taken > 0.0
        inside = np.linspace(table.knots.overlap[0], 0.999 * table.largest_overlap, 40)
        with quiet():
            true = dl.law("rms", PAIR, "elastic").force(inside)
        np.testing.assert_allclose(table.force(inside), true, rtol=5.0 * share)


def test_a_limited_curve_says_so_and_is_nowhere_stiffer(tmp_path):
    points = noisy(0.01, 0)
    elastic = table_of(points, "elastic")
    with pytest.warns(
        dl.ValidityWarning, match=r"at .* N the stiffness is .* N/m, that of unloading 'hertz' .* N/m \(by noise\)"
    ):
        table = dl.Table.from_points(points, PAIR, "hertz")
    loads = np.geomspace(1e-6, 99.0, 4000)
    hertz = dl.law("hertz", PAIR)
    bound = hertz.stiffness(hertz.overlap(loads))
    assert np.max(elastic.stiffness(elastic.overlap(loads)) / bound) > 1.02
    assert np.max(table.stiffness(table.overlap(loads)) / bound) <= 1.0
    assert "stiffness limited to that of unloading 'hertz'" in table.knots.smoothing
    change = np.abs(table.force(table.knots.overlap[:-1]) - elastic.knots.force[:-1])
    assert 0.1 < np.max(change / table.knots.uncertainty[:-1]) < 3.0
    read = dl.Table.load(table.save(tmp_path / "limited.tbl"))
    assert read.knots.smoothing == table.knots.smoothing
    departures = np.abs(table.force(points[:, 0]) - points[:, 1])
    assert table.knots.departure == pytest.approx(np.max(departures), rel=0.1)


@pytest.mark.parametrize("last", [10.0, 30.0])
def test_a_passive_curve_is_not_changed(last):
    """To 30 N the last cell of the table continues to 72 N, as a power law that is stiffer than Hertz's curve there."""
    points = noisy(0.001, 1, "pohrt-popov", np.linspace(0.5, last, 40))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        hertz, elastic = (dl.Table.from_points(points, PAIR, rule) for rule in ("hertz", "elastic"))
    if last == 10.0:
        np.testing.assert_array_equal(hertz.nodes.force, elastic.nodes.force)
    else:
        assert hertz.knots.smoothing.endswith("stiffness limited to that of unloading 'hertz' outside the points")
        np.testing.assert_allclose(hertz.force(points[:, 0]), elastic.force(points[:, 0]), rtol=3e-3)
        assert returned(hertz, 0)[0] < 1e-6


@pytest.mark.parametrize("stiffer", [1.05, 1.3])
def test_what_noise_does_not_explain_is_refused(stiffer):
    points = noisy(0.005, 0, "hertz", contact=PAIR.with_values(modulus=stiffer * PAIR.modulus))
    with pytest.raises(NotPassive) as refused:
        table_of(points)
    numbers = re.search(r"at (\S+) N the stiffness is (\S+) N/m, that of unloading 'hertz' (\S+) N/m", str(refused.value))
    load, stiffness, other = map(float, numbers.groups())
    hertz = dl.law("hertz", PAIR)
    assert other == pytest.approx(hertz.stiffness(hertz.overlap(load)), rel=0.01) and stiffness > other
    assert "standard uncertainty of the force is" in str(refused.value)
    table_of(points, "elastic")


def test_points_too_soft_at_small_loads_for_a_power_below_hertz():
    """Below the points the curve has the exponent of the first ones: one below 1.5 would return work at any small load."""
    overlap = np.linspace(2e-6, 8e-6, 30)
    force = 2.2e6 * overlap
    elastic = table_of(np.column_stack([overlap, force]), "elastic")
    assert elastic.stiffness(1e-8) * 1e-8 / elastic.force(1e-8) == pytest.approx(1.0, abs=1e-3)
    table = table_of(np.column_stack([overlap, force]))
    assert returned(table, 0)[0] < 1e-6
    np.testing.assert_allclose(table.force(overlap[:-1]), force[:-1], rtol=3e-3)


def test_a_curve_to_unload_along_limits_it_too():
    """Of a stiffer table: also between its rows, within both certificates."""
    points = noisy(0.01, 0)
    curve = dl.law("rms", PAIR.with_values(sigma=0.1 * PAIR.sigma), "elastic")
    table = table_of(points, curve)
    assert table.unloading == "table" and returned(table, 3)[0] < 1e-6
