"""The servo follows the load; the bed settles with the cycles; plastic contacts dissipate, never the other way."""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent))
import common

from demlaws.liggghts import read_log


def check(folder):
    period = common.load(Path(__file__).parent / "run.py").PERIOD
    log = read_log(Path(folder) / "log.liggghts")
    cyclic = log["Step"] > 200000
    phase = ((log["Step"] - 200000) % period) == 0
    ends = log["plate"][cyclic & phase]
    settlement = (ends[0] - ends[-1]) * 1e3
    print(f"settlement between the first and the last of {ends.size} cycles: {settlement:.4f} mm")
    follow = np.abs(np.abs(log["carried"]) - log["load"])[cyclic]
    return [
        ("load carried against asked for, median, of the largest load", np.median(follow) / log["load"].max(), 0.1),
        ("heave instead of settlement [mm]", max(0.0, -settlement), 0.0),
        ("plastic dissipation that went backwards", max(0.0, -np.diff(log["lost"]).min()) / log["lost"][-1], 1e-12),
    ]


if __name__ == "__main__":
    common.check_main(__file__, check)
