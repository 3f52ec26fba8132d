"""Laws that users register: from their own scripts, files and packages, and everything that must be refused."""

import importlib
import importlib.util
import math
import os
import pickle
import sys
from textwrap import dedent

import numba
import numpy as np
import pytest
from examples import GRANITE, shared
from own_spring import POWER
from processes import PACKAGE, counted, python

import demlaws as dl
from demlaws.core.fastmath import sqrt
from demlaws.laws import registry
from demlaws.laws.definition import Advice, Fitting, Loading


@pytest.fixture(autouse=True)
def whatever_a_test_registers_goes_with_it(registered_here):
    modules = set(sys.modules)
    yield
    for name in set(sys.modules) - modules:
        if name.startswith("demlaws_own_"):
            del sys.modules[name]


def write(folder, text=POWER, name="my_laws.py"):
    (folder / name).write_text(dedent(text))
    return folder / name


def power(p, overlap):
    return 3e9 * overlap**1.7


def slope(p, overlap):
    return 5.1e9 * overlap**0.7


# --- what holds for a law of the package


def test_a_law_of_ones_own_is_a_law(tmp_path):
    assert dl.load_laws(write(tmp_path)) == ["power"]
    assert dl.laws()[-1] == "power"
    law = dl.law("power", GRANITE, exponent=1.8)
    overlap = np.geomspace(1e-9, 1e-4, 30)
    np.testing.assert_allclose(law.force(overlap), 3e9 * overlap**1.8, rtol=1e-15)
    np.testing.assert_allclose(law.energy(overlap), 3e9 * overlap**2.8 / 2.8, rtol=1e-13)
    np.testing.assert_allclose(law.overlap(law.force(overlap)), overlap, rtol=1e-14)
    state, joined = (one := law.joined("hertz")).new_state(30), one
    force, _ = joined.evaluate(overlap, state)
    np.testing.assert_array_equal(force, law.force(overlap))
    assert joined.evaluate(0.9 * overlap, state)[0][0] < law.force(0.9 * overlap)[0]
    table = joined.tabulate(1e-6)
    assert not table.collapses and max(table.force_error, table.stiffness_error) <= 1e-6
    table.save(tmp_path / "power.tbl")
    assert dl.Table.load(tmp_path / "power.tbl").definition is law.definition
    assert pickle.loads(pickle.dumps(joined)).force(1e-6) == law.force(1e-6)
    assert dl.driver.impact(joined, 0.01, 0.05, 100).restitution < 1
    with pytest.raises(dl.DemlawsError, match=r"Its options are factor, exponent"):
        dl.law("power", GRANITE, steepness=2)
    many = dl.law("power", GRANITE.with_values(radius=np.linspace(1e-3, 5e-3, 30)))
    np.testing.assert_array_equal(many.evaluate(overlap)[0], dl.law("power", GRANITE).evaluate(overlap)[0])


def test_what_can_be_fitted_follows_the_registry():
    """A law that is registered after the module was imported; and several rules at once."""
    from demlaws.advice import fit as module

    own = dl.Parameter("", False, lambda c: (1.1, 3.0), lambda c: [1.5], option=True)
    law = dl.define("power", lambda p, d: 3e9 * d**p.bend, lambda p, d: 3e9 * p.bend * d ** (p.bend - 1), options={"bend": 1.7})
    force = np.append(np.geomspace(0.5, 80, 20), np.linspace(75, 20, 8))
    points = np.stack([(force / 3e9) ** (1 / 1.7), force], axis=1)
    with pytest.raises(dl.DemlawsError):
        dl.fit(points, GRANITE, laws="hertz", free=["bend"])
    dl.register(law._replace(fitting=Fitting({"bend": own}, free=("bend",))))
    assert "bend" in module.parameters()
    found = dl.fit(points, GRANITE, laws="power", free=["bend"], unloading=["elastic", "hertz"])
    assert sorted(f.unloading for f in found) == ["elastic", "hertz"]
    assert found.best.unloading == "elastic" and found.best.parameters["bend"].value == pytest.approx(1.7, abs=1e-6)


@pytest.mark.parametrize("arguments", [("x", 3), ("x",), ("x", power), ("x", power, 3)])
def test_functions_that_are_missing(arguments):
    with pytest.raises(dl.DemlawsError, match="must be a Python function"):
        dl.define(*arguments)


