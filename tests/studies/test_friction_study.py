"""The study of friction by pressure: pressures by Hertz's closed form, changes of pairs, what the page shows."""

from pathlib import Path

import numpy as np
import pytest

import demlaws as dl
from studies.friction import __main__ as study


def test_the_pressure_is_weighted_with_the_force():
    radius, modulus = study.RADIUS / 2, 60.6e9 / study.SOFT / (2 * (1 - 0.25**2))
    forces = np.array([10.0, 100.0, 300.0])
    each = np.cbrt(16 * forces * modulus**2 / (9 * np.pi**3 * radius**2))
    assert study.pressure_of(forces) == pytest.approx(np.sum(each * forces) / forces.sum(), rel=1e-9)


def test_softened_grains_have_the_coefficient_of_the_real_ones():
    """At equal forces."""
    forces = np.array([20.0, 200.0])
    real = dl.law("hertz", dl.Contact(study.RADIUS / 2, 60.6e9 / (2 * (1 - 0.25**2))))
    pressure = forces / (np.pi * study.RADIUS / 2 * real.overlap(forces))
    soft = [study.pressure_of(np.array([force])) for force in forces]
    np.testing.assert_allclose(study.FRICTION.coefficient(soft), study.REAL.coefficient(pressure), rtol=1e-9)


def test_the_page_shows_the_stored_runs():
    runs, page = study.read(), (Path(dl.__file__).parents[1] / "docs/shear.md").read_text()
    seeds = {seed for seed, _, _ in runs}
    assert len(runs) == len(seeds) * 9 and len(seeds) == 12
    for stress in study.STRESSES:
        pairs = [(runs[seed, stress, "mean"][1], runs[seed, stress, "pressure"][1]) for seed in seeds]
        found = study.effects()[stress, "mean"]
        assert found.mean == pytest.approx(np.exp(np.mean([np.log(b / a) for a, b in pairs])) - 1.0, rel=1e-12)
        mean = np.mean([after for _, after in pairs])
        change = f"{100 * found.mean:+.1f} % ({100 * found.low:+.1f} to {100 * found.high:+.1f})"
        shown = f"| {1e-3 * stress:.0f} | {mean:.3f} | {change} |"
        assert shown.replace("-", "−") in page
