"""Peak force, rebound and energies of in.impact against the Python law integrated with the same scheme."""

import math
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent))
import common

from demlaws.liggghts import read_log

MASS = 2650 * 4 / 3 * math.pi * 8e-3**3
SQRT_5_6 = math.sqrt(5 / 6)


def reference(law, speed, restitution, dt, steps):
    """Velocity Verlet as LIGGGHTS does it (damping from the half-step velocity): peak force, rebound speed."""
    reduced = 0.5 * MASS
    beta = math.log(restitution) / math.sqrt(math.log(restitution) ** 2 + math.pi**2)
    overlap, velocity, peak = np.zeros(1), speed, 0.0
    state = law.new_state(1)
    force = 0.0
    for _ in range(steps):
        velocity -= 0.5 * dt * force / reduced
        overlap[0] += dt * velocity
        contact, stiffness = law.evaluate(overlap, state)
        force = contact[0] - 2.0 * SQRT_5_6 * beta * math.sqrt(stiffness[0] * reduced) * velocity if overlap[0] > 0 else 0.0
        velocity -= 0.5 * dt * force / reduced
        peak = max(peak, force)
        if overlap[0] <= 0:
            break
    return peak, -velocity


def check(folder, unloading="hertz"):
    case = common.load(Path(__file__).parent / "run.py")
    law = case.law(unloading)
    findings = []
    for restitution in (1.0, 0.5):
        log = read_log(Path(folder) / f"log.{restitution:g}")
        peak, rebound = reference(law, case.SPEED, restitution, case.DT, log["Step"].size)
        findings.append(
            (
                f"restitution {restitution:g}: peak force {peak:.4f} N, relative difference",
                abs(log["force"].max() / peak - 1),
                1e-6,
            )
        )
        findings.append(
            (
                f"restitution {restitution:g}: rebound speed {rebound:.6f} m/s, relative difference",
                abs(log["speed_no"][-1] / rebound - 1),
                1e-6,
            )
        )
        if restitution == 1:
            total = log["KinEng"] + log["stored"] + log["lost"]
            findings.append(("energy balance: drift of kinetic + stored + dissipated", np.ptp(total) / total[0], 1e-6))
            findings.append(("energy gained in the impact", max(0.0, log["KinEng"][-1] / log["KinEng"][0] - 1), 0))
    return findings


if __name__ == "__main__":
    common.check_main(__file__, check)
