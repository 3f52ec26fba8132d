"""The scene of `python -m studies.trade` in YADE, what a law costs there, and its Conical Damage Model on one contact."""

import numpy as np
import pytest

import demlaws as dl
from studies.costs.costs import under_yade
from studies.trade import candidates, peers

HERTZ = candidates.Way("hertz", "hertz", shear="native")
PAIR = dl.Contact(4.35e-3, 32.32e9, 2.40e-6, 2.22, 6.266e9)


@pytest.mark.slow
def test_the_conical_damage_model_is_hertz_until_it_yields():
    hertz = dl.law("hertz", PAIR)
    peaks = np.array([1.0, 30.0])
    assert peers.cdm_error(hertz, peaks, 5e9)[0] < 1e-6
    overlaps, forces = peers.reference_paths(hertz, peaks)
    given = {"young": 60.6e9, "poisson": 0.25, "density": 2650.0, "radius": 8.7e-3, "paths": overlaps.tolist()}
    weak = np.array(under_yade("costs/yade_cost.py", {**given, "ways": [{"model": "cdm", "cdm": (0.5e9, 0.5)}]}))[0]
    assert weak[1, 0] < 0.5 * forces[1, 0]
    assert np.all(np.diff(weak[1]) <= 0.0)
