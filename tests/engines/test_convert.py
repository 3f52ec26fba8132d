"""Inputs of the engines with demlaws/table in place of their contact model."""

import importlib.util
import json
import os
import shutil
from pathlib import Path

import pytest

from demlaws import cli
from demlaws.convert import convert
from demlaws.errors import DemlawsError
from demlaws.liggghts import run

TUTORIALS = Path(__file__).parents[2] / "liggghts_inputs" / "tutorials.py"
LIGGGHTS = """\
pair_style gran model hertz tangential history rolling_friction epsd2 torsionTorque off &
    absolute_damping on  # of the tutorial
pair_coeff * *
fix floor all wall/gran model hertz tangential history primitive type 1 zplane 0.0
fix drum all wall/gran model hooke tangential no_history mesh n_meshes 1 meshes cad
variable a string "model hertz tangential history"
"""
LAMMPS = """\
pair_style granular
pair_coeff 1 * hertz/material 1e9 0.8 0.25 tangential mindlin NULL 1.0 0.4 # one
pair_coeff 2 2 demlaws/table other.tbl 1e9 0.8 0.25 tangential mindlin NULL 1.0 0.4
fix floor all wall/gran granular hertz/material 1e9 0.8 0.25 tangential mindlin NULL 1.0 0.4 zplane 0.0 NULL
fix drum all wall/gran/region granular hertz/material 1e9 0.8 0.25 tangential mindlin NULL 1.0 0.4 region drum
"""


def test_every_line_of_liggghts():
    converted = convert(LIGGGHTS, "liggghts", "law.tbl")
    assert converted.text.splitlines() == [
        "pair_style gran model demlaws/table tangential demlaws rolling_friction epsd2 torsionTorque off table law.tbl "
        "# of the tutorial",
        "pair_coeff * *",
        "fix floor all wall/gran model demlaws/table tangential demlaws primitive type 1 zplane 0.0",
        "fix drum all wall/gran model demlaws/table tangential no_history mesh n_meshes 1 meshes cad",
        'variable a string "model hertz tangential history"',
    ]
    assert all(note.served for note in converted.notes) and {note.line for note in converted.notes} == {1, 4, 5}


def test_every_line_of_lammps():
    lines = convert(LAMMPS, "lammps", "law.tbl").text.splitlines()
    assert lines[1] == "pair_coeff 1 * demlaws/table law.tbl 1e9 0.8 0.25 tangential demlaws 1.0 0.4 # one"
    assert lines[2] == LAMMPS.splitlines()[2]
    assert [line.count("demlaws/table law.tbl 1e9 0.8 0.25") for line in lines] == [0, 1, 0, 1, 1]


@pytest.mark.parametrize(
    "engine, line",
    [
        ("liggghts", "pair_style gran model hertz tangential history surface multicontact"),
        ("liggghts", "pair_style gran model hertz tangential tan_luding"),
        ("liggghts", "pair_style gran model hertz cohesion washino/capillary/viscous tangential history"),
        ("lammps", "pair_coeff * * jkr 1e9 50 0.3 10 tangential mindlin NULL 1.0 0.4"),
        ("lammps", "pair_coeff * * hertz 1e5 50 tangential mindlin NULL 1.0 0.4"),
        ("lammps", "pair_style gran/hertz/history 1e5 NULL 50 NULL 0.4 1"),
        ("lammps", "units cgs"),
        ("lammps", "timestep 1e-6"),  # no units line: lj
        ("liggghts", "units lj"),
    ],
)
def test_what_is_not_served_stays_and_is_listed(engine, line, tmp_path, capsys):
    wall = {"liggghts": LIGGGHTS, "lammps": LAMMPS}[engine].splitlines()[3]
    (tmp_path / "in.case").write_text(f"{line}\n{wall}\n")
    (tmp_path / "law.tbl").write_text("")
    arguments = [engine, "convert", str(tmp_path / "in.case"), "--table", str(tmp_path / "law.tbl")]
    assert cli.main(arguments) == 1
    out = capsys.readouterr().out
    assert "line 1: NOT SERVED" in out and "run stops" in out
    text = (tmp_path / "in.case.demlaws").read_text()
    for word in ("multicontact", "tan_luding", "washino", "jkr", "hertz 1e5", "gran/hertz/history"):
        assert (word in line) == (word in text)
    assert cli.main([*arguments, "--json", "--force"]) == 1
    assert any(note["line"] == 1 and not note["served"] for note in json.loads(capsys.readouterr().out)["notes"])


def test_nothing_to_convert_is_an_error(tmp_path, capsys):
    with pytest.raises(DemlawsError):
        convert("print hello\n", "lammps", "law.tbl")
    with pytest.raises(DemlawsError):
        convert(LAMMPS, "lammps", "my law.tbl")
    (tmp_path / "in.case").write_text(LAMMPS)
    assert cli.main(["lammps", "convert", str(tmp_path / "in.case"), "--table", "none.tbl"]) == 2


@pytest.fixture
def tutorials():
    """The script, and LIGGGHTS's own tutorials."""
    spec = importlib.util.spec_from_file_location("tutorials", TUTORIALS)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    try:
        return module, module.find(os.environ.get("DEMLAWS_LIGGGHTS_DOC"))
    except DemlawsError:
        pytest.skip(module.INSTALL)


@pytest.mark.parametrize("engine", ["liggghts"])
def test_three_ways_of_one_tutorial(engine, tutorials, tmp_path):
    script, folder = tutorials
    stock, hertz, rough = script.compare(folder / "packing", tmp_path, 1500)
    assert [row["way"] for row in (stock, hertz, rough)] == list(script.WAYS)
    assert stock["steps"] == hertz["steps"] == rough["steps"] == 1 + 2 * 1500  # two runs, each up to the cap
    assert stock["grains"] == 338 and stock["worst"] == 0 and stock["beyond"] == hertz["beyond"] == 0
    assert hertz["worst"] < 1e-9 < 1e-4 < rough["worst"]
    assert not list(tmp_path.rglob("post/*"))
    lines = script.table([stock, hertz, rough])
    assert len(lines) == 1 + 3 + 2 and all("packing" in line for line in lines[1:4])


@pytest.mark.parametrize("engine", ["liggghts"])
def test_tutorials_of_the_package_run(engine, tutorials, tmp_path):
    """Each input of a folder of LIGGGHTS's tutorials is converted; where all is served, it runs a few steps."""
    module, folder = tutorials
    ran, refused = [], []
    for script in sorted(folder.glob("*/in.*")):
        try:
            converted = convert(script.read_text(), engine, "law.tbl")
        except DemlawsError:
            continue
        if not all(note.served for note in converted.notes):
            refused.append(script.name)
            continue
        if script.parent.name not in (*module.TUTORIALS, "cohesion", "contactModels"):
            continue
        there = tmp_path / script.parent.name
        shutil.copytree(script.parent, there, dirs_exist_ok=True)
        (there / "post").mkdir(exist_ok=True)
        module.tables(script.read_text(), there)
        text = module.changed(script.read_text(), "rough table", 400)
        (there / "in.case").write_text(text.replace("tangential history", "tangential demlaws"))
        assert run(there / "in.case")["Step"][-1] > 0
        ran.append(script.name)
    assert len(ran) >= 8 and "in.hydrogel_multicontact" in refused
