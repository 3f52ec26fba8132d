"""Cyclic load on a ballast-like bed of granite spheres; 4 minutes (4 cycles on a small bed with --quick, 15 s).

python run.py [--figure settlement.png]
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent))
import common

import demlaws as dl
from demlaws.liggghts import run

SETTLE, PRESS, PERIOD = 75000, 50000, 40000  # steps


def law():
    return dl.law("pohrt-popov", common.contact(15e-3, 15e-3, roughness=20e-6), unloading="hertz")


def variables(quick):
    """Box, load and steps of the input; number of grains."""
    size = {"half": 0.08, "height": 0.5} if quick else {"half": 0.15, "height": 0.6}
    load = {"mean": 500, "amplitude": 400, "gain": 6e-3} if quick else {"mean": 2000, "amplitude": 1600, "gain": 2.2e-3}
    steps = {"settle": SETTLE, "press": PRESS, "period": PERIOD, "cycles": (4 if quick else 25) * PERIOD}
    return {**size, **load, **steps}, 100 if quick else 500


def simulate(folder, ranks=1, quick=False):
    common.table(folder, "granite.tbl", law())
    given, count = variables(quick)
    # the plate is 52 mm wide in its file; it leaves the grains at the walls alone
    scale = 0.85 * given["half"] / 0.026
    run(folder / "in.ballast", ranks, {**given, "count": count, "scale": scale}, echo=not quick)


if __name__ == "__main__":
    common.run_main(__file__, simulate, __doc__)
