"""Closed forms at 50 digits: sums of a pair, criterion of yield, unloading, shear, time step, asperities, Gaussian layers."""

import mpmath
import numpy as np
import pytest
from ellipsoids import ellipsoids
from examples import GRANITE
from mpmath import mp, mpf
from references import REFERENCES, Hertz

import demlaws as dl
from studies.half_space.axisymmetric import solve

pytestmark = pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")
VALUES = {"radius": GRANITE.radius, "modulus": GRANITE.modulus, "roughness": GRANITE.sigma, "fractal_dimension": 2.22}
HERTZ = Hertz(GRANITE.radius, GRANITE.modulus)


def test_sums_of_a_pair():
    """1/R, 1/E* and σ² are sums over the two bodies; α = σ (16 R E*²/(9 P²))^(1/3)."""
    bodies = ((70e9, 0.2, 3e-3, 1e-6), (210e9, 0.3, 7e-3, 3e-6))
    steel, glass = (dl.Material(young, poisson) for young, poisson, _, _ in bodies)
    pair = dl.Contact.between(steel, glass, radius1=3e-3, radius2=7e-3, roughness1=1e-6, roughness2=3e-6)
    bodies = [tuple(map(mpf, body)) for body in bodies]
    radius = 1 / sum(1 / r for _, _, r, _ in bodies)
    modulus = 1 / sum((1 - v**2) / e for e, v, _, _ in bodies)
    roughness = mpmath.sqrt(sum(s**2 for _, _, _, s in bodies))
    assert (pair.radius, pair.modulus, pair.sigma) == pytest.approx(tuple(map(float, (radius, modulus, roughness))), rel=1e-15)
    alpha = roughness * mpmath.cbrt(16 * radius * modulus**2 / (9 * mpf(25) ** 2))
    assert pair.roughness_parameter(25.0) == pytest.approx(float(alpha), rel=1e-15)


# --- criterion of bulk yield


def pressure_ratio(load):
    """p(0)/H_m with p0 = (6 P E*²/(π³ R²))^(1/3) and p(0)/p0 = 1 - exp(-2/(3 α^0.6))."""
    radius, modulus, roughness, load = map(mpf, (GRANITE.radius, GRANITE.modulus, GRANITE.sigma, load))
    pressure = mpmath.cbrt(6 * load * modulus**2 / (mp.pi**3 * radius**2))
    alpha = roughness * mpmath.cbrt(16 * radius * modulus**2 / (9 * load**2))
    return pressure * (1 - mpmath.exp(-2 / (3 * alpha ** mpf("0.6")))) / mpf(GRANITE.hardness)


def test_criterion_of_bulk_yield():
    from demlaws import regime

    for load in (0.1, 10.0, 1e3):
        assert regime.pressure_ratio(GRANITE, load) == pytest.approx(float(pressure_ratio(load)), rel=1e-13)
    assert regime.YIELD_RATIO == 0.6  # Tabor's, as both papers have it
    assert float(pressure_ratio(regime.transition_force(GRANITE))) == pytest.approx(0.6, rel=1e-12)


# --- unloading along Hertz's curve


@pytest.mark.parametrize("unloading", ["hertz", "thornton"])
@pytest.mark.parametrize("largest", [2.0, 400.0])
def test_unloading_and_loss_of_a_yielded_rough_contact(unloading, largest):
    """P = C √(R_p/R) (δ - δp)^1.5 through (δmax, Pmax); R_p/R = (a²/a_H²)^1.5, a² = a_y² + (P - P_y)/(π p_y) after yield."""
    law = dl.law("rough-plastic", GRANITE, unloading, yield_pressure=0.8e9)
    exact = REFERENCES["rough-plastic"](**VALUES, yield_pressure=0.8e9)
    top = law.overlap(largest)
    force = exact.force(top)
    yielded = mpf(top) > exact.overlap_at_yield
    assert bool(yielded) == (largest > 100.0)
    elastic = HERTZ.overlap(force)  # a_H²/R
    area = elastic
    if yielded and unloading == "thornton":
        area = HERTZ.overlap(exact.force_at_yield) + (force - exact.force_at_yield) / exact.stiffness_at_yield
    growth = (area / elastic) ** mpf("1.5")
    whole = area / growth  # δmax - δp = a²/R_p
    path = law.follow(np.array([top, top - 0.3 * float(whole), top - 1.01 * float(whole)]))
    root = mpmath.sqrt(growth)
    left = mpf(float(path.overlap[1])) - (mpf(top) - whole)
    assert path.plastic_overlap[1] == pytest.approx(float(mpf(top) - whole), rel=1e-12)
    assert path.force[1] == pytest.approx(float(root * HERTZ.force(left)), rel=1e-12)
    assert path.stiffness[1] == pytest.approx(float(root * HERTZ.stiffness(left)), rel=1e-12)
    assert path.force[2] == 0.0
    assert path.dissipated[2] == pytest.approx(float(exact.energy(top) - root * HERTZ.energy(whole)), rel=1e-11)
    state = law.new_state(1)
    law.follow([top], state)
    wanted = mpf(top) - whole + HERTZ.overlap(force / 3 / root)
    assert law.unloading_overlap(float(force) / 3, state) == pytest.approx(float(wanted), rel=1e-12)


