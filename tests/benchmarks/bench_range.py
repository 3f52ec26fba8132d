"""What `law.evaluate` pays for seeing in its loop which contacts are out of range: with and without, in turn, in cache.

    python tests/benchmarks/bench_range.py [--contacts 4096] [--rounds 300]

The loop counts an overlap beyond `end` as NaN, so that the contact's history stays, and compares each force with `most`.
"""

import argparse
import inspect
import time
import warnings

import numba
import numpy as np

import demlaws as dl
from demlaws.core import loops

PAIR = dl.Contact(radius=4.35e-3, modulus=32.32e9, roughness=2.4e-6, fractal_dimension=2.22, hardness=6.266e9)
SEEN = (
    "here = here if (here <= gather(end, i)[0]) | (len(state) == 0) else math.nan",
    "good &= looked_at <= gather(most, i)[0]",
)


def compiled(left_out):
    """`batch_loop` without these lines."""
    text = inspect.getsource(loops.batch_loop.py_func).replace("@loop\n", "")
    for line in left_out:
        assert text.count(line) == 1, line
        text = text.replace(line, "pass")
    names = dict(vars(loops))
    exec(text, names)
    options = {name: value for name, value in loops.batch_loop.targetoptions.items() if name != "nopython"}
    return numba.njit(**options)(names["batch_loop"])


def laws():
    """Name → law of one contact, with a history."""
    rough = dl.law("pohrt-popov", PAIR, "hertz")
    yield "pohrt-popov, hertz", rough
    yield "the same as a table", rough.tabulate(1e-5)
    for name in ("rms", "yip-venart"):
        yield f"{name}, hertz", dl.law(name, PAIR, "hertz")


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--contacts", type=int, default=4096)
    parser.add_argument("--rounds", type=int, default=300)
    arguments = parser.parse_args()
    warnings.simplefilter("ignore", dl.ValidityWarning)
    random, size = np.random.default_rng(1), arguments.contacts
    paths = [random.uniform(0.0, 1e-5, size)]
    paths.append(paths[0] * random.uniform(0.8, 1.05, size))
    variants = {"with": compiled(()), "without": compiled(SEEN)}
    out = np.empty(size), np.empty(size)
    for name, law in laws():
        state, times = law.new_state(size).arrays, {variant: [] for variant in variants}
        for _ in range(arguments.rounds):
            for variant, function in variants.items():
                begin = time.perf_counter()
                for overlap in paths:
                    function(law.rule, law.params, overlap, state, (PAIR.radius,), loops.FINITE, *out)
                times[variant].append(time.perf_counter() - begin)
        ours, bare = (min(times[variant]) / (2 * size) * 1e9 for variant in variants)
        print(f"{name:22} {ours:5.2f} ns a contact, without {bare:5.2f}: {100 * (ours / bare - 1):+.1f} %")


if __name__ == "__main__":
    main()
