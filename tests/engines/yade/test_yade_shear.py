"""Shear in YADE: K_t, the shear force along paths, regular arrays."""

import json
import math
from typing import NamedTuple

import numpy as np
import pytest
from examples import shared
from shear_paths import GRANITE_RATIO, PATHS, overlaps_at
from yade_scenes import GRANITE, POISSON, YOUNG, functor, material, set_engines, sphere, yade

import demlaws as dl
from demlaws.core.dispatch import _KERNELS, bind
from demlaws.core.shear import SPRINGS
from demlaws.core.unloading import RULES, Hertz, Rule, own_rule
from demlaws.driver import sheared
from demlaws.laws import registry
from demlaws.laws.definition import Advice, Rules
from demlaws.make import example_law
from studies.validation import engines
from studies.validation.jobs import collision_jobs

pytestmark = pytest.mark.releases

CHOICES = ("elastic", "loading")
RADIUS = 0.01
MODULUS = YOUNG / (1 - POISSON**2) / 2
PAIR = GRANITE.combined(GRANITE)
CONTACT = dl.Contact(RADIUS / 2, MODULUS, PAIR.roughness, PAIR.fractal_dimension, PAIR.hardness)


def pair_of_spheres(law, friction=14.0):
    """Two spheres that a test leads along a path."""
    omega = yade.O
    omega.reset()
    stone = material(friction=math.atan(friction))
    for height in (0.0, 2 * RADIUS):
        omega.bodies.append(sphere((0, 0, height), RADIUS, fixed=True, material=stone))
    set_engines(law, 1.0)


def lead(overlaps, displacements, start=(0.0, 0.0)):
    """Lead the spheres along a path; displacements [m] in one or two directions. For each point: overlap, K_t, both elastic
    shear forces, normal force."""
    omega, rows, former = yade.O, [], np.array(start)
    plane = np.array([np.broadcast_to(place, 2) * ((1.0, 0.0) if np.ndim(place) == 0 else 1.0) for place in displacements])
    for overlap, place in zip(overlaps, plane, strict=True):
        omega.bodies[1].state.pos = yade.Vector3(0, 0, 2 * RADIUS - overlap)
        # YADE takes the shear of bodies that are as far apart as the sum of their radii, against ratcheting
        step = (place - former) * (1 - overlap / (2 * RADIUS))
        omega.bodies[1].state.vel, former = yade.Vector3(*step, 0), place
        omega.step()
        contact = omega.interactions[0, 1]
        phys = contact.phys
        rows.append(
            (contact.geom.penetrationDepth, phys.ks, phys.shearElastic[0], phys.shearElastic[1], phys.normalForce.norm())
        )
    return np.array(rows).T


def taken_along(law, overlaps, displacements, friction=14.0):
    """Two spheres led along a path: K_t, elastic shear force and normal force of their contact at each point."""
    pair_of_spheres(law, friction)
    reached, stiffness, shear, _, normal = lead(overlaps, displacements)
    return reached, stiffness, shear, normal


def test_tangential_stiffness_through_a_reversal(omega):
    """K_t is continuous where the tangent jumps, from 1.24 N/µm on first loading to 3.03 just below."""
    one = example_law("pohrt-popov", dl.Contact(RADIUS / 2, MODULUS, 2.4e-6, 2.22, 6.266e9), "hertz")
    surfaces = {"granite": dl.Surface(2.4e-6 / 2**0.5, 2.22, 6.266e9)}
    deep = 2.2657e-6
    path = np.array([0.5, 1.0, 1.0 - 1e-10, 0.8, 1.0 - 1e-10, 1.0 + 1e-10, 1.2]) * deep
    for choice in CHOICES:
        reached, stiffness, _, _ = taken_along(functor(surfaces=surfaces, shear=choice), path, 0.0 * path)
        expected = one.shear_stiffness(reached, GRANITE_RATIO, choice)
        assert stiffness == pytest.approx(expected, rel=1e-11)
        jumps = np.abs(stiffness[[2, 4]] / stiffness[[1, 5]] - 1.0)
        assert np.all(jumps < 1e-9)


