"""Shear of one contact: K_t of every choice; levels; closed forms of partial slip; passivity for every law and rule."""

import itertools

import numpy as np
import pytest
from examples import GRANITE, each_law_and_rule, make, pairs, quiet, sealed, telling
from hypothesis import given, strategies as st

import demlaws as dl
from demlaws.core.shear import SPRINGS
from demlaws.core.unloading import RULES
from demlaws.shear import _pressure_along, sheared
from studies.shear.springs import mindlin

pytestmark = pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")
RATIO, FRICTION, LOAD = 2 * (1 - 0.25) / (2 - 0.25), 0.5, 10.0


def hertz():
    """Law, overlap at the load, and the displacement at which the whole contact slides."""
    law = make("hertz")
    overlap = law.overlap(LOAD)
    return law, overlap, FRICTION * overlap / RATIO


@pytest.mark.parametrize(
    ("springs", "force", "loss"), [(8, 3e-2, 0.2), (11, 1.5e-2, 0.1), (32, 2e-3, 2.5e-2), (1000, 2e-5, 2e-3)]
)
def test_hertz_is_cattaneo_mindlin_and_deresiewicz(springs, force, loss):
    """Q = μP [1 - (1 - 2 K_t s/(3 μP))^1.5]; loss of a cycle at 0.05 to 0.99 μP (Johnson 1985, Eq. 7.57)."""
    error, losses = mindlin(springs)
    assert error <= force and np.abs(losses).max() <= loss


def loss_of_cycle(law, share):
    """Energy [J] that a cycle between ±`share` of Coulomb's limit takes at 10 N (Johnson 1985, Eq. 7.57)."""
    unit = 7.2 * (FRICTION * LOAD) ** 2 / (RATIO * law.stiffness(law.overlap(LOAD)))
    return unit * (1.0 - (1.0 - share) ** (5 / 3) - 5.0 * share / 6.0 * (1.0 + (1.0 - share) ** (2 / 3)))


def small_cycle(law, approach, share, springs=SPRINGS):
    """Loss of a cycle between ±`share` of Coulomb's limit at 10 N over that of Mindlin & Deresiewicz (1953), less 1.

    approach: overlaps over that at 10 N before.
    """
    overlap = law.overlap(LOAD)
    reach = FRICTION * overlap / RATIO * (1.0 - (1.0 - share) ** (2 / 3))
    cycle = reach * np.interp(np.arange(1201), [0, 200, 600, 1000, 1200], [0.0, 1.0, -1.0, 1.0, 0.0])[:1001]
    path = sheared(
        law,
        overlap * np.r_[approach, np.ones(cycle.size)],
        np.r_[np.zeros(len(approach)), cycle],
        RATIO,
        "slip",
        friction=FRICTION,
        springs=springs,
    )
    return (path.dissipated[-1] - path.dissipated[len(approach) + 200]) / loss_of_cycle(law, share) - 1.0


GROWTHS = [
    np.geomspace(1e-3, 1.0, 2000),
    np.geomspace(1e-3, 1.0, 200),
    np.geomspace(1e-3, 1.0, 1713),
    np.geomspace(0.4, 1.0, 20),
    [1.0],
]
"""Ways to a load, after which a row of equal springs would be filled to different shares."""


@pytest.mark.parametrize("rule", ["elastic", "hertz"])
@pytest.mark.parametrize("growth", range(len(GROWTHS)))
def test_small_cycles_lose_what_they_should(rule, growth):
    """Within 10 % from 0.05 of Coulomb's limit on, 30 % at 0.02; with 32 springs within 6 %."""
    law = dl.law("hertz", GRANITE, rule)
    for share in (0.02, 0.05, 0.06, 0.08, 0.1, 0.14, 0.2, 0.3, 0.45, 0.6, 0.8, 0.95):
        assert abs(small_cycle(law, GROWTHS[growth], share)) < (0.1 if share >= 0.05 else 0.3), share
        assert abs(small_cycle(law, GROWTHS[growth], share, 32)) < 0.06, share


@pytest.mark.parametrize("top", [1.1, 1.5, 3.0])
def test_small_cycles_after_unloading(top):
    """Springs are divided as the contact becomes softer; one that was as wide as the cycle would lose nothing."""
    law = dl.law("hertz", GRANITE, "hertz")
    way = np.r_[np.geomspace(1e-3, top, 1000), np.geomspace(top, 1.0, 300)]
    errors = [small_cycle(law, way, share) for share in (0.1, 0.14, 0.2, 0.3, 0.45, 0.6, 0.8)]
    assert np.abs(errors).max() < 0.35


