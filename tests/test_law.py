"""What every law of the registry must do, with every unloading rule that it takes."""

import copy
import math
import os
import pickle
import signal
import warnings

import numpy as np
import pytest
from examples import ALIKE, CONTACTS, GRANITE, SOFT, each_law_and_rule, make, options_of, pairs, rules_of, shared, telling
from references import EPS

import demlaws as dl
from demlaws.core.unloading import GIVEN
from demlaws.curves.soundness import curve_checks
from demlaws.curves.unloading import largest_stiffness_ratio
from demlaws.errors import LargeOverlap
from demlaws.laws.registry import registry
from demlaws.make import example_law
from demlaws.surface import HeightMap

pytestmark = pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")

LAWS = dl.laws()
PAIRS = pairs()
EACH = [(name, contact) for name in LAWS for contact in CONTACTS]
# a law of a measured map has its roughness from there, not from the contact
every_rough_law = pytest.mark.parametrize("name", [n for n, d in registry().items() if not d.needs_map])
every_law = pytest.mark.parametrize("name", LAWS)
every_contact = pytest.mark.parametrize(("name", "contact"), EACH)

BATCH_OF_CONTACTS = dl.Contact(
    radius=np.array([3e-3, 4.35e-3, 5e-3, 6e-3, 4.1e-3]),
    modulus=np.array([32.32e9, 30e9, 32.32e9, 25e9, 32.32e9]),
    sigma=np.array([4e-6, 2.4e-6, 2e-6, 3e-6, 2.5e-6]),
    fractal_dimension=2.22,
    hardness=6.266e9,
)


# --- the curve


@every_contact
def test_the_curve_passes_every_check(name, contact):
    """Force of an overlap, overlap of a force, stiffness and energy: what `check_law` measures of a user-defined law."""
    law = make(name, contact=contact)
    checks = curve_checks(law.shape, law.params, law.contact.radius, law.definition.solved)
    failed = [check for check in checks if not check.passed]
    assert not failed


@every_contact
def test_positive_and_finite_at_every_overlap(name, contact):
    """From 1e-15 of the roughness to 0.2 of the radius; the checks of the curve look from 1e-9 to 0.1 of the radius."""
    law = make(name, contact=contact)
    overlap = np.geomspace(1e-15 * law.contact.sigma, 0.2 * law.contact.radius, 20000)
    force = law.force(overlap)
    for values in (force, law.stiffness(overlap), law.energy(overlap), law.overlap(force)):
        assert np.all(np.isfinite(values)) and np.all(values > 0)
    # rough laws start from a seating load that moves by less than rounding between the first points; kinks round, too
    assert np.min(np.diff(force) / force[1:]) >= -64 * EPS
    assert np.all(np.diff(law.energy(overlap)) > 0)


@every_law
def test_no_overlap_no_force(name):
    law = make(name)
    values = np.array([0.0, -0.0, -1e-9, -1.0])
    for method in (law.force, law.stiffness, law.energy, law.overlap):
        np.testing.assert_array_equal(method(values), 0.0)


# --- towards a smooth surface


def smooth_options(name):
    """Options with which a law is Hertz's where the surface is smooth."""
    flat = HeightMap(np.zeros((8, 8)), 1e-6)
    special = {"goddard": {"slope": 0.0}, "asperity": {"surface": flat}}
    strong = {option: 1e15 for option in ("yield_pressure", "yield_strength", "strength") if option in options_of(name)}
    return special.get(name) or {**options_of(name), **strong}


