"""The Conical Damage Model: YADE's own (Law2_ScGeom_MindlinPhysCDM_HertzMindlinCDM) against law conical-damage in one scene."""

import numpy as np
from yade_scenes import POISSON, YOUNG, engine_list, fixed_pair, functor, interaction_loop, yade

import demlaws as dl

STRENGTH, ANGLE, RADIUS = 0.8e9, 1.2, 0.01
PATH = np.concatenate(
    [np.linspace(0, 8e-5, 60)[1:], np.linspace(8e-5, 4e-5, 40), np.linspace(4e-5, 1.6e-4, 60), np.linspace(1.6e-4, 1e-5, 60)]
)


def test_yades_own_and_ours_on_the_same_path(omega):
    """Loading beyond first yield, unloading, reloading beyond, unloading past the plastic overlap: to 1e-12 of the largest."""
    law = functor("conical-damage", None, strength=STRENGTH, angle=ANGLE)
    plain = yade.FrictMat(young=YOUNG, poisson=POISSON, density=2650, frictionAngle=0.5, label="granite")
    crushed = yade.FrictMatCDM(
        young=YOUNG, poisson=POISSON, density=2650, frictionAngle=0.5, sigmaMax=STRENGTH, alpha=ANGLE, c1=0.0, c2=0.0
    )
    for x, stone in ((0.0, plain), (0.1, crushed)):
        omega.bodies.append(fixed_pair(stone, 0.0, RADIUS, x))
    physics = [yade.Ip2_FrictMatCDM_FrictMatCDM_MindlinPhysCDM(), yade.Ip2_FrictMat_FrictMat_MindlinPhys()]
    omega.engines = engine_list(interaction_loop(yade.Law2_ScGeom_MindlinPhysCDM_HertzMindlinCDM(), law, physics=physics))
    omega.dt = 1e-9
    forces = []
    for overlap in PATH:
        for upper in (1, 3):
            omega.bodies[upper].state.pos = (0.1 * (upper > 1), 0, 2 * RADIUS - overlap)
        omega.step()
        forces.append([omega.forces.f(1)[2], omega.forces.f(3)[2]])
    ours, theirs = np.array(forces).T
    assert theirs.max() > 100.0 and np.any(theirs[-60:] == 0.0)
    assert np.max(np.abs(ours - theirs)) <= 1e-12 * theirs.max()
    contact = dl.Contact(RADIUS / 2, YOUNG / (1 - POISSON**2) / 2)
    overlap = 2 * RADIUS - (2 * RADIUS - PATH)  # as the scene has it
    alone = dl.law("conical-damage", contact, strength=STRENGTH, angle=ANGLE).follow(overlap).force
    assert np.max(np.abs(alone - theirs)) <= 1e-12 * theirs.max()
