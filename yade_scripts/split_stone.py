"""Stones between two plates; one whose contact is above its strength is replaced by a clump of four smaller spheres inside it.

Shows: `law.contacts(strength=…)`, friction that falls with the pressure, and what a script does where a stone breaks:
demlaws has no model of breakage. The rest of the stone becomes fines, which are left out: mass and elastic energy that
go are printed. Contacts of the clump begin without history.
Start: demlaws yade run -x yade_scripts/split_stone.py [--quick] [--strength 0.6] [--out FOLDER]
Takes: about 5 s. Saves split_stone.png.
"""

import argparse
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import yade

import demlaws as dl
from demlaws.yade import Law2_ScGeom_MindlinPhys_Demlaws, engines

O = yade.O  # noqa: E741
RADIUS, SPEED = 0.02, 0.05
FRICTION = dl.PressureFriction(mu0=0.3, c1=0.4, c2=1e-9)
SHARE = 1.0 / (1.0 + 1.5**0.5)
"""Radius of four equal spheres in a sphere, over its radius."""


def scene(count):
    """Stones of slightly different size in a square on a plate, a plate above that moves down."""
    random = np.random.default_rng(3)
    for label, young, density in (("stone", 60.6e9, 2650), ("plate", 210e9, 7850)):
        O.materials.append(yade.FrictMat(young=young, poisson=0.25, frictionAngle=0.5, density=density, label=label))
    for n in range(count**2):
        radius = RADIUS * (1.0 - 0.01 * random.random())
        O.bodies.append(yade.utils.sphere((0.05 * (n % count), 0.05 * (n // count), radius), radius, material="stone"))
    O.bodies.append(yade.utils.wall(0.0, 2, sense=1, material="plate"))
    plate = O.bodies[O.bodies.append(yade.utils.wall(2.0 * RADIUS, 2, sense=-1, material="plate"))]
    plate.state.vel = (0, 0, -SPEED)
    surfaces = {"stone": dl.materials.granite, "plate": dl.Surface(roughness=0.4e-6, fractal_dimension=2.22)}
    friction = {"stone": FRICTION, ("stone", "plate"): FRICTION}
    law = Law2_ScGeom_MindlinPhys_Demlaws("pohrt-popov", "hertz", surfaces, friction=friction)
    O.engines = engines(law, newton=yade.NewtonIntegrator(damping=0.2, gravity=(0, 0, -9.81)))
    O.dt = 0.2 * yade.utils.PWaveTimeStep()
    return law, plate


def split(stone, random):
    """Replace a stone by a clump of four spheres, turned at random, that moves as it did; the mass [kg] that is left out."""
    corners = np.array([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)]) / 3**0.5
    turn, _ = np.linalg.qr(random.standard_normal((3, 3)))
    radius, state = stone.shape.radius, stone.state
    pieces = [
        yade.utils.sphere(state.pos + yade.Vector3(*(radius * (1.0 - SHARE) * corner)), SHARE * radius, material="stone")
        for corner in corners @ turn.T
    ]
    clump, _ = O.bodies.appendClumped(pieces)
    O.bodies[clump].state.vel, O.bodies[clump].state.angVel = state.vel, state.angVel
    gone = state.mass - O.bodies[clump].state.mass
    O.bodies.erase(stone.id)
    return gone


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="fewer stones")
    parser.add_argument("--strength", type=float, default=0.6, help="mean pressure of a contact that splits a stone, GPa")
    parser.add_argument("--out", default=".", help="folder of the picture")
    arguments = parser.parse_args()
    law, plate = scene(2 if arguments.quick else 4)
    random, whole, curve, splits, mass, energy = np.random.default_rng(5), O.bodies[0].state.mass, [], [], 0.0, 0.0
    while 2.0 * RADIUS - plate.state.pos[2] < 5e-4:
        O.run(50, True)
        contacts = law.contacts(strength=1e9 * arguments.strength)
        on_plate = contacts[contacts.body1 == plate.id] if len(contacts) else contacts
        curve.append((2.0 * RADIUS - plate.state.pos[2], float(np.sum(on_plate.force))))
        for number in {*contacts.body1[contacts.above], *contacts.body2[contacts.above]}:
            stone = O.bodies[int(number)]
            if not isinstance(stone.shape, yade.Sphere) or stone.isClumpMember:
                continue
            touching = contacts[(contacts.body1 == stone.id) | (contacts.body2 == stone.id)]
            energy += float(np.sum(touching.stored + touching.shear_stored))
            splits.append((*curve[-1], float(np.max(touching.mean_pressure))))
            mass += split(stone, random)
    down, force = np.array(curve).T
    print(f"{len(splits)} stones split at {1e-9 * min(s[2] for s in splits):.3g} to {1e-9 * max(s[2] for s in splits):.3g} GPa")
    print(f"left out: {mass / whole:.2f} of the mass of a stone, {energy:.3g} J that their contacts stored")
    print(f"totals: {law.totals()}")
    figure, axis = plt.subplots(constrained_layout=True)
    axis.plot(1e6 * down, force, lw=1.0, label="force on the upper plate")
    axis.plot(*(np.array(splits).T[:2] * [[1e6], [1.0]]), "rx", label="a stone is replaced")
    axis.set(xlabel="displacement of the plate (µm)", ylabel="force (N)")
    axis.legend()
    picture = Path(arguments.out) / "split_stone.png"
    picture.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(picture, dpi=120)
    print(f"picture: {picture}")


main()
