import dataclasses
import math
import warnings

import mpmath
import numpy as np
import pytest
from ellipsoids import ellipsoids
from hypothesis import given, settings, strategies as st

import demlaws as dl
from demlaws import regime
from demlaws.laws.asperity import _steepest
from demlaws.solvers import ellipsoid
from demlaws.solvers.contact import RoughContact, _deform
from demlaws.solvers.summits import summits
from demlaws.surface import HeightMap, self_affine
from studies.jamari import published
from studies.validation.maps import load_ratios

# what c_h and c_A are taken to be is said where a contact is made; here it does not matter
pytestmark = pytest.mark.filterwarnings("ignore:c_h = :demlaws.errors.ValidityWarning")

ALUMINIUM = ellipsoid.plasticity(71.3e9, 0.24e9, 0.34)
ELASTIC = ellipsoid.plasticity(50e9, math.inf, 0.3)
MANY = dl.Contact(radius=np.linspace(1e-3, 2e-3, 100), modulus=np.linspace(1e10, 2e10, 100), sigma=1e-6, hardness=1e9)

ratios = st.floats(0.0, 4.0).map(lambda x: 10.0**x)


# --- one ellipsoid


@pytest.mark.parametrize("ratio", [1 + 1e-12, 1 + 1e-7, 1 + 1e-5, 1.001, 1.01, 1.3, 2.0, 7.0, 50.0, 1e3, 1e5, 1e8])
def test_shape_factors_are_those_of_johnson(ratio):
    """Against Johnson 1985, Eqs. 4.26-4.28, solved with 40 digits: k, semi-axes, approach."""
    alpha, beta, gamma, k = ellipsoid.shape_factors(ratio)
    with mpmath.workdps(40):
        ratio = mpmath.mpf(ratio)

        def misfit(log_k):  # Johnson's (b/a) is our k: R'/R'' = [(a/b)² E - K]/(K - E)
            m = 1 - mpmath.exp(2 * log_k)
            big_k, big_e = mpmath.ellipk(m), mpmath.ellipe(m)
            return mpmath.log((big_e / (1 - m) - big_k) / (big_k - big_e)) - mpmath.log(ratio)

        exact = mpmath.exp(mpmath.findroot(misfit, (math.log(k) * 0.99 - 1e-13, math.log(k) * 1.01 - 1e-12)))
        m = 1 - exact**2
        big_k, big_e = mpmath.ellipk(m), mpmath.ellipe(m)
        # R_short = 1, R_long = ratio, E* = 1, P = 1; long semi-axis b, p0 = 3P/(2πab)
        b = mpmath.cbrt(3 * big_e / (mpmath.pi * exact**2) / (1 + 1 / ratio))
        a = exact * b
        p0 = 3 / (2 * mpmath.pi * a * b)
        approach = p0 * a * big_k  # δ = p0 b_Johnson K/E*, b_Johnson the short semi-axis
        mean = ratio / (1 + ratio)
        scale = mpmath.cbrt(3 * mean / 2)
        assert float(abs(k / exact - 1)) < 1e-12
        assert float(abs(alpha * scale / a - 1)) < 1e-12
        assert float(abs(beta * scale / b - 1)) < 1e-12
        assert float(abs(gamma * mpmath.cbrt(mpmath.mpf(9) / (32 * mean)) / approach - 1)) < 1e-12


def test_the_factors_that_maps_read_from_a_table():
    """Cubic interpolation in ln ratio against the exact integrals: 1e-10 at every ratio that a patch can have."""
    ratio = np.concatenate([[1.0, 1 + 1e-9], np.exp(np.linspace(0, 26, 4001) ** 1.0)])
    alpha, beta, gamma, _ = ellipsoid.shape_factors(np.minimum(ratio, 9e11))
    quick = np.array([ellipsoid.quick_factors(r) for r in np.minimum(ratio, 9e11)])
    np.testing.assert_allclose(quick[:, 0], alpha * beta, rtol=1e-10)
    np.testing.assert_allclose(quick[:, 1], gamma, rtol=1e-10)


@given(ratios, st.floats(1e-7, 1e-3), st.floats(0.0, 0.5))
def test_joints_are_continuous_and_force_rises(ratio, radius, poisson):
    material = ellipsoid.plasticity(71.3e9, 0.24e9, poisson)
    one = ellipsoids(material, radius, radius * ratio, 1e-9)
    first, full = one.first_yield[0], one.full_plasticity[0]
    assert full > first > 0
    for joint in (first, full):
        sides = ellipsoids(material, radius, radius * ratio, joint * np.array([1 - 1e-9, 1 + 1e-9]))
        assert sides.state[0] != sides.state[1]
        assert sides.force[1] == pytest.approx(sides.force[0], rel=1e-7)
        assert sides.area[1] == pytest.approx(sides.area[0], rel=1e-7)
    path = ellipsoids(material, radius, radius * ratio, np.geomspace(0.1 * first, 10 * full, 400))
    assert np.all(np.diff(path.force) > 0) and np.all(np.diff(path.area) > 0) and np.all(np.diff(path.residual) >= 0)


