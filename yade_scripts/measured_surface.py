"""Equal granite spheres with a measured surface, compressed in a periodic cell; the same with smooth (Hertz) spheres.

Shows: a height map in a DEM run in three commands; roughness makes the packing softer at low pressure.
Start: demlaws yade run -x yade_scripts/measured_surface.py grain.tbl [--quick] [--out FOLDER], with a table from
       demlaws surface scan.csv --pixel 3um --out grain.asc
       demlaws surface contact grain.asc --radius 8mm 8mm --young 60.6e9 --poisson 0.25 \\
           --hardness 6.266e9 --table grain.tbl
The table holds for spheres of its own radius and material. Without a table a synthetic surface is used.
Takes: about half a minute (quick: 10 s). Saves measured_surface.png.
"""

import argparse
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import yade
from yade import pack

import demlaws as dl
from demlaws.surface import self_affine
from demlaws.yade import Law2_ScGeom_MindlinPhys_Demlaws, engines

O = yade.O  # noqa: E741
GRANITE = dl.Material(young=60.6e9, poisson=0.25, hardness=6.266e9)


def synthetic_table():
    heights = self_affine(512, 3e-6, 0.78, roughness=2.4e-6, seed=1, longest=200e-6)
    pair = dl.Contact.between(GRANITE, GRANITE, radius1=8e-3, radius2=8e-3, roughness1=heights.sq, roughness2=0)
    return dl.law("asperity", pair, unloading="hertz", surface=heights, poisson=0.25).tabulate(1e-5)


def shrink(rate, pressure, steps=200000):
    """Shrink the cell at `rate` [1/s] along each axis until the mean stress reaches `pressure` [Pa]; returns the stress."""
    O.cell.velGrad = yade.Matrix3(-rate, 0, 0, 0, -rate, 0, 0, 0, -rate)
    stress = 0.0
    for _ in range(steps // 50):
        for _ in range(50):
            O.step()  # O.run would wait for 40 ms before it looks whether it has ended
        stress = -np.trace(np.array(yade.utils.getStress())) / 3
        if stress > pressure:
            break
    return stress


def compress(law, surface, radius, count, pressures):
    """Mean stress [Pa], mean overlap over radius, contacts a sphere as the cell shrinks."""
    O.reset()
    O.periodic = True
    O.materials.append(yade.FrictMat(young=GRANITE.young, poisson=GRANITE.poisson, frictionAngle=0.3, density=2680, label="g"))
    side = 2 * radius * (count * np.pi / 6 / 0.3) ** (1 / 3)
    O.cell.setBox(side, side, side)
    spheres = pack.SpherePack()
    spheres.makeCloud((0, 0, 0), (side, side, side), rMean=radius, rRelFuzz=0, num=count, periodic=True, seed=3)
    spheres.toSimulation(material="g")
    # a packing with the law's table must not meet radii that are equal only to a rounding
    for body in O.bodies:
        body.shape.radius = radius
    functor = Law2_ScGeom_MindlinPhys_Demlaws(law, surfaces={"g": surface} if surface else None)
    O.engines = engines(functor, newton=yade.NewtonIntegrator(damping=0.3))
    O.dt = 0.2 * np.sqrt(O.bodies[0].state.mass / 2e7)
    rows = []
    # fast until the spheres touch, then let them come to rest and go on slowly
    shrink(5.0, 1e4)
    shrink(0.0, np.inf, 3000)
    for pressure in pressures:
        stress = shrink(0.2, pressure)
        real = [i for i in O.interactions if i.isReal and i.phys.normalForce.norm() > 0]
        overlap = np.mean([i.geom.penetrationDepth for i in real])
        force = np.mean([i.phys.normalForce.norm() for i in real])
        rows.append((stress, O.cell.volume, 2 * len(real) / count, overlap, force))
    return np.array(rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("table", nargs="?", help="table written by demlaws surface contact --table")
    parser.add_argument("--quick", action="store_true", help="fewer spheres and pressures")
    parser.add_argument("--out", default=".", help="folder of the picture")
    arguments = parser.parse_args()
    table = dl.Table.load(arguments.table) if arguments.table else synthetic_table()
    contact = table.contact
    radius = 2.0 * contact.radius  # equal spheres
    surface = dl.Surface(roughness=contact.sigma / 2**0.5, hardness=contact.hardness)
    pressures = np.geomspace(3e4, 3e6, 4 if arguments.quick else 9)
    count = 60 if arguments.quick else 200
    figure, axis = plt.subplots(figsize=(6, 4), constrained_layout=True)
    print(f"{'law':10}{'stress':>12}{'contacts':>10}{'mean force':>12}{'mean overlap':>14}{'law of mean':>13}")
    for name, law, rough in (("asperity", table, surface), ("hertz", "hertz", None)):
        rows = compress(law, rough, radius, count, pressures)
        single = table if name == "asperity" else dl.law("hertz", contact)
        for stress, _, coordination, overlap, force in rows:
            expected = single.overlap(float(force))
            print(
                f"{name:10}{stress / 1e3:9.1f} kPa{coordination:10.2f}{force:10.2f} N{overlap * 1e6:11.2f} µm"
                f"{expected * 1e6:10.2f} µm"
            )
        axis.loglog(rows[:, 3] * 1e6, rows[:, 0] / 1e3, "o-", label=name)
    axis.set(xlabel="mean overlap (µm)", ylabel="mean stress (kPa)", title=f"{count} spheres, isotropic compression")
    axis.legend()
    picture = Path(arguments.out) / "measured_surface.png"
    picture.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(picture, dpi=120)
    print(f"picture: {picture}")


main()
