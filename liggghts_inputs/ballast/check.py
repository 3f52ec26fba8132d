"""The plate carries the load asked for; the bed settles with the cycles, ever less; losses never come back."""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent))
import common

from demlaws import plots
from demlaws.liggghts import read_log


def cycles(folder):
    """The log, its rows in the cycles, and at the end of every cycle settlement [m] and energy taken [J] since the start."""
    case = common.load(Path(__file__).parent / "run.py")
    log = read_log(Path(folder) / "log.liggghts")
    step = log["Step"] - case.SETTLE - case.PRESS
    ends = (step >= 0) & (step % case.PERIOD == 0)
    return log, step > 0, log["plate"][ends][0] - log["plate"][ends], log["lost"][ends] - log["lost"][ends][0]


def check(folder):
    log, cyclic, settlement, taken = cycles(folder)
    height = log["bed"][0]
    count = settlement.size - 1
    print(f"bed {height * 1e3:.0f} mm high under {log['load'][cyclic].min():.0f} to {log['load'].max():.0f} N")
    print(f"{'cycle':>6} {'settlement mm':>14} {'strain %':>9} {'flow, friction took J':>22}")
    for n in sorted({n for n in (1, 2, 3, 5, 10, 15, 20, count) if n <= count}):
        print(f"{n:6d} {settlement[n] * 1e3:14.4f} {settlement[n] / height * 100:9.4f} {taken[n]:22.5f}")
    error = np.abs(log["carried"] - log["load"])[cyclic] / log["load"].max()
    steps = np.diff(settlement)
    at_rest = log["KinEng"][0] / log["stored"].max()
    return [
        ("kinetic energy when the plate starts, of the most that contacts hold later", at_rest, 0.01),
        ("load carried against asked for, median, of the largest load", np.median(error), 0.02),
        # the worst row is a grain that slips and takes the load off the plate for an instant
        ("load carried against asked for, 95 of 100 rows, of the largest load", np.quantile(error, 0.95), 0.05),
        ("heave instead of settlement [mm]", max(0.0, -settlement[-1]) * 1e3, 0.0),
        ("settlement of the last cycle, of the first", steps[-1] / steps[0], 1.0),
        ("dissipation that went backwards", max(0.0, -np.diff(log["lost"]).min()) / log["lost"][-1], 1e-12),
    ]


def draw(folder, path):
    log, cyclic, settlement, _ = cycles(folder)
    figure, (left, right) = plots.figure(columns=2)
    left.plot((log["plate"][cyclic][0] - log["plate"][cyclic]) * 1e3, log["carried"][cyclic] / 1e3, linewidth=0.6)
    left.set(xlabel="way of the plate (mm)", ylabel="load carried (kN)")
    right.plot(np.arange(settlement.size), settlement * 1e3, "o-", markersize=3)
    right.set(xlabel="cycle", ylabel="permanent settlement (mm)")
    return plots.save(figure, path)


if __name__ == "__main__":
    common.check_main(__file__, check)
