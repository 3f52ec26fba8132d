"""Hertz: published numbers and 50-digit references."""

import pytest
from accuracy import check, contacts, measure, overlaps
from examples import GRANITE

import demlaws as dl


def test_textbook_forms():
    law, force = dl.law("hertz", GRANITE), 10.0
    radius, modulus = GRANITE.radius, GRANITE.modulus
    contact_radius = (3 * force * radius / (4 * modulus)) ** (1 / 3)
    overlap = law.overlap(force)
    assert overlap == pytest.approx(contact_radius**2 / radius, rel=1e-14)
    assert law.stiffness(overlap) == pytest.approx(2 * modulus * contact_radius, rel=1e-14)
    assert law.stiffness(overlap) == pytest.approx((6 * force * radius * modulus**2) ** (1 / 3), rel=1e-14)
    assert GRANITE.roughness_parameter(force) == pytest.approx(GRANITE.roughness * radius / contact_radius**2, rel=1e-14)


def test_errors_against_fifty_digits(rng):
    contact = contacts(rng, 1500)
    _, measured = measure("hertz", contact, overlaps(rng, contact))
    check(measured, 8.0, 1.0)  # measured: largest 2.2, mean 0.5
