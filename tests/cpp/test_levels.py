"""The contact of example.cpp, normal force, shear with levels and energies, against Python."""

import subprocess

import numpy as np
import pytest
from examples import GRANITE, shared
from programs import HEADERS, compiled

import demlaws as dl
from demlaws.make import example_law

pytestmark = pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")

RATIO, FRICTION = 0.857, 0.4
LAWS = [("hertz", "elastic"), ("pohrt-popov", "elastic"), ("pohrt-popov", "hertz"), ("rough-plastic", "hertz")]


@pytest.fixture(scope="module")
def program(tmp_path_factory):
    return compiled(tmp_path_factory.mktemp("contact"), HEADERS / "example.cpp")


def columns(program, table, overlap, across, levels=3, damping=0.0):
    """What the program prints along a path of the table's own contact, as columns."""
    path, table = table
    contact = table.contact
    words = (program, path, contact.modulus, contact.radius, 0, RATIO, FRICTION, levels, damping)
    text = "\n".join(f"{a!r} {b!r} {c!r}" for a, (b, c) in zip(overlap.tolist(), across.tolist(), strict=True))
    out = subprocess.run([*map(str, words)], input=text, capture_output=True, text=True, check=True).stdout
    return np.array([line.split() for line in out.splitlines()], float).T


def wandering(kind, largest, points=4000, seed=3):
    """Overlaps and displacements in two directions: smooth noise, or a vibration by 2 % under a slow oblique motion."""
    random = np.random.default_rng(seed)
    if kind == "noise":
        overlap = largest * np.exp(np.clip(0.15 * random.standard_normal(points).cumsum(), -5.0, 0.0))
        across = 2e-2 * largest * random.standard_normal((points, 2)).cumsum(0)
    else:
        turn = np.linspace(0.0, 200.0 * np.pi, points)
        overlap = largest * np.clip(np.linspace(0.0, 4.0, points), 0.0, 0.9) * (1.0 + 0.02 * np.sin(turn))
        across = 0.3 * largest * np.stack([np.sin(0.03 * turn), np.cos(0.017 * turn)], -1)
    overlap[points // 2] = -0.1 * largest  # the contact parts once
    return overlap, across - across[0]


@pytest.fixture(scope="module", params=LAWS, ids=" ".join)
def table(request, tmp_path_factory):
    law, rule = request.param
    path = tmp_path_factory.mktemp("table") / "law.tbl"
    example_law(law, GRANITE, rule).tabulate(rtol=1e-6).save(path)
    return path, dl.Table.load(path)


@pytest.mark.parametrize("levels", shared(range(1, 9), lambda count: count < 5))
@pytest.mark.parametrize("kind", ["noise", "vibration"])
def test_forces_and_energies_are_pythons(program, table, levels, kind):
    overlap, across = wandering(kind, 0.5 * float(table[1].overlap(100.0)))
    force, _, _, _, stored, dissipated, first, second = columns(program, table, overlap, across, levels)
    path = dl.driver.sheared(table[1], overlap, across, RATIO, levels=levels, friction=FRICTION)
    normal = table[1].follow(overlap)
    limit = FRICTION * path.force.max()
    sticks = np.hypot(*path.shear_force.T) < 0.999 * FRICTION * path.force
    assert sticks.sum() > 100 and (~sticks).sum() > 100
    np.testing.assert_allclose(force, path.force, rtol=1e-10, atol=1e-10 * path.force.max())
    np.testing.assert_allclose(np.stack([first, second], -1), -path.shear_force, rtol=0.0, atol=1e-9 * limit)
    np.testing.assert_allclose(stored - normal.stored, path.stored, rtol=0.0, atol=1e-9 * stored.max())
    lost = path.work - path.stored
    assert lost[-1] > stored.max() / 10 and np.diff(lost).min() >= -1e-12 * stored.max()
    np.testing.assert_allclose(dissipated - normal.dissipated, lost, rtol=0.0, atol=1e-9 * lost[-1])
    assert dissipated.min() >= -1e-12 * stored.max()


def test_damping_takes_what_the_contact_does_not_return(program, table):
    """Work of the forces along a closed path, by the trapezoidal rule, against the energies."""
    overlap = 0.3 * float(table[1].overlap(100.0)) * np.sin(np.linspace(0.0, np.pi, 4001))[1:-1]
    across = np.zeros((len(overlap), 2))
    elastic, damped = (columns(program, table, overlap, across, damping=damping) for damping in (0.0, 0.05))
    pull = damped[0] - elastic[0]
    work = (0.5 * (pull[1:] + pull[:-1]) * np.diff(overlap)).sum()
    lost = damped[5, -1] - elastic[5, -1]
    assert lost > 0.0 and abs(work - lost) <= 0.01 * lost
