"""Cost of a step in LIGGGHTS or LAMMPS: demlaws/table against the engine's own Hertz and shear, in a block of touching spheres.

    python tools/benchmarks/bench_engines.py liggghts [--ranks 1 2] [--rounds 9] [--steps 300] [--sides 22 46] [--portable]
    python tools/benchmarks/bench_engines.py lammps --laws "pohrt-popov, hertz unloading" --sides 46 --weak --ranks 1 2 4
    python tools/benchmarks/bench_engines.py liggghts --sides 100 --ranks 2 --rounds 1        a million spheres

The block is a shaken simple cubic lattice in a periodic box (side³ spheres of three sizes, about 2 contacts each), so that no
packing need settle first. Every sphere keeps its own velocity: contacts load, unload, open and close, the same ones under
every law. The laws are timed in turn, round after round. --springs: partial slip, too; --levels: other numbers of levels, too.
--portable: the plugin compiled for any processor. --neighbour: another process copies arrays of 256 MB all the time;
use it with one rank less than cores. Columns:

step, pair     median of the ratios of the whole step and of the pair loop to the stock model of the same round
fastest        ratio of the fastest rounds (what is left where other programs share the machine)
efficiency     spheres moved per core and second over those of the table's first row (ranks beyond the cores share them)
MB, restart    peak memory of the largest rank; restart file
over light     the step over the time in which this machine's copy bandwidth, on as many cores, moves once the data that a step
               must read and write (spheres: place, velocity, spin, size, mass, force, torque; contacts: index, history read
               and written)
"""

import argparse
import os
import re
import statistics
import subprocess
import sys
import tempfile
import time
import warnings
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import NamedTuple

import numpy as np

import demlaws as dl
from demlaws.lammps.run import HEAD
from studies.trade.liggghts_oedometer import data_text

warnings.simplefilter("ignore", dl.ValidityWarning)

LIGGGHTS = """\
atom_style      granular
atom_modify     map array
boundary        p p p
newton          off
communicate     single vel yes
units           si
hard_particles  yes
processors      ${ranks} 1 1
read_data       block.data
neighbor        4e-4 bin
neigh_modify    delay 0 contact_distance_factor 1.01 one 200
fix             m1 all property/global youngsModulus peratomtype 6.06e8
fix             m2 all property/global poissonsRatio peratomtype 0.25
fix             m3 all property/global coefficientRestitution peratomtypepair 1 0.3
fix             m4 all property/global coefficientFriction peratomtypepair 1 0.5
pair_style      gran model ${model}
pair_coeff      * *
"""
LAMMPS = (
    HEAD
    + """\
boundary        p p p
newton          on
read_data       block.data
neighbor        4e-4 bin
neigh_modify    every 1 delay 0 check yes
pair_style      granular
pair_coeff      * * ${model}
"""
)
RUN = """\
timestep        2e-6
fix             move all nve/noforce
compute         touching all contact/atom
compute         ends all reduce sum c_touching
variable        contacts equal 0.5*c_ends
thermo_style    custom step ke v_contacts
thermo          ${steps}
run             ${warm}
run             ${steps}
write_restart   state.restart
"""
STOCK = "Hertz, stock"
OURS = {
    "Hertz, table": "hertz.tbl",
    "pohrt-popov, elastic": "elastic.tbl",
    "pohrt-popov, hertz unloading": "hysteretic.tbl",
    "pohrt-popov, thornton unloading": "thornton.tbl",
}
HISTORY = {  # bytes per contact, docs/tables/cost-memory.csv
    ("liggghts", STOCK): 24,
    ("liggghts", "pohrt-popov, hertz unloading"): 120,
    ("lammps", STOCK): 24,
    ("lammps", "pohrt-popov, hertz unloading"): 128,
}
SPHERE = 8 * (3 + 3 + 3 + 1 + 1 + 2 * 3 + 2 * 3)
CORES = len(os.sched_getaffinity(0))
PEAK = """import resource, subprocess, sys
code = subprocess.call(sys.argv[1:])
print("", 1024 * resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)
sys.exit(code)"""  # a process of its own: a child's peak begins with that of the process that starts it


