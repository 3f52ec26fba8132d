"""Inputs of the engines with demlaws/table in place of their contact model."""

import json
import os
import shutil
from pathlib import Path

import pytest
from inputs import part

import demlaws as dl
from demlaws import cli
from demlaws.errors import DemlawsError
from demlaws.liggghts import run
from demlaws.plugins.convert import convert, convert_file
from studies.cases import tutorials as script

HERTZ = Path(__file__).parents[1] / "data" / "tables" / "good" / "hertz-elastic.tbl"
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


def table_in(folder):
    """Hertz's table in a folder of the test: engines accept no spaces in its name, as that of this project may have."""
    return shutil.copy(HERTZ, folder / "law.tbl")


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
    ],
)
def test_what_is_not_served_stays_and_is_listed(engine, line, tmp_path, capsys):
    wall = {"liggghts": LIGGGHTS, "lammps": LAMMPS}[engine].splitlines()[3]
    (tmp_path / "in.case").write_text(f"{line}\n{wall}\n")
    table_in(tmp_path)
    arguments = [engine, "convert", str(tmp_path / "in.case"), "--table", str(tmp_path / "law.tbl")]
    assert cli.main(arguments) == 1
    out = " ".join(capsys.readouterr().out.split())
    assert "line 1: NOT CONVERTED" in out and "stop the run" in out
    text = (tmp_path / "in.case.demlaws").read_text()
    for word in ("multicontact", "tan_luding", "washino", "jkr", "hertz 1e5", "gran/hertz/history"):
        assert (word in line) == (word in text)
    assert cli.main([*arguments, "--json", "--force"]) == 1
    assert any(note["line"] == 1 and not note["served"] for note in json.loads(capsys.readouterr().out)["notes"])


@pytest.mark.parametrize(
    "engine, lines, named",
    [
        ("lammps", ["pair_coeff * * hooke 1e4 0.5 tangential linear_history 8235 0 0.5"], [1]),
        ("lammps", ["fix w all wall/gran granular jkr 1e6 0.5 0.3 10 tangential mindlin NULL 1 0.5 zplane 0 1"], [1]),
        ("lammps", ["pair_coeff * * mdr 5e6 0.4 1.9e5 2.0 0.5 0.5"], [1]),
        ("lammps", ["pair_coeff * * dmt 1e6 0.5 0.3 10"], [1]),
        ("lammps", ["pair_coeff * * hertz/material 0 0 0 tangential linear_nohistory 0 0"], [1]),
        ("lammps", ["pair_style gran/hertz/history 1e5 2e4 50 25 0.5 1", "pair_coeff * *"], [1]),
        ("lammps", ["pair_style hybrid/overlay gran/hooke 1e5 2e4 50 25 0.5 1 zero 1", "pair_coeff * * gran/hooke"], [1]),
        ("lammps", ["fix w all wall/gran hertz/history 1e5 2e4 50 25 0.5 1 zplane 0 1"], [1]),
        ("lammps", ["fix w all wall/gran/region hooke/history 1e5 2e4 50 25 0.5 1 region cone"], [1]),
        ("lammps", ["pair_style granular", "pair_coeff * * ${model} 1e9 0.5 0.25"], [2]),
        ("lammps", ["pair_style granular", "variable m index hooke hertz", "pair_coeff * * $m 1e9 0.5 0.25"], [3]),
        ("lammps", ["pair_style ${style}"], [1]),
        ("lammps", ["fix w all wall/gran ${wall} zplane 0 1"], [1]),
        ("lammps", ['if "$a > 1" then "pair_coeff * * jkr 1e6 0.5 0.3 10"', "run 1"], [1]),
        ("lammps", ['run 10 every 5 "pair_coeff * * hooke 1 1"'], [1]),
        ("lammps", ["variable c string 'pair_coeff * * jkr 1e6 0.5 0.3 10'", "${c}"], [2]),
        ("lammps", ["pair_style granular", "pair_coeff * * thing 1e6 0.5 0.3"], [2]),
        ("liggghts", ["pair_style gran/hertz/history 1 0", "pair_coeff * *", "fix z all wall/gran/hertz/history 1 0"], [1, 3]),
        ("liggghts", ["pair_style gran ${model}"], [1]),
        ("liggghts", ["fix z all wall/gran model ${m} tangential history primitive type 1 zplane 0"], [1]),
        ("liggghts", ["pair_style gran_bubble bubble"], [1]),
    ],
)
def test_granular_lines_alone_that_stay(engine, lines, named, tmp_path, capsys):
    """These were "nothing to convert", or they were not mentioned."""
    text = "\n".join(["units si", *lines]) + "\n"
    (tmp_path / "in.case").write_text(text)
    table_in(tmp_path)
    arguments = [engine, "convert", str(tmp_path / "in.case"), "--table", str(tmp_path / "law.tbl"), "--json"]
    assert cli.main(arguments) == 1
    result = json.loads(capsys.readouterr().out)
    assert [note["line"] - 1 for note in result["notes"] if not note["served"]] == named
    assert result["file"] is None and not (tmp_path / "in.case.demlaws").exists()


