import math
import warnings

import numpy as np
import pytest
from examples import GRANITE
from hypothesis import given, strategies as st

import demlaws as dl
from demlaws import regime
from studies.half_space.axisymmetric import solve
from studies.jamari import published

TESTS = published.published_tests()

pytestmark = pytest.mark.filterwarnings("ignore:(sigma|hardness) = :demlaws.errors.ValidityWarning")
contacts = st.builds(
    dl.Contact,
    radius=st.floats(1e-5, 1.0),
    modulus=st.floats(1e6, 1e12),
    sigma=st.floats(1e-12, 1e-7),
    hardness=st.floats(1e6, 1e11),
)


@pytest.mark.parametrize("test", TESTS, ids=[t.label for t in TESTS])
def test_printed_numbers(test):
    """α of 2006 and p(0)/H_m of 2008 as printed, to their digits."""
    if not math.isnan(test.alpha):
        assert float(test.contact.roughness_parameter(test.load)) == pytest.approx(test.alpha, abs=0.01)
    if not math.isnan(test.ratio):
        assert regime.pressure_ratio(test.contact, test.load) == pytest.approx(test.ratio, abs=0.006)


def test_the_closed_fit_and_its_range():
    """Eq. 4 against the solution for the two μ it stands for; far off beyond α = 10, where it warns."""
    alpha = np.geomspace(0.05, 2.0, 12)
    for mu in (4.0, 17.0):
        ratio = regime.pressure_drop(alpha) / regime.central_pressure(alpha, mu)
        assert np.max(np.abs(ratio - 1.0)) < 0.12
        assert 1.4 < regime.pressure_drop(20.0) / regime.central_pressure(20.0, mu) < 2.1
    with pytest.warns(dl.ValidityWarning, match="closed fit"):
        found = regime(TESTS[-1].contact, 0.2)
    assert found.roughness_parameter > 10 and "closed fit" in str(found)


def test_a_measured_yield_pressure_decides():
    """FC5 yielded at 7 N: at 20 N its bulk is not elastic, whatever its hardness says."""
    cone = dl.Contact(0.33e-3, 32.32e9, 5.04e-6, 2.22, 6.266e9)
    assert regime(cone, 20.0).deforms == "asperities"
    found = regime(cone, 20.0, yield_pressure=2.35e9)
    assert found.deforms == "bulk" and found.transition_force == pytest.approx(7.0, rel=0.01)
    assert not {a.law: a for a in regime.advise(cone, 20.0, 2.35e9)}["pohrt-popov"].fits


@pytest.mark.parametrize(
    ("share", "part"), [(0.92, "asperities"), (0.94, "both"), (1.05, "both"), (1.08, "bulk"), (0.8, "asperities")]
)
def test_shares_of_a_measured_yield_pressure(share, part):
    """p0/p_y, with the band of the criterion: 0.56 and 0.64 for 0.6 are 0.933 and 1.067 for 1."""
    contact = dl.Contact(4e-3, 32.32e9, 2e-6, 2.22)
    found = regime(contact, 20.0, yield_pressure=float(regime.hertz_pressure(contact, 20.0)) / share)
    assert found.ratio == pytest.approx(share) and found.deforms == part


@pytest.mark.parametrize("mu", [4.0, 17.0])
def test_central_pressure_is_that_of_the_solver(mu):
    """At f = 4/3 α^(-3/2): the solver of studies/half_space, which the data of the package come from."""
    for alpha in (0.09, 1.0, 20.0):
        solved = solve("greenwood-tripp", mu, np.array([4.0 / 3.0 * alpha**-1.5])).central_pressure[0]
        assert regime.central_pressure(alpha, mu) == pytest.approx(float(solved), rel=1e-4)


@given(contacts)
def test_the_answer_changes_at_the_transition(contact):
    load = regime.transition_force(contact)
    assert regime.pressure_ratio(contact, load) == pytest.approx(0.6, rel=1e-12)
    # on a nearly smooth contact the ratio says little about the roughness, so the ratio is what must agree
    rough = contact.with_values(sigma=min(regime.transition_sigma(contact, 1.5 * load), 0.5 * contact.radius))
    if rough.sigma < 0.5 * contact.radius:
        assert regime.pressure_ratio(rough, 1.5 * load) == pytest.approx(0.6, rel=1e-9)
    assert regime.pressure_ratio(contact, load * 1.01) > 0.6 > regime.pressure_ratio(contact, load * 0.99)


