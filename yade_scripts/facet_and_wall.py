"""A granite sphere on a facet, a wall and a box of steel: force against the law, two materials.

Shows: flats of another material and surface (granite on steel), that a sphere on a flat has its own radius as R (YADE's law has
2r/3 at a facet, r/2 at a wall or a box; flats="yade" keeps these), and that the force applied is the law's at every step.
Start: demlaws yade run -x yade_scripts/facet_and_wall.py [--quick] [--out FOLDER]
Takes: about 5 s. Saves facet_and_wall.png.
"""

import argparse
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import yade
from yade import utils

import demlaws as dl
from demlaws.yade import Law2_ScGeom_MindlinPhys_Demlaws, engines

O = yade.O  # noqa: E741
RADIUS = 0.01
SURFACES = {
    "granite": dl.materials.granite.surface,
    "steel": dl.Surface(roughness=0.4e-6, fractal_dimension=2.3, hardness=2.5e9),
}
FLATS = {
    "facet": lambda: utils.facet([(-1, -1, 0), (1, -1, 0), (0, 1, 0)], fixed=True, material="steel"),
    "wall": lambda: utils.wall(0, 2, sense=1, material="steel"),
    "box": lambda: utils.box((0, 0, -0.1), (1, 1, 0.1), fixed=True, material="steel"),
}


def drop(flat, steps):
    O.reset()
    O.materials.append(yade.FrictMat(young=60.6e9, poisson=0.25, frictionAngle=0.5, density=2680, label="granite"))
    O.materials.append(yade.FrictMat(young=210e9, poisson=0.3, frictionAngle=0.4, density=7800, label="steel"))
    O.bodies.append(FLATS[flat]())
    O.bodies.append(utils.sphere((0, 0, RADIUS), RADIUS, material="granite"))
    O.bodies[1].state.vel = yade.Vector3(0.2, 0, -0.5)
    functor = Law2_ScGeom_MindlinPhys_Demlaws("pohrt-popov", "hertz", SURFACES)
    O.engines = engines(functor)
    O.dt = 1.6e-4 / steps
    rows = []
    for _ in range(steps):
        O.step()
        if O.interactions.has(0, 1) and O.interactions[0, 1].isReal and O.interactions[0, 1].geom.penetrationDepth >= 0:
            contact = O.interactions[0, 1]
            state = functor.contacts([contact])
            rows.append((contact.geom.penetrationDepth, contact.phys.normalForce.norm(), contact.phys.shearForce.norm()))
            radius, modulus = state.radius[0], state.modulus[0]
    return np.array(rows).T, radius, modulus


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="fewer steps")
    parser.add_argument("--out", default=".", help="folder of the picture")
    arguments = parser.parse_args()
    pair = SURFACES["granite"].combined(SURFACES["steel"])
    figure, axis = plt.subplots(figsize=(6, 4), constrained_layout=True)
    print(f"granite on steel: combined roughness {1e6 * pair.roughness:.3f} µm, fractal dimension {pair.fractal_dimension:.3f}")
    print(f"{'flat':7}{'R / sphere radius':>19}{'E*':>12}{'largest F':>12}{'|F - F_law|/F_max':>20}{'steps':>7}")
    worst = 0.0
    for flat in FLATS:
        (overlap, force, shear), radius, modulus = drop(flat, 400 if arguments.quick else 2000)
        law = dl.law("pohrt-popov", dl.Contact(radius, modulus, pair.roughness, pair.fractal_dimension), "hertz")
        error = np.abs(law.follow(overlap).force - force).max() / force.max()
        worst = max(worst, error)
        print(f"{flat:7}{radius / RADIUS:19.4f}{modulus / 1e9:8.2f} GPa{force.max():10.1f} N{error:20.1e}{force.size:7d}")
        (line,) = axis.plot(1e6 * overlap, force, label=f"{flat}: normal")
        axis.plot(1e6 * overlap, shear, ":", color=line.get_color(), label=f"{flat}: shear")
    axis.set(xlabel="overlap (µm)", ylabel="force (N)")
    axis.legend(fontsize=8)
    picture = Path(arguments.out) / "facet_and_wall.png"
    picture.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(picture, dpi=120)
    print(f"picture: {picture}")
    if worst > 1e-14:
        raise SystemExit("the force in YADE is not the law's")


main()