def test_names_that_are_taken(tmp_path):
    law = dl.define("power", power, slope)
    dl.load_laws(write(tmp_path))
    for taken in (law, law._replace(name="hertz"), law._replace(name="other", advice=Advice(rank=2))):
        with pytest.raises(dl.DemlawsError):
            dl.register(taken)
    assert dl.register(law, replace=True) is registry.find("power")
    assert dl.register(law) is dl.register(law) is registry.find("power")


def test_a_reloaded_module_replaces_its_laws(tmp_path):
    """As a notebook does: the new law for what is made from then on, the old one for what was made before."""
    spec = importlib.util.spec_from_file_location("mine_to_reload", write(tmp_path, name="mine_to_reload.py"))
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    old = dl.law("power", GRANITE)
    write(tmp_path, POWER.replace("p.factor * ", "2 * p.factor * "), name="mine_to_reload.py")
    importlib.invalidate_caches()
    exec(compile((tmp_path / "mine_to_reload.py").read_text(), str(tmp_path / "mine_to_reload.py"), "exec"), vars(module))
    new = dl.law("power", GRANITE)
    assert (new.force(1e-6), old.force(1e-6)) == pytest.approx((2 * 3e9 * 1e-6**1.7, 3e9 * 1e-6**1.7), rel=1e-14)
    np.testing.assert_allclose(new.joined("hertz").tabulate(1e-3).force(1e-6), new.force(1e-6), rtol=1e-3)
    saved = pickle.dumps(new)
    dl.register(dl.define("power", power, slope), replace=True)
    with pytest.raises(dl.DemlawsError, match="differs from the law that was pickled"):
        pickle.loads(saved)


# --- files


@pytest.mark.parametrize(
    "text",
    [
        None,
        "def force(p, overlap:\n",
        "import demlaws\n\n1 / 0\n",
        "import nowhere_to_be_found\n",
        "import sys\nsys.exit(3)\n",
        "x = 1\n",
        POWER.replace('"power"', '"rms"'),
        POWER + "\n1 / 0",
    ],
)
def test_files_that_are_refused(tmp_path, text):
    file = tmp_path / "my_laws.py"
    if text is not None:
        write(tmp_path, text)
    with pytest.raises(dl.DemlawsError) as caught:
        dl.load_laws(file)
    assert "\n" not in str(caught.value)


def test_a_file_as_the_packages_own_are(tmp_path):
    """Types, kernels and LAW written out; two files may call their types alike."""
    text = (PACKAGE / "laws" / "goddard.py").read_text().replace('name="goddard"', 'name="blunt"')
    other = text.replace('name="blunt"', 'name="blunter"').replace("0.75 * overlap * slope", "0.75 * overlap * slope * 1.0")
    assert dl.load_laws(write(tmp_path, text, "one.py")) == ["blunt"]
    assert dl.load_laws(write(tmp_path, other, "other.py")) == ["blunter"]
    overlap = np.geomspace(1e-9, 1e-4, 20)
    expected = dl.law("goddard", GRANITE, slope=0.035).force(overlap)
    for name in ("blunt", "blunter"):
        np.testing.assert_array_equal(dl.law(name, GRANITE, slope=0.035).force(overlap), expected)


def test_a_pickled_law_is_found_by_its_name_where_its_file_is_loaded(tmp_path):
    file = write(tmp_path)
    environment = dict(os.environ)
    dl.load_laws(file)
    assert dict(os.environ) == environment
    path = tmp_path / "definition.pickle"
    path.write_bytes(pickle.dumps(registry.find("power")))
    unpickle = f"import pickle; print(pickle.load(open({str(path)!r}, 'rb')).description)"
    with pytest.raises(AssertionError, match="unknown law 'power'"):
        python(unpickle)
    load = f"import demlaws as dl; dl.load_laws({str(file)!r}); "
    assert python(load + unpickle) == "power of the overlap"
    write(tmp_path, POWER.replace("3e9", "4e9"))
    with pytest.raises(AssertionError, match="differs from the law that was pickled"):
        python(load + unpickle)


