"""Shared settings. Helpers are plain modules beside this file: examples, references, accuracy."""

import pytest
from hypothesis import settings

# the machines that run this are shared: an example may take long once, when a loop is compiled
settings.register_profile("demlaws", deadline=None, print_blob=True)
settings.load_profile("demlaws")


@pytest.fixture
def rng():
    import numpy as np

    return np.random.default_rng(20231)
