"""These tests need YADE: the system's, or the one whose start script the environment variable YADE names. They run in the test
process itself, so that their failures show as any other."""

import os
import sys
from pathlib import Path

import pytest

from demlaws.errors import DemlawsError
from demlaws.yade.run import executable, modules_of

# One thread in the test process: two add forces in changing order, and trajectories of a packing part from rounding.
# What two threads do is tested in processes of its own.
os.environ["OMP_NUM_THREADS"] = "1"
HERE = Path(__file__).parent
try:
    LIBRARIES = modules_of(executable())
except DemlawsError:
    LIBRARIES = None


def pytest_collection_modifyitems(items):
    for item in items:
        if Path(item.fspath).parent == HERE:
            item.add_marker(pytest.mark.yade)
            if LIBRARIES is None and not os.environ.get("CI"):  # in CI an engine that is missing is a failure
                item.add_marker(pytest.mark.skip(reason="no YADE: sudo apt install yade, or YADE=/path/to/yade"))


if LIBRARIES is not None and str(LIBRARIES) not in sys.path:
    sys.path.append(str(LIBRARIES))


@pytest.fixture
def omega():
    import yade

    yade.O.reset()
    yield yade.O
    yade.O.reset()
