"""These tests need YADE: the system's, or the one whose start script the environment variable YADE names. They run in the test
process itself, so that their failures show as any other."""

import os
import sys

import pytest

from demlaws.errors import DemlawsError
from demlaws.yade.run import executable, modules_of

# One thread in the test process: two add forces in changing order, and trajectories of a packing part from rounding.
# What two threads do is tested in processes of its own.
os.environ["OMP_NUM_THREADS"] = "1"
try:
    LIBRARIES = modules_of(executable())
except DemlawsError:
    LIBRARIES = None


if LIBRARIES is not None and str(LIBRARIES) not in sys.path:
    sys.path.append(str(LIBRARIES))


@pytest.fixture
def omega():
    import yade

    yade.O.reset()
    yield yade.O
    yade.O.reset()