# --- shear


def test_shear_stiffness_where_little_of_the_overlap_is_recoverable():
    """K_t = ratio × Hertz's stiffness at the force, 1.5 (C² P)^(1/3); below 1e-9 of the overlap it follows from P alone."""
    law = dl.law("pohrt-popov", GRANITE.with_values(fractal_dimension=3.0), "hertz")
    exact = REFERENCES["pohrt-popov"](**{**VALUES, "fractal_dimension": 3.0})
    recoverable = []
    for overlap in GRANITE.sigma * np.geomspace(1e-10, 10.0, 21):
        force = exact.force(overlap)
        recoverable.append(float(HERTZ.overlap(force) / mpf(overlap)))
        wanted = mpf("0.8") * HERTZ.stiffness(HERTZ.overlap(force))
        # δ - δp of overlaps that are rounded: 1e-9 of the overlap has seven digits
        assert law.shear_stiffness(overlap, 0.8) == pytest.approx(float(wanted), rel=4e-16 / max(recoverable[-1], 1e-9) + 1e-12)
    assert min(recoverable) < 1e-10 and max(recoverable) > 0.1


# --- time step


def test_timestep_of_a_body_on_a_wall():
    """0.8 × 2/ω below the resonance of velocity Verlet at √3/2; 0.56 × 2/ω where the lossless tangent falls at a kink."""
    mass, force, alone = 2e-3, 50.0, {"other_mass": float("inf"), "shear_ratio": 0.0}
    stiffness = mpmath.cbrt(6 * mpf(force) * mpf(GRANITE.radius) * mpf(GRANITE.modulus) ** 2)
    limit = float(2 * mpmath.sqrt(mpf(mass) / stiffness))
    assert dl.timestep(dl.law("hertz", GRANITE), mass, force, **alone) == pytest.approx(0.8 * limit, rel=1e-9)
    exact = REFERENCES["conical-damage"](GRANITE.radius, GRANITE.modulus, 1.66e9, 1.2)
    limit = float(2 * mpmath.sqrt(mpf(mass) / HERTZ.stiffness(exact.kinks[0])))
    law = dl.law("conical-damage", GRANITE, "elastic", strength=1.66e9, angle=1.2)
    step = dl.timestep(law, mass, 4.0 * float(exact.force(exact.kinks[0])), **alone)
    assert step == pytest.approx(0.56 * limit, rel=1e-6)


@pytest.mark.parametrize("ratio", [0.2, 6 / 7])
def test_estimates_of_the_time_step(ratio):
    """2/ω, ω² = 2/3 (1 + 1/s)/2 max((Z + 4)(1 + 2r), (Z + 2.5) 5r) K/m; Rayleigh's π R √(ρ/G)/(0.1631 ν + 0.8766)."""
    from demlaws.timestep import packing_estimate, rayleigh_step

    for coordination, size in ((6.0, 1.0), (7.5, 1.7), (4.5, 1.7)):
        r, z, s = map(mpf, (ratio, max(coordination, 6.0), size))
        square = mpf(2) / 3 * (1 + 1 / s) / 2 * max((z + 4) * (1 + 2 * r), (z + mpf("2.5")) * 5 * r) * mpf(1e6) / mpf(1e-3)
        found = packing_estimate(1e6, 1e-3, coordination, shear_ratio=ratio, size_ratio=size)
        assert found == pytest.approx(float(2 / mpmath.sqrt(square)), rel=1e-14)
    shear = mpf(60e9) / 2 / (1 + mpf(0.25))
    wave = mp.pi * mpf(2e-3) * mpmath.sqrt(2650 / shear) / (mpf("0.1631") * mpf(0.25) + mpf("0.8766"))
    assert rayleigh_step(2e-3, 2650.0, 60e9, poisson=0.25) == pytest.approx(float(wave), rel=1e-14)


