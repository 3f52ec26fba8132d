"""Every option of every law as a number, as text with a unit, and as junk, wherever a user gives it: in Python, commands, scene
files, YADE, cases of LIGGGHTS and LAMMPS, saved tables."""

import inspect
import math

import numpy as np
import pytest
from examples import GRANITE, options_of, quiet

import demlaws as dl
from demlaws.cli import main
from demlaws.laws.definition import CLOSED, HERTZ_CURVE, Numbers
from demlaws.laws.registry import find, registry
from demlaws.plugins.grains import Case, Grain
from demlaws.units import UNITS
from demlaws.yade.pairs import LawSource

INSTEAD = {  # where options exclude or need one another; None: left out
    ("walton-braun", "growth"): {"stiffness_ratio": None, "growth": 0.02},
    ("asperity", "max_force"): {"max_force": 50.0},
    ("rough-plastic", "bulk_radius"): {"bulk_radius": 3e-3},
}
NUMERIC = [(law, name) for law, d in registry().items() for name, one in d.options.items() if isinstance(one.values, Numbers)]
MATERIAL = dl.Material(60.6e9, 0.25, 6.266e9, surface=dl.Surface(1.7e-6, 2.22))
SCENE = """radii = [0.004]
force = [1, 10]
reference = "{law}"
reference_options = {{ {name} = {value} }}
[material]
young = 60.6e9
poisson = 0.25
"""
CURVE = [
    "curve",
    "--effective-radius",
    "4mm",
    "--modulus",
    "32GPa",
    "--sigma",
    "2um",
    "--fractal-dimension",
    "2.2",
]
CURVE += ["--hardness", "6.266GPa", "--overlaps", "1e-6", "--steps", "1"]


def default_of(law, name):
    return inspect.signature(find(law).prepare).parameters[name].default


def options_with(law, name):
    """Options with which a law is made that has the option `name`."""
    options = {**options_of(law), **INSTEAD.get((law, name), {})}
    if name not in options:
        options[name] = default_of(law, name)
    return {key: value for key, value in options.items() if value is not None}


def of_scene(law, name, value, folder):
    """The value of an option in a scene file, as the scene has it."""
    file = folder / "scene.toml"
    text = str(value).lower() if isinstance(value, bool | float) else f'"{value}"'
    file.write_text(SCENE.format(law=law, name=name, value=text))
    return dl.Scene.load(file).reference_options[name]


def in_every_way(law, options):
    """Options as each way in reads them."""
    yield find(law).read_options(options)
    yield LawSource(law, options).options
    yield Case(law, (Grain(4e-3, MATERIAL),), options=options).options
    yield dl.Scene(radii=4e-3, materials=MATERIAL, force=(1, 2), reference=law, reference_options=options).reference_options


@pytest.mark.parametrize(("law", "name"), NUMERIC)
def test_text_with_a_unit_is_the_number(law, name, tmp_path):
    options, unit = options_with(law, name), find(law).options[name].unit
    for symbol, factor in UNITS.get(unit, {unit: 1.0}).items():
        text = f"{options[name] / factor!r} {symbol}".rstrip()
        for read in in_every_way(law, {**options, name: text}):
            assert read[name] == pytest.approx(options[name], rel=1e-14) and isinstance(read[name], float)
        assert of_scene(law, name, text, tmp_path) == pytest.approx(options[name], rel=1e-14)


def text_of(law, options):
    """Options with every number as text with its unit."""
    records = find(law).options
    return {n: f"{v!r} {records[n].unit}".strip() if isinstance(records[n].values, Numbers) else v for n, v in options.items()}


@pytest.mark.parametrize("law", [law for law in dl.laws() if any(law == other for other, _ in NUMERIC)])
def test_a_law_made_of_text(law, tmp_path):
    """The same options, curve and limits; a table saved from it has the numbers."""
    options = options_of(law)
    number, text = (quiet(dl.law, law, GRANITE, "elastic", **one) for one in (options, text_of(law, options)))
    assert text.options == number.options and text == number and text.limits() == number.limits()
    assert quiet(text.force, 2e-6) == quiet(number.force, 2e-6)
    if text.definition.loading.computed in (HERTZ_CURVE, CLOSED):
        file = quiet(text.tabulate, rtol=1e-2).save(tmp_path / "law.tbl")
        assert file.read_bytes() == quiet(number.tabulate, rtol=1e-2).save(tmp_path / "number.tbl").read_bytes()


NEEDED = {law: [n for n in find(law).options if default_of(law, n) is inspect.Parameter.empty] for law in dl.laws()}


