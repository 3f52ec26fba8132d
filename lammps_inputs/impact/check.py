"""Peak force, rebound and energies of in.impact against the Python law integrated with the same scheme."""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent))
import common

from demlaws.lammps import read_log

SCHEME = common.load(common.SHARED.parent / "impact" / "check.py")


def check(folder, unloading="hertz"):
    case = common.load(Path(__file__).parent / "run.py")
    law = case.law(unloading)
    findings = []
    for restitution in (1.0, 0.5):
        log = read_log(Path(folder) / f"log.{restitution:g}")
        peak, rebound = SCHEME.reference(law, case.SPEED, restitution, case.DT, log["Step"].size)
        for name, value, expected in (
            ("peak force", log["force"].max(), peak),
            ("rebound speed", log["speed_now"][-1], rebound),
        ):
            what = f"restitution {restitution:g}: {name} {expected:.6g}, relative difference"
            findings.append((what, abs(value / expected - 1), 1e-6))
        if restitution == 1:
            total = log["KinEng"] + log["stored"] + log["lost"]
            findings.append(("energy balance: drift of kinetic + stored + dissipated", np.ptp(total) / total[0], 1e-6))
            findings.append(("energy gained in the impact", max(0.0, log["KinEng"][-1] / log["KinEng"][0] - 1), 0))
    return findings


if __name__ == "__main__":
    common.check_main(__file__, check)
