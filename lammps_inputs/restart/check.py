"""Forces and energies of the restarted run against those of the run that went on, and against the Python law."""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent))
import common

from demlaws.lammps import read_log


def check(folder, unloading="hertz", limit=1e-5):
    first, second = (read_log(Path(folder) / f"log.{name}") for name in ("first", "second"))
    path = common.load(Path(__file__).parent / "run.py").law(unloading).follow(first["overlap"])
    scale, work = path.force.max(), path.work.max()
    same = np.isin(first["Step"], second["Step"])
    return [
        ("rows missing in the restarted run", float(second["Step"].size - same.sum()), 0),
        ("force, restarted against continued, of the maximum", np.abs(first["force"][same] - second["force"]).max() / scale, 0),
        ("stored energy, likewise", np.abs(first["stored"][same] - second["stored"]).max() / work, 0),
        ("taken by plastic flow, likewise", np.abs(first["lost"][same] - second["lost"]).max() / work, 0),
        ("force against the law, of the maximum", np.abs(first["force"] - path.force).max() / scale, limit),
        ("taken by plastic flow against the law", np.abs(first["lost"] - path.dissipated).max() / work, limit),
    ]


if __name__ == "__main__":
    common.check_main(__file__, check)
