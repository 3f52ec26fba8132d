"""The Conical Damage Model: YADE's own against law conical-damage with the same numbers, each driven as in studies/trade."""

import natives
import numpy as np
import pytest

import demlaws as dl

pytestmark = pytest.mark.slow


def test_yades_own_and_ours_on_the_same_path():
    law = dl.law("conical-damage", dl.Contact(4e-3, 32e9), strength=0.8e9, angle=1.2)
    path, theirs = natives.in_yade(law, [2e-5, 1.2e-5, 4e-5, 1.5e-5])
    ours = law.follow(path).force
    assert ours[natives.until_free(ours) - 1] > 0.0 and natives.until_free(ours) > 50
    assert np.max(np.abs(theirs - ours)) <= 1e-12 * theirs.max()