@pytest.mark.slow
def test_with_mu_the_answer_changes_where_the_solution_says():
    """It changed by the closed fit: below the load of this test, whose ratio is under 0.6."""
    test = next(test for test in TESTS if test.label == "Al_AB")
    found = regime(test.contact, test.load, mu=test.mu)
    assert found.ratio == pytest.approx(0.5794, abs=1e-3) and found.transition_force > test.load
    assert regime.pressure_ratio(test.contact, found.transition_force, test.mu) == pytest.approx(0.6, rel=1e-4)
    rough = test.contact.with_values(sigma=found.transition_sigma)
    assert regime.pressure_ratio(rough, test.load, test.mu) == pytest.approx(0.6, rel=1e-4)


@given(contacts, st.floats(1e-6, 1e6), st.floats(1e-6, 1e6))
def test_the_ratio_rises_with_load_and_falls_with_roughness(contact, load1, load2):
    low, high = sorted((load1, load2))
    assert regime.pressure_ratio(contact, low) <= regime.pressure_ratio(contact, high) * (1 + 1e-12)
    rougher = contact.with_values(sigma=2 * contact.sigma)
    assert regime.pressure_ratio(rougher, low) <= regime.pressure_ratio(contact, low) * (1 + 1e-12)


def test_arrays_agree_with_single_calls():
    contact = TESTS[0].contact
    loads, roughnesses = np.array([0.1, 1.0, 10.0]), np.array([1e-7, 1e-6])
    singles = [regime.pressure_ratio(contact, load) for load in loads]
    np.testing.assert_allclose(regime.pressure_ratio(contact, loads), singles, rtol=1e-12)
    many = contact.with_values(sigma=roughnesses)
    singles = [regime.transition_force(contact.with_values(sigma=r)) for r in roughnesses]
    np.testing.assert_allclose(regime.transition_force(many), singles, rtol=1e-12)


def test_advice_follows_the_regime():
    test = TESTS[-1]
    advice = {a.law: a for a in regime.advise(test.contact, test.load)}
    assert advice["asperity"].fits and not advice["rough-plastic"].fits and not advice["hertz"].fits
    advice = {a.law: a for a in regime.advise(test.contact, 100.0)}
    assert advice["rough-plastic"].fits and not advice["asperity"].fits
    assert "bulk yields" in advice["yip-venart"].reason
    bare = dl.Contact(radius=1e-3, modulus=1e9, sigma=1e-7)
    # rough granite: Hertz's and the fitted law are far off at small loads, choose finds 780 %
    advice = {a.law: a for a in regime.advise(GRANITE, 50.0)}
    assert advice["pohrt-popov"].fits and not advice["hertz"].fits and not advice["rms"].fits
    assert advice["bahrami"].fits and advice["bahrami"].reason != advice["pohrt-popov"].reason
    assert "no hardness" in {a.law: a for a in regime.advise(bare, 1.0)}["goddard"].reason


@pytest.mark.parametrize(
    "call",
    [
        lambda: regime(dl.Contact(radius=1e-3, modulus=1e9), 1.0),
        lambda: regime(TESTS[0].contact.with_values(sigma=np.array([1e-6, 2e-6])), 1.0),
    ],
)
def test_bad_input_is_named(call):
    with pytest.raises(dl.DemlawsError):
        call()


