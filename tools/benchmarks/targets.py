"""Cost of a batch compiled for processors of three generations, as CSV: `law.evaluate` over a copy kernel (batch.py).

    python tools/benchmarks/targets.py [--targets x86-64-v2 haswell x86-64-v4] [--contacts 4000 4e6] [--rounds 5]

Columns: the case, then for each target and number of contacts the ratio of the fastest rounds, of a random mixture of virgin,
unloading and separated contacts. 4,000 contacts stay in the processor's cache, 4e6 come from memory. A process for each target,
whose compiler has it; one whose instructions this processor lacks is left out.
"""

import argparse
import csv
import json
import os
import subprocess
import sys
from itertools import product
from pathlib import Path

TARGETS = {"x86-64-v2": "sse4.2", "haswell": "avx2", "x86-64-v4": "avx512f"}


def measure(sizes, rounds):
    """Case → ratio for each number of contacts, with this process's compiler."""
    here = Path(__file__).parent
    sys.path[:0] = [str(here), str(here.parents[1] / "tests")]
    import warnings

    import batch
    from examples import pairs

    import demlaws as dl

    warnings.simplefilter("ignore", dl.ValidityWarning)
    closed = [(*pair, "closed") for pair in pairs(("pohrt-popov",)) if batch.goal(batch.Case(*pair))]
    tables = [(law, rule, "table") for law, rule in product(("hertz", "pohrt-popov", "rough-plastic"), ("elastic", "hertz"))]
    found = {}
    for case in map(lambda names: batch.Case(*names), closed + tables):
        ratios = []
        for n in sizes:
            law = batch.make(case, n)
            if law is None:
                break
            ours, copy = batch.times(law, "mixture", n, rounds if n > 1e5 else 40 * rounds)
            ratios.append(min(ours) / min(copy))
        if len(ratios) == len(sizes):
            found[" ".join(case[:3])] = ratios
    return found


def main(arguments=None):
    """Run this file in a process for each target."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--targets", nargs="+", choices=TARGETS, default=list(TARGETS))
    parser.add_argument("--contacts", nargs="+", type=float, default=[4000, 4e6])
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--here", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args(arguments)
    sizes = [int(n) for n in options.contacts]
    if options.here:
        print(json.dumps(measure(sizes, options.rounds)))
        return
    flags = Path("/proc/cpuinfo").read_text().replace("_", ".").split()
    columns = {}
    for target in options.targets:
        if TARGETS[target] not in flags:
            print(f"{target}: this processor has no {TARGETS[target]}", file=sys.stderr)
            continue
        line = [sys.executable, __file__, "--here", "--rounds", str(options.rounds), "--contacts", *map(str, sizes)]
        environment = {**os.environ, "NUMBA_CPU_NAME": target, "NUMBA_CPU_FEATURES": ""}
        columns[target] = json.loads(subprocess.run(line, env=environment, check=True, stdout=subprocess.PIPE).stdout)
    writer = csv.writer(sys.stdout, lineterminator="\n")
    writer.writerow(["law", "unloading", "form", *(f"{target}: {n:g} contacts" for target in columns for n in sizes)])
    for case in next(iter(columns.values()), {}):
        writer.writerow([*case.split(), *(f"{ratio:.2f}" for found in columns.values() for ratio in found[case])])


if __name__ == "__main__":
    main()
