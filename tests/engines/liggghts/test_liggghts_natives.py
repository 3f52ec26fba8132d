"""Stock edinburgh of LIGGGHTS on one contact."""

import numpy as np
from natives import in_liggghts, until_free

import demlaws as dl


def test_liggghts_own_and_ours_on_the_same_path():
    """Equal until the force is 0; below the plastic overlap stock moves it back with the bodies, and reloads from there."""
    law = dl.law("eepa", dl.Contact(4e-3, 32e9), softness=0.8, stiffness_ratio=2.5)
    overlap, theirs = in_liggghts(law, [6e-6, 4.5e-6, 1e-5, 7.5e-6, 5.5e-6, 9e-6])
    ours = law.follow(overlap).force
    assert np.count_nonzero(ours == 0.0) > 10 and until_free(ours) > 100
    first = slice(0, until_free(ours))
    assert np.max(np.abs(theirs - ours)[first]) <= 1e-13 * theirs.max()
    later = (np.arange(ours.size) > until_free(ours)) & (theirs > 0.0)
    assert np.max((theirs - ours)[later]) > 0.05 * theirs.max()
