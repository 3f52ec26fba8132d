"""Boundary-element solutions of rough contacts, compared with the laws by `make validation`: bem.csv and asperity_bem.csv.

    pip install ContactMechanics SurfaceTopography
    python -m studies.validation.boundary_elements spheres      # bem.csv, about ten minutes on one core
    python -m studies.validation.boundary_elements maps         # asperity_bem.csv, some five minutes

spheres: rough elastic spheres as in the granite tests; longest roughness wavelength, seed, force and tangent stiffness (by a
second solution at an overlap 1 % larger). maps: the maps of `studies.validation.maps`; load and contact area, and those of
the asperity model at the same separation.
"""

import argparse
from pathlib import Path

import numpy as np
from ContactMechanics import make_system
from SurfaceTopography import Topography

from demlaws.files import write_atomically
from demlaws.surface import self_affine
from studies.validation import maps

HERE = Path(__file__).parent


def solve(system, offset, overlap, *, shift, tolerance, iterations):
    """Pressures at this offset; where the solver stops early, at offsets moved by shares `shift` of the overlap."""
    for attempt in range(8):
        moved = ((1.0 + shift) ** attempt - 1.0) * overlap
        solution = system.minimize_proxy(offset=offset + moved, pentol=tolerance * overlap, maxiter=iterations)
        if solution.success:
            return np.abs(np.asarray(solution.jac)), overlap + moved
    return None, overlap


def spheres():
    """Rows of bem.csv."""
    pixels, pixel, modulus, radius, roughness = 256, 3e-6, 32.32e9, 4.35e-3, 2.40e-6
    x = pixel * (np.arange(pixels) - 0.5 * (pixels - 1))
    ball = -(x[:, None] ** 2 + x[None, :] ** 2) / (2.0 * radius)
    yield "longest,seed,force,stiffness"
    for longest in (160e-6, 320e-6):
        for seed in range(1, 9):
            shape = (
                ball
                + self_affine(pixels, pixel, 0.8, roughness=roughness, seed=seed, shortest=6 * pixel, longest=longest).heights
            )
            topography = Topography(shape, physical_sizes=(pixels * pixel,) * 2, periodic=False)
            system, top = make_system(substrate="free", surface=topography, young=modulus), float(shape.max())
            for overlap in np.geomspace(2e-6, 16e-6, 7):
                pressed = [
                    solve(system, d - top, overlap, shift=0.002, tolerance=5e-4, iterations=300)[0]
                    for d in (overlap, 1.01 * overlap)
                ]
                low, high = (float(p.sum()) if p is not None else float("nan") for p in pressed)
                yield f"{longest:g},{seed},{0.5 * (low + high):.6e},{(high - low) / (0.01 * overlap):.6e}"


def rough_maps():
    """Rows of asperity_bem.csv."""
    yield "case,overlap,bem_force,bem_area,model_force,model_area,patches"
    for name, heights, radius in maps.cases():
        flat = radius == np.inf
        model = maps.model(heights, radius)
        topography = Topography(model.gap.T.copy(), physical_sizes=(maps.PIXELS * maps.PIXEL,) * 2, periodic=flat)
        system = make_system(substrate="periodic" if flat else "free", surface=topography, young=maps.MODULUS)
        top = model.gap.max()
        largest = 3.0 * heights.sq if flat else 2.5 * heights.sq + 0.15e-6
        for start in np.geomspace(0.03 * largest, largest, 12):
            pressed, overlap = solve(system, start - top, start, shift=0.007, tolerance=1e-4, iterations=400)
            if pressed is not None:
                force, area = float(pressed.sum()), float((pressed > 0).sum()) * maps.PIXEL**2
                step = model.at(overlap)
                figures = (overlap, force, area, step.force, step.contact_area)
                yield ",".join([name, *(f"{f:.6e}" for f in figures), str(len(step.micro))])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["spheres", "maps"])
    what = parser.parse_args().what
    lines = []
    for line in spheres() if what == "spheres" else rough_maps():
        print(line, flush=True)
        lines.append(line)
    write_atomically(HERE / ("bem.csv" if what == "spheres" else "asperity_bem.csv"), "\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