@pytest.mark.parametrize("name", ["case.py", "in.case"])
def test_python_scripts_are_refused(name, tmp_path, capsys):
    """One of three commands was converted, and the others were not named."""
    line = LAMMPS.splitlines()[1].split(" #")[0]
    text = f'from lammps import lammps\nlmp = lammps()\nlmp.command("{line}")\nlmp.commands_string("""\n{LAMMPS}""")\n'
    (tmp_path / name).write_text(text)
    assert cli.main(["lammps", "convert", str(tmp_path / name), "--table", str(table_in(tmp_path))]) == 2
    assert "Python script" in capsys.readouterr().err
    assert {file.name for file in tmp_path.iterdir()} == {name, "law.tbl"}


def test_models_in_commands_that_are_not_read_are_named():
    text = f'units si\npair_style granular\n{LAMMPS.splitlines()[3]}\npython f source here """ f(\'hertz/material\') """\n'
    converted = convert(text + "print 'hertz/material'\n", "lammps", "law.tbl")
    assert [note.line for note in converted.notes if not note.served] == [4]
    partition = f"pair_style granular\npartition yes 1 {LAMMPS.splitlines()[3]}\n{LAMMPS.splitlines()[1]}\n"
    assert [note.line for note in convert(partition, "lammps", "law.tbl").notes if not note.served] == [2]


@pytest.mark.parametrize("pairs", ["", LAMMPS.splitlines()[1] + "\n"])
@pytest.mark.parametrize(
    ("content", "served"),
    [(b"granular hertz/material", [False]), (b"granular demlaws/table", []), (b"lj/cut", []), (None, [True])],
)
def test_pairs_of_a_restart_file(tmp_path, pairs, content, served):
    """Their models are in it: walls were converted, pairs remained stock ones without a word."""
    if content is not None:
        (tmp_path / "now.restart").write_bytes(content)
    path = tmp_path / "in.case"
    path.write_text(f"read_restart now.restart\npair_style granular\n{pairs}{LAMMPS.splitlines()[3]}\n")
    converted = convert_file(path, "lammps", table_in(tmp_path))[1]
    assert [note.served for note in converted.notes if note.line == 1] == served


def test_places_by_variables_and_parts_of_inputs_are_no_fault():
    wall = "fix w all wall/gran model hertz tangential history primitive type 1 zcylinder ${r} 0. 0."
    converted = convert(f"pair_style gran model hertz tangential history\n{wall}\n", "liggghts", "law.tbl")
    assert converted.complete and converted.text.count("demlaws/table") == 2 and "zcylinder ${r} 0. 0." in converted.text
    wall = LAMMPS.splitlines()[3].replace("zplane 0.0", "zplane ${pz}")
    converted = convert(f"{wall}\nvariable r equal 2\n", "lammps", "law.tbl")  # a file that an input includes
    assert converted.complete and "zplane ${pz} NULL" in converted.text


@pytest.mark.parametrize(("engine", "text"), [("lammps", LAMMPS.replace("other.tbl", "law.tbl")), ("liggghts", LIGGGHTS)])
def test_a_converted_input_gets_another_table(engine, text):
    once = convert(f"units si\n{text}", engine, "law.tbl")
    assert convert(once.text, engine, "new.tbl").text == once.text.replace("law.tbl", "new.tbl")
    two = once.text.replace("law.tbl", "a.tbl", 1).replace("pair_coeff 1 *", "pair_coeff 1 1")
    if engine == "lammps":
        with pytest.raises(DemlawsError, match=r"several tables, a\.tbl, law\.tbl"):
            convert(two, engine, "new.tbl")