@pytest.mark.parametrize(
    ("name", "rule"), shared([("pohrt-popov", "elastic"), ("pohrt-popov", "hertz")], lambda one: one[1] == "hertz")
)
def test_shear_force_is_that_of_the_passive_contact(omega, name, rule):
    """Along closed paths of normal force and displacement, which then return no work."""
    one = example_law(name, CONTACT, rule)
    for forces, displacements in PATHS.values():
        for choice in CHOICES:
            law = functor(name, rule, shear=choice)
            reached, _, shear, normal = taken_along(law, overlaps_at(one, forces), displacements)
            assert normal == pytest.approx(forces, rel=1e-9)
            mine = sheared(one, reached, displacements, GRANITE_RATIO, choice)
            assert -shear == pytest.approx(mine.shear_force, abs=1e-9 * np.abs(shear).max())
            assert np.diff(mine.dissipated).min() >= -1e-12 * mine.work.max()


def test_a_step_that_turns_a_fallen_force_round_loses_energy(omega):
    """The contact slides at 20 N, then in one long step the other way at 5 N."""
    one = example_law("hertz", CONTACT, "elastic")
    overlaps = [float(one.overlap(force)) for force in (40.0, 40.0, 10.0)]
    places = np.array([(0.0, 0.0), (2.0, 0.0), (-6.0, 0.0)]) * overlaps[0]
    law, lost = functor("hertz", "elastic"), []
    pair_of_spheres(law, friction=0.5)
    for start, end, overlap in zip([places[0], *places], places, overlaps, strict=False):
        _, _, (shear,), *_ = lead([overlap], [end], start)
        lost.append(law.totals().shear_dissipated)
    assert shear == pytest.approx(5.0, rel=1e-3) and lost[2] > lost[1] > lost[0] == 0.0


# --- levels


