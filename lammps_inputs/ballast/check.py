"""The plate carries the load asked for; the bed settles with the cycles, ever less: as in liggghts_inputs/ballast."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent))
import common

from demlaws.lammps import read_log

SHARED = common.load(common.SHARED.parent / "ballast" / "check.py")
SHARED.read_log = lambda path: read_log(path.with_name("log.lammps"))
check, draw = SHARED.check, SHARED.draw


if __name__ == "__main__":
    common.check_main(__file__, check)
