"""The packing is at rest and the walls carry its weight."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent))
import common

from demlaws.liggghts import read_log


def check(folder):
    log = read_log(Path(folder) / "log.liggghts")
    weight = log["weight"][-1]
    drop = weight * 1e-3  # energy of the packing falling by 1 mm
    return [
        # single rows swing by 1 to 2 %: spheres that roll on
        ("walls against weight, mean of the last rows, relative difference", abs(log["held"][-20:].mean() / weight - 1), 0.01),
        ("kinetic energy, of the packing's weight times 1 mm", log["KinEng"][-1] / drop, 1e-2),
        (
            "plastic dissipation that went backwards",
            max(0.0, -min(log["lost"][i + 1] - log["lost"][i] for i in range(len(log["lost"]) - 1))) / log["lost"][-1],
            1e-12,
        ),
    ]


if __name__ == "__main__":
    common.check_main(__file__, check)
