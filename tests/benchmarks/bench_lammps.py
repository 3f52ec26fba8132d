"""Cost of a step in LAMMPS: demlaws/table against stock hertz/material, in a block of touching spheres.

    python tests/benchmarks/bench_lammps.py [--ranks 1 2] [--rounds 9] [--steps 300] [--sides 22 46] [--warm 100] [--portable]
    python tests/benchmarks/bench_lammps.py --count [--tangent]

The block is a shaken simple cubic lattice in a periodic box (side³ spheres of three sizes, some 2 contacts each), so no
packing need settle first. Every sphere keeps its own velocity: contacts load, unload, open and close, the same ones under
every law. Every law is timed in turn, round after round, with Mindlin's tangential model and the same damping, viscoelastic
(--tangent: ours with demlaws/tangent, which takes one more square root a contact). Printed are medians of the ratio to the
stock hertz/material of the same round, the ratio of the fastest rounds (what is left where other programs share the
machine), and the parallel efficiency T1/(n Tn) of the fastest rounds. --count: instructions a step instead of times, under
valgrind, of 1,000 spheres with the portable plugin: what other programs cannot disturb.
"""

import argparse
import re
import statistics
import subprocess
import tempfile
import warnings
from pathlib import Path

import numpy as np

import demlaws as dl
from demlaws.lammps import run, versions
from demlaws.lammps.run import HEAD, command, timings

warnings.simplefilter("ignore", dl.ValidityWarning)

CASE = (
    HEAD
    + """\
boundary        p p p
newton          on
read_data       block.data
neighbor        4e-4 bin
neigh_modify    every 1 delay 0 check yes
pair_style      granular
pair_coeff      * * ${normal} 6.06e8 ${eta} 0.25 tangential mindlin NULL 1.0 0.5 damping ${damping}
timestep        2e-6
fix             move all nve/noforce
compute         touching all contact/atom
compute         ends all reduce sum c_touching
variable        contacts equal 0.5*c_ends
thermo_style    custom step ke v_contacts
thermo          ${steps}
run             ${warm}
run             ${steps}
"""
)
STOCK = "hertz/material, stock"
OURS = {
    "hertz, table": "hertz.tbl",
    "pohrt-popov, elastic": "elastic.tbl",
    "pohrt-popov, hertz unloading": "hysteretic.tbl",
    "pohrt-popov, thornton unloading": "thornton.tbl",
}


def write_block(path, side, radius=2e-3, seed=1):
    random = np.random.default_rng(seed)
    pitch, count = 2.0 * radius, side**3
    place = (np.indices((side, side, side)).reshape(3, -1).T + 0.5) * pitch + random.uniform(-2e-5, 2e-5, (count, 3))
    diameter = 2.0 * radius * random.choice([0.99, 1.0, 1.01], count)
    speed = random.normal(0.0, 0.05, (count, 3))
    lines = ["block", "", f"{count} atoms", "1 atom types", ""]
    lines += [f"0 {side * pitch:.17g} {axis}lo {axis}hi" for axis in "xyz"] + ["", "Atoms", ""]
    rows = enumerate(zip(diameter, place, strict=True), start=1)
    lines += [f"{n} 1 {d:.17g} 2650 {x:.17g} {y:.17g} {z:.17g}" for n, (d, (x, y, z)) in rows]
    lines += ["", "Velocities", ""]
    lines += [f"{n} {u:.9g} {v:.9g} {w:.9g} 0 0 0" for n, (u, v, w) in enumerate(speed, start=1)]
    path.write_text("\n".join(lines) + "\n")


def values_of(name, steps, warm, tangent=False):
    """What the input is told, for one law."""
    ours = name in OURS
    normal = f"demlaws/table {OURS[name]}" if ours else "hertz/material"
    tangent = tangent and ours
    own = {"normal": normal, "eta": 0.5 if tangent else 100.0, "damping": "demlaws/tangent" if tangent else "viscoelastic"}
    return {**own, "steps": steps, "warm": warm}


