"""Ratios of interleaved timings, compared with the stored ones: `make bench`.

    python tools/benchmarks/ratios.py [--only kernels start ...] [--every] [--keep] [--contacts 4e6] [--rounds 9]

Times depend on the machine and on what else it does, ratios to a peer in the same run much less. Each ratio comes with its
noise: by how much the first and the second half of the rounds disagree. tools/benchmarks/ratios.json holds, by machine, what
was measured last with --keep; a ratio that is larger by more than 3 % beyond the noise of both is printed as SLOWER, one
above its goal as a miss. Nothing here fails: the suite has no timing in it.

kernels   `law.evaluate` over a copy kernel on the same arrays (batch.py): virgin contacts, and a random mixture; --every: of
          each law and rule
cores     the same on all cores over one core, law and copy kernel: what memory allows
start     `import demlaws` over `import numba`; `demlaws --help` over an argparse program's help; user and system time
waits     seconds, not ratios: a user's waiting time in a new process, with an empty cache of machine code, then a full one
liggghts, lammps, yade    a step (in YADE the interaction loop) over that with the engine's own Hertz law and shear
"""

import argparse
import datetime
import json
import math
import os
import platform
import re
import resource
import subprocess
import sys
import tempfile
import time
import warnings
from itertools import product
from pathlib import Path
from typing import NamedTuple

import numba
import numpy as np

import demlaws as dl
from demlaws.core.unloading import RULES
from demlaws.files import write_atomically
from demlaws.yade.run import run as run_in_yade

sys.path.insert(0, str(Path(__file__).parent))
import batch
import bench_engines
import bench_fit

FILE = Path(__file__).with_name("ratios.json")
BALLAST = FILE.parents[2] / "tests" / "data" / "ballast.toml"
ALLOWED = 0.03


class Ratio(NamedTuple):
    value: float
    noise: float  # relative
    goal: float | None = None


def machine():
    """What a kept ratio is valid for."""
    cpuinfo = Path("/proc/cpuinfo")
    lines = cpuinfo.read_text().splitlines() if cpuinfo.is_file() else ()
    model = next((line.partition(":")[2].strip() for line in lines if line.startswith("model name")), platform.machine())
    return f"{model}, {os.cpu_count()} cores, numba {numba.__version__}"


def ratio_of(ours, peer, goal=None):
    """Fastest round of ours over the peer's fastest; noise from the halves of the rounds, which alternate."""
    halves = [min(ours[k::2]) / min(peer[k::2]) for k in (0, 1)]
    return Ratio(min(ours) / min(peer), abs(math.log(halves[0] / halves[1])), goal)


# --- what is measured: functions from (contacts, rounds, every) to name → Ratio


CASES = [
    *(batch.Case(*case) for case in product(("hertz", "rms", "pohrt-popov", "goddard", "rough-plastic"), ("elastic", "hertz"))),
    *(batch.Case(law, "thornton") for law in ("pohrt-popov", "rough-plastic")),
    *(batch.Case("pohrt-popov", rule, "table") for rule in ("elastic", "hertz")),
    *(batch.Case("pohrt-popov", rule, scales="each") for rule in ("elastic", "hertz")),
    batch.Case("yip-venart", "elastic"),
]


def kernels(contacts, rounds, every=False):
    cases = CASES
    if every:
        cases = [batch.Case(*case) for case in product(dl.laws(), RULES, ("closed", "table"), ("one", "each"))]
    found = {}
    for case in cases:
        law = batch.make(case, contacts)
        for extreme in batch.EXTREMES if law else ():
            found[", ".join((*case, extreme))] = ratio_of(*batch.times(law, extreme, contacts, rounds), batch.goal(case))
    return found


def cores(contacts, rounds, every=False):
    found = {}
    for case in (batch.Case("hertz", "elastic"), batch.Case("pohrt-popov", "hertz"), batch.Case("rough-plastic", "thornton")):
        law = batch.make(case, contacts)
        one, several = (batch.times(law, "mixture", contacts, rounds, parallel) for parallel in (False, True))
        for what, ours, peer, goal in zip(("law", "copy of its arrays"), several, one, (1 / 1.7, None), strict=True):
            found[f"{case.law}, {case.unloading}, {what}"] = ratio_of(ours, peer, goal)
    return found


