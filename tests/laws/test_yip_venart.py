"""Yip & Venart as a law: seat, published numbers, its curve against the solver, contacts that differ."""

import numpy as np
import pytest
from examples import GRANITE, quiet

import demlaws as dl
from demlaws.solvers.axisymmetric import solve


def solved(contact, force):
    number = contact.hardness / contact.modulus * np.sqrt(8 * contact.radius / contact.roughness)
    unit = contact.modulus * np.sqrt(contact.radius) * contact.roughness**1.5
    points = solve("yip-venart", number, np.atleast_1d(force) / unit)
    return points.approach * contact.roughness, points.stiffness * unit / contact.roughness


def test_force_and_stiffness_are_those_of_the_solver():
    """The law reads a curve; solved afresh at loads between its nodes. The issue asks for 1e-4."""
    law = dl.law("yip-venart", GRANITE)
    force = np.geomspace(0.03, 90.0, 12)
    approach, stiffness = solved(GRANITE, np.append(0.02, force))
    overlap = approach[1:] - approach[0] + quiet(law.overlap, 0.02)
    np.testing.assert_allclose(quiet(law.force, overlap), force, rtol=5e-6)
    np.testing.assert_allclose(quiet(law.stiffness, overlap), stiffness[1:], rtol=2e-5)


@pytest.mark.parametrize("share", [1e-4, 0.0025, 0.025])
def test_overlap_counts_from_the_end_of_the_continued_curve(share):
    law = dl.law("yip-venart", GRANITE, seating_share=share)
    seat = share * GRANITE.modulus * GRANITE.radius**0.5 * GRANITE.roughness**1.5
    approach, stiffness = solved(GRANITE, [seat, 10.0])
    assert law.overlap(10.0) == pytest.approx(approach[1] - approach[0] + 1.5 * seat / stiffness[0], rel=1e-6)


def test_bad_input():
    smooth = GRANITE.with_values(roughness=np.array([0.0, 1e-6]))
    for contact, options in (
        (GRANITE.with_values(hardness=None), {}),
        (GRANITE, {"seating_share": 0.0}),
        (GRANITE, {"seating_share": 2.0}),
        (smooth, {}),
    ):
        with pytest.raises(dl.DemlawsError):
            dl.law("yip-venart", contact, **options)
