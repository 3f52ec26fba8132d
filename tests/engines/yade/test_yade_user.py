"""What surrounds the law, as a user of YADE meets it: engine lists, scenes, labels, loading, markers, the time step."""

import copy
import ctypes
import pickle
import time
import warnings

import numpy as np
import pytest
from yade_scenes import (
    FLATS,
    GRANITE,
    MODULUS,
    OVERLAP,
    acting,
    advance,
    assert_guarded,
    engine_list,
    expected,
    fixed_pair,
    force,
    functor,
    interaction_loop,
    material,
    set_engines,
    sphere,
    still,
    stops,
    under_yade,
    yade,
)

import demlaws as dl
from demlaws import yade as dy

# --- the engine list


def test_engines_are_what_the_user_wrote(omega):
    """Reading, slicing, indexing and assigning O.engines do not show the guard, which is there all the same."""
    law = functor()
    wrote = dy.engines(law)
    omega.engines = wrote
    assert [type(e) for e in omega.engines] == [type(e) for e in wrote] and omega.engines[2] is wrote[2]
    assert len(omega._currEngines) == len(wrote) + 1
    # YADE's triax tutorial, FEMxDEM's prepareRVE, apply-buoyancy-clumps
    recorder = yade.PyRunner(command="pass", iterPeriod=20)
    omega.engines = omega.engines[0:3] + [recorder] + omega.engines[3:4]  # noqa: RUF005
    assert [type(e).__name__ for e in omega.engines[2:]] == ["InteractionLoop", "PyRunner", "NewtonIntegrator"]
    omega.engines = omega.engines[:3] + omega.engines[4:]
    omega.engines = list(omega.engines)
    assert [type(e) for e in omega.engines] == [type(e) for e in wrote] and len(omega._currEngines) == len(wrote) + 1
    for engine in omega.engines:
        engine.dead = isinstance(engine, yade.PyRunner)
    omega.bodies.append(fixed_pair(material()))
    omega.dt = 1e-9
    advance(3)
    assert force() == expected()
    assert_guarded()


def test_engines_assigned_and_saved_while_it_runs(omega, tmp_path):
    """As FEMxDEM's prepareRVE does when its controller is done."""
    import __main__

    law = functor()
    still(law)

    def done():
        omega.engines = omega.engines[:3] + omega.engines[4:]
        omega.save(str(tmp_path / "x.yade"))

    __main__.done = done
    once = yade.PyRunner(command="done()", iterPeriod=1, nDo=1, initRun=True)
    omega.engines = [*omega.engines[:3], once, *omega.engines[3:]]
    advance(5)
    assert [type(e).__name__ for e in omega.engines[2:]] == ["InteractionLoop", "NewtonIntegrator"]
    assert len(omega._currEngines) == 5 and force() == expected()
    omega.load(str(tmp_path / "x.yade"))
    advance(5)
    assert len(omega._currEngines) == 5 and force() == expected()
    assert_guarded()


def test_the_guard_rests(omega):
    """It runs at the first two steps, then every hundred: the cost of a step of Python occurs in one of a hundred."""
    law = functor()
    still(law)
    advance(1001)
    assert law.binding.guards <= 13


def test_parallel_engine(omega, tmp_path):
    law = functor()
    omega.bodies.append(fixed_pair(material()))
    omega.engines = engine_list(yade.ParallelEngine([[interaction_loop(law)]]))
    assert len(omega._currEngines) == 5 and len(omega.engines) == 4
    omega.dt = 1e-9
    advance(3)
    assert force() == expected()
    omega.save(str(tmp_path / "x.yade"))
    omega.load(str(tmp_path / "x.yade"))
    advance(3)
    assert law.binding.guards >= 2 and force() == expected()
    assert_guarded()


def test_a_saved_scene_never_acts_natively(omega, tmp_path):
    """Loaded where the script does not import this package, with every PyRunner made dead: the law acts, not Mindlin's."""
    acting(functor())
    file = tmp_path / "x.yade"
    omega.save(str(file))
    text = f"""
import yade
yade.O.load({str(file)!r})
for engine in yade.O.engines:
    engine.dead = isinstance(engine, yade.PyRunner)
yade.O.run(5, True)
print("WENT ON", yade.O.interactions[0, 1].phys.normalForce.norm())
"""
    done = under_yade(text, tmp_path)
    assert float(done.stdout.split("WENT ON")[1].split()[0]) == expected(), done.stdout + done.stderr


