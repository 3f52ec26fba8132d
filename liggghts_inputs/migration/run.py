"""A contact that crosses from one rank to the other in mid-unloading, and a block on 1, 2 and 4 ranks; about 10 s.

python run.py -np 2
"""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent))
import common

from demlaws.liggghts import run
from demlaws.make import example


def law(unloading="hertz"):
    return example("pohrt-popov", common.contact(8.76e-3, 8.63e-3), unloading)


def write_block(path):
    """8 × 8 × 8 spheres of 10.00 to 10.02 mm on a lattice of 10 mm, in a box that leaves room to travel."""
    random = np.random.default_rng(1)
    place = (np.indices((8, 8, 8)).reshape(3, -1).T - 3.5) * 10e-3 + random.uniform(-3e-6, 3e-6, (512, 3))
    diameter = random.uniform(10.0e-3, 10.02e-3, 512)
    lines = ["spheres", "", "512 atoms", "1 atom types", ""]
    lines += ["-0.07 0.07 xlo xhi", "-0.06 0.06 ylo yhi", "-0.06 0.06 zlo zhi", "", "Atoms", ""]
    for i, (d, (x, y, z)) in enumerate(zip(diameter, place, strict=True), start=1):
        lines.append(f"{i} 1 {d:.17g} 2650 {x:.17g} {y:.17g} {z:.17g}")
    path.write_text("\n".join(lines) + "\n")


def simulate(folder, ranks=2, quick=False, unloading="hertz", rtol=1e-5):
    common.table(folder, "granite.tbl", law(unloading), rtol)
    for n in sorted({1, max(ranks, 2)}):
        run(folder / "in.migration", n, {"px": n}, log=f"log.{n}")
    write_block(folder / "block.data")
    for px, py in ((1, 1), (2, 1), (2, 2)):
        run(folder / "in.block", px * py, {"px": px, "py": py}, log=f"block.{px}x{py}")


if __name__ == "__main__":
    common.run_main(__file__, simulate, __doc__)
