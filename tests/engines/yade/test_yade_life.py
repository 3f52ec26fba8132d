"""Saving, loading, switching, erasing, failing: what happens around the forces."""

import itertools
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from yade_scenes import (
    GRANITE,
    MODULUS,
    OVERLAP,
    acting,
    advance,
    cloud,
    fixed_pair,
    functor,
    material,
    set_engines,
    sphere,
    stops,
    two_spheres,
    under_yade,
    yade,
)

import demlaws as dl

pytestmark = pytest.mark.releases

HERE = Path(__file__).parent
ROUNDING = 1e-13
"""Positions [m] in a box of 0.1 m after 500 steps; loading changes the order in which forces are summed."""


def positions():
    return np.array([tuple(b.state.pos) for b in yade.O.bodies if b is not None])


def printed(text, tmp_path, **options):
    """First word → other words of the lines that a script prints in a YADE process of its own."""
    done = under_yade(text, tmp_path, **options)
    assert done.returncode == 0, done.stdout + done.stderr
    return {line.split()[0]: line.split()[1:] for line in done.stdout.splitlines() if line.strip()}


# --- energy


@pytest.mark.parametrize("rule", ["hertz", pytest.param("thornton", marks=pytest.mark.slow)])
def test_energy_balance_of_an_impact(omega, rule):
    law = functor("rough-plastic", rule, yield_pressure=1.66e9)
    two_spheres(law, speed=-2.0)
    omega.dt = 2e-9
    mass = omega.bodies[1].state.mass

    def kinetic():
        return 0.5 * mass * omega.bodies[1].state.vel.squaredNorm()

    before = kinetic()
    seen = 0.0
    while omega.bodies[1].state.vel[2] < 0 or omega.interactions.countReal():
        advance(2000)
        totals = law.totals()
        seen = max(seen, totals.stored)
        if omega.interactions.countReal():
            assert kinetic() + totals.stored + totals.dissipated == pytest.approx(before, rel=1e-4)
    assert law.totals().stored == 0.0
    assert seen > 0.5 * before
    assert kinetic() + law.totals().dissipated == pytest.approx(before, rel=1e-6)
    assert law.totals().dissipated > 1e-3 * before


def test_state_of_a_contact(omega):
    law = two_spheres(functor(), steps=300)
    contact = omega.interactions[0, 1]
    state = law.contacts([contact])
    assert (state.body1[0], state.body2[0]) == (0, 1)
    assert state.radius[0] == pytest.approx(0.005)
    assert state.sigma[0] == pytest.approx(2.4e-6 * 2**0.5)
    assert state.maximum_overlap[0] == contact.geom.penetrationDepth
    assert 0 < state.plastic_overlap[0] < state.maximum_overlap[0]
    assert np.isnan(state.radius_ratio[0])
    assert state.force[0] == pytest.approx(contact.phys.normalForce.norm(), rel=1e-14)
    assert state.stored[0] > 0 and state.dissipated[0] > 0
    assert law.normElastEnergy() == state.stored[0]


# --- the bridge


def test_a_proof_that_fails_is_one_error(omega, monkeypatch):
    """It names the failure, the versions, the processor and the remedies; no functor acts."""
    import platform

    import yade.config

    from demlaws.yade import native

    monkeypatch.setattr(native, "_layout", None)
    monkeypatch.setattr(native, "GO", native.GO.replace("IGeom", "JGeom"))
    with pytest.raises(dl.DemlawsError) as failed:
        functor()
    for words in ("do not export", "JGeom", yade.config.version, np.__version__, platform.machine(), native.TESTED[0], "table"):
        assert words in str(failed.value)


@pytest.mark.parametrize("share", [1.0, 1.001])
def test_a_self_test_that_fails_is_the_same_error(omega, monkeypatch, share):
    """The force that YADE applies is compared with the law's."""
    from demlaws.yade.pairs import Pairs

    right = Pairs.evaluate

    def evaluate(pairs, rows):
        answer, bad = right(pairs, rows)
        answer["kno"] *= share
        return answer, bad

    monkeypatch.setattr(Pairs, "evaluate", evaluate)
    if share == 1.0:
        functor()
        return
    with pytest.raises(dl.DemlawsError, match=r"does not work with this YADE: YADE applied .* differ by"):
        functor()


