"""Goddard: continuity at the load where the cones have rounded off, and 50-digit references."""

import math

import numpy as np
import pytest
from accuracy import check, contacts, measure, overlaps
from examples import GRANITE, quiet

import demlaws as dl

ELASTIC = GRANITE.with_values(hardness=None)  # no bulk yield to warn of
SLOPES = (1e-3, 0.035, 0.3, 1.0)


@pytest.mark.parametrize("slope", SLOPES)
def test_stiffness_at_and_around_the_threshold(slope):
    law, hertz = dl.law("goddard", ELASTIC, slope=slope), dl.law("hertz", ELASTIC)
    tangent = math.tan(slope)
    threshold = 9 * math.pi**3 / 128 * GRANITE.modulus * GRANITE.radius**2 * tangent**3
    overlap = 3 * math.pi**2 / 16 * tangent**2  # over R, at the threshold; laws answer up to R
    factors = [f for f in (1e-6, 0.5, 1 - 1e-12, 1 + 1e-12, 2.0, 1e3) if overlap * max(f**0.5, f ** (2 / 3)) < 1.0]
    assert factors
    for factor in factors:
        force = factor * threshold
        cone = 2 * math.sqrt(2 * GRANITE.modulus * force / (math.pi * tangent))
        smooth = quiet(hertz.stiffness, quiet(hertz.overlap, force))
        assert quiet(law.stiffness, quiet(law.overlap, force)) == pytest.approx(min(cone, smooth), rel=1e-11)


@pytest.mark.parametrize("slope", SLOPES)
def test_errors_against_fifty_digits(slope, rng):
    contact = contacts(rng, 400)
    _, measured = measure("goddard", contact, overlaps(rng, contact), slope=slope)
    check(measured, 8.0, 1.0)  # measured: largest 2.8, mean 0.8


def test_no_slope_is_hertz():
    law, hertz = dl.law("goddard", GRANITE, slope=0.0), dl.law("hertz", GRANITE)
    overlap = np.geomspace(1e-12, 1e-4, 30)
    np.testing.assert_allclose(law.force(overlap), hertz.force(overlap), rtol=1e-14)


@pytest.mark.parametrize("slope", [None, -0.1, 1.5, math.nan, "steep"])
def test_slope_is_checked(slope):
    with pytest.raises(dl.DemlawsError, match="slope"):
        dl.law("goddard", GRANITE, slope=slope)
