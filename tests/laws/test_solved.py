"""Laws whose curve a solver gives: the curve of a contact, what lies between two solved curves, and the solver itself."""

import math
import warnings

import numpy as np
import pytest
from examples import GRANITE, quiet

import demlaws as dl
from demlaws.core.loops import force_loop
from demlaws.solvers import master_curves
from studies.half_space.axisymmetric import solve

pytestmark = pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")
UNIT = GRANITE.modulus * math.sqrt(GRANITE.radius) * GRANITE.sigma**1.5
NUMBER = GRANITE.hardness / GRANITE.modulus * math.sqrt(8 * GRANITE.radius / GRANITE.sigma)
RADII = GRANITE.radius * np.array([0.5, 0.8, 1.0, 1.7])


@pytest.fixture(scope="module")
def family():
    """Yip & Venart's law of contacts that differ: curves at a sequence of their number."""
    return quiet(dl.law, "yip-venart", GRANITE.with_values(radius=RADII))


def test_between_two_curves_the_family_is_the_solvers(family):
    """At equal overlap: the kernel reads four curves of the data between which the number of each contact lies."""
    overlap = np.full(RADII.size, 5e-6)
    force, stiffness = quiet(family.force, overlap), quiet(family.stiffness, overlap)
    for i, radius in enumerate(RADII):
        one = dl.law("yip-venart", GRANITE.with_values(radius=float(radius)))
        assert force[i] == pytest.approx(quiet(one.force, 5e-6), rel=2e-6)
        assert stiffness[i] == pytest.approx(quiet(one.stiffness, 5e-6), rel=2e-6)


def test_the_family_is_its_own_inverse_and_integral(family):
    overlap = np.array([1e-6, 5e-6, 1e-5, 2e-5])
    force = quiet(family.force, overlap)
    np.testing.assert_allclose(quiet(family.overlap, force), overlap, rtol=1e-9)
    step = 1e-4 * overlap
    difference = (family.energy(overlap + step) - family.energy(overlap - step)) / (2 * step)
    np.testing.assert_allclose(difference, force, rtol=1e-6)


@pytest.mark.parametrize("model", ["yip-venart", "greenwood-tripp"])
def test_rows_of_the_data_are_at_their_numbers(model):
    """The value between four rows is that of a row at this row's own number, in every row."""
    data, force = master_curves.load(model), np.geomspace(1e-4, 1e4, 5)
    rows, _ = data.pressure.at(np.log(force))
    numbers = np.exp(data.log_first + data.log_ratio * np.arange(len(rows)))
    inside = (numbers >= master_curves.LOWEST) & (numbers <= master_curves.HIGHEST)
    assert len(rows) - 4 <= inside.sum() < len(rows)
    for number, row in zip(numbers[inside], rows[inside], strict=True):
        np.testing.assert_allclose(master_curves.central_pressure(model, float(number), force), row, rtol=1e-9)
    last = int(np.flatnonzero(inside)[-1])
    for first in (int(np.flatnonzero(inside)[0]), 60, last - 1):  # between two rows: the cubic through the four around
        number = float(np.sqrt(numbers[first] * numbers[first + 1]))
        cubic = np.array([-1.0, 9.0, 9.0, -1.0]) @ rows[first - 1 : first + 3] / 16.0
        np.testing.assert_allclose(master_curves.central_pressure(model, number, force), cubic, rtol=1e-9)


@pytest.mark.parametrize("name", ["greenwood-tripp", "yip-venart"])
def test_below_the_seating_load_the_curve_is_continued(name):
    low, high = (dl.law(name, GRANITE, seating_share=share) for share in (1e-4, 0.1))
    for law, share in ((low, 1e-4), (high, 0.1)):
        seat = quiet(law.overlap, share * UNIT)
        below = seat * np.array([1e-6, 1e-3, 0.5, 1 - 1e-9])
        np.testing.assert_allclose(quiet(law.force, below), share * UNIT * (below / seat) ** 1.5, rtol=1e-4)
        assert quiet(law.stiffness, seat * (1 + 1e-9)) == pytest.approx(1.5 * share * UNIT / seat, rel=1e-2)
        assert min(limit.minimum_force for limit in law.limits() if limit.minimum_force) == pytest.approx(share * UNIT)
    # above both seats it is one curve, shifted
    ahead = quiet(low.overlap, 0.2 * UNIT) - quiet(high.overlap, 0.2 * UNIT)
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


