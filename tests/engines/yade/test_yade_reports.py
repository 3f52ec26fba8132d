"""Reports to the YADE user: limits of laws, inadmissible input, large overlaps, engines that are not served, energies."""

import dataclasses
import re
import warnings
from pathlib import Path

import numpy as np
import pytest
from yade_scenes import (
    FLATS,
    GRANITE,
    MODULUS,
    SURFACES,
    acting,
    advance,
    fixed_pair,
    force,
    functor,
    interaction_loop,
    material,
    set_engines,
    sphere,
    stops,
    two_spheres,
    yade,
)

import demlaws as dl
from demlaws import yade as dy
from demlaws.errors import TimeStepWarning
from demlaws.timestep import STEP_SAFETY, packing_estimate
from studies.extremes import extremes, report

pytestmark = pytest.mark.releases

ROOT = Path(__file__).parents[3]


def issued(run):
    """Texts of the ValidityWarnings that `run` causes."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        run()
    return [str(one.message) for one in caught if issubclass(one.category, dl.ValidityWarning)]


def test_a_limit_of_the_law_is_reported_once_with_the_worst_contact(omega):
    soft = dl.Surface(2.4e-6, 2.22, 1e9)
    pair = soft.combined(soft)
    contact = dl.Contact(0.005, 60.6e9 / (2 * (1 - 0.25**2)), pair.roughness, pair.fractal_dimension, pair.hardness)
    limit = dl.law("pohrt-popov", contact).limits()[0].maximum_force
    law = functor(surfaces={"granite": soft})
    two_spheres(law, speed=-1.0)
    for x in (0.1, 0.2):
        omega.bodies.append(fixed_pair("granite", 3e-5 * x, x=x))
    texts = issued(lambda: (advance(280), law.totals(), advance(20), law.contacts()))
    (text,) = (text for text in texts if "0.6 H_m" in text)
    assert "1 of 3 contacts are above" in text and "0+1" in text and f"above {limit:.3g} N" in text
    omega.reset()
    two_spheres(functor(surfaces={"granite": soft}), speed=-0.05)
    assert not issued(lambda: advance(300)) and force() < limit


def test_roughness_beside_the_radius(omega):
    """Both the combined value and what was typed are shown."""
    two_spheres(functor(surfaces={"granite": dl.Surface(5e-4, 2.22)}), speed=-0.3)
    (text,) = issued(lambda: advance(200))
    assert "0.141 times the radius 0.005 m" in text and "Sq = 0.0005 m and 0.0005 m" in text
    omega.reset()
    two_spheres(functor(surfaces={"granite": dl.Surface(2.4e-3, 2.22)}), speed=-0.3)
    stops(r"0\.679 times the radius 0\.005 m", 200)
    omega.reset()  # rocks
    two_spheres(functor(surfaces={"granite": dl.Surface(5e-3, 2.22)}), speed=-10.0, radius=1.0)
    assert not [text for text in issued(lambda: advance(200)) if "times the radius" in text] and force() > 0


def test_numbers_in_other_units_are_named(omega):
    """Radii in mm, a friction angle in degrees (tan 30 rad is -6.4), a sphere without a radius."""
    law, stone = functor(), material(friction=30.0)  # a law that is made beside the bodies warns at once
    omega.bodies.append([yade.utils.sphere((0, 0, z), 10.0, fixed=True, material=stone) for z in (0, 19.999)])
    set_engines(law, 1e-9)
    with pytest.warns(dl.ValidityWarning) as seen:
        advance(20)
    for words in ("did you mean mm", "frictionAngle = 30 rad"):
        assert sum(words in str(one.message) for one in seen) == 1
    omega.reset()
    two_spheres(functor(), gap=-1e-4)
    omega.bodies[1].shape.radius = 0.0
    omega.bodies[1].state.pos = (0, 0, 0.0099)
    stops("radius = 0 m", 20)


def test_engines_within_an_integrator_are_refused(omega):
    """They compute contacts at trial positions; without a guard a contact has no force rather than native Mindlin's."""

    def engines_of(law):
        collider = yade.GeneralIntegratorInsertionSortCollider([yade.Bo1_Sphere_Aabb()])
        return [yade.ForceResetter(), collider, interaction_loop(law)]

    two_spheres(yade.Law2_ScGeom_MindlinPhys_Mindlin(), gap=-1e-6)
    law = functor()
    with pytest.raises(dl.DemlawsError, match="RungeKuttaCashKarp54Integrator computes contacts several times"):
        omega.engines = [yade.RungeKuttaCashKarp54Integrator(engines_of(law))]
    integrator = yade.RungeKuttaCashKarp54Integrator([])
    integrator.rel_err = integrator.abs_err = 1e-6
    omega.engines = [integrator]
    integrator.slaves = engines_of(law)
    omega.step()
    assert not np.isfinite(force())
    with pytest.raises(dl.DemlawsError, match="contact 0\\+1"):
        law.totals()


