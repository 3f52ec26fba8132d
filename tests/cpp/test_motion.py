"""Displacement of a step and turn of springs (demlaws_shear.h): second order in the step, lengths kept, no energy made."""

import subprocess

import moving_contact as reference
import numpy as np
import pytest
from programs import compiled

RADII, TIME = np.array([1.2, 0.7]), 2.0


@pytest.fixture(scope="module")
def program(tmp_path_factory):
    return compiled(tmp_path_factory.mktemp("motion"), "motion.cpp")


def steps_of(program, levels, *columns):
    """Forces, stored and lost energies of steps given by the columns of the program's lines."""
    rows = np.column_stack(columns)
    text = "\n".join(" ".join(map(repr, row)) for row in rows.tolist())
    out = subprocess.run([program, str(levels)], input=text, capture_output=True, text=True, check=True).stdout
    found = np.array([line.split() for line in out.splitlines()], float)
    return found[:, :3], found[:, 3], found[:, 4]


def place(time, depth):
    """First centre minus second one: an orbit whose distance changes by `depth`."""
    polar, around, distance = 0.9 + 0.6 * np.sin(2 * time), 1.3 * time, RADII.sum() - depth * (1.2 + np.sin(3 * time))
    across = np.sin(polar)
    return distance * np.array([across * np.cos(around), across * np.sin(around), np.cos(polar) + 0 * time])


def spins(time):
    """Those of both bodies."""
    first = [1.1 * np.cos(time), 0.7 + 0 * time, 0.4 - 0.9 * np.sin(2 * time)]
    return np.array([first, [-0.3 + 0 * time, 0.5 * np.sin(1.5 * time), 1.2 + 0 * time]])


def orbit(program, steps, depth):
    """Shear force at the end for K_t = 1: positions at full steps, velocities, spins and levers at half steps."""
    dt = TIME / steps
    full = np.arange(steps + 1) * dt
    places, middle = place(full, depth).T, full[1:] - 0.5 * dt
    distance = np.linalg.norm(places, axis=1)
    normal, velocity = places[1:] / distance[1:, None], np.diff(places, axis=0) / dt
    lever = RADII[:, None] - 0.5 * (RADII.sum() - 0.5 * (distance[1:] + distance[:-1]))
    turning = spins(middle)
    arms = np.einsum("bn,bkn->nk", lever, turning)
    ones = np.ones(steps)
    columns = normal, velocity, arms, turning.sum(axis=0).T, distance[1:], dt * ones, ones, np.inf * ones
    return steps_of(program, 3, *columns)[0][-1]


@pytest.mark.parametrize("depth", [0.0, 1e-3, 0.05], ids=["constant distance", "small overlap", "large overlap"])
def test_the_displacement_is_of_second_order(program, depth):
    exact = -reference.carried(lambda time: -place(time, depth), spins, RADII, TIME)
    errors = [np.linalg.norm(orbit(program, steps, depth) - exact) for steps in (800, 1600, 3200)]
    assert errors[2] < 1e-6
    assert [errors[0] / errors[1], errors[1] / errors[2]] == pytest.approx([4.0, 4.0], rel=0.02)


def test_ten_turns_about_the_normal_keep_the_force(program):
    """Sheared in the first step, then turned as one body with 2,000 steps a turn."""
    steps, dt = 20_001, 1.0
    normal, arms = np.tile([0.48, 0.6, 0.64], (steps, 1)), np.zeros((steps, 3))
    velocity, spin = np.zeros((steps, 3)), 2 * (2 * np.pi / 2000) * normal
    velocity[0], spin[0] = np.cross(normal[0], [1.0, 0.0, 0.0]), 0.0
    ones = np.ones(steps)
    force, _, _ = steps_of(program, 3, normal, velocity, arms, spin, ones, dt * ones, ones, np.inf * ones)
    length = np.linalg.norm(force[0])
    assert abs(np.linalg.norm(force[-1]) / length - 1.0) < 1e-12
    assert np.linalg.norm(force[-1] - force[0]) < 1e-4 * length


def wandering(random, count=3000):
    """Motion, K_t and limit of a contact: noise, with a limit that falls and rises with K_t or none."""
    place, distance, size = random.standard_normal(3), RADII.sum(), 1e-3
    place *= distance / np.linalg.norm(place)
    lines, stiffness = np.empty((count, 16)), 1.0
    limited, wild = random.random(2)
    for line in lines:
        old, place = place, place + 0.2 * size * random.standard_normal(3)
        distance = np.clip(np.linalg.norm(place), 0.98 * RADII.sum(), RADII.sum())
        place *= distance / np.linalg.norm(place)
        first, second = 0.3 * size * random.standard_normal((2, 3))
        stiffness = np.clip(stiffness * np.exp((0.05 if wild < 0.7 else 1.0) * random.standard_normal()), 0.01, 1.0)
        if random.random() < 0.002:
            stiffness = 0.0
        line[:3], line[3:6], line[9:12] = place / distance, place - old, first + second
        line[6:9] = (RADII - 0.5 * (RADII.sum() - distance)) @ [first, second]
        limit = 0.003 * stiffness * np.exp(random.standard_normal() * (wild > 0.3)) if limited < 0.7 else 1e300
        line[12:] = distance, 1.0, stiffness, limit
    return lines


@pytest.mark.parametrize("levels", [1, 2, 3, 5])
def test_no_step_returns_more_energy_than_it_had(program, levels):
    """Work done less what the contact stores more is the loss, which is not negative."""
    random = np.random.default_rng(levels)
    for _ in range(10):
        _, stored, lost = steps_of(program, levels, wandering(random))
        assert lost.min() >= -1e-13 * stored.max() and lost.sum() > 0.1 * stored.max()
