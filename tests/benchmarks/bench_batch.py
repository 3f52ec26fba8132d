"""Cost of `law.evaluate` over large batches, as a ratio to a copy kernel over exactly the same arrays.

The copy kernel reads the overlap, every per-contact parameter array that the law reads and the state, and writes the
state, the force and the stiffness: the memory traffic of a law whose arithmetic is free. Law and copy are timed in turn,
round after round, on arrays far larger than cache, so that a busy machine slows both.

Two extremes: every contact virgin, and a random mixture of a third each virgin (or reloaded past its maximum), unloading
and separated, which no branch predictor can learn.

    python tests/benchmarks/bench_batch.py                   all cases, some twenty minutes; --quick: two minutes
    python tests/benchmarks/bench_batch.py --law pohrt-popov --unloading hertz
"""

import argparse
import functools
import os
import time
from itertools import product
from typing import NamedTuple

import numba
import numpy as np

import demlaws as dl
from demlaws.batch import in_threads
from demlaws.core.loops import evaluate_loop, leaves, map_leaves
from demlaws.core.unloading import RULES
from demlaws.laws.registry import registry
from demlaws.make import example

EXTREMES = ("virgin", "mixture")
FORMS = ("closed", "table")
SCALES = ("one", "each")
STORAGES = ("float64", "float32")
THREADS = ("1", "all")
STATELESS, HYSTERETIC, TABULATED = 2.0, 3.0, 4.0


class Case(NamedTuple):
    """One row of the table."""

    law: str
    unloading: str
    form: str  # "closed", or "table": law.tabulate(1e-5)
    scales: str  # "one" contact common to all, or "each" contact with its own radius, modulus, roughness
    storage: str
    threads: str


def goal(case):
    """Largest permitted ratio to the copy kernel; None for an implicit law, which is meant to be tabulated."""
    definition = registry()[case.law]
    if case.form == "table" or definition.solved:
        return TABULATED
    if definition.implicit:
        return None
    return STATELESS if case.unloading == "elastic" and case.law != "rough-plastic" else HYSTERETIC


def contact(scales, n, seed=1):
    """A contact like those of the granite tests, or n that scatter around it."""
    shared = {"fractal_dimension": 2.22, "hardness": 6.266e9}
    if scales == "one":
        return dl.Contact(radius=4.35e-3, modulus=32.32e9, roughness=2.40e-6, **shared)
    random = np.random.default_rng(seed)
    return dl.Contact(
        radius=4.35e-3 * random.uniform(0.7, 1.5, n),
        modulus=32.32e9 * random.uniform(0.9, 1.1, n),
        roughness=2.40e-6 * random.uniform(0.5, 2.0, n),
        **shared,
    )


def make(case, n):
    """The law of a case, or None where it is refused: not passive, or without one table for contacts that differ."""
    try:
        law = example(case.law, contact(case.scales, n), case.unloading)
        return law.tabulate(1e-5) if case.form == "table" else law
    except dl.DemlawsError:
        return None


@functools.lru_cache(maxsize=4)
def overlaps(extreme, n, storage, seed=2):
    """Overlaps [m] over 3.5 decades, now and one step before."""
    random = np.random.default_rng(seed)
    overlap = 10.0 ** random.uniform(-8.0, -4.5, n)
    kind = random.integers(0, 3, n)
    before = overlap * np.where(kind == 0, random.uniform(0.5, 1.0, n), random.uniform(1.0, 2.0, n))
    if extreme == "mixture":
        overlap = np.where(kind == 2, -overlap, overlap)
    return overlap.astype(storage), before.astype(storage)


def inputs(law, extreme, n, storage):
    """Overlaps [m], and the state arrays before the step."""
    overlap, before = overlaps(extreme, n, storage)
    state = law.new_state(n, storage)
    if state.arrays and extreme == "mixture":
        law.evaluate(before, state)
    return overlap, state.arrays


def _arrays(params):
    return [v for v in leaves(params) if isinstance(v, np.ndarray) and v.ndim == 1]


def arrays_read(law, overlap, states):
    """The per-contact arrays of law.params that matter: filling one with NaN changes a result."""
    first = slice(2000)
    overlap, states = overlap[first], tuple(s[first] for s in states)

    def run(spoiled):
        params = map_leaves(
            lambda v: (
                (np.full(overlap.size, np.nan) if v is spoiled else v[first])
                if isinstance(v, np.ndarray) and v.ndim == 1
                else v
            ),
            law.params,
        )
        result = [np.empty_like(overlap), np.empty_like(overlap), *(s.copy() for s in states)]
        evaluate_loop(law.rule, params, overlap, tuple(result[2:]), result[0], result[1])
        return np.concatenate(result)

    normal = run(None)
    return [v for v in _arrays(law.params) if not np.array_equal(normal, run(v), equal_nan=True)]


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


