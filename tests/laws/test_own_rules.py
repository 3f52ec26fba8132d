"""A rule for unloading that a user brings with a law of their own, from a file outside the package."""

import importlib
import shutil
import sys
import textwrap
from pathlib import Path

import numpy as np
import pytest
from examples import GRANITE, shared
from own_spring import SPRING, expected, registered

import demlaws as dl
from demlaws.core.unloading import Rule, own_rule, rule_of
from demlaws.laws.registry import find

PATH = np.array([1e-5, 8e-6, 5e-6, 3e-6, 9e-6, 1e-5, 2e-5, 1.5e-5, 0.0, 1e-6])


@pytest.fixture(scope="module", autouse=True)
def spring(tmp_path_factory):
    """The law, from a file; it goes with the module."""
    with registered(tmp_path_factory.mktemp("laws")):
        yield


def test_it_is_the_laws_default_and_follows_its_path():
    law = dl.law("spring", GRANITE)
    assert (law.unloading, law.state_names) == ("slack", ("maximum_overlap", "largest_force"))
    path = law.follow(PATH)
    np.testing.assert_allclose(path.force, expected(PATH), rtol=1e-12, atol=1e-12)
    assert path.dissipated[4] == pytest.approx(0.5 * 2e6 * 1e-10 * 0.4, rel=1e-12)
    assert np.all(np.isnan(path.plastic_overlap))  # it remembers no such quantity
    assert np.all(dl.law("spring", GRANITE, "elastic").follow(PATH).plastic_overlap == 0.0)
    batch, state = np.full(50, 1e-5), law.new_state(50)
    law.evaluate(batch, state)
    np.testing.assert_allclose(law.evaluate(0.8 * batch, state)[0], expected([1e-5, 8e-6])[1], rtol=1e-12)


def test_its_shear_stiffness_is_that_of_unloading():
    """The rule states none: at the largest overlap it is the slope just below, not that of loading."""
    law = dl.law("spring", GRANITE, lost=0.4)
    np.testing.assert_allclose(law.shear_stiffness([1e-5, 8e-6, 1e-5], 1.0, "elastic"), 2e6 / 0.6, rtol=1e-12)
    assert law.follow([1e-5]).stiffness[0] == 2e6


def test_a_table_has_it_too_but_not_its_file(tmp_path):
    """An engine would not know the rule; with another rule, or a curve to unload along, there is a file."""
    law = dl.law("spring", GRANITE, lost=0.3)
    table = law.tabulate(1e-6)
    assert table.unloading == "slack"
    np.testing.assert_allclose(table.follow(PATH).force, expected(PATH, 0.3), rtol=1e-6, atol=1e-6)
    with pytest.raises(dl.DemlawsError, match=r"law 'spring' with its user-defined unloading rule 'slack'"):
        table.save(tmp_path / "slack.tbl")
    assert not list(tmp_path.iterdir())
    assert dl.Table.load(table.joined("elastic").save(tmp_path / "elastic.tbl")).unloading == "elastic"
    assert [file.name for file in tmp_path.iterdir()] == ["elastic.tbl"]


@pytest.mark.parametrize("how", ["relative", "symlink"])
def test_one_file_by_two_names_is_one_law(tmp_path, monkeypatch, how):
    """A copy is refused."""
    text = SPRING.replace('name="spring"', 'name="twice"').replace('"slack"', '"twice-slack"')
    with registered(tmp_path, text, "twice.py") as file:
        first, other = find("twice"), tmp_path / "other.py"
        if how == "relative":
            monkeypatch.chdir(tmp_path)
            other = Path("twice.py")
        else:
            other.symlink_to(file)
        assert dl.load_laws(other) == ["twice"]
        assert find("twice") is first
        copy = tmp_path / "copy.py"
        shutil.copy(file, copy)
        with pytest.raises(dl.DemlawsError, match=r"law 'twice' of .* is already registered by"):
            dl.load_laws(copy)
        # as a module of a script, too: it runs once more, its law is the one from then on, and the rules of both are known
        monkeypatch.syspath_prepend(tmp_path)
        name = other.stem
        importlib.import_module(name)
        del sys.modules[name]
        again = find("twice")
        assert again is not first
        for definition in (first, again):
            assert rule_of(type(definition.rules.own[0].tag)) is definition.rules.own[0]


def test_no_other_law_is_offered_it():
    with pytest.raises(dl.DemlawsError, match="unknown unloading rule 'slack'"):
        dl.law("hertz", GRANITE, "slack")


@pytest.mark.parametrize(
    "changes",
    [
        {"name": "hertz"},
        {"state": ("a", "b", "c", "d")},
        {"curve": "hertz"},
    ],
)
def test_rules_that_will_not_do(changes):
    good = Rule("other", (), ("maximum_overlap",), "law", None, "nothing")
    with pytest.raises(TypeError):
        own_rule(good._replace(**changes))


HOSTILE = {
    "returns work": ("else stiffness * elastic\n", "else stiffness * elastic * (1.0 + 4.0 * (1.0 - positive / maximum))\n"),
    "another first loading": ("first_loading(shape, p, positive)", "first_loading(shape, p, 1.01 * positive)"),
    "jumps where it turns": ("stiffness = top / (maximum", "stiffness = 0.99 * top / (maximum"),
    "outlives contact": ("force, stiffness, maximum, top = 0.0, 0.0, 0.0, 0.0", "force, stiffness = 0.0, 0.0"),
    "says other energies": ("return 0.5 * state[1] * elastic", "return 0.4 * state[1] * elastic"),
}


@pytest.mark.parametrize("fault", shared(list(HOSTILE), ("returns work", "jumps where it turns").__contains__))
def test_a_rule_that_is_none_is_refused_with_its_overlap_and_value(fault, tmp_path):
    right, wrong = HOSTILE[fault]
    number, text = list(HOSTILE).index(fault), textwrap.dedent(SPRING)
    assert text.count(right) == 1
    text = text.replace(right, wrong).replace('"slack"', f'"slack{number}"').replace('name="spring"', f'name="bad{number}"')
    with registered(tmp_path, text, f"bad{number}.py"), pytest.raises(dl.DemlawsError) as caught:
        dl.law(f"bad{number}", GRANITE)
    assert f"law 'bad{number}' cannot be used with its rule 'slack{number}'" in str(caught.value)
