"""Head-on impact of two granite spheres of 16 mm, with and without viscous damping; about 3 s.

python run.py
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent))
import common

from demlaws.lammps import run
from demlaws.make import example

SPEED = 0.2
DT = 5e-9


def law(unloading="hertz"):
    return example("pohrt-popov", common.contact(8e-3, 8e-3), unloading)


def simulate(folder, ranks=1, quick=False, unloading="hertz", rtol=1e-9):
    common.table(folder, "granite.tbl", law(unloading), rtol)
    for restitution in (1.0, 0.5):
        variables = {"speed": SPEED, "restitution": restitution, "dt": DT, "steps": 24000, "gap": 0}
        run(folder / "in.impact", ranks, variables, log=f"log.{restitution:g}")


if __name__ == "__main__":
    common.run_main(__file__, simulate, __doc__)