@pytest.mark.parametrize(("first", "then"), [(0.9, 0.4), (0.7, 0.3), (0.4, 0.2), (0.9, -0.3)])
def test_small_cycles_of_a_loaded_contact(first, then):
    """They lose as much about any shear force, from the second on (Masing's rule): springs stick until they are back at it."""
    law, overlap, sliding = hertz()

    def moved(share):
        return sliding * (1.0 - (1.0 - share) ** (2 / 3))

    def legs(*corners):
        return np.concatenate([np.linspace(a, b, 200)[1:] for a, b in itertools.pairwise(corners)])

    growth = np.geomspace(1e-3, 1.0, 2000)
    for share in (0.02, 0.05, 0.1):
        middle, reach = moved(first) - 2.0 * moved(0.5 * (first - then)), moved(share)
        corners = 3 * [middle + reach, middle - reach]
        across = np.r_[np.zeros(growth.size), legs(0.0, moved(first), middle, *corners)]
        overlaps = overlap * np.r_[growth, np.ones(across.size - growth.size)]
        path = sheared(law, overlaps, across, RATIO, "slip", friction=FRICTION, springs=SPRINGS)
        lost = path.dissipated[-1] - path.dissipated[-1 - 2 * 199]
        assert lost / loss_of_cycle(law, share) == pytest.approx(1.0, abs=0.1 if share >= 0.05 else 0.2), share


@pytest.mark.parametrize(("springs", "first"), [(11, 6e-4), (22, 1e-3)])
def test_a_contact_that_vibrates_stops_losing_energy(springs, first):
    """Springs are divided and joined in the first cycles only, those with nearly equal stretches."""
    law = dl.law("hertz", GRANITE, "elastic")
    growth, vibration = np.geomspace(1e-3, 1.0, 1000), 1.0 + 0.05 * np.sin(np.linspace(0.0, 40.0 * np.pi, 4001))
    overlap = law.overlap(10.0) * np.r_[growth, vibration]
    across = 0.4 * FRICTION / RATIO * law.overlap(10.0) * np.r_[growth, np.ones(vibration.size)]
    path = sheared(law, overlap, across, RATIO, "slip", friction=FRICTION, springs=springs)
    lost = path.dissipated[1000::200] / path.stored[1000]
    assert lost[-1] - lost[0] < first and lost[-1] - lost[3] < 1e-4


@each_law_and_rule
def test_shear_at_constant_overlap_is_that_of_the_unloading_curve(name, unloading):
    """Q = μ [P(δ) - P(δ - ratio s/μ)] (Jäger 1998; Ciavarella 1998), P along which the contact would unload."""
    law = make(name, unloading)
    overlap = quiet(law.overlap, LOAD)
    deeper = np.linspace(0.0, 1.1, 150) * overlap
    state = law.new_state(1)
    law.follow([overlap], state)
    curve = quiet(law.follow, np.maximum(overlap - deeper, 1e-9 * overlap), state).force
    if np.any(np.diff(curve, 2) < -1e-4 * LOAD):
        pytest.skip("the unloading curve is not convex: the springs' compressions are scaled")
    # the springs know the curve from the contact's growth
    overlaps, moved = np.r_[overlap * np.geomspace(1e-4, 1.0, 1500), np.full(150, overlap)], np.r_[np.zeros(1500), deeper]
    path = quiet(sheared, law, overlaps, moved * FRICTION / RATIO, RATIO, "slip", friction=FRICTION, springs=400)
    np.testing.assert_allclose(path.shear_force[1500:], FRICTION * (LOAD - curve), atol=2e-3 * FRICTION * LOAD)


@pytest.mark.parametrize("shear", ["elastic", "loading", "slip"])
@each_law_and_rule
@given(data=st.data())
def test_no_step_of_any_path_returns_what_was_lost(name, unloading, shear, data):
    """Dissipation never falls, so that no closed path returns work; the force never exceeds Coulomb's."""
    law = make(name, unloading)
    places = [st.floats(lo, 1.0).map(lambda x: round(x, 12)) for lo in (-0.1, -1.0, -1.0)]  # no forces of 1e-300 N
    corners = data.draw(st.lists(st.tuples(*places), min_size=2, max_size=8))
    scale = quiet(law.overlap, LOAD) * np.array([1.0, *[FRICTION / RATIO * data.draw(st.sampled_from([0.1, 1.0, 3.0]))] * 2])
    legs = [np.linspace(a, b, 25)[1:] for a, b in zip(corners, [*corners[1:], (corners[-1][0], 0.0, 0.0)], strict=True)]
    path = np.concatenate([np.zeros((1, 3)), *legs]) * scale
    levels = None if shear == "slip" else data.draw(st.integers(1, 8))
    result = quiet(sheared, law, path[:, 0], path[:, 1:], RATIO, shear, friction=FRICTION, springs=16, levels=levels)
    size = np.abs(result.work).max()
    assert np.diff(result.dissipated).min() >= -1e-13 * size
    assert np.all(np.hypot(*result.shear_force.T) <= FRICTION * result.force * (1.0 + 1e-9))


