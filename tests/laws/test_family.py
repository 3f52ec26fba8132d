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


def test_overlap_zero_is_where_the_seating_load_is_carried():
    low, high = (dl.law("yip-venart", GRANITE, seating_load=load) for load in (1e-3, 1.0))
    for law, load in ((low, 1e-3), (high, 1.0)):
        assert quiet(law.force, 1e-12) == pytest.approx(load, rel=1e-3)
    # one curve, moved by what the search for its start leaves
    ahead = quiet(low.overlap, 1.0)
    assert quiet(low.force, ahead + 3e-6) == pytest.approx(quiet(high.force, 3e-6), rel=1e-7)


def test_a_smooth_contact_is_hertz():
    smooth = GRANITE.with_values(roughness=1e-10 * GRANITE.radius)
    assert dl.law("yip-venart", smooth).force(1e-5) == dl.law("hertz", smooth).force(1e-5)
