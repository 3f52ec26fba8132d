"""Energy of a granite sphere that bounces on a primitive and on a mesh wall, through a restart; about 5 s.

python run.py [-np 2]
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent))
import common

from demlaws.liggghts import run
from demlaws.make import example

START = -3.613e-5  # [m] along x; in its first contact the sphere passes x = 0, an edge of the mesh and the border of two ranks
FIRST = 600  # steps to the restart file: in the first contact, after x = 0


def law(unloading="hertz"):
    return example("pohrt-popov", common.contact(6.05e-3), unloading)


def simulate(folder, ranks=1, quick=False, unloading="hertz", rtol=1e-8):
    common.table(folder, "granite.tbl", law(unloading), rtol)
    for wall in ("primitive", "mesh"):
        variables = {
            "wall": f"{wall}.inc",
            "name": wall,
            "ranks": ranks,
            "start": START,
            "first": FIRST,
            "second": 66000,
            "every": 20,
        }
        run(folder / "in.energy", ranks, variables, log=f"log.{wall}")
        run(folder / "in.again", ranks, variables, log=f"log.{wall}.again")


if __name__ == "__main__":
    common.run_main(__file__, simulate, __doc__)