def test_what_is_asked_about(tmp_path):
    """A modulus that is not the table's, a damping that takes another stiffness; a table that is none is refused."""
    path = tmp_path / "in.case"
    line = LAMMPS.splitlines()[1].split(" #")[0].replace("1e9", "5e6")
    path.write_text(f"units si\npair_style granular\n{line} damping tsuji\n")
    text = " ".join(note.text for note in convert_file(path, "lammps", table_in(tmp_path))[1].notes)
    assert "Young's modulus 5e+06 Pa" in text and "damping tsuji stays" in text
    young = 2 * dl.Table.load(HERTZ).contact.modulus * (1 - 0.25**2)
    path.write_text(f"units si\npair_style granular\n{line.replace('5e6', repr(young))} damping demlaws/tangent\n")
    assert len(convert_file(path, "lammps", table_in(tmp_path))[1].notes) == 2
    path.write_text(f"fix m1 all property/global youngsModulus peratomtype 5e6 {young!r}\n{LIGGGHTS}")
    assert "Young's modulus 5e+06 Pa" in convert_file(path, "liggghts", table_in(tmp_path))[1].notes[0].text
    with pytest.raises(DemlawsError, match="not a demlaws table"):
        convert_file(path, "liggghts", path)


def test_a_modulus_in_other_units_or_by_a_variable_is_asked_about(tmp_path):
    """units cgs were read as Pa; the value of an equal-style variable, as most inputs have it, was not seen."""
    path, young = tmp_path / "in.case", 2 * dl.Table.load(HERTZ).contact.modulus * (1 - 0.25**2)

    def asked(units, value, begin=""):
        path.write_text(f"{begin}units {units}\nfix m1 all property/global youngsModulus peratomtype {value}\n{LIGGGHTS}")
        notes = convert_file(path, "liggghts", table_in(tmp_path))[1].notes
        return [note.text.partition(" has ")[0] for note in notes if "Young's modulus" in note.text]

    assert asked("cgs", repr(10 * young)) == asked("micro", repr(1e-3 * young)) == asked("si", repr(young)) == []
    assert asked("cgs", repr(young)) == [f"Young's modulus {0.1 * young:g} Pa"]
    assert asked("si", "${E}", "variable E equal 5e6\n") == ["Young's modulus 5e+06 Pa"]
    assert asked("si", "${E}", f"variable E equal {young!r}\n") == asked("si", "${E}", "variable E equal 2*v_a\n") == []


def test_other_pair_styles_are_left_alone():
    """Lines of styles that are not granular are not named."""
    text = "units si\npair_style hybrid/overlay granular lj/cut 2.5\npair_coeff 1 1 granular hertz/material 1e9 0.8 0.25\n"
    text += 'pair_coeff 2 2 lj/cut 1.0 1.0\npair_coeff 1 2 lj/cut ${e} 1.0\nfix 1 all nve\nif "${x} > 1" then "jump SELF a"\n'
    converted = convert(text, "lammps", "law.tbl")
    assert converted.complete and {note.line for note in converted.notes} == {3}
    text = "units si\npair_style lj/cut 2.5\npair_coeff * * ${e} 1.0\n" + LAMMPS.splitlines()[3] + "\n"
    assert convert(text, "lammps", "law.tbl").complete


def test_what_stops_or_misleads_a_run_is_mentioned():
    """delete_atoms that renumbers; synchronized_verlet stays beside tangential demlaws; a model by variable is converted."""
    head = "units si\n"
    line = LAMMPS.splitlines()[1]
    for command, mentioned in (
        ("delete_atoms group a", True),
        ("delete_atoms group a compress yes", True),
        ("delete_atoms group a compress no", False),
    ):
        for engine, model in (("lammps", line), ("liggghts", LIGGGHTS.splitlines()[3])):
            notes = convert(f"{head}{model}\n{command}\n", engine, "law.tbl").notes
            assert any(note.line == 3 for note in notes) == mentioned
    converted = convert(head + line.split("#")[0] + "synchronized_verlet\n", "lammps", "law.tbl")
    assert converted.complete and "tangential demlaws" in converted.text and "synchronized_verlet\n" in converted.text
    stays = LAMMPS.splitlines()[1].replace("mindlin NULL", "linear_history ${kt}")
    converted = convert(f"{head}{stays}\n", "lammps", "law.tbl")
    assert converted.complete and "law.tbl 1e9 0.8 0.25 tangential linear_history ${kt}" in converted.text
    assert not convert(f"{head}{stays.replace('linear_history', '$m')}\n", "lammps", "law.tbl").complete
    text = "variable model index history\npair_style gran model hertz tangential ${model} cohesion ${c}\n"
    converted = convert(text, "liggghts", "law.tbl")
    assert "tangential demlaws cohesion ${c}" in converted.text
    assert [note.line for note in converted.notes if not note.served] == [2]


