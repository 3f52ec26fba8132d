"""Cost of a step in LIGGGHTS or LAMMPS: demlaws/table against the engine's own Hertz and shear, in a block of touching spheres.

    python tests/benchmarks/bench_engines.py liggghts [--ranks 1 2] [--rounds 9] [--steps 300] [--sides 22 46] [--portable]
    python tests/benchmarks/bench_engines.py lammps --springs 12

The block is a shaken simple cubic lattice in a periodic box (side³ spheres of three sizes, some 2 contacts each), so that no
packing need settle first. Every sphere keeps its own velocity: contacts load, unload, open and close, the same ones under
every law. The laws are timed in turn, round after round. Printed are medians of the ratio to the stock model of the same
round, the ratio of the fastest rounds (what is left where other programs share the machine), and the parallel efficiency
T1/(n Tn) of the fastest rounds. --springs: partial slip, too. --portable: the plugin compiled for any processor.
"""

import argparse
import statistics
import tempfile
import warnings
from importlib import import_module
from pathlib import Path

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
"""
STOCK = "Hertz, stock"
OURS = {
    "Hertz, table": "hertz.tbl",
    "pohrt-popov, elastic": "elastic.tbl",
    "pohrt-popov, hertz unloading": "hysteretic.tbl",
    "pohrt-popov, thornton unloading": "thornton.tbl",
}
WIDTH = 48


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
    contact = dl.Contact(radius=1e-3, modulus=32.3e9, roughness=2.4e-6, fractal_dimension=2.22)
    dl.law("hertz", contact).tabulate().save(folder / "hertz.tbl")
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


def prepare(engine, folder, more=""):
    """Write input and tables."""
    (folder / "in.cost").write_text((LIGGGHTS if engine == "liggghts" else LAMMPS) + RUN + more)
    write_tables(folder)


def interleaved(engine, folder, ranks, rounds, steps, warm=100, portable=False):
    """law → ((whole step, pair loop) [s] of each round), law → contacts; of the block in `folder`."""
    module = import_module(f"demlaws.{engine}.run")
    times, contacts = {name: [] for name in (STOCK, *OURS)}, {}
    for _ in range(rounds):
        for name, seconds in times.items():
            values = variables(engine, name, ranks, steps, warm)
            log = module.run(folder / "in.cost", ranks, values, plugin=name in OURS, portable=portable)
            contacts[name] = log["contacts"][-1]
            seconds.append(module.timings(folder / f"log.{engine}"))
    return times, contacts


def measure(engine, folder, options):
    """Print ratios of interleaved timings for every size and number of ranks."""
    for side in options.sides:
        write_block(folder / "block.data", side)
        one = {}
        for ranks in options.ranks:
            settings = (options.rounds, options.steps, options.warm, options.portable)
            times, contacts = interleaved(engine, folder, ranks, *settings)
            print(f"\n{side**3} spheres, ranks: {ranks}, {options.rounds} rounds of {options.steps} steps")
            titles = ("step ratio", "fastest", "pair ratio", "efficiency")
            print(f"{'law':{WIDTH}} {'contacts':>9} {'µs/step':>8}" + "".join(f"{title:>12}" for title in titles))
            stock = times[STOCK]
            for name, seconds in times.items():
                step = min(s[0] for s in seconds)
                ratio, pair = (statistics.median(s[k] / t[k] for s, t in zip(seconds, stock, strict=True)) for k in (0, 1))
                fastest = step / min(t[0] for t in stock)
                one.setdefault(name, step * ranks)
                figures = (ratio, fastest, pair, one[name] / (step * ranks))
                cells = "".join(f"{figure:12.3f}" for figure in figures)
                print(f"{name:{WIDTH}} {contacts[name]:9.0f} {step / options.steps * 1e6:8.0f}{cells}", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("engine", choices=["liggghts", "lammps"])
    parser.add_argument("--ranks", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--steps", type=int, default=300)
    parser.add_argument("--warm", type=int, default=100, help="steps before the clock starts")
    parser.add_argument("--sides", type=int, nargs="+", default=[22, 46], help="spheres along an edge (22: 10,648; 46: 97,336)")
    parser.add_argument("--portable", action="store_true", help="the plugin compiled for any processor, as the wheel's is")
    parser.add_argument("--springs", type=int, nargs="*", default=[], help="partial slip, too, with these numbers of springs")
    options = parser.parse_args()
    for name in ("pohrt-popov, elastic", "pohrt-popov, hertz unloading"):
        OURS.update({f"{name}, slip, {n} springs": f"{OURS[name]} shear slip springs {n}" for n in options.springs})
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        prepare(options.engine, folder)
        measure(options.engine, folder, options)


if __name__ == "__main__":
    main()
