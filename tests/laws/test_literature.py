"""Laws against what their papers say: printed numbers, branches, restitution."""

import math
import warnings

import numpy as np
import pytest
from examples import GRANITE, PLASTIC, quiet
from references import REFERENCES

import demlaws as dl
from demlaws.laws.bahrami import CONTINUOUS, PRINTED
from studies.validation.published import SPEEDS, restitution_of, yield_speed

pytestmark = pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")


def test_restitution_of_thornton_and_ning():
    """e of their Eqs. 10 and 44 over V/V_y 1 to 1000; at high speed 1.185 (V_y/V)^¼."""
    contact, mass = dl.Contact(0.005, 30e9), 0.01
    pressure = 1e-3 * contact.modulus
    law = dl.law("thornton-ning", contact, yield_pressure=pressure)
    speed = yield_speed(contact, pressure, mass)
    for ratio in SPEEDS:
        found = dl.driver.impact(law, mass, ratio * speed, 40000).restitution
        assert found == pytest.approx(restitution_of(ratio), rel=1e-5)
    assert restitution_of(1000.0) == pytest.approx(1.185 * 1000**-0.25, rel=0.02)


@pytest.mark.parametrize("name", ["jackson-green", "kogut-etsion"])
def test_rule_jackson_is_the_fit_to_finite_elements(name):
    """0.52 of the largest overlap stays at 20 ω_c, where the analytic form gives 0.39 with Jackson & Green's law."""
    options = PLASTIC[name] | {"yield_strength": 1e8}
    law, exact = dl.law(name, GRANITE, "jackson", **options), REFERENCES[name](GRANITE.radius, GRANITE.modulus, **options)
    critical = float(exact.critical)
    assert law.follow([20 * critical]).plastic_overlap[0] == pytest.approx(0.5207 * 20 * critical, rel=1e-4)
    assert law.follow([critical]).plastic_overlap[0] == 0.0
    for curve, tolerance in ((law, 1e-12), (law.tabulate(1e-6), 3e-6)):
        for maximum in critical * np.array([1.2, 3.0, 20.0, 100.0, 144.0, 300.0]):
            for share in (0.99, 0.9, 0.8):
                wanted = float(exact.unloading_of_finite_elements(maximum, share * maximum))
                found = curve.follow([maximum, share * maximum]).force[1]
                assert found == pytest.approx(wanted, rel=tolerance, abs=tolerance * float(exact.force(maximum)))


@pytest.mark.parametrize(("modulus", "returns"), [(4.2e9, True), (4.45e9, False)])
def test_a_cone_that_is_too_blunt_returns_work_and_says_so(modulus, returns):
    """Stored over work of crushing: 1.2 h/(h + A), above 1 from h = 5 A on, at overlaps from 0.36 R on."""
    contact = dl.Contact(GRANITE.radius, modulus)
    law = dl.law("conical-damage", contact, "thornton", **PLASTIC["conical-damage"])
    (kink,) = law.kinks()
    h = kink / contact.radius
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        path = law.follow(kink * (1.0 + np.array([1e-9, 1e-3])))
    assert any("returns more work than crushing took" in str(one.message) for one in said) == returns
    stored, work = np.diff(path.stored)[0], np.diff(path.work)[0]
    blunting = (1.0 - math.sin(1.2)) / math.sin(1.2)
    assert stored / work == pytest.approx(1.2 * h / (h + blunting), rel=1e-3)
    assert (stored > work) == returns == bool(law.limits())


def test_branches_meet_with_the_continuous_constant():
    """a_L' of the two branches at p0' = 0.47: 2.3411 against 2.3303 as printed."""
    assert PRINTED / np.sqrt(0.47) == pytest.approx(2.3411, abs=5e-5)
    assert CONTINUOUS / np.sqrt(0.47) == pytest.approx(3.51 - 2.51 * 0.47, abs=5e-5)
    jumps = {}
    for constant in (CONTINUOUS, PRINTED):
        law = dl.law("bahrami", GRANITE, constant=constant)
        (kink,) = law.kinks()
        force = law.force(kink * np.array([1 - 1e-9, 1 + 1e-9]))
        jumps[constant] = force[1] / force[0] - 1
    assert abs(jumps[CONTINUOUS]) < 1e-4
    assert jumps[PRINTED] > 5e-3


@pytest.mark.parametrize("options", [*({"stiffness_ratio": ratio} for ratio in (1.0, 2.0, 10.0)), {"growth": 2e4}])
@pytest.mark.parametrize("speed", [0.01, 1.0])
def test_restitution_of_walton_and_braun(options, speed):
    """e² = k1/k2 (Walton & Braun 1986), where k2 grows: k1/(k1 + S Pmax), Pmax = v √(m k1)."""
    law = dl.law("walton-braun", GRANITE, loading_stiffness=3e6, **options)
    ratio = options.get("stiffness_ratio", 1.0 + 2e4 * speed * math.sqrt(1e-3 / 3e6))
    assert quiet(dl.driver.impact, law, 1e-3, speed, 4000).restitution == pytest.approx(math.sqrt(1 / ratio), rel=2e-6)
