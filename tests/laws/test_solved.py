"""Laws whose curve a solver gives: the curve of a contact, what lies between two solved curves, and the solver itself."""

import math

import numpy as np
import pytest
from examples import GRANITE, quiet

import demlaws as dl
from demlaws.solvers.axisymmetric import solve

pytestmark = pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")
RADII = GRANITE.radius * np.array([0.5, 0.8, 1.0, 1.7])


@pytest.fixture(scope="module")
def family():
    """Yip & Venart's law of contacts that differ: curves at a sequence of their number."""
    return quiet(dl.law, "yip-venart", GRANITE.with_values(radius=RADII))


def test_one_contact_has_one_curve_and_several_have_a_family(family):
    one = dl.law("yip-venart", GRANITE)
    assert type(one.shape).__name__ == "ImplicitShape" and one.shape.table.grid.cells.shape[0] == one.shape.table.grid.count
    assert type(family.shape).__name__ == "FamilyShape" and family.shape.curves >= 2
    assert family.shape.grid.cells.shape == (family.shape.curves * family.shape.grid.count, 4)


def test_between_two_curves_the_family_is_the_solvers(family):
    """At equal overlap, to the family's tolerance, where the number of each contact lies between two that were solved."""
    overlap = np.full(RADII.size, 5e-6)
    force, stiffness = quiet(family.force, overlap), quiet(family.stiffness, overlap)
    for i, radius in enumerate(RADII):
        one = dl.law("yip-venart", GRANITE.with_values(radius=float(radius)))
        assert force[i] == pytest.approx(quiet(one.force, 5e-6), rel=3e-4)
        assert stiffness[i] == pytest.approx(quiet(one.stiffness, 5e-6), rel=3e-3)


def test_the_family_is_its_own_inverse_and_integral(family):
    overlap = np.array([1e-6, 5e-6, 1e-5, 2e-5])
    force = quiet(family.force, overlap)
    np.testing.assert_allclose(quiet(family.overlap, force), overlap, rtol=1e-9)
    step = 1e-4 * overlap
    difference = (family.energy(overlap + step) - family.energy(overlap - step)) / (2 * step)
    np.testing.assert_allclose(difference, force, rtol=1e-6)


@pytest.mark.parametrize("name", ["greenwood-tripp", "yip-venart"])
def test_below_the_seating_load_the_curve_is_continued(name):
    unit = GRANITE.modulus * GRANITE.radius**0.5 * GRANITE.roughness**1.5
    low, high = (dl.law(name, GRANITE, seating_share=share) for share in (1e-4, 0.1))
    for law, share in ((low, 1e-4), (high, 0.1)):
        seat = quiet(law.overlap, share * unit)
        below = seat * np.array([1e-6, 1e-3, 0.5, 1 - 1e-9])
        np.testing.assert_allclose(quiet(law.force, below), share * unit * (below / seat) ** 1.5, rtol=1e-4)
        assert quiet(law.stiffness, seat * (1 + 1e-9)) == pytest.approx(1.5 * share * unit / seat, rel=1e-2)
        assert min(limit.minimum_force for limit in law.limits() if limit.minimum_force) == pytest.approx(share * unit)
    # above both seats it is one curve, shifted
    ahead = quiet(low.overlap, 0.2 * unit) - quiet(high.overlap, 0.2 * unit)
    assert quiet(low.force, 8e-6 + ahead) == pytest.approx(quiet(high.force, 8e-6), rel=1e-5)


@pytest.mark.parametrize("name", ["greenwood-tripp", "yip-venart"])
def test_small_beads_are_never_stiffer_than_hertz(name):
    """Two glass spheres of 25 µm: the seating load was 0.02 N, so that 20 nm gave 0.0222 N, 45 times Hertz's force."""
    glass = dl.Material(70e9, 0.22, 5.5e9)
    pair = dl.Contact.between(glass, glass, radius1=25e-6, radius2=25e-6, roughness1=0.07e-6, roughness2=0.07e-6)
    law, hertz = dl.law(name, pair), dl.law("hertz", pair)
    overlap = np.append(np.geomspace(1e-13, 1e-6, 300), 20e-9)
    for quantity in ("force", "stiffness"):
        assert np.all(quiet(getattr(law, quantity), overlap) <= quiet(getattr(hertz, quantity), overlap))
    assert 0.0 < quiet(law.force, 20e-9) < 0.1 * quiet(hertz.force, 20e-9)
    assert quiet(law.force, 1e-300) < 1e-30


def solved(contact, force):
    number = contact.hardness / contact.modulus * np.sqrt(8 * contact.radius / contact.roughness)
    unit = contact.modulus * np.sqrt(contact.radius) * contact.roughness**1.5
    points = solve("yip-venart", number, np.atleast_1d(force) / unit)
    return points.approach * contact.roughness, points.stiffness * unit / contact.roughness


def test_yip_venart_is_that_of_the_solver():
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


def test_a_smooth_contact_among_rough_ones_is_refused():
    with pytest.raises(dl.DemlawsError):
        dl.law("yip-venart", GRANITE.with_values(roughness=np.array([0.0, 1e-6])))


@pytest.mark.parametrize("mu", [4.0, 17.0])
def test_greenwood_tripp_is_that_of_the_solver(mu):
    """The law reads a curve; solved afresh at loads between its nodes. The issue asks for 1e-4."""
    law = dl.law("greenwood-tripp", GRANITE, mu=mu)
    unit = GRANITE.modulus * math.sqrt(GRANITE.radius) * GRANITE.roughness**1.5
    force = np.geomspace(0.02, 1000.0, 14)
    points = solve("greenwood-tripp", mu, force / unit)
    overlap = (points.approach[1:] - points.approach[0]) * GRANITE.roughness + law.overlap(0.02)
    np.testing.assert_allclose(law.force(overlap), force[1:], rtol=5e-6)
    np.testing.assert_allclose(law.stiffness(overlap), points.stiffness[1:] * unit / GRANITE.roughness, rtol=2e-5)


def test_mu_from_asperities():
    """μ = (8/3) η σ √(2Rβ)."""
    density, radius = 2e9, 5e-5
    mu = 8 / 3 * density * GRANITE.roughness * math.sqrt(2 * GRANITE.radius * radius)
    measured = dl.law("greenwood-tripp", GRANITE, asperity_density=density, asperity_radius=radius)
    given = dl.law("greenwood-tripp", GRANITE, mu=mu)
    assert measured.force(3e-6) == pytest.approx(given.force(3e-6), rel=1e-9)
