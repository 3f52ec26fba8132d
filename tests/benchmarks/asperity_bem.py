"""The asperity model beside an elastic boundary-element solution of the same maps: loads over separations.

    pip install ContactMechanics SurfaceTopography && python tests/benchmarks/asperity_bem.py tests/data/asperity_bem.csv

Writes one row for each map and overlap: the boundary-element load and contact area, the model's, and the model's overlap at
that load with its interaction estimate. Takes about five minutes on one core; tests read the stored file.
"""

import sys

import numpy as np
from ContactMechanics import make_system

import demlaws as dl
from demlaws.files import write_atomically
from demlaws.solvers.patches import RoughContact
from demlaws.surface import self_affine

PIXELS, PIXEL, MODULUS = 256, 0.5e-6, 50e9


def cases():
    """Name, map, radius [m] (inf: flat, periodic)."""
    for name, roughness, hurst, radius in (
        ("smooth ball", 1e-15, 0.8, 3.175e-3),
        ("ball, fine", 0.1e-6, 0.8, 3.175e-3),
        ("ball, rough", 0.5e-6, 0.8, 3.175e-3),
        ("flat, H = 0.8", 0.5e-6, 0.8, np.inf),
        ("flat, H = 0.5", 0.5e-6, 0.5, np.inf),
    ):
        yield name, self_affine(PIXELS, PIXEL, hurst, roughness, 7, shortest=4e-6, longest=40e-6, periodic=True), radius


def main(path):
    from SurfaceTopography import Topography

    rows = ["case,overlap,bem_force,bem_area,model_force,model_area,patches,interaction"]
    for name, heights, radius in cases():
        flat = radius == np.inf
        pair = dl.Contact(radius=1.0 if flat else radius, modulus=MODULUS, roughness=heights.sq)
        model = RoughContact(heights, pair, flat=flat)
        size = (PIXELS * PIXEL,) * 2
        topography = Topography(model.gap.T.copy(), physical_sizes=size, periodic=flat)
        system = make_system(substrate="periodic" if flat else "free", surface=topography, young=MODULUS)
        top = model.gap.max()
        largest = 3.0 * heights.sq if flat else 2.5 * heights.sq + 0.15e-6
        for overlap in np.geomspace(0.03 * largest, largest, 12):
            for _ in range(8):
                solution = system.minimize_proxy(offset=overlap - top, pentol=1e-4 * overlap, maxiter=400)
                if solution.success:
                    break
                overlap *= 1.007  # their iteration now and then stops early; a neighbouring overlap does as well
            else:
                continue
            pressed = np.abs(np.asarray(solution.jac))
            force, area = float(pressed.sum()), float((pressed > 0).sum()) * PIXEL**2
            step = model.at(overlap)
            rows.append(
                f"{name.replace(',', ';')},{overlap:.6e},{force:.6e},{area:.6e},{step.load:.6e},{step.contact_area:.6e},"
                f"{len(step.micro)},{step.interaction:.6e}"
            )
            print(rows[-1], flush=True)
    write_atomically(path, "\n".join(rows) + "\n")


if __name__ == "__main__":
    main(sys.argv[1])