@pytest.mark.parametrize(("springs", "lost"), [(256, 0.01), (10, 0.05)])
@pytest.mark.parametrize("shear", ["elastic", "slip"])
def test_oblique_loading_of_constant_direction_does_not_slip(shear, springs, lost):
    """δ and s in proportion, dQ < μ dP: each spring is stretched in proportion to its compression, Q = ratio (s/δ) P."""
    law, overlap, sliding = hertz()
    part = np.linspace(0.0, 1.0, 4000) ** 2
    path = sheared(law, overlap * part, 0.5 * sliding * part, RATIO, shear, friction=FRICTION, springs=springs)
    assert path.shear_force[-1] == pytest.approx(0.5 * FRICTION * LOAD, rel=1e-3)
    # what is not stretched at all but slips is what enters beside stretched springs
    assert path.dissipated[-1] < (lost if shear == "slip" else 1.0) * path.stored[-1]


def test_direction_does_not_matter():
    law, overlap, sliding = hertz()
    turn = np.linspace(0.0, 4.0, 400)
    plane = sliding * np.stack([np.sin(turn), 0.7 * np.sin(2.3 * turn)], -1)
    angle = 0.6
    rotation = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    depth = overlap * (1.0 - 0.4 * np.sin(3.0 * turn))
    first, second = (sheared(law, depth, p, RATIO, "slip", friction=FRICTION) for p in (plane, plane @ rotation.T))
    np.testing.assert_allclose(second.shear_force, first.shear_force @ rotation.T, atol=1e-12 * LOAD)
    np.testing.assert_allclose(second.work, first.work, rtol=1e-10, atol=1e-12 * first.work.max())
    one = sheared(law, depth, plane[:, 0], RATIO, "slip", friction=FRICTION)
    two = sheared(law, depth, np.stack([plane[:, 0], 0 * turn], -1), RATIO, "slip", friction=FRICTION)
    np.testing.assert_array_equal(one.shear_force, two.shear_force[:, 0])


@pytest.mark.parametrize(("levels", "stored"), [(1, [1.0, 0.5, 0.25]), (2, [1.0, 0.5, 0.5]), (3, [1.0, 0.5, 0.5])])
def test_the_force_falls_with_the_stiffness_and_is_kept_where_it_rises(levels, stored):
    """One level shares the force that is left with the springs that touch again; of more, one keeps its stretch."""
    law, overlap, sliding = hertz()
    depth = overlap * np.array([1.0, 1.0, 0.25, 1.0])
    path = sheared(law, depth, np.outer([0.0, 0.1, 0.1, 0.1], [1.0, 0.5]) * sliding, RATIO, levels=levels)
    for along in path.shear_force.T:
        np.testing.assert_allclose(along[1:] / along[1], [1.0, 0.5, 0.5], rtol=1e-12)
    np.testing.assert_allclose(path.stored[1:] / path.stored[1], stored, rtol=1e-12)


def all_springs(stiffness, displacement, limit):
    """Shear force along a path with a list of springs (K_t below them, K_t with them, stretch), which are never joined."""
    springs, previous, before, forces = [], 0.0, np.zeros(2), []
    for top, place, largest in zip(stiffness, displacement, limit, strict=True):
        springs = [(low, min(high, top), stretch) for low, high, stretch in springs if low < top]
        if top > previous:
            springs.append((previous, top, np.zeros(2)))
        springs = [(low, high, stretch + place - before) for low, high, stretch in springs]
        force = sum(((high - low) * stretch for low, high, stretch in springs), np.zeros(2))
        share = min(1.0, largest / max(np.hypot(*force), 1e-300))
        springs = [(low, high, share * stretch) for low, high, stretch in springs]
        forces.append(share * force)
        previous, before = top, place
    return np.array(forces)