def test_included_files_are_followed(tmp_path):
    """Their variables have values in the input; their granular lines are named."""
    table_in(tmp_path)
    (tmp_path / "values.in").write_text("variable m string hertz/material\nvariable E equal 1e9\n")
    (tmp_path / "models.in").write_text("print hello\n" + LAMMPS.splitlines()[3] + "\n")
    path = tmp_path / "in.case"
    lines = ["units si", "include values.in", "pair_style granular", "pair_coeff * * $m ${E} 0.8 0.25", "jump in.case end"]
    path.write_text("\n".join(lines) + "\n")
    out, converted = convert_file(path, "lammps", tmp_path / "law.tbl")
    assert converted.complete and "pair_coeff * * demlaws/table law.tbl ${E} 0.8 0.25\n" in out.read_text()
    for file in ("models.in", "absent.in"):
        path.write_text("\n".join([*lines, f"include {file}"]) + "\n")
        assert [
            note.line for note in convert_file(path, "lammps", tmp_path / "law.tbl", out=out)[1].notes if not note.served
        ] == [6]


LAMMPS_HEAD = """\
units si
atom_style sphere
atom_modify map array
comm_modify vel yes
newton off
boundary f f f
region box block -0.03 0.03 -0.02 0.02 -0.02 0.02
create_box 1 box
create_atoms 1 single -0.0039 0 0
create_atoms 1 single 0.0039 0 0
set group all diameter 0.00782 density 2650
neighbor 1e-4 bin
timestep 5e-8
"""
LAMMPS_TAIL = """
fix move all nve/sphere
compute f all reduce max fx fz
thermo_style custom step c_f[1] c_f[2]
run 0
"""
LIGGGHTS_HEAD = """\
units si
atom_style granular
atom_modify map array
communicate single vel yes
newton off
hard_particles yes
boundary f f f
region box block -0.03 0.03 -0.02 0.02 -0.02 0.02 units box
create_box 1 box
neighbor 1e-3 bin
fix p1 all property/global youngsModulus peratomtype 60.6e9
fix p2 all property/global poissonsRatio peratomtype 0.25
fix p3 all property/global coefficientRestitution peratomtypepair 1 0.5
fix p4 all property/global coefficientFriction peratomtypepair 1 0.5
timestep 5e-8
"""
LIGGGHTS_TAIL = """
create_atoms 1 single -0.0039 0 0 units box
create_atoms 1 single 0.0039 0 0 units box
set group all diameter 0.00782 density 2650
fix move all nve/sphere
compute f1 all reduce max fx
compute f2 all reduce max fz
thermo_style custom step c_f1 c_f2
run 0
"""
MODEL = "hertz/material 60.6e9 0.5 0.25 tangential mindlin NULL 1.0 0.5 damping tsuji"
WALL = "zplane -0.0039 NULL"
WRITTEN = {
    "lammps hybrid": f"pair_style hybrid granular\npair_coeff * * granular {MODEL}\n"
    f"fix w all wall/gran granular {MODEL} {WALL}",
    "lammps hybrid/overlay": f"pair_style hybrid/overlay zero 0.02 granular\npair_coeff * * zero\n"
    f"pair_coeff * * granular {MODEL}\nfix w all wall/gran granular {MODEL} {WALL}",
    "lammps variables": f'variable wall string "granular {MODEL}"\nvariable m index hertz/material\nvariable E equal 60.6e9\n'
    f"pair_style granular\npair_coeff * * $m ${{E}} 0.5 0.25 tangential mindlin NULL 1.0 0.5 damping tsuji\n"
    f"fix w all wall/gran ${{wall}} {WALL}",
    "lammps if": f'variable rough equal 1\npair_style granular\nif "${{rough}} == 1" then &\n'
    f' "pair_coeff * * {MODEL}" "fix w all wall/gran granular {MODEL} {WALL}" else &\n \'pair_coeff * * {MODEL}\'',
    "lammps command": f"variable c string 'pair_coeff * * {MODEL}'\npair_style granular\n${{c}}\n"
    f"fix w all wall/gran granular {MODEL} {WALL}",
    "liggghts hybrid": "pair_style hybrid gran model hertz tangential history\npair_coeff * * gran\n"
    "fix w all wall/gran model hertz tangential history primitive type 1 zplane -0.0039",
    "liggghts variables": 'variable t index history\nvariable m string "model hertz tangential history"\n'
    "pair_style gran model hertz tangential ${t}\npair_coeff * *\nfix w all wall/gran $m primitive type 1 zplane -0.0039",
    "liggghts if": 'variable r equal 1\nif "${r} == 1" then "pair_style gran model hertz tangential history" "pair_coeff * *"\n'
    "fix w all wall/gran model hertz tangential history primitive type 1 zplane -0.0039",
}


