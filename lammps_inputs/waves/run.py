"""Longitudinal and transverse pulses in a column of rough glass beads at 10 and 100 kPa; about a minute (half with --quick).

python run.py [-np 2] [--figure waves.png]

The packings are at rest under the law (pohrt-popov, σ = 0.5 µm, spheres of 1 mm) without shear forces.
"""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent))
import common

import demlaws as dl
from demlaws.lammps import run

HERE = Path(__file__).parent
DIAMETER, DENSITY = 1e-3, 2500.0
PRESSURES = (10, 100)  # [kPa]
AXES = {"z": "z", "x": "xz"}  # polarisation of the wave → strain of its modulus
WIDTH, LAYER = 1e-2, 1e-3  # of the pulse and of the layers whose velocities are written [m]


def law():
    contact = dl.Contact(radius=DIAMETER / 4, modulus=70e9 / (2 * (1 - 0.2**2)), roughness=0.5e-6, fractal_dimension=2.2)
    return dl.law("pohrt-popov", contact)


def write_box(path, pressure):
    """Write the packing as a data file; returns the largest tangent stiffness of its contacts [N/m]."""
    size, *centres = 1e-12 * np.loadtxt(HERE / f"{pressure}kPa.txt")
    lines = ["packing", "", f"{len(centres)} atoms", "1 atom types", ""]
    lines += [f"0 {side:.17g} {axis}lo {axis}hi" for axis, side in zip("xyz", size, strict=True)]
    lines += ["", "Atoms", ""]
    lines += [f"{n} 1 {DIAMETER} {DENSITY} {x:.17g} {y:.17g} {z:.17g}" for n, (x, y, z) in enumerate(centres, start=1)]
    Path(path).write_text("\n".join(lines) + "\n")
    from scipy.spatial import cKDTree

    nearest = cKDTree(np.array(centres), boxsize=size).query(centres, 2)[0][:, 1].min()
    return float(law().stiffness(DIAMETER - nearest))


def simulate(folder, ranks=1, quick=False):
    mass = DENSITY * np.pi * DIAMETER**3 / 6
    for pressure in PRESSURES[1:] if quick else PRESSURES:
        here = folder / f"{pressure}kPa"
        common.copy_inputs(__file__, here)
        common.table(here, "glass.tbl", law(), 1e-7)
        frequency = (write_box(here / "box.data", pressure) / mass) ** 0.5
        values = {"dt": 0.2 / frequency, "drag": 0.1 * mass * frequency, "turn": 0.01 * mass * frequency * DIAMETER**2}
        for axis, strain in AXES.items():
            run(here / "in.moduli", ranks, {**values, "axis": strain}, log=f"log.{strain}")
            steps = 570 if axis == "z" else 850
            wave = {"dt": values["dt"], "axis": axis, "boxes": 16, "width": WIDTH, "layer": LAYER, "steps": steps}
            run(here / "in.waves", ranks, wave, log=f"log.wave.{axis}")
        np.savetxt(here / "post" / "dt.txt", [values["dt"]])


if __name__ == "__main__":
    common.run_main(__file__, simulate, __doc__)
