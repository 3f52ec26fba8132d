"""The force that native YADE applied against the law, every step, in every geometry."""

import numpy as np
import pytest
from examples import ALIKE, rules_of, shared, telling
from yade_scenes import (
    GRANITE,
    MODULUS,
    OVERLAP,
    Recorder,
    advance,
    cloud,
    expected,
    fixed_pair,
    force,
    functor,
    material,
    set_engines,
    sphere,
    still,
    stops,
    two_spheres,
    yade,
)

import demlaws as dl
from demlaws.core.unloading import GIVEN, RULES
from demlaws.laws.registry import find
from demlaws.make import example_law

pytestmark = pytest.mark.releases

TOLERANCE = 1e-14
REFUSED = [("bahrami", rule) for rule in RULES if rule != "elastic"]
SLOW = [("asperity", GIVEN)]  # to make, not to run
COMBINATIONS = [(name, rule) for name in dl.laws() for rule in rules_of(name) if (name, rule) not in REFUSED + SLOW]


EVERY_LAW = shared(((*pair, {}) for pair in COMBINATIONS if telling(pair)), lambda one: one[0] not in ALIKE)
YIELDED = {"yield_pressure": 3e8, "yield_at": "load"}
BULK = [("hertz", YIELDED), ("thornton", {"yield_pressure": 3e8, "yield_at": "load", "bulk_radius": "9mm"})]


@pytest.mark.parametrize(("name", "rule", "more"), [*EVERY_LAW, *(("rough-plastic", *one) for one in BULK)])
def test_two_spheres_every_law(omega, name, rule, more):
    wanted = options = find(name).drawing.example | more
    given = name, rule
    if rule == GIVEN or find(name).needs_map:  # a law that has its curve with it, or the map of one contact
        pair = GRANITE.combined(GRANITE)
        contact = dl.Contact(0.005, MODULUS, pair.roughness, pair.fractal_dimension, pair.hardness)
        given, options = (example_law(name, contact, rule, **more), None), {}
    law = functor(*given, **options)
    two_spheres(law, sideways=0.02)
    recorder = Recorder()
    recorder.step(400)
    omega.bodies[1].state.vel = (0.0, 0, -0.5)  # again, deeper
    recorder.step(600)
    if find(name).fitting.free == ("sigma",) and find(name).solved:  # the law has the mean of four curves, YADE the four
        wrong, tangent, steps = recorder.worst(name, rule, **wanted)
        assert wrong <= 1e-12 and tangent <= 1e-11 and steps > 300
    else:
        assert recorder.exact(name, rule, **wanted) > 300


def test_periodic_packing(omega):
    law = functor()
    cloud(law, rate=-60)
    advance(2500)
    recorder = Recorder()
    recorder.lives.clear()
    born = omega.iter
    recorder.step(250)
    recorder.lives = {key: rows for key, rows in recorder.lives.items() if key[2] >= born}  # seen from their beginning
    assert len(recorder.lives) > 20
    recorder.exact()


def test_table(omega, tmp_path):
    contact = dl.Contact(0.005, 32e9, 2.4e-6 * 2**0.5, 2.22)
    table = dl.law("pohrt-popov", contact, "hertz").tabulate(1e-6)
    law = functor(str(table.save(tmp_path / "pp.table")), None)
    assert "table" in law.binding.pairs.name and law.binding.pairs.unloading == "hertz"
    two_spheres(law)
    recorder = Recorder()
    recorder.step(400)
    wrong, tangent, _ = recorder.worst()
    assert 1e-12 < wrong <= 2e-6 and tangent <= 2e-6


