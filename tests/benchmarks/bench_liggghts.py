"""Cost of a step in LIGGGHTS: demlaws/table against stock hertz in a settled packing of 10,000 spheres.

    python tests/benchmarks/bench_liggghts.py [--ranks 1 2] [--rounds 9] [--steps 1000] [--count 10000] [--portable]

Settles the packing once (3 minutes, kept in the cache), lets every law come to rest in it (a stiffer one bounces off the
overlaps of the rough law first: 15,000 steps; the contacts left are printed, for they are what a step costs), then times
the same number of steps of each law in turn, round after round, all at contact_distance_factor 1.01. Printed are medians of the
ratio to the stock hertz of the same round, the ratio of the fastest rounds (what is left where other programs share the
machine), and the parallel efficiency T1/(n Tn) of the fastest rounds. --portable adds rows of the plugin compiled without
-march=native: what is left of the gain there comes from the plugin's pair loop, as the stock binary, too, is compiled for
any processor. The row of stock edinburgh is Pohrt–Popov fitted at 3 mN, a contact of this packing, without damping, on one
rank: on more it loses its history.
"""

import argparse
import importlib.util
import statistics
import sys
import tempfile
import time
import warnings
from pathlib import Path

import numpy as np

import demlaws as dl
from demlaws.engines import cache_folder
from demlaws.liggghts import build, run
from demlaws.liggghts.export import stock_fit, stock_properties
from demlaws.liggghts.run import timings

warnings.simplefilter("ignore", dl.ValidityWarning)
INPUTS = Path(__file__).parents[2] / "liggghts_inputs"

HEAD = """\
atom_style      granular
atom_modify     map array
boundary        m m m
newton          off
communicate     single vel yes
units           si
hard_particles  yes
processors      ${ranks} 1 1
"""
CASE = """\
neighbor        4e-4 bin
neigh_modify    delay 0 contact_distance_factor 1.01
fix             m1 all property/global youngsModulus peratomtype 6.06e8
fix             m2 all property/global poissonsRatio peratomtype 0.25
fix             m3 all property/global coefficientRestitution peratomtypepair 1 ${restitution}
include         ${more}
fix             m4 all property/global coefficientFriction peratomtypepair 1 0.5
pair_style      gran model ${model} tangential history ${words}
pair_coeff      * *
timestep        4e-6
fix             gravity all gravity 9.81 vector 0 0 -1
variable        low equal -${half}
fix             w1 all wall/gran model ${model} tangential history primitive type 1 zplane 0.0 ${words}
fix             w2 all wall/gran model ${model} tangential history primitive type 1 xplane ${low} ${words}
fix             w3 all wall/gran model ${model} tangential history primitive type 1 xplane ${half} ${words}
fix             w4 all wall/gran model ${model} tangential history primitive type 1 yplane ${low} ${words}
fix             w5 all wall/gran model ${model} tangential history primitive type 1 yplane ${half} ${words}
fix             move all nve/sphere
thermo_style    custom step atoms ke
thermo          100000
"""
STOCK, EDINBURGH = "hertz, stock", "edinburgh, stock"
CONTACTS = """\
compute         touching all contact/atom
compute         ends all reduce sum c_touching
variable        contacts equal 0.5*c_ends
thermo_style    custom step atoms ke v_contacts
"""
MODELS = {
    STOCK: ("hertz", "tangential_damping on"),
    EDINBURGH: ("edinburgh/stiffness", "tangential_damping on"),
    "hertz, table": ("demlaws/table", "table hertz.tbl"),
    "pohrt-popov, elastic": ("demlaws/table", "table elastic.tbl"),
    "pohrt-popov, hertz unloading": ("demlaws/table", "table hysteretic.tbl"),
    "pohrt-popov, thornton unloading": ("demlaws/table", "table thornton.tbl"),
}
PORTABLE = {
    "hertz, portable": MODELS["hertz, table"],
    "pohrt-popov, elastic, portable": MODELS["pohrt-popov, elastic"],
    "pohrt-popov, hertz, portable": MODELS["pohrt-popov, hertz unloading"],
}