def test_a_functor_that_is_assigned_to_the_dispatcher_needs_the_engine_list(omega):
    law = functor()
    two_spheres(yade.Law2_ScGeom_MindlinPhys_Mindlin())
    omega.engines[2].lawDispatcher.functors = [law]
    with pytest.raises(dl.errors.EngineStopped, match=r"given to a dispatcher.*O\.engines = O\.engines"):
        omega.run(1, True)
    omega.engines = omega.engines
    advance(300)
    assert law.contacts().force[0] == pytest.approx(force(), rel=1e-12) and law.totals().dissipated > 0
    omega.engines[2].lawDispatcher.functors = [yade.Law2_ScGeom_MindlinPhys_Mindlin()]
    stops("is not used in this scene", 101)


@pytest.mark.parametrize("shear", ["elastic", "loading", "slip"])
def test_energies_of_an_oblique_impact(omega, tmp_path, shear):
    """O.energy is constant, also over saving and loading, and the same numbers are in totals()."""
    law = functor(shear=shear)
    two_spheres(law, sideways=0.2)
    omega.trackEnergy = True
    omega.dt = 2e-8
    assert not list(omega.energy.keys())  # YADE's plot.plot asks for data of all, and there are none before the first step
    omega.step()
    start = omega.energy.total()
    for _ in range(3):
        advance(800)
        assert omega.energy.total() == pytest.approx(start, rel=2e-3)
    totals, energy = law.totals(), dict(omega.energy.items())
    assert np.array(totals).tolist() == [totals.stored, totals.dissipated] and "stored (J)" in str(totals)
    assert energy["demlawsElastic"] == totals.stored
    assert energy["demlawsShearLost"] == pytest.approx(totals.shear_dissipated, rel=1e-12)
    omega.save(str(tmp_path / "scene.xml"))
    first = []
    for again in (False, True):
        if again:
            omega.load(str(tmp_path / "scene.xml"))
        advance(9000)
        first.append((*omega.bodies[1].state.vel, *omega.bodies[1].state.angVel, law.totals().shear_dissipated))
    assert first[0] == pytest.approx(first[1], rel=1e-9)
    assert not omega.interactions.countReal() and omega.energy.total() == pytest.approx(start, rel=2e-3)
    assert law.totals().shear_stored == 0.0 < law.totals().shear_dissipated < 0.1 * start


def test_physics_of_the_conical_damage_model_are_accepted(omega):
    """Its stiffnesses and constant friction are those of Mindlin's law; its strength is not used."""
    strength = {"sigmaMax": 1e9, "alpha": 0.1}
    stone = yade.FrictMatCDM(young=60.6e9, poisson=0.25, frictionAngle=0.5, density=2650, label="granite", **strength)
    omega.materials.append(stone)
    omega.bodies.append(fixed_pair(stone, 1e-6))
    set_engines(functor(), 1e-9, physics=yade.Ip2_FrictMatCDM_FrictMatCDM_MindlinPhysCDM())
    advance(3)
    contact = dl.Contact(0.005, MODULUS, GRANITE.roughness * 2**0.5, GRANITE.fractal_dimension)
    assert force() == pytest.approx(float(dl.law("pohrt-popov", contact, "hertz").force(1e-6)), rel=1e-8)


