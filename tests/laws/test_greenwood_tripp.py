"""Greenwood & Tripp as a law: seat, its number μ, its curve against the solver."""

import math

import numpy as np
import pytest
from examples import GRANITE

import demlaws as dl
from demlaws.solvers.axisymmetric import solve


@pytest.mark.parametrize("mu", [4.0, 17.0])
def test_force_and_stiffness_are_those_of_the_solver(mu):
    """The law reads a curve; solved afresh at loads between its nodes. The issue asks for 1e-4."""
    law = dl.law("greenwood-tripp", GRANITE, mu=mu)
    unit = GRANITE.modulus * math.sqrt(GRANITE.radius) * GRANITE.roughness**1.5
    force = np.geomspace(0.02, 1000.0, 14)
    points = solve("greenwood-tripp", mu, force / unit)
    overlap = (points.approach[1:] - points.approach[0]) * GRANITE.roughness + law.overlap(0.02)
    np.testing.assert_allclose(law.force(overlap), force[1:], rtol=5e-6)
    np.testing.assert_allclose(law.stiffness(overlap), points.stiffness[1:] * unit / GRANITE.roughness, rtol=2e-5)


def test_mu_from_asperities():
    """μ = (8/3) η σ √(2Rβ)."""
    density, radius = 2e9, 5e-5
    mu = 8 / 3 * density * GRANITE.roughness * math.sqrt(2 * GRANITE.radius * radius)
    measured = dl.law("greenwood-tripp", GRANITE, asperity_density=density, asperity_radius=radius)
    given = dl.law("greenwood-tripp", GRANITE, mu=mu)
    assert measured.force(3e-6) == pytest.approx(given.force(3e-6), rel=1e-9)


def test_softer_than_hertz_and_towards_it_at_high_load():
    contact = GRANITE.with_values(hardness=None)  # no bulk yield to warn of
    law, hertz = dl.law("greenwood-tripp", contact), dl.law("hertz", contact)
    force = np.geomspace(0.1, 1e4, 20)
    ratio = law.stiffness(law.overlap(force)) / hertz.stiffness(hertz.overlap(force))
    assert np.all(np.diff(ratio) > 0)
    assert 0.9 < ratio[-1] < 1.0


def test_bad_input():
    for options in ({"mu": -1}, {"asperity_density": 1e9}, {"mu": 4, "asperity_density": 1e9, "asperity_radius": 1e-5}):
        with pytest.raises(dl.DemlawsError):
            dl.law("greenwood-tripp", GRANITE, **options)
