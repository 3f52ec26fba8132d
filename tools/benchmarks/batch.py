"""Cost of `law.evaluate` over large batches, beside a copy kernel over exactly the same arrays.

The copy kernel reads the overlap, every per-contact parameter array that the law reads and the state, and writes the
state, the force and the stiffness: the memory traffic of a law whose arithmetic is free. Law and copy are timed in turn,
round after round, on arrays far larger than cache, so that a busy machine slows both.

Two extremes: every contact virgin, and a random mixture of a third each virgin (or reloaded past its maximum), unloading
and separated, which no branch predictor can learn.
"""

import functools
import time
from typing import NamedTuple

import numba
import numpy as np

import demlaws as dl
from demlaws.core.dispatch import leaves, map_leaves
from demlaws.core.loops import FINITE, UNBOUNDED, batch_loop
from demlaws.laws.definition import CLOSED, HERTZ_CURVE
from demlaws.laws.registry import registry
from demlaws.make import example_law
from demlaws.responses.batch import in_threads

EXTREMES = ("virgin", "mixture")
STATELESS, HYSTERETIC, TABULATED = 2.0, 3.0, 4.0


class Case(NamedTuple):
    """A law and its contacts."""

    law: str
    unloading: str
    form: str = "closed"  # or "table": law.tabulate(1e-5)
    scales: str = "one"  # contact common to all, or "each" contact with its own radius, modulus, roughness


def goal(case):
    """Largest permitted ratio to the copy kernel; None for an implicit law, which is meant to be tabulated."""
    definition = registry()[case.law]
    if case.form == "table" or definition.solved:
        return TABULATED
    if definition.loading.computed not in (HERTZ_CURVE, CLOSED):
        return None
    return STATELESS if case.unloading == "elastic" and case.law != "rough-plastic" else HYSTERETIC


def contact(scales, n, seed=1):
    """A contact like those of the granite tests, or n that scatter around it."""
    shared = {"fractal_dimension": 2.22, "hardness": 6.266e9}
    if scales == "one":
        return dl.Contact(radius=4.35e-3, modulus=32.32e9, sigma=2.40e-6, **shared)
    random = np.random.default_rng(seed)
    return dl.Contact(
        radius=4.35e-3 * random.uniform(0.7, 1.5, n),
        modulus=32.32e9 * random.uniform(0.9, 1.1, n),
        sigma=2.40e-6 * random.uniform(0.5, 2.0, n),
        **shared,
    )


def make(case, n):
    """The law of a case, or None where it is refused: not passive, or without one table for contacts that differ."""
    try:
        law = example_law(case.law, contact(case.scales, n), case.unloading)
        return law.tabulate(1e-5) if case.form == "table" else law
    except dl.DemlawsError:
        return None


@functools.lru_cache(maxsize=4)
def overlaps(extreme, n, seed=2):
    """Overlaps [m] over 3.5 decades, now and one step before."""
    random = np.random.default_rng(seed)
    overlap = 10.0 ** random.uniform(-8.0, -4.5, n)
    kind = random.integers(0, 3, n)
    before = overlap * np.where(kind == 0, random.uniform(0.5, 1.0, n), random.uniform(1.0, 2.0, n))
    if extreme == "mixture":
        overlap = np.where(kind == 2, -overlap, overlap)
    return overlap, before


def arrays_read(law, overlap, states):
    """The per-contact arrays of law.params that matter: filling one with NaN changes a result."""
    first = slice(2000)
    overlap, states = overlap[first], tuple(s[first] for s in states)

    def run(spoiled):
        params = map_leaves(
            lambda v: (np.full(overlap.size, np.nan) if v is spoiled else v[first]) if isinstance(v, np.ndarray) else v,
            law.params,
        )
        result = [np.empty_like(overlap), np.empty_like(overlap), *(s.copy() for s in states)]
        batch_loop(law.rule_tag, law.shape, params, overlap, tuple(result[2:]), UNBOUNDED, FINITE, result[0], result[1])
        return np.concatenate(result)

    normal = run(None)
    arrays = [v for v in leaves(law.params) if isinstance(v, np.ndarray)]
    return [v for v in arrays if not np.array_equal(normal, run(v), equal_nan=True)]


@functools.cache
def copy_kernel(parameters, states):
    """A compiled loop that reads overlap, parameter and state arrays and writes state, force and stiffness."""
    p = [f"p{k}" for k in range(parameters)]
    s = [f"s{k}" for k in range(states)]
    body = [f"{name}[i] = 0.5 * ({name}[i] + x)" for name in s]
    body += [f"force[i] = {' + '.join(['x', *(f'{name}[i]' for name in p)])}", "stiffness[i] = x"]
    lines = "".join(f"\n        {line}" for line in body)
    names = {}
    head = f"def copy({', '.join(['overlap', *p, *s, 'force', 'stiffness'])}):"
    exec(f"{head}\n    for i in range(overlap.size):\n        x = overlap[i]{lines}\n", names)
    return numba.njit(nogil=True, error_model="numpy")(names["copy"])


def times(law, extreme, n, rounds, parallel=False):
    """Seconds of law and copy, timed in turn round after round; the state is put back before each.

    Of one thread the processor's time counts, which other processes do not change; with one thread per core, wall-clock time.
    """
    overlap, before = overlaps(extreme, n)
    state = law.new_state(n)
    if state.arrays and extreme == "mixture":
        law.evaluate(before, state)
    initial = tuple(array.copy() for array in state.arrays)
    out = np.zeros_like(overlap), np.zeros_like(overlap)
    read = arrays_read(law, overlap, initial)
    copy, moved = copy_kernel(len(read), len(initial)), (overlap, *read, *state.arrays, *out)
    clock = time.perf_counter if parallel else time.thread_time

    def law_once():
        law.evaluate(overlap, state if state.arrays else None, out, parallel=parallel)

    def copy_once():
        if parallel:
            in_threads(lambda piece: copy(*(array[piece] for array in moved)), overlap.size)
        else:
            copy(*moved)

    taken = {law_once: [], copy_once: []}
    for _ in range(rounds + 1):
        for run, seconds in taken.items():
            for target, source in zip(state.arrays, initial, strict=True):
                target[:] = source
            start = clock()
            run()
            seconds.append(clock() - start)
    return [seconds[1:] for seconds in taken.values()]  # the first round compiles and touches memory