# --- scenes


def test_scenes_keep_apart(omega, tmp_path):
    """Two scenes under one label: saved, loaded and switched, each keeps its own surfaces and its guard."""
    rough = dl.Surface(1e-5, 2.22, 6.266e9)
    acting(functor())
    omega.switchScene()
    try:
        second = functor(surfaces={"granite": rough})
        acting(second)
        assert force() == expected(1e-5)
        omega.switchScene()
        advance(3)
        omega.save(str(tmp_path / "a.yade"))
        omega.load(str(tmp_path / "a.yade"))
        advance(3)
        assert force() == expected()
        omega.switchScene()
        advance(3)
        assert force() == expected(1e-5)
        assert_guarded()
    finally:
        omega.reset()


def test_a_law_in_two_scenes_stops_the_first(omega):
    """Its account of energy would mix: the scene that it left stops before its next contact."""
    law = acting(functor())
    first, second = omega.thisScene, omega.addScene()
    omega.switchToScene(second)
    acting(law)
    assert force() == expected()
    omega.switchToScene(first)
    stops("used in another scene")
    omega.reset()
    acting(law)
    assert force() == expected() and law.totals().dissipated > 0


# --- labels


@pytest.mark.parametrize(
    ("surfaces", "why"),
    [({"granit": GRANITE}, "label 'granit'.*'granite'"), (None, "no surface was given.*'granite'")],
)
def test_smooth_contacts_of_a_rough_law_are_an_error(omega, surfaces, why):
    still(functor(surfaces=surfaces, label="unsaid"))
    stops(why)


def test_a_surface_for_bodies_that_come_later(omega):
    """A label of a material in the scene is not a typing error, though no body has it yet."""
    floor, later = material("floor"), material("later")
    law = functor(surfaces={"granite": GRANITE, "later": dl.Surface(1e-6, 2.3)})
    still(law)
    omega.bodies.append(sphere((0, 0, -0.02 + OVERLAP), 0.01, fixed=True, material=floor))
    advance(4)
    assert sorted(law.contacts().sigma) == pytest.approx([2.4e-6, 2.4e-6 * 2**0.5])
    omega.bodies.append(sphere((0, 0, 0.04 - 2 * OVERLAP), 0.01, fixed=True, material=later))
    advance(3)
    assert sorted(law.contacts().sigma) == pytest.approx([2.4e-6, 2.6e-6, 2.4e-6 * 2**0.5])


def test_smooth_is_allowed_by_the_user(omega):
    acting(functor(surfaces=None, smooth=True))
    assert force() == pytest.approx(dl.law("hertz", dl.Contact(0.005, MODULUS)).force(OVERLAP), rel=1e-13)


def test_one_surface_for_all_materials(omega):
    """YADE's examples have materials without labels."""
    acting(functor(surfaces=GRANITE), label="")
    assert force() == expected()
    omega.saveTmp()
    omega.loadTmp()
    advance(3)
    assert force() == expected()


@pytest.mark.native_step
@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy, lambda law: pickle.loads(pickle.dumps(law))])
def test_a_copy_is_the_same_law(omega, copied):
    """A copy by YADE's own functions would be smooth Hertz: 34.1 N for 6.67."""
    from demlaws.yade.saving import same_law

    law = acting(functor(label="first", neverErase=True))
    other = copied(law)
    assert other.label == "first" and other.neverErase
    assert other.binding is not law.binding and same_law(other.binding, law.binding)
    omega.reset()
    acting(other)
    assert force() == expected()
    assert other.totals().dissipated == pytest.approx(other.contacts().dissipated[0], rel=1e-12)  # of this scene alone


# --- false alarms and markers


def test_scaled_stiffness_is_no_alarm(omega):
    """TriaxialStressController with internalCompaction scales kn; what derives from MindlinPhys is another law's."""
    law = acting(functor())
    omega.interactions[0, 1].phys.kn *= 1.5
    law.binding.verify()
    advance(3)
    assert force() == expected()