def solved(name, number, force):
    points = solve(name, number, np.asarray(force) / UNIT)
    return points.approach * GRANITE.sigma, points.stiffness * UNIT / GRANITE.sigma


@pytest.mark.parametrize(
    ("name", "number", "options", "largest"),
    [
        ("yip-venart", NUMBER, {}, 90.0),
        ("greenwood-tripp", 4.0, {"mu": 4.0}, 1000.0),
        ("greenwood-tripp", 17.0, {"mu": 17.0}, 1000.0),
    ],
    ids=["yip-venart", "greenwood-tripp 4", "greenwood-tripp 17"],
)
def test_the_law_is_that_of_the_solver(name, number, options, largest):
    """The law reads the package's data; solved afresh at loads between its nodes."""
    law = dl.law(name, GRANITE, **options)
    force = np.geomspace(0.02, largest, 14)
    approach, stiffness = solved(name, number, force)
    overlap = approach[1:] - approach[0] + quiet(law.overlap, 0.02)
    np.testing.assert_allclose(quiet(law.force, overlap), force[1:], rtol=5e-6)
    np.testing.assert_allclose(quiet(law.stiffness, overlap), stiffness[1:], rtol=2e-5)


@pytest.mark.parametrize("share", [1e-4, 0.0025, 0.025])
def test_overlap_counts_from_the_end_of_the_continued_curve(share):
    law = dl.law("yip-venart", GRANITE, seating_share=share)
    seat = share * UNIT
    approach, stiffness = solved("yip-venart", NUMBER, [seat, 10.0])
    assert law.overlap(10.0) == pytest.approx(approach[1] - approach[0] + 1.5 * seat / stiffness[0], rel=1e-6)


def test_a_smooth_contact_among_rough_ones_is_refused():
    with pytest.raises(dl.DemlawsError):
        dl.law("yip-venart", GRANITE.with_values(sigma=np.array([0.0, 1e-6])))


@pytest.mark.parametrize("radius", [1.0, [1.0, 1.1]])
@pytest.mark.parametrize("change", [{"hardness": 5e5}, {"modulus": 3e15}, {"sigma": 1e-4, "hardness": 1e6}])
def test_a_number_outside_the_data_is_one_clear_error(radius, change):
    """N_H from 0.05 to 1e5; also of one contact among others."""
    contact = GRANITE.with_values(radius=GRANITE.radius * np.array(radius) if isinstance(radius, list) else GRANITE.radius)
    with pytest.raises(dl.DemlawsError, match="N_H"), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        dl.law("yip-venart", contact.with_values(**change))


@pytest.mark.parametrize("number", [2.0, 60.0, 100.0, 175.0, 313.0])
@pytest.mark.parametrize("differ", [False, True])
def test_where_the_pressure_reaches_the_hardness_the_law_is_no_stiffer_than_hertz(number, differ):
    """There the curves bend, at an overlap that goes with N_H²: a cubic through neighbours was 0.15 % stiffer."""
    hardness = number * GRANITE.modulus / math.sqrt(8 * GRANITE.radius / GRANITE.sigma)
    radius = GRANITE.radius * np.array([1.0, 1.2, 1.4]) if differ else GRANITE.radius
    law = dl.law("yip-venart", GRANITE.with_values(hardness=min(hardness, 9 * GRANITE.modulus), radius=radius), "elastic")
    flat = 0.28 * number**2 * GRANITE.sigma
    for overlap in np.geomspace(0.3, 1.3, 400) * flat:
        force, stiffness = force_loop(law.shape, law.params, np.full(3 if differ else 1, overlap))
        hertz = (6.0 * np.asarray(radius) * GRANITE.modulus**2 * force) ** (1 / 3)
        assert np.all(stiffness <= hertz * (1.0 + 1e-9))
