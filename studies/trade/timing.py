"""Interleaved timings: every contestant runs in every round, and the fastest round of each counts."""

import functools
import time
from typing import NamedTuple

import numpy as np

from demlaws.batch import State
from demlaws.law import Law


class Batch(NamedTuple):
    """A law with contacts to evaluate."""

    law: Law
    overlap: np.ndarray
    start: State  # the state before the step; put back before each round

    @classmethod
    def of(cls, law, peak, overlap):
        """Contacts that were at `peak` [m] and are now at `overlap` [m]."""
        state = law.new_state(peak.size)
        if law.state_size:
            law.evaluate(peak, state)
        return cls(law, overlap, state)


def nanoseconds(batches, rounds=7):
    """ns per contact of each batch (name → Batch), and of a copy kernel that only reads and writes: (name → ns, floor)."""
    work = {}
    for name, batch in batches.items():
        out = np.empty_like(batch.overlap), np.empty_like(batch.overlap)
        work[name] = batch, batch.start.copy(), out
    size = max(b.overlap.size for b in batches.values())
    source, first, second = np.ones(size), np.empty(size), np.empty(size)
    copy = _copy_kernel()
    best, floor = dict.fromkeys(batches, np.inf), np.inf
    for number in range(rounds + 1):  # the first round compiles and touches memory
        start = time.perf_counter()
        copy(source, first, second)
        taken = (time.perf_counter() - start) / size * 1e9
        floor = min(floor, taken) if number else floor
        for name, (batch, state, out) in work.items():
            for target, initial in zip(state.arrays, batch.start.arrays, strict=True):
                target[:] = initial
            start = time.perf_counter()
            batch.law.evaluate(batch.overlap, state, out)
            taken = (time.perf_counter() - start) / batch.overlap.size * 1e9
            best[name] = min(best[name], taken) if number else best[name]
    return best, floor


@functools.cache
def _copy_kernel():
    from demlaws.core.numba_compat import loop

    @loop
    def copy(source, first, second):
        for i in range(source.size):
            first[i] = source[i]
            second[i] = source[i]

    return copy
