"""Laws whose curve a solver gives: which curve a contact has, and what lies between two solved curves."""

import numpy as np
import pytest
from examples import GRANITE, quiet

import demlaws as dl

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


def test_a_smooth_contact_is_hertz():
    smooth = GRANITE.with_values(roughness=1e-10 * GRANITE.radius)
    assert dl.law("yip-venart", smooth).force(1e-5) == dl.law("hertz", smooth).force(1e-5)
