"""Force and energies of either wall against the Python law, and the force of one wall against the other."""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent))
import common

from demlaws.lammps import read_log


def check(folder, unloading="hertz", limit=1e-5):
    law = common.load(Path(__file__).parent / "run.py").law(unloading)
    findings, logs = [], {}
    for wall in ("plane", "region"):
        log = logs[wall] = read_log(Path(folder) / f"log.{wall}")
        path = law.follow(log["overlap"])
        error = np.abs(log["force"] - path.force).max() / path.force.max()
        findings.append((f"{wall} wall: force against the law, of the maximum", error, limit))
        for name, expected in (("stored", path.stored), ("lost", path.dissipated)):
            error = np.abs(log[name] - expected).max() / path.work.max()
            findings.append((f"{wall} wall: energy {name} against the law, of the largest work", error, limit))
    force = [logs[wall]["force"] for wall in ("plane", "region")]
    findings.append(("region against plane, of the maximum", np.abs(force[0] - force[1]).max() / force[0].max(), 1e-9))
    return findings


if __name__ == "__main__":
    common.check_main(__file__, check)