@every_rough_law
def test_goes_over_into_its_smooth_limit_without_a_jump(name):
    """σ → 0 at equal force: what differs from σ = 0 shrinks with σ, through denormal numbers, to nothing; that is Hertz."""

    def curve(roughness):
        law = dl.law(name, GRANITE.with_values(sigma=roughness), **smooth_options(name))
        overlap = law.overlap(np.geomspace(1.0, 1e4, 12))
        # differences of overlap: a law with a seating load counts from there
        return np.concatenate([overlap[1:] - overlap[:-1], law.stiffness(overlap)])

    # the solved laws are taken for Hertz's from where they are within 3e-4 of it
    floor = 3e-4 if registry()[name].solved else 64 * EPS
    limit, last = curve(0.0), math.inf
    for exponent in [*np.arange(-6.0, -12.0, -0.5), -20, -35, -38, -39, -40, -41, -45, -100, -300, -320]:
        differs = np.max(np.abs(curve(GRANITE.radius * 10.0**exponent) / limit - 1))
        assert differs <= max(0.6 * last, floor), exponent
        last = differs
    assert last <= 16 * EPS
    if any(rule.name == "linear" for rule in registry()[name].rules.own):  # straight, not Hertz's
        return
    law, hertz = dl.law(name, GRANITE.with_values(sigma=0.0), **smooth_options(name)), dl.law("hertz", GRANITE)
    overlap = np.geomspace(1e-9, 1e-4, 40)
    # Bahrami's constants have three digits: their p0' = 1 is 1.00035 of Hertz's overlap
    rtol = 6e-4 if name == "bahrami" else 1e-13
    for method, factor in (("force", 1), ("stiffness", 1), ("energy", 10)):
        np.testing.assert_allclose(getattr(law, method)(overlap), getattr(hertz, method)(overlap), rtol=factor * rtol)


# --- numbers and arrays


@every_law
def test_scalars_and_shapes(name):
    law = make(name)
    overlap = np.array([[1e-6, 2e-6, 3e-6], [4e-6, 5e-6, 6e-6]])
    for method, values in (
        *((method, overlap) for method in (law.force, law.stiffness, law.energy)),
        (law.overlap, law.force(overlap)),
    ):
        one = method(float(values[0, 0]))
        assert type(one) is float
        assert type(method(0)) is float
        result = method(values)
        assert result.shape == (2, 3)
        assert result.dtype == np.float64
        np.testing.assert_allclose(result.ravel(), [method(float(v)) for v in values.ravel()], rtol=4 * EPS)
        assert method(values.ravel().tolist()).shape == (6,)
        assert method(np.empty(0)).shape == (0,)
        np.testing.assert_array_equal(method(values[:, ::2]), result[:, ::2])


@each_law_and_rule
def test_contacts_in_arrays_follow_their_own_paths(name, unloading, rng):
    """Steps of a batch of unlike contacts: forces, stiffnesses and histories are those of each contact's path."""
    options, batch = options_of(name), BATCH_OF_CONTACTS
    if registry()[name].needs_map:  # contacts of one map: at the radii of its curves
        radii = GRANITE.radius * np.geomspace(1.0, 1.05**2, 3)[[0, 1, 2, 0, 2]]
        batch = GRANITE.with_values(radius=radii)
    ones = [
        GRANITE.with_values(**{k: float(np.broadcast_to(getattr(batch, k), 5)[i]) for k in ("radius", "modulus", "sigma")})
        for i in range(batch.size)
    ]
    many = example_law(name, batch, unloading, **options)
    steps = rng.uniform(-1e-6, 1e-5, (20, 5))
    paths = [example_law(name, one, unloading, **options).follow(x) for one, x in zip(ones, steps.T, strict=True)]
    state = many.new_state(5) if many.state_size else None
    rtol = 1e-4 if registry()[name].solved else 32 * EPS  # solved laws blend two curves
    # what follows from δ - δp, a small difference of overlaps, has an absolute tolerance, on the scale of the path
    for n, overlap in enumerate(steps):
        out = np.empty(5), np.empty(5)
        found = many.evaluate(overlap, state, out=out)
        assert (found[0] is out[0], found[1] is out[1]) == (True, True)
        for quantity, values in zip(("force", "stiffness"), found, strict=True):
            wanted = np.array([getattr(path, quantity) for path in paths])
            atol = 16 * rtol * wanted.max()
            np.testing.assert_allclose(values, wanted[:, n], rtol=16 * rtol, atol=atol)
        for quantity in many.state_names[:2] if many.state_names[:1] == ("maximum_overlap",) else ():
            wanted = [getattr(path, quantity)[n] for path in paths]
            np.testing.assert_allclose(getattr(state, quantity), wanted, rtol=rtol, atol=10 * rtol * 1e-5)
    assert many.force(9e-6).shape == (5,)
    overlap = np.linspace(2e-6, 9e-6, 5)
    np.testing.assert_allclose(many.overlap(many.force(overlap)), overlap, rtol=1e-10 if registry()[name].solved else 1e-12)


