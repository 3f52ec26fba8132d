"""Shear with levels in the C++ header, which the plugins use, against Python."""

import subprocess
from pathlib import Path

import numpy as np
import pytest
from examples import GRANITE, shared

import demlaws as dl
from demlaws.make import example as example_law

pytestmark = pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")

HERE = Path(__file__).parent
RATIO, FRICTION = 0.857, 0.4
LAWS = [("hertz", "elastic"), ("pohrt-popov", "elastic"), ("pohrt-popov", "hertz"), ("rough-plastic", "hertz")]


@pytest.fixture(scope="module")
def program(tmp_path_factory):
    program = tmp_path_factory.mktemp("levels") / "levels"
    headers = Path(dl.__file__).parent / "cpp"
    subprocess.run(["g++", "-std=c++11", "-O2", "-I", str(headers), str(HERE / "levels.cpp"), "-o", str(program)], check=True)
    return program


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
    return path


@pytest.mark.parametrize("levels", shared(range(1, 9), lambda count: count < 5))
@pytest.mark.parametrize("kind", ["noise", "vibration"])
def test_levels_are_pythons(program, table, levels, kind):
    words = [str(v) for v in (program, table, FRICTION, RATIO, levels)]
    table = dl.Table.load(table)
    overlap, across = wandering(kind, 0.5 * float(table.overlap(100.0)))
    text = "\n".join(f"{a!r} {b!r} {c!r}" for a, (b, c) in zip(overlap.tolist(), across.tolist(), strict=True))
    out = subprocess.run(words, input=text, capture_output=True, text=True, check=True).stdout
    force, first, second, work, stored = np.array([line.split() for line in out.splitlines()], float).T
    path = dl.driver.sheared(table, overlap, across, RATIO, levels=levels, friction=FRICTION)
    limit = FRICTION * path.force.max()
    sticks = np.hypot(*path.shear_force.T) < 0.999 * FRICTION * path.force
    assert sticks.sum() > 100 and (~sticks).sum() > 100
    np.testing.assert_allclose(force, path.force, rtol=1e-10, atol=1e-10 * path.force.max())
    np.testing.assert_allclose(np.stack([first, second], -1), path.shear_force, rtol=0.0, atol=1e-9 * limit)
    np.testing.assert_allclose(stored, path.stored, rtol=0.0, atol=1e-9 * path.stored.max())
    assert np.all(work - stored > -1e-12 * np.abs(work).max())
