"""Drivers: paths between turning points, force control, impact, and the stable time step."""

import itertools

import numpy as np
import pytest
from examples import GRANITE, each_law_and_rule, make, quiet
from hypothesis import given, settings, strategies as st

import demlaws as dl
from demlaws import driver
from demlaws.laws.registry import registry

pytestmark = pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")

MASS = 0.01


# --- paths


@each_law_and_rule
def test_displacement_control_visits_its_turning_points(name, unloading):
    law = make(name, unloading)
    turns = [4e-6, 3.5e-6, 6e-6, 0.0, 2e-6]
    path = driver.displacement_controlled(law, turns, steps=20)
    assert path.overlap.size == 101
    np.testing.assert_array_equal(path.overlap[::20], [0.0, *turns])
    np.testing.assert_allclose(path.force[[20, 60, 100]], law.force(np.array([4e-6, 6e-6, 2e-6])), rtol=1e-12)
    assert path.force[80] == 0.0
    if unloading == "elastic":
        assert path.force[40] == pytest.approx(law.force(3.5e-6), rel=1e-12)
    else:
        assert path.force[40] <= law.force(3.5e-6) * (1 + 1e-12)


@each_law_and_rule
@given(turns=st.lists(st.floats(0.1, 100.0), min_size=1, max_size=6))
@settings(max_examples=15)
def test_force_control_reaches_its_forces(name, unloading, turns):
    """Whatever the sequence of turning points: rising ones, falling ones, the same again."""
    law = make(name, unloading)
    path = quiet(driver.force_controlled, law, turns, 7)
    asked = np.concatenate([[0.0], *(np.linspace(a, b, 8)[1:] for a, b in itertools.pairwise([0.0, *turns]))])
    # a law with a seating load carries that as soon as there is overlap, and nothing less
    seat = law.force(1e-18) if registry()[name].solved else 0.0
    reached = asked > 1.01 * seat
    np.testing.assert_allclose(path.force[reached], asked[reached], rtol=1e-8)
    assert np.all(np.diff(path.maximum_overlap) >= 0)


@each_law_and_rule
def test_force_control_begins_anew_after_a_full_opening(name, unloading):
    """An unloaded contact without plastic overlap is a new one: its force follows first loading again."""
    law = make(name, unloading)
    path = quiet(driver.force_controlled, law, [5.0, 0.0, 3.0], 4)
    assert path.force[-4:] == pytest.approx([0.75, 1.5, 2.25, 3.0], rel=1e-8)


@each_law_and_rule
def test_force_control_down_to_nothing_leaves_the_plastic_overlap(name, unloading):
    law = make(name, unloading)
    path = driver.force_controlled(law, [50.0, 0.0], steps=10)
    last = path.overlap[-1]
    if unloading == "elastic":
        assert last == pytest.approx(0.0, abs=1e-12)
    else:
        plastic = path.plastic_overlap[10]
        # below a seating load δp is negative: the contact parts there, at no force
        assert last == pytest.approx(plastic, abs=1e-12 * path.overlap.max())
    assert path.dissipated[-1] >= -1e-12 * path.work.max()


@pytest.mark.parametrize(
    "call",
    [
        lambda law: driver.impact(law, 1.0, 1.0, steps_per_contact=1),
        lambda law: driver.impact(law, 1e6, 1e6),
    ],
)
def test_bad_calls(call):
    with pytest.raises(dl.DemlawsError):
        call(make("pohrt-popov", "hertz"))


# --- impact


def test_impact_of_hertz_has_its_closed_forms():
    """Duration 2.9432 δmax/v, δmax = (15 m v²/(16 E* √R))^0.4; elastic: it rebounds as it came (Johnson 1985, 11.1)."""
    speed = 0.05
    result = quiet(driver.impact, make("hertz"), MASS, speed, 20000)
    peak = (15 * MASS * speed**2 / (16 * GRANITE.modulus * np.sqrt(GRANITE.radius))) ** 0.4
    assert result.peak_overlap == pytest.approx(peak, rel=1e-6)
    assert result.duration == pytest.approx(2.94326 * peak / speed, rel=2e-4)
    assert result.restitution == pytest.approx(1.0, abs=1e-6)
    assert result.dissipated == 0.0


