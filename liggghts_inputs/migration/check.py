"""Forces on several ranks against those on one, and against the Python law."""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent))
import common

from demlaws.liggghts import read_log


def check(folder, unloading="hertz", limit=1e-5):
    logs = {path.suffix[1:]: read_log(path) for path in sorted(Path(folder).glob("log.[0-9]*"))}
    one = logs.pop("1")
    expected = common.load(Path(__file__).parent / "run.py").law(unloading).follow(one["overlap"]).force
    scale = expected.max()
    findings = [("force against the law, of the maximum", np.abs(one["force"] - expected).max() / scale, limit)]
    for n, log in logs.items():
        findings.append((f"{n} ranks against 1, of the maximum", np.abs(log["force"] - one["force"]).max() / scale, 1e-9))
    forces = {p.suffix[1:]: np.loadtxt(p, skiprows=9) for p in sorted((Path(folder) / "post").glob("forces.*"))}
    one = forces.pop("1x1")
    scale = np.abs(one[:, 2:5]).max()
    for grid, several in forces.items():
        error = np.abs(several[:, 2:5] - one[:, 2:5]).max() / scale
        findings.append((f"block on {grid} ranks against 1: force on each of {len(one)} spheres, of the largest", error, 1e-9))
    return findings


if __name__ == "__main__":
    common.check_main(__file__, check)
