"""Shared settings. Helpers are plain modules beside this file: examples, references, accuracy."""

import os

import mpmath
import pytest
from hypothesis import settings

# the machines that run this are shared: an example may take long once, when a loop is compiled
settings.register_profile("demlaws", deadline=None, print_blob=True)
settings.load_profile("demlaws")


@pytest.fixture(autouse=True)
def fifty_digits():
    """References are exact whatever ran before: importing YADE sets mpmath to 16 digits for the whole process."""
    with mpmath.workdps(50):
        yield


@pytest.fixture
def rng():
    import numpy as np

    return np.random.default_rng(20231)


_skipped_engines = []


def pytest_runtest_logreport(report):
    if report.skipped and "tests/engines" in report.nodeid.replace(os.sep, "/"):
        _skipped_engines.append(report.nodeid)


def pytest_sessionfinish(session, exitstatus):
    """In CI an engine test that did not run is a failure: there the engines can be installed."""
    if os.environ.get("CI") and _skipped_engines and exitstatus == 0:
        session.exitstatus = pytest.ExitCode.TESTS_FAILED


def pytest_terminal_summary(terminalreporter):
    if os.environ.get("CI") and _skipped_engines:
        terminalreporter.write_line(f"CI: {len(_skipped_engines)} engine tests were skipped, which counts as failure", red=True)
