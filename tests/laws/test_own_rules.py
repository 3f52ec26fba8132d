"""A rule for unloading that a user brings with a law of their own, from a file outside the package."""

import importlib
import os
import shutil
import subprocess
import sys
import textwrap
import zlib
from pathlib import Path

import numpy as np
import pytest
from examples import GRANITE, shared
from own_spring import SPRING, expected, registered

import demlaws as dl
from demlaws.core.unloading import Rule, own_rule, rule_of
from demlaws.laws import registry
from demlaws.laws.registry import find

FOLLOW = Path(__file__).parents[1] / "cpp" / "follow.cpp"
SHARED = Path(dl.__file__).parent / "cpp"
needs_compiler = pytest.mark.skipif(shutil.which("g++") is None, reason="needs g++")
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


def test_a_table_has_it_too_and_its_file_names_the_object(tmp_path):
    law = dl.law("spring", GRANITE, lost=0.3)
    table = law.tabulate(1e-6)
    assert table.unloading == "slack"
    np.testing.assert_allclose(table.follow(PATH).force, expected(PATH, 0.3), rtol=1e-6, atol=1e-6)
    assert dl.Table.load(table.joined("elastic").save(tmp_path / "elastic.tbl")).unloading == "elastic"
    assert [file.name for file in tmp_path.iterdir()] == ["elastic.tbl"]


@needs_compiler
def test_a_file_and_its_object(tmp_path):
    """Twice the same bytes; read again it is the law's rule; C++ does with it what Python does."""
    law = dl.law("spring", GRANITE, lost=0.3)
    table = law.tabulate(1e-6)
    path, other = table.save(tmp_path / "spring.tbl"), law.tabulate(1e-6).save(tmp_path / "other.tbl")
    code = Path(f"{path}.so").read_bytes()
    assert code == Path(f"{other}.so").read_bytes() and path.read_bytes() == other.read_bytes()
    assert f"rule_object: {zlib.crc32(code):08x} {len(code)} " in path.read_text()
    again = dl.Table.load(path)
    assert (again.unloading, again.fingerprint) == ("slack", table.fingerprint)
    np.testing.assert_array_equal(again.follow(PATH).force, table.follow(PATH).force)
    program = tmp_path / "follow"
    line = ["g++", "-std=c++11", "-O2", "-Wall", "-Wextra", "-Werror", f"-I{SHARED}"]
    subprocess.run([*line, str(FOLLOW), "-o", str(program), "-ldl"], check=True)

    def follow(file):
        done = subprocess.run([program, file, *map(repr, PATH.tolist())], capture_output=True, text=True)
        return done.stdout if done.returncode else np.array([line.split() for line in done.stdout.splitlines()], float)

    found, mine = follow(path), table.follow(PATH)
    for column, values in zip(found.T[:2], (mine.force, mine.stiffness), strict=True):
        np.testing.assert_allclose(column, values, rtol=1e-12, atol=1e-12 * values.max())
    np.testing.assert_allclose(found[:, 2], table.shear_stiffness(PATH, 1.0), rtol=1e-12)
    np.testing.assert_allclose(found[:8, 3], mine.stored[:8], rtol=1e-9)
    np.testing.assert_allclose(found[:8, 4], mine.dissipated[:8], rtol=1e-9)
    Path(f"{other}.so").write_bytes(code[:-1] + b"x")
    assert "is not the object that the table was written with" in follow(other)
    Path(f"{other}.so").unlink()
    assert "cannot be opened" in follow(other) and "unloading rule 'slack'" in follow(other)
    text = path.read_text().splitlines()
    lines = {line.split(":")[0]: number for number, line in enumerate(text, 1)}
    (tmp_path / "cut.tbl").write_bytes(b"\n".join(line.encode() for line in text if not line.startswith("rule_object")) + b"\n")
    with pytest.raises(dl.DemlawsError, match=f"cut.tbl, line {lines['rule_object']}: "):
        dl.Table.load(tmp_path / "cut.tbl")


@pytest.mark.slow
@needs_compiler
def test_a_file_whose_law_is_not_here_or_another(tmp_path):
    text = SPRING.replace('name="spring"', 'name="soft-spring"').replace('"slack"', '"more-slack"')
    with registered(tmp_path, text, "soft.py"):
        path = dl.law("soft-spring", GRANITE).tabulate(1e-4).save(tmp_path / "soft.tbl")
        assert dl.Table.load(path).unloading == "more-slack"
    with pytest.raises(dl.DemlawsError, match=r"rule 'more-slack' belongs to law 'soft-spring', which is not registered here"):
        dl.Table.load(path)
    with (
        registered(tmp_path, text.replace("lost=0.4", "lost=0.5"), "softer.py"),
        pytest.raises(dl.DemlawsError, match=r"law 'soft-spring' has changed since the table was written"),
    ):
        dl.Table.load(path)


@needs_compiler
def test_a_table_and_its_object_are_both_written_or_neither(tmp_path):
    """The table cannot take the place of a folder; the object that was there before, or none, is there after it."""
    table = dl.law("spring", GRANITE).tabulate(1e-3)
    name = tmp_path / "spring.tbl"
    name.mkdir()
    with pytest.raises(dl.DemlawsError, match=r"cannot write \S+spring\.tbl: Is a directory"):
        table.save(name)
    assert [file.name for file in tmp_path.iterdir()] == ["spring.tbl"]
    Path(f"{name}.so").write_bytes(b"of another table")
    with pytest.raises(dl.DemlawsError, match="Is a directory"):
        table.save(name)
    assert Path(f"{name}.so").read_bytes() == b"of another table"
    assert sorted(file.name for file in tmp_path.iterdir()) == ["spring.tbl", "spring.tbl.so"]


@pytest.mark.parametrize("how", ["relative", "symlink"])
def test_one_file_by_two_names_is_one_law(tmp_path, monkeypatch, how):
    """Its rule would else meet one of its own name; a copy is refused."""
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
        assert "DEMLAWS_LAWS" not in os.environ or str(file) not in os.environ["DEMLAWS_LAWS"]
        assert registry.environment()["DEMLAWS_LAWS"].split(os.pathsep)[-1] == str(file)
        copy = tmp_path / "copy.py"
        shutil.copy(file, copy)
        with pytest.raises(dl.DemlawsError, match="an unloading rule 'twice-slack' exists already"):
            dl.load_laws(copy)
        # as a module of a script, too: it runs once more, its law is the one from then on, and the rules of both are known
        monkeypatch.syspath_prepend(tmp_path)
        name = other.stem
        importlib.import_module(name)
        del sys.modules[name]
        again = find("twice")
        assert again is not first
        for definition in (first, again):
            assert rule_of(type(definition.rules[0].tag)) is definition.rules[0]


def test_no_other_law_is_offered_it():
    with pytest.raises(dl.DemlawsError, match="unknown unloading rule 'slack'"):
        dl.law("hertz", GRANITE, "slack")


@pytest.mark.parametrize(
    "changes",
    [
        {"name": "hertz"},
        {"name": "linear"},
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
    "another first loading": ("virgin(p, positive)", "virgin(p, 1.01 * positive)"),
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
