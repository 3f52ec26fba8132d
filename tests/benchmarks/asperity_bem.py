"""The asperity model beside an elastic boundary-element solution of the same maps: loads over separations.

    pip install ContactMechanics SurfaceTopography
    python tests/benchmarks/asperity_bem.py studies/validation/asperity_bem.csv

Writes one row for each map and overlap: the boundary-element load and contact area, the model's, and the model's overlap at
that load. Takes about five minutes on one core; tests read the stored file.
"""

import sys

import numpy as np
from ContactMechanics import make_system

from demlaws.files import write_atomically
from studies.validation.maps import MODULUS, PIXEL, PIXELS, cases
from studies.validation.maps import model as contact_of


def main(path):
    from SurfaceTopography import Topography

    rows = ["case,overlap,bem_force,bem_area,model_force,model_area,patches"]
    for name, heights, radius in cases():
        flat = radius == np.inf
        model = contact_of(heights, radius)
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
                f"{name},{overlap:.6e},{force:.6e},{area:.6e},{step.load:.6e},{step.contact_area:.6e},{len(step.micro)}"
            )
            print(rows[-1], flush=True)
    write_atomically(path, "\n".join(rows) + "\n")


if __name__ == "__main__":
    main(sys.argv[1])