def test_native_shear_warns_and_slip_needs_springs(omega):
    with pytest.warns(dl.ValidityWarning, match="can create energy"):
        functor("hertz", "elastic", {}, shear="native")
    with pytest.raises(dl.DemlawsError, match="needs an unloading rule with springs"):
        functor("walton-braun", None, SURFACES, shear="slip", loading_stiffness=3e6, stiffness_ratio=2.0)


def test_numbers_that_are_none_stop_and_name_the_body(omega):
    """The extremes in small (python -m studies.extremes --yade measures them in full)."""
    from studies.extremes.yade_extremes import Yade

    found = dict(extremes.stops(Yade()))
    assert len(found) == 8 and report.stop_failures("YADE", found.items()) == []
    for what, message in found.items():
        assert "body 2 is at" in message or ("alone" not in what and "contact " in message)


# --- overlaps that no law of small strains is for: warned of beyond R/10, refused beyond R

RADIUS = 0.01  # of two spheres: R = 5 mm


def pressed(law, overlap, young=60.6e9, speed=0.0):
    omega = yade.O
    omega.reset()
    below, above = material(), material(young=young)
    for place in (0.0, 0.2):
        omega.bodies.append(sphere((0, 0, place), RADIUS, fixed=True, material=below))
        omega.bodies.append(sphere((0, 0, place + 2 * RADIUS - overlap), RADIUS, fixed=True, material=above))
    omega.bodies[1].state.vel = (0, 0, -speed)
    set_engines(law, 1e-6)


def large_overlaps(steps):
    return [text for text in issued(lambda: advance(steps)) if "law 'demlaws': overlap" in text]


@pytest.mark.parametrize("rule", ["elastic", "hertz"])
def test_a_large_overlap_is_warned_of_once(omega, rule):
    law = functor("pohrt-popov", rule)
    pressed(law, 0.499e-3)
    assert not large_overlaps(5)
    pressed(law, 0.6e-3)
    (text,) = large_overlaps(22)
    assert re.search(r"overlap 0.0006 m is 0.12 of .* R = 0.005 m \(2 of 2 con", text)
    assert omega.interactions[0, 1].phys.normalForce.norm() > 0
    pressed(law, 0.6e-3)  # another scene: again
    assert "2 of 2" in large_overlaps(2)[0]


@pytest.mark.native_step
def test_an_overlap_beyond_the_radius_stops(omega):
    """Sphere 1 is driven in at 200 m/s; no force is applied at that overlap."""
    law = functor(neverErase=True)
    pressed(law, 4.9e-3, speed=200.0)
    stops(r"contact 0\+1: overlap 0.005\d* m is 1.\d* times .* R = 0.005 m.*check units", 20)
    assert omega.iter < 5


def test_a_marker_has_no_force_anywhere(omega):
    """young=0, as YADE's examples mark water levels: no force, as native Mindlin."""
    law = functor()
    pressed(law, 8e-3, young=0.0)
    assert not issued(lambda: advance(5))
    assert omega.interactions.countReal() == 2 and omega.forces.f(1).norm() == 0 and law.totals() == (0.0, 0.0)
    functor("yip-venart", "elastic", label="later")  # made after the marker


def test_a_density_in_other_units(omega):
    """Contacts do not use it, the motion does: a warning, once per material."""
    stone = material()
    stone.density = 2.65
    yade.O.bodies.append(
        [sphere((0, 0, 0), 0.01, fixed=True, material=stone), sphere((0, 0, 0.02 - 1e-6), 0.01, material=stone)]
    )
    set_engines(functor(), 1e-9)
    with pytest.warns(dl.errors.ValidityWarning, match="g/cm³") as seen:
        advance(5)
    assert len([one for one in seen if "g/cm³" in str(one.message)]) == 1


