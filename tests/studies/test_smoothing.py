"""The study of smoothing: each way gives a curve of the points that it can, and what cannot become a table is counted."""

import numpy as np
import pytest

import demlaws as dl
from studies.smoothing import PAIR, WAYS, errors

pytestmark = pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")


@pytest.mark.parametrize("way", WAYS)
def test_noise_in_proportion_to_the_force(way):
    found, refused = errors(WAYS[way], dl.law("rms", PAIR, "elastic"), 40, (0.01, 0.0), np.random.default_rng(1), 2)
    assert refused == 0 and 0.001 < np.quantile(found, 0.95) < 0.1


def test_noise_of_one_size():
    """A spline through logarithms of noise about 0 does not rise; likelihood finds the size of the noise."""
    law, noise = dl.law("rms", PAIR, "elastic"), (0.0, 0.003)
    lost = {name: errors(way, law, 100, noise, np.random.default_rng(1), 3)[1] for name, way in WAYS.items()}
    assert lost["demlaws"] == 0 < lost["scipy"]
