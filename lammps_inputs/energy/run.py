"""Energy of a granite sphere that bounces on a plane and on a region's wall, through a restart; about 5 s.

python run.py [-np 2]
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent))
import common

from demlaws.lammps import run

SHARED = common.load(common.SHARED.parent / "energy" / "run.py")


def simulate(folder, ranks=1, quick=False, unloading="hertz", rtol=1e-8):
    common.table(folder, "granite.tbl", SHARED.law(unloading), rtol)
    for wall in ("plane", "region"):
        variables = {"wall": f"{wall}.inc", "name": wall, "ranks": ranks, "start": SHARED.START}
        variables |= {"first": SHARED.FIRST, "second": 66000, "every": 20}
        run(folder / "in.energy", ranks, variables, log=f"log.{wall}")
        run(folder / "in.again", ranks, variables, log=f"log.{wall}.again")


if __name__ == "__main__":
    common.run_main(__file__, simulate, __doc__)