def test_one_functor_for_a_kind_of_contact(omega):
    """Of functors for the same contacts YADE lists one and asks another: the native law would act, or a functor without a
    scene, which ends the process. Two loops compute every contact twice."""
    law = functor()
    second = functor("hertz", "elastic", label="second")
    mindlin, linear = yade.Law2_ScGeom_MindlinPhys_Mindlin(), yade.Law2_ScGeom_MindlinPhys_HertzWithLinearShear()
    cundall = yade.Law2_ScGeom_FrictPhys_CundallStrack()
    for functors in ((law, mindlin), (mindlin, law), (law, second), (law, linear), (linear, law)):
        with pytest.raises(dl.DemlawsError):
            omega.engines = engine_list(interaction_loop(*functors))
    for functors in ((law, law), (law, second), (law, cundall)):
        with pytest.raises(dl.DemlawsError):
            omega.engines = engine_list(*map(interaction_loop, functors))
    assert law.binding.scene is None
    with pytest.raises(dl.DemlawsError):
        set_engines(law, physics=yade.Ip2_FrictMat_FrictMat_FrictPhys())
    dead = interaction_loop(cundall)
    dead.dead = True
    still(law)
    omega.engines = engine_list(interaction_loop(law, law), dead)
    advance(3)
    assert omega.forces.f(1)[2] == expected()


@pytest.mark.parametrize("wrong", [{"young": -1e9}, {"poisson": 1.0}, {"poisson": 0.7}, {"young": float("inf")}])
def test_an_invalid_modulus_stops(omega, wrong):
    """By YADE's own law these contacts attract, without a message."""
    still(functor(), **wrong)
    stops("granite")
    functor(label="later")  # can be made while such bodies are in the scene


def test_a_modulus_typed_in_gpa_stops(omega):
    still(functor(), young=60.6)
    stops("granite")


# --- after loading


def test_right_at_once_after_loading(omega, tmp_path):
    import builtins

    law = acting(functor())
    omega.bodies[1].state.pos = (0, 0, 0.02 - 0.5 * OVERLAP)
    advance(3)
    totals, state = law.totals(), law.contacts()
    assert state.branch.tolist() == [1] and totals.dissipated > 0
    omega.save(str(tmp_path / "x.yade"))
    advance(2)
    omega.load(str(tmp_path / "x.yade"))
    assert law.totals() == totals
    assert law.contacts().force == pytest.approx(state.force, rel=1e-14)
    assert state.conductance == pytest.approx(state.stiffness / state.modulus)
    assert builtins.demlaws is law and type(omega.engines[2].lawDispatcher.functors[0]) is type(law)
    again = functor()
    set_engines(again, 1e-9)  # load, then define the engines: YADE's standard way
    advance(3)
    assert again.totals() == pytest.approx(totals, rel=1e-12) and law.totals() == again.totals()
    assert again.contacts().maximum_overlap[0] == pytest.approx(OVERLAP, rel=1e-9)
    with pytest.raises(dl.DemlawsError):
        set_engines(functor(surfaces={"granite": dl.Surface(1e-6, 2.22)}), 1e-9)


# --- sizes, flats


OF_YADE = {"facet": 2 / 3, "wall": 0.5, "box": 0.5}


def on_flat(flat):
    stone = material()
    yade.O.bodies.append(FLATS[flat](yade.utils, stone))
    yade.O.bodies.append(yade.utils.sphere((0, 0, 0.01 - OVERLAP), 0.01, fixed=True, material=stone))


@pytest.mark.parametrize("flat", FLATS)
def test_a_sphere_on_a_flat_has_its_own_radius(omega, flat):
    for flats, share in (("plane", 1.0), ("yade", OF_YADE[flat])):
        omega.reset()
        on_flat(flat)
        set_engines(functor(flats=flats), 1e-9)
        advance(3)
        assert force() == expected(radius=0.01 * share)


