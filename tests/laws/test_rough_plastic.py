"""Rough-plastic: yield of the granite cones, what yielding leaves, and 50-digit references."""

import math

import numpy as np
import pytest
from examples import quiet, shared

import demlaws as dl

CONE = dl.Contact(radius=0.96e-3, modulus=32.32e9, sigma=5.04e-6, fractal_dimension=2.25, hardness=6.266e9)


def test_yield_of_the_cones():
    """RFC10: 5000 N/mm is p_y = 1.66 GPa = 0.265 H_m, and Hertz alone yields at 20.8 N. FC5: 2437 N/mm, about 7 N."""
    for contact, pressure, stiffness, force in (
        (CONE, 1.66e9, 5000e3, 20.8),
        (CONE.with_values(radius=0.33e-3), 2.35e9, 2437e3, 7.0),
    ):
        law = dl.law("rough-plastic", contact, loading="hertz", yield_pressure=pressure)
        (kink,) = law.kinks()
        assert law.force(kink) == pytest.approx(force, rel=0.01)
        exact = math.pi**3 * contact.radius**2 * pressure**3 / (6 * contact.modulus**2)
        assert law.force(kink) == pytest.approx(exact, rel=1e-13)
        np.testing.assert_allclose(quiet(law.stiffness, kink * np.array([1.0, 1.5, 10.0])), stiffness, rtol=2e-3)


@pytest.mark.parametrize(
    "loading",
    shared(
        ["hertz", "rms", "pohrt-popov", "goddard", "bahrami", "yip-venart", "greenwood-tripp"],
        ("hertz", "pohrt-popov", "yip-venart").__contains__,
    ),
)
def test_stiffness_is_the_smaller_of_the_two(loading):
    options = {"slope": 0.05} if loading == "goddard" else {}
    law = dl.law("rough-plastic", CONE, loading=loading, yield_pressure=1.66e9, **options)
    rough = dl.law(loading, CONE, **options)
    force = np.geomspace(0.021, 400.0, 50)
    stiffness = quiet(law.stiffness, quiet(law.overlap, force))
    limit = math.pi * CONE.radius * 1.66e9
    expected = np.minimum(quiet(rough.stiffness, quiet(rough.overlap, force)), limit)
    if loading == "bahrami":  # its stiffness dips after the joint: yield is final
        expected = np.where(np.maximum.accumulate(expected) >= limit, limit, expected)
    np.testing.assert_allclose(stiffness, expected, rtol=1e-9)


def test_kinks_are_those_of_the_rough_law_below_yield_and_yield():
    smooth = CONE.with_values(sigma=0.2e-6)
    law, rough = dl.law("rough-plastic", smooth, "elastic", yield_pressure=1.66e9), dl.law("pohrt-popov", smooth, "elastic")
    assert law.kinks() == [*rough.kinks(), law.params.yield_overlap] and rough.kinks()[0] < law.params.yield_overlap
    late = dl.law("rough-plastic", CONE, "elastic", yield_pressure=0.5e9)
    assert late.kinks() == [late.params.yield_overlap]


def test_yield_loads_and_stiffnesses_of_other_radii():
    """P_y = π³R²p_y³/(6E*²) and K_y = π R p_y: for many contacts, of the rough law at that load."""
    many = CONE.with_values(radius=np.array([0.96e-3, 0.33e-3]))
    law = dl.law("rough-plastic", many, "thornton", yield_pressure=1.66e9, yield_at="load")
    for n, radius in enumerate(many.radius):
        load = math.pi**3 * radius**2 * 1.66e9**3 / (6 * many.modulus**2)
        rough = dl.law("pohrt-popov", contact := CONE.with_values(radius=radius))
        kink = rough.overlap(load)
        expected = {"yield_force": load, "yield_stiffness": rough.stiffness(kink), "yield_overlap": kink}
        expected["area_slope"] = 1.0 / (math.pi * radius * 1.66e9)
        for name, value in (expected | {"yield_area": dl.law("hertz", contact).overlap(load)}).items():
            assert getattr(law.params, name)[n] == pytest.approx(value, rel=1e-12), name


FC5 = CONE.with_values(radius=0.33e-3, fractal_dimension=2.22)
BLUNT = {"yield_pressure": 1.66e9, "yield_at": "load", "bulk_radius": 0.62e-3}


