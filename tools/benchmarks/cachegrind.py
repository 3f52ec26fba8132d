"""Instructions and cache misses of a contact and step in LIGGGHTS or LAMMPS, stock and ours, counted by `valgrind`.

    python tools/benchmarks/cachegrind.py liggghts [--levels 1 2]                             ten minutes

The block of bench_engines.py. Each law runs twice, the second time for 20 steps more; the difference, over 20 steps and the
number of contacts, includes the neighbours that do not touch. The caches are those of one core: 32 kB, and a second level of
1 MB as the last one, beyond which other programs share. The plugin is compiled for a processor with AVX2, the newest that
valgrind knows.
"""

import argparse
import re
import subprocess
import tempfile
from importlib import import_module
from pathlib import Path

import bench_engines

LONG, SHORT = 22, 2
COUNTS = {
    "instructions per contact and step": "I +refs",
    "data read, written": "D +refs",
    "misses of 32 kB": "D1 +misses",
    "misses of 1 MB": "LLd misses",
}


def counts(engine, folder, name, steps):
    """The numbers of valgrind's summary for one run."""
    module = import_module(f"demlaws.{engine}.run")
    values = bench_engines.variables(engine, name, 1, steps, 1)
    line, environment = module.command("in.cost", 1, values, plugin=name in bench_engines.OURS, portable=True)
    line = [str(word) for word in line]
    at = next(k for k, word in enumerate(line) if Path(word).name.startswith(("liggghts", "lmp")))
    valgrind = ["valgrind", "--tool=cachegrind", "--cache-sim=yes", "--cachegrind-out-file=/dev/null"]
    valgrind += ["--D1=32768,8,64", "--LL=1048576,16,64"]
    done = subprocess.run([*line[:at], *valgrind, *line[at:]], cwd=folder, env=environment, capture_output=True, text=True)
    found = [re.search(rf"{pattern}: +([\d,]+)", done.stderr) for pattern in COUNTS.values()]
    if done.returncode or None in found:
        raise SystemExit((done.stdout + done.stderr)[-1000:])
    contacts = int(module.read_log(folder / f"log.{engine}")["contacts"][-1])
    return contacts, [int(number[1].replace(",", "")) for number in found]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("engine", choices=["liggghts", "lammps"])
    parser.add_argument("--levels", type=int, nargs="*", default=[1, 2])
    options = parser.parse_args()
    plugin = import_module(f"demlaws.{options.engine}.build").PLUGIN
    plugin.flags = (*plugin.flags, "-march=haswell")
    law = "pohrt-popov, hertz unloading"
    bench_engines.OURS.update({f"{law}, {n} levels": f"{bench_engines.OURS[law]} levels {n}" for n in options.levels})
    print("engine,law," + ",".join(f'"{name}"' for name in COUNTS))
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        bench_engines.write_block(folder / "block.data", 22)
        bench_engines.prepare(options.engine, folder)
        for name in [bench_engines.STOCK, "Hertz, table", *(name for name in bench_engines.OURS if name.startswith(law))]:
            (_, few), (contacts, many) = (counts(options.engine, folder, name, steps) for steps in (SHORT, LONG))
            per = [(b - a) / (LONG - SHORT) / contacts for a, b in zip(few, many, strict=True)]
            print(f'{options.engine},"{name}",{per[0]:.0f},{per[1]:.0f},{per[2]:.1f},{per[3]:.1f}', flush=True)


if __name__ == "__main__":
    main()
