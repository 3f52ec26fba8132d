"""Scaling of a step under MPI, memory of a rank and restart files, in blocks of touching spheres (those of bench_engines.py).

    python tests/benchmarks/bench_scale.py lammps                  strong: 97,336 spheres; weak: 97,336 per rank; ranks 1 2 4
    python tests/benchmarks/bench_scale.py liggghts --sides 100 --ranks 2 --rounds 1        a million spheres

Columns: µs per step (fastest round); over the stock step; efficiency, spheres moved per core and second over those of the
table's first row (ranks beyond the cores share them); peak memory of the largest rank; restart file; the step over the time in
which this machine's copy bandwidth, on as many cores, moves once the data that a step must read and write (spheres: place,
velocity, spin, size, mass, force, torque; contacts: index, history read and written).
"""

import argparse
import os
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from importlib import import_module
from pathlib import Path

import numpy as np
from bench_engines import STOCK, prepare, variables, write_block

LAWS = (STOCK, "pohrt-popov, hertz unloading")
CORES = len(os.sched_getaffinity(0))
HISTORY = {  # bytes per contact, from the table of docs/shear.md, Memory
    ("liggghts", STOCK): 32,
    ("liggghts", LAWS[1]): 56,
    ("lammps", STOCK): 32,
    ("lammps", LAWS[1]): 64,
}
PEAK = """import resource, subprocess, sys
code = subprocess.call(sys.argv[1:])
print("", 1024 * resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)
sys.exit(code)"""  # a process of its own: a child's peak begins with that of the process that starts it
SPHERE = 8 * (3 + 3 + 3 + 1 + 1 + 2 * 3 + 2 * 3)


def bandwidth(threads):
    """Bytes/s read and written by copies of 256 MB arrays in so many threads at once, the fastest of nine."""
    arrays = [(np.zeros(1 << 25), np.ones(1 << 25)) for _ in range(threads)]
    fastest = np.inf
    with ThreadPoolExecutor(threads) as pool:
        for _ in range(9):
            start = time.perf_counter()
            list(pool.map(lambda pair: np.copyto(*pair), arrays))
            fastest = min(fastest, time.perf_counter() - start)
    return 2 * threads * arrays[0][0].nbytes / fastest


def run(engine, folder, name, ranks, options):
    """(s a step, contacts, peak memory of the largest process [B], restart file [B]) of one run."""
    module = import_module(f"demlaws.{engine}.run")
    values = variables(engine, name, ranks, options.steps, options.warm)
    line, environment = module.command("in.cost", ranks, values, plugin=name != STOCK)
    environment["OMPI_MCA_rmaps_base_oversubscribe"] = "1"
    line = [sys.executable, "-S", "-c", PEAK, *map(str, line)]
    done = subprocess.run(line, cwd=folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if done.returncode:
        raise SystemExit(done.stdout[-500:])
    log, peak = folder / f"log.{engine}", int(done.stdout.split()[-1])
    contacts = module.read_log(log)["contacts"][-1]
    return module.timings(log)[0] / options.steps, contacts, peak, (folder / "state.restart").stat().st_size


def measure(engine, folder, title, cases, options, rates):
    """Print a table; cases: (side of the block, ranks)."""
    print(f"\n{engine}, {title}")
    heads = ("spheres", "ranks", "contacts", "µs/step", "over stock", "efficiency", "MB a rank", "restart MB", "over light")
    print(f"{'law':30}" + "".join(f"{head:>11}" for head in heads))
    first = {}
    for side, ranks in cases:
        write_block(folder / "block.data", side)
        rounds = {name: [] for name in LAWS}
        for _ in range(options.rounds):
            for name, found in rounds.items():
                found.append(run(engine, folder, name, ranks, options))
        for name, found in rounds.items():
            step, contacts, memory, restart = min(found)
            busy = min(ranks, CORES)
            rate = side**3 / (step * busy)
            over, efficiency = step / min(rounds[STOCK])[0], rate / first.setdefault(name, rate)
            light = (side**3 * SPHERE + contacts * (4 + 2 * HISTORY[engine, name])) / rates[busy]
            print(
                f"{name:30}{side**3:11}{ranks:11}{contacts:11.0f}{1e6 * step:11.0f}{over:11.2f}{efficiency:11.2f}"
                f"{memory / 1e6:11.0f}{restart / 1e6:11.1f}{step / light:11.1f}",
                flush=True,
            )


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("engine", choices=["liggghts", "lammps"])
    parser.add_argument("--ranks", type=int, nargs="+", default=[1, 2, 4])
    parser.add_argument("--sides", type=int, nargs="+", help="only blocks of these sides, with each number of ranks")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--steps", type=int, default=100)
    parser.add_argument("--warm", type=int, default=20, help="steps before the clock starts")
    options = parser.parse_args()
    rates = {n: bandwidth(n) for n in range(1, CORES + 1)}
    print("copies, bytes read and written: " + ", ".join(f"{n} cores {rate / 1e9:.1f} GB/s" for n, rate in rates.items()))
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        prepare(options.engine, folder, "write_restart state.restart\n")
        if options.sides:
            cases = [(side, ranks) for side in options.sides for ranks in options.ranks]
            measure(options.engine, folder, "blocks", cases, options, rates)
            return
        measure(options.engine, folder, "strong scaling", [(46, n) for n in options.ranks], options, rates)
        weak = [(round(46 * n ** (1 / 3)), n) for n in options.ranks]
        measure(options.engine, folder, "weak scaling", weak, options, rates)


if __name__ == "__main__":
    main()
