"""Independent jobs in one process or several, by `concurrent.futures`."""

import contextlib
import pickle
import tempfile
import time
import warnings
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context
from typing import Any

from demlaws.laws.registry import registry
from demlaws.units import whole

_PATIENCE = 0.5  # [s] of work before other processes are started: each takes about a second to begin
_work: Callable | None = None  # of a process that was started here


def _begin(path):
    global _work
    with open(path, "rb") as file:
        _work = pickle.load(file)
    warnings.simplefilter("ignore")  # they would pass the caller's filters


def _work_on(job):
    return _work(job)


def results(work: Callable, jobs: list, processes: int = 1, progress: Callable = iter) -> Iterator[Any]:
    """`work(job)` for each of `jobs`, in their order.

    With `processes` above 1, this process takes the jobs from the first on, and `processes - 1` others, started where that
    takes long, from the last on. `work`, jobs and results are pickled for them. User-defined laws are known in this
    process only: with one of them registered, all jobs stay here.
    """
    processes = whole(processes, "processes", 1, 256)
    if any(not definition.prepare.__module__.startswith("demlaws.laws.") for definition in registry().values()):
        processes = 1
    begin, pool, futures = time.monotonic(), None, {}
    with contextlib.ExitStack() as stack:
        for number, job in enumerate(progress(jobs)):
            if pool is None and processes > 1 and number + 2 < len(jobs) and time.monotonic() > begin + _PATIENCE:
                # in a file: an argument of over 64 kB would block for ever where the process dies at its start
                file = stack.enter_context(tempfile.NamedTemporaryFile(suffix=".pickle"))
                file.write(pickle.dumps(work))
                file.flush()
                pool = ProcessPoolExecutor(processes - 1, get_context("spawn"), _begin, (file.name,))
                stack.callback(pool.shutdown, wait=False, cancel_futures=True)
                with contextlib.suppress(BrokenProcessPool):
                    for n in reversed(range(number + 1, len(jobs))):
                        futures[n] = pool.submit(_work_on, jobs[n])
            if number not in futures or futures[number].cancel():
                yield work(job)
                continue
            try:
                yield futures[number].result()
            except BrokenProcessPool:  # a script without `if __name__ == "__main__":`, for instance
                yield work(job)
