"""Friction that depends on the pressure in YADE: against native HertzMindlinCDM, against Python, saved, refused."""

import itertools
import math

import numpy as np
import pytest
from yade_scenes import (
    GRANITE,
    MODULUS,
    POISSON,
    YOUNG,
    acting,
    advance,
    engine_list,
    fixed_pair,
    functor,
    interaction_loop,
    material,
    set_engines,
    stops,
    yade,
)

import demlaws as dl
from demlaws import yade as dy
from demlaws.shear import _pressure_along

FRICTION = dl.PressureFriction(mu0=0.2, c1=0.5, c2=2e-9)
SAND = {"sigmaMax": 0.4e9, "alpha": 1.2, "c1": 0.4, "c2": 3e-9, "frictionAngle": 0.25}
STONE = {"sigmaMax": 0.6e9, "alpha": 1.1, "c1": 0.6, "c2": 1e-9, "frictionAngle": 0.3}


def crushed(**options):
    """Law conical-damage of the scene's materials."""
    return functor("conical-damage", None, None, **options)


def crushed_with_options(**options):
    """The same with options: of two materials those of the weaker and of the sharper one, without a radius."""
    strength = {name: {"strength": one["sigmaMax"], "angle": one["alpha"]} for name, one in (("sand", SAND), ("stone", STONE))}
    mixed = {name: min(strength["sand"][name], strength["stone"][name]) for name in ("strength", "angle")}
    pairs = {("sand", "sand"): strength["sand"], ("stone", "stone"): strength["stone"], ("sand", "stone"): mixed}
    law = {pair: ("conical-damage", one) for pair, one in pairs.items()}
    return functor(law, None, {"sand": dl.Surface(0.0), "stone": dl.Surface(0.0)}, smooth=True, **options)


def ramp(omega, constant, make):
    """Grains of two FrictMatCDM that are pressed down a bed of fixed ones: places and velocities, shear forces, frictions."""
    omega.reset()
    for label, values in (("sand", SAND), ("stone", STONE)):
        values = values | ({"c1": 0.0} if constant else {})
        omega.materials.append(yade.FrictMatCDM(young=YOUNG, poisson=POISSON, density=2650, label=label, **values))
    law, physics = make()
    radius, random = 0.01, np.random.default_rng(4)
    for n, (i, j) in enumerate(itertools.product(range(5), range(3))):
        place = (2.02 * radius * i, 2.02 * radius * j, 0)
        omega.bodies.append(yade.utils.sphere(place, radius, fixed=True, material=("sand", "stone")[n % 2]))
    height = math.sqrt(4.0 - 2 * 1.01**2) * radius - 1e-5
    for n, (i, j) in enumerate(itertools.product(range(3), range(2))):
        place = (2.02 * radius * (i + 0.5), 2.02 * radius * (j + 0.5), height)
        omega.bodies.append(yade.utils.sphere(place, radius, material=("sand", "stone")[(n + 1) % 2]))
        omega.bodies[-1].state.vel = (0.5 + 0.1 * random.random(), 0.1 * random.random(), -0.05)
    omega.engines = engine_list(interaction_loop(law, physics=[physics]))
    omega.engines[-1].gravity = (60.0, 0, -200.0)
    omega.dt, seen = 5e-8, []
    for _ in range(60):
        advance(20)
        rows = [(*b.state.pos, *b.state.vel, *(0.01 * b.state.angVel)) for b in omega.bodies if b.dynamic]
        pressed = [c.phys for c in omega.interactions if c.phys.normalForce.norm() > 0.0]  # of others isSliding is stale
        of_contacts = [
            (phys.shearForce.norm(), phys.tangensOfFrictionAngle, phys.isSliding, phys.R, phys.isYielding) for phys in pressed
        ]
        yielding = [[law.ratioYieldingContacts()]] if pressed else [[0.0]]
        seen.append((np.array(rows), np.array(sorted(of_contacts), float), np.array(yielding)))
    return seen