def vibrated(law, levels, size, cycles=1000, noise=False):
    """A contact that is loaded, sheared to about half of Coulomb's limit, then vibrated by ±`size` of the overlap."""
    overlap = law.overlap(LOAD)
    sideways = 0.5 * FRICTION * LOAD / law.shear_stiffness([overlap], RATIO)[0]
    ends = 1.0 + size * (np.random.default_rng(1).standard_normal(2 * cycles) if noise else np.tile([-1.0, 1.0], cycles))
    turns = np.concatenate([[1.0], ends, [1.0]])
    depth = np.concatenate([np.linspace(0.01, 1.0, 100), np.linspace(turns[:-1], turns[1:], 5)[1:].T.ravel()])
    across = np.concatenate([np.zeros(99), np.full(depth.size - 99, sideways)])
    return quiet(sheared, law, overlap * depth, across, RATIO, "elastic", friction=FRICTION, springs=32, levels=levels)


LAWS = [("hertz", "elastic"), ("pohrt-popov", "elastic"), ("pohrt-popov", "hertz"), ("rough-plastic", None)]


def kept(law, *arguments, **options):
    """Share of the shear force that is left after `vibrated`."""
    path = vibrated(law, *arguments, **options)
    return path.shear_force[-1] / path.shear_force[100]


@pytest.fixture
def any_levels(monkeypatch):
    """More levels than a contact may have, as the reference."""
    monkeypatch.setattr("demlaws.shear.MOST_LEVELS", 10_000)


@pytest.mark.parametrize("law", LAWS)
def test_a_contact_that_vibrates_keeps_its_shear_force(law, any_levels):
    """Three levels are within 0.01 of all springs at 0.1 and 1 %, and within 0.05 at 10 %; one level forgets the force."""
    law = make(*law)
    for size, tolerance in ((1e-3, 0.01), (1e-2, 0.01), (0.1, 0.05)):
        for noise in (False, True):
            every = kept(law, 4000, size, 200, noise=noise)
            assert kept(law, 3, size, 200, noise=noise) == pytest.approx(every, abs=tolerance)
    assert kept(law, None, 1e-2, 200) == kept(law, 3, 1e-2, 200) > 0.95
    assert kept(law, 1, 1e-2, 200) < 0.5


def test_many_levels_are_all_springs(any_levels):
    law, overlap, sliding = hertz()
    turn = np.linspace(0.0, 6.0, 400)
    plane = sliding * np.stack([np.sin(turn), 0.7 * np.sin(2.3 * turn)], -1)
    depth = overlap * (1.0 - 0.4 * np.sin(7.0 * turn))
    path = sheared(law, depth, plane, RATIO, friction=FRICTION, levels=1000)
    expected = all_springs(path.shear_stiffness, plane, FRICTION * path.force)
    np.testing.assert_allclose(path.shear_force, expected, atol=1e-12 * LOAD)


# what is followed is the rule's force: every rule with one law, and those that laws have of their own
every_pair = pytest.mark.parametrize(
    ("name", "unloading"), [p for p in pairs() if telling(p) and (p[0] == "pohrt-popov" or p[1] not in RULES)]
)
DEEP = 5.0 * GRANITE.sigma
BACK = np.array([0.4, 1.0, 1.0 - 1e-11, 0.999, 1.0, 1.0 + 1e-11, 1.1]) * DEEP


@every_pair
def test_what_each_choice_is(name, unloading):
    """Against the law's own stiffnesses: just below the overlap, and of first loading at that force."""
    law = make(name, unloading)
    path = law.follow(BACK)
    elastic, loading = (law.shear_stiffness(BACK, 0.5, choice) for choice in ("elastic", "loading"))
    below = [law.follow([*BACK[: n + 1], BACK[n] * (1 - 1e-9)]).stiffness[-1] for n in range(BACK.size)]
    np.testing.assert_allclose(elastic, 0.5 * np.array(below), rtol=1e-7)
    np.testing.assert_allclose(loading, 0.5 * law.stiffness(law.overlap(path.force)), rtol=1e-7)