def test_the_self_test_has_a_periodic_cell_of_the_size_of_its_spheres(tmp_path):
    """From 0.2 m the first law of a process could not be made: YADE's cell of 1 m was too small for them."""
    spheres = (
        "from yade_scenes import *\nyade.O.bodies.append([sphere((0, 0, n), 0.3, material=material()) for n in range(2)])\n"
    )
    law = "print(functor('hertz', 'elastic', None, smooth=True).binding.attachment is not None)"
    assert "True" in under_yade(spheres + law, tmp_path).stdout


def test_contacts_that_are_cleared_after_loading_begin_again(omega, tmp_path):
    """A contact that is cleared and made again does not have the largest overlap of the saved one."""
    law = acting(functor())
    omega.save(str(tmp_path / "x.yade"))
    omega.reset()
    omega.load(str(tmp_path / "x.yade"))
    omega.interactions.clear()
    omega.bodies[1].state.pos = (0, 0, 0.02 - 0.5 * OVERLAP)
    advance(2)
    state = law.contacts()
    assert state.branch.tolist() == [0] and state.maximum_overlap == pytest.approx([0.5 * OVERLAP], rel=1e-9)


def test_threads(omega, tmp_path):
    """Two threads, in another process: the same packing to rounding of sums."""
    text = """
import yade
from yade_scenes import cloud, functor
law = functor()
cloud(law, number=200, rate=-40)
yade.O.run(2500, True)
print("threads", yade.O.numThreads, yade.O.interactions.countReal())
print("energies", *law.totals())
"""
    rows = printed(text, tmp_path, threads=2)
    law = functor()
    cloud(law, number=200, rate=-40)
    advance(2500)
    assert rows["threads"] == ["2", str(omega.interactions.countReal())] and omega.interactions.countReal() > 20
    assert [float(x) for x in rows["energies"]] == pytest.approx(law.totals(), rel=1e-6)


# --- saving and loading


def test_a_packing_goes_on_after_loading(omega, tmp_path):
    """Loaded here in three ways, and in a process whose script does not know this package."""
    law = functor()
    cloud(law, rate=-60)
    advance(3000)
    assert omega.interactions.countReal() > 20
    file = str(tmp_path / "packing.yade.bz2")
    omega.saveTmp()
    omega.save(file)
    advance(500)
    goal = positions(), law.totals()
    for load in (omega.loadTmp, lambda: omega.load(file), omega.reload):
        load()
        advance(500)
        assert np.abs(positions() - goal[0]).max() <= ROUNDING
        assert law.totals() == pytest.approx(goal[1], rel=1e-9)
    text = f"""
import yade
yade.O.load({file!r})
yade.O.run(500, True)
print("positions", *[x.hex() for b in yade.O.bodies for x in b.state.pos])
import demlaws.yade
print("totals", *demlaws.yade.attached("demlaws").totals())
"""
    rows = printed(text, tmp_path)
    there = np.array([float.fromhex(x) for x in rows["positions"]])
    assert np.abs(there - goal[0].ravel()).max() <= ROUNDING
    assert [float(x) for x in rows["totals"]] == pytest.approx(goal[1], rel=1e-9)


# --- refusals: never silently the native law