@pytest.mark.parametrize("make", [crushed, crushed_with_options])
@pytest.mark.parametrize("constant", [True, False], ids=["c1 = 0", "c1 > 0"])
def test_a_ramp_of_two_materials_is_that_of_the_native_law(omega, constant, make):
    """The script of HertzMindlinCDM with another functor: contacts of two kinds crush, slide and unload."""

    def native():
        return yade.Law2_ScGeom_MindlinPhysCDM_HertzMindlinCDM(), yade.Ip2_FrictMatCDM_FrictMatCDM_MindlinPhysCDM()

    def ours():
        with pytest.warns(dl.ValidityWarning, match="can create energy"):
            return make(shear="native"), yade.Ip2_FrictMatCDM_FrictMatCDM_MindlinPhysCDM()

    wanted, found = ramp(omega, constant, native), ramp(omega, constant, ours)
    assert sum(contacts[:, 2].any() for _, contacts, _ in wanted) > 10
    assert max(len(contacts) for _, contacts, _ in wanted) == 24
    assert sum(0.0 < yielding[0, 0] < 1.0 for _, _, yielding in wanted) > 10
    assert np.ptp(np.concatenate([contacts[:, 3] for _, contacts, _ in wanted])) > 1e-5  # radii have grown
    for now, then in zip(found, wanted, strict=True):
        assert now[1].shape == then[1].shape
        for ours_now, native_now in zip(now, then, strict=True):
            assert (np.abs(ours_now - native_now).max(0, initial=0.0) <= 1e-9 * np.abs(native_now).max(0, initial=0.0)).all()
    frictions = np.concatenate([contacts[:, 1] for _, contacts, _ in found])
    constants = {math.tan(one["frictionAngle"]) for one in (SAND, STONE)}
    assert set(np.round(frictions, 12)) == set(np.round([*constants], 12)) if constant else np.ptp(frictions) > 0.05


def strengths(law, *labels):
    """Strength and angle of a pair of labels."""
    source = law.binding.pairs.combined[law.binding.pairs.number(*labels)][1]
    return source and tuple(source.options[name] for name in ("strength", "angle"))


def test_options_that_are_not_given_are_those_of_the_materials(omega):
    """Of two FrictMatCDM the smaller, of one and another material its own, as native contacts have; given options hold."""
    both = {"sand": SAND, "stone": STONE, "": STONE}
    for label, values in both.items():
        omega.materials.append(yade.FrictMatCDM(young=YOUNG, poisson=POISSON, label=label, **values))
    omega.materials.append(yade.FrictMat(young=YOUNG, poisson=POISSON))
    sand, stone = (0.4e9, 1.2), (0.6e9, 1.1)
    for surfaces in (None, {"steel": dl.Surface(0.0)}, dl.Surface(0.0, hardness=5e9)):
        law = functor("conical-damage", None, surfaces)
        assert [strengths(law, *pair) for pair in (("sand", "sand"), ("stone", "stone"))] == [sand, stone]
        assert strengths(law, "sand", "stone") == strengths(law, "stone", "sand") == (0.4e9, 1.1)
        assert strengths(law, "sand", "steel") == strengths(law, "", "sand") == sand  # steel: FrictMat
        assert omega.materials[2].label == "FrictMatCDM 2" and omega.materials[3].label == ""
        assert strengths(law, "FrictMatCDM 2", "sand") == (0.4e9, 1.1) and strengths(law, "", "") is None
    law = functor("conical-damage", None, None, strength="1 GPa")
    assert strengths(law, "sand", "stone") == (1e9, 1.1)
    law = functor("conical-damage", None, None, strength=1e9, angle=1.0)
    assert not law.binding.pairs.of_materials and strengths(law, "sand", "") == (1e9, 1.0)


@pytest.mark.parametrize("saved", [False, True])
@pytest.mark.parametrize("late", [False, True], ids=["changed", "new"])
def test_a_strength_that_the_law_has_not_taken_stops_the_run(omega, tmp_path, late, saved):
    stone = cdm(sigmaMax=1e9, alpha=1.2)
    omega.bodies.append(fixed_pair(stone, 1e-6))
    set_engines(crushed(), 1e-9, physics=yade.Ip2_FrictMatCDM_FrictMatCDM_MindlinPhysCDM())
    advance(3)
    if saved:
        omega.save(str(tmp_path / "scene.xml"))
        omega.reset()
        omega.load(str(tmp_path / "scene.xml"))
        advance(3)
    assert dy.attached().pairs.of_materials == {"granite": {"sigmaMax": 1e9, "alpha": 1.2}}
    if late:
        new = yade.FrictMatCDM(young=YOUNG, poisson=POISSON, density=2650, label="sand", sigmaMax=1e9, alpha=1.2)
        omega.materials.append(new)
        omega.bodies[1].material = new
    else:
        omega.materials[0].sigmaMax = 2e9
    found = r"'sand' has sigmaMax = 1e\+09, and did not exist" if late else r"'granite' has sigmaMax = 2e\+09, and had 1e\+09"
    stops(found + " when the law was made", 200)


