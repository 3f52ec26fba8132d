"""Forces and energies on several ranks against those on one."""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent))
import common

from demlaws.lammps import read_log


def check(folder, unloading="hertz"):
    folder = Path(folder)
    forces = {p.suffix[1:]: np.loadtxt(p, skiprows=9) for p in sorted((folder / "post").glob("forces.*"))}
    one, log = forces.pop("1x1"), read_log(folder / "block.1x1")
    scale, work = np.abs(one[:, 2:5]).max(), np.abs(log["stored"]).max()
    findings = [
        ("block: a plastic overlap took nothing", float(unloading != "elastic" and not log["lost"][-1] > 1e-3 * work), 0)
    ]
    for grid, several in forces.items():
        error = np.abs(several[:, 2:5] - one[:, 2:5]).max() / scale
        findings.append((f"block on {grid} ranks against 1: force on each of {len(one)} spheres, of the largest", error, 1e-9))
        other = read_log(folder / f"block.{grid}")
        for name in ("stored", "lost"):
            error = np.abs(other[name] - log[name]).max() / work
            findings.append((f"block on {grid} ranks against 1: energy {name}, of the largest stored", error, 1e-9))
    return findings


if __name__ == "__main__":
    common.check_main(__file__, check)