@pytest.mark.parametrize(
    ("name", "unloading"), [pair for pair in PAIRS if pair[0] in ("pohrt-popov", "yip-venart") and telling(pair)]
)
def test_float32_storage_with_double_arithmetic(name, unloading):
    """Results are those of the stored overlaps in double, rounded once."""
    law = make(name, unloading)
    overlap = np.linspace(2e-6, 9e-6, 5).astype(np.float32)
    state = law.new_state(5, np.float32)
    force, stiffness = law.evaluate(overlap, state if law.state_size else None)
    assert force.dtype == stiffness.dtype == np.float32
    exact = law.force(overlap.astype(float)), law.stiffness(overlap.astype(float))
    np.testing.assert_array_max_ulp(force, exact[0].astype(np.float32), 1, dtype=np.float32)
    np.testing.assert_array_max_ulp(stiffness, exact[1].astype(np.float32), 1, dtype=np.float32)
    for array in state.arrays:
        assert array.dtype == np.float32
    double = law.new_state(5)
    law.evaluate(overlap.astype(float), double if law.state_size else None)
    back = overlap * np.float32(0.9)
    single = law.evaluate(back, state if law.state_size else None)
    # unloading depends on δ - δp, whose rounding in storage costs its share of δ
    for a, b in zip(single, law.evaluate(back.astype(float), double if law.state_size else None), strict=True):
        np.testing.assert_allclose(a, b, rtol=2e-5)


@each_law_and_rule
def test_parallel_is_equal_bit_for_bit(name, unloading, rng):
    law = make(name, unloading)
    n = 150_001  # fewer are not shared out
    overlap = rng.uniform(-1e-6, 1e-5, n)
    results = []
    for parallel in (False, True):
        state = law.new_state(n) if law.state_size else None
        run = []
        for factor in (1.0, 0.8, 0.95, 1.1):
            run += law.evaluate(factor * overlap, state, parallel=parallel)
        results.append([*run, *(state.arrays if state is not None else ())])
    for a, b in zip(*results, strict=True):
        np.testing.assert_array_equal(a, b)


# along jackson-green's curve an overlap that is NaN had a force of some hundred newtons
@pytest.mark.parametrize(
    ("name", "unloading"),
    shared([*filter(telling, PAIRS), ("jackson-green", GIVEN)], lambda p: telling(p) and p[0] not in ALIKE),
)
@pytest.mark.parametrize("beyond", [math.inf, 1.001 * GRANITE.radius, math.nan, 1e300])
def test_what_cannot_be_answered_leaves_the_history_as_it_was(name, unloading, beyond):
    law = make(name, unloading)
    state = law.new_state(3) if law.state_size else None
    law.evaluate(np.full(3, 5e-6), state)
    kept = [array.copy() for array in state.arrays] if law.state_size else []
    expected = law.evaluate(np.full(3, 4.8e-6), state)[0]
    out = np.empty(3), np.empty(3)
    with pytest.raises(dl.DemlawsError, match="contact 1: "):
        law.evaluate(np.array([4.8e-6, beyond, 4.8e-6]), state, out)
    assert math.isnan(out[0][1])
    np.testing.assert_array_equal(out[0][[0, 2]], expected[[0, 2]])
    for array, old in zip(state.arrays if law.state_size else (), kept, strict=True):
        np.testing.assert_array_equal(array, old)
    np.testing.assert_array_equal(law.evaluate(np.full(3, 4.8e-6), state)[0], expected)


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_a_small_grain_does_not_bound_the_others(dtype):
    """Overlaps beyond the radius of the smallest contact of a batch, though not of their own: loaded, unloaded, reloaded."""
    many = GRANITE.with_values(radius=np.array([1e-5, 4e-3, 2e-5, 5e-3]))
    law = dl.law("pohrt-popov", many, "hertz")
    state = law.new_state(4, dtype)
    alone = [dl.law("pohrt-popov", GRANITE.with_values(radius=float(r)), "hertz") for r in many.radius]
    states = [one.new_state(1, dtype) for one in alone]
    for overlap in ([2e-7, 5e-5, 1e-7, 3e-6], [1.9e-7, 4.99e-5, 9e-8, 4e-5], [2.5e-7, 6e-5, 1.2e-7, 3.9e-5]):
        overlap = np.array(overlap, dtype)
        force, stiffness = law.evaluate(overlap, state)
        for i, (one, own) in enumerate(zip(alone, states, strict=True)):
            expected = one.evaluate(overlap[[i]], own)
            np.testing.assert_array_max_ulp(np.array([force[i], stiffness[i]]), np.ravel(expected), 4, dtype=dtype)
    kept = [array.copy() for array in state.arrays]
    with pytest.raises(dl.DemlawsError, match="contact 0: "):
        law.evaluate(np.array([5e-5, 5.9e-5, 1e-7, 3.8e-5], dtype), state)
    assert state.arrays[0][0] == kept[0][0] and state.arrays[1][0] == kept[1][0]


