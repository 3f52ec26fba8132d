"""Two granite spheres, load–unload–reload–separate–load; about 5 s.

python run.py
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent))
import common

from demlaws.liggghts import run
from demlaws.make import example


def law(unloading="hertz"):
    return example("pohrt-popov", common.contact(8.76e-3, 8.63e-3), unloading)


def simulate(folder, ranks=1, quick=False, unloading="hertz", rtol=1e-5):
    common.table(folder, "granite.tbl", law(unloading), rtol)
    return run(folder / "in.two_spheres", ranks, {"every": 100 if quick else 20})


if __name__ == "__main__":
    common.run_main(__file__, simulate, __doc__)
