"""10,000 polydisperse granite spheres settle under gravity; 3 minutes on 2 ranks (600 spheres with --quick, 10 s).

python run.py -np 2
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent))
import common

import demlaws as dl
from demlaws.liggghts import run


def law(unloading="hertz"):
    return dl.law("pohrt-popov", common.contact(2e-3, 2e-3), unloading=unloading)


def simulate(folder, ranks=1, quick=False):
    common.table(folder, "granite.tbl", law())
    if quick:
        variables = {"half": 0.015, "height": 0.14, "count": 600, "settle": 100000}
    else:
        variables = {"half": 0.04, "height": 0.19, "count": 10000, "settle": 120000}
    run(folder / "in.packing", ranks, variables, echo=not quick)


if __name__ == "__main__":
    common.run_main(__file__, simulate, __doc__)