def _cpu_of(command):
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(command, stdout=subprocess.DEVNULL, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def start(contacts, rounds, every=False):
    help_of = "import argparse; argparse.ArgumentParser().parse_args(['--help'])"
    commands = {
        "numba": ["-c", "import numba"],
        "demlaws": ["-c", "import demlaws"],
        "law": ["-c", "import demlaws; demlaws.law('hertz', demlaws.Contact(1e-2, 1e10)).force(1e-6)"],
        "argparse": ["-c", help_of],
        "help": ["-m", "demlaws", "--help"],
    }
    taken = {name: [] for name in commands}
    for _ in range(max(rounds, 10)):
        for name, command in commands.items():
            taken[name].append(_cpu_of([sys.executable, *command]))
    return {
        "import demlaws / import numba": ratio_of(taken["demlaws"], taken["numba"], 1.3),
        "a first force / import numba": ratio_of(taken["law"], taken["numba"]),
        "demlaws --help / argparse --help": ratio_of(taken["help"], taken["argparse"], 1.5),
    }


FIT = """
import numpy, demlaws
points = numpy.loadtxt({file!r})
demlaws.fit(points, demlaws.Contact(4.35e-3, 32.32e9, 4e-6, 2.4, 6.266e9))
"""
PLOT = """
import matplotlib; matplotlib.use("agg")
import demlaws
law = demlaws.law("pohrt-popov", demlaws.Contact(4.35e-3, 32.32e9, 2.4e-6, 2.22), unloading="hertz")
print(law.follow([1e-6, 2e-6, 1e-6]).force)
law.plot()
"""


def waits(contacts, rounds, every=False):
    """Wall time; run on an idle machine."""
    force = np.concatenate([np.linspace(1, 90, 40), np.linspace(86, 2, 20)])
    case = next(case for case in bench_fit.CASES if case.name == "inside")._replace(force=force, noise=5e-8)
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "points")
        np.savetxt(file, bench_fit.made(case, 1))
        commands = {
            "a force and a plot": (8.0, 1.5, ["-c", PLOT]),
            "fit of all laws to 60 points": (6.0, 2.0, ["-c", FIT.format(file=str(file))]),
            "choose on ballast.toml": (
                8.0,
                2.0,
                ["-m", "demlaws", "choose", str(BALLAST)],
            ),
        }
        for name, (cold, warm, command) in commands.items():
            taken = []
            for _ in range(max(2, min(rounds, 4)) + 1):
                begin = time.perf_counter()
                environment = {**os.environ, "NUMBA_CACHE_DIR": str(Path(folder, name)), "PYTHONWARNINGS": "ignore"}
                subprocess.run([sys.executable, *command], env=environment, stdout=subprocess.DEVNULL, check=True)
                taken.append(time.perf_counter() - begin)
            found[f"{name}, first time (s)"] = Ratio(taken[0], 0.1, cold)
            found[f"{name}, again (s)"] = Ratio(min(taken[1:]), math.log(max(taken[1:]) / min(taken[1:])), warm)
    return found


