"""10,000 polydisperse granite spheres settle under gravity; 3 minutes on 2 ranks (300 spheres with --quick, 20 s).

python run.py -np 2
"""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent))
import common

import demlaws as dl
from demlaws.lammps import run


def law(unloading="hertz"):
    return dl.law("pohrt-popov", common.contact(2e-3, 2e-3), unloading=unloading)


def write_loose(path, count, half, radii=(1.8e-3, 2.0e-3, 2.2e-3), shares=None, seed=7):
    """Spheres of three sizes on a shaken lattice above the floor, without an overlap; shares: of the sizes (default: alike)."""
    random = np.random.default_rng(seed)
    pitch = 2 * max(radii) + 0.2e-3
    across = int(2 * half / pitch)
    radius = random.choice(radii, count, p=shares)
    place = np.arange(count)
    centre = np.stack([place % across, place // across % across, place // across**2], 1).astype(float) + 0.5
    centre *= [2 * half / across, 2 * half / across, pitch]
    centre -= [half, half, 0]
    centre += random.uniform(-1, 1, centre.shape) * (0.5 * pitch - radius)[:, None]
    lines = ["loose", "", f"{count} atoms", "1 atom types", ""]
    top = centre[:, 2].max() + 5 * pitch
    lines += [
        f"{-half - 1e-3} {half + 1e-3} xlo xhi",
        f"{-half - 1e-3} {half + 1e-3} ylo yhi",
        f"-0.005 {top} zlo zhi",
        "",
        "Atoms",
        "",
    ]
    rows = enumerate(zip(radius, centre, strict=True), start=1)
    lines += [f"{i} 1 {2 * r:.17g} 2650 {x:.17g} {y:.17g} {z:.17g}" for i, (r, (x, y, z)) in rows]
    Path(path).write_text("\n".join(lines) + "\n")


def simulate(folder, ranks=1, quick=False):
    common.table(folder, "granite.tbl", law())
    half, count, settle = (0.0115, 300, 140000) if quick else (0.04, 10000, 120000)
    write_loose(folder / "loose.data", count, half)
    run(folder / "in.packing", ranks, {"half": half, "settle": settle}, echo=not quick)


if __name__ == "__main__":
    common.run_main(__file__, simulate, __doc__)