def test_time_of_an_elastic_contact():
    """The integral of the law's energy: Hertz's closed form; the linear spring's half period."""
    speed = 0.05
    peak, duration = driver.elastic_contact(make("hertz"), MASS, speed)
    assert duration == pytest.approx(2.943276 * peak / speed, rel=1e-5)
    spring = dl.law("walton-braun", GRANITE, "elastic", loading_stiffness=3e6, stiffness_ratio=2.0)
    peak, duration = driver.elastic_contact(spring, MASS, speed)
    assert (peak, duration) == pytest.approx((speed * (MASS / 3e6) ** 0.5, np.pi * (MASS / 3e6) ** 0.5), rel=1e-5)


@each_law_and_rule
def test_impact_balances_its_energy(name, unloading):
    result = driver.impact(make(name, unloading), MASS, 0.05, 4000)
    assert abs(result.energy_error) < (1e-4 if registry()[name].solved else 3e-6)
    assert result.kinetic_before == pytest.approx(0.5 * MASS * 0.05**2, rel=1e-15)
    assert result.kinetic_after == pytest.approx(0.5 * MASS * result.rebound_speed**2, rel=1e-14)
    assert 0.0 < result.restitution <= 1.0 + 1e-4
    assert result.dissipated >= -1e-9 * result.kinetic_before
    if unloading == "elastic":
        assert result.dissipated == result.plastic_overlap == 0.0
    # the record is the motion: its force is the law's along its overlaps
    path = make(name, unloading).follow(result.overlap)
    np.testing.assert_allclose(result.force, path.force, rtol=1e-12)
    assert result.overlap[-1] <= 0.0 < result.overlap[-2]
    assert result.peak_force == result.force.max()


# --- time step


@each_law_and_rule
def test_timestep_of_a_body_on_a_fixed_contact(name, unloading):
    """Never above 2/ω on the stiffest branch, whose stiffness the forces give, never below half of it."""
    law, load = make(name, unloading), 50.0
    end = law.overlap(load)
    state = law.new_state(1)
    law.follow([end], state)
    # just below the turning point, where the unloading branch is stiffest; elastic laws have one branch
    place = end * (1.0 - 1e-4) if law.state_size else end * (1.0 - 1e-6)
    force = [law.follow([place * (1.0 + shift)], state.copy()).force[0] for shift in (-1e-6, 1e-6)]
    limit = 2.0 * np.sqrt(MASS / ((force[1] - force[0]) / (2e-6 * place)))
    assert 0.47 * limit < dl.timestep(law, MASS, load, other_mass=np.inf, shear_ratio=0.0) < 1.02 * limit


def test_an_impact_of_a_very_soft_metal_separates():
    """Restitution 0.003 was refused: no separation within 100,000 steps."""
    pair = dl.Contact(4.35e-3, 32.32e9)
    result = quiet(driver.impact, dl.law("thornton-ning", pair, yield_pressure=1e5), mass=1e-3, speed=2.0)
    assert 0.002 < result.restitution < 0.004
    assert result.time[-1] == pytest.approx(result.duration) and result.time.size > 100_000
    assert abs(result.energy_error) < 1e-4


def test_an_impact_is_recorded_to_its_end():
    """Also one that ends after many times the elastic duration, below a restitution of 0.1."""
    law = dl.law("thornton-ning", dl.Contact(4.35e-3, 32.32e9), yield_pressure=1e6)
    result = driver.impact(law, mass=1e-3, speed=2.0, steps_per_contact=200)
    assert result.restitution < 0.1 and len(result.time) > 4 * 200 + 16
    assert result.time[-1] == pytest.approx(result.duration, rel=1e-12)
    assert result.speed[-1] == -result.rebound_speed and result.overlap[-1] <= 0.0
