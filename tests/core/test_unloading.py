"""Unloading rules with every law that takes them: no closed path returns work, and history is what it should be."""

import itertools
import pickle
import re
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from examples import GRANITE, each_law_and_rule, make, options_of, pairs, quiet, rules_of, shared, telling, work_along
from hypothesis import given, settings, strategies as st
from references import EPS

import demlaws as dl
from demlaws.core import dispatch, numba_compat
from demlaws.core.unloading import RULES
from demlaws.errors import NotPassive
from demlaws.laws.definition import CLOSED, HERTZ_CURVE
from demlaws.laws.registry import registry

pytestmark = pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")

PAIRS = pairs(with_curves=dl.laws())
WITH_HISTORY = [pair for pair in PAIRS if pair[1] != "elastic"]
# a law whose every force is an equation solved takes seconds
every_pair = pytest.mark.parametrize(
    ("name", "unloading"),
    shared(PAIRS, lambda pair: telling(pair) and registry()[pair[0]].loading.computed in (HERTZ_CURVE, CLOSED)),
)
every_history = pytest.mark.parametrize(("name", "unloading"), shared(WITH_HISTORY, telling))

# turning points as multiples of the roughness: from far below it to far above, and parted
TURNS = st.lists(st.one_of(st.floats(1e-6, 1e-2), st.floats(1e-2, 30.0), st.just(0.0), st.just(-1.0)), min_size=1, max_size=8)


@every_pair
@given(turns=TURNS)
@settings(max_examples=20)
def test_no_closed_path_returns_work(name, unloading, turns):
    """∮P dδ of the forces alone, from a virgin contact and back to no overlap; and each time the path comes by 0."""
    law = make(name, unloading)
    corners = [*(GRANITE.sigma * np.array(turns)), 0.0]
    work = work_along(law, corners)
    path = quiet(law.follow, np.array(corners))
    # 1e-8: Gauss's rule in steps over the cells of a table; every other law is integrated to 1e-10
    scale = np.max(np.abs(work)) + np.max(path.dissipated)
    tolerance = (1e-8 if registry()[name].solved else 1e-10) * scale
    parted = np.array(corners) <= 0.0
    assert np.all(work[parted] >= -tolerance)
    np.testing.assert_allclose(path.work, work, rtol=0.0, atol=tolerance)
    assert np.all(path.stored >= 0.0)
    assert np.all(path.stored[parted] == 0.0)
    # δp may fall by what the check of passivity lets pass, 1e-9 of a step, where both curves have become Hertz's
    rounding = (1e-10 if unloading == "table" else 4 * EPS) * scale
    assert np.all(np.diff(path.dissipated) >= -rounding)
    assert path.dissipated[0] >= -rounding
    if unloading == "elastic":
        np.testing.assert_array_equal(path.dissipated, 0.0)


@every_history
@given(turns=st.lists(st.floats(0.3, 1.0), min_size=2, max_size=6), first=st.floats(0.01, 20.0))
@settings(max_examples=20)
def test_cycles_below_the_maximum_are_closed(name, unloading, turns, first):
    """Below δmax the contact is elastic: one force an overlap, however it was reached, and no work for a cycle."""
    law = make(name, unloading)
    maximum = first * GRANITE.sigma
    path = law.follow(np.array([maximum, *(maximum * np.array(turns)), maximum * turns[0], maximum]))
    assert path.force[-2] == path.force[1]
    assert path.work[-2] == pytest.approx(path.work[1], rel=1e-12, abs=1e-14 * path.work[0])
    assert path.work[-1] == pytest.approx(path.work[0], rel=1e-12)
    assert path.dissipated[-1] == pytest.approx(path.dissipated[0], rel=1e-12, abs=1e-15 * path.work[0])


@each_law_and_rule
@given(turns=TURNS, pieces=st.integers(2, 9))
@settings(max_examples=20)
def test_refining_a_path_changes_nothing(name, unloading, turns, pieces):
    """Bit for bit, at the points that the paths share."""
    law = make(name, unloading)
    corners = np.array([0.0, *(GRANITE.sigma * np.array(turns))])
    fine = [np.linspace(a, b, pieces + 1)[1:] for a, b in itertools.pairwise(corners)]
    for branch, corner in zip(fine, corners[1:], strict=True):
        branch[-1] = corner
    coarse, refined = law.follow(corners[1:]), law.follow(np.concatenate(fine))
    last = np.arange(1, len(fine) + 1) * pieces - 1
    for quantity in ("force", "stiffness", "maximum_overlap", "plastic_overlap", "stored"):
        np.testing.assert_array_equal(getattr(coarse, quantity), getattr(refined, quantity)[last], err_msg=quantity)
    scale = 16 * EPS * len(turns) * np.max(coarse.work)
    np.testing.assert_allclose(coarse.work, refined.work[last], rtol=0, atol=scale)


