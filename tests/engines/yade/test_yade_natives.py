"""The Conical Damage Model: YADE's own (Law2_ScGeom_MindlinPhysCDM_HertzMindlinCDM) against law conical-damage in one scene."""

import numpy as np
import pytest
from yade_scenes import POISSON, YOUNG, engine_list, fixed_pair, functor, interaction_loop, yade

import demlaws as dl

STRENGTH, ANGLE, RADIUS = 0.8e9, 1.2, 0.01
PATH = np.concatenate(
    [np.linspace(0, 8e-5, 60)[1:], np.linspace(8e-5, 4e-5, 40), np.linspace(4e-5, 1.6e-4, 60), np.linspace(1.6e-4, 1e-5, 60)]
)


@pytest.mark.parametrize("other", ["FrictMatCDM", "FrictMat", "wall"])
def test_a_script_whose_materials_have_no_labels(omega, other):
    """FrictMatCDM on itself, on FrictMat and on a wall, with another functor only: the forces are those of the native law."""

    def impact(make):
        omega.reset()
        shared = {"young": 1e10, "poisson": 0.2, "density": 3000, "frictionAngle": 0.1}
        plain = omega.materials.append(yade.FrictMat(**shared))
        crushed = omega.materials.append(yade.FrictMatCDM(**shared, sigmaMax=6e7, alpha=1.48, c1=0.0, c2=0.0))
        law, radius = make(), 0.1
        if other == "wall":
            omega.bodies.append(yade.utils.wall((0, 0, radius), axis=2, material=crushed))
        else:
            stone = plain if other == "FrictMat" else crushed
            omega.bodies.append(yade.utils.sphere((0, 0, 2 * radius), radius, fixed=True, material=stone))
        omega.bodies.append(yade.utils.sphere((0, 0, 0), radius, material=crushed))
        omega.bodies[1].state.vel = (0, 0, 0.05)
        physics = [
            yade.Ip2_FrictMatCDM_FrictMatCDM_MindlinPhysCDM(),
            yade.Ip2_FrictMat_FrictMatCDM_MindlinPhysCDM(),
            yade.Ip2_FrictMat_FrictMat_MindlinPhys(),
        ]
        geometries = [yade.Ig2_Sphere_Sphere_ScGeom(), yade.Ig2_Wall_Sphere_ScGeom()]
        omega.engines = engine_list(
            interaction_loop(law, geometries=geometries, physics=physics), bounds=[yade.Bo1_Wall_Aabb()]
        )
        omega.dt, forces = 2e-5, []
        for _ in range(300):
            omega.step()
            forces.append(sum(one.phys.normalForce.norm() for one in omega.interactions if one.isReal))
        return np.array(forces)

    theirs = impact(yade.Law2_ScGeom_MindlinPhysCDM_HertzMindlinCDM)
    ours = impact(lambda: functor("conical-damage", None, None, flats="yade"))
    assert theirs.max() > 100.0 and theirs[-1] == 0.0
    assert np.max(np.abs(ours - theirs)) <= 1e-9 * theirs.max()


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
