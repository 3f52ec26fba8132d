"""Rough-plastic: yield of the granite cones, what yielding leaves, and 50-digit references."""

import math

import numpy as np
import pytest
from examples import quiet, shared

import demlaws as dl
from demlaws.errors import NotPassive

CONE = dl.Contact(radius=0.96e-3, modulus=32.32e9, roughness=5.04e-6, fractal_dimension=2.25, hardness=6.266e9)


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


def measured(load, stiffness, contact=CONE):
    """Options of a contact that was seen to yield at this load [N] and to keep this stiffness [N/m] from there."""
    pressures = {
        "yield_pressure": float(dl.regime.hertz_pressure(contact, load)),
        "post_yield_pressure": stiffness / (math.pi * contact.radius),
    }
    return {"yield_at": "load", **pressures}


@pytest.mark.parametrize("loading", ["hertz", "pohrt-popov"])
def test_a_yield_load_and_a_stiffness_of_their_own(loading):
    """RFC10 as measured: the rough law to the yield load, then the stiffness that was seen, which one p_y cannot both give."""
    law = dl.law("rough-plastic", CONE, "hertz", loading=loading, **measured(20.8, 5e6))
    rough = dl.law(loading, CONE)
    kink = law.kinks()[-1]
    assert law.force(kink) == pytest.approx(20.8, rel=1e-12)
    assert law.overlap(20.8) == pytest.approx(rough.overlap(20.8), rel=1e-12)
    np.testing.assert_allclose(quiet(law.stiffness, kink * np.array([1.001, 2.0, 9.0])), 5e6, rtol=1e-12)
    force = 20.8 + 5e6 * kink
    assert quiet(law.force, 2.0 * kink) == pytest.approx(force, rel=1e-12)
    assert quiet(law.energy, 2.0 * kink) == pytest.approx(rough.energy(kink) + 0.5 * (20.8 + force) * kink, rel=1e-12)
    before = np.array([0.5, 0.999]) * kink
    np.testing.assert_allclose(quiet(law.force, before), rough.force(before), rtol=1e-12)


def test_yield_loads_and_stiffnesses_of_other_radii():
    """P_y = π³R²p_y³/(6E*²) and K_y = π R p_K: for many contacts, of the rough law at that load."""
    many = CONE.with_values(radius=np.array([0.96e-3, 0.33e-3]))
    law = dl.law("rough-plastic", many, "thornton", yield_pressure=1.66e9, yield_at="load", post_yield_pressure=1.5e9)
    for n, radius in enumerate(many.radius):
        load = math.pi**3 * radius**2 * 1.66e9**3 / (6 * many.modulus**2)
        stiffness = math.pi * radius * 1.5e9
        kink = dl.law("pohrt-popov", contact := CONE.with_values(radius=radius)).overlap(load)
        expected = {"yield_force": load, "yield_stiffness": stiffness, "yield_overlap": kink}
        for name, value in (expected | {"yield_area": dl.law("hertz", contact).overlap(load)}).items():
            assert getattr(law.params, name)[n] == pytest.approx(value, rel=1e-12), name


def test_measured_yield_that_cannot_be():
    # a stiffness that jumps above Hertz's at the yield load by 1e-4 would return work, however narrow that step
    stiffness = 1.0001 * (6 * 20.8 * CONE.radius * CONE.modulus**2) ** (1 / 3)
    with pytest.raises(NotPassive):
        dl.law("rough-plastic", CONE, "hertz", **measured(20.8, stiffness))