# --- asperities of a measured map


@pytest.mark.parametrize("poisson", [0.0, 0.34, 0.5])
def test_sphere_between_yield_and_flow(poisson):
    """Jamari & Schipper's area and mean pressure, from p0 = K_ν H_m at ω1 to c_h H_m at ω2 = (c_A/2) ω1."""
    from demlaws.solvers import ellipsoid

    radius, modulus, hardness, flow, ratio = 2e-4, 71.3e9, 0.24e9, 0.71, 160.0
    material = ellipsoid.plasticity(modulus, hardness, poisson, flow, ratio)
    radius, modulus, hardness, flow, nu = map(mpf, (radius, modulus, hardness, flow, poisson))
    factor = mpf("0.4645") + mpf("0.3141") * nu + mpf("0.1943") * nu**2
    first = (mp.pi * factor * hardness / (2 * modulus)) ** 2 * radius
    full = first * mpf(ratio) / 2
    times = np.array([0.5, 1.5, 5.0, 30.0, 79.0, 100.0])
    radii = np.full(times.size, float(radius))
    found = ellipsoids(material, radii, radii, float(first) * times)
    np.testing.assert_allclose(found.first_yield, float(first), rtol=1e-13)
    np.testing.assert_allclose(found.full_plasticity, float(full), rtol=1e-13)
    for i in range(times.size):
        w = mpf(float(first) * times[i])
        x = min(max((w - first) / (full - first), mpf(0)), mpf(1))
        area = mp.pi * radius * w * (1 + x * x * (3 - 2 * x))
        pressure = flow - (flow - 2 * factor / 3) * mpmath.log(full / w) / mpmath.log(full / first) if w < full else flow
        force = 4 * modulus / 3 * mpmath.sqrt(radius) * w ** mpf("1.5") if w < first else pressure * hardness * area
        assert found.area[i] == pytest.approx(float(area), rel=1e-12)
        assert found.force[i] == pytest.approx(float(force), rel=1e-12)


# --- layers of Gaussian asperities


def density(z):
    return mpmath.exp(-z * z / 2) / mpmath.sqrt(2 * mp.pi)


@pytest.mark.parametrize(
    ("model", "number", "layer"),
    [
        ("yip-venart", 23.0, lambda s: mpmath.erfc(s / mpmath.sqrt(2)) / 2),
        ("greenwood-tripp", 4.0, lambda s: mpmath.quad(lambda x: x ** mpf("1.5") * density(s + x), [0, 1, 4, 20])),
    ],
    ids=["yip-venart layer", "greenwood-tripp layer"],
)
def test_tail_of_a_layer(model, number, layer):
    """At light load the bulk stays undeformed: f = (π/√2) A ∫ g(s) ds from d = -U on."""
    force = np.array([1e-9])
    separation = -float(solve(model, number, force).approach[0])
    with mpmath.workdps(15):
        load = (
            mp.pi / mpmath.sqrt(2) * number * mpmath.quad(layer, [separation, separation + 1, separation + 4, separation + 12])
        )
    assert float(load) == pytest.approx(float(force[0]), rel=1e-5)


def test_shear_ratio_of_two_materials():
    """4 G*/E*, 1/G* = Σ 2 (2 - ν)(1 + ν)/E, 1/E* = Σ (1 - ν²)/E (Mindlin 1949); 2(1 - ν)/(2 - ν) for one material."""
    from demlaws.timestep import shear_ratio

    bodies = ((70e9, 0.2), (3e9, 0.4))
    exact = [(mpf(e), mpf(v)) for e, v in bodies]
    wanted = 4 * sum((1 - v**2) / e for e, v in exact) / sum(2 * (2 - v) * (1 + v) / e for e, v in exact)
    assert shear_ratio(*(dl.Material(*body) for body in bodies)) == pytest.approx(float(wanted), rel=1e-14)
    assert shear_ratio(*2 * [dl.Material(1e9, 0.25)]) == pytest.approx(6 / 7, rel=1e-14)
