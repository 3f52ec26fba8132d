"""Jobs in several processes: the same results in the same order, and no process that was not asked for."""

import os
import subprocess
import sys
import time

import numpy as np
import pytest

import demlaws as dl
from demlaws.advice.processes import results

PAIR = dl.Contact(4.35e-3, 32.32e9, 2.4e-6, 2.22, 6.266e9)
ROWS = np.column_stack([(np.linspace(1, 9, 12) / 2e9) ** 0.66, np.linspace(1, 9, 12)])


def slow(jobs):
    """A progress bar that takes long enough for other processes to be started."""
    for number, job in enumerate(jobs):
        if number == 0:
            time.sleep(0.6)
        yield job


def test_jobs_are_shared_and_stay_in_order():
    job = "[__import__('time').sleep(0.1), {}, __import__('os').getpid()][1:]"
    found = list(results(eval, [job.format(n) for n in range(6)], 2, slow))
    assert [number for number, _ in found] == list(range(6))
    assert len({process for _, process in found}) == 2 and found[0][1] == os.getpid()


def test_a_library_call_starts_no_process(monkeypatch):
    """Before: after 0.2 s `dl.fit` and `dl.choose` forked the user's process."""

    def started(*arguments):
        raise AssertionError("a process was started")

    monkeypatch.setattr(os, "fork", started)
    monkeypatch.setattr(os, "posix_spawn", started, raising=False)
    laws = ["hertz", "rms", "goddard", "pohrt-popov"]
    assert len(dl.fit(ROWS, PAIR, laws=laws, unloading="elastic", progress=slow)) == 4
    steel = dl.Material(210e9, 0.3, density=7850, surface=dl.Surface(0))
    scene = dl.Scene(radii=5e-3, materials=steel, force=(1, 10), cyclic=True)
    assert dl.choose(scene, tables=False, progress=slow).best.name == "hertz"


def test_fits_in_two_processes_are_those_of_one():
    laws = ["hertz", "rms", "goddard", "pohrt-popov"]
    one, two = (dl.fit(ROWS, PAIR, laws=laws, unloading="elastic", progress=slow, processes=n) for n in (1, 2))
    assert [(fit.name, fit.aicc, fit.misfit) for fit in one] == [(fit.name, fit.aicc, fit.misfit) for fit in two]
    for wrong in (0, 1.5, "two"):
        with pytest.raises(dl.DemlawsError):
            dl.fit(ROWS, PAIR, laws=laws, processes=wrong)


UNGUARDED = """
import functools, time
import numpy as np
from demlaws.advice.processes import results

def slow(jobs):
    time.sleep(0.6)
    yield from jobs

large = functools.partial(np.add, np.zeros(100_000))  # longer than a pipe
print(sum(float(found[0]) for found in results(large, list(range(6)), 2, slow)))
"""


def test_a_script_without_a_main_guard_goes_on_alone(tmp_path):
    """Before: the process that was started died, and the script waited for ever."""
    (tmp_path / "script.py").write_text(UNGUARDED)
    done = subprocess.run([sys.executable, "script.py"], cwd=tmp_path, capture_output=True, text=True, timeout=100)
    assert done.stdout.split() == ["15.0"]