def test_beyond_the_end_of_a_table_the_history_stays():
    table = make("pohrt-popov", "hertz").tabulate(rtol=1e-3, max_force=50.0)
    many = make("pohrt-popov").tabulate(rtol=1e-3, max_force=50.0).bound_to(BATCH_OF_CONTACTS).joined("hertz")
    for law in (table, many, dl.law("pohrt-popov", GRANITE, table.joined("elastic"))):
        n = law.contact.size or 5
        state = law.new_state(n)
        law.evaluate(np.full(n, 2e-6), state)
        kept = [array.copy() for array in state.arrays]
        overlap = np.full(n, 1.9e-6)
        overlap[1] = 2e-4
        with pytest.raises(dl.DemlawsError, match="contact 1: "):
            law.evaluate(overlap, state)
        for array, old in zip(state.arrays, kept, strict=True):
            np.testing.assert_array_equal(array, old)


# --- range


def test_overlaps_beyond_a_tenth_of_the_radius_warn_and_beyond_the_radius_are_refused():

    def fresh(**changes):
        return dl.law("hertz", dl.Contact(4.35e-3, 32e9).with_values(**changes))

    small, large, huge = 0.0999 * 4.35e-3, 0.11 * 4.35e-3, 1.0
    for call in (
        lambda law, x: law.force(x),
        lambda law, x: law.stiffness(x),
        lambda law, x: law.energy(x),
        lambda law, x: law.overlap(4 / 3 * 32e9 * math.sqrt(4.35e-3) * x**1.5),
        lambda law, x: law.follow([1e-6, x]),
        lambda law, x: law.evaluate(np.array([1e-6, x])),
    ):
        law = fresh()
        with warnings.catch_warnings():
            warnings.simplefilter("error", dl.ValidityWarning)
            call(law, small)
        for filtered, expected in (("default", 1), ("always", 2)):
            with warnings.catch_warnings(record=True) as seen:
                warnings.simplefilter(filtered)
                for factor in (1.0, 1.01):
                    call(law, factor * large)
            assert [one.category for one in seen] == [LargeOverlap] * expected
        with pytest.raises(dl.DemlawsError):
            call(law, huge)
    several = fresh(radius=np.array([1e-3, 4.35e-3, 0.1]))
    with pytest.warns(dl.ValidityWarning, match="above 0.0001 m, .* R = 0.001 m"):
        several.evaluate(np.full(3, 1.1e-4))
    with pytest.raises(dl.DemlawsError, match="contact 0 "):
        several.evaluate(np.full(3, 5e-3))


