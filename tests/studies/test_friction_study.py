"""The study of friction by pressure: pressures by Hertz's closed form, angles of known slopes, changes of pairs, the page."""

from pathlib import Path

import numpy as np
import pytest

import demlaws as dl
from studies.assembly.study import read
from studies.friction import beds, report, shear, slopes
from studies.friction.coefficients import PLANE, POISSON, SETS, YADE, YOUNG, Constant, mean_pressure, softer, words

PAGE = Path(dl.__file__).parents[1] / "docs/inside/shear.md"
MODULUS = YOUNG / (2 * (1 - POISSON**2))


def test_the_pressure_is_weighted_with_the_force():
    forces, radius = np.array([10.0, 100.0, 300.0]), 0.01
    each = np.cbrt(16 * forces * MODULUS**2 / (9 * np.pi**3 * radius**2))
    assert mean_pressure(forces, radius, MODULUS) == pytest.approx(np.sum(each * forces) / forces.sum(), rel=1e-9)


@pytest.mark.parametrize("name", SETS)
def test_softened_grains_have_the_coefficient_of_the_real_ones(name):
    """At equal forces."""
    forces, friction = ([20.0], [200.0]), SETS[name]
    real, soft = ([mean_pressure(np.array(f), 0.01, E) for f in forces] for E in (MODULUS, MODULUS / 100.0))
    np.testing.assert_allclose(softer(friction, 100.0).coefficient(soft), friction.coefficient(real), rtol=1e-9)


def test_the_example_is_that_of_yade_at_equal_stress():
    """A force F = stress R² of grains of YADE's modulus and of granite, with c2 as printed and as transferred."""
    printed, radius = dl.PressureFriction(0.25, 1.3, 1.26e-5), 0.01
    forces = [np.array([stress * radius**2]) for stress in (1e4, 1e5)]
    soft, hard = ([mean_pressure(force, radius, plane / 2.0) for force in forces] for plane in (YADE, PLANE))
    np.testing.assert_allclose(SETS["example"].coefficient(hard), printed.coefficient(soft), rtol=1e-9)


def test_words_of_lammps():
    assert words(Constant(0.4)) == ("", 0.4)
    assert words(dl.PressureFriction(0.3, 0.6, 4e-9)) == (" friction_pressure 0.6 4e-09", 0.3)


@pytest.mark.parametrize("degrees", [0.0, 20.0, 35.0])
def test_the_angle_of_a_slope_that_is_known(tmp_path, degrees):
    """Spheres in layers below a plane, others on the lower floor."""
    rise, rows = np.tan(np.radians(degrees)), []
    for x in np.arange(0.004, slopes.LENGTH, 0.008):
        for y in np.arange(0.004, slopes.WIDTH, 0.008):
            rows += [(0, 1, 0.004, x, y, z) for z in (0.1 + rise * (slopes.LENGTH - x) - 0.004, 0.05)]
    count = len(rows)
    rows += [(0, 1, 0.004, slopes.LENGTH + 0.1, 0.1, -slopes.DROP + 0.004)] * count
    np.savetxt(tmp_path / "places.txt", rows, header="\n" * 8)
    angle, left = slopes.slope(tmp_path / "places.txt")
    assert angle == pytest.approx(degrees, abs=0.3) and left == 0.5


@pytest.mark.parametrize("grains", ["spheres", "clumps"])
def test_grains_begin_apart_on_a_base(grains):
    rows = np.array(slopes.falling(grains, 1))
    base, loose = rows[rows[:, 1] == 2], rows[rows[:, 1] == 1]
    assert len(np.unique(loose[:, 0])) == slopes.COUNT and not set(base[:, 0]) & set(loose[:, 0])
    assert base[:, 6].max() + 0.02 <= 0.005 and np.all(loose[:, 6] > 0)
    assert loose[:, 4].min() > 0 and loose[:, 4].max() < slopes.LENGTH
    near = np.linalg.norm(loose[:, None, 4:] - loose[None, :, 4:], axis=-1)
    apart = loose[:, None, 0] != loose[None, :, 0]
    assert np.all((near > 0.5 * (loose[:, None, 2] + loose[None, :, 2]))[apart])


def test_the_page_shows_the_stored_runs_of_simple_shear():
    runs, page = shear.read(), PAGE.read_text()
    seeds = {seed for seed, _, _ in runs}
    assert len(runs) == len(seeds) * 9 and len(seeds) == 12
    for stress in shear.STRESSES:
        pairs = [(runs[seed, stress, "mean"][1], runs[seed, stress, "pressure"][1]) for seed in seeds]
        found = shear.effects()[stress, "mean"]
        assert found.mean == pytest.approx(np.exp(np.mean([np.log(b / a) for a, b in pairs])) - 1.0, rel=1e-12)
        mean = np.mean([after for _, after in pairs])
        change = f"{100 * found.mean:+.1f} % ({100 * found.low:+.1f} to {100 * found.high:+.1f})"
        shown = f"| {1e-3 * stress:.0f} | {mean:.3f} | {change} |"
        assert shown.replace("-", "−") in page


def test_the_page_shows_the_stored_runs_of_beds_and_slopes():
    page = PAGE.read_text()
    for rows, table in ((read(beds.RUNS), report.bed_table), (read(slopes.RUNS), report.slope_table)):
        assert {int(row["seed"]) for row in rows if row["friction"] == "mean"} >= {1, 2, 3, 4}
        for line in table(rows).splitlines():
            assert line in page
    first = report.bed_effects(read(beds.RUNS))["spheres", "s1_um"]
    pairs = np.array(report.pairs(read(beds.RUNS), "spheres", "s1_um", "mean"))
    assert first.mean == pytest.approx(np.exp(np.mean(np.log(pairs[1] / pairs[0]))) - 1.0, rel=1e-12)
