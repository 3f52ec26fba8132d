"""The packing is at rest and the walls carry its weight."""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent))
import common

from demlaws.lammps import read_log


def check(folder):
    log = read_log(Path(folder) / "log.lammps")
    weight = log["weight"][-1]
    drop = weight * 1e-3  # energy of the packing falling by 1 mm
    return [
        ("walls against weight, relative difference", abs(log["held"][-1] / weight - 1), 1e-3),
        ("kinetic energy, of the packing's weight times 1 mm", log["KinEng"][-1] / drop, 1e-3),
        (
            "plastic dissipation that went backwards",
            max(0.0, -np.diff(log["lost"]).min()) / log["lost"][-1],
            1e-12,
        ),
    ]


if __name__ == "__main__":
    common.check_main(__file__, check)