def test_residual_indentation():
    """ω_res/ω = 0.20, 0.42, 0.54, 0.63, 0.72 at ω/ω1 = 2, 5, 10, 20, 80, and Hertz at Pmax over the same area."""
    radius = 1e-4
    first = ellipsoids(ALUMINIUM, radius, radius, 1e-9).first_yield[0]
    times = np.array([1, 2, 5, 10, 20, 80])
    found = ellipsoids(ALUMINIUM, radius, radius, first * times)
    np.testing.assert_allclose(found.residual / (first * times), [0, 0.20, 0.42, 0.54, 0.63, 0.72], atol=0.005)
    a = np.sqrt(found.area / math.pi)
    elastic = 3 * found.force / (4 * ALUMINIUM.modulus * a)
    np.testing.assert_allclose(found.residual[1:], (first * times - elastic)[1:], rtol=1e-12)


# --- patches


def independent_volume(height, cut):
    """Volume above the cut of the triangulated surface, in pixels: (1/6) Σ u₊³/Π(u_i - u_j) a triangle of area 1/2."""
    u = np.asarray(height, np.longdouble) - np.longdouble(cut)
    nw, n, w, c = u[:-1, :-1], u[:-1, 1:], u[1:, :-1], u[1:, 1:]
    total = np.longdouble(0)
    for corners in ((nw, n, c), (nw, w, c)):
        for i in range(3):
            a, b, d = corners[i], corners[(i + 1) % 3], corners[(i + 2) % 3]
            total += (np.maximum(a, 0) ** 3 / ((a - b) * (a - d))).sum()
    return float(total / 6)


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10**6), st.floats(-1.5, 2.5), st.booleans())
def test_volume_and_area_are_conserved(seed, cut, flat):
    rng = np.random.default_rng(seed)
    z = rng.standard_normal((24, 31)) * 1e-6
    pair = dl.Contact(radius=1e-3, modulus=50e9, hardness=1e9, sigma=1e-6)
    contact = RoughContact(HeightMap(z, 1e-6), pair, flat=flat)
    step = contact.at(contact.highest - cut * 1e-6) if contact.highest > cut * 1e-6 else contact.at(1e-7)
    micro = step.micro
    ellipses = math.pi / 4 * micro.length_long * micro.length_short
    assert (0.5 * ellipses * micro.indentation).sum() == pytest.approx(
        independent_volume(contact.gap, step.cut) * 1e-12, rel=1e-12
    )
    assert ellipses.sum() == pytest.approx(step.cut_area, rel=1e-12)


def test_patches_are_those_of_scipy():
    """Labels against scipy.ndimage.label with the neighbours that the triangulation has."""
    from scipy import ndimage

    neighbours = np.array([[1, 1, 0], [1, 1, 1], [0, 1, 1]])
    rng = np.random.default_rng(5)
    for _ in range(20):
        z = rng.standard_normal((40, 33))
        contact = RoughContact(HeightMap(z * 1e-6, 1e-6), dl.Contact(radius=1.0, modulus=1e9), flat=True)
        cut = rng.uniform(-1, 2) * 1e-6
        _, expected = ndimage.label(contact.gap > cut, neighbours)
        assert len(contact._patches(cut)) == expected


def test_moments_of_a_patch_are_those_of_its_cells():
    """A plateau of 3 by 6 pixels is 2 by 5 cells: the ellipse of its second moments has the ratio 5/2 of the rectangle."""
    z = np.full((9, 12), -1.0)
    z[3:6, 2:8] = 1e-9
    contact = RoughContact(HeightMap(z, 1e-6), dl.Contact(1e-3, 1e11), 0.3, 0.71, 160.0, flat=True)
    (patch,) = contact.at(1e-9).micro
    assert patch.cut_area == pytest.approx(10e-12, rel=1e-7)
    assert patch.length_long / patch.length_short == pytest.approx(2.5, rel=1e-6)


