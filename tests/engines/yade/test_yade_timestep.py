"""Packings at the advised time step keep their energy in YADE, and explode beyond the exact limit."""

import itertools
import math

import numpy as np
import pytest
from yade_scenes import advance, engine_list, interaction_loop, yade

import demlaws as dl
from demlaws.advice.scene import Scene, stable_step
from demlaws.timestep import from_contacts

RADIUS, FORCE = 0.01, 500.0
GRANITE = dl.Material(young=60.6e9, poisson=0.25, density=2680.0)
HERTZ = dl.law("hertz", dl.Contact.between(GRANITE, GRANITE, radius1=RADIUS, radius2=RADIUS))
BASES = {"sc": [(0, 0, 0)], "fcc": [(0, 0, 0), (0.5, 0.5, 0), (0.5, 0, 0.5), (0, 0.5, 0.5)]}


def lattice(kind):
    """A periodic lattice of equal spheres with YADE's own Mindlin law and FORCE in each contact, moving a little."""
    yade.O.reset()
    edge = (2.0 * RADIUS - HERTZ.overlap(FORCE)) * (math.sqrt(2.0) if kind == "fcc" else 1.0)
    yade.O.materials.append(
        yade.FrictMat(young=GRANITE.young, poisson=GRANITE.poisson, density=GRANITE.density, frictionAngle=1.0)
    )
    yade.O.periodic = True
    yade.O.cell.setBox(4 * edge, 4 * edge, 4 * edge)
    random = np.random.default_rng(1)
    for corner, base in itertools.product(itertools.product(range(4), repeat=3), BASES[kind]):
        body = yade.utils.sphere(tuple(edge * (np.array(corner) + base)), RADIUS)
        body.state.vel = tuple(1e-4 * random.standard_normal(3))
        yade.O.bodies.append(body)
    yade.O.engines = engine_list(interaction_loop(yade.Law2_ScGeom_MindlinPhys_Mindlin()))
    yade.O.dt = 1e-9
    yade.O.run(2, True)
    return yade.O


def growth(omega, dt, steps):
    """Largest kinetic energy in a run of `steps` over that at its start."""
    start, largest = yade.utils.kineticEnergy(), 0.0
    omega.dt = dt
    for _ in range(steps // 20):
        advance(20)
        largest = max(largest, yade.utils.kineticEnergy())
        if not largest < 1e4 * start:  # grains that fly apart take long
            break
    return largest / start


@pytest.mark.parametrize("kind", BASES)
def test_energy_is_bounded_at_the_advised_step(omega, kind):
    scene = Scene(radii=(0.01, 0.03), materials=GRANITE, force=(1.0, FORCE), coordination=6.0)
    advised = stable_step(scene, lambda contact: dl.law("hertz", contact))
    exact = limits_of(lattice(kind))
    assert 0.4 * exact < advised < 0.9 * exact
    assert growth(lattice(kind), advised, 5_000) < 2.0
    assert growth(lattice(kind), 1.05 * exact, 2_000) > 1e3


def limits_of(omega):
    """Exact limit [s] of the contacts as they are; equal to the closed form of the lattice."""
    contacts = [contact for contact in omega.interactions if contact.isReal]
    found = from_contacts(
        [(contact.id1, contact.id2) for contact in contacts],
        [tuple(contact.geom.normal) for contact in contacts],
        [contact.phys.kn for contact in contacts],
        shear_stiffness=[contact.phys.ks for contact in contacts],
        masses=[body.state.mass for body in omega.bodies],
    )
    stiffness = 1.5 * FORCE / HERTZ.overlap(FORCE)
    mass = 4.0 / 3.0 * math.pi * RADIUS**3 * GRANITE.density
    number = 2.0 * len(contacts) / len(omega.bodies)
    assert found == pytest.approx(2.0 / math.sqrt(10.0 / 3.0 * number * 1.5 / 1.75 * stiffness / mass), rel=1e-3)
    return found