def test_a_sharp_tip_of_a_blunt_bulk():
    """Roughness on R, yield and unloading on R_b: FC5 by the pressure of RFC10 yields at 8.7 N (printed: 7), with no jump."""
    law, rough = dl.law("rough-plastic", FC5, "hertz", **BLUNT), dl.law("pohrt-popov", FC5)
    load = math.pi**3 * 0.62e-3**2 * 1.66e9**3 / (6 * FC5.modulus**2)
    kink = law.kinks()[-1]
    assert load == pytest.approx(8.70, abs=0.005)
    assert kink == pytest.approx(rough.overlap(load), rel=1e-12)
    assert law.stiffness(kink * np.array([1.0 - 1e-12, 1.0 + 1e-12, 2.0])) == pytest.approx(
        [rough.stiffness(kink)] * 3, rel=1e-9
    )
    np.testing.assert_allclose(law.force(kink * np.array([0.3, 0.9])), rough.force(kink * np.array([0.3, 0.9])), rtol=1e-12)
    at_stiffness = dl.law("rough-plastic", FC5, yield_pressure=1.66e9, bulk_radius=0.62e-3)
    assert rough.stiffness(at_stiffness.kinks()[-1]) == pytest.approx(math.pi * 0.62e-3 * 1.66e9, rel=1e-12)
    smooth = dl.law("hertz", FC5.with_values(radius=0.62e-3))
    for top in (0.5 * load, 5.0 * load):  # unloading: Hertz's curve of R_b
        state = law.new_state(1)
        law.evaluate([law.overlap(top)], state)
        (foot,) = state.plastic_overlap
        force, _ = law.evaluate([foot + smooth.overlap(0.4 * top)], state)
        assert force[0] == pytest.approx(0.4 * top, rel=1e-12)
        assert foot == pytest.approx(law.overlap(top) - smooth.overlap(top), rel=1e-12)


def test_thornton_starts_from_the_radius_of_the_bulk():
    """R_p = R_b until yield, then (4E*/3P) a³ with a² = a_y² + (P - P_y)/(π p_y)."""
    law = dl.law("rough-plastic", FC5, "thornton", **BLUNT)
    load, bulk = float(law.params.yield_force), 0.62e-3
    for top in (0.5 * load, 4.0 * load):
        state = law.new_state(1)
        law.evaluate([law.overlap(top)], state)
        area = (0.75 * min(top, load) * bulk / FC5.modulus) ** (2 / 3) + max(top - load, 0.0) / (math.pi * 1.66e9)
        radius = 4 * FC5.modulus / (3 * top) * area**1.5
        assert state.radius_ratio[0] * bulk == pytest.approx(radius, rel=1e-12)


def test_tables_of_a_blunt_bulk():
    law = dl.law("rough-plastic", FC5, "hertz", **BLUNT)
    path = quiet(dl.driver.force_controlled, law, [20.0, 0.0, 60.0, 10.0, 90.0, 0.0])
    for table in (law.tabulate(), law.joined("elastic").tabulate().joined("hertz")):
        assert table.largest_overlap > 0.0619e-3  # a tenth of R_b
        found = quiet(table.follow, path.overlap)
        np.testing.assert_allclose(found.force, path.force, atol=1e-5 * 90.0)
        np.testing.assert_allclose(found.plastic_overlap, path.plastic_overlap, atol=1e-5 * path.overlap.max())
    with pytest.raises(dl.DemlawsError, match="hertz"):
        law.joined("thornton").tabulate()


def test_overlaps_of_a_blunt_bulk_are_judged_by_its_radius():
    law = dl.law("rough-plastic", FC5, "hertz", **BLUNT)
    law.force(0.099 * 0.62e-3)
    with pytest.warns(dl.errors.LargeOverlap):
        law.force(0.101 * 0.62e-3)


@pytest.mark.parametrize("radius", [0.32e-3, math.nan, 0.0, "1s", -1.0, True])
def test_bulk_radii_that_cannot_be(radius):
    with pytest.raises(dl.DemlawsError, match="bulk_radius"):
        dl.law("rough-plastic", FC5, yield_pressure=1.66e9, bulk_radius=radius)


def test_a_contact_in_a_batch_that_is_blunter_than_the_bulk_has_no_force():
    """Radii of engines are not known when the law is made: not a number, rather than work returned."""
    from demlaws.core.dispatch import scale

    law = dl.law("rough-plastic", CONE, yield_pressure=1.66e9, bulk_radius=1.2e-3)
    for radius, wrong in ((1.2e-3, False), (1.2e-3 * (1.0 + 1e-6), True), (5e-3, True)):
        params = scale(law.curve.shape, radius, CONE.modulus, CONE.sigma)
        assert math.isnan(params.hertz_coefficient) == wrong and math.isnan(params.yield_stiffness) == wrong