@pytest.mark.parametrize("overlap", [[1e-6, 2e-6], (1, 0), ["1um", "2um"], np.array([0, 0]), np.float16([0.0, 1e-3])])
def test_a_batch_takes_what_a_force_takes(overlap):
    law = dl.law("hertz", dl.Contact(10.0, 32e9))
    np.testing.assert_array_equal(law.evaluate(overlap)[0], law.force(overlap))


# --- threads


def test_parallel_works_in_a_child_made_by_fork():
    law, n = make("hertz"), 150_001
    overlap = np.linspace(0.0, 1e-5, n)
    expected = law.evaluate(overlap, parallel=True)[0]
    child = os.fork()
    if child == 0:
        signal.alarm(20)  # a child that hangs is killed
        os._exit(0 if np.array_equal(law.evaluate(overlap, parallel=True)[0], expected) else 1)
    assert os.waitpid(child, 0)[1] == 0


# --- what is kept


def test_setting_a_quantity_of_a_state_sets_it():
    law = make("pohrt-popov", "hertz")
    state = law.new_state(3)
    array = state.maximum_overlap
    state.maximum_overlap = [1e-6, 2e-6, 3e-6]
    state.plastic_overlap = 5e-7
    np.testing.assert_array_equal(array, [1e-6, 2e-6, 3e-6])
    np.testing.assert_array_equal(state.arrays[1], 5e-7)
    for name, value in (("maximum_overlap", np.zeros(4)), ("maximum_overlap", "deep"), ("maximum", 1.0), ("arrays", ())):
        with pytest.raises((ValueError, AttributeError, TypeError)):
            setattr(state, name, value)


TWINS = {"deepcopy": copy.deepcopy, "pickle": lambda thing: pickle.loads(pickle.dumps(thing))}


@pytest.mark.parametrize("twin", TWINS.values(), ids=TWINS)
def test_states_paths_and_contacts_can_be_copied_and_pickled(twin):
    law = make("pohrt-popov", "thornton")
    state = law.new_state(4, dtype=np.float32)
    state.maximum_overlap = 3e-6
    other = twin(state)
    assert other.names == state.names
    assert other.maximum_overlap is not state.maximum_overlap
    assert [a.dtype for a in other.arrays] == [np.float32] * 3
    np.testing.assert_array_equal(other.arrays, state.arrays)
    path = law.follow([1e-6, 3e-6, 2e-6])
    np.testing.assert_array_equal(twin(path), path)
    np.testing.assert_array_equal(twin(path).work, path.work)
    assert twin(GRANITE) == GRANITE
    np.testing.assert_array_equal(twin(BATCH_OF_CONTACTS).radius, BATCH_OF_CONTACTS.radius)


@each_law_and_rule
@pytest.mark.parametrize("twin", TWINS.values(), ids=TWINS)
def test_laws_and_tables_can_be_copied_and_pickled(name, unloading, twin):
    law = make(name, unloading)
    overlap = np.array([1e-6, 3e-6, 2.9e-6])
    for thing in (law, law.tabulate(rtol=1e-3)) if name == "pohrt-popov" else (law,):
        again = twin(thing)
        assert repr(again) == repr(thing)
        np.testing.assert_array_equal(again.follow(overlap).force, thing.follow(overlap).force)


# --- errors


def read_only(n):
    arrays = np.zeros(n), np.zeros(n)
    arrays[1].flags.writeable = False
    return arrays


def in_place(law, out):
    overlap, state = np.full(3, 1e-6), law.new_state(3)
    law.evaluate(overlap, state, out(overlap, state))


