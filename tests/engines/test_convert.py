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
    assert {note.line: note.served for note in converted.notes} == {1: True, 4: True, 5: True, 6: False}


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
    assert cli.main([*arguments, "--json", "--overwrite"]) == 1
    assert any(note["line"] == 1 and not note["served"] for note in json.loads(capsys.readouterr().out)["notes"])


@pytest.mark.parametrize(
    "engine, lines, named",
    [
        ("lammps", ["pair_coeff * * hooke 1e4 0.5 tangential linear_history 8235 0 0.5"], [1]),
        ("lammps", ["fix w all wall/gran granular jkr 1e6 0.5 0.3 10 tangential mindlin NULL 1 0.5 zplane 0 1"], [1]),
        ("lammps", ["pair_coeff * * mdr 5e6 0.4 1.9e5 2.0 0.5 0.5"], [1]),
        ("lammps", ["pair_coeff * * dmt 1e6 0.5 0.3 10"], [1]),
        ("lammps", ["pair_style gran/hertz/history 1e5 2e4 50 25 0.5 1", "pair_coeff * *"], [1]),
        ("lammps", ["pair_style hybrid/overlay gran/hooke 1e5 2e4 50 25 0.5 1 zero 1", "pair_coeff * * gran/hooke"], [1]),
        ("lammps", ["fix w all wall/gran hertz/history 1e5 2e4 50 25 0.5 1 zplane 0 1"], [1]),
        ("lammps", ["fix w all wall/gran/region hooke/history 1e5 2e4 50 25 0.5 1 region cone"], [1]),
        ("lammps", ["pair_style granular", "pair_coeff * * ${model} 1e9 0.5 0.25"], [2]),
        ("lammps", ["pair_style ${style}"], [1]),
        ("lammps", ["fix w all wall/gran ${wall} zplane 0 1"], [1]),
        ("lammps", ['if "$a > 1" then "pair_coeff * * jkr 1e6 0.5 0.3 10"', "run 1"], [1]),
        ("lammps", ['run 10 every 5 "pair_coeff * * hooke 1 1"'], [1]),
        ("lammps", ["variable c string 'pair_coeff * * jkr 1e6 0.5 0.3 10'", "${c}"], [1, 2]),
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


def test_models_in_commands_that_are_not_read_are_named():
    text = f'units si\npair_style granular\n{LAMMPS.splitlines()[3]}\npython f source here """ f(\'hertz/material\') """\n'
    converted = convert(text + "print 'hertz/material'\n", "lammps", "law.tbl")
    assert [note.line for note in converted.notes if not note.served] == [4]
    partition = f"pair_style granular\npartition yes 1 {LAMMPS.splitlines()[3]}\n{LAMMPS.splitlines()[1]}\n"
    assert [note.line for note in convert(partition, "lammps", "law.tbl").notes if not note.served] == [2]


def test_places_by_variables_and_parts_of_inputs_are_no_fault():
    wall = "fix w all wall/gran model hertz tangential history primitive type 1 zcylinder ${r} 0. 0."
    converted = convert(f"pair_style gran model hertz tangential history\n{wall}\n", "liggghts", "law.tbl")
    assert converted.complete and converted.text.count("demlaws/table") == 2 and "zcylinder ${r} 0. 0." in converted.text
    wall = LAMMPS.splitlines()[3].replace("zplane 0.0", "zplane ${pz}")
    converted = convert(f"{wall}\nvariable r equal 2\n", "lammps", "law.tbl")  # a file that an input includes
    assert converted.complete and "zplane ${pz} NULL" in converted.text


def test_python_scripts_have_each_command_named():
    """Whole lines in quotes of a script are converted; a command in one of Python's is not, and is named."""
    line = LAMMPS.splitlines()[1].split(" #")[0]
    text = f'lmp = lammps()\nlmp.command("{line}")\nlmp.command(f"pair_coeff * * {{model}}")\n'
    text += f'lmp.commands_string("""\n{LAMMPS}""")\n'
    notes = convert(text, "lammps", "law.tbl").notes
    assert [note.line for note in notes if not note.served] == [2, 3]
    assert {note.line for note in notes if note.served} == {6, 8, 9}


def test_a_restart_file_and_moduli_are_asked_about(tmp_path):
    """The models of a restart file's pairs are in it; the moduli of the input may not be those of the table."""
    path = tmp_path / "in.case"
    path.write_text(f"read_restart now.restart\npair_style granular\n{LAMMPS.splitlines()[3]} damping tsuji\n")
    converted = convert_file(path, "lammps", table_in(tmp_path))[1]
    assert converted.complete and [note.line for note in converted.notes] == [1, 3, 3, 3, 3]
    texts = " ".join(note.text for note in converted.notes)
    modulus = dl.Table.load(HERTZ).contact.modulus
    assert "start from positions" in texts and f"{modulus:.4g} Pa" in texts and "damping tsuji stays" in texts
    with pytest.raises(DemlawsError, match="not a demlaws table"):
        convert_file(path, "lammps", path)


@pytest.mark.parametrize(("engine", "text"), [("lammps", LAMMPS), ("liggghts", LIGGGHTS.rsplit("variable", 1)[0])])
def test_converted_lines_stay(engine, text):
    once = convert(f"units si\n{text}", engine, "law.tbl").text
    with pytest.raises(DemlawsError, match="another table by hand"):
        convert(once, engine, "new.tbl")


def test_other_pair_styles_are_left_alone():
    """Lines of styles that are not granular are not named."""
    text = "units si\npair_style hybrid/overlay granular lj/cut 2.5\npair_coeff 1 1 granular hertz/material 1e9 0.8 0.25\n"
    text += 'pair_coeff 2 2 lj/cut 1.0 1.0\npair_coeff 1 2 lj/cut ${e} 1.0\nfix 1 all nve\nif "${x} > 1" then "jump SELF a"\n'
    converted = convert(text, "lammps", "law.tbl")
    assert converted.complete and {note.line for note in converted.notes} == {3}
    text = "units si\npair_style lj/cut 2.5\npair_coeff * * 1.0 ${e}\n" + LAMMPS.splitlines()[3] + "\n"
    assert convert(text, "lammps", "law.tbl").complete


def test_words_that_stay():
    """synchronized_verlet, and variables in numbers."""
    line = LAMMPS.splitlines()[1].split("#")[0]
    converted = convert(f"{line}synchronized_verlet\n", "lammps", "law.tbl")
    assert converted.complete and "tangential demlaws" in converted.text and "synchronized_verlet\n" in converted.text
    stays = line.replace("mindlin NULL", "linear_history ${kt}").replace("1e9", "${E}")
    converted = convert(stays, "lammps", "law.tbl")
    assert converted.complete and "law.tbl ${E} 0.8 0.25 tangential linear_history ${kt}" in converted.text


def test_included_files_with_granular_lines_are_named(tmp_path):
    (tmp_path / "values.in").write_text("variable E equal 1e9\n")
    (tmp_path / "models.in").write_text("print hello\n" + LAMMPS.splitlines()[3] + "\n")
    path = tmp_path / "in.case"
    lines = ["include values.in", "include models.in", "include absent.in", "jump in.case end", LAMMPS.splitlines()[1]]
    path.write_text("\n".join(lines) + "\n")
    converted = convert_file(path, "lammps", table_in(tmp_path))[1]
    assert [note.line for note in converted.notes if not note.served] == [2, 3]


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
    "liggghts hybrid": "pair_style hybrid gran model hertz tangential history\npair_coeff * * gran\n"
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
        if path.parent.name not in (*script.TUTORIALS, "contactModels"):
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
