"""These tests need Debian's YADE; they run in the test process itself, so that their failures show as any other."""

import os
import sys
from pathlib import Path

import pytest

# One thread in the test process: two add forces in changing order, and trajectories of a packing part from rounding.
# What two threads do is tested in processes of its own.
os.environ["OMP_NUM_THREADS"] = "1"
LIBRARIES = Path("/usr/lib/x86_64-linux-gnu/yade-double/py")
HERE = Path(__file__).parent


def pytest_collection_modifyitems(items):
    for item in items:
        if Path(item.fspath).parent == HERE:
            item.add_marker(pytest.mark.yade)
            if not LIBRARIES.is_dir() and not os.environ.get("CI"):  # in CI an engine that is missing is a failure
                item.add_marker(pytest.mark.skip(reason="Debian's YADE is not installed: sudo apt install yade"))


if LIBRARIES.is_dir() and str(LIBRARIES) not in sys.path:
    sys.path.append(str(LIBRARIES))


@pytest.fixture
def omega():
    import yade

    yade.O.reset()
    yield yade.O
    yade.O.reset()
