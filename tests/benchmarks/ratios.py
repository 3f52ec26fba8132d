"""Ratios of interleaved timings, compared with the stored ones: `make bench`.

    python tests/benchmarks/ratios.py [--only kernels start ...] [--keep] [--contacts 4e6] [--rounds 9]

Times depend on the machine and on what else it does, ratios to a peer in the same run much less. Each ratio comes with its
noise: by how much the first and the second half of the rounds disagree. tests/benchmarks/ratios.json holds, by machine, what
was measured last with --keep; a ratio that is larger by more than 3 % beyond the noise of both is printed as SLOWER, one
above its goal as a miss. Nothing here fails: the suite has no timing in it.

kernels   `law.evaluate` over a copy kernel on the same arrays (bench_batch.py): virgin contacts, and a random mixture
start     `import demlaws` over `import numba`; `demlaws --help` over an argparse program's help; user and system time
surfaces  a load step of a measured map over scipy.ndimage.label of the same map
yade, liggghts   a step with our laws over the engine's own Hertz, per contact
"""

import argparse
import datetime
import json
import math
import os
import platform
import resource
import subprocess
import sys
import time
import warnings
from pathlib import Path
from typing import NamedTuple

import numba

import demlaws as dl

sys.path.insert(0, str(Path(__file__).parent))
import bench_batch

FILE = Path(__file__).with_name("ratios.json")
ALLOWED = 0.03


class Ratio(NamedTuple):
    value: float
    noise: float  # relative
    goal: float | None = None


def machine():
    """What a kept ratio is valid for."""
    model = platform.processor() or platform.machine()
    for line in Path("/proc/cpuinfo").read_text().splitlines() if Path("/proc/cpuinfo").is_file() else ():
        if line.startswith("model name"):
            model = line.partition(":")[2].strip()
            break
    return f"{model}, {os.cpu_count()} cores, numba {numba.__version__}"


def ratio_of(ours, peer, goal=None):
    """Fastest round of ours over the peer's fastest; noise from the halves of the rounds, which alternate."""
    halves = [min(ours[k::2]) / min(peer[k::2]) for k in (0, 1)]
    return Ratio(min(ours) / min(peer), abs(math.log(halves[0] / halves[1])), goal)


def alternate(functions, rounds):
    """Processor seconds of each function (name → function), one round after another."""
    taken = {name: [] for name in functions}
    for _ in range(rounds + 1):
        for name, function in functions.items():
            start = time.thread_time()
            function()
            taken[name].append(time.thread_time() - start)
    return {name: times[1:] for name, times in taken.items()}  # the first round compiles and touches memory


# --- what is measured: functions from (contacts, rounds) to name → Ratio


def kernels(contacts, rounds):
    laws = ("hertz", "rms", "pohrt-popov", "goddard", "rough-plastic")
    chosen = bench_batch.cases(laws, ("elastic", "hertz"), ("closed",), ("one",), ("float64",), ("1",))
    chosen += bench_batch.cases(("pohrt-popov", "rough-plastic"), ("thornton",), ("closed",), ("one",), ("float64",), ("1",))
    chosen += bench_batch.cases(("pohrt-popov",), ("elastic", "hertz"), ("table",), ("one",), ("float64",), ("1",))
    chosen += bench_batch.cases(("pohrt-popov",), ("elastic", "hertz"), ("closed",), ("each",), ("float64",), ("1",))
    chosen += bench_batch.cases(("yip-venart",), ("elastic",), ("closed",), ("one",), ("float64",), ("1",))
    found = {}
    for case in chosen:
        law = bench_batch.make(case, contacts)
        for extreme in bench_batch.EXTREMES if law else ():
            law_times, copy_times = bench_batch.times(law, case, extreme, contacts, rounds)
            name = f"{case.law}, {case.unloading}, {case.form}, {case.scales}, {extreme}"
            found[name] = ratio_of(law_times, copy_times, bench_batch.goal(case))
    return found


def _cpu_of(command):
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(command, stdout=subprocess.DEVNULL, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def start(contacts, rounds):
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


def surfaces(contacts, rounds):
    from scipy import ndimage

    from demlaws.solvers.contact import RoughContact
    from demlaws.surface import self_affine
    from studies.jamari.published import published_contact

    found = {}
    for size in (1024, 2048):
        heights = self_affine(size, 0.5e-6, 0.8, 1.3e-6, 1, periodic=True)
        contact = RoughContact(heights, published_contact("isotropic").pair, 0.34, flat=True)
        load = 0.2 * (size / 512) ** 2
        step = contact.load(load)
        both = {
            "load": lambda contact=contact, load=load: contact.load(load),
            "label": lambda contact=contact, cut=step.cut: ndimage.label(contact.gap > cut),
        }
        taken = alternate(both, min(rounds, 5))
        found[f"load step / labelling, {size}²"] = ratio_of(taken["load"], taken["label"], 20.0)
    return found


def _engine(engine, quick_rounds):
    from studies.trade import trade

    runs = [trade.engine_trade(engine, quick=True) for _ in range(quick_rounds)]
    found = {}
    for entries in zip(*runs, strict=True):
        values = [e.cost.over_hertz for e in entries]
        found[entries[0].cost.way.label] = Ratio(min(values), math.log(max(values) / min(values)))
    return found


def yade(contacts, rounds):
    return _engine("yade", 2)


def liggghts(contacts, rounds):
    return _engine("liggghts", 2)


PARTS = {function.__name__: function for function in (kernels, start, surfaces, yade, liggghts)}


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
    temporary = file.with_suffix(".tmp")
    temporary.write_text(json.dumps(everything, indent=1, ensure_ascii=False) + "\n")
    temporary.replace(file)


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="+", choices=list(PARTS), default=list(PARTS))
    parser.add_argument("--contacts", type=float, default=4e6, help="contacts of a batch (default %(default)g)")
    parser.add_argument("--rounds", type=int, default=10, help="default %(default)s")
    parser.add_argument("--keep", action="store_true", help=f"write the ratios to {FILE.name}")
    chosen = parser.parse_args(arguments)
    warnings.simplefilter("ignore", dl.ValidityWarning)
    where = machine()
    print(f"{where}, load {os.getloadavg()[0]:.1f}")
    found = {}
    for part in chosen.only:
        try:
            measured = PARTS[part](int(chosen.contacts), chosen.rounds)
        except dl.DemlawsError as error:
            print(f"{part}: left out: {error}")
            continue
        for name, ratio in measured.items():
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