@pytest.mark.parametrize("warned", [True, False])
def test_a_step_far_too_long_is_warned_of_once(omega, warned):
    """Of Hertz at an overlap of 1 µm: 2 √(m/K), and 0.8 of the estimate for a packing."""
    law, stone = functor("hertz", "elastic", None), material()
    yade.O.bodies.append([sphere((0, 0, 0), 0.01, fixed=True, material=stone)])
    yade.O.bodies.append(sphere((0, 0, 0.02 - 1e-6), 0.01, material=stone))
    mass, stiffness = yade.O.bodies[1].state.mass, 2.0 * MODULUS * (0.005 * 1e-6) ** 0.5
    limit = 2.0 * (mass / stiffness) ** 0.5
    set_engines(law, (1e3 if warned else 0.95) * limit)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        advance(3)
    texts = [str(one.message) for one in caught if issubclass(one.category, TimeStepWarning)]
    assert len(texts) == warned
    advised = STEP_SAFETY * packing_estimate(stiffness, mass)
    assert all("1e+03 times" in text and f"{limit:.3g} s: " in text and f"{advised:.2g} s is adv" in text for text in texts)


def before_its_material(law, young, radius=0.006, **options):
    """Two spheres whose material the law did not know when it was made."""
    made = functor(law, None, smooth=True, **options)
    stone = material("late", young=young)
    yade.O.bodies.append([sphere((0, 0, z), radius, fixed=True, material=stone) for z in (0, 2 * radius - 1e-6)])
    set_engines(made, 1e-9)


def test_energy_that_a_law_would_create_is_refused_at_the_first_contact(omega):
    """The blunted tip stores more than the work of crushing at E* of the contact, not at the 30 GPa of before."""
    before_its_material("conical-damage", 2.9e10, surfaces=None, strength=1.9e9, angle=1.4815)
    stops(r"0\+1 \('late' on 'late'\).*E\* = 1\.5\d*e\+10 Pa: .*return more work than loading took", 3)


def test_a_law_of_soft_grains_is_not_judged_by_hard_ones(omega):
    """With 30 GPa this law would create energy, with E* = 2.6 GPa it does not; it was refused where it was made."""
    before_its_material("conical-damage", 5e9, surfaces=None, strength=1.9e9, angle=1.52)
    advance(3)
    omega.reset()
    material("early", young=6e10)  # E* is known
    with pytest.raises(dl.DemlawsError, match="return more work"):
        functor("conical-damage", None, smooth=True, surfaces=None, strength=1.9e9, angle=1.52)


def test_hardness_is_judged_at_the_first_contact(omega):
    before_its_material("bahrami", 1e8, surfaces=dl.materials.granite)
    (text,) = (text for text in issued(lambda: advance(300)) if "hardness" in text)
    assert "times the effective modulus" in text and "E* = 5.3" in text


def test_a_bulk_radius_below_that_of_the_contact_is_named(omega):
    before_its_material("rough-plastic", 6e10, surfaces=dl.materials.granite, yield_pressure=1.66e9, bulk_radius=1e-3)
    stops(r"bulk_radius = 0\.001 m is below the contact's effective radius R = 0\.003 m", 3)


def test_a_position_that_is_not_finite_is_named(omega):
    acting(functor())
    yade.O.bodies[1].state.pos = (0, 0, float("nan"))
    stops("position is not finite", 20)


@pytest.mark.parametrize("shape", ["sphere", *FLATS])
@pytest.mark.parametrize("radius", [0.0, -1e-3, float("nan")])
def test_a_radius_that_is_not_positive_is_named(omega, shape, radius):
    """Such a sphere has no mass, moves to NaN, or meets nothing; the box was blamed, or a table's end."""
    stone = material()
    below = sphere((0, 0, -0.01), 0.01, fixed=True, material=stone) if shape == "sphere" else FLATS[shape](yade.utils, stone)
    omega.bodies.append([below, sphere((0, 0, 0.01 - 1e-6), 0.01, material=stone)])
    set_engines(functor())
    omega.bodies[1].shape.radius = radius
    stops(f"body 1 is a sphere with radius = {radius:g} m", 20)


