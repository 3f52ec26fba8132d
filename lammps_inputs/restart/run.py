"""Two granite spheres, restart in mid-unloading in a new process; about 2 s.

python run.py
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent))
import common

from demlaws.lammps import run
from demlaws.make import example


def law(unloading="hertz"):
    return example("pohrt-popov", common.contact(8.76e-3, 8.63e-3), unloading)


def simulate(folder, ranks=1, quick=False, unloading="hertz", rtol=1e-5):
    common.table(folder, "granite.tbl", law(unloading), rtol)
    run(folder / "in.first", ranks, log="log.first")
    run(folder / "in.second", ranks, log="log.second")


if __name__ == "__main__":
    common.run_main(__file__, simulate, __doc__)
