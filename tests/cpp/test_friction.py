"""Friction that falls with the pressure: the headers of the plugins against Python along one path."""

import subprocess

import numpy as np
import pytest
from examples import GRANITE
from programs import compiled

import demlaws as dl
from demlaws.core.shear import SPRINGS
from demlaws.make import example_law
from demlaws.shear import _pressure_along

pytestmark = pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")

RATIO, FRICTION = 0.857, dl.PressureFriction(mu0=0.2, c1=0.5, c2=1e-9)
LAWS = [
    ("hertz", "elastic"),
    ("pohrt-popov", "elastic"),
    ("pohrt-popov", "hertz"),
    ("rough-plastic", "elastic"),
    ("rough-plastic", "hertz"),
    ("rough-plastic", "thornton"),
    ("conical-damage", "thornton"),
    ("kogut-etsion", "etsion"),
    ("jackson-green", "jackson"),
    ("walton-braun", "linear"),
    ("eepa", "eepa"),
    ("pohrt-popov", "table"),
]
NO_SPRINGS = ("linear", "eepa")  # no partial slip in the engines
ROUNDING = {("hertz", "elastic"): 1e-10, ("pohrt-popov", "elastic"): 1e-8, ("pohrt-popov", "table"): 1e-7}
"""Partial slip where the compression of a new spring, with 1e-5 of the force, is the small difference of two sums: a rounding
error of the overlaps changes the force of either twin by 1.4e-10 and 6e-8, in the other cases by 1e-14."""
CASES = [
    (*law, shear) for law in LAWS for shear in ("elastic", "loading", "slip") if shear != "slip" or law[1] not in NO_SPRINGS
]


@pytest.fixture(scope="module")
def program(tmp_path_factory):
    return compiled(tmp_path_factory.mktemp("friction"), "friction.cpp")


def path_of(largest, points=1500):
    """Pressed in turns up to `largest`, parted once, while the contact is sheared to and fro in two directions [m]."""
    turns = np.array([0.0, 0.3, 0.1, 0.6, 0.55, 1.0, 0.3, -0.1, 0.5, 0.2]) * largest
    overlap = np.interp(np.linspace(0.0, len(turns) - 1.0, points), np.arange(len(turns)), turns)
    angle = np.linspace(0.0, 20.0, points)
    return overlap, 0.6 * largest * np.stack([np.sin(angle), np.sin(0.7 * angle) ** 2], -1)


@pytest.mark.parametrize(("name", "rule", "shear"), CASES)
def test_pressure_limit_force_and_loss_are_pythons(program, tmp_path, name, rule, shear):
    curve = dl.law("hertz", GRANITE) if rule == "table" else rule
    example_law(name, GRANITE, curve).tabulate(rtol=1e-6).save(tmp_path / "law.tbl")
    table = dl.Table.load(tmp_path / "law.tbl")
    overlap, across = path_of(float(table.overlap(500.0)))
    steps = np.diff(across, axis=0, prepend=across[:1])
    text = "\n".join(f"{a!r} {b!r} {c!r}" for a, (b, c) in zip(overlap.tolist(), steps.tolist(), strict=True))
    words = (program, tmp_path / "law.tbl", shear, RATIO, FRICTION.mu0, FRICTION.c1, FRICTION.c2)
    out = subprocess.run([*map(str, words)], input=text, capture_output=True, text=True, check=True).stdout
    pressure, unkept, limit, *force, energy, lost = np.array([line.split() for line in out.splitlines()], float).T
    path = dl.driver.sheared(table, overlap, across, RATIO, shear, friction=FRICTION, springs=SPRINGS)
    np.testing.assert_allclose(unkept, pressure, rtol=1e-12)
    np.testing.assert_allclose(limit, FRICTION.coefficient(pressure) * path.force, rtol=1e-12, atol=1e-12 * limit.max())
    expected = _pressure_along(table, overlap)
    np.testing.assert_allclose(pressure, expected, rtol=1e-12, atol=1e-12 * pressure.max())
    largest = limit.max()
    assert np.ptp(limit[path.force > 0.1] / path.force[path.force > 0.1]) > 0.01
    rounding = ROUNDING.get((name, rule), 1e-12) if shear == "slip" else 1e-12
    np.testing.assert_allclose(np.stack(force, -1), path.shear_force, rtol=0.0, atol=rounding * largest)
    np.testing.assert_allclose(energy, path.stored, rtol=0.0, atol=rounding * path.stored.max())
    np.testing.assert_allclose(lost.cumsum(), path.dissipated, rtol=0.0, atol=rounding * path.dissipated[-1])
