"""Energy balance of the bounces, and the same energies after a restart: as in liggghts_inputs/energy."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent))
import common

from demlaws.lammps import read_log

SHARED = common.load(common.SHARED.parent / "energy" / "check.py")
SHARED.read_log, SHARED.WALLS = read_log, ("plane", "region")
check = SHARED.check


if __name__ == "__main__":
    common.check_main(__file__, check)