@every_history
def test_unloading_curve_and_reload(name, unloading):
    """P = (4/3) E* √R_p (δ - δp)^1.5 or the given curve of δ - δp, through (δmax, Pmax); no force below δp; reload likewise."""
    law = make(name, unloading)
    for maximum in GRANITE.sigma * np.array([0.1, 1.0, 8.0]):
        force, stiffness = law.force(maximum), law.stiffness(maximum)
        state = law.new_state(1)
        law.follow([maximum], state)
        plastic = float(state.plastic_overlap[0])
        assert state.maximum_overlap[0] == maximum
        down = maximum - np.linspace(0.0, 1.2, 50)[1:] * (maximum - plastic)
        down = down[down > 0.0]
        path = law.follow(down, state.copy())
        elastic = np.maximum(down - plastic, 0.0)
        if unloading == "table":
            curve, tangent = law.unloading_law.force(elastic), law.unloading_law.stiffness(elastic)
        elif registry()[name].rule(unloading).curve == "law":  # its closed form is tested in tests/laws
            curve, tangent = path.force, path.stiffness
        else:
            coefficient = law.params.hertz_coefficient
            if unloading == "thornton":
                assert state.radius_ratio[0] >= 1.0 - 1e-9
                coefficient *= np.sqrt(state.radius_ratio[0])
            curve, tangent = coefficient * elastic**1.5, 1.5 * coefficient * np.sqrt(elastic)
        # δ - δp is a difference: its rounding is that of δ
        noise = 8 * EPS * maximum * tangent
        np.testing.assert_array_less(np.abs(path.force - curve), 1e-13 * path.force + noise + 1e-300)
        np.testing.assert_allclose(path.stiffness, tangent, rtol=1e-7, atol=1e-7 * tangent.max())
        if plastic > 0.0:
            gap = law.follow(np.array([0.999, 0.5, 0.01]) * plastic, state.copy())
            np.testing.assert_array_equal(gap.force, 0.0)
            np.testing.assert_array_equal(gap.stiffness, 0.0)
            assert gap.maximum_overlap[-1] == maximum  # a gap inside the overlap keeps the history
        # reloading to the maximum meets the virgin curve, exactly; then first loading goes on
        back = law.follow([down[3], maximum, 1.1 * maximum], state.copy())
        assert back.force[1] == force
        assert back.stiffness[1] == stiffness
        assert back.force[2] == law.force(1.1 * maximum)
        just = law.follow([maximum * (1.0 - EPS)], state.copy())
        assert just.force[0] == pytest.approx(force, rel=1e-12)
        # turning back, the contact is as stiff as its unloading curve at that load: stiffer than before
        assert just.stiffness[0] >= stiffness * (1.0 - 1e-9)


@pytest.mark.parametrize(("name", "unloading"), list(filter(telling, WITH_HISTORY)))
def test_unloading_overlap_is_the_inverse(name, unloading):
    law = make(name, unloading)
    maximum = 2.0 * GRANITE.sigma
    state = law.new_state(1)
    law.follow([maximum], state)
    forces = law.force(maximum) * np.array([0.999, 0.5, 0.1, 1e-3])
    overlaps = law.unloading_overlap(forces, state)
    np.testing.assert_allclose(law.follow(overlaps, state.copy()).force, forces, rtol=1e-9)
    assert law.unloading_overlap(0.0, state) == pytest.approx(state.plastic_overlap[0], abs=1e-20)


@each_law_and_rule
@pytest.mark.parametrize("parted", [0.0, -1e-9])
def test_a_contact_that_parted_is_virgin(name, unloading, parted):
    law = make(name, unloading)
    overlap = GRANITE.sigma * np.array([0.5, 0.2, 3.0])
    state = law.new_state(1)
    path = law.follow([1e-5, 8e-6, parted], state)
    assert path.force[-1] == path.stiffness[-1] == 0.0
    for array in state.arrays:
        np.testing.assert_array_equal(array, 0.0)
    again, fresh = law.follow(overlap, state), law.follow(overlap)
    for quantity in ("force", "stiffness", "maximum_overlap", "plastic_overlap", "stored"):
        np.testing.assert_array_equal(getattr(again, quantity), getattr(fresh, quantity))
    np.testing.assert_array_equal(again.dissipated, fresh.dissipated + path.dissipated[-1])


@each_law_and_rule
def test_a_path_in_pieces_is_the_path_in_one(name, unloading):
    """The dissipation of earlier closings was lost where a path went on from a state; copies of the state go on, too."""
    law = make(name, unloading)
    overlap = GRANITE.sigma * np.array([1.0, 0.4, -0.1, 2.0, 0.0, 0.7, 0.3, -1e-3, 1.5, 1.0])
    whole, state, dissipated = law.follow(overlap), law.new_state(1), []
    for piece in np.split(overlap, [2, 3, 4, 7, 8]):
        state = pickle.loads(pickle.dumps(state)).copy()
        dissipated.append(law.follow(piece, state).dissipated)
    np.testing.assert_allclose(np.concatenate(dissipated), whole.dissipated, rtol=1e-15)
    if name == "pohrt-popov" and unloading != "elastic":
        assert whole.dissipated[-1] > 2.0 * whole.dissipated[2] > 0.0