def _steps(engine, goals, rounds):
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        bench_engines.prepare(engine, Path(folder))
        bench_engines.write_block(Path(folder) / "block.data", 22)
        for ranks in (1, 2):
            runs = bench_engines.interleaved(engine, Path(folder), ranks, max(3, rounds // 2), 300)
            steps = {name: [run.step for run in found] for name, found in runs.items()}
            stock = steps.pop(bench_engines.STOCK)
            for name, ours in steps.items():
                found[f"{name}, {ranks} ranks"] = ratio_of(ours, stock, goals[name.endswith("unloading")])
    return found


def liggghts(contacts, rounds, every=False):
    return _steps("liggghts", (0.95, 0.95), rounds)


def lammps(contacts, rounds, every=False):
    return _steps("lammps", (1.0, 1.03), rounds)


def yade(contacts, rounds, every=False):
    laws = ("hertz", "pohrt-popov, hertz unloading", "rough-plastic, thornton unloading")
    script = Path(__file__).parents[2] / "yade_scripts" / "cost.py"
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        options = ["--quick", "--bridge", "--sizes", "4000", "15000", "60000", "--out", folder, "--laws", *laws]
        lines = run_in_yade(script, options, capture_output=True, text=True).stdout.splitlines()
    for line in lines:
        if heading := re.match(r"interaction loop, (\d+) contacts", line):
            size = heading[1]
        elif name := next((name for name in laws if line.startswith(f"bridge: {name}  ")), None):
            columns = re.findall(r"([\d.]+) \(([\d.]+)-([\d.]+)\)", line)
            for threads, (median, low, high) in enumerate(columns, start=1):
                noise = math.log(float(high) / float(low))
                found[f"{name}, {size} contacts, {threads} threads"] = Ratio(float(median), noise, 1.05)
    return found


PARTS = {function.__name__: function for function in (kernels, cores, start, waits, liggghts, lammps, yade)}


# --- what is kept


def compare(kept, found):
    """Lines on what became slower and what misses its goal; name → Ratio on both sides."""
    lines = []
    for name, now in found.items():
        if now.goal is not None and now.value > now.goal:
            lines.append(f"misses its goal: {name}: {now.value:.3f}, goal {now.goal:g}")
        if name not in kept:
            continue
        before = kept[name]
        change = now.value / before.value - 1.0
        if change > ALLOWED + now.noise + before.noise:
            noise = f"noise {before.noise:.1%} and {now.noise:.1%}"
            lines.append(f"SLOWER by {change:.1%}: {name}: {before.value:.3f} → {now.value:.3f} ({noise})")
    return lines


def read(file, where):
    """Ratios kept for this machine."""
    if not file.is_file():
        return {}
    of_machine = json.loads(file.read_text()).get(where, {"ratios": {}})
    return {name: Ratio(*values) for name, values in of_machine["ratios"].items()}


def keep(file, where, ratios):
    """Write them into the file, beside those of other machines."""
    everything = json.loads(file.read_text()) if file.is_file() else {}
    everything[where] = {
        "measured": datetime.date.today().isoformat(),
        "load": round(os.getloadavg()[0], 1),
        "version": dl.__version__,
        "ratios": {name: [round(r.value, 4), round(r.noise, 4), r.goal] for name, r in sorted(ratios.items())},
    }
    write_atomically(file, json.dumps(everything, indent=1, ensure_ascii=False) + "\n")


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="+", choices=list(PARTS), default=list(PARTS))
    parser.add_argument("--contacts", type=float, default=4e6, help="contacts of a batch (default %(default)g)")
    parser.add_argument("--rounds", type=int, default=10, help="default %(default)s")
    parser.add_argument("--every", action="store_true", help="every law and rule, as closed form and as table")
    parser.add_argument("--keep", action="store_true", help=f"write the ratios to {FILE.name}")
    chosen = parser.parse_args(arguments)
    warnings.simplefilter("ignore", dl.ValidityWarning)
    where = machine()
    print(f"{where}, load {os.getloadavg()[0]:.1f}")
    found = {}
    for part in chosen.only:
        for name, ratio in PARTS[part](int(chosen.contacts), chosen.rounds, chosen.every).items():
            print(f"{part + ':':10}{name:62}{ratio.value:8.3f}  ± {ratio.noise:6.1%}", flush=True)
            found[f"{part}: {name}"] = ratio
    kept = read(FILE, where)
    lines = compare(kept, found)
    print(*lines, sep="\n")
    known = sum(name in kept for name in found)
    print(f"{len(found)} ratios; {known} of them compared with those kept for this machine")
    if chosen.keep:
        keep(FILE, where, {**kept, **found})
        print(f"kept in {FILE}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
