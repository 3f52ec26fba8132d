"""One record a rule: the kernels are bound to its tag, and the C++ header and the plugins say the same of it."""

import re
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from examples import GRANITE, make, quiet

import demlaws as dl
from demlaws.core import dispatch, numba_compat
from demlaws.core.loops import energies_loop, unloaded_loop
from demlaws.core.unloading import GIVEN, RULES, rule_of
from demlaws.laws.registry import registry

PACKAGE = Path(dl.__file__).parent
OWN = {rule.name: rule for definition in registry().values() for rule in definition.rules}
IN_CPP = [rule for rule in (*RULES.values(), *OWN.values()) if rule.number is not None]


def test_records_agree_with_one_another():
    assert [name for name in RULES] == [rule.name for rule in RULES.values()]
    assert len({type(rule.tag) for rule in RULES.values()}) == len(RULES)
    assert all(rule_of(type(rule.tag)) is rule for rule in RULES.values())
    assert {rule.name for rule in RULES.values() if rule.curve == "given"} == {GIVEN}
    for rule in RULES.values():
        assert bool(rule.state) == (rule.curve != "own")
        assert make("pohrt-popov", rule.name).state_names == rule.state


def test_histories_of_liggghts_are_the_state_in_its_order():
    sources = "".join(path.read_text() for path in sorted((PACKAGE / "liggghts" / "src").glob("*.h")))
    listed = re.search(r"\[MOST_STATE\] = \{([^}]*)\}", sources).group(1)
    words = [re.sub(r"[A-Z]", lambda m: "_" + m.group().lower(), name) for name in re.findall(r'"demlaws_(\w+)"', listed)]
    for rule in IN_CPP:
        assert tuple(words[: len(rule.state)]) == rule.state


class Unbound(NamedTuple):
    value: float


def test_an_unknown_kernel_is_refused():
    with pytest.raises(TypeError, match=r"Unbound: no generic function is called virign; there are .*energy, .*virgin"):
        dispatch.bind(Unbound, virign=lambda p, overlap: overlap)
    with pytest.raises(TypeError):
        dispatch.bind(type("HertzParams", (tuple,), {"__module__": "demlaws.laws.mine"}), virgin=lambda p, overlap: overlap)


def test_a_second_type_of_the_name_is_refused():
    """The name goes into the symbols of the machine code."""

    class First(NamedTuple):
        k: float

    class Second(NamedTuple):
        k: float

    First.__name__ = Second.__name__ = "SpringOfThisTest"
    First.__module__ = Second.__module__ = "demlaws.laws.made_up"  # a user's would be given another name
    kernel = numba_compat.kernel(lambda p, overlap: 0.5 * p.k * overlap**2)
    dispatch.bind(First, energy=kernel)
    dispatch.bind(First, inverse=numba_compat.kernel(lambda p, force: force / p.k))  # binding again adds
    with pytest.raises(TypeError, match=r"SpringOfThisTest\w*: another law has a type of this name"):
        dispatch.bind(Second, energy=kernel)


@pytest.mark.parametrize("unloading", RULES)
def test_batches_unload_and_balance_as_one_contact_does(unloading):
    """`unloaded_loop` and `energies_loop` over contacts that differ, against the driver's path of each."""
    law = make("pohrt-popov", unloading)
    many = GRANITE.with_values(radius=GRANITE.radius * np.linspace(0.7, 1.4, 9))
    curve = (
        None if law.unloading_law is None else law.unloading_law.bound_to(many.with_values(roughness=0.25 * GRANITE.roughness))
    )
    batch = dl.law("pohrt-popov", many, curve or unloading)
    top = quiet(batch.overlap, 60.0)
    state = batch.new_state(9)
    batch.evaluate(top, state)
    overlap, stored, dissipated = np.empty(9), np.empty(9), np.empty(9)
    unloaded_loop(batch.rule, batch.params, np.full(9, 12.0), state.arrays, overlap)
    assert batch.evaluate(overlap, state.copy())[0] == pytest.approx(12.0, rel=1e-9)
    energies_loop(batch.rule, batch.params, overlap, state.arrays, stored, dissipated)
    for i in (0, 8):
        alone = many.with_values(radius=float(many.radius[i]))
        own = None if curve is None else law.unloading_law.bound_to(alone.with_values(roughness=0.25 * GRANITE.roughness))
        path = dl.law("pohrt-popov", alone, own or unloading).follow(np.array([top[i], overlap[i]]))
        assert (stored[i], dissipated[i]) == pytest.approx((path.stored[1], path.dissipated[1]), rel=1e-10, abs=1e-20)
