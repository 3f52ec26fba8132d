"""Softer contacts: P_new(δ) = P_old(δ/s^(2/3)) for every law and rule of the registry; what cannot be softened is refused."""

import dataclasses
import itertools

import numpy as np
import pytest
from examples import GRANITE, make, overlaps, pairs, quiet, telling

import demlaws as dl
from demlaws.advice.soften import EXPONENTS, Softening
from demlaws.core.unloading import GIVEN
from demlaws.laws.definition import Advice, Option
from demlaws.laws.registry import registry
from demlaws.plugins.grains import Case, Grain
from demlaws.timestep import timestep

SOFTENED = [name for name, definition in registry().items() if not definition.advice.rigid]
EXACT = 8.0
"""A factor whose cube root and its square are powers of two: scaling by it rounds nothing."""


def _path(law):
    """Loading, unloading to nothing, reloading beyond, half back."""
    top = 0.02 * law.contact.radius
    turns = [0.0, 0.3 * top, -0.05 * top, 0.5 * top, 0.2 * top, top, 0.4 * top]
    return np.concatenate([np.linspace(a, b, 40) for a, b in itertools.pairwise(turns)])


def _same_but_stretched(law, softened, factor, rtol):
    stretch = Softening(factor).overlap
    path = _path(law)
    before, after = quiet(law.follow, path), quiet(softened.follow, path * stretch)
    scale = np.max(before.force)
    np.testing.assert_allclose(after.force, before.force, rtol=rtol, atol=rtol * scale)
    np.testing.assert_allclose(
        after.stiffness, before.stiffness / stretch, rtol=100 * rtol, atol=100 * rtol * np.max(before.stiffness) / stretch
    )
    top = stretch * np.max(path)
    for name in ("plastic_overlap", "maximum_overlap"):
        np.testing.assert_allclose(getattr(after, name), getattr(before, name) * stretch, rtol=rtol, atol=rtol * top)
    for name in ("stored", "dissipated"):
        np.testing.assert_allclose(getattr(after, name), getattr(before, name) * stretch, rtol=0, atol=10 * rtol * scale * top)


@pytest.mark.parametrize(("name", "rule"), [pair for pair in pairs() if pair[0] in SOFTENED and telling(pair)])
def test_every_law_and_rule_is_stretched(name, rule):
    """A factor that rounds nothing: equal to 1e-13; hysteresis, and the curve of rule "table", included."""
    law = make(name, rule)
    _same_but_stretched(law, dl.soften(law, EXACT), EXACT, 1e-13)


@pytest.mark.parametrize("name", SOFTENED)
def test_first_loading_is_stretched(name):
    """Force, stiffness, inverse and energy from 1e-8 σ to a tenth of the radius; also by 10, to rounding (solved: 2e-6)."""
    law = make(name)
    delta = overlaps(law) / 40.0
    for factor, rtol in ((EXACT, 1e-13), (10.0, 2e-6 if law.definition.solved else 1e-12)):
        softened, stretch = dl.soften(law, factor), Softening(factor).overlap
        np.testing.assert_allclose(quiet(softened.force, delta * stretch), quiet(law.force, delta), rtol=rtol)
        np.testing.assert_allclose(
            quiet(softened.stiffness, delta * stretch) * stretch, quiet(law.stiffness, delta), rtol=10 * rtol
        )
        np.testing.assert_allclose(quiet(softened.energy, delta * stretch), quiet(law.energy, delta) * stretch, rtol=10 * rtol)
        force = quiet(law.force, delta)
        found, seat = quiet(softened.overlap, force), rtol * softened.contact.sigma  # a small overlap is a difference
        np.testing.assert_allclose(found, quiet(law.overlap, force) * stretch, rtol=10 * rtol, atol=seat)
        back = dl.soften(softened, 1.0 / factor)
        np.testing.assert_allclose(quiet(back.force, delta), force, rtol=10 * rtol)


@pytest.mark.parametrize(
    ("name", "rule"), [("pohrt-popov", GIVEN), ("rough-plastic", "thornton"), ("goddard", "hertz"), ("yip-venart", "elastic")]
)
def test_a_table_and_its_file(name, rule, tmp_path):
    """With an unloading curve; with a yield pressure, which falls in the options of the file, too."""
    table = quiet(make(name, rule).tabulate, 1e-3)
    softened = dl.soften(dl.Table.load(table.save(tmp_path / "law.tbl")), EXACT)
    if name == "rough-plastic":
        assert softened.options["yield_pressure"] == pytest.approx(table.options["yield_pressure"] / 4)
    for one in (softened, dl.Table.load(softened.save(tmp_path / "soft.tbl"))):
        _same_but_stretched(table, one, EXACT, 1e-12)


def test_arrays_of_contacts():
    contact = GRANITE.with_values(radius=np.array([1e-3, 4e-3, 2e-2]))
    law = dl.law("pohrt-popov", contact, unloading="hertz")
    delta = np.array([1e-6, 3e-6, 5e-6])
    np.testing.assert_allclose(dl.soften(law, EXACT).force(4.0 * delta), law.force(delta), rtol=1e-14)


