"""A granite sphere falls on another at several speeds: restitution from the law, and from viscous damping.

Shows: the coefficient of restitution that roughness and yield of the contact give, against speed, without damping or with that
of `en`; the energy balance; an elastic law bounces back at the speed it came with.
Start: demlaws yade run -x yade_scripts/impact.py [--quick] [--en 0.9] [--out FOLDER]
Takes: about 10 s (quick: 3 s). Saves impact.png.
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
RADIUS = 8.7e-3
SURFACE = dl.materials.granite.surface
LAWS = (
    ("pohrt-popov", "elastic", {}),
    ("pohrt-popov", "hertz", {}),
    ("rough-plastic", "hertz", {"yield_pressure": 1.66e9}),
    ("rough-plastic", "thornton", {"yield_pressure": 1.66e9}),
)


def bounce(name, unloading, options, speed, dt, damping):
    """Rebound speed, and energy balance relative to the impact energy."""
    O.reset()
    O.materials.append(yade.FrictMat(young=60.6e9, poisson=0.25, frictionAngle=0.5, density=2680, label="granite"))
    O.bodies.append(sphere((0, 0, 0), RADIUS, fixed=True, material="granite"))
    O.bodies.append(sphere((0, 0, 2 * RADIUS + 1e-9), RADIUS, material="granite"))
    ball = O.bodies[1].state
    ball.vel = (0, 0, -speed)
    functor = Law2_ScGeom_MindlinPhys_Demlaws(name, unloading, {"granite": SURFACE}, **options)
    O.engines = engines(functor, physics=yade.Ip2_FrictMat_FrictMat_MindlinPhys(**damping))
    O.dt = dt
    energy = 0.5 * ball.mass * speed**2
    while ball.vel[2] < 0 or O.interactions.countReal():
        O.run(400, True)
    lost = functor.totals().dissipated + functor.totals().viscous
    balance = (0.5 * ball.mass * ball.vel[2] ** 2 + lost) / energy - 1
    return ball.vel[2], balance


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="fewer speeds")
    parser.add_argument("--en", type=float, help="restitution of an elastic Hertz contact, for viscous damping (default: none)")
    parser.add_argument("--out", default=".", help="folder of the picture")
    arguments = parser.parse_args()
    damping = {} if arguments.en is None else {"en": arguments.en, "es": arguments.en}
    speeds = np.geomspace(0.01, 3.0, 3 if arguments.quick else 9)
    figure, axis = plt.subplots(figsize=(6, 4), constrained_layout=True)
    print(f"{'law':16}{'unloading':11}{'speed':>10}{'rebound/impact':>17}{'energy balance':>16}")
    for name, unloading, options in LAWS:
        ratios = []
        for speed in speeds:
            # a Hertz contact lasts 2.87 (m²/(R E*² v))^(1/5); roughness makes it longer
            mass, modulus = 2680 * 4 / 3 * np.pi * RADIUS**3, 60.6e9 / (1 - 0.25**2) / 2
            lasts = 2.87 * (mass**2 / (RADIUS / 2 * modulus**2 * speed)) ** 0.2
            rebound, balance = bounce(name, unloading, options, speed, lasts / 1000, damping)
            ratios.append(rebound / speed)
            print(f"{name:16}{unloading:11}{speed:6.3f} m/s{ratios[-1]:17.8f}{balance:16.1e}")
        axis.semilogx(speeds, ratios, "o-", ms=4, label=f"{name}, {unloading} unloading")
    axis.set(xlabel="impact speed (m/s)", ylabel="coefficient of restitution", ylim=(0, 1.05))
    axis.legend(fontsize=8)
    picture = Path(arguments.out) / "impact.png"
    picture.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(picture, dpi=120)
    print(f"picture: {picture}")


main()