@pytest.mark.parametrize("law", [law for law in dl.laws() if NEEDED[law]])
def test_an_option_without_a_default_is_needed(law):
    """One error with all that are missing and how to give them."""
    for given in ({}, dict.fromkeys(NEEDED[law])):
        with pytest.raises(dl.DemlawsError) as refused:
            dl.law(law, GRANITE, **given)
        assert all(f"{name}=VALUE" in str(refused.value) for name in NEEDED[law])


@pytest.mark.parametrize("law", ["goddard", "luding"])
def test_a_fit_needs_the_options_that_it_does_not_vary(law):
    points = np.linspace(1e-6, 1e-5, 20)
    with pytest.raises(dl.DemlawsError, match=f"law '{law}' needs {NEEDED[law][0]}"):
        dl.fit(np.column_stack([points, 1e6 * points]), GRANITE, laws=law, free=["modulus"])


@pytest.mark.parametrize(("law", "name"), NUMERIC)
def test_junk_is_refused_by_name(law, name, tmp_path, capsys):
    options, unit = options_with(law, name), find(law).options[name].unit
    may_be_none = default_of(law, name) in (None, inspect.Parameter.empty)
    words = ["junk", "nan", "inf", "1 furlong", "-1e300", "1 mm" if unit == "Pa" else "1 GPa"]
    for junk in (*words, math.nan, [1.0, 2.0], {}, True, 1j, *([] if may_be_none else [None])):
        with pytest.raises(dl.DemlawsError, match=name):
            dl.law(law, GRANITE, **{**options, name: junk})
        for make in (LawSource, lambda law, options: Case(law, (Grain(4e-3, MATERIAL),), options=options)):
            with pytest.raises(dl.DemlawsError, match=name):
                make(law, {**options, name: junk})
    for word in words:
        with pytest.raises(dl.DemlawsError, match=name):
            of_scene(law, name, word, tmp_path)
        others = [f"--option={key}={value!r}" for key, value in options.items() if isinstance(value, float) and key != name]
        assert main([*CURVE, "--law", law, *others, "--option", f"{name}={word}"]) == 2
        printed = capsys.readouterr().err
        assert name in printed.replace("-", "_") and printed.count("\n") == 1 and "Traceback" not in printed


@pytest.mark.parametrize(("law", "name"), [pair for pair in NUMERIC if default_of(*pair) is None])
def test_none_is_not_given(law, name):
    """None where that is the default is an option left out."""
    assert find(law).read_options({name: None}) == {}


WORDS = [(law, name) for law, d in registry().items() for name in d.options if (law, name) not in NUMERIC]


@pytest.mark.parametrize(("law", "name"), WORDS)
def test_junk_for_a_word(law, name):
    for junk in ("junk", 3.7, math.nan, [1.0, 2.0], {}, True, 1j):
        with pytest.raises(dl.DemlawsError):
            dl.law(law, GRANITE, **{**options_of(law), name: junk})


def test_a_scene_accepts_text_for_every_quantity(tmp_path):
    """As its template says: text with a unit equals the number, also in lists."""
    rows = {
        "radii": ([0.004, 0.005], '["4mm", 0.005]'),
        "classes": ((0.004, 0.005), '["4 mm", "5mm"]'),
        "force": ((1.0, 500.0), '["1N", "0.5 kN"]'),
        "pressure": ((1e5, 2e6), '["100kPa", 2e6]'),
        "speed": (0.5, '"500 mm/s"'),
        "tolerance": (0.2, '"0.2"'),
        "porosity": (0.4, '"0.4"'),
        "coordination": (6.0, '"6"'),
        "rate": (10.0, '"10 1/s"'),
        "yield_pressure": (1.66e9, '"1.66GPa"'),
    }
    for name, (number, text) in rows.items():
        file = tmp_path / "scene.toml"
        others = "" if name in ("radii", "classes") else "radii = [0.004]\n"
        others += "" if name in ("force", "pressure", "speed") else "force = [1, 10]\n"
        file.write_text(f"{others}{name} = {text}\n[material]\nyoung = '60.6 GPa'\npoisson = 0.25\n")
        assert getattr(dl.Scene.load(file), name) == pytest.approx(number, rel=1e-14), name
        file.write_text(f"{others}{name} = '3 furlong'\n[material]\nyoung = '60.6 GPa'\npoisson = 0.25\n")
        with pytest.raises(dl.DemlawsError, match=name):
            dl.Scene.load(file)


def test_a_fault_in_prepare_is_not_a_fault_of_the_options():
    """The text was "cannot use slope=0.5"."""

    def prepare(contact, slope):
        return len(5)

    faulty = find("goddard")._replace(prepare=prepare)
    with pytest.raises(dl.DemlawsError, match=r"its prepare\(contact, slope=0\.5\) raises TypeError: object of type 'int'"):
        faulty.shape(dl.Contact(4e-3, 32e9), slope=0.5)
