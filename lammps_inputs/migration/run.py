"""A block of spheres that crosses the borders between 1, 2 and 4 ranks while it is squeezed and released; about 10 s.

python run.py -np 2
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent))
import common

from demlaws.lammps import run
from demlaws.make import example

BLOCK = common.load(common.SHARED.parent / "migration" / "run.py")


def law(unloading="hertz"):
    return example("pohrt-popov", common.contact(5e-3, 5e-3), unloading)


def simulate(folder, ranks=2, quick=False, unloading="hertz", rtol=1e-5):
    common.table(folder, "granite.tbl", law(unloading), rtol)
    BLOCK.write_block(folder / "block.data")
    for px, py in ((1, 1), (2, 1)) if quick else ((1, 1), (2, 1), (2, 2)):
        run(folder / "in.block", px * py, {"px": px, "py": py}, log=f"block.{px}x{py}")


if __name__ == "__main__":
    common.run_main(__file__, simulate, __doc__)
