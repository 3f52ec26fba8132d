"""Calibration with GrainLearning: the model of the contact test, its fit by `dl.fit`, and the error without the library."""

import numpy as np
import pytest

from studies.calibration import bayes


def test_the_contact_test_determines_both_quantities():
    found = bayes.fitted(bayes.contact_test())
    for name, truth, unit in zip(bayes.NAMES, bayes.TRUTH, bayes.UNITS, strict=True):
        assert found[name].low < truth * unit < found[name].high


def test_the_same_test_to_a_tenth_of_the_load_does_not(monkeypatch):
    """Below F the law has one number of σ and E* alone: no method can find both."""
    monkeypatch.setattr(bayes, "FORCES", np.geomspace(1.0, 50.0, 25))
    found = bayes.fitted(bayes.contact_test())
    assert "not separately identifiable" in found["modulus"].note


def test_grainlearning_finds_what_the_fit_finds():
    pytest.importorskip("grainlearning")
    posterior = bayes.calibrate(bayes.displacements, bayes.contact_test(), bayes.FORCES, samples=40, iterations=10)
    assert posterior.mean == pytest.approx(bayes.TRUTH, rel=0.03)