def write_block(path, side, radius=2e-3, seed=1):
    """The data file of side³ spheres, which both engines read."""
    random = np.random.default_rng(seed)
    pitch, count = 2.0 * radius, side**3
    place = (np.indices((side, side, side)).reshape(3, -1).T + 0.5) * pitch + random.uniform(-2e-5, 2e-5, (count, 3))
    diameter = 2.0 * radius * random.choice([0.99, 1.0, 1.01], count)
    speed = random.normal(0.0, 0.05, (count, 3))
    atoms = [(1, d, 2650, *centre) for d, centre in zip(diameter, place, strict=True)]
    path.write_text(data_text([(0.0, side * pitch)] * 3, atoms, [(*v, 0, 0, 0) for v in speed], types=1))


def write_tables(folder):
    contact = dl.Contact(radius=1e-3, modulus=32.3e9, sigma=2.4e-6, fractal_dimension=2.22)
    # smooth, as stock: Hertz of a rough contact is below its range of force, which each step would count
    dl.law("hertz", dl.Contact(radius=1e-3, modulus=32.3e9)).tabulate().save(folder / "hertz.tbl")
    for name, unloading in (("elastic", "elastic"), ("hysteretic", "hertz"), ("thornton", "thornton")):
        dl.law("pohrt-popov", contact, unloading=unloading).tabulate().save(folder / f"{name}.tbl")


def variables(engine, name, ranks, steps, warm):
    """Variables of the input for one law."""
    table = OURS.get(name)
    file, _, shear = (table or "").partition(" ")
    if engine == "liggghts":
        model = f"demlaws/table tangential demlaws table {table}" if table else "hertz tangential history"
        return {"steps": steps, "warm": warm, "model": model, "ranks": ranks}
    ours = f"demlaws/table {file} 6.06e8 100.0 0.25 {shear} tangential demlaws"
    stock = "hertz/material 6.06e8 100.0 0.25 tangential mindlin NULL"
    return {"steps": steps, "warm": warm, "model": f"{ours if table else stock} 1.0 0.5 damping viscoelastic"}


def prepare(engine, folder):
    """Write input and tables."""
    (folder / "in.cost").write_text((LIGGGHTS if engine == "liggghts" else LAMMPS) + RUN)
    write_tables(folder)


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


@contextmanager
def neighbour(wanted):
    """A process that reads and writes memory while the block runs."""
    line = [sys.executable, "-c", "import numpy as np\na, b = np.zeros((2, 1 << 25))\nwhile True: np.copyto(a, b)"]
    if not wanted:
        yield
        return
    process = subprocess.Popen(line)
    try:
        yield
    finally:
        process.kill()


class Run(NamedTuple):
    """One law in one round."""

    step: float  # s per step
    pair: float  # of it in the pair loop
    contacts: int
    memory: int  # peak of the largest process [B]
    restart: int  # file [B]


PAIR_TIME = {"lammps": r"^Pair +\| *\S+ *\| *(\S+)", "liggghts": r"Pair +time \(%\) = (\S+)"}


def timings(engine, path):
    """(loop seconds, pair seconds) of the last run in a log."""
    text = path.read_text()
    loop, pair = re.findall(r"Loop time of (\S+)", text), re.findall(PAIR_TIME[engine], text, re.MULTILINE)
    return float(loop[-1]), float(pair[-1])