@pytest.mark.slow
def test_a_file_is_run_once(tmp_path):
    """Twice by name; a module of a script is another run of it, with the same law."""
    file = write(tmp_path, POWER + "\nprint('ran', __name__.startswith('demlaws_own_my_laws'))\n")
    law = "dl.law('power', dl.Contact(radius=4e-3, modulus=3e10), 'hertz')"
    load = f"dl.load_laws({str(file)!r}); dl.load_laws({str(file)!r}); print({law}.force(1e-6))"
    ran, force = python(f"import demlaws as dl; {load}").splitlines()
    assert ran == "ran True" and float(force) == pytest.approx(3e9 * 1e-6**1.7, rel=1e-14)
    again = python(f"import demlaws as dl, my_laws; {load}", PYTHONPATH=f"{PACKAGE.parent}:{tmp_path}").splitlines()
    assert again == ["ran False", "ran True", force]


# --- machine code follows the file


@pytest.mark.parametrize("edits", shared([1, 3], (1).__eq__))
def test_machine_code_follows_an_edited_file(tmp_path, edits):
    """The file itself, a module that it takes a function from, a number of it."""
    write(tmp_path, "def factor():\n    return 3.0\n\nPLAIN = 1.0\n", "helper.py")
    text = """
        import demlaws as dl, helper
        from demlaws.core.fastmath import kernel
        from helper import PLAIN

        factor = kernel(helper.factor)

        def force(p, overlap):
            return factor() * PLAIN * helper.PLAIN * 1e9 * overlap**1.7

        def stiffness(p, overlap):
            return 1.7 * force_(p, overlap) / overlap

        force_ = kernel(force)
        dl.register(dl.define("mine", force, stiffness))
    """
    file = write(tmp_path, text)
    code = counted(f"""
        import demlaws as dl
        dl.load_laws({str(file)!r})
        print(dl.law("mine", dl.Contact(radius=4e-3, modulus=3e10)).force(1e-3), len(Count.compiled))
    """)
    settings = {"NUMBA_CACHE_DIR": tmp_path / "cache", "PYTHONDONTWRITEBYTECODE": 1}

    def run():
        force, compiled = python(code, **settings).split()
        return round(float(force) / (1e9 * 1e-3**1.7), 9), int(compiled) > 0

    assert run() == (3.0, True)
    assert run() == (3.0, False)
    edited = [
        ("def factor():\n    return 5.0\n\nPLAIN = 1.0\n", "helper.py", 5.0),
        ("def factor():\n    return 5.0\n\nPLAIN = 2.0\n", "helper.py", 20.0),
        (text.replace("1e9", "2e9"), "my_laws.py", 40.0),
    ]
    for text, name, expected in edited[:edits]:
        write(tmp_path, text, name)
        assert run()[0] == expected


# --- definitions that are none


def law(force, stiffness=slope, **functions):
    return dl.define("bad", force, stiffness, **functions)


BAD = {  # faults of values alone: tests/curves/test_user_curves.py
    "NaN somewhere": law(lambda p, d: 3e9 * d**1.7 if d < 1e-5 else math.nan),
    "derivative": law(power, lambda p, d: 5.3e9 * d**0.7),
    "NaN stiffness": law(power, lambda p, d: math.nan),
    "inverse": law(power, overlap=lambda p, f: (f / 3e9) ** (1 / 1.75)),
    "energy": law(power, energy=lambda p, d: 3e9 * d**2.7),
    "nothing": law(lambda p, d: 0.0 * d, lambda p, d: 0.0 * d),
    "no such field": law(lambda p, d: p.softness * d),
    "NaN in a gap": law(lambda p, d: math.nan if 1.23e-5 < d < 1.233e-5 else 3e9 * d**1.7),
    "a narrow dip": law(lambda p, d: 3e9 * d**1.7 * (1.0 - 1e-3 * math.exp(-(((d - 1.2345e-5) / 2e-9) ** 2)))),
    "no zero": law(lambda p, d: 1.0 + 3e9 * d**1.7),
    "by chance": law(lambda p, d: 3e9 * d**1.7 * (1.0 + 1e-5 * np.random.random())),  # noqa: NPY002
}


