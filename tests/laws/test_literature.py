"""Laws against what their papers say: printed numbers, branches, restitution."""

import itertools
import math
import warnings

import numpy as np
import pytest
from examples import GRANITE, PLASTIC, make, quiet
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


JOINTS = {0.0: (4.14, -7.0), 0.2: (2.54, -2.6), 0.3: (2.01, -0.5), 0.4: (1.59, -1.5), 0.5: (1.26, -3.4)}
"""ν → joint of Jackson & Green's branches over ω_c, and largest difference from the printed law [%], as documented."""


@pytest.mark.parametrize("poisson", JOINTS)
def test_joint_of_jackson_and_green(poisson):
    """Printed: Hertz below 1.9 ω_c, the plastic equation above."""
    strength, modulus, radius = 2e8, 1e11, 1e-3
    constraint = 1.295 * math.exp(0.736 * poisson)
    critical = (math.pi * constraint * strength / (2.0 * modulus)) ** 2 * radius
    force = 4.0 / 3.0 * (radius / modulus) ** 2 * (math.pi * constraint * strength / 2.0) ** 3
    w = np.concatenate([np.geomspace(1.0, 110.0, 400), 1.9 * np.array([1.0 - 1e-9, 1.0 + 1e-9])])
    a = np.sqrt(w * critical / radius * (w / 1.9) ** (0.14 * math.exp(23.0 * strength / modulus)))
    hardness = 2.84 * (1.0 - np.exp(-0.82 * a**-0.7))
    plastic = np.exp(-0.25 * w ** (5 / 12)) * w**1.5 + 4.0 * hardness / constraint * (1.0 - np.exp(-(w ** (5 / 9)) / 25.0)) * w
    law = dl.law("jackson-green", dl.Contact(radius, modulus), yield_strength=strength, poisson=poisson, unloading="elastic")
    difference = 100.0 * (law.force(w * critical) / (force * np.where(w < 1.9, w**1.5, plastic)) - 1.0)
    joint, largest = JOINTS[poisson]
    assert law.kinks()[0] / critical == pytest.approx(joint, abs=0.006)
    assert difference[np.argmax(np.abs(difference))] == pytest.approx(largest, abs=0.06)
    outside = (w < min(joint, 1.9) - 0.01) | (w > max(joint, 1.9) + 0.01)
    assert np.max(np.abs(difference[outside])) < 1e-9


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


@pytest.mark.parametrize(("w", "residual"), [(3.0, 0.10), (10.0, 0.29), (30.0, 0.50), (80.0, 0.63)])
def test_rule_etsion_is_hertz_through_force_and_contact_radius(w, residual):
    """With Kogut & Etsion's force 1.03 w^1.425, 1.40 w^1.263 and area 0.93 w^1.136, 0.94 w^1.146 over those at ω_c."""
    force = 1.03 * w**1.425 if w < 6.0 else 1.40 * w**1.263
    area = 0.93 * w**1.136 if w < 6.0 else 0.94 * w**1.146
    options = PLASTIC["kogut-etsion"] | {"poisson": 0.3}
    law = dl.law("kogut-etsion", GRANITE, "etsion", **options)
    exact = REFERENCES["kogut-etsion"](GRANITE.radius, GRANITE.modulus, **options)
    path = law.follow([w * float(exact.critical)])
    found = path.plastic_overlap[0] / path.overlap[0]
    assert found == pytest.approx(residual, abs=0.006)  # as documented
    assert found == pytest.approx(1.0 - force / (w * math.sqrt(area)), abs=0.01)


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


@pytest.mark.parametrize("constant", [CONTINUOUS, PRINTED])
def test_energy_across_the_branches_of_bahrami(constant):
    """∫P dδ piece by piece, with the jump of the force at the joint."""
    law = dl.law("bahrami", GRANITE, constant=constant)
    (kink,) = law.kinks()
    for low, high in ((kink * 1e-3, kink * (1 - 1e-9)), (kink * (1 + 1e-9), 3 * kink), (kink * 1e-3, 3 * kink)):
        pieces = [low, high] if high < kink or low > kink else [low, kink * (1 - 1e-9), kink * (1 + 1e-9), high]
        work = 0.0
        for a, b in itertools.pairwise(pieces):
            x, w = np.polynomial.legendre.leggauss(60)
            work += 0.5 * (b - a) * np.sum(w * law.force(0.5 * (a + b) + 0.5 * (b - a) * x))
        assert law.energy(high) - law.energy(low) == pytest.approx(work, rel=1e-6)


@pytest.mark.parametrize("name", ["walton-braun", "luding"])
def test_slopes_of_straight_unloading_beside_a_table(name):
    """Over E* √(R length), larger by the table's error, so that no table is stiffer in loading than in unloading."""
    law, length = make(name), 3e-6
    p, unit = law.params, GRANITE.modulus * math.sqrt(GRANITE.radius * length)
    found = law.definition.rules.numbers(p, length, 0.25)
    expected = p.first_stiffness, p.stiffening * length, p.largest_stiffness
    assert list(found.values()) == pytest.approx([1.25 * value / unit for value in expected], rel=1e-14)


@pytest.mark.parametrize("options", [*({"stiffness_ratio": ratio} for ratio in (1.0, 2.0, 10.0)), {"growth": 2e4}])
@pytest.mark.parametrize("speed", [0.01, 1.0])
def test_restitution_of_walton_and_braun(options, speed):
    """e² = k1/k2 (Walton & Braun 1986), where k2 grows: k1/(k1 + S Pmax), Pmax = v √(m k1)."""
    law = dl.law("walton-braun", GRANITE, loading_stiffness=3e6, **options)
    ratio = options.get("stiffness_ratio", 1.0 + 2e4 * speed * math.sqrt(1e-3 / 3e6))
    assert quiet(dl.driver.impact, law, 1e-3, speed, 4000).restitution == pytest.approx(math.sqrt(1 / ratio), rel=2e-6)