@pytest.mark.parametrize(
    "call",
    [
        lambda law: sheared(law, [0.0, 1e-6], [0.0], 0.8),
        lambda law: sheared(law, [1e-6], [[0.0, 0.0, 0.0]], 0.8),
        lambda law: sheared(law, [1e-6], [0.0], 0.8, "slip"),
        lambda law: sheared(law, [1e-6], [0.0], 0.8, "slip", friction=0.5, springs=1),
        lambda law: sheared(law, [1e-6], [0.0], 0.8, "slip", friction=0.5, levels=3),
        lambda law: sheared(law, [1e-6], [0.0], 0.8, levels=0),
        lambda law: sheared(law, [1e-6], [0.0], 0.8, levels=2.5),
        lambda law: sheared(law, [2.0 * GRANITE.radius], [0.0], 0.8),
        lambda law: law.shear_stiffness(1.0, 0.8),
    ],
)
def test_bad_input(call):
    with pytest.raises(dl.DemlawsError):
        call(make("pohrt-popov", "hertz"))


@pytest.mark.parametrize("levels", [0, 9, 1000, 2.5])
def test_the_number_of_levels_is_1_to_8(levels):
    with pytest.raises(dl.DemlawsError, match=r"levels = .* from 1 to 8"):
        dl.driver.sheared(dl.law("hertz", dl.Contact(4e-3, 32e9)), [1e-6], [1e-7], 0.8, levels=levels)


# --- friction that depends on the pressure

PRESSURE_FRICTION = dl.PressureFriction(mu0=0.2, c1=0.5, c2=1e-9)


@pytest.mark.parametrize(("name", "rule"), [("hertz", "elastic"), ("pohrt-popov", "hertz"), ("conical-damage", "thornton")])
def test_the_limit_is_that_of_the_pressure(name, rule):
    """Slide at once on first loading and on unloading, with the radius of Hertz, of the smooth contact, of the blunted tip."""
    law = make(name, rule)
    overlap = quiet(law.overlap, 2000.0) * np.array([0.2, 0.6, 1.0, 0.99, 0.98])
    path = quiet(sheared, law, overlap, np.arange(5.0) * overlap.max(), RATIO, friction=PRESSURE_FRICTION)
    contact = law.contact
    equivalent = (0.75 * path.force / contact.modulus / contact.radius**0.5) ** (2 / 3)
    square = contact.radius * equivalent
    if name == "conical-damage":
        strength, h = law.options["strength"], (0.5 * np.pi * law.options["strength"] / contact.modulus) ** 2
        blunted = np.maximum.accumulate(path.force) * 0.75 / (contact.modulus * h**1.5)  # R² on first loading
        assert path.force[1] > contact.modulus * contact.radius**2 * h**1.5 / 0.75 and strength > 0
        radius = np.maximum(np.sqrt(blunted), contact.radius)
        square = radius * (0.75 * path.force / contact.modulus / radius**0.5) ** (2 / 3)
    limit = PRESSURE_FRICTION.coefficient(path.force / (np.pi * square)) * path.force
    assert np.ptp(limit[1:] / path.force[1:]) > 0.005
    np.testing.assert_allclose(np.abs(path.shear_force[1:]), limit[1:], rtol=1e-9)


@pytest.mark.parametrize("name", ["jackson-green", "kogut-etsion"])
@pytest.mark.parametrize("rule", ["elastic", "etsion"])
def test_pressure_of_a_table_of_a_law_with_an_area_of_its_own(name, rule, tmp_path):
    """Rule elastic: the table has no area, etsion: the law's."""
    modulus, strength = 35e9, 175e6
    law = dl.law(name, dl.Contact(10e-3, modulus), yield_strength=strength, unloading=rule)
    yields = (0.5 * np.pi * 1.6 * strength / modulus) ** 2 * 10e-3  # overlap of first yield, nearly
    overlap = np.array([6.0, 130.0]) * yields
    table = quiet(law.tabulate, max_force=float(1.01 * law.force(overlap[-1])))
    if rule == "etsion":
        np.testing.assert_allclose(*(quiet(_pressure_along, one, overlap) for one in (law, table)), rtol=1e-3)
        return
    table.save(tmp_path / "law.tbl")
    for one in (table, dl.Table.load(tmp_path / "law.tbl")):
        with pytest.raises(dl.DemlawsError, match="does not contain the contact area"):
            quiet(sheared, one, overlap, [0.0, 1e-6], RATIO, friction=PRESSURE_FRICTION)
        assert quiet(sheared, one, overlap, [0.0, 1e-6], RATIO, friction=0.5).shear_force[1] > 0.0
    below = np.array([0.3 * yields])
    small = quiet(law.tabulate, max_force=float(law.force(0.5 * yields)))
    assert quiet(_pressure_along, small, below) == pytest.approx(quiet(_pressure_along, law, below))