def instructions(folder, name, steps, tangent):
    """Instructions of a run of so many steps."""
    line, environment = command("in.cost", 1, values_of(name, steps, 1, tangent), plugin=name in OURS, portable=True)
    tool = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null"]
    done = subprocess.run([*tool, *line], cwd=folder, env=environment, capture_output=True, text=True)
    return int(re.search(r"Collected : (\d+)", done.stderr)[1])


def count(folder, tangent):
    write_block(folder / "block.data", 10)
    print(f"{'law':32s} {'instructions a step':>20s} {'over stock':>11s}")
    stock = None
    for name in (STOCK, *OURS):
        step = (instructions(folder, name, 61, tangent) - instructions(folder, name, 1, tangent)) / 60
        stock = stock or step
        print(f"{name:32s} {step:20.0f} {step / stock:11.3f}", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--ranks", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--steps", type=int, default=300)
    parser.add_argument("--warm", type=int, default=100, help="steps before the clock starts")
    parser.add_argument("--sides", type=int, nargs="+", default=[22, 46], help="spheres along an edge (22: 10,648; 46: 97,336)")
    parser.add_argument("--portable", action="store_true", help="the plugin compiled for any processor, as the wheel's is")
    parser.add_argument("--count", action="store_true", help="count instructions, in valgrind, instead of time")
    parser.add_argument("--tangent", action="store_true", help="our laws with demlaws/tangent, stock with viscoelastic")
    options = parser.parse_args()
    print(f"LAMMPS {versions().date}{', portable plugin' if options.portable else ''}")
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        (folder / "in.cost").write_text(CASE)
        contact = dl.Contact(radius=1e-3, modulus=32.3e9, roughness=2.4e-6, fractal_dimension=2.22)
        dl.law("hertz", contact).tabulate().save(folder / "hertz.tbl")
        for name, unloading in (("elastic", "elastic"), ("hysteretic", "hertz"), ("thornton", "thornton")):
            dl.law("pohrt-popov", contact, unloading=unloading).tabulate().save(folder / f"{name}.tbl")

        if options.count:
            count(folder, options.tangent)
            return

        def simulate(name, ranks):
            values = values_of(name, options.steps, options.warm, options.tangent)
            log = run(folder / "in.cost", ranks, values, plugin=name in OURS, portable=options.portable)
            return log["contacts"][-1], timings(folder / "log.lammps")

        for side in options.sides:
            write_block(folder / "block.data", side)
            one = {}
            for ranks in options.ranks:
                times, contacts = {name: [] for name in (STOCK, *OURS)}, {}
                for _ in range(options.rounds):
                    for name, values in times.items():
                        contacts[name], seconds = simulate(name, ranks)
                        values.append(seconds)
                print(f"\n{side**3} spheres, ranks: {ranks}, median of {options.rounds} rounds of {options.steps} steps")
                titles = ("step ratio", "fastest", "pair ratio", "efficiency")
                print(f"{'law':32s} {'contacts':>9s} {'µs/step':>8s}" + "".join(f"{title:>12s}" for title in titles))
                stock = times[STOCK]
                for name, values in times.items():
                    step = min(v[0] for v in values)
                    ratio = statistics.median(v[0] / s[0] for v, s in zip(values, stock, strict=True))
                    pair = statistics.median(v[1] / s[1] for v, s in zip(values, stock, strict=True))
                    fastest = step / min(s[0] for s in stock)
                    one.setdefault(name, step * ranks)
                    efficiency, micro = one[name] / (step * ranks), step / options.steps * 1e6
                    cells = f"{contacts[name]:9.0f} {micro:8.0f}{ratio:12.3f}{fastest:12.3f}{pair:12.3f}{efficiency:12.2f}"
                    print(f"{name:32s} {cells}", flush=True)


if __name__ == "__main__":
    main()
