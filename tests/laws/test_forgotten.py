"""A quantity of the contact that a law uses, and that is not given, is an error that names it, wherever contacts are described:
in Python, commands, scene files, surfaces of YADE, exports to LIGGGHTS and LAMMPS. 0 is a value: a smooth surface."""

import dataclasses
import pickle

import numpy as np
import pytest
from examples import GRANITE, options_of, quiet

import demlaws as dl
from demlaws.cli import main
from demlaws.errors import MissingQuantity
from demlaws.laws.definition import SIGMA
from demlaws.laws.registry import find, registry
from demlaws.plugins.grains import Case, Grain
from demlaws.yade.pairs import Pairs

OF_CONTACT = ("sigma", "fractal_dimension", "hardness")
LEFT_OUT = [(law, name) for law, definition in registry().items() for name in definition.needed(**options_of(law))]
"""(law, quantity that it uses)."""
WITHOUT = [(law, name) for law in dl.laws() for name in OF_CONTACT if (law, name) not in LEFT_OUT]
STONE = dl.Material(60.6e9, 0.25)
OF_SURFACE = {"sigma": "roughness"}
SQ = {"roughness": 1.7e-6, "fractal_dimension": 2.22, "hardness": 6.266e9}
OPTIONS = {"sigma": "--sigma", "fractal_dimension": "--fractal-dimension", "hardness": "--hardness"}
SCENE = """radii = [0.004]
force = [1, 10]
reference = "{law}"
reference_options = {{ {options} }}
[material]
young = 60.6e9
poisson = 0.25
[surface]
{surface}
"""


def without(name):
    return {key: value for key, value in SQ.items() if key != OF_SURFACE.get(name, name)}


def words(law, sign):
    """Options of a law that are numbers, as the words of a command or of a scene file."""
    return [f"{name}{sign}{value!r}" for name, value in options_of(law).items() if isinstance(value, float)]


def in_python(law, name, folder):
    return dl.law(law, dataclasses.replace(GRANITE, **{name: None}), **options_of(law))


def between(law, name, folder):
    """The quantities of two bodies; of the roughness that of one body alone."""
    quantities = {"roughness1": 1e-6, "roughness2": 1e-6, "fractal_dimension": 2.22, "hardness": 6e9}
    quantities.pop({"sigma": "roughness2"}.get(name, name))
    return dl.law(law, dl.Contact.between(STONE, STONE, radius1=8e-3, radius2=8e-3, **quantities), **options_of(law))


def in_yade(law, name, folder):
    return Pairs(law, {"granite": dl.Surface(**without(name))}, None, options_of(law), 32e9, smooth=True)


def in_a_case(law, name, folder):
    case = Case(law, (Grain(4e-3, STONE, dl.Surface(**without(name))),), options=options_of(law))
    return case.bound(case.grains[0].contact(case.grains[0]))


PYTHON = (in_python, between, in_yade, in_a_case)


def command(name, *arguments):
    """Run `demlaws ...` with the contact's options but that of the quantity, None: all."""
    given = [word for key, option in OPTIONS.items() if key != name for word in (option, repr(SQ[OF_SURFACE.get(key, key)]))]
    return main([*arguments, *given])


def of_curve(law, name, folder):
    options = [word for text in words(law, "=") for word in ("--option", text)]
    contact = ["--effective-radius", "4mm", "--modulus", "32GPa", "--overlaps", "1e-6", "--steps", "1"]
    return command(name, "curve", "--law", law, *options, *contact)


def of_an_export(engine):
    def export(law, name, folder):
        options = [word for text in words(law, "=") for word in ("--option", text)]
        given = [word for key in without(name) for word in (f"--{key.replace('_', '-')}", repr(SQ[key]))]
        return main(
            [engine, "export", str(folder / "case"), "--law", law, "--radius", "4mm", *given, *options, "--rtol", "1e-2"]
        )

    return export


def of_a_scene(law, name, folder):
    options = ", ".join(words(law, " = "))
    surface = "\n".join(f"{key} = {value!r}" for key, value in without(name).items())
    (folder / "scene.toml").write_text(SCENE.format(law=law, options=options, surface=surface))
    return main(["choose", str(folder / "scene.toml")])


COMMANDS = {
    "curve": of_curve,
    "liggghts": of_an_export("liggghts"),
    "lammps": of_an_export("lammps"),
    "scene": of_a_scene,
}


@pytest.mark.parametrize("way", PYTHON)
@pytest.mark.parametrize(("law", "name"), LEFT_OUT)
def test_a_forgotten_quantity_is_an_error(law, name, way, tmp_path):
    with pytest.raises(dl.DemlawsError, match=name):
        way(law, name, tmp_path)


@pytest.mark.parametrize("way", COMMANDS)
@pytest.mark.parametrize(("law", "name"), LEFT_OUT)
def test_a_forgotten_quantity_in_a_command(law, name, way, tmp_path, capsys):
    """One line, status 2, the option or the line of the file that gives it; nothing written."""
    assert COMMANDS[way](law, name, tmp_path) == 2
    printed = [line for line in capsys.readouterr().err.splitlines() if "warning" not in line]
    option = f"--{OF_SURFACE.get(name, name).replace('_', '-')}"
    assert len(printed) == 1 and f"give {name} " in printed[0] and f"({option})" in printed[0] and "Traceback" not in printed[0]
    assert not list((tmp_path / "case").rglob("*.tbl"))


