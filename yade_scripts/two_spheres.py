"""Two spheres through the granite tests' paths inside YADE, against the single-contact driver.

Shows: the force that YADE applies is the law's, along the loading, unloading and reloading paths of the granite contact
tests (Altuhafi, Baudet & Coop 2023): SS(18-18), SS(12-18), and the cone tip RFC10, which yields.
Start: demlaws yade run -x yade_scripts/two_spheres.py [--quick] [--out FOLDER]
Takes: about 10 s (quick: 3 s). Saves two_spheres.png.
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
from demlaws import granite
from demlaws.yade import Law2_ScGeom_MindlinPhys_Demlaws, engines

O = yade.O  # noqa: E741
RUNS = (("SS(18-18)", "pohrt-popov"), ("SS(12-18)", "pohrt-popov"), ("SS(12-18)", "rms"), ("RFC10", "rough-plastic"))


def run(test, name, steps):
    """Overlap and force in YADE along the test's last stage; the law, and the driver's path."""
    law = granite.bind(name, test, "hertz")
    path = dl.driver.force_controlled(law, test.stages[-1], steps)
    O.reset()
    O.materials.append(
        yade.FrictMat(
            young=granite.GRANITE.young, poisson=granite.GRANITE.poisson, frictionAngle=0.5, density=2680, label="granite"
        )
    )
    radius = 2.0 * test.radius  # two like spheres of 2R have the effective radius R
    O.bodies.append([sphere((0, 0, z), radius, material="granite") for z in (0, 2 * radius)])
    for body in O.bodies:
        body.state.blockedDOFs = "xyzXYZ"
    surface = dl.Surface(test.sigma / 2**0.5, test.fractal_dimension, granite.GRANITE.hardness)
    functor = Law2_ScGeom_MindlinPhys_Demlaws(name, "hertz", {"granite": surface}, **law.options)
    O.engines = engines(functor)
    O.dt = 1e-9
    overlap, force = np.zeros(path.overlap.size), np.zeros(path.overlap.size)
    for n, wanted in enumerate(path.overlap):
        O.bodies[1].state.pos = yade.Vector3(0, 0, 2 * radius - wanted)
        O.step()
        if O.interactions.has(0, 1) and O.interactions[0, 1].isReal:
            contact = O.interactions[0, 1]
            overlap[n], force[n] = contact.geom.penetrationDepth, contact.phys.normalForce.norm()
    return law, path, overlap, force, functor.totals()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="fewer steps")
    parser.add_argument("--out", default=".", help="folder of the picture")
    arguments = parser.parse_args()
    figure, axes = plt.subplots(1, 3, figsize=(13, 4), constrained_layout=True)
    panels = dict(zip(("SS(18-18)", "SS(12-18)", "RFC10"), axes, strict=True))
    print("F in YADE against the law at YADE's own overlap, and the energies against the driver's, at the end of the path")
    print(f"{'test':11}{'law':16}{'steps':>7}{'largest F':>11}{'|F - F_law|/F_max':>19}{'dissipated':>13}{'driver':>13}")
    worst = 0.0
    for key, name in RUNS:
        test = granite.find_test(key)
        law, path, overlap, force, totals = run(test, name, 30 if arguments.quick else 200)
        expected = law.follow(overlap)
        error = np.abs(force - expected.force).max() / force.max()
        worst = max(worst, error)
        print(
            f"{key:11}{name:16}{force.size:7d}{force.max():9.1f} N{error:19.1e}{1e3 * totals.dissipated:10.4f} mJ"
            f"{1e3 * path.dissipated[-1]:10.4f} mJ"
        )
        axis = panels[key]
        axis.plot(1e6 * path.overlap, path.force, "-", color="0.6", lw=3)
        axis.plot(1e6 * overlap, force, "-", lw=1, label=f"{name} in YADE")
        axis.set(title=key, xlabel="overlap (µm)", ylabel="force (N)")
        axis.legend(fontsize=8)
    print(f"largest error: {worst:.1e} of the largest force (grey lines in the picture: the driver)")
    picture = Path(arguments.out) / "two_spheres.png"
    picture.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(picture, dpi=120)
    print(f"picture: {picture}")
    if worst > 1e-14:
        raise SystemExit("the force in YADE is not the law's")


main()
