"""A granite sphere on a plane wall and on the same plane as a region; about 3 s.

python run.py
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent))
import common

from demlaws.lammps import run
from demlaws.make import example


def law(unloading="hertz"):
    return example("pohrt-popov", common.contact(6.05e-3), unloading)


def simulate(folder, ranks=1, quick=False, unloading="hertz", rtol=1e-5):
    common.table(folder, "granite.tbl", law(unloading), rtol)
    for wall in ("plane", "region"):
        run(folder / "in.walls", ranks, {"wall": wall, "every": 20 if quick else 4}, log=f"log.{wall}")


if __name__ == "__main__":
    common.run_main(__file__, simulate, __doc__)