@pytest.mark.parametrize("fault", shared(list(BAD), list(BAD)[::3].__contains__))
def test_a_law_that_is_none_is_refused_with_its_overlap_and_value(fault):
    dl.register(BAD[fault])
    with pytest.raises(dl.DemlawsError) as caught:
        dl.law("bad", GRANITE)
    assert "bad" in str(caught.value) and "\n" not in str(caught.value)


def test_no_former_contact_decides_whether_a_law_is_accepted():
    """Wrong by 10 % at radii from 5 mm on: refused there, however many contacts were bound before."""
    dl.register(law(power, lambda p, d: (5.1e9 if p.radius < 5e-3 else 5.6e9) * d**0.7))
    for n in range(35):
        dl.law("bad", GRANITE.with_values(radius=(4.0 + 0.01 * n) * 1e-3))
    with pytest.raises(dl.DemlawsError, match="derivative"):
        dl.law("bad", GRANITE.with_values(radius=6e-3))


def test_kinks_are_no_fault():
    """A stiffness that jumps is what a law may have: only the force must not."""

    def force(p, d):
        return 1e6 * d + 2e6 * max(d - 1e-5, 0.0)

    dl.register(dl.define("kinked", force, lambda p, d: 1e6 if d < 1e-5 else 3e6, kinks=lambda p, **o: [1e-5]))
    table = dl.law("kinked", GRANITE).tabulate(1e-6)
    np.testing.assert_allclose(table.force(np.array([9e-6, 2e-5])), [9.0, 40.0], rtol=1e-6)


@pytest.mark.filterwarnings("error")
def test_a_force_may_begin_at_an_overlap():
    """Where force, energy and Hertz's overlap are all 0 there is no ratio of them to judge."""
    law = dl.define("late", lambda p, d: 3e9 * max(d - 1e-7, 0.0) ** 1.7, lambda p, d: 5.1e9 * max(d - 1e-7, 0.0) ** 0.7)
    dl.register(law)
    assert dl.law("late", GRANITE).force(np.array([5e-8, 1.1e-6])) == pytest.approx([0.0, 3e9 * 1e-6**1.7], rel=1e-9)


def test_a_law_that_does_not_collapse_says_so():
    dl.register(dl.define("power", power, slope, collapses=True))
    with pytest.raises(dl.DemlawsError, match=r"with radius = .*overlap .* m, made dimensionless, is 0\.\d+ times as large"):
        dl.law("power", GRANITE).tabulate()
    assert dl.law("power", GRANITE).force(1e-6) > 0


@pytest.mark.parametrize(
    "changes",
    [
        {"name": "My Law"},
        {"name": "table"},
        {"name": 3},
        {"equation": "two\nlines"},
        {"prepare": None},
        {"length": "diameter"},
        {"loading": Loading(needs=("colour",))},
        {"unloading": ("hertz",)},
        {"fitting": Fitting(free=("n",))},
    ],
)
def test_definitions_that_are_refused(changes):
    with pytest.raises(dl.DemlawsError):
        dl.register(law(power)._replace(**changes))


@pytest.mark.parametrize(
    "call",
    [
        *(lambda name=name: law(power, options={name: 1.0}) for name in ("radius", "for")),
        lambda: law(power, options={"n": math.nan}),
        lambda: law(power, colours=3),
        lambda: law(power, prepare=1),
    ],
)
def test_what_is_no_definition(call):
    with pytest.raises(dl.DemlawsError):
        call()


def test_an_option_without_a_default_must_be_given():
    dl.register(dl.define("needs", power, slope, options={"n": None}))
    with pytest.raises(dl.DemlawsError):
        dl.law("needs", GRANITE)
    assert dl.law("needs", GRANITE, n=2).options == {"n": 2}


# --- the tests of a law