# junk in each argument: test_junk.py
@pytest.mark.parametrize(
    "call",
    [
        lambda law: law.evaluate(np.zeros(3, int)),
        lambda law: law.evaluate(np.zeros(3), law.new_state(4)),
        lambda law: law.evaluate(np.zeros(3), law.new_state(3), out=(np.zeros(2), np.zeros(3))),
        lambda law: law.evaluate(np.zeros(3), law.new_state(3), out=(np.zeros(3, int), np.zeros(3))),
        lambda law: law.evaluate(np.zeros(3), law.new_state(3), out=(np.zeros(3), [0, 0, 0])),
        lambda law: law.evaluate(np.zeros(3), law.new_state(3), out=read_only(3)),
        lambda law: in_place(law, lambda x, s: (x, np.zeros(3))),
        lambda law: in_place(law, lambda x, s: (np.zeros(3), s.arrays[1])),
        lambda law: in_place(law, lambda x, s: (s.arrays[0][::-1], x)),
        lambda law: in_place(law, lambda x, s: [np.zeros(3)] * 2),
        lambda law: law.evaluate(np.zeros(3), make("hertz", "thornton").new_state(3)),
        lambda law: law.follow([1e-6], law.new_state(2)),
        lambda law: law.new_state(1, int),
        lambda law: law.new_state(1, np.float16),
    ],
)
def test_bad_calls(call):
    with pytest.raises(dl.DemlawsError):
        call(make("pohrt-popov", "hertz"))


def test_bad_laws():
    many = dl.law("hertz", BATCH_OF_CONTACTS)
    for call in (
        lambda: dl.law("hertz", GRANITE, slope=0.1),
        lambda: many.force(np.zeros(4)),
        lambda: many.evaluate(np.zeros(4)),
        lambda: many.follow([1e-6]),
        lambda: dl.law("hertz", dl.Contact(radius=np.empty(0), modulus=1e9)),
    ):
        with pytest.raises(dl.DemlawsError):
            call()


@every_law
def test_needs_and_warnings(name):
    """A law without what it needs is refused; outside its source's range a warning is issued, as Python's filters say."""
    definition = registry()[name]
    for field in definition.loading.needs:
        with pytest.raises(dl.DemlawsError, match=f"needs the contact's {field}"):
            dl.law(name, GRANITE.with_values(**{field: None}), **options_of(name))
    law = dl.law(name, GRANITE, **options_of(name))
    for limit in law.limits():
        assert limit.minimum_force < limit.maximum_force
        outside = 0.99 * limit.minimum_force if limit.minimum_force > 0 else 1.01 * limit.maximum_force
        with pytest.warns(dl.ValidityWarning, match=f"{name} (above|below) .* N: "):
            dl.law(name, GRANITE, **options_of(name)).overlap(outside)
        for filtered, expected in (("default", 1), ("always", 2)):
            with warnings.catch_warnings(record=True) as seen:
                warnings.simplefilter(filtered)
                for _ in range(2):
                    dl.law(name, GRANITE, **options_of(name)).overlap(outside)
            assert sum(limit.reason in str(one.message) for one in seen) == expected


def test_passivity_is_measured_where_it_is_worst():
    assert largest_stiffness_ratio(dl.law("hertz", SOFT))[0] == pytest.approx(1.0, abs=1e-12)
    assert largest_stiffness_ratio(dl.law("bahrami", GRANITE))[0] > 1.05
    general = {name for name in LAWS if "hertz" in rules_of(name)}
    assert {name for name, rule in PAIRS if rule == "hertz"} == general - {"bahrami"}
    assert {n for n, rule in PAIRS if rule == "thornton" and n in general} == general - {"bahrami"}
    assert all((name, registry()[name].default_rule()) in PAIRS for name in LAWS)
    assert {n for n, rule in PAIRS if rule == "elastic"} == set(LAWS)


@pytest.mark.parametrize("force", [-5.0, 0.0])
def test_a_force_without_contact_has_no_overlap_and_no_warning(force):
    contact = dl.Contact(radius=4e-3, modulus=32e9, sigma=2e-6, fractal_dimension=2.2, hardness=6e9)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert all(dl.law(name, contact).overlap(force) == 0.0 for name in ("hertz", "pohrt-popov"))


def test_the_name_of_a_law_comes_first():
    contact = dl.Contact(radius=4e-3, modulus=32e9)
    with pytest.raises(dl.DemlawsError, match=r"dl\.law\(NAME, contact\)"):
        dl.law(contact, "hertz")