def run(engine, folder, name, ranks, steps, warm=100, portable=False):
    """`Run` of the block in `folder`."""
    module = import_module(f"demlaws.{engine}.run")
    values = variables(engine, name, ranks, steps, warm)
    line, environment = module.command("in.cost", ranks, values, plugin=name in OURS, portable=portable)
    line = [sys.executable, "-S", "-c", PEAK, *map(str, line)]
    done = subprocess.run(line, cwd=folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if done.returncode:
        raise SystemExit(done.stdout[-500:])
    log = folder / f"log.{engine}"
    step, pair = (seconds / steps for seconds in timings(engine, log))
    contacts = int(module.read_log(log)["contacts"][-1])
    return Run(step, pair, contacts, int(done.stdout.split()[-1]), (folder / "state.restart").stat().st_size)


def interleaved(engine, folder, ranks, rounds, steps, laws=None, **options):
    """law → its `Run` in each round; stock first."""
    runs = {name: [] for name in (STOCK, *(OURS if laws is None else laws))}
    for _ in range(rounds):
        for name, found in runs.items():
            found.append(run(engine, folder, name, ranks, steps, **options))
    return runs


def measure(folder, cases, rates, options):
    """Print a table; cases: (side of the block, ranks); rates: cores → bytes/s of copies."""
    heads = ("spheres", "ranks", "contacts", "µs/step", "step", "fastest", "pair", "efficiency", "MB", "restart", "over light")
    print(f"\n{'law':48}" + "".join(f"{head:>11}" for head in heads))
    first = {}
    for side, ranks in cases:
        write_block(folder / "block.data", side)
        settings = {"laws": options.laws, "warm": options.warm, "portable": options.portable}
        runs = interleaved(options.engine, folder, ranks, options.rounds, options.steps, **settings)
        cores, stock = min(ranks, CORES), runs[STOCK]
        for name, found in runs.items():
            best, light = min(found), "-"
            if history := HISTORY.get((options.engine, name)):
                moved = side**3 * SPHERE + best.contacts * (4 + 2 * history)
                light = f"{best.step * rates[cores] / moved:.1f}"
            step, pair = (statistics.median(ours[k] / peer[k] for ours, peer in zip(found, stock, strict=True)) for k in (0, 1))
            rate = side**3 / (best.step * cores)
            print(
                f"{name:48}{side**3:11}{ranks:11}{best.contacts:11}{1e6 * best.step:11.0f}{step:11.3f}"
                f"{best.step / min(stock).step:11.3f}{pair:11.3f}{rate / first.setdefault(name, rate):11.2f}"
                f"{best.memory / 1e6:11.0f}{best.restart / 1e6:11.1f}{light:>11}",
                flush=True,
            )


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("engine", choices=["liggghts", "lammps"])
    parser.add_argument("--ranks", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--steps", type=int, default=300)
    parser.add_argument("--warm", type=int, default=100, help="steps before the clock starts")
    parser.add_argument("--sides", type=int, nargs="+", default=[22, 46], help="spheres along an edge (22: 10,648; 46: 97,336)")
    parser.add_argument("--weak", action="store_true", help="also 97,336 spheres per rank")
    parser.add_argument("--portable", action="store_true", help="the plugin compiled for any processor, as the wheel's is")
    parser.add_argument("--laws", nargs="+", choices=list(OURS), metavar="LAW", help="only these laws of ours")
    parser.add_argument(
        "--springs", type=int, nargs="*", default=[], help="these laws with partial slip, too, of so many springs"
    )
    parser.add_argument(
        "--levels", type=int, nargs="*", default=[], help="these laws with so many levels of the default shear, too"
    )
    parser.add_argument("--neighbour", action="store_true", help="another process reads and writes memory all the time")
    options = parser.parse_args()
    laws = options.laws or ("pohrt-popov, elastic", "pohrt-popov, hertz unloading")
    more = {f"{name}, slip, {n} springs": f"{OURS[name]} shear slip springs {n}" for name in laws for n in options.springs}
    more |= {f"{name}, {n} levels": f"{OURS[name]} levels {n}" for name in laws for n in options.levels}
    OURS.update(more)
    if options.laws:
        options.laws += more
    rates = {n: bandwidth(n) for n in range(1, CORES + 1)}
    print("copies, bytes read and written: " + ", ".join(f"{n} cores {rate / 1e9:.1f} GB/s" for n, rate in rates.items()))
    tables = [[(side, n) for n in options.ranks] for side in options.sides]
    if options.weak:
        tables.append([(round(46 * n ** (1 / 3)), n) for n in options.ranks])
    with tempfile.TemporaryDirectory() as scratch, neighbour(options.neighbour):
        prepare(options.engine, Path(scratch))
        for cases in tables:
            measure(Path(scratch), cases, rates, options)


if __name__ == "__main__":
    main()
