"""`demlaws materials`."""

import json
import math

import pytest

import demlaws as dl
from demlaws.cli import main
from demlaws.cli.engine import PROPERTIES
from demlaws.law import Table
from demlaws.materials import names, typical
from demlaws.plugins.grains import Grain


def test_table_has_all_materials(capsys):
    assert main(["materials"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines[1:-1:2]] == names()
    assert max(map(len, lines)) <= 100


def test_one_material_with_its_sources(capsys):
    assert main(["materials", "steel"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert all(" ".join(value.source.split()) in said for value in typical("steel").values())


def test_unknown_material(capsys):
    assert main(["materials", "stel"]) == 2
    assert "did you mean 'steel'" in capsys.readouterr().err


def test_json_has_the_unit_of_its_values(capsys):
    assert main(["materials", "granite", "--json"]) == 0
    values = json.loads(capsys.readouterr().out)["granite"]
    for quantity, value in typical("granite").items():
        found = values[quantity]
        assert (found["value"], found["unit"]) == (value.value, value.unit) and found["display"] == value.display()
    assert (values["young"]["value"], values["young"]["unit"]) == (60.6e9, "Pa")
    assert values["young"]["display"].startswith("60.6 GPa") and values["roughness"]["display"].startswith("1.7 µm")
    assert (values["roughness"]["unit"], values["density"]["unit"], values["poisson"]["unit"]) == ("m", "kg/m³", "")


RADII = ["--radius", "8mm", "6mm"]


@pytest.mark.parametrize("names", [["granite"], ["glass", "steel"]])
def test_a_material_by_its_name(names, capsys):
    """The contact of Python's `Contact.between`; values that are given replace those of the material."""
    first, second = (dl.materials.material(name) for name in (names[0], names[-1]))
    words = ["curve", "--law", "hertz", *RADII, "--material", *names, "--forces", "1", "--steps", "2", "--json"]
    for more, changes in (([], {}), (["--fractal-dimension", "2.4"], {"fractal_dimension": 2.4})):
        assert main([*words, *more]) == 0
        expected = dl.Contact.between(first, second, radius1=8e-3, radius2=6e-3).with_values(**changes)
        assert json.loads(capsys.readouterr().out)["contact"] == pytest.approx(vars(expected))
    assert main([*words, "--young", "50GPa"]) == 0
    bodies = (dl.Material(50e9, one.poisson) for one in (first, second))
    modulus = dl.Contact.between(*bodies, radius1=8e-3, radius2=6e-3).modulus
    assert json.loads(capsys.readouterr().out)["contact"]["modulus"] == pytest.approx(modulus)


@pytest.mark.parametrize("engine", ["liggghts", "lammps"])
def test_a_case_of_materials_by_name(engine, tmp_path):
    """The export of the listed values, of which density and roughness are the material's, too."""
    granite = dl.materials.granite
    listed = [
        "--young",
        granite.young,
        "--poisson",
        granite.poisson,
        "--hardness",
        granite.hardness,
        "--density",
        granite.density,
    ]
    listed += ["--roughness", granite.surface.roughness, "--fractal-dimension", granite.surface.fractal_dimension]
    texts = []
    for number, words in enumerate((["--material", "granite"], map(str, listed))):
        folder = tmp_path / str(number)
        assert main([engine, "export", str(folder), "--radius", "4mm", "--count", "20", *words]) == 0
        texts.append([(folder / "in.case").read_text(), Table.load(next(folder.glob("*.tbl"))).force(1e-6)])
    assert texts[0] == texts[1]


def test_a_case_without_a_material_has_the_grains_of_granite():
    """Also the grains of a scene or a Python case whose material states no density."""
    defaults = {name: default[0] for name, _, default, _ in PROPERTIES if default != [None]}
    assert defaults == {name: getattr(dl.materials.granite, name) for name in ("young", "poisson", "density")}
    assert Grain(1e-3, dl.Material(60e9, 0.25)).density == dl.materials.granite.density


def test_the_flat_side_of_a_material(capsys):
    assert main(["regime", "--radius", "8mm", "flat", "--material", "granite", "--json"]) == 0
    contact = json.loads(capsys.readouterr().out)["contact"]
    assert contact["radius"] == 8e-3 and contact["sigma"] == pytest.approx(math.sqrt(2) * 1.7e-6)
