"""Force, history and energies of in.two_spheres against the Python law."""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent))
import common

from demlaws.lammps import read_log


def check(folder, unloading="hertz", limit=1e-5):
    log = read_log(Path(folder) / "log.lammps")
    law = common.load(Path(__file__).parent / "run.py").law(unloading)
    path = law.follow(log["overlap"])
    findings = [("force against the law, of the maximum", np.abs(log["force"] - path.force).max() / path.force.max(), limit)]
    if unloading != "elastic":
        touching = log["overlap"] > 0
        scale = path.maximum_overlap.max()
        for column, expected in (("maximum", path.maximum_overlap), ("plastic", path.plastic_overlap)):
            difference = np.abs(log[column] - expected)[touching].max() / scale
            findings.append((f"history value {column} against the law, of the largest overlap", difference, limit))
    scale = path.work.max()
    findings.append(
        (
            "stored energy (compute demlaws/energy), of the largest work",
            np.abs(log["stored"] - path.stored).max() / scale,
            limit,
        )
    )
    findings.append(
        (
            "plastic dissipation (compute demlaws/energy), of the largest work",
            np.abs(log["lost"] - path.dissipated).max() / scale,
            limit,
        )
    )
    return findings


if __name__ == "__main__":
    common.check_main(__file__, check)