def test_a_paraboloid_gives_back_its_radii():
    """A tilted elliptic cap: radii of curvature, orientation, Hertz load of the exact ellipsoid."""
    size, pixel, rx, ry, angle, height = 401, 0.1e-6, 40e-6, 160e-6, 0.4, 1e-6
    y, x = (np.indices((size, size)) - size // 2) * pixel
    u, v = x * math.cos(angle) + y * math.sin(angle), -x * math.sin(angle) + y * math.cos(angle)
    z = height - v**2 / (2 * rx) - u**2 / (2 * ry)
    pair = dl.Contact(radius=1.0, modulus=50e9)
    contact = RoughContact(HeightMap(z, pixel), pair, flat=True)
    step = contact.at(0.8 * height)
    assert len(step.micro) == 1
    assert step.micro.angle[0] == pytest.approx(angle, abs=1e-4)
    assert step.micro.length_long[0] == pytest.approx(2 * math.sqrt(2 * ry * 0.8 * height), rel=1e-3)
    exact = ellipsoids(ELASTIC, rx, ry, 0.8 * height)
    assert step.force == pytest.approx(exact.force[0], rel=1e-3)
    assert step.contact_area == pytest.approx(exact.area[0], rel=1e-3)


def random_case(k, rng):
    rows, columns = (int(n) for n in rng.integers(16, 72, 2))
    pixel, roughness = rng.uniform(0.1, 2) * 1e-6, 10 ** rng.uniform(-8, -5.5)
    if k % 4 == 3:
        heights = HeightMap(rng.standard_normal((rows, columns)) * roughness, pixel)
    else:
        stretch = rng.uniform(0.2, 5) if k % 4 == 1 else 1.0
        heights = self_affine(
            (rows, columns), pixel, rng.uniform(0.05, 1), roughness=roughness, seed=k, anisotropy=stretch, periodic=k % 4 == 2
        )
    pair = dl.Contact(
        radius=10 ** rng.uniform(-4, -1.5), modulus=10 ** rng.uniform(9, 11.7), hardness=10 ** rng.uniform(8, 10.3)
    )
    contact = RoughContact(heights, pair, rng.uniform(0, 0.5), flat=bool(k % 2))
    load = contact.at(10 ** rng.uniform(-4, 0.5) * heights.sq).force
    return contact, load * rng.uniform(0.7, 1.4)


def test_load_is_met_on_a_thousand_random_maps():
    rng = np.random.default_rng(1)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", dl.ValidityWarning)
        for k in range(1000):
            contact, load = random_case(k, rng)
            for tolerance in (0.01, 1e-9):
                step = contact.load(load, tolerance)
                assert abs(step.force - load) <= tolerance * load * (1 + 1e-6)
            assert step.force == pytest.approx(step.micro.force.sum(), rel=1e-12)


# --- unloading and cycles


def test_one_sphere_after_unloading():
    """The map left by one plastic asperity: peak lowered by the residual, the same load and area again, elastically."""
    size, pixel, radius = 241, 0.25e-6, 100e-6
    y, x = (np.indices((size, size)) - size // 2) * pixel
    heights = HeightMap(1e-6 - (x**2 + y**2) / (2 * radius), pixel)
    pair = dl.Contact(radius=1.0, modulus=ALUMINIUM.modulus, hardness=0.24e9)
    contact = RoughContact(heights, pair, poisson=0.34, flat=True)
    one = ellipsoids(ALUMINIUM, radius, radius, 0.7e-6)
    step = contact.at(0.7e-6)
    assert step.micro.state[0] == one.state[0] > 0
    worn = contact.unload(step)
    assert contact.highest - worn.highest == pytest.approx(one.residual[0], rel=2e-3)
    again = worn.at(0.7e-6)
    assert again.counts == (1, 0, 0)
    assert again.force == pytest.approx(step.force, rel=1e-9)
    assert again.contact_area == pytest.approx(step.contact_area, rel=1e-9)
    # on the way there it is the Hertz contact of the blunter sphere R' = 4 E* a³/(3 Pmax)
    blunt = 4 * ALUMINIUM.modulus * (one.area[0] / math.pi) ** 1.5 / (3 * one.force[0])
    half = worn.at(0.7e-6 - 0.5 * (0.7e-6 - one.residual[0]))
    hertz = 4 / 3 * ALUMINIUM.modulus * math.sqrt(blunt) * (0.5 * (0.7e-6 - one.residual[0])) ** 1.5
    assert half.force == pytest.approx(hertz, rel=5e-3)
    # a heavier load yields again
    assert worn.at(0.8e-6).counts[0] == 0


def test_pixels_between_patches():
    """One that borders two patches follows the one that shrinks least and remembers the highest pressure of both.

    Borders are edges of the triangulation: left, right, up, down, and one diagonal.
    """
    labels = np.zeros((5, 7), np.int32)
    labels[2, 2], labels[2, 4], labels[0, 6] = 1, 2, 3
    table = np.zeros((3, 15))
    table[:, 10] = (ellipsoid.ELASTIC + 1, ellipsoid.ELASTIC + 1, ellipsoid.ELASTIC)
    table[:, 11], table[:, 12], table[:, 13] = (0.5, 0.8, 0.9), (1.5, 1.2, 7.0), (3.0, 2.0, 9.0)  # shrink, spread, pressure
    h = np.linspace(1.0, 2.0, 35).reshape(5, 7)
    h[1, 1] = np.nan
    heights, spread, limit = h.copy(), np.ones((5, 7)), np.zeros((5, 7))
    _deform(h, 0.25, labels, np.array([0, 1, 2, 3], np.int32), table, heights, spread, limit)
    left = {(2, 2), (1, 2), (2, 1), (3, 2), (3, 3)}  # of the first patch alone; (1, 1) is missing
    right = {(2, 4), (1, 4), (2, 5), (3, 4), (1, 3), (3, 5)}
    expected = {**dict.fromkeys(left, (0.5, 1.5, 3.0)), **dict.fromkeys(right, (0.8, 1.2, 2.0)), (2, 3): (0.8, 1.2, 3.0)}
    for place in np.ndindex(5, 7):
        shrink, blunt, pressure = expected.get(place, (1.0, 1.0, 0.0))
        found = heights[place], spread[place], limit[place]
        assert found == pytest.approx((h[place] + (shrink - 1.0) * (h[place] - 0.25), blunt, pressure), nan_ok=True), place


def aluminium_on(seed):
    """SiC ball on a synthetic map of aluminium."""
    heights = self_affine(128, 1e-6, 0.8, roughness=1e-6, seed=seed, shortest=6e-6, longest=40e-6)
    pair = dl.Contact(radius=3.175e-3, modulus=71e9, sigma=heights.sq, hardness=0.24e9)
    return RoughContact(heights, pair, 0.34, 0.71, 160.0)


@pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")
@pytest.mark.parametrize("seed", range(3))
def test_rising_loads_end_where_direct_loading_ends(seed):
    """Loaded to 0.02 N, unloaded and loaded to 0.04 N a map kept 0.5 of the worn volume of direct loading."""
    rng, new = np.random.default_rng(seed), aluminium_on(seed)
    for _ in range(4):
        contact, highest = new, 0.0
        for load in rng.uniform(0.005, 0.06, 4):  # in any order; what lies below the highest changes next to nothing
            worn = contact.unload(contact.load(load, 1e-6))
            if load < highest:
                assert worn.change_from(contact) < 1e-3 * worn.change_from(new)
            contact, highest = worn, max(load, highest)
        for load in highest * np.array([1.0001, 1.1, 2.0]):
            later, direct = contact.load(load, 1e-7), new.load(load, 1e-7)
            assert later.overlap == pytest.approx(direct.overlap, rel=1e-3)
            assert later.contact_area == pytest.approx(direct.contact_area, rel=1e-3)
            after, expected = contact.unload(later), new.unload(direct)
            assert after.change_from(expected) < 1e-3 * expected.change_from(new)


@pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")
def test_at_another_place_the_memory_is_that_of_the_pixels():
    new = aluminium_on(1)
    worn = new.unload(new.load(0.02))
    assert worn.before is new
    for change in ({"centre": (20e-6, 20e-6)}, {"pair": new.pair.with_values(radius=2e-3)}):
        moved = dataclasses.replace(worn, **change)
        assert moved.before is None and moved.limit is worn.limit


def test_missing_pixels_do_not_touch():
    heights = self_affine(64, 1e-6, 0.8, roughness=0.5e-6, seed=1)
    holes = heights.heights.copy()
    holes[20:40, 20:40] = np.nan
    pair = dl.Contact(radius=5e-3, modulus=50e9, hardness=1e9)
    step = RoughContact(heights.with_heights(holes), pair, flat=True).load(0.05)
    x, y = step.micro.x / 1e-6, step.micro.y / 1e-6
    assert not np.any((x > 19.5) & (x < 39.5) & (y > 19.5) & (y < 39.5))
    worn = RoughContact(heights.with_heights(holes), pair, flat=True).unload(step)
    np.testing.assert_array_equal(np.isnan(worn.heights.heights), np.isnan(holes))


def test_bulk_yield_and_edge_are_warned_about():
    with warnings.catch_warnings(record=True) as seen:
        warnings.simplefilter("always")
        published.published_contact("isotropic").load(1.45)
    assert any("bulk also yields" in str(w.message) for w in seen)
    small = HeightMap(np.zeros((21, 21)), 1e-6)
    with pytest.warns(dl.ValidityWarning, match="edge of the map"):
        RoughContact(small, dl.Contact(radius=1e-2, modulus=1e9)).load(6e-5)


def test_a_law_up_to_a_force_beyond_the_edge_of_its_map_warns():
    """Without max_force the curve ends where the contact reaches the edge."""
    heights, pair = self_affine(64, pixel=2e-6, hurst=0.8, roughness=2e-6, seed=1), dl.Contact(4e-3, 32e9, 2e-6, hardness=6e9)
    with pytest.warns(dl.ValidityWarning, match="reaches the edge of the map"):
        dl.law("asperity", pair, surface=heights, max_force=20.0, plastic_factor=0.71, plastic_ratio=160.0)


@pytest.mark.parametrize(
    "call",
    [
        lambda heights, pair: RoughContact(heights, pair).load(-1),
        lambda heights, pair: RoughContact(heights, pair).load(1.0, rtol=2.0),
        lambda heights, pair: RoughContact(heights, pair, plastic_factor=0.1),
        lambda heights, pair: RoughContact(heights, pair.with_values(radius=np.array([1e-3, 2e-3]))),
        lambda heights, pair: ellipsoid.shape_factors(0.5),
        lambda heights, pair: summits(HeightMap(np.zeros((8, 8)), 1e-6)),
        lambda heights, pair: dl.law("asperity", MANY, surface=heights),
    ],
)
def test_bad_input(call):
    with pytest.raises(dl.DemlawsError):
        call(self_affine(32, 1e-6, 0.8, roughness=0.5e-6, seed=1), dl.Contact(radius=5e-3, modulus=50e9, hardness=1e9))


# --- an elastic boundary-element solution


def test_against_boundary_elements():
    """Ratio of loads at equal separation, whatever it is: 1.00 on a smooth ball, 0.5 to 1.3 on rough maps."""
    for case, ratio in load_ratios():
        low, high = (0.99, 1.01) if case == "smooth ball" else (0.5, 1.35)
        assert low < ratio < high, (case, ratio)


# --- as a law


def law_of(kind="isotropic", **options):
    contact = published.published_contact(kind)
    return contact, dl.law("asperity", contact.pair, surface=contact.heights, poisson=0.34, **options)


def test_the_law_follows_the_model():
    contact, law = law_of()
    for load in (0.01, 0.05, 0.2, 0.8):
        assert law.overlap(load) == pytest.approx(contact.load(load, 1e-6).overlap, rel=0.05)
    assert law.limits()[0].maximum_force == pytest.approx(regime.transition_force(contact.pair), rel=1e-9)
    with pytest.warns(dl.ValidityWarning, match="bulk yields"):
        law.overlap(3.0)


def test_steepest_slope_between_nodes():
    """A cubic through straight nodes with one steep slope passes 1 between them: the curve is scaled by its largest slope."""
    u, s = np.array([0.0, 1.0, 2.0, 3.0]), np.array([0.0, 0.9, 1.8, 2.7])
    steep = np.array([0.9, 0.5, 0.9, 0.9])
    t = np.linspace(0.0, 1.0, 100_001)
    slope = 0.9 * (1 - t) * (1 - 3 * t) + 6 * t * (1 - t) * 0.9 + 0.5 * t * (3 * t - 2)
    assert _steepest(u, s, steep) == pytest.approx(slope.max(), rel=2e-3) and slope.max() > 1.03
    assert _steepest(u, s, np.full(4, 0.9)) == 1.0


def test_nine_point_summits_of_known_bumps():
    """Spherical bumps of one radius on a square grid: η, β and μ are those they were made with."""
    pitch, radius, pixel, count = 20, 30e-6, 1e-6, 8
    y, x = np.indices((count * pitch, count * pitch))
    r2 = ((x % pitch - 10) ** 2 + (y % pitch - 10) ** 2) * pixel**2
    heights = HeightMap(np.maximum(-r2 / (2.0 * radius), -1.2e-6), pixel)
    found = summits(heights)
    assert found.total == count**2
    assert found.density == pytest.approx(1.0 / (pitch * pixel) ** 2, rel=0.03)  # less the rim, which has no neighbours
    assert found.radius == pytest.approx(radius, rel=1e-9)
    assert found.roughness == heights.sq and found.spread == 0.0
    assert found.height == pytest.approx(-float(heights.heights.mean()), rel=1e-9)
    expected = 8.0 / 3.0 * found.density * heights.sq * math.sqrt(2.0 * 5e-3 * radius)
    assert found.mu(5e-3) == pytest.approx(expected, rel=1e-12)
