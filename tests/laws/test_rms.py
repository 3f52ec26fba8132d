"""RMS: published numbers, limits and 50-digit references."""

import numpy as np
import pytest
from accuracy import check, contacts, measure, overlaps
from examples import GRANITE, quiet
from references import Rms, errors

import demlaws as dl


def test_limits_of_low_and_high_load():
    # hardness: no bulk yield to warn of; high is a load at which the overlap is many times the roughness, and within R
    for force, roughness, factor, within in ((1e-12, GRANITE.roughness, 5.76, 1e-6), (100.0, 1e-12, 1.0, 1e-6)):
        contact = GRANITE.with_values(hardness=None, roughness=roughness)
        law, hertz = dl.law("rms", contact), dl.law("hertz", contact)
        overlap = quiet(law.overlap, force)
        smooth = hertz.overlap(force)
        assert overlap / smooth == pytest.approx(factor, rel=within)
        assert hertz.stiffness(smooth) / quiet(law.stiffness, overlap) == pytest.approx(factor, rel=within)


def test_is_the_root_of_the_cubic():
    """u α³ + (4u - 5.76)α² + (4u - 9.6)α - 4 = 0."""
    law = dl.law("rms", GRANITE)
    for u in np.geomspace(1e-3, 1e3, 13):
        alpha = GRANITE.roughness_parameter(quiet(law.force, u * GRANITE.roughness))
        terms = np.array([u * alpha**3, (4 * u - 5.76) * alpha**2, (4 * u - 9.6) * alpha, -4.0])
        assert abs(terms.sum()) < 1e-13 * np.abs(terms).sum()


def test_errors_against_fifty_digits(rng):
    contact = contacts(rng, 1200)
    _, measured = measure("rms", contact, overlaps(rng, contact), energy=False)
    check(measured, 8.0, 1.0, ["overlap"])  # δ(P), the explicit direction; measured: 3.1, mean 0.9
    check(measured, 16.0, 1.3, ["force", "stiffness"])  # the root of the cubic; measured: 5.3, mean 1.2


def test_energy_against_a_quadrature_of_forty_digits():
    contact = GRANITE.with_values(roughness=1e-6 * GRANITE.roughness)  # a million times that is within R
    law = dl.law("rms", contact)
    reference = Rms(contact.radius, contact.modulus, contact.roughness)
    overlap = contact.roughness * np.array([1e-8, 1e-3, 0.1, 0.4, 0.5, 0.6, 1.0, 10.0, 1e3, 1e6])
    measured = errors(law.energy(overlap), [reference.energy(d) for d in overlap])
    assert measured.max() < 200.0, measured


def test_warns_where_the_fit_has_no_data():
    law = dl.law("rms", GRANITE)
    alpha_one = 4 / 3 * GRANITE.modulus * np.sqrt(GRANITE.radius) * GRANITE.roughness**1.5
    assert GRANITE.roughness_parameter(alpha_one) == pytest.approx(1.0)
    law.overlap(1.01 * alpha_one)  # inside: ValidityWarning is an error here
    with pytest.warns(dl.ValidityWarning, match="α > 1"):
        law.overlap(0.99 * alpha_one)
    with pytest.warns(dl.ValidityWarning, match="α > 5"):
        law.overlap(0.99 * alpha_one / 5**1.5)
