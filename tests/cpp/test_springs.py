"""Partial slip of the plugins (demlaws_slip.h) against its twin in Python."""

import platform
import subprocess

import numpy as np
import pytest
from examples import GRANITE
from programs import compiled

import demlaws as dl
from demlaws.shear import sheared

RATIO, FRICTION = 0.857, 0.4


@pytest.fixture(scope="module", params=["x86-64", "native"])
def program(tmp_path_factory, request):
    """For vectors of two and, where the processor has them, of four numbers."""
    machine = [f"-march={request.param}"] if platform.machine() == "x86_64" else []
    return compiled(tmp_path_factory.mktemp("springs"), "springs.cpp", "-lz", *machine)


CASES = [
    pytest.param("hertz", "elastic", 11, 3e-6, id="hertz"),
    pytest.param("pohrt-popov", "elastic", 11, 6e-7, id="pohrt-popov"),
    pytest.param("pohrt-popov", "hertz", 11, 6e-7, id="pohrt-popov, Hertz unloading"),
    pytest.param("pohrt-popov", "thornton", 2, 6e-7, id="2 springs"),
    pytest.param("pohrt-popov", "hertz", 22, 6e-7, id="22 springs"),
]


@pytest.mark.parametrize(("name", "rule", "springs", "reach"), CASES)
def test_row_of_springs(program, tmp_path, name, rule, springs, reach):
    """Growth, which lifts bounds, unloading, which divides springs, noise, reversed slip; force, energy, loss of a step."""
    table = dl.law(name, GRANITE, rule).tabulate(rtol=1e-7, max_force=100.0)
    table.save(tmp_path / "law.tbl")
    turn = np.linspace(0.0, 6.0, 601)
    overlap = 4e-6 * np.interp(turn, [0.0, 1.0, 1.4, 2.0, 3.0, 4.0, 5.0, 6.0], [0.03, 0.5, 0.45, 1.0, 0.2, 0.6, 0.599, 1.2])
    overlap[300:] *= 1.0 + 0.01 * np.random.default_rng(1).normal(size=301)
    displacement = reach * np.stack([np.sin(7.0 * turn), 0.5 * np.cos(4.0 * turn)], -1) * (overlap / 4e-6)[:, None]
    displacement[0] = 0.0
    lines = "\n".join(" ".join(map(repr, row)) for row in np.column_stack([overlap, displacement]).tolist())
    words = [str(program), str(tmp_path / "law.tbl"), str(springs), str(RATIO), str(FRICTION)]
    out = subprocess.run(words, input=lines, capture_output=True, text=True, check=True).stdout
    found = np.array([line.split() for line in out.splitlines()], float).T
    path = sheared(table, overlap, displacement.cumsum(0), RATIO, "slip", friction=FRICTION, springs=springs)
    pressed = path.force > 0.0
    share = np.hypot(*path.shear_force[pressed].T) / (FRICTION * path.force[pressed])
    assert share.max() > 0.999 and share.min() < 0.95
    for one, other in zip(found, [*path.shear_force.T, path.stored, np.diff(path.dissipated, prepend=0.0)], strict=True):
        np.testing.assert_allclose(one, other, rtol=0.0, atol=1e-12 * np.abs(other).max())
    assert found[3].min() >= -1e-13 * np.abs(found[2]).max()


def test_a_dashpot_stays_within_the_limit(tmp_path):
    """Of the share that sticks; with the springs at most Coulomb's limit, which it reaches where it is cut."""
    program = compiled(tmp_path, "dashpot.cpp")
    random, limit = np.random.default_rng(3), 2.0
    angle, size = random.uniform(0.0, 2.0 * np.pi, 500), limit * random.choice([0.0, 0.3, 0.9, 1.0], 500)
    force, stuck = np.stack([size * np.cos(angle), size * np.sin(angle)]), random.uniform(0.0, 1.0, 500)
    velocity, coefficient = random.normal(0.0, 1.0, (2, 500)), random.choice([0.0, 0.5, 5.0], 500)
    lines = "\n".join(
        " ".join(map(repr, row)) for row in np.stack([*force, stuck, coefficient, np.full(500, limit), *velocity], -1).tolist()
    )
    out = subprocess.run([str(program)], input=lines, capture_output=True, text=True, check=True).stdout
    viscous = np.array([line.split() for line in out.splitlines()], float).T
    whole = -coefficient * stuck * velocity
    share = np.sum(viscous * whole, 0) / np.maximum(np.sum(whole * whole, 0), 1e-300)
    assert np.allclose(viscous, share * whole, atol=1e-14) and np.all((share >= 0.0) & (share <= 1.0 + 1e-14))
    total, free = np.hypot(*(viscous - force)), np.hypot(*(whole - force))
    assert np.all(total <= limit * (1.0 + 1e-9))
    cut = free > limit * (1.0 + 1e-9)
    assert 100 < cut.sum() < 400 and np.allclose(total[cut], limit, rtol=1e-7)
    assert np.allclose(share[(free < limit) & (coefficient > 0.0)], 1.0)