@pytest.mark.parametrize("flat", ["facet", "wall"])
def test_hertzian_flats_are_understood(omega, flat):
    """hertzian=True: YADE gives R = r, which the law must serve."""
    on_flat(flat)
    geometries = [yade.Ig2_Facet_Sphere_ScGeom(hertzian=True), yade.Ig2_Wall_Sphere_ScGeom(hertzian=True)]
    for flats in ("plane", "yade"):
        law = functor(flats=flats)
        set_engines(law, 1e-9, geometries=geometries)
        advance(3)
        assert law.contacts().radius[0] == pytest.approx(0.01, rel=1e-7) and law.contacts().force[0] > 0
        omega.interactions.clear()


# --- the time step


@pytest.mark.parametrize("share", [0.1, 0.5])
def test_the_stepper_is_bounded(omega, share):
    """Young rough contacts are soft: 27 spheres in a box keep their energy under `engines(law, timestep=…)`."""
    from yade import geom, utils

    stone = material()
    law = functor()
    law_engines = dy.engines(law, timestep=share, newton=yade.NewtonIntegrator(damping=0))
    side = 0.03
    omega.bodies.append(geom.facetBox((side / 2,) * 3, (side / 2,) * 3, material=stone))
    generator = np.random.default_rng(1)
    for n in range(27):
        place = [0.005 * (2 * m + 1) for m in (n % 3, n // 3 % 3, n // 9)]
        omega.bodies.append(utils.sphere(place, 0.0049 * generator.uniform(0.8, 1), material=stone))
        omega.bodies[-1].state.vel = yade.Vector3(*(0.1 * generator.standard_normal(3)))
    omega.engines = law_engines
    omega.dt = 1e-7
    start = utils.kineticEnergy()
    for _ in range(20):
        advance(500)
        assert utils.kineticEnergy() <= 1.01 * start, omega.dt
    assert omega.dt <= share * 4 * utils.PWaveTimeStep() * (1 + 1e-12)


def test_a_stepper_without_a_bound_is_warned_of(omega):
    law = functor()
    stepper = yade.GlobalStiffnessTimeStepper(timestepSafetyCoefficient=0.5)
    still(law)
    with pytest.warns(dy.TimeStepWarning, match=r"bound is 4\.18e-06 s .* which is now its maxDt"):
        omega.engines = [*dy.engines(law), stepper]
    assert yade.utils.PWaveTimeStep() == pytest.approx(2.09e-6, rel=1e-3)
    assert stepper.maxDt == pytest.approx(0.5 * 4 * 2.09e-6, rel=1e-3)
    stepper.maxDt = 5e-6
    omega.engines = [*dy.engines(law), stepper]
    assert stepper.maxDt == 5e-6  # a bound of the user's own
    for wrong in ((law, 3), (law, "0.5"), ("hertz",), (None,)):  # YADE ends the process at None
        with pytest.raises(dl.DemlawsError):
            dy.engines(wrong[0], timestep=dict(enumerate(wrong)).get(1))


# --- while it runs


def test_totals_while_it_runs(omega):
    """In the simulation's own thread; elsewhere contacts would change while they are read."""
    import __main__

    law, seen = acting(functor()), []
    __main__.read = lambda: seen.append((law.totals(), len(law.contacts())))
    omega.engines = [*omega.engines, yade.PyRunner(command="read()", iterPeriod=1)]
    omega.run(10**7, False)
    try:
        while len(seen) < 2:
            time.sleep(0.01)
        for read in (law.totals, law.contacts, lambda: omega.energy, omega.saveTmp):
            with pytest.raises(dl.DemlawsError, match=r"O\.pause"):
                read()
    finally:
        omega.pause()
        time.sleep(0.5)  # the last step ends: O.reset waits for it with the lock that Python in this step needs (stock YADE)
    assert seen[-1] == (law.totals(), 1)


def test_contacts_of_a_list_with_potential_ones(omega):
    """`O.interactions.all()` holds those that do not touch yet; one contact needs no list."""
    law = functor()
    still(law)
    omega.bodies.append(sphere((0, 0, 0.0401), 0.01, fixed=True, material=omega.bodies[0].material))
    advance(3)
    assert len(omega.interactions.all()) > omega.interactions.countReal() == 1
    assert law.contacts(omega.interactions.all()).force == law.contacts(omega.interactions[0, 1]).force == law.contacts().force


# --- versions and layouts


@pytest.fixture
def bridge(omega, monkeypatch):
    """The module of the native bridge, which looks for its layout again."""
    from demlaws.yade import native

    monkeypatch.setattr(native, "_layout", None)
    return native


@pytest.mark.parametrize("name, value", [("suffix", "-trunk"), ("version", "2031.01")])
def test_another_build_or_version_passes(bridge, monkeypatch, name, value):
    """Only Debian names a build by its precision: the suffix of another build has no meaning. A version warns."""
    import yade.config

    monkeypatch.setattr(yade.config, name, value)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        functor()
        assert bridge.find_layout().slot
    assert (dy.BridgeWarning in [one.category for one in caught]) == (name == "version")


@pytest.mark.parametrize(
    "doctored", ["two places", "another class", "a moved member", "precision", "GO", "TABLE", "BODY_BY_ID"]
)
def test_a_doctored_layout_fails_closed(bridge, monkeypatch, doctored):
    import yade.config

    from demlaws.yade import search

    real, find = search.read_memory, bridge.find_member
    twice = [np.float64(value).tobytes() for value in search.SETTINGS["f8"]]

    def read(start, size, kind):
        content = real(start, size, kind).copy()
        if kind is bridge.ctypes.c_uint8 and any(value in content.tobytes() for value in twice):
            here = content.view(np.float64)
            here[-1] = here[np.isin(here, search.SETTINGS["f8"])][0]
        return content

    def moved(thing, name, *more, **options):
        kind, *shape, place = find(thing, name, *more, **options)
        return kind, *shape, place + 8 * (type(thing).__name__ == "ScGeom6D" and name == "refR2")

    changes = {
        "two places": (search, "read_memory", read),
        "another class": (search, "symbol_at", lambda location: "_ZTIN4yade5OtherE"),
        "a moved member": (bridge, "find_member", moved),
        "precision": (yade.config, "highPrecisionBits", 80),
    }
    monkeypatch.setattr(*changes.get(doctored) or (bridge, doctored, getattr(bridge, doctored) + "x"))
    with pytest.raises(bridge.BridgeUnavailable):
        bridge.find_layout()


def test_a_yade_of_one_library_is_refused(bridge, monkeypatch):
    from demlaws.yade import search

    loaded = [mapping for mapping in search._mappings() if not mapping[-1].endswith("/libpkg_dem.so")]
    monkeypatch.setattr(search, "_mappings", lambda: loaded)
    named = r"0 loaded libraries are named libpkg_dem\.so, .* of YADE 2022\.01a or newer \(up to 2021 YADE is one library\)"
    with pytest.raises(bridge.BridgeUnavailable, match=named):
        bridge.find_layout()


def with_flag(bridge, flag):
    """(functor, layout) of a YADE whose law has one flag more, True by default."""

    class Other(yade.Law2_ScGeom_MindlinPhys_Mindlin):
        def dict(self):
            return super().dict() | {flag: True}

    found = bridge.Layout.__new__(bridge.Layout)
    found.library, found.core = bridge.find_layout().library, bridge.find_layout().core
    return Other(), found


@pytest.mark.parametrize("part", ["geom", "phys"])
def test_a_class_is_known_whichever_library_has_its_virtual_table(bridge, omega, part):
    """With link-time optimisation each library may have one of its own, as the copy here."""
    from demlaws.yade.search import address, memory_at, read_memory

    omega.bodies.append(fixed_pair(material()))
    law = functor("pohrt-popov", "hertz")
    set_engines(law)
    advance(2)
    first = memory_at(address(getattr(omega.interactions[0, 1], part)))
    kept, before = first.value, omega.forces.f(1)
    table = np.array(read_memory(kept - 16, 8 * 40, ctypes.c_int64))
    first.value = table.ctypes.data + 16
    try:
        advance(2)
    finally:
        first.value = kept
    assert omega.forces.f(1) == before and before[2] > 0.0


def test_a_flag_of_another_version_may_keep_its_default(bridge, omega):
    """Only a script that changes such a flag is refused."""
    other, found = with_flag(bridge, "flagOfTomorrow")
    assert found._find_options(other) == bridge.find_layout()._find_options(yade.Law2_ScGeom_MindlinPhys_Mindlin())
    assert found.unknown == {"flagOfTomorrow": True} | bridge.find_layout().unknown


def test_a_native_law_with_a_slip_of_its_own_is_known(bridge, omega):
    """YADE 2022.01a: its law does not read shearInc, and our correction has no effect on it."""
    other, found = with_flag(bridge, "preventGranularRatcheting")
    found._find_options(other)
    assert found.own_slip and found.unknown == {"preventGranularRatcheting": True}


def test_a_flag_that_demlaws_does_not_know_is_refused(omega, bridge, monkeypatch):
    monkeypatch.setitem(bridge.find_layout().unknown, "includeMoment", False)
    refused = r"includeMoment=True .* does not know"
    with pytest.raises(dl.DemlawsError, match=refused):
        functor(includeMoment=True)
    law = functor()
    omega.bodies.append(fixed_pair(material()))
    set_engines(law)
    advance(1)
    law.includeMoment = True
    stops(refused)


def test_a_yade_of_one_library_is_named(bridge):
    with pytest.raises(bridge.BridgeUnavailable, match=r"0 loaded libraries are named libyade_all.so.*up to 2021"):
        bridge.mapped("/libyade_all.so")


# --- contacts as a table


def test_contacts_are_a_table(omega):
    """len, columns and energies of contacts; lines end at the bodies' centres, or on the wall."""
    law = functor(surfaces={"granite": dl.materials.granite})
    ids = omega.bodies.append(fixed_pair(material()))
    omega.bodies.append(yade.utils.wall((0, 0, -0.01 + 0.5 * OVERLAP), 2, material=material()))
    set_engines(law, 1e-9)
    advance(3)
    contacts, totals = law.contacts(), law.totals()
    assert len(contacts) == len(contacts.force) == 2 and len(contacts[contacts.body1 == ids[0]]) >= 1
    assert contacts.flattened.all() and contacts.bulk_yielded is None and not contacts.sliding.any()
    assert contacts.stored.sum() == pytest.approx(totals.stored) and contacts.dissipated.sum() == pytest.approx(
        totals.dissipated
    )
    assert contacts.shear_stored.sum() == totals.shear_stored and contacts.viscous.sum() == totals.viscous
    assert contacts.sigma[contacts.body2 == ids[1]] == pytest.approx(2**0.5 * dl.materials.granite.surface.roughness)
    for one in range(2):
        for number, centre in ((contacts.body1[one], contacts.centre1[one]), (contacts.body2[one], contacts.centre2[one])):
            body = omega.bodies[int(number)]
            if isinstance(body.shape, yade.Sphere):
                assert centre == pytest.approx(tuple(body.state.pos), abs=1e-12)
            else:
                assert centre[2] == pytest.approx(-0.01 + 0.5 * OVERLAP, abs=OVERLAP)


def test_sliding_contacts_are_marked(omega):
    law = acting(functor())
    omega.bodies[1].state.vel = (1.0, 0, 0)
    omega.dt = 1e-8
    advance(300)
    contacts = law.contacts()
    assert contacts.sliding.all() and contacts.shear_dissipated.sum() > 0
    friction = omega.bodies[0].material.frictionAngle
    assert contacts.shear_force[0] == pytest.approx(np.tan(friction) * contacts.force[0], rel=1e-6)


def test_lines_across_a_periodic_face(omega):
    omega.periodic = True
    omega.cell.setBox(0.05, 0.05, 0.05)
    stone = material()
    omega.bodies.append([sphere((0.025, 0.025, z), 0.01, material=stone) for z in (0.005, 0.035 + 0.5 * OVERLAP)])
    for body in omega.bodies:
        body.dynamic = False
    set_engines(law := functor(), 1e-9)
    omega.engines[1].allowBiggerThanPeriod = True
    advance(3)
    contacts = law.contacts()
    assert len(contacts) == 1
    distance = np.linalg.norm(contacts.centre1 - contacts.centre2, axis=1)
    assert distance == pytest.approx(0.02 - contacts.overlap, rel=1e-9)