PATH = np.concatenate([np.linspace(0, 1e-5, 41)[1:], np.linspace(1e-5, 4e-6, 40), np.linspace(4e-6, 1.2e-5, 40)])


def dragged(omega, law, physics=None, surface="granite"):
    """Overlap, normal and shear force, friction of two spheres that are pressed and dragged beyond the limit."""
    stone = material(surface)
    omega.bodies.append(fixed_pair(stone, 0.0))
    set_engines(law, 1e-7, physics=physics)
    seen = []
    for overlap in PATH:
        omega.bodies[1].state.pos = (0, 0, 0.02 - overlap)
        omega.bodies[1].state.vel = (30.0, 0, 0)
        omega.step()
        contact = omega.interactions[0, 1]
        phys = contact.phys
        seen.append(
            (contact.geom.penetrationDepth, phys.normalForce.norm(), phys.shearForce.norm(), phys.tangensOfFrictionAngle)
        )
    return np.array(seen).T


@pytest.mark.parametrize("shear", ["elastic", "loading", "slip"])
@pytest.mark.parametrize("name, rule", [("pohrt-popov", "hertz"), ("hertz", "elastic"), ("rough-plastic", "thornton")])
def test_the_limit_is_that_of_python(omega, name, rule, shear):
    options = {"yield_pressure": 1e9} if name == "rough-plastic" else {}
    overlap, force, sideways, friction = dragged(
        omega, functor(name, rule, friction={"granite": FRICTION}, shear=shear, **options)
    )
    pair = dl.Contact(0.005, MODULUS, GRANITE.roughness * 2**0.5, GRANITE.fractal_dimension, GRANITE.hardness)
    law = dl.law(name, pair, rule, **options)
    expected = FRICTION.coefficient(_pressure_along(law, overlap))
    assert np.ptp(expected) > 0.05
    np.testing.assert_allclose(friction, expected, rtol=1e-12)
    slid = np.arange(len(PATH)) > 10
    np.testing.assert_allclose(sideways[slid], (friction * force)[slid], rtol=1e-9)


def test_a_damped_contact_has_the_same_coefficient(omega):
    """The limit is μ of the law's pressure times the normal force with its dashpot."""
    physics = yade.Ip2_FrictMat_FrictMat_MindlinPhys(betan=0.3, betas=0.1)
    law = functor("hertz", "elastic", friction=FRICTION)
    stone = material()
    omega.bodies.append(fixed_pair(stone, 5e-6))
    set_engines(law, 1e-7, physics=physics)
    omega.bodies[1].state.vel = (30.0, 0, -0.5)
    advance(30)
    phys, overlap = omega.interactions[0, 1].phys, omega.interactions[0, 1].geom.penetrationDepth
    hertz = dl.law("hertz", dl.Contact(0.005, MODULUS))
    assert phys.normalForce.norm() > 1.2 * hertz.force(overlap)
    friction = FRICTION.coefficient(_pressure_along(hertz, np.array([overlap])))[0]
    assert phys.tangensOfFrictionAngle == pytest.approx(friction, rel=1e-12)
    assert phys.shearForce.norm() == pytest.approx(friction * phys.normalForce.norm(), rel=1e-9)


def test_a_pair_has_its_own_or_the_smaller_of_each(omega):
    other, own = dl.PressureFriction(0.3, 0.1, 1e-9), dl.PressureFriction(0.6, 0.0, 0.0)
    surfaces = {"a": GRANITE, "b": GRANITE, "c": GRANITE}
    law = functor(surfaces=surfaces, friction={"a": FRICTION, "b": other, ("a", "*"): own})
    found = law.binding.pairs.friction
    assert found.of("b", "a") == (0.2, 0.1, 1e-9) and found.of("a", "a") == (0.2, 0.5, 2e-9)
    assert found.of("", "a") == (0.6, 0.0, 0.0)
    assert math.isnan(found.of("a", "c")[0]) and math.isnan(found.of("", "b")[0])