def settled(count, half, height):
    """Positions of a packing that liggghts_inputs/packing has settled (cached)."""
    folder = cache_folder() / f"packing-{count}-120000"
    dump = folder / "post" / "settled.dump"
    if not dump.is_file():
        print(f"settling {count} spheres ...", flush=True)
        sys.path.insert(0, str(INPUTS))
        import common

        common.copy_inputs(INPUTS / "packing" / "run.py", folder)
        spec = importlib.util.spec_from_file_location("packing_run", INPUTS / "packing" / "run.py")
        case = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(case)
        common.table(folder, "granite.tbl", case.law())
        run(folder / "in.packing", 2, {"half": half, "height": height, "count": count, "settle": 120000})
    return np.loadtxt(dump, skiprows=9)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--ranks", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--steps", type=int, default=1000)
    parser.add_argument("--count", type=int, default=10000)
    parser.add_argument("--rest", type=int, default=15000, help="steps in which a law comes to rest before it is timed")
    parser.add_argument(
        "--laws", nargs="+", default=list(MODELS), choices=list(MODELS), help="which of them (stock is always run)"
    )
    parser.add_argument("--portable", action="store_true", help="time the plugin without -march=native, too")
    options = parser.parse_args()
    models = {name: MODELS[name] for name in MODELS if name in options.laws or name == STOCK}
    if options.portable:
        models.update(PORTABLE)
    begin = time.perf_counter()
    build(force=True)
    if options.portable:
        build(portable=True)
    print(f"build of the plugin: {time.perf_counter() - begin:.1f} s")
    half = 0.04 * (options.count / 10000) ** 0.5
    rows = settled(options.count, half, 0.19)
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        lines = ["settled", "", f"{len(rows)} atoms", "1 atom types", "", f"-{half} {half} xlo xhi", f"-{half} {half} ylo yhi"]
        lines += ["0 0.19 zlo zhi", "", "Atoms", ""]
        lines += [f"{int(r[0])} 1 {2 * r[2]:.17g} 2650 {r[3]:.17g} {r[4]:.17g} {r[5]:.17g}" for r in rows]
        (folder / "settled.data").write_text("\n".join(lines) + "\n")
        contact = dl.Contact(radius=1e-3, modulus=32.3e9, roughness=2.4e-6, fractal_dimension=2.22)
        dl.law("hertz", contact).tabulate().save(folder / "hertz.tbl")
        for name, unloading in (("elastic", "elastic"), ("hysteretic", "hertz"), ("thornton", "thornton")):
            dl.law("pohrt-popov", contact, unloading=unloading).tabulate().save(folder / f"{name}.tbl")
        (folder / "in.rest").write_text(
            HEAD + "read_data settled.data\n" + CASE + CONTACTS + "run ${steps}\nwrite_restart ${file}\n"
        )
        (folder / "in.time").write_text(HEAD + "read_restart ${file}\n" + CASE + "run 50\nrun ${steps}\n")
        packed = contact.with_values(modulus=contact.modulus / 100)  # the modulus of the case
        fit = stock_fit(dl.law("pohrt-popov", packed, unloading="hertz"), 3e-3, "edinburgh")
        (folder / "edinburgh.inc").write_text(stock_properties(fit, 1))
        (folder / "none.inc").write_text("# nothing\n")

        def simulate(name, number, script, ranks, steps):
            model, words = models[name]
            own = {"model": model, "words": words, "file": f"rest.{number}", "ranks": ranks, "steps": steps}
            peer = name == EDINBURGH
            own |= {"half": half, "more": "edinburgh.inc" if peer else "none.inc", "restitution": 1.0 if peer else 0.3}
            return run(folder / script, ranks, own, plugin=name not in (STOCK, EDINBURGH), portable=name in PORTABLE)

        print("contacts of spheres when timed")
        for number, name in enumerate(models):
            rest = simulate(name, number, "in.rest", 1, options.rest)
            print(f"{name:32s} {rest['contacts'][-1]:8.0f}", flush=True)
        pair_one = {}
        for ranks in options.ranks:
            times = {name: [] for name in models if ranks == 1 or name != EDINBURGH}
            for _ in range(options.rounds):
                for number, name in enumerate(models):
                    if name in times:
                        simulate(name, number, "in.time", ranks, options.steps)
                        times[name].append(timings(folder / "log.liggghts"))
            title = f"{len(rows)} spheres, ranks: {ranks}, median of {options.rounds} rounds of {options.steps} steps"
            print("\n" + title)
            print(f"{'law':32s} {'µs/step':>8s} {'step ratio':>11s} {'fastest':>8s} {'pair ratio':>11s} {'efficiency':>11s}")
            stock = times[STOCK]
            for name, values in times.items():
                step = min(v[0] for v in values)
                ratio = statistics.median(v[0] / s[0] for v, s in zip(values, stock, strict=True))
                pair = statistics.median(v[1] / s[1] for v, s in zip(values, stock, strict=True))
                fastest = step / min(s[0] for s in stock)
                pair_one.setdefault(name, step * ranks)
                efficiency = pair_one[name] / (step * ranks)
                micro = step / options.steps * 1e6
                print(f"{name:32s} {micro:8.0f} {ratio:11.3f} {fastest:8.3f} {pair:11.3f} {efficiency:11.2f}", flush=True)


if __name__ == "__main__":
    main()