def test_a_stepper_is_judged_once_there_are_spheres(omega):
    """Without a sphere YADE's P-wave step is 1 s: engines that come before the bodies were told of a bound of 3.2 s."""
    stepper, law = yade.GlobalStiffnessTimeStepper(), functor("hertz", None, None)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        omega.engines = [*dy.engines(law), stepper]
    omega.bodies.append(fixed_pair(material()))
    omega.dt = 1e-9
    with pytest.warns(dl.errors.TimeStepWarning, match=r"bound is 6\.\d+e-06 s") as seen:
        advance(3)
    assert "rough" not in str(seen[0].message) and stepper.maxDt == pytest.approx(0.8 * 4 * yade.utils.PWaveTimeStep())


@pytest.mark.parametrize("tabulated", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_which_contacts_have_yielded(omega, tabulated):
    """Of two pairs that are unloaded, one has passed the yield point."""
    pair = dl.Contact(0.005, MODULUS, GRANITE.roughness * 2**0.5, GRANITE.fractal_dimension, GRANITE.hardness)
    law = dl.law("rough-plastic", pair, "thornton", yield_pressure=1.66e9)
    yields, stone = law.kinks()[-1], material()
    for n, overlap in enumerate([1.01 * yields, 0.99 * yields]):
        omega.bodies.append(fixed_pair(stone, overlap, x=0.1 * n))
    acts = functor(law.tabulate() if tabulated else law, "thornton")
    set_engines(acts, 1e-9)
    advance(2)
    for body in (1, 3):
        omega.bodies[body].state.pos += yade.Vector3(0, 0, 0.5 * yields)
    advance(2)
    state = acts.contacts()
    assert (
        state.bulk_yielded.tolist() == [True, False]
        and state.flattened.all()
        and state.branch.tolist() == [1, 1]
        and len(state) == 2
    )


def test_asperities_flatten_from_the_first_touch(omega):
    """The bulk of a law without a yield point stays elastic: no word of it. No contacts: arrays of no entries."""
    rough = acting(functor())
    assert rough.contacts().flattened.tolist() == [True] and rough.contacts().bulk_yielded is None
    assert len(rough.contacts([])) == 0 == rough.contacts([]).flattened.size
    omega.reset()
    assert acting(functor("pohrt-popov", "elastic")).contacts().flattened.tolist() == [False]


def test_columns_of_contacts(omega):
    """They print, become a DataFrame, and each is described on the page."""
    pandas = pytest.importorskip("pandas")
    from demlaws.responses.contacts import COLUMNS

    state = acting(functor()).contacts()
    frame = state.to_dataframe()
    assert isinstance(frame, pandas.DataFrame) and len(frame) == 1 and frame["force (N)"][0] == state.force[0] == force()
    assert "overlap (m)" in str(state) and "1 contact\n" in repr(state)
    fields = [f.name for f in dataclasses.fields(state) if not f.name.startswith("centre")]
    assert [name for name in COLUMNS if name in fields] == fields
    page = re.sub(" +", " ", (ROOT / "docs/reference/yade.md").read_text())
    for name, (unit, meaning) in COLUMNS.items():
        assert re.sub(" +", " ", f"| `{name}` | {unit} | {meaning} |") in page, name


@pytest.mark.parametrize("kind", ["pair", "wall"])
def test_balance_of_energy(omega, kind):
    """It closes in proportion to the step without YADE's scaled shear; with it two spheres miss δ/(r1 + r2) of the loss."""
    from studies.shear import yade_balance

    coarse, fine = (yade_balance.impact(kind, False, share)[0] for share in (0.1, 0.025))
    assert abs(fine) < 6e-5 and fine / coarse == pytest.approx(0.25, rel=0.15)
    excess = yade_balance.impact(kind, True, 0.025)[0] - fine
    assert abs(excess) < 1e-9 if kind == "wall" else 1e-4 < excess < 5e-4  # on flats the displacement is ours