def test_a_damaged_record_of_a_scene_is_one_error(omega):
    """A changed letter anywhere, and the record of a version that wrote no digest."""
    from demlaws.yade import saving

    law = functor()
    acting(law)
    text = saving.law_text(law)
    assert saving.content_of(text, "demlaws")["contacts"] == 1
    for place in (0, 4, 12, len(text) // 2, len(text) - 3):
        changed = text[:place] + chr(ord(text[place]) ^ 1) + text[place + 1 :]
        with pytest.raises(dl.DemlawsError, match="damaged: its record of law 'demlaws'"):
            saving.content_of(changed, "demlaws")
    with pytest.raises(dl.DemlawsError, match="former version"):
        saving.content_of(text.partition(" ")[2], "demlaws")


def test_adhesion_is_refused(omega):
    with pytest.raises(dl.DemlawsError):
        functor(includeAdhesion=True)
    law = functor()
    two_spheres(law)
    law.includeAdhesion = True
    stops("includeAdhesion")


def test_switch_with_live_contacts(omega):
    two_spheres(functor(), steps=100)
    assert omega.interactions.countReal() == 1
    other = functor("hertz", "elastic", label="other")
    with pytest.raises(dl.DemlawsError):
        set_engines(other)
    with pytest.raises(dl.DemlawsError):
        set_engines(yade.Law2_ScGeom_MindlinPhys_Mindlin())
    omega.engines = [*omega.engines, yade.PyRunner(command="pass", iterPeriod=1)]  # the same law: no switch
    omega.interactions.clear()
    set_engines(other)
    advance(10)
    assert omega.interactions[0, 1].phys.normalForce.norm() == pytest.approx(other.contacts().force[0], rel=1e-14)


def test_foreign_functor_in_a_contact_is_noticed(omega):
    """Past the engine list: contacts made by native Mindlin are found out at the second step."""
    from demlaws.yade import engines, omega as native, scene

    two_spheres(yade.Law2_ScGeom_MindlinPhys_Mindlin())
    advance(100)
    law = functor()
    native.set_engines(scene.completed(engines(law), {"demlaws": law}, []))
    stops(r"was not computed by the law .* O.interactions.clear\(\) lets all contacts begin again")
    omega.interactions.clear()
    omega.engines = engines(law)
    advance(20)
    assert law.contacts().force[0] > 0.0


def test_end_of_table_stops(omega, tmp_path):
    contact = dl.Contact(0.005, 32e9, 2.4e-6 * 2**0.5, 2.22)
    table = dl.law("pohrt-popov", contact, "hertz").tabulate(1e-5, max_force=5.0)
    law = functor(table, None)
    two_spheres(law)
    stops("no finite force .* make the table for larger forces", 500)
    assert np.isfinite(positions()).all()
    omega.reset()
    two_spheres(functor(dl.law("pohrt-popov", contact, "hertz").tabulate(1e-5, max_force=5e3), None), steps=500)
    assert omega.interactions[0, 1].phys.normalForce.norm() > 5.0


def test_table_of_a_law_without_one_curve(omega):
    contact = dl.Contact(0.005, 32.32e9, 2.4e-6 * 2**0.5, 2.22)
    made = dl.law("rough-plastic", contact, "hertz", yield_pressure=1.66e9)
    table = made.tabulate(1e-5)
    two_spheres(functor(table, None), steps=100)
    omega.reset()
    two_spheres(functor(table, None), radius=0.02)
    stops("that of another contact", 100)


@pytest.mark.parametrize(
    "arguments",
    [
        {"law": "herz"},
        {"unloading": "plastic"},
        {"label": "two words"},
        {"surfaces": {"granite": 2e-6}},
        {"surfaces": {"granite": dl.Surface(2e-6)}},
        {"law": "/nowhere/table"},
        {"law": {("granite", "steel"): "hertz"}},
        {"radii": (1.0, 2.0)},
        {"law": "asperity"},
        {"colour": "red"},
        {"law": "walton-braun", "unloading": None, "surfaces": None, "smooth": True},
    ],
)
def test_bad_arguments(omega, arguments):
    with pytest.raises(dl.DemlawsError):
        functor(**arguments)


def test_laws_by_pair(omega):
    """A table for one pair, another for the next."""
    steel = dl.Surface(roughness=0.5e-6, fractal_dimension=2.6)
    surfaces, tables = {"": dl.Surface(0), "granite": GRANITE, "steel": steel}, {}
    for names in (pair for pair in itertools.combinations_with_replacement(surfaces, 2) if any(pair)):
        surface = surfaces[names[0]].combined(surfaces[names[1]])
        contact = dl.Contact(0.005, 32e9, surface.roughness, surface.fractal_dimension)
        tables[names] = dl.law("pohrt-popov", contact, "hertz").tabulate(1e-5)
    law = functor(tables, None, {"granite": GRANITE, "steel": steel})
    pairs = law.binding.pairs
    assert pairs.number("granite", "steel") == pairs.number("steel", "granite") != pairs.number("steel", "steel")
    assert pairs.number("sand", "sand") == pairs.number("", "")
    from demlaws.yade.saving import pairs_from, pairs_text

    again = pairs_from(pairs_text(pairs))
    assert pairs_text(again) == pairs_text(pairs) and repr(again.law) == repr(pairs.law)


def test_laws_by_pair_of_smooth_materials(omega):
    """Labels without a surface are smooth where the user says so; else the error says how."""
    laws = {("cloth", "sand"): "hertz"}
    pairs = functor(laws, None, None, smooth=True).binding.pairs
    assert pairs.number("sand", "cloth") not in (pairs.number("sand", "sand"), pairs.number("", ""))
    with pytest.raises(dl.DemlawsError, match=r"'cloth' .* has no surface.*surfaces=\{'cloth': .*smooth=True"):
        functor(laws, None, None)


def test_labels_that_begin_alike(omega):
    """A contact has the surface of its materials' own label, also beside a longer or a shorter one."""
    surfaces = {label: dl.Surface(roughness, 2.22) for label, roughness in (("sand", 1e-6), ("sandé", 2e-6), ("s", 3e-6))}
    law = functor(surfaces=surfaces, smooth=True)
    labels = ["sand", "sandé", "s", "san", "sandés", ""]
    for n, label in enumerate(labels):
        yade.O.bodies.append(fixed_pair(material(label), x=0.1 * n))
    set_engines(law, 1e-9)
    advance(2)
    expected = [2**0.5 * surfaces[label].roughness if label in surfaces else 0.0 for label in labels]
    contacts = law.contacts()
    assert contacts.sigma[np.argsort(contacts.body1)] == pytest.approx(expected)


def test_laws_by_pair_of_two_kinds(omega):
    """One functor has one law, or tables: the error names the laws and what to give."""
    surfaces = {"granite": GRANITE, "steel": dl.Surface(0.5e-6)}
    laws = {("granite", "granite"): "pohrt-popov", ("granite", "steel"): "rms", ("steel", "steel"): "rms"}
    with pytest.raises(dl.DemlawsError, match=r"got pohrt-popov, rms: give each pair a table"):
        functor(laws, "hertz", surfaces)
    del laws["steel", "steel"]
    with pytest.raises(dl.DemlawsError, match=r"no entry for the pair \('steel', 'steel'\), .* add it to the dict"):
        functor(laws, "hertz", surfaces)


def test_a_measured_map_beside_a_wall(omega):
    """The law of the map is that of one contact; pairs that do not meet need no other."""
    from yade.utils import sphere, wall

    from demlaws.laws.registry import find
    from demlaws.yade.saving import pairs_from, pairs_text

    stone, steel = material(), material("steel")
    omega.bodies.append([sphere((0, 0, 0.01 - 2e-6), 0.01, fixed=True, material=stone), wall(0, 2, material=steel)])
    pair = dl.Contact(0.01, MODULUS, GRANITE.roughness, GRANITE.fractal_dimension, GRANITE.hardness)
    given = dl.law("asperity", pair, "elastic", **find("asperity").drawing.example)
    law = functor(given, None, {"granite": GRANITE, "steel": dl.Surface(0)})
    set_engines(law, 1e-9)
    advance(3)
    wanted = given.force(law.contacts().overlap[0])
    assert omega.forces.f(0)[2] == pytest.approx(wanted, rel=1e-13)
    text = pairs_text(law.binding.pairs)
    assert pairs_text(pairs_from(text)) == text


def test_a_measured_map_is_refused_for_another_contact(omega):
    """A law made for R = 5 mm gives 0.8765 N at R = 10 mm, where the map gives 0.8699 N."""
    from demlaws.laws.registry import find

    stone, pair = material(), GRANITE.combined(GRANITE)
    contact = dl.Contact(0.005, MODULUS, pair.roughness, pair.fractal_dimension, pair.hardness)
    law = functor(dl.law("asperity", contact, "elastic", **find("asperity").drawing.example), None)
    omega.bodies.append([sphere((0, 0, z), 0.02, fixed=True, material=stone) for z in (0, 0.04 - 2e-6)])
    set_engines(law, 1e-9)
    stops("that of another contact")


# --- the command


def test_import_leaves_yade_alone():
    code = "import sys, demlaws, demlaws.yade, demlaws.cli.yade, demlaws.yade.run; sys.exit('yade' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], cwd=HERE.parents[2], timeout=600).returncode == 0
