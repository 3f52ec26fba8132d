"""A granite sphere on a primitive wall and on a mesh wall, sliding across triangles; about 10 s.

python run.py
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent))
import common

from demlaws.liggghts import run
from demlaws.make import example


def law(unloading="hertz"):
    return example("pohrt-popov", common.contact(6.05e-3), unloading)


def simulate(folder, ranks=1, quick=False, unloading="hertz", rtol=1e-5):
    common.table(folder, "granite.tbl", law(unloading), rtol)
    for wall in ("primitive", "mesh"):
        variables = {"wall": f"{wall}.inc", "every": 100, "slide": 20000 if quick else 100000}
        run(folder / "in.walls", ranks, variables, log=f"log.{wall}")


if __name__ == "__main__":
    common.run_main(__file__, simulate, __doc__)