def test_hertz_on_a_rough_contact_warns():
    """It has no roughness: at 0.1 N its overlap is 0.107 µm where Pohrt & Popov's is 0.748 µm. Smooth contacts do not warn."""
    pair = dl.Contact(radius=4.35e-3, modulus=32.32e9, sigma=2.4e-6, fractal_dimension=2.22)
    with pytest.warns(dl.ValidityWarning, match="no roughness"):
        overlap = dl.law("hertz", pair).overlap(0.1)
    assert overlap == pytest.approx(0.107e-6, rel=0.01)
    (limit,) = dl.law("hertz", pair).limits()
    assert pair.roughness_parameter(limit.minimum_force) == pytest.approx(0.05)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        dl.law("hertz", pair).overlap(1.001 * limit.minimum_force)
        dl.law("hertz", pair.with_values(sigma=0.0)).overlap(0.1)
        dl.law("pohrt-popov", pair).overlap(0.1)
    with pytest.warns(dl.ValidityWarning, match="no roughness"):
        dl.law("rough-plastic", pair, loading="hertz", yield_pressure=1e9).overlap(0.1)
    many = pair.with_values(radius=np.array([1e-3, 4e-3]), sigma=np.array([0.0, 1e-6]))
    with pytest.warns(dl.ValidityWarning, match="no roughness"):
        dl.law("hertz", many).overlap(np.array([0.1, 0.1]))


def test_laws_warn_where_the_bulk_yields():
    """Every law that keeps the bulk elastic is limited by the criterion; the law in which it yields is not."""
    pair = dl.Contact(radius=0.96e-3, modulus=32.32e9, sigma=5.04e-6, fractal_dimension=2.22, hardness=6.266e9)
    load = regime.transition_force(pair)
    for name in ("hertz", "pohrt-popov", "rms"):
        limits = dl.law(name, pair).limits()
        assert any("bulk yields" in limit.reason and limit.maximum_force == pytest.approx(load) for limit in limits)
    with pytest.warns(dl.ValidityWarning, match="bulk yields"):
        dl.law("hertz", pair.with_values(sigma=0.0)).overlap(2.0 * load)
    yielding = dl.law("rough-plastic", pair, yield_pressure=1.66e9)
    assert not any("bulk yields" in limit.reason for limit in yielding.limits())


@pytest.mark.parametrize("largest", [6e3, 1e7])
def test_breaches_begin_with_the_largest_excess(largest):
    """Over or below its bound by the largest factor, whichever side it is on."""
    for name in ("hertz", "rms", "greenwood-tripp"):
        found = dl.law(name, GRANITE).breaches(1e-2, largest)
        factors = [max(b.value / b.bound, b.bound / b.value) for b in found]
        assert len(found) > 1 and factors == sorted(factors, reverse=True) and min(factors) > 1.0


@pytest.mark.parametrize(("dimension", "warned"), [(2.5, False), (2.6, True)])
def test_fractal_dimensions_beyond_those_of_the_theory(dimension, warned):
    """0.2567 Df is within 4 % of 1/(1 + H) of Pastewka et al. 2013 up to Df 2.5; beyond it a warning."""
    assert abs(0.2567 * 2.5 * (1 + 3 - 2.5) - 1) < 0.04 and abs(0.2567 * 2.8 * (1 + 3 - 2.8) - 1) > 0.13
    contact = GRANITE.with_values(fractal_dimension=dimension)
    for name, options in (("pohrt-popov", {}), ("rough-plastic", {"yield_pressure": 1.66e9})):
        law = dl.law(name, contact, **options)
        threshold = float(dl.law("pohrt-popov", contact, "elastic").limits()[-1].minimum_force)
        found = [breach for breach in law.breaches(1.0, 2.0) if "fractal dimension" in breach.reason]
        assert len(found) == warned and all(breach.bound == pytest.approx(threshold) for breach in found)


def test_the_criterion_is_a_function_with_the_others_as_attributes():
    found = dl.regime(GRANITE, "50N")
    assert found == dl.regime(GRANITE, 50.0) and found.deforms == "asperities"
    assert dl.regime.transition_force(GRANITE) == found.transition_force


def test_the_command_states_the_loads_at_which_laws_are_judged(capsys):
    """A law is judged from 0.01 of the load: α there differs from that at the load."""
    from demlaws.cli import main

    contact = ["--effective-radius", "4.35mm", "--modulus", "32.32GPa", "--sigma", "2.4um", "--hardness", "6GPa"]
    assert main(["regime", *contact, "--load", "50"]) == 0
    alpha = dl.Contact(4.35e-3, 32.32e9, 2.4e-6).roughness_parameter(0.5)
    assert f"laws from 0.5 N (α = {alpha:.3g}) to 50 N:" in capsys.readouterr().out
