"""A rough elastic sphere as in the granite tests, by boundary elements: stiffness against load.

    pip install ContactMechanics SurfaceTopography && python tests/benchmarks/rough_sphere_bem.py studies/validation/bem.csv

Writes a row for each map and load: longest roughness wavelength, seed, force, tangent stiffness (by a second solution at an
overlap 1 % larger). Some ten minutes on one core; `make validation` reads the stored file.
"""

import sys

import numpy as np
from ContactMechanics import make_system
from SurfaceTopography import Topography

from demlaws.files import write_atomically
from demlaws.surface import self_affine

PIXELS, PIXEL, MODULUS, RADIUS, ROUGHNESS = 256, 3e-6, 32.32e9, 4.35e-3, 2.40e-6


def solve(system, offset, overlap):
    for _ in range(6):
        solution = system.minimize_proxy(offset=offset, pentol=5e-4 * overlap, maxiter=300)
        if solution.success:
            return float(np.abs(np.asarray(solution.jac)).sum())
        offset += 0.002 * overlap
    return float("nan")


def main(path):
    rows = ["longest,seed,force,stiffness"]
    x = PIXEL * (np.arange(PIXELS) - 0.5 * (PIXELS - 1))
    ball = -(x[:, None] ** 2 + x[None, :] ** 2) / (2.0 * RADIUS)
    for longest in (160e-6, 320e-6):
        for seed in range(1, 9):
            rough = self_affine(PIXELS, PIXEL, 0.8, ROUGHNESS, seed, shortest=6 * PIXEL, longest=longest)
            shape = ball + rough.heights
            topography = Topography(shape, physical_sizes=(PIXELS * PIXEL,) * 2, periodic=False)
            system = make_system(substrate="free", surface=topography, young=MODULUS)
            top = float(shape.max())
            for overlap in np.geomspace(2e-6, 16e-6, 7):
                low = solve(system, overlap - top, overlap)
                high = solve(system, 1.01 * overlap - top, overlap)
                rows.append(f"{longest:g},{seed},{0.5 * (low + high):.6e},{(high - low) / (0.01 * overlap):.6e}")
                print(rows[-1], flush=True)
    write_atomically(path, "\n".join(rows) + "\n")


if __name__ == "__main__":
    main(sys.argv[1])
