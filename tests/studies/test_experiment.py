"""The oedometer of glass beads: the values read from a curve, and the kept runs."""

import numpy as np
import pytest

from studies.experiment import oedometer
from studies.experiment.report import numbers


def power_curve(exponent, strain=0.02, high=52e6):
    """Loading to `high` and unloading on the same curve, with M ∝ σ^exponent."""
    stress = np.concatenate([np.linspace(6e6, high, 200), np.linspace(high, 20e6, 100)])
    return oedometer.Curve(strain * (stress / high) ** (1.0 - exponent), stress, 0.4 * stress, np.full(300, 0.39))


def test_the_measured_curve_has_its_cycles():
    curve = oedometer.measured()
    assert len(curve.turns) == 5 and curve.porosity[0] == pytest.approx(0.391059)
    strain, back, *_ = numbers(curve)
    assert strain == pytest.approx(1.691, abs=1e-3) and back == pytest.approx(0.604, abs=1e-3)


@pytest.mark.parametrize("exponent", [0.3, 0.55])
def test_the_exponent_of_a_power_law_is_found(exponent):
    curve = power_curve(exponent)
    assert curve.exponent() == pytest.approx(exponent, abs=0.01)
    assert curve.gained(0, 10e6, 50e6) == pytest.approx(curve.gained(1, 20e6, 50e6) + curve.gained(0, 10e6, 20e6), rel=1e-4)
