"""The reference of moving contacts itself: what it must give whatever engines do."""

import moving_contact as reference
import numpy as np
import pytest

import demlaws as dl

RADIUS, OVERLAP = 5e-4, 1e-5
FIRST = {
    "sphere": reference.sphere(5e-3),
    "plane": reference.plane((0, 0, 1)),
    "triangle": reference.triangle([(-1, -1, 0), (1, -1, 0), (0, 1, 0)]),
}


def law(rule="elastic"):
    return dl.law("hertz" if rule == "elastic" else "rms", dl.Contact(RADIUS, 2.7e8, 2e-9), rule)


def test_straight_paths_agree_with_the_shear_of_demlaws():
    """Loading, unloading and shear in two directions on a plane, with memory of three levels and Coulomb's limit."""
    path = [
        reference.Leg(),
        reference.Leg(shift=(0.2, 0.1), overlap=1.3),
        reference.Leg(shift=(-0.1, 0.2), overlap=0.5),
        reference.Leg(shift=(2.0, 0.0), overlap=0.9),
        reference.Leg(shift=(-0.3, -0.2), overlap=0.2),
    ]
    moved = reference.motion(FIRST["plane"], RADIUS, OVERLAP, 40, path=path)
    forces = reference.follow(FIRST["plane"], RADIUS, moved, law("hertz"), ratio=0.8, friction=0.4)
    shift = np.cumsum(moved.velocity[:, 1, :2] - moved.velocity[:, 0, :2], axis=0) * moved.timestep
    expected = dl.driver.sheared(law("hertz"), forces.overlap, shift, 0.8, friction=0.4)
    assert np.abs(forces.force[:, 0, :2] - expected.shear_force).max() <= 1e-9 * np.abs(expected.force).max()
    assert np.abs(expected.shear_force).max() > 0.0


@pytest.mark.parametrize("name", ["sphere", "triangle"])
@pytest.mark.parametrize("turn", ["plane", "cross"])
def test_a_pair_that_turns_as_one_body_takes_its_forces_along(name, turn):
    angle = np.array([0.5, 2.2, 1.9])
    first, steps = FIRST[name], 400
    path = [reference.Leg(), reference.Leg(shift=(0.15, 0.1)), reference.Leg(whole=angle)]
    moved = reference.motion(first, RADIUS, OVERLAP, steps, path=path)

    def turned(half_step):
        way = reference.Way(turn=turn, half_step=half_step)
        found = reference.follow(first, RADIUS, moved, law(), ratio=0.8, friction=0.5, way=way)
        before, after = found.force[2 * steps - 1, 1], found.force[3 * steps - 1, 1]
        return np.linalg.norm(after - reference.rotation(angle) @ before) / np.linalg.norm(before)

    assert turned(True) < 0.01 < 0.1 < turned(False)


def test_each_body_gets_the_reaction_of_the_other():
    for first in FIRST.values():
        found = reference.follow(first, RADIUS, reference.motion(first, RADIUS, OVERLAP), law(), ratio=0.8, friction=0.5)
        assert np.abs(found.force.sum(axis=1)).max() == 0.0 < np.abs(found.force).max()
