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
@pytest.mark.parametrize("turn", ["rotation", "frame"])
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


class OneSpring:
    """A spring of 1 N/m for `reference.follow`."""

    stretch = np.zeros(3)

    def touch(self, stiffness):
        pass

    def displace(self, turn, displacement):
        self.stretch = turn(self.stretch) + displacement
        return self.stretch


@pytest.mark.parametrize("lever", ["contact", "radius"])
@pytest.mark.parametrize("by_speed", [False, True])
def test_the_displacement_is_of_second_order(lever, by_speed):
    """An orbit whose distance changes, spinning, against an integration of the rates; of first order without the half step."""
    radii, time = np.array([1.2, 0.7]), 2.0

    def place(now):
        polar, around, distance = 0.9 + 0.6 * np.sin(2 * now), 1.3 * now, radii.sum() - 0.04 * (1.2 + np.sin(3 * now))
        return distance * np.array([np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around), np.cos(polar)])

    def spins(now):
        return np.array([[1.1 * np.cos(now), 0.7, 0.4 - 0.9 * np.sin(2 * now)], [-0.3, 0.5 * np.sin(1.5 * now), 1.2]])

    exact, law = reference.carried(place, spins, radii, time, lever), dl.law("hertz", dl.Contact(1.0, 1e9))

    def errors(**way):
        for steps in (200, 400, 800):
            dt = time / steps
            places = np.array([place(n * dt) for n in range(steps + 1)])
            velocity = np.stack([np.zeros((steps, 3)), np.diff(places, axis=0) / dt], axis=1)
            spin = np.array([spins((n - 0.5) * dt) for n in range(1, steps + 1)])
            moved = reference.Motion(np.array([np.zeros(3), places[0]]), velocity, spin, dt)
            springs, way = OneSpring(), {"lever": lever, "by_speed": by_speed, **way}
            options = {"ratio": 0.8, "friction": 1e9, "way": reference.Way(**way), "springs": springs}
            reference.follow(reference.sphere(radii[0]), radii[1], moved, law, **options)
            yield np.linalg.norm(springs.stretch - exact)

    found, former = np.array(list(errors())), np.array(list(errors(half_step=False)))
    assert found[:-1] / found[1:] == pytest.approx([4.0, 4.0], rel=0.05)
    assert former[:-1] / former[1:] == pytest.approx([2.0, 2.0], rel=0.1) and found[-1] < 0.02 * former[-1]


def test_each_body_gets_the_reaction_of_the_other():
    for first in FIRST.values():
        found = reference.follow(first, RADIUS, reference.motion(first, RADIUS, OVERLAP), law(), ratio=0.8, friction=0.5)
        assert np.abs(found.force.sum(axis=1)).max() == 0.0 < np.abs(found.force).max()