@pytest.mark.parametrize("as_table", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_a_curve_to_unload_along(omega, as_table):
    """Given beside the law, as a law and as a table; saved with the scene."""
    from demlaws.yade.saving import pairs_from, pairs_text

    contact = dl.Contact(0.005, 32e9, 2.4e-6 * 2**0.5, 2.22, 6.266e9)
    curve = dl.law("hertz", contact).tabulate() if as_table else dl.law("hertz", contact)
    law = functor("pohrt-popov", curve)
    assert law.binding.pairs.unloading == "table"
    two_spheres(law)
    recorder = Recorder()
    recorder.step(400)
    wrong, tangent, _ = recorder.worst("pohrt-popov", "hertz")  # what this curve amounts to
    assert wrong <= TOLERANCE and tangent <= 1e-12
    assert law.totals().dissipated > 0.0
    again = pairs_from(pairs_text(law.binding.pairs))
    assert again.unloading == "table" and pairs_text(again) == pairs_text(law.binding.pairs)


def test_pairs_of_materials(omega):
    """Granite on granite, granite on steel, steel on steel, unlisted on granite: each by its own surface."""
    steel = dl.Surface(roughness=0.5e-6, fractal_dimension=2.6)
    law = functor(surfaces={"granite": GRANITE, "steel": steel})
    smooth = dl.Surface(0)
    kinds = {"granite": GRANITE, "steel": steel, "rubber": smooth}
    made = {label: material(label) for label in kinds}
    pairs = [("granite", "granite"), ("granite", "steel"), ("steel", "steel"), ("granite", "rubber"), ("rubber", "rubber")]
    for n, (a, b) in enumerate(pairs):
        omega.bodies.append(sphere((n, 0, 0), 0.01, fixed=True, material=made[a]))
        omega.bodies.append(sphere((n, 0, 0.02), 0.01, material=made[b]))
        omega.bodies[-1].state.vel = (0, 0, -0.3)
    set_engines(law)
    recorder = Recorder()
    recorder.step(300)
    for n, (a, b) in enumerate(pairs):
        one = Recorder()
        one.lives = {key: rows for key, rows in recorder.lives.items() if key[0] == 2 * n}
        surface = kinds[a].combined(kinds[b])
        law_name = "hertz" if surface.roughness == 0 else "pohrt-popov"
        one.exact(law_name, pair=surface)


def test_material_outside_the_scene_list(omega):
    """A material that was never appended to O.materials counts by its label all the same."""
    law = functor()
    long_label = "granite"
    for height in (0, 0.019999):
        stone = yade.FrictMat(young=60.6e9, poisson=0.25, density=2650, label=long_label)
        omega.bodies.append(sphere((0, 0, height), 0.01, fixed=True, material=stone))
    set_engines(law)
    advance(2)
    assert law.contacts().sigma[0] == pytest.approx(2.4e-6 * 2**0.5)


def test_rows_of_contacts_that_end_are_used_again(omega):
    """20,000 contacts, of which at most 20 at a time, need the memory of about a thousand."""
    stone = material()
    law = functor()
    for n in range(20):
        omega.bodies.append(fixed_pair(stone, x=0.05 * n))
    set_engines(law, 1e-9)
    upper = [body for body in omega.bodies if body.state.pos[2] > 0.0]
    for step in range(2000):
        for body in upper:
            body.state.pos = (body.state.pos[0], 0, 0.02 - (OVERLAP if step % 2 else -OVERLAP))
        omega.step()
    assert omega.interactions.countReal() == 20
    assert law.binding.attachment.context["rows_used"] < 1200


def test_coefficients_that_a_script_changes(omega):
    """Each change stops the run."""
    still(functor())
    advance(5)
    for name in ("kno", "kso", "kno"):
        phys = yade.O.interactions[0, 1].phys
        setattr(phys, name, 1.5 * getattr(phys, name))
        stops(r"contact 0\+1: kno or kso was changed.*materials.*shear_ratio=", 3)
        advance(1)
        assert force() == expected()


def test_bodies_come_and_go(omega, monkeypatch):
    """Contacts end because bodies are erased, others begin with new bodies, whose history is where that of others was."""
    from demlaws.yade import native

    monkeypatch.setattr(native, "FEW_ROWS", 4)
    monkeypatch.setattr("demlaws.yade.scene.PERIOD", 5)
    law = functor("rough-plastic", "hertz", yield_pressure=1.66e9)
    attachment = law.binding.attachment
    stone = material()
    omega.bodies.append([sphere((n, 0, 0), 0.01, fixed=True, material=stone) for n in range(12)])
    set_engines(law)
    recorder = Recorder()
    generator = np.random.default_rng(1)
    for wave in range(6):
        fresh = []
        for n in range(12):
            fresh.append(omega.bodies.append(sphere((n, 0, 0.02), 0.01, material=stone)))
            omega.bodies[fresh[-1]].state.vel = yade.Vector3(0, 0, -generator.uniform(0.2, 2))
        recorder.step(120 + 40 * wave)
        for body in fresh:
            omega.bodies.erase(body)
    recorder.exact("rough-plastic", "hertz", yield_pressure=1.66e9)
    assert len(recorder.lives) == 72
    assert attachment.context["rows_used"] <= 40


@pytest.mark.parametrize("erase", ["body", "contact", "all contacts", "clump"])
def test_totals_count_contacts_that_were_erased(omega, tmp_path, erase):
    """Their dissipation is not known: `totals` states their number, also after saving; contacts that end do not count."""
    law = functor("pohrt-popov", "hertz")
    stone = material()
    omega.bodies.append(sphere((0, 0, 0), 0.01, fixed=True, material=stone))
    upper = sphere((0, 0, 0.02), 0.01, material=stone)
    clump = omega.bodies.appendClumped([upper])[0] if erase == "clump" else omega.bodies.append(upper)
    omega.bodies[clump].state.vel = (0, 0, -0.3)
    omega.bodies.append(fixed_pair(stone, x=0.1))
    set_engines(law)
    advance(60)
    omega.bodies[omega.bodies[-1].id].state.pos = (0.1, 0, 0.03)  # this contact ends
    advance(2)
    before = law.totals()
    head, row = str(before).splitlines()
    assert head.split()[:2] == ["stored", "(J)"] and head.endswith("unaccounted") and row.split()[-1] == str(before.unaccounted)
    assert float(row.split()[0]) == pytest.approx(before.stored, rel=1e-4) and repr(before) == str(before)
    assert before.stored > 0 and before.dissipated > 0 and before.unaccounted == 0
    {
        "body": lambda: omega.bodies.erase(1),
        "contact": lambda: omega.interactions.erase(0, 1),
        "all contacts": omega.interactions.clear,
        "clump": lambda: omega.bodies.erase(clump, True),
    }[erase]()
    after = law.totals()
    assert after.unaccounted == 1
    assert 0 < after.dissipated < before.dissipated and after.stored == 0
    omega.saveTmp()
    omega.loadTmp()
    assert law.totals() == after and law.totals().unaccounted == 1


@pytest.mark.native_step
def test_never_erase(omega):
    """A contact that Mindlin keeps while the bodies are apart is a new one when they meet again."""
    law = functor(neverErase=True)
    two_spheres(law)
    recorder = Recorder()
    recorder.step(1600)
    omega.bodies[1].state.vel = (0.0, 0, -0.2)
    recorder.step(1500)
    assert len(recorder.lives) == 1
    rows = next(iter(recorder.lives.values()))
    parted = [n for n, row in enumerate(rows) if row[0] < 0]
    assert parted and rows[-1][1] > 0
    recorder.lives = {"first touch": rows[: parted[0]], "second touch": rows[parted[-1] + 1 :]}
    recorder.exact()


def test_a_law_made_before_the_bodies_serves_every_size(omega):
    """One curve per N_H; the law has those of all N_H, without bodies or materials in the scene."""
    law = functor("yip-venart", "hertz")
    stone = material()
    for n, radius in enumerate((0.005, 0.01, 0.02)):
        omega.bodies.append(sphere((n, 0, 0), 0.01, fixed=True, material=stone))
        omega.bodies.append(sphere((n, 0, 0.01 + radius), radius, material=stone))
        omega.bodies[-1].state.vel = (0, 0, -0.05)
    set_engines(law)
    recorder = Recorder()
    recorder.step(300)
    wrong, tangent, _ = recorder.worst("yip-venart", "hertz")
    assert wrong <= 1e-12 and tangent <= 1e-11
    omega.reset()
    soft = dl.Surface(2e-6, hardness=1e6)  # N_H = 0.003 on this stone
    two_spheres(functor("yip-venart", "hertz", {"granite": soft}))
    stops("N_H", 50)


@pytest.mark.native_step
@pytest.mark.parametrize("damping", [{}, {"betan": 0.05, "betas": 0.05}])
def test_moments_are_those_of_native_mindlin(omega, damping):
    """A packing that is compressed and sheared with rolling and twisting resistance: Hertz's law beside YADE's own."""
    ends = []
    for law in (yade.Law2_ScGeom_MindlinPhys_Mindlin(), functor("hertz", "elastic", {}, shear="native")):
        omega.reset()
        law.includeMoment = True
        physics = yade.Ip2_FrictMat_FrictMat_MindlinPhys(krot=1.0, ktwist=2.0, eta=2e-3, **damping)
        cloud(law, physics=physics)
        omega.cell.velGrad = yade.Matrix3(-140, 100, 0, 0, -140, 0, 0, 0, -140)
        generator = np.random.default_rng(5)
        for body in omega.bodies:
            body.state.angVel = yade.Vector3(*generator.uniform(-300, 300, 3))
        advance(1400)  # rounding grows tenfold every 300 steps, from collision to collision
        touching = [i.phys for i in omega.interactions if i.isReal and i.phys.normalForce.norm() > 0]
        bend = [phys.momentBend.norm() / (phys.maxBendPl * phys.normalForce.norm()) for phys in touching]
        bodies = omega.bodies
        ends.append(
            np.array([(*b.state.pos, *omega.forces.f(b.id), *omega.forces.t(b.id), *b.state.angVel) for b in bodies]).reshape(
                -1, 4, 3
            )
        )
    assert len(bend) > 100 and max(bend) == pytest.approx(1.0) and min(bend) < 0.9  # some contacts roll, some do not
    scale = np.abs(ends[0]).max(axis=(0, 2), keepdims=True)
    assert np.all(np.abs(ends[0] - ends[1]) <= 1e-9 * scale)
