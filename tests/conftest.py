"""Shared settings, and how tests are shared out. Helpers are plain modules beside this file: examples, references,
processes."""

import contextlib
import gc
import os

# One thread of YADE in the test process, set before any module loads OpenMP, which reads it then: two add forces in changing
# order, and trajectories of a packing part from rounding. What two threads do is tested in processes of its own.
os.environ["OMP_NUM_THREADS"] = "1"

import mpmath
import pytest
from hypothesis import settings

# the machines that run this are shared: an example may take long once, when a loop is compiled. Who runs the suite draws new
# examples each time; in CI, where an unlucky draw would stop a change that has nothing to do with it, they are the same
COMMON = {"deadline": None, "print_blob": True, "derandomize": bool(os.environ.get("CI"))}
settings.register_profile("demlaws", **COMMON, max_examples=25)
settings.register_profile("thorough", **COMMON, max_examples=100)  # make test-all
settings.load_profile("demlaws")

# numba makes objects by the million, which all live: looking for garbage less often saves a tenth of what compiling takes
gc.set_threshold(100_000, 20, 20)


MPI_FOLDER = contextlib.ExitStack()
BEFORE = set()
"""Files of MPICH's shared memory that were there when the tests began."""


def pytest_configure():
    """Each process of the tests has a folder for the files of MPI: tests that start an engine's command themselves need it."""
    from processes import shared_memory

    from demlaws.plugins.engines import own_session

    BEFORE.update(shared_memory())
    os.environ.update(MPI_FOLDER.enter_context(own_session({})))


@pytest.fixture(autouse=True)
def fifty_digits():
    """References are exact whatever ran before: importing YADE sets mpmath to 16 digits for the whole process."""
    with mpmath.workdps(50):
        yield


@pytest.fixture
def rng():
    import numpy as np

    return np.random.default_rng(20231)


@pytest.fixture
def registered_here():
    """A law that a test registers goes with it."""
    from own_spring import restored

    with restored():
        yield


def _under(path, folder):
    return f"tests/{folder}/" in str(path).replace(os.sep, "/")


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(items):
    """Engines first, then the longest files, so that no long file is begun last. A slow test counts as 10 kB."""
    weight = {path: path.stat().st_size for path in {item.path for item in items}}
    for item in items:
        weight[item.path] += 10_000 * bool(item.get_closest_marker("slow"))
    items.sort(key=lambda item: (not _under(item.path, "engines"), -weight[item.path], str(item.path)))


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """A file goes to one process, which makes its fixtures once; the files of LIGGGHTS all to the same one: two runs under MPI
    at once would wait for each other's processors."""
    from xdist.scheduler import LoadFileScheduling

    class ByFile(LoadFileScheduling):
        def _split_scope(self, nodeid):
            return "liggghts" if _under(nodeid, "engines/liggghts") else super()._split_scope(nodeid)

    config.option.loadscopereorder = False
    return ByFile(config, log)


_skipped_engines = []


def pytest_runtest_logreport(report):
    needed = _under(report.nodeid, "engines") or any(engine in report.keywords for engine in ("yade", "liggghts", "lammps"))
    if report.skipped and needed:
        _skipped_engines.append(report.nodeid)


def pytest_sessionfinish(session, exitstatus):
    """In CI a test that needs an engine and did not run is a failure: there the engines can be installed."""
    from processes import remove_shared_memory

    MPI_FOLDER.close()
    remove_shared_memory(BEFORE)
    if os.environ.get("CI") and _skipped_engines and exitstatus == 0:
        session.exitstatus = pytest.ExitCode.TESTS_FAILED


def pytest_terminal_summary(terminalreporter):
    if os.environ.get("CI") and _skipped_engines:
        terminalreporter.write_line(f"CI: {len(_skipped_engines)} engine tests were skipped, which counts as failure", red=True)
