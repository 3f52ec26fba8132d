"""Pohrt & Popov: published numbers, the threshold, and 50-digit references."""

import numpy as np
import pytest
from accuracy import contacts, measure, overlaps
from examples import GRANITE, GRANITE_TESTS, SMOOTH_GRANITE, quiet
from references import EPS, PohrtPopov, errors

import demlaws as dl
from demlaws.laws.pohrt_popov import stiffness_exponent
from demlaws.regime import transition_load

DIMENSIONS = (2.0, 2.075, 2.22, 2.4, 2.6, 2.8, 3.0)


@pytest.mark.parametrize("test", [*GRANITE_TESTS.values(), SMOOTH_GRANITE], ids=[*GRANITE_TESTS, "VS(18-18)"])
def test_threshold_force_of_the_granite_tests(test):
    """57.5 N for SS(18-18), not the 73 N of the paper's text. At F the stiffness joins Hertz's, and stays there."""
    law, hertz = dl.law("pohrt-popov", test.contact), dl.law("hertz", test.contact)
    (kink,) = law.kinks()
    assert quiet(law.force, kink) == pytest.approx(test.threshold, abs=0.005 if test is SMOOTH_GRANITE else 0.06)
    for factor, ratio in ((1.0, 1.0), (3.0, 1.0), (0.5, 0.5 ** (stiffness_exponent(test.contact.fractal_dimension) - 1 / 3))):
        force = factor * quiet(law.force, kink)
        stiffness = quiet(law.stiffness, quiet(law.overlap, force))
        assert stiffness / hertz.stiffness(hertz.overlap(force)) == pytest.approx(ratio, rel=1e-12)


def test_stiffness_exponents_of_the_paper():
    exponents = [stiffness_exponent(test.contact.fractal_dimension) for test in GRANITE_TESTS.values()]
    assert min(exponents) >= 0.557
    assert max(exponents) <= 0.598
    law = dl.law("pohrt-popov", GRANITE)
    k = law.stiffness(law.overlap(np.array([1.0, 10.0])))
    assert np.log10(k[1] / k[0]) == pytest.approx(stiffness_exponent(2.22), rel=1e-12)


@pytest.mark.parametrize("dimension", DIMENSIONS)
def test_errors_against_fifty_digits(dimension, rng):
    """Within 4 ε times the law's own condition number; measured 0.9."""
    contact = contacts(rng, 250, fractal_dimension=dimension)
    overlap = overlaps(rng, contact)
    references, measured = measure("pohrt-popov", contact, overlap)
    condition = np.array([float(r.condition(d)) for r, d in zip(references, overlap, strict=True)])
    for values in (measured.force, measured.stiffness, measured.energy):
        assert np.max(values / condition) <= 4.0
        assert np.mean(values / condition) <= 1.0
    # δ(P) has the condition number 1 + (1-m)|ln(P/F)|
    of_inverse = [1 + abs(np.log(float(d / r.overlap_at_threshold))) for r, d in zip(references, overlap, strict=True)]
    assert np.max(measured.overlap / of_inverse) <= 4.0


@pytest.mark.parametrize("dimension", [2.0, 2.22, 3.0])
def test_errors_next_to_the_threshold(dimension):
    contact = GRANITE.with_values(fractal_dimension=dimension)
    law = dl.law("pohrt-popov", contact)
    reference = PohrtPopov(contact.radius, contact.modulus, contact.roughness, dimension)
    (kink,) = law.kinks()
    assert kink == pytest.approx(float(reference.overlap_at_threshold), rel=8 * EPS)
    overlap = kink * (1 + np.array([-1e-3, -1e-9, -4 * EPS, 0.0, 4 * EPS, 1e-9, 1e-3]))
    for values, exact in ((quiet(law.force, overlap), reference.force), (quiet(law.stiffness, overlap), reference.stiffness)):
        assert errors(values, [exact(d) for d in overlap]).max() <= 4 / (1 - float(reference.m))


def test_warns_where_the_bulk_yields():
    """Where the regime criterion says so; without roughness that is Hertz's π³R²(0.6 H_m)³/(6E*²)."""
    smooth = np.pi**3 * GRANITE.radius**2 * (0.6 * GRANITE.hardness) ** 3 / (6 * GRANITE.modulus**2)
    assert transition_load(GRANITE.with_values(roughness=0.0)) == pytest.approx(smooth, rel=1e-12)
    law, yields = dl.law("pohrt-popov", GRANITE), transition_load(GRANITE)
    assert yields > smooth
    law.overlap(0.999 * yields)
    with pytest.warns(dl.ValidityWarning, match=r"0\.6 H_m"):
        law.overlap(1.001 * yields)