@each_law_and_rule
def test_asking_changes_no_history(name, unloading):
    """Force, stiffness, overlap and energy are of first loading, whatever a state holds; a new state is not shared."""
    law = make(name, unloading)
    state, other = law.new_state(2), law.new_state(2)
    law.evaluate(np.array([3e-6, 4e-6]), state if law.state_size else None)
    kept = [array.copy() for array in state.arrays]
    law.force(1e-5), law.stiffness(1e-5), law.overlap(5.0), law.energy(1e-5), law.follow([1e-5])
    for array, old, fresh in zip(state.arrays, kept, other.arrays, strict=True):
        np.testing.assert_array_equal(array, old)
        np.testing.assert_array_equal(fresh, 0.0)


@pytest.mark.parametrize("name", [n for n in dl.laws() if (n, "hertz") not in PAIRS and "hertz" in rules_of(n)])
def test_a_refused_law_would_return_work(name):
    """The refusal names the load; there, Hertz unloading from just above would give back more than loading took."""
    with pytest.raises(NotPassive) as refusal:
        dl.law(name, GRANITE, unloading="hertz", **options_of(name))
    load = float(str(refusal.value).split(" at ")[1].split(" N")[0])
    law = make(name)
    low = law.overlap(0.999 * load)
    high = law.overlap(load)
    # once at `low` the unloading curve starts at δp(low); climbing the virgin curve moves δp back
    coefficient = law.params.hertz_coefficient
    plastic = [o - (law.force(o) / coefficient) ** (2 / 3) for o in (low, high)]
    assert plastic[1] < plastic[0]
    with pytest.raises(NotPassive):  # one of several
        dl.law(name, GRANITE.with_values(sigma=np.array([1e-9, 2.4e-6, 1e-6])), unloading="hertz", **options_of(name))


# --- rule "table": a given curve


@given(turns=TURNS)
@settings(max_examples=10)
def test_hertz_as_the_curve_is_the_rule_hertz(turns):
    """Bit for bit; energies to rounding."""
    given_curve, rule = make("pohrt-popov").joined(dl.law("hertz", GRANITE)), make("pohrt-popov", "hertz")
    assert (given_curve.unloading, given_curve.state_names) == ("table", rule.state_names)
    path = GRANITE.sigma * np.array(turns)
    a, b = quiet(given_curve.follow, path), quiet(rule.follow, path)
    for quantity in ("force", "stiffness", "maximum_overlap", "plastic_overlap"):
        np.testing.assert_array_equal(getattr(a, quantity), getattr(b, quantity), err_msg=quantity)
    held = 0.4 * b.force.max() * np.max(b.maximum_overlap - b.plastic_overlap)
    np.testing.assert_allclose(a.work, b.work, rtol=1e-14, atol=1e-14 * held)
    np.testing.assert_allclose(a.dissipated, b.dissipated, rtol=0, atol=1e-14 * max(held, b.work.max()))


@pytest.mark.parametrize(
    "curve",
    [
        "table",
        "stiff",
        3.0,
        "nowhere.tbl",
        lambda: make("pohrt-popov", "hertz"),
        lambda: dl.law("rms", GRANITE.with_values(sigma=4 * GRANITE.sigma)),
        lambda: dl.law("hertz", GRANITE.with_values(radius=np.array([1e-3, 2e-3]))),
    ],
)
def test_curves_that_will_not_do(curve):
    with pytest.raises(dl.DemlawsError):
        dl.law("rms", GRANITE, unloading=curve() if callable(curve) else curve)


# --- one record a rule: the kernels are bound to its tag, and the plugins use its state

PACKAGE = Path(dl.__file__).parent
OWN = {rule.name: rule for definition in registry().values() for rule in definition.rules.own}
IN_CPP = [rule for rule in (*RULES.values(), *OWN.values()) if rule.number is not None]


def test_histories_of_the_plugins_are_the_state_in_its_order():
    """A rule keeps the first so many of the names."""
    facts = (PACKAGE / "cpp" / "demlaws_facts.h").read_text()
    names = re.findall(r'"(\w+)"', re.search(r"STATE_NAMES\[\] = \{([^}]*)\}", facts).group(1))
    for rule in IN_CPP:
        assert tuple(names[: len(rule.state)]) == rule.state


def test_a_second_type_of_the_name_is_refused():
    """The name goes into the symbols of the machine code."""

    class First(NamedTuple):
        hertz_coefficient: float
        k: float

    class Second(NamedTuple):
        hertz_coefficient: float
        k: float

    First.__name__ = Second.__name__ = "SpringOfThisTest"
    First.__module__ = Second.__module__ = "demlaws.laws.made_up"  # a user's would be given another name
    kernel = numba_compat.kernel(lambda shape, p, overlap: 0.5 * p.k * overlap**2)
    dispatch.bind(First, energy=kernel)
    dispatch.bind(First, inverse=numba_compat.kernel(lambda shape, p, force: force / p.k))  # binding again adds
    with pytest.raises(TypeError, match=r"SpringOfThisTest\w*: another law has a type of this name"):
        dispatch.bind(Second, energy=kernel)