def oblique(law, steps=400, seed=5):
    """A random path in the tangent plane whose overlap vibrates by 1 % between larger changes: overlaps, displacements [m]."""
    generator = np.random.default_rng(seed)
    depth = float(law.overlap(40.0))
    large = np.repeat(generator.uniform(0.4, 1.0, steps // 20), 20)
    overlaps = depth * large * (1.0 + 0.01 * generator.standard_normal(steps))
    corners = np.cumsum(generator.standard_normal((steps // 10, 2)), axis=0)
    where = np.arange(steps) / 10.0
    places = np.stack([np.interp(where, np.arange(steps // 10), corner) for corner in corners.T], -1)
    return overlaps, 0.2 * depth * (places - places[0])


@pytest.mark.parametrize("levels", shared([1, None], lambda levels: levels is None))
def test_levels_are_those_of_python(omega, levels):
    """Along oblique paths under vibration, with sliding; energies, too."""
    for name, rule in [("hertz", "elastic"), ("pohrt-popov", "hertz")]:
        one = example_law(name, CONTACT, rule)
        overlaps, places = oblique(one)
        surfaces = {} if name == "hertz" else {"granite": GRANITE}
        law = functor(name, rule, surfaces, levels=levels)
        pair_of_spheres(law, friction=0.5)
        reached, _, *shear, normal = lead(overlaps, places)
        mine = sheared(one, reached, places, GRANITE_RATIO, friction=0.5, levels=levels or 3)
        expected = mine.shear_force.T
        assert -np.array(shear) == pytest.approx(expected, abs=1e-9 * np.abs(expected).max())
        share = np.hypot(*shear) / (0.5 * np.maximum(normal, 1e-300))
        assert np.any(share > 0.999) and np.any(share < 0.5)
        totals = law.totals()
        assert totals.shear_stored == pytest.approx(mine.stored[-1], rel=1e-9)
        assert totals.shear_dissipated == pytest.approx(mine.dissipated[-1], rel=0.02)


def test_shear_force_is_kept_under_vibration(omega, monkeypatch):
    """After 1,000 vibrations by 1 % a contact at half of Coulomb's limit has the force of all springs; with one level none."""
    monkeypatch.setattr("demlaws.shear.MOST_LEVELS", 300)  # as the reference
    one = example_law("pohrt-popov", CONTACT, "hertz")
    depth = float(one.overlap(40.0))
    overlaps = depth * np.concatenate([np.linspace(0.1, 1.0, 10), np.ones(10), np.tile([0.99, 1.01], 1000), [1.0]])
    places = np.zeros(len(overlaps))
    places[10:] = 0.3 * depth * np.minimum(np.arange(len(overlaps) - 10) / 10, 1.0)
    every = sheared(one, overlaps, places, GRANITE_RATIO, friction=0.5, levels=300).shear_force
    assert every[-1] > 0.9 * every[19]
    left = {}
    for levels in (1, 3):
        pair_of_spheres(functor(levels=levels), friction=0.5)
        left[levels] = -lead(overlaps, places)[2][-1] / every[-1]
    assert left[1] < 0.01 and left[3] >= 0.98


def test_levels_continue_from_a_saved_scene(omega, tmp_path):
    one = example_law("pohrt-popov", CONTACT, "hertz")
    overlaps, places = oblique(one, 100)
    whole = functor()
    pair_of_spheres(whole, friction=0.5)
    _, _, *expected, _ = lead(overlaps, places)
    pair_of_spheres(functor(levels=3), friction=0.5)
    lead(overlaps[:50], places[:50])
    omega.save(str(tmp_path / "half.xml"))
    omega.reset()
    omega.load(str(tmp_path / "half.xml"))
    _, _, *shear, _ = lead(overlaps[50:], places[50:], places[49])
    assert np.array(shear) == pytest.approx(np.array(expected)[:, 50:], rel=1e-12)


@pytest.mark.parametrize("levels", shared([1, 3, 8], lambda levels: levels == 3))
def test_no_step_of_a_random_path_creates_energy(omega, levels):
    """What the totals count as dissipated never falls, and what is stored never exceeds the work."""
    one = example_law("pohrt-popov", CONTACT, "hertz")
    overlaps, places = oblique(one, 200, seed=levels)
    law = functor(levels=levels)
    pair_of_spheres(law, friction=0.5)
    lost, work, former, start = 0.0, 0.0, np.zeros(2), places[0]
    for overlap, place in zip(overlaps, places, strict=True):
        _, _, *shear, _ = lead([overlap], [place], start)
        force = -np.array(shear)[:, 0]
        work += 0.5 * (former + force) @ (place - start)
        former, start, totals = force, place, law.totals()
        assert totals.shear_dissipated >= lost - 1e-12 * max(work, 1e-12)
        assert totals.shear_stored <= work * (1.0 + 1e-9) + 1e-18
        lost = totals.shear_dissipated
    assert lost > 0.0


@pytest.mark.parametrize(
    ("name", "rule", "shear"),
    [("hertz", "elastic", "elastic"), ("pohrt-popov", "hertz", "elastic"), ("pohrt-popov", "hertz", "loading")],
)
def test_a_gas_gains_no_energy(omega, name, rule, shear):
    """27 spheres without damping in a periodic cell, which collide and rub at ν = 0."""
    law = functor(name, rule, {} if name == "hertz" else {"granite": GRANITE}, shear=shear)
    stone, side, generator = material(friction=math.atan(1.0), poisson=0.0), 2.02 * RADIUS, np.random.default_rng(3)
    omega.periodic = True
    omega.cell.setBox(3 * side, 3 * side, 3 * side)
    for place in np.ndindex(3, 3, 3):
        body = omega.bodies[omega.bodies.append(sphere(side * (np.array(place) + 0.5), RADIUS, material=stone))]
        body.state.vel, body.state.angVel = generator.uniform(-0.1, 0.1, 3), generator.uniform(-20.0, 20.0, 3)
    set_engines(law, 2e-7)
    start, most = yade.utils.kineticEnergy(), 0.0
    for _ in range(40):
        omega.run(1000, True)
        totals = law.totals()
        most = max(most, yade.utils.kineticEnergy() + totals.stored + totals.shear_stored)
    assert 0.2 * start < yade.utils.kineticEnergy() < 0.99 * start
    assert most <= 1.001 * start


@pytest.mark.native_step
def test_levels_with_the_native_go(omega):
    """With calcEnergy YADE's own function acts; all levels follow its Coulomb limit. (Our step is no reference: where both
    differ, the self-test refuses it.)"""
    one = example_law("pohrt-popov", CONTACT, "hertz")
    overlaps, places = oblique(one)
    pair_of_spheres(functor(calcEnergy=True), friction=0.5)
    reached, _, *shear, _ = lead(overlaps, places)
    expected = sheared(one, reached, places, GRANITE_RATIO, friction=0.5).shear_force.T
    assert -np.array(shear) == pytest.approx(expected, abs=1e-9 * np.abs(expected).max())


def test_levels_turn_with_the_contact(omega):
    """Two spheres in contact that turn about each other as one body keep the size of their shear force, in its plane."""
    one = example_law("pohrt-popov", CONTACT, "hertz")
    depth = float(one.overlap(40.0))
    overlaps = depth * np.array([0.5, 1.0, 1.0, 0.9, 0.95, 1.0])
    pair_of_spheres(functor(), friction=0.5)
    _, _, *shear, _ = lead(overlaps, 0.05 * depth * np.array([0, 0, 1, 1, 2, 2]))
    first, second = omega.bodies
    turn = 1e-3
    second.state.vel = yade.Vector3.Zero
    for body in (first, second):
        body.state.angVel = yade.Vector3(0, turn, 0)
    former = yade.Vector3(0, 0, 2 * RADIUS - depth)
    for n in range(1, 1000):
        place = (2 * RADIUS - depth) * yade.Vector3(math.sin(n * turn), 0, math.cos(n * turn))
        second.state.vel, former = place - former, place  # of the half step
        second.state.pos = place
        omega.step()
    geom, phys = omega.interactions[0, 1].geom, omega.interactions[0, 1].phys
    assert geom.normal[0] > 0.8
    assert phys.shearElastic.norm() == pytest.approx(np.hypot(shear[0][-1], shear[1][-1]), rel=1e-3)
    assert abs(phys.shearElastic.dot(geom.normal)) < 2e-3 * phys.shearElastic.norm()


@pytest.mark.parametrize(
    "wrong",
    [{"levels": 0}, {"levels": 9}, {"levels": 2.5}, {"levels": True}, {"levels": "3"}, {"levels": 3, "shear": "slip"}]
    + [{"shear_ratio": value} for value in (0.0, -0.1, 1.34, math.nan, "soft")],
    ids=str,
)
def test_wrong_levels_and_ratios_are_refused(omega, wrong):
    with pytest.raises(dl.DemlawsError):
        functor(**wrong)


def test_ratio_of_stiffnesses(omega, tmp_path):
    """K_t is the given share of the stiffness of unloading, also in a saved scene."""
    one = example_law("pohrt-popov", CONTACT, "hertz")
    depth = float(one.overlap(40.0)) * np.array([0.5, 1.0, 0.9])
    pair_of_spheres(functor(shear_ratio=0.1))
    reached, stiffness, *_ = lead(depth, np.zeros(3))
    assert stiffness == pytest.approx(one.shear_stiffness(reached, 0.1), rel=1e-11)
    omega.save(str(tmp_path / "scene.xml"))
    omega.load(str(tmp_path / "scene.xml"))
    _, again, *_ = lead(depth[-1:], np.zeros(1))
    assert again == pytest.approx(stiffness[-1:], rel=1e-12)


def test_choice_is_saved_and_checked(omega):
    from demlaws.yade.pairs import Pairs
    from demlaws.yade.saving import pairs_from, pairs_text

    pairs = Pairs("pohrt-popov", {"granite": GRANITE}, "hertz", {}, shear="loading", levels=2)
    again = pairs_from(pairs_text(pairs))
    assert (again.shear_name, again.levels) == ("loading", 2) and type(again.law.shear) is type(pairs.law.shear)
    assert "shear elastic in 3 levels" in repr(functor())
    former = json.loads(pairs_text(pairs))
    del former["levels"]
    with pytest.raises(dl.DemlawsError, match="former version"):
        pairs_from(json.dumps(former))
    for wrong in ("secant", "tangent", ["elastic"]):
        with pytest.raises(dl.DemlawsError):
            functor(shear=wrong)


@pytest.mark.slow
def test_friction_limits_a_damped_contact_that_slides():
    """The dashpot of the shear force is off while the contact slides, though the normal dashpot raises Coulomb's limit."""
    (job,) = [job for job in collision_jobs("YADE") if job["restitution"] == 0.9]
    for found in engines.in_yade([job | {"motions": job["motions"][-1:], "shear": choice} for choice in ("elastic", "slip")]):
        _, away, spin = found[0]
        assert 0.95 < spin / (2.5 * job["friction"] * (5.0 + away)) < 1.005


@pytest.mark.native_step
@pytest.mark.parametrize("calc_energy", [False, True])  # True: YADE's own function acts
@pytest.mark.parametrize("shear", ["elastic", "slip"])
def test_springs_and_dashpot_together_stay_within_the_limit(omega, shear, calc_energy):
    """A ball that is pressed on and dragged sideways, with a large dashpot: YADE's own law reaches some times μN."""
    omega.reset()
    stone = material(friction=math.atan(0.3))
    omega.bodies.append([sphere((0, 0, z), RADIUS, fixed=True, material=stone) for z in (0.0, 2 * RADIUS - 1e-7)])
    physics = yade.Ip2_FrictMat_FrictMat_MindlinPhys(betan=0.1, betas=0.9)
    set_engines(functor(shear=shear, calcEnergy=calc_energy), 1e-7, physics=physics)
    omega.bodies[1].state.vel = (0.03, 0, -0.5)
    ratios, shares = [], []
    for _ in range(60):
        omega.step()
        phys = omega.interactions[0, 1].phys
        limit = phys.tangensOfFrictionAngle * phys.normalForce.norm()
        ratios.append(phys.shearForce.norm() / limit)
        shares.append(phys.shearViscous.norm() / limit)
    assert max(ratios) <= 1.0 + 1e-9
    assert sum(share > 0.05 and ratio > 1.0 - 1e-9 for share, ratio in zip(shares, ratios, strict=True)) > 5


# --- partial slip


@pytest.mark.parametrize(
    ("name", "rule"),
    shared(
        [("hertz", "elastic"), ("pohrt-popov", "elastic"), ("pohrt-popov", "hertz"), ("jackson-green", "jackson")],
        lambda pair: pair[1] != "jackson" and pair != ("pohrt-popov", "elastic"),
    ),
)
def test_partial_slip_is_that_of_python(omega, name, rule):
    """With the energies: the same springs, which are laid, lifted and divided."""
    one = example_law(name, CONTACT, rule)
    generator = np.random.default_rng(2)
    depth = float(one.overlap(60.0))
    overlaps = depth * np.concatenate([[1.0, 1.0, 1.0], generator.uniform(0.7, 1.0, 60)])
    sideways = 0.6 * depth * np.concatenate([[0.0, 0.2, 1.0], generator.uniform(-1.0, 1.0, 60)])
    surfaces = {} if name == "hertz" else {"granite": GRANITE}
    law = functor(name, rule, surfaces, shear="slip", **one.options)
    reached, _, shear, normal = taken_along(law, overlaps, sideways, friction=0.5)
    expected = sheared(one, reached, sideways, GRANITE_RATIO, "slip", friction=0.5, springs=SPRINGS)
    assert -shear == pytest.approx(expected.shear_force, abs=1e-9 * np.abs(expected.shear_force).max())
    assert np.any(np.abs(shear) < 0.2 * normal) and np.any(np.abs(shear) > 0.49 * normal)
    totals = law.totals()
    assert totals.shear_stored == pytest.approx(expected.stored[-1], rel=1e-8)
    assert totals.shear_dissipated == pytest.approx(expected.dissipated[-1], rel=1e-8)


def test_partial_slip_of_a_contact_that_grows(omega):
    """Within the error of few springs."""
    one = example_law("pohrt-popov", CONTACT, "hertz")
    forces, displacements = PATHS["wild"]
    overlaps = overlaps_at(one, forces)
    reached, _, shear, _ = taken_along(functor(shear="slip"), overlaps, displacements, friction=0.5)
    limit = sheared(one, reached, displacements, GRANITE_RATIO, "slip", friction=0.5, springs=1000)
    assert -shear == pytest.approx(limit.shear_force, abs=0.02 * 0.5 * max(forces))


class Twin(NamedTuple):
    """Hertz's rule under another name."""


def test_a_rule_of_ones_own_with_springs_slips(omega, registered_here):
    bind(Twin, **_KERNELS[Hertz])
    rule = own_rule(Rule("twin", Twin(), RULES["hertz"].state, "law", None, "as hertz", springs="hertz"))
    facts = {"unloading": ("elastic", "twin"), "rules": Rules(own=(rule,)), "advice": Advice()}
    law = registry.find("pohrt-popov")._replace(name="twins", **facts)
    dl.register(law)
    overlaps, sideways = 1e-5 * np.array([1.0, 1.0, 0.9, 0.8, 0.95]), 1e-5 * np.array([0.0, 0.2, 0.1, 0.3, 0.0])
    found = []
    for name, unloading in (("twins", "twin"), ("pohrt-popov", "hertz")):
        law = functor(name, unloading, {"granite": GRANITE}, shear="slip")
        found.append(taken_along(law, overlaps, sideways, friction=0.5)[2])
    assert np.any(found[0] != 0.0) and found[0] == pytest.approx(found[1], rel=1e-12)
