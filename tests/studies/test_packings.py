"""The oedometer's scene without an engine: where its grains start, what it tells the engine, what it makes of the answer."""

import numpy as np
import pytest

import demlaws as dl
from studies.trade.candidates import GRANITE, RADII
from studies.trade.packings import QUICK, Setup


@pytest.mark.parametrize("setup", [QUICK, Setup(), Setup(count=7, across=2, seed=3)])
def test_grains_start_apart_inside_their_box(setup):
    centres, radii = setup.start()
    assert len(centres) == len(radii) == setup.count and set(radii) <= set(RADII)
    distance = np.linalg.norm(centres[:, None] - centres[None], axis=2) + np.diag(np.full(setup.count, np.inf))
    assert np.all(distance > radii[:, None] + radii[None])
    for axis in (0, 1):
        assert np.all(centres[:, axis] > radii) and np.all(centres[:, axis] < setup.width - radii)
    assert np.all(centres[:, 2] > radii)
    again, _ = setup.start()
    np.testing.assert_array_equal(centres, again)


def test_the_step_is_stable_for_the_stiffest_contact():
    """Half of 2 √(m/K)/√3 of the lighter grain at the largest force; Hertz is the stiffest of the ways."""
    setup = Setup()
    half = dl.Contact.between(GRANITE, GRANITE, radius1=min(RADII), radius2=min(RADII))
    stiffness = dl.law("hertz", half).stiffness(dl.law("hertz", half).overlap(setup.largest_force))
    mass = 4 / 3 * np.pi * min(RADII) ** 3 * GRANITE.density
    assert 0.0 < setup.timestep() < 2.0 * np.sqrt(mass / stiffness)
    assert setup.timestep() > 0.1 * np.sqrt(mass / stiffness)