@pytest.mark.parametrize(("law", "name"), WITHOUT)
def test_a_quantity_that_a_law_does_not_use(law, name):
    """May be left out, of one contact and of an array: the same forces, and limits without it."""
    if name == "hardness" or find(law).needs_map:
        contact = dataclasses.replace(GRANITE, **{name: None})
        assert find(law).shape(contact, **find(law).read_options(options_of(law))) is not None
        return
    for contact in (GRANITE, dataclasses.replace(GRANITE, radius=np.array([4e-3, 5e-3]))):
        law_with, law_without = (
            dl.law(law, one, **options_of(law)) for one in (contact, dataclasses.replace(contact, **{name: None}))
        )
        np.testing.assert_array_equal(quiet(law_with.force, 1e-6), quiet(law_without.force, 1e-6))
        law_without.limits()


def test_a_contact_without_roughness():
    """It is not the smooth one, and survives pickles, copies, tables, softening; of two bodies, both are needed."""
    contact = dl.Contact(4e-3, 32e9)
    assert contact.sigma is None and contact != dl.Contact(4e-3, 32e9, 0.0) and "sigma=None" in repr(contact)
    assert pickle.loads(pickle.dumps(contact)) == contact == contact.with_values(radius=4e-3)
    assert contact.is_smooth and contact.sigma_or_zero == 0.0 and dl.soften(contact, 8).sigma is None
    with pytest.raises(MissingQuantity):
        contact.roughness_parameter(1.0)
    assert dl.Surface(1e-6).combined(dl.Surface()).roughness is None
    for one, other in ((1e-6, None), (None, 0.0)):
        pair = dl.Contact.between(STONE, STONE, radius1=8e-3, radius2=8e-3, roughness1=one, roughness2=other)
        assert pair.sigma is None
    granite = dl.materials.granite
    assert dl.Contact.between(granite, STONE, radius1=8e-3, radius2="flat").sigma is None
    assert dl.Contact.between(granite, granite, radius1=8e-3, radius2="flat").sigma == pytest.approx(
        2**0.5 * granite.surface.roughness
    )


def test_a_table_keeps_that_no_roughness_is_given(tmp_path):
    table = dl.law("hertz", dl.Contact(4e-3, 32e9), "hertz").tabulate(rtol=1e-2)
    loaded = dl.Table.load(table.save(tmp_path / "hertz.tbl"))
    assert loaded.contact == table.contact and loaded.contact.sigma is None
    rough = dl.law("rms", dl.Contact(4e-3, 32e9, 2e-6), "hertz").tabulate(rtol=1e-2)
    with pytest.raises(MissingQuantity):
        rough.bound_to(dl.Contact(4e-3, 32e9))


def test_a_law_of_a_user_that_reads_roughness(registered_here):
    def helper(p):
        return p.sigma

    plain = dl.define("plain", lambda p, x: 1e6 * x, lambda p, x: 1e6)
    direct = dl.define("direct", lambda p, x: 1e6 * x * (1.0 + p.sigma), lambda p, x: 1e6 * (1.0 + p.sigma))
    indirect = dl.define("indirect", lambda p, x: 1e6 * x * helper(p), lambda p, x: 1e6 * helper(p))
    assert plain.loading.needs == () and direct.loading.needs == indirect.loading.needs == ("sigma",)
    dl.register(direct)
    with pytest.raises(MissingQuantity):
        dl.law("direct", dl.Contact(4e-3, 32e9))


def test_a_fit_finds_the_roughness_that_is_not_given():
    truth = dl.law("rms", dl.Contact(4e-3, 32e9, 2e-6))
    load = np.geomspace(0.5, 50.0, 15)
    points = np.column_stack([quiet(truth.overlap, load), load])
    report = quiet(dl.fit, points, dl.Contact(4e-3, 32e9), laws=["rms"])
    assert report[0].contact.sigma == pytest.approx(2e-6, rel=1e-3)


def test_a_law_of_a_user_with_the_former_name_of_sigma(registered_here):
    """Functions that read `p.roughness`, and definitions that need or fit it, are the same law, with a warning."""
    contact = dl.Contact(4e-3, 32e9, 2e-6)
    new = dl.define("scaled", lambda p, x: 1e12 * x * p.sigma, lambda p, x: 1e12 * p.sigma, free=("modulus",))
    with pytest.warns(FutureWarning, match="of the pair, not Sq of one surface"):
        old = dl.define("scaled", lambda p, x: 1e12 * x * p.roughness, lambda p, x: 1e12 * p.roughness)
    assert old.loading.needs == new.loading.needs == ("sigma",)
    for one in (new, old):
        dl.register(one)
        assert dl.law("scaled", contact).force(1e-6) == pytest.approx(2.0)
    former = new._replace(
        loading=new.loading._replace(needs=("roughness",)),
        fitting=new.fitting._replace(parameters={"roughness": SIGMA}, free=("roughness",)),
    )
    with pytest.warns(FutureWarning, match="of the pair"):
        kept = dl.register(former)
    assert kept.loading.needs == kept.fitting.free == tuple(kept.fitting.parameters) == ("sigma",)
