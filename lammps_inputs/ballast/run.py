"""Cyclic load on a ballast-like bed of granite spheres; 4 minutes (4 cycles on a small bed with --quick, 30 s).

python run.py [-np 2] [--figure settlement.png]
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent))
import common

from demlaws.lammps import run

SHARED = common.load(common.SHARED.parent / "ballast" / "run.py")
PACKING = common.load(Path(__file__).parent.parent / "packing" / "run.py")


def simulate(folder, ranks=1, quick=False):
    common.table(folder, "granite.tbl", SHARED.law())
    variables, count = SHARED.variables(quick)
    PACKING.write_loose(folder / "loose.data", count, variables["half"], (0.015, 0.020, 0.025), (0.4, 0.4, 0.2))
    run(folder / "in.ballast", ranks, {**variables, "wide": 0.85 * variables["half"]}, echo=not quick)


if __name__ == "__main__":
    common.run_main(__file__, simulate, __doc__)