@pytest.mark.parametrize("engine, name", [tuple(name.split(" ", 1)) for name in WRITTEN])
def test_forces_after_conversion(engine, name, law, tmp_path):
    """Two spheres and a wall: the table's forces, not the stock ones; with Hertz's table the stock forces."""
    head, tail = (LAMMPS_HEAD, LAMMPS_TAIL) if engine == "lammps" else (LIGGGHTS_HEAD, LIGGGHTS_TAIL)
    contact = law.contact.with_values(radius=1.955e-3)
    (tmp_path / "in.case").write_text(f"{head}{WRITTEN[f'{engine} {name}']}{tail}")
    run_it = part(engine, "run").run

    def forces(path, **how):
        log = run_it(path, **how)
        return [float(column[-1]) for title, column in log.items() if title not in ("Step", "step")]

    found = {}
    for kind in ("hertz", law.name):
        made = dl.law(kind, contact, unloading="elastic" if kind == "hertz" else law.unloading)
        made.tabulate(rtol=1e-7).save(tmp_path / f"{kind}.tbl")
        out, converted = convert_file(tmp_path / "in.case", engine, tmp_path / f"{kind}.tbl")
        assert converted.complete and out.read_text().count(f"{kind}.tbl") >= 1
        found[kind] = forces(out)
        wall = made.bound_to(contact.with_values(radius=2 * contact.radius))
        assert found[kind] == pytest.approx([made.force(20e-6), wall.force(10e-6)], rel=1e-5)
    assert forces(tmp_path / "in.case", plugin=False) == pytest.approx(found["hertz"], rel=1e-5)
    assert found[law.name][0] < 0.8 * found["hertz"][0]


def test_nothing_to_convert_is_an_error(tmp_path, capsys):
    with pytest.raises(DemlawsError):
        convert("print hello\n", "lammps", "law.tbl")
    with pytest.raises(DemlawsError):
        convert(LAMMPS, "lammps", "my law.tbl")
    (tmp_path / "in.case").write_text(LAMMPS)
    assert cli.main(["lammps", "convert", str(tmp_path / "in.case"), "--table", "none.tbl"]) == 2


@pytest.fixture
def tutorials():
    """Folder of LIGGGHTS's own tutorials."""
    try:
        return script.find(os.environ.get("DEMLAWS_LIGGGHTS_DOC"))
    except DemlawsError:
        pytest.skip(script.INSTALL)


@pytest.mark.parametrize("engine", ["liggghts"])
def test_three_ways_of_one_tutorial(engine, tutorials, tmp_path):
    stock, hertz, rough = script.compare(tutorials / "packing", tmp_path, 1500)
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
    ran, refused = [], []
    for path in sorted(tutorials.glob("*/in.*")):
        try:
            converted = convert(path.read_text(), engine, "law.tbl")
        except DemlawsError:
            continue
        if not all(note.served for note in converted.notes):
            refused.append(path.name)
            continue
        if path.parent.name not in (*script.TUTORIALS, "cohesion", "contactModels"):
            continue
        there = tmp_path / path.parent.name
        shutil.copytree(path.parent, there, dirs_exist_ok=True)
        (there / "post").mkdir(exist_ok=True)
        script.tables(path.read_text(), there)
        text = script.changed(path.read_text(), "rough table", 400)
        (there / "in.case").write_text(text.replace("tangential history", "tangential demlaws"))
        assert run(there / "in.case")["Step"][-1] > 0
        ran.append(path.name)
    assert len(ran) >= 8 and "in.hydrogel_multicontact" in refused


@pytest.mark.parametrize(
    ("line", "mentioned"),
    [
        ("pair_style gran/hooke/history 1 0", True),  # of LIGGGHTS 2
        ("pair_style ${style} model hertz", True),
        ("pair_style hybrid gran/hertz/history soft 1.0", True),
        ("pair_style soft 1.0", False),
        ("pair_style none", False),
        ("fix gran all ave/time 1 1 1 c_gran", False),
        ("variable gran equal 1", False),
    ],
)
def test_lines_that_are_no_style_of_liggghts_3(line, mentioned):
    """A granular style in another form, or one by variable, is named; other lines are not."""
    converted = convert(f"units si\n{line}\n{LIGGGHTS.splitlines()[3]}\n", "liggghts", "law.tbl")
    assert any(note.line == 2 for note in converted.notes) == mentioned
    assert line in converted.text
