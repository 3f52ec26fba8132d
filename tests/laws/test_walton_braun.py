"""Walton & Braun: the straight branches of the paper, its restitution, what a user must give."""

import math

import numpy as np
import pytest
from accuracy import check, contacts, measure, overlaps
from examples import GRANITE, quiet
from references import REFERENCES, errors

import demlaws as dl

CONSTANT = {"loading_stiffness": 3e6, "stiffness_ratio": 2.5}
GROWING = {"loading_stiffness": 3e6, "growth": 2e4}


@pytest.mark.parametrize("options", [CONSTANT, GROWING])
def test_errors_against_fifty_digits(options, rng):
    contact = contacts(rng, 300)
    _, measured = measure("walton-braun", contact, overlaps(rng, contact), **options)
    check(measured, 2.0, 0.7)


@pytest.mark.parametrize("options", [CONSTANT, GROWING])
@pytest.mark.parametrize("share", [1.0, 0.99, 0.7, 0.5, 0.2])
def test_unloading_against_fifty_digits(options, share):
    law = dl.law("walton-braun", GRANITE, **options)
    assert law.unloading == "linear"
    exact = REFERENCES["walton-braun"](**options)
    for maximum in GRANITE.radius * np.array([1e-6, 1e-4, 1e-2]):
        path = law.follow([maximum, share * maximum, maximum])
        wanted = exact.unloading(maximum, share * maximum)
        if wanted == 0:
            assert path.force[1] == path.stiffness[1] == 0.0
        else:
            noise = 4 * float(exact.force(maximum) / wanted)  # of the difference δ - δ0
            assert errors(path.force[1], [wanted])[0] <= noise
        assert path.force[2] == path.force[0]


@pytest.mark.parametrize("ratio", [1.0, 2.0, 10.0])
def test_restitution_of_constant_stiffnesses_does_not_depend_on_speed(ratio):
    """e = √(k1/k2), Walton & Braun 1986."""
    law = dl.law("walton-braun", GRANITE, loading_stiffness=3e6, stiffness_ratio=ratio)
    for speed in (0.01, 1.0):
        assert dl.driver.impact(law, 1e-3, speed, 4000).restitution == pytest.approx(math.sqrt(1 / ratio), rel=2e-6)


def test_growing_stiffness_dissipates_more_at_speed():
    """e² = k1/(k1 + S Pmax), Pmax = v √(m k1)."""
    law = dl.law("walton-braun", GRANITE, **GROWING)
    for speed in (0.01, 0.1, 1.0):
        peak = speed * math.sqrt(1e-3 * 3e6)
        wanted = math.sqrt(3e6 / (3e6 + 2e4 * peak))
        assert quiet(dl.driver.impact, law, 1e-3, speed, 4000).restitution == pytest.approx(wanted, rel=2e-6)


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"loading_stiffness": 3e6},
        {**CONSTANT, "growth": 1.0},
        {"loading_stiffness": 3e6, "stiffness_ratio": 0.9},
        {"loading_stiffness": math.nan, "stiffness_ratio": 2.0},
        {"loading_stiffness": 3e6, "growth": -1.0},
    ],
)
def test_bad_options(options):
    with pytest.raises(dl.DemlawsError):
        dl.law("walton-braun", GRANITE, **options)


def test_a_table_keeps_the_rule():
    law = dl.law("walton-braun", GRANITE, **GROWING)
    path = np.array([2e-5, 1.9e-5, 1.2e-5, 2e-5, 4e-5, 3.7e-5, 0.0])
    table = law.tabulate(1e-6)
    assert (table.unloading, table.state_names) == ("linear", law.state_names)
    for one in (table, table.joined("elastic").joined("linear")):
        np.testing.assert_allclose(one.follow(path).force, law.follow(path).force, rtol=1e-6, atol=1e-6 * 120)