@pytest.mark.slow
def test_the_check_sees_what_is_wrong():
    """Within what a law may be to be used at all: an energy off by 1e-5, a stiffness by 1e-6."""
    off = dl.define("off", power, lambda p, d: 1.000001 * 5.1e9 * d**0.7, energy=lambda p, d: 1.00001 * 3e9 * d**2.7 / 2.7)
    dl.register(off)
    found = dl.check_law("off", rules=("elastic",), paths=100)
    failed = {check.what: check.value for check in found.failures}
    assert failed["stiffness against derivative, relative"] == pytest.approx(1e-6, rel=0.01)
    assert failed["energy against ∫P dδ, relative"] == pytest.approx(1e-5, rel=0.01)
    stiff = dl.define(
        "stiff", lambda p, d: 9.0 * p.hertz_coefficient * d**1.5, lambda p, d: 13.5 * p.hertz_coefficient * d**0.5
    )
    dl.register(stiff._replace(unloading=("elastic", "hertz")))
    # a rule that would return work is refused for any law: no fault of this one
    found = dl.check_law("stiff", rules=("hertz",), paths=100)
    assert found.passed and "hertz unloading: refused" in str(found)


def test_a_number_from_where_is_a_number():
    """numba's np.where of two numbers is an array without dimensions: it ended in 51 lines of numba's."""
    law = dl.define("where", lambda p, d: np.where(d > 1e-6, 3e9 * d**1.6, 3e9 * d**1.6), lambda p, d: 4.8e9 * d**0.6)
    dl.register(law, replace=True)
    bound = dl.law("where", GRANITE)
    assert bound.force(2e-6) == pytest.approx(3e9 * 2e-6**1.6) == bound.follow([2e-6]).force[0]


def plain_helper(overlap):
    return 3e9 * overlap**1.6


def test_a_plain_helper_is_named():
    dl.register(dl.define("helped", lambda p, d: plain_helper(d), lambda p, d: 4.8e9 * d**0.6), replace=True)
    with pytest.raises(dl.DemlawsError, match=r"plain_helper is a plain Python function: put @numba.njit before it") as error:
        dl.law("helped", GRANITE)
    assert "\n" not in str(error.value)


FACTOR = 3e9


@numba.njit
def compiled_helper(overlap):
    return FACTOR * overlap**1.6


def test_a_helper_follows_its_global():
    """numba keeps the value that a global had when the helper was compiled."""
    global FACTOR
    before = FACTOR
    try:
        for factor in (3e9, 6e9):
            FACTOR = factor
            law = dl.define("global-factor", lambda p, d: compiled_helper(d), lambda p, d: 1.6 * compiled_helper(d) / d)
            dl.register(law, replace=True)
            assert dl.law("global-factor", GRANITE).force(1e-6) == pytest.approx(factor * 1e-6**1.6)
    finally:
        FACTOR = before


@pytest.mark.slow
def test_a_law_that_says_so_is_chosen_from():
    """Among the candidates, closed form and table, with the error that it has: 0.9 of Hertz's force."""

    def force(p, overlap):
        return p.factor * p.hertz_coefficient * overlap * sqrt(overlap)

    def stiffness(p, overlap):
        return 1.5 * p.factor * p.hertz_coefficient * sqrt(overlap)

    dl.register(dl.define("near-hertz", force, stiffness, options={"factor": 0.9}, collapses=True, candidate=True, smooth=True))
    choices = dl.choose(
        dl.Scene(radii=5e-3, materials=dl.Material(210e9, 0.3), surfaces=dl.Surface(0), force=(1.0, 10.0), tolerance=0.2)
    )
    found = [choice for choice in choices if choice.name == "near-hertz"]
    assert {choice.evaluation for choice in found} == {"closed form", "table"}
    assert all(0.1 <= choice.error <= 0.15 and choice.meets for choice in found)


def line_of(factor):
    """Definition of P = factor δ, with functions made anew."""

    def force(p, overlap):
        return factor * overlap

    def stiffness(p, overlap):
        return factor

    return dl.define("line", force, stiffness)


def test_the_same_functions_are_the_same_law():
    """A definition in a loop kept types, kernels and 10 MB of machine code each time."""
    contact = dl.Contact(4e-3, 32e9)
    first, again, other = (type(line_of(factor).shape(contact)) for factor in (1e6, 1e6, 2e6))
    assert first is again and first is not other


def test_many_definitions_are_warned_of_once(monkeypatch):
    """numba frees no machine code."""
    monkeypatch.setattr(importlib.import_module("demlaws.user_laws.define"), "_tags", [])
    with pytest.warns(UserWarning, match="20 laws of different functions.*as options of one law") as seen:
        for n in range(25):
            line_of(1e6 + n)
    assert len(seen) == 1
