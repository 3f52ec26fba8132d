"""A small wave in a chain of granite beads under a constant force: its speed, and the exponent of the speed over the force.

Shows: the speed of sound of smooth beads (Hertz: F^(1/6)) and of rough ones (Pohrt-Popov at Df 2.22: F^0.285), against the
long-wave formula D √(K/m).
Start: demlaws yade run -x yade_scripts/chain.py [--quick]
Takes: about 10 s (quick: 4 s). Saves chain.png.
"""

import argparse
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import yade
from yade.utils import sphere

import demlaws as dl
from demlaws.yade import Law2_ScGeom_MindlinPhys_Demlaws, engines

O = yade.O  # noqa: E741
DIAMETER, DENSITY, BEADS, NEAR, FAR = 17.4e-3, 2650.0, 80, 20, 60
SURFACE = dl.materials.granite.surface


def strike(law, force, overlap, speed, dt, steps):
    """Time [s], velocities [m/s] of beads NEAR and FAR after the first bead is struck; the chain carries `force` [N]."""
    O.reset()
    O.materials.append(yade.FrictMat(young=60.6e9, poisson=0.25, frictionAngle=0.5, density=DENSITY, label="granite"))
    for n in range(BEADS):
        O.bodies.append(sphere((n * (DIAMETER - overlap), 0, 0), DIAMETER / 2, material="granite"))
    surfaces = {"granite": SURFACE if law != "hertz" else dl.Surface()}
    O.engines = engines(Law2_ScGeom_MindlinPhys_Demlaws(law, "elastic", surfaces))
    O.forces.setPermF(0, (force, 0, 0))
    O.forces.setPermF(BEADS - 1, (-force, 0, 0))
    O.bodies[0].state.vel = (speed, 0, 0)
    O.dt = dt
    near, far = O.bodies[NEAR].state, O.bodies[FAR].state
    rows = []
    for step in range(steps):
        rows.append((step * dt, near.vel[0], far.vel[0]))
        O.step()
    return np.array(rows).T


def arrival(time, velocity):
    """Time at which a velocity first has 0.663 of its first maximum, as a wave of the long-wave speed arrives."""
    begun = int(np.argmax(velocity > 0.5 * velocity.max()))
    top = begun + int(np.argmax(np.diff(velocity[begun:]) < 0))
    return float(np.interp(0.663 * velocity[top], velocity[begun - 1 : top + 1], time[begun - 1 : top + 1]))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="two forces in place of four")
    parser.add_argument("--out", default=".", help="folder of the picture")
    arguments = parser.parse_args()
    forces = (0.805, 8.05) if arguments.quick else (0.805, 2.0, 4.0, 8.05)
    figure, axis = plt.subplots(figsize=(6, 4), constrained_layout=True)
    mass = DENSITY * np.pi / 6 * DIAMETER**3
    print(f"{'law':14}{'force':>10}{'speed':>14}{'D √(K/m)':>14}")
    for name in ("hertz", "pohrt-popov"):
        speeds = []
        for force in forces:
            contact = dl.Contact(DIAMETER / 4, 0.5 * 60.6e9 / (1 - 0.25**2), 2**0.5 * 1.7e-6, 2.22, 6.266e9)
            law = dl.law(name, contact if name != "hertz" else contact.with_values(sigma=0.0))
            overlap = law.overlap(force)
            frequency = np.sqrt(law.stiffness(overlap) / mass)
            found = strike(name, force, overlap, 1e-3 * force / (frequency * mass), 0.04 / frequency, 1870)
            time, near, far = found
            speeds.append((FAR - NEAR) * (DIAMETER - overlap) / (arrival(time, far) - arrival(time, near)))
            print(f"{name:14}{force:8.3f} N{speeds[-1]:10.2f} m/s{(DIAMETER - overlap) * frequency:10.2f} m/s")
        slope = np.polyfit(np.log(forces), np.log(speeds), 1)[0]
        print(f"{name}: speed ∝ F^{slope:.4f}")
        axis.loglog(forces, speeds, "o-", label=f"{name}: speed ∝ F^{slope:.3f}")
    axis.set(xlabel="force in the chain (N)", ylabel="speed of a small wave (m/s)")
    axis.legend()
    picture = Path(arguments.out) / "chain.png"
    picture.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(picture, dpi=120)
    print(f"picture: {picture}")


if __name__ == "__main__":
    main()