@pytest.mark.parametrize(("name", "rule"), [("hertz", "elastic"), ("kogut-etsion", "etsion")])
def test_pressure_of_a_table_file_of_a_former_version(name, rule, tmp_path):
    """Without the key `area`, whose absence stood for a known one: refused, but with a rule that describes the area."""
    options = {"yield_strength": 0.3e9} if rule == "etsion" else {}
    table = quiet(dl.law(name, GRANITE.with_values(sigma=0.0), rule, **options).tabulate, max_force=100.0)
    table.save(tmp_path / "new.tbl")
    lines = (tmp_path / "new.tbl").read_bytes().splitlines()[:-1]
    (tmp_path / "old.tbl").write_bytes(sealed([line for line in lines if line != b"area: known"]))
    overlap = quiet(table.overlap, [1.0, 10.0])
    new, old = (dl.Table.load(tmp_path / f"{age}.tbl") for age in ("new", "old"))
    expected = quiet(_pressure_along, new, overlap)
    if rule == "etsion":
        assert (b"area: known" in lines, *quiet(_pressure_along, old, overlap)) == (False, *expected)
        return
    with pytest.raises(dl.DemlawsError, match="table of a former version"):
        quiet(sheared, old, overlap, [0.0, 1e-6], RATIO, friction=PRESSURE_FRICTION)


@pytest.mark.parametrize("rule", ["elastic", "hertz"])
def test_pressure_of_a_blunter_bulk(rule):
    """Of rough-plastic with bulk_radius: Hertz's of R_b before yield, the yield pressure far beyond; the table has no area."""
    law = dl.law("rough-plastic", GRANITE, rule, yield_pressure=0.2e9, bulk_radius=4 * GRANITE.radius)
    overlap = quiet(law.overlap, [1.0, 3e4])
    before, beyond = quiet(_pressure_along, law, overlap)
    square = 4 * GRANITE.radius * (0.75 / GRANITE.modulus / (4 * GRANITE.radius) ** 0.5) ** (2 / 3)
    assert before == pytest.approx(1.0 / (np.pi * square), rel=1e-9) and beyond == pytest.approx(0.2e9, rel=2e-2)
    with pytest.raises(dl.DemlawsError, match="does not contain the contact area"):
        quiet(sheared, quiet(law.tabulate), overlap[:1], [0.0], RATIO, friction=PRESSURE_FRICTION)


@pytest.mark.parametrize("paths", [20, pytest.param(1000, marks=pytest.mark.slow)])
@pytest.mark.parametrize("shear", ["elastic", "loading", "slip"])
@each_law_and_rule
def test_friction_by_pressure_creates_no_energy(name, unloading, shear, paths):
    """Random paths whose overlap and displacement change together; the same with c1 = 0 as with a number."""
    law = make(name, unloading)
    scale, random = quiet(law.overlap, LOAD), np.random.default_rng(7)
    for _ in range(paths):
        overlap = scale * np.clip(1.0 + 0.4 * random.standard_normal(150).cumsum(), -0.1, 3.0)
        across = 0.3 * scale * random.standard_normal((150, 2)).cumsum(0)
        result = quiet(sheared, law, overlap, across, RATIO, shear, friction=PRESSURE_FRICTION, springs=8)
        assert np.diff(result.dissipated).min() >= -1e-12 * np.abs(result.work).max()
        assert np.all(np.hypot(*result.shear_force.T) <= 0.7 * np.maximum(result.force, 0.0) * (1 + 1e-9))
    one = quiet(sheared, law, overlap, across, RATIO, shear, friction=dl.PressureFriction(0.4, 0.0, 1e-9), springs=8)
    other = quiet(sheared, law, overlap, across, RATIO, shear, friction=0.4, springs=8)
    np.testing.assert_array_equal(one.shear_force, other.shear_force)


def test_friction_of_two_materials_and_values_that_are_refused():
    assert PRESSURE_FRICTION.combined(dl.PressureFriction(0.3, 0.1, 0.0)) == dl.PressureFriction(0.2, 0.1, 0.0)
    for values in ((-0.1, 0.1, 0.0), (0.1, float("nan"), 0.0), (0.1, 0.1, -1e-9), ("much", 0.1, 0.0)):
        with pytest.raises(dl.DemlawsError):
            dl.PressureFriction(*values)
    law = make("hertz")
    hard = dl.law("hertz", law.contact.with_values(hardness=1e9))
    with pytest.warns(dl.ValidityWarning, match="above the hardness"):
        sheared(hard, [0.0, float(quiet(law.overlap, 3000.0))], [0.0, 0.0], RATIO, friction=PRESSURE_FRICTION)