def test_a_saved_scene_goes_on_with_its_friction(omega, tmp_path):
    law = functor(friction={"granite": FRICTION, ("granite", "*"): dl.PressureFriction(0.1, 0.0, 0.0)})
    dragged(omega, law)
    omega.save(str(tmp_path / "scene.xml"))
    after = []
    for again in (False, True):
        if again:
            omega.reset()
            omega.load(str(tmp_path / "scene.xml"))
        omega.bodies[1].state.pos = (0, 0, 0.02 - 1.1e-5)
        omega.bodies[1].state.vel = (30.0, 0, 0)
        omega.step()
        phys = omega.interactions[0, 1].phys
        after.append((phys.tangensOfFrictionAngle, phys.shearForce.norm()))
    assert after[0] == after[1] and after[0][0] != pytest.approx(math.tan(0.5))
    restored = dy.attached().pairs.friction
    assert restored.content() == law.binding.pairs.friction.content()


@pytest.mark.parametrize(
    ("friction", "named"),
    [
        ({"granit": FRICTION}, "granite"),
        ({("granite", "granite", "granite"): FRICTION}, "not a label"),
        ({"granite": 0.5}, "must be a demlaws.PressureFriction"),
        (0.5, "frictionAngle"),
        ("constant", "'materials'"),
        (np.ones(2), "PressureFriction"),
        ({(): FRICTION}, "not a label"),
    ],
)
def test_frictions_that_are_refused(friction, named):
    with pytest.raises(dl.DemlawsError, match=named):
        functor(friction=friction)


def test_a_table_without_the_area_of_its_law_is_refused():
    """Its pressures are not known in `contacts`, either."""
    table = dl.law("kogut-etsion", dl.Contact(0.005, MODULUS), "elastic", yield_strength=0.3e9).tabulate(
        rtol=1e-4, max_force=2e3
    )
    with pytest.raises(dl.DemlawsError, match="does not contain the contact area"):
        functor(table, None, {"granite": dl.Surface(0.0)}, friction=FRICTION, smooth=True)
    law = acting(functor(table, None, {"granite": dl.Surface(0.0)}, smooth=True))
    assert math.isnan(law.contacts().mean_pressure[0]) and law.contacts().force[0] > 0.0


def test_options_of_a_pair_are_those_of_its_law():
    with pytest.raises(dl.DemlawsError, match="strengh"):
        functor({("granite", "granite"): ("conical-damage", {"strengh": 1e9, "angle": 1.2})}, None)
    law = functor({("granite", "granite"): ("conical-damage", {"angle": 1.2})}, None, strength=1e9)
    (source,) = law.binding.pairs.by_pair.values()
    assert source.options == {"strength": 1e9, "angle": 1.2}


def cdm(**values):
    stone = yade.FrictMatCDM(young=YOUNG, poisson=POISSON, frictionAngle=0.5, density=2650, label="granite", **values)
    yade.O.materials.append(stone)
    return stone


def test_materials_that_come_after_the_law_stop_the_run(omega):
    law = functor()
    omega.bodies.append(fixed_pair(cdm(sigmaMax=1e9, alpha=0.5, c1=0.4, c2=1e-9)))
    set_engines(law, 1e-9, physics=yade.Ip2_FrictMatCDM_FrictMatCDM_MindlinPhysCDM())
    stops(r'contact 0\+1 has a friction that depends on the pressure \(c1 = 0.4\).*friction="materials"')
    omega.interactions.clear()
    set_engines(functor(friction="materials"), 1e-9, physics=yade.Ip2_FrictMatCDM_FrictMatCDM_MindlinPhysCDM())
    advance(3)
    assert math.tan(0.5) < omega.interactions[0, 1].phys.tangensOfFrictionAngle < math.tan(0.5) + 0.4