def test_the_stable_step_grows_by_the_cube_root():
    for name in ("hertz", "pohrt-popov", "rms"):
        law = make(name)
        steps = [quiet(timestep, one, 1e-3, 10.0) for one in (law, dl.soften(law, 27.0))]
        assert steps[1] == pytest.approx(3.0 * steps[0], rel=1e-12)


def test_factors_of_a_softening():
    scaled = Softening(8.0)
    assert (scaled.overlap, scaled.stiffness, scaled.step) == pytest.approx((4.0, 0.25, 2.0), rel=1e-14)


def test_similar_impacts_are_faster():
    """At equal force: an impact is similar at s^(1/3) times the speed, not at the same speed."""
    law, mass = dl.law("pohrt-popov", GRANITE, "hertz"), 3.7e-3
    softer = dl.soften(law, 10.0)
    whole, same, similar = (
        dl.driver.impact(one, mass, speed) for one, speed in ((law, 0.1), (softer, 0.1), (softer, 0.1 * 10.0 ** (1 / 3)))
    )
    assert similar.restitution == pytest.approx(whole.restitution, rel=1e-6)
    assert similar.peak_force == pytest.approx(whole.peak_force, rel=1e-6)
    assert same.restitution < 0.95 * whole.restitution
    effects = {quantity: times for quantity, times, _ in Softening(10.0).effects()}
    assert float(effects["speed of an impact with equal forces and restitution"]) == pytest.approx(10.0 ** (1 / 3), rel=1e-3)
    assert "force" in next(quantity for quantity, times in effects.items() if times == "1")


def test_every_measured_quantity_has_its_exponent():
    for kind, exponents in EXPONENTS.items():
        assert set(exponents) == {field.name for field in dataclasses.fields(kind)} - {"surface"}  # softened itself


def test_contacts_of_softened_grains_are_softened_contacts():
    grains = [
        Grain(4e-3, dl.Material(60e9, 0.25, 6e9, 2700.0), dl.Surface(2e-6, 2.2, 5e9)),
        Grain(5e-3, dl.Material(70e9, 0.2), dl.Surface(1e-6, 2.4)),
    ]
    softened = dl.soften(grains, 10.0)
    for wall in (False, True):
        one, other = softened[0].contact(softened[1], wall), dl.soften(grains[0].contact(grains[1], wall), 10.0)
        for field in dataclasses.fields(one):
            assert getattr(one, field.name) == pytest.approx(getattr(other, field.name), rel=1e-13), field.name
    assert softened[0].mass == grains[0].mass
    case = dl.soften(Case("rough-plastic", tuple(grains[:1]), "thornton", {"yield_pressure": 1.6e9}), EXACT)
    assert case.options == {"yield_pressure": 0.4e9} and case.grains[0].material.young == 60e9 / 8
    assert dl.soften({"ballast": dl.Surface(2e-6)}, EXACT) == {"ballast": dl.Surface(8e-6)}


def test_a_softened_scene_has_the_same_forces():
    scene = dl.Scene(
        radii=4e-3,
        materials=dl.Material(60e9, 0.25, 6e9),
        surfaces=dl.Surface(2e-6, 2.2),
        pressure=1e5,
        yield_pressure=1.6e9,
        reference="goddard",
        reference_options={"slope": 0.035},
    )
    softened = dl.soften(scene, EXACT)
    one, other = scene.contacts(2e-3)[0], softened.contacts(2e-3)[0]
    assert other.modulus == one.modulus / 8 and other.sigma == pytest.approx(4 * one.sigma)
    assert softened.force_range(other) == scene.force_range(one)
    assert softened.yield_pressure == pytest.approx(scene.yield_pressure / 4)
    assert np.tan(softened.reference_options["slope"]) == pytest.approx(2.0 * np.tan(0.035))


def test_what_cannot_be_softened(monkeypatch):
    with pytest.raises(dl.DemlawsError):
        dl.soften(GRANITE, 1e6)
    with pytest.raises(dl.DemlawsError):
        dl.soften(3.0, 10.0)
    with pytest.raises(dl.DemlawsError):
        dl.soften(dl.Table.from_function(lambda d: 3e9 * d**1.5, GRANITE, name="mine", rtol=1e-2), 10.0)
    law = make("goddard")
    definition = law.definition
    rigid = definition._replace(advice=Advice(rigid="its gap of 1 nm is no length of the surface"))
    monkeypatch.setattr("demlaws.advice.soften.find", lambda name: rigid)
    with pytest.raises(dl.DemlawsError):
        dl.soften(law, 10.0)
    unsaid = definition._replace(options={"slope": Option("m", "above 0", "a length of which nothing is said")})
    monkeypatch.setattr("demlaws.advice.soften.find", lambda name: unsaid)
    with pytest.raises(dl.DemlawsError):
        dl.soften(law, 10.0)