_copies = {}


def copy(arrays, parameters, states, parallel):
    """Run the copy kernel in one thread or, as `law.evaluate` does, in one thread a core."""
    if (parameters, states) not in _copies:
        _copies[parameters, states] = copy_kernel(parameters, states)
    kernel = _copies[parameters, states]
    if not parallel:
        kernel(*arrays)
        return
    in_threads(lambda piece: kernel(*(a[piece] for a in arrays)), arrays[0].size)


def times(law, case, extreme, n, rounds):
    """ns a contact of law and copy, timed in turn round after round; the state is put back before each.

    Of one thread the processor's time counts, which other processes take nothing of; of several, the clock.
    """
    overlap, initial = inputs(law, extreme, n, case.storage)
    state = law.new_state(n, case.storage)
    out = np.zeros_like(overlap), np.zeros_like(overlap)
    read = arrays_read(law, overlap, initial)
    parallel = case.threads == "all"
    clock = time.perf_counter if parallel else time.thread_time
    moved = [overlap, *read, *state.arrays, *out]

    def law_once():
        law.evaluate(overlap, state if state.arrays else None, out, parallel=parallel)

    def copy_once():
        copy(moved, len(read), len(state.arrays), parallel)

    taken = {law_once: [], copy_once: []}
    for _ in range(rounds + 1):
        for run, nanoseconds in taken.items():
            for target, source in zip(state.arrays, initial, strict=True):
                target[:] = source
            start = clock()
            run()
            nanoseconds.append((clock() - start) / n * 1e9)
    return [nanoseconds[1:] for nanoseconds in taken.values()]  # the first round compiles and touches memory


def cases(laws=None, unloadings=None, forms=FORMS, scales=SCALES, storages=STORAGES, threads=THREADS):
    """All cases asked for, in the order of the table."""
    return [Case(*c) for c in product(laws or dl.laws(), unloadings or RULES, forms, scales, storages, threads)]


def show(chosen, n, rounds):
    """Measure the cases and print one line for each: ratio and, in brackets, its median, ns per contact of law and copy."""
    head = f"{'law':16}{'unloading':10}{'form':7}{'scales':7}{'storage':9}{'threads':8}{'goal':>5}"
    print(head + "".join(f"{extreme:>9}{'(median)':>10}{'ns':>6}{'copy':>6}" for extreme in EXTREMES))
    missed = []
    for case in chosen:
        law, limit = make(case, n), goal(case)
        if law is None:
            continue
        line = f"{case.law:16}{case.unloading:10}{case.form:7}{case.scales:7}{case.storage:9}{case.threads:8}{limit or '-':>5}"
        ratios = []
        for extreme in EXTREMES:
            ours, bare = times(law, case, extreme, n, rounds)
            ratios.append(min(ours) / min(bare))
            median = np.median(ours) / np.median(bare)
            line += f"{ratios[-1]:9.2f}{f'({median:.2f})':>10}{min(ours):6.2f}{min(bare):6.2f}"
        print(line, flush=True)
        if limit and max(ratios) > limit:
            missed.append(case)
    print(f"\n{len(missed)} cases miss their goal", *(" ".join(case) for case in missed), sep="\n")


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--law", action="append", choices=dl.laws(), help="only this law (may be repeated)")
    parser.add_argument("--unloading", action="append", choices=list(RULES), help="only this rule (may be repeated)")
    parser.add_argument("--contacts", type=int, help="default: 10 million, 8 million with --quick")
    parser.add_argument("--rounds", type=int, help="default: 9, 3 with --quick")
    parser.add_argument("--quick", action="store_true", help="float64 and one thread only, fewer rounds")
    options = parser.parse_args(arguments)
    fewer = {"storages": ("float64",), "threads": ("1",)} if options.quick else {}
    n = options.contacts or (8_000_000 if options.quick else 10_000_000)
    rounds = options.rounds or (3 if options.quick else 9)
    print(f"{n} contacts, {rounds} rounds, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}, numba {numba.__version__}")
    print("ratio = fastest round of the law / fastest round of the copy kernel over the same arrays\n")
    show(cases(options.law, options.unloading, **fewer), n, rounds)


if __name__ == "__main__":
    main()