def test_contacts_above_a_strength(omega):
    law = functor()
    dragged(omega, law)
    (pressure,) = law.contacts().mean_pressure
    pair = dl.Contact(0.005, MODULUS, GRANITE.roughness * 2**0.5, GRANITE.fractal_dimension)
    along = np.array([0.02 - (0.02 - overlap) for overlap in PATH])
    assert pressure == pytest.approx(_pressure_along(dl.law("pohrt-popov", pair, "hertz"), along)[-1], rel=1e-9)
    assert law.contacts().above is None
    for share, above in ((0.99, True), (1.01, False)):
        contacts = law.contacts(strength=share * pressure)
        assert contacts.above.tolist() == [above] and list(contacts["above"]) == [above]
    assert law.contacts(strength="1 kPa").above.tolist() == [True]
    with pytest.raises(dl.DemlawsError, match="strength"):
        law.contacts(strength=-1.0)


def test_another_roughness_acts_in_contacts_that_begin_later(omega):
    """A body that gets the material of another label: live contacts keep roughness and memory (docs/how-to)."""
    law = functor(surfaces={"fresh": dl.Surface(3e-6, 2.2), "worn": dl.Surface(1e-6, 2.2)})
    fresh, worn = material("fresh"), material("worn")
    omega.bodies.append(fixed_pair(fresh, 0.0))
    set_engines(law, 1e-9)

    def press(overlap):
        omega.bodies[1].state.pos = (0, 0, 0.02 - overlap)
        advance(3)
        contacts = law.contacts()
        return contacts.sigma, contacts.plastic_overlap, contacts.force

    def law_of(roughness, overlaps):
        pair = dl.Contact(0.005, MODULUS, roughness * 2**0.5, 2.2)
        return dl.law("pohrt-popov", pair, "hertz").follow([0.02 - (0.02 - overlap) for overlap in overlaps])

    press(1e-5)
    for body in omega.bodies:
        body.material = worn
    sigma, plastic, force = (float(value[0]) for value in press(8e-6))
    path = law_of(3e-6, [1e-5, 8e-6])
    assert sigma == pytest.approx(3e-6 * 2**0.5) and plastic == pytest.approx(path.plastic_overlap[-1], rel=1e-9)
    assert force == pytest.approx(path.force[-1], rel=1e-9)
    omega.bodies[1].state.pos = (0, 0, 0.021)
    advance(3)
    assert not omega.interactions.countReal()
    sigma, _, force = (float(value[0]) for value in press(8e-6))
    assert sigma == pytest.approx(1e-6 * 2**0.5) and force == pytest.approx(law_of(1e-6, [8e-6]).force[-1], rel=1e-9)


def test_a_pressure_above_the_hardness_is_warned_of_once(omega):
    law = functor("hertz", "elastic", {"granite": dl.Surface(0.0, hardness=0.3e9)}, friction=FRICTION)
    with pytest.warns(dl.ValidityWarning, match="is above the hardness 3e\\+08 Pa: the friction law") as caught:
        dragged(omega, law)
        law.totals()
        law.totals()
    assert sum("the friction law" in str(one.message) for one in caught) == 1


def test_contacts_of_the_conical_damage_model_are_read_and_saved(omega, tmp_path):
    """`contacts`, `totals` and a saved scene have those of MindlinPhysCDM with their history."""
    omega.bodies.append(fixed_pair(cdm(sigmaMax=0.4e9, alpha=1.2), 1e-5))
    law = crushed()
    set_engines(law, 1e-9, physics=yade.Ip2_FrictMatCDM_FrictMatCDM_MindlinPhysCDM())
    advance(3)
    omega.bodies[1].state.pos = (0, 0, 0.02 - 6e-6)
    advance(3)

    def seen(law):
        contacts, totals = law.contacts(), law.totals()
        return [*map(float, (contacts.force[0], contacts.plastic_overlap[0])), totals.stored, totals.dissipated]

    before = seen(law)
    alone = dl.law("conical-damage", dl.Contact(0.005, MODULUS), strength=0.4e9, angle=1.2).follow([1e-5, 6e-6])
    assert before == pytest.approx(
        [alone.force[-1], alone.plastic_overlap[-1], alone.stored[-1], alone.dissipated[-1]], rel=1e-7
    )
    assert before[1] > 1e-7 and before[3] > 0.0
    omega.save(str(tmp_path / "scene.xml"))
    omega.reset()
    omega.load(str(tmp_path / "scene.xml"))
    advance(3)
    assert seen(dy.attached()) == pytest.approx(before, rel=1e-9)
