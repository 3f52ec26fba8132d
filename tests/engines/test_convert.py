"""Inputs of the engines with demlaws/table in place of their contact model."""

import json
import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest
from inputs import part

import demlaws as dl
from demlaws import cli
from demlaws.errors import DemlawsError
from demlaws.liggghts import run
from demlaws.plugins import styles
from demlaws.plugins.convert import Table, convert, convert_file
from studies.cases import tutorials as script

DOCUMENTATION = Path("/usr/share/doc/liggghts/doc")
HERTZ = Path(__file__).parents[1] / "data" / "tables" / "good" / "hertz-elastic.tbl"
LIGGGHTS = """\
pair_style gran model hertz tangential history rolling_friction epsd2 torsionTorque off &
    absolute_damping on  # of the tutorial
pair_coeff * *
fix floor all wall/gran model hertz tangential history primitive type 1 zplane 0.0
fix drum all wall/gran model hertz tangential no_history mesh n_meshes 1 meshes cad
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


# --- what the table would drop


@pytest.fixture(scope="module")
def tables(tmp_path_factory):
    """Tables of laws that are not every model's: the files, by law."""
    folder, contact = tmp_path_factory.mktemp("tables"), dl.Contact(radius=2e-3, modulus=1e7)
    kinds = {
        "luding": {"loading_stiffness": 1e3, "stiffness_ratio": 3.0, "plasticity_depth": 0.05},
        "walton-braun": {"loading_stiffness": 1e3, "stiffness_ratio": 1.0},
        "eepa": {"stiffness_ratio": 3.0},
        "thornton-ning": {"yield_pressure": 1e6},
    }
    for law, options in kinds.items():
        dl.law(law, contact, **options).tabulate(max_force=1.0).save(folder / f"{law}.tbl")
    return folder


NEAREST = {
    "hooke": "walton-braun",
    "hooke/stiffness": "walton-braun",
    "hooke/hysteresis": "luding",
    "luding": "luding",
    "edinburgh": "eepa",
    "edinburgh/stiffness": "eepa",
    "hysteretic/nonlinear1": "eepa",
    "thornton_ning": "thornton-ning",
}


@pytest.mark.parametrize("model", NEAREST)
def test_plastic_and_linear_models_need_a_table_of_their_law(model, tables, tmp_path):
    """Else a plastic, adhesive or linear contact would become that of the table without a word."""
    path, law = tmp_path / "in.case", NEAREST[model]
    path.write_text(f"pair_style gran model {model} tangential history\npair_coeff * *\n")
    out, conversion = convert_file(path, "liggghts", table_in(tmp_path))
    (note,) = conversion.notes
    assert out is None and not note.served and f"demlaws table --law {law} --option" in note.text and model in note.text
    out, conversion = convert_file(path, "liggghts", tables / f"{law}.tbl")
    assert conversion.complete and f"law {law}" in " ".join(note.text for note in conversion.notes)
    assert f"model demlaws/table tangential demlaws table {os.path.relpath(tables, tmp_path)}/{law}.tbl" in out.read_text()


@pytest.mark.parametrize(
    ("engine", "line", "named"),
    [
        ("liggghts", "pair_style gran model jkr tangential history", "adhesive"),
        ("liggghts", "pair_style gran model hertz/stiffness tangential history", "4/3 E*"),
        ("liggghts", "pair_style gran model cundall tangential history", "does not know"),
        ("liggghts", "pair_style hybrid gran model hertz bubble model hertz", "bubble"),
        ("liggghts", "fix c all multicontact/halfspace", "multicontact"),
        ("liggghts", "fix g all wall/gran/other model hertz", "does not know"),
        ("liggghts", "compute c all clump/gran", "does not know"),
        ("liggghts", "coarsegraining 2.0", "coarse grains"),
        ("liggghts", "atom_style superquadric", "spheres only"),
        ("liggghts", "fix i all insert/stream/predefined", "histories"),
        ("liggghts", "fix h all heat/gran/conduction initial_temperature 300 area_correction yes", "power of the overlap"),
        ("liggghts", "pair_style gran model hertz tangential history curvatureLimitFactor 0.1", "no setting of demlaws/table"),
        ("lammps", "pair_coeff * * hooke 1e5 0.5 tangential linear_nohistory 1 0.5", "walton-braun"),
        ("lammps", "pair_coeff * * hertz 1e5 0.5 tangential linear_nohistory 1 0.5", "1.5 (1 - nu²) k_n"),
        ("lammps", "pair_coeff * * mdr 5e6 0.4 1.9e5 2.0 0.5 0.5", "thornton-ning"),
        ("lammps", "pair_coeff * * jkr 1e6 0.5 0.3 10", "adhesive"),
        ("lammps", "pair_coeff * * cundall 1e6 0.5 0.3", "no normal model that convert knows"),
        ("lammps", "pair_coeff * * hertz/material 1e6", "E eta nu"),
        ("lammps", "pair_style granular/superellipsoid", "cannot be used with it"),
        ("lammps", "pair_style granular/other", "does not know"),
        ("lammps", "pair_style hybrid/overlay granular surf/granular", "surface/global"),
        ("lammps", "pair_coeff * * surf/granular hertz/material 1e7 0.1 0.3 tangential mindlin NULL 1 0.5", "surface/global"),
        ("lammps", "fix s all surface/local input stl 1 plate.stl", "surface/global"),
        ("lammps", "fix s all surface/global input stl 1 1 a.stl model * * hertz/material 1e7 0.1 0.3", "an old style"),
        ("lammps", "run_style respa 2 4 pair 1", "verlet"),
        ("lammps", "reset_atoms id", "before the first run"),
        ("lammps", "units lj", "metres"),
        ("lammps", 'if "$a > 1" then "delete_atoms group g"', "delete_atoms"),
    ],
)
def test_lines_that_drop_something_or_stop_the_run_are_named(engine, line, named):
    style = {"liggghts": "pair_style gran model hertz tangential history\n", "lammps": "pair_style granular\n"}[engine]
    text = f"{style}{line}\n{style}{ {'liggghts': LIGGGHTS, 'lammps': LAMMPS}[engine].splitlines()[3] }\n"
    (note,) = [note for note in convert(text, engine, "law.tbl").notes if not note.served]
    assert note.line == 2 and named in note.text


def test_an_ellipsoid_gets_no_advice_for_spheres():
    text = "pair_style granular/superellipsoid\npair_coeff * * hertz 1e9 0. tangential linear_history 5e8 0. .5\n"
    (note,) = convert(text, "lammps", "law.tbl").notes
    assert note.line == 1 and "hertz/material" not in note.text


def styles_of(text, begins):
    """Names of a block of an engine's -help."""
    found = re.search(rf"^\* {begins}:?[^\n]*\n\n(.*?)\n\n(?:\*|\Z)", text, re.M | re.S)
    return found[1].split() if found else []


@pytest.mark.parametrize("engine", ["liggghts", "lammps"])
def test_granular_styles_are_those_of_the_engine(engine):
    """Each that it prints, and each that its documentation has, is in one of the lists."""
    program = part(engine, "run").executable()
    _, environment = part(engine, "run").command("in.case", plugin=False)
    line = [str(getattr(program, "path", program)), "-h"]
    text = subprocess.run(line, env=environment, capture_output=True, text=True).stdout
    for command, title in (
        ("pair_style", "Pair styles"),
        ("fix", "Fix styles"),
        ("compute", "Compute styles"),
        ("dump", "Dump styles"),
    ):
        names = styles_of(text, title)
        assert len(names) > 5
        found = {re.sub("/(omp|kk|gpu|intel|opt)$", "", name) for name in names if styles.GRANULAR[engine].search(name)}
        assert {name for name in found if name.islower() or "VTK" in name} <= set(styles.STYLES[engine][command])
        if (engine, command) == ("liggghts", "pair_style"):
            assert set(names) <= {*styles.OTHER_PAIRS, *found}
    if engine == "lammps":
        return
    kinds = {
        "Normal": "model",
        "Tangential": "tangential",
        "Cohesion": "cohesion",
        "Rolling": "rolling_friction",
        "Surface": "surface",
    }
    documented = {path.name.split(".")[0].split("_", 1)[1] for path in DOCUMENTATION.glob("gran_*.html")}
    for title, kind in kinds.items():
        names = styles_of(text, f"{title} models for pair gran")
        assert names
        pages = {name.removeprefix(f"{kind}_").replace("_", "/") for name in documented if name.startswith(f"{kind}_")}
        if kind == "model":
            assert {*names, *pages} <= set(styles.NORMALS[engine])
        else:
            served = {"off", "demlaws"} | set(names)
            assert set(styles.SUB_MODELS[kind]) <= served


def test_a_normal_model_of_lammps_that_is_unknown_is_named():
    """LAMMPS prints no list of its sub-models: those that it has beside ours are refused by itself."""
    for name in [*styles.NORMALS["lammps"], "other"]:
        (first, *_) = convert(f"pair_style granular\npair_coeff * * {name} 1e9 0.5 0.25 1 1 1\n", "lammps", "law.tbl").notes
        assert first.served == (name == "hertz/material")


def test_surfaces_of_triangles_are_converted():
    words = "hertz/material 1e7 0.5 0.3 tangential mindlin NULL 1 0.5 damping coeff_restitution"
    surface = f"fix s all surface/global input stl 1 1 belt.stl model * * granular {words}"
    text = f"pair_style granular\npair_coeff * * {words}\n{surface}\n"
    converted = convert(text, "lammps", "law.tbl")
    assert converted.complete
    assert converted.text.splitlines()[2] == (
        "fix s all surface/global input stl 1 1 belt.stl model * * granular demlaws/table law.tbl 1e7 0.5 0.3 "
        "tangential demlaws 1 0.5 damping coeff_restitution"
    )
    twice = convert(text.replace(surface, f"{surface} model 1 1 granular {words}"), "lammps", "law.tbl")
    assert [note.line for note in twice.notes if not note.served] == [3]


def test_includes_of_includes_are_looked_at(tmp_path):
    (tmp_path / "one.in").write_text("include two.in\n")
    (tmp_path / "two.in").write_text("include one.in\n" + LAMMPS.splitlines()[1] + "\n")
    text = "include one.in\n" + LAMMPS.splitlines()[3] + "\n"
    assert [note.line for note in convert(text, "lammps", "law.tbl", tmp_path).notes if not note.served] == [1]
    (tmp_path / "two.in").write_text("variable E equal 1e9\nunits si\n")
    assert convert(text, "lammps", "law.tbl", tmp_path).complete
    (tmp_path / "two.in").write_text("units lj\n")
    assert not convert(text, "lammps", "law.tbl", tmp_path).complete


@pytest.mark.parametrize("engine", ["liggghts", "lammps"])
def test_units_and_numbers_of_particles(engine):
    """LAMMPS's default is lj; delete_atoms would deal new numbers."""
    line = {"liggghts": LIGGGHTS, "lammps": LAMMPS}[engine].splitlines()[3]
    text = f"create_box 1 b\n{line}\nrun 1\ndelete_atoms group g compress yes mol no\ndelete_atoms group h compress no\n"
    text += "".join(f"fix {n} all property/global {n} peratomtype 1\n" for n in styles.PROPERTIES)
    converted = convert(text, engine, "law.tbl")
    assert [note.line for note in converted.notes if not note.served] == [1] and "lj" in converted.notes[0].text
    assert converted.text.splitlines()[3:5] == ["delete_atoms group g mol no compress no", "delete_atoms group h compress no"]
    assert convert(f"units si\n{text}", engine, "law.tbl").complete


def test_properties_that_a_stiffness_model_had_not():
    text = (
        "units si\ncreate_box 1 b\n" + LIGGGHTS.splitlines()[3] + "\nfix p all property/global youngsModulus peratomtype 1e9\n"
    )
    (note,) = [note for note in convert(text, "liggghts", "law.tbl").notes if not note.served]
    assert "poissonsRatio, coefficientRestitution" in note.text


def test_settings_of_the_stock_model_behind_the_place_of_a_wall():
    wall = (
        "fix w all wall/gran model hertz tangential history primitive type 1 zplane 0 computeElasticPotential on limitForce on"
    )
    converted = convert(wall, "liggghts", "law.tbl")
    assert converted.text.endswith("zplane 0 limitForce on\n") and any("was deleted" in note.text for note in converted.notes)


# --- several materials


def several(tmp_path, engine, *materials, more="", tables=()):
    """`Converted` of an input with these materials (E, nu), by a rough table of the first; tables: of pairs of types."""
    contact = dl.Contact.between(
        *[dl.Material(60e9, 0.25)] * 2, radius1=4e-3, radius2=4e-3, roughness1=1e-6, roughness2=0.0, fractal_dimension=2.2
    )
    dl.law("pohrt-popov", contact).tabulate().save(tmp_path / "one.tbl")
    if engine == "liggghts":
        lines = ["pair_style gran model hertz tangential history"]
        for name, values in zip(styles.PROPERTIES, [*zip(*materials, strict=True), ["1 0.5"]], strict=True):
            lines.append(f"fix {name} all property/global {name} peratomtype {' '.join(map(str, values))}")
    else:
        lines = ["pair_style granular"]
        for n, (young, poisson) in enumerate(materials, 1):
            lines.append(f"pair_coeff {n} {n} hertz/material {young} 0.5 {poisson} tangential mindlin NULL 1 0.5 damping none")
    (tmp_path / "in.case").write_text("\n".join(["units si", "create_box 2 b", *lines, more]) + "\n")
    pairs = {types: tmp_path / "one.tbl" for types in tables}
    return convert_file(tmp_path / "in.case", engine, tmp_path / "one.tbl", pairs=pairs)[1]


def left(converted):
    return [note.text for note in converted.notes if not note.served]


GRANITE, STEEL = (60e9, 0.25), (210e9, 0.3)


@pytest.mark.parametrize("engine", ["liggghts", "lammps"])
def test_other_materials_than_the_tables_are_named(engine, tmp_path):
    """They would get its roughness; each pair is named with what to write."""
    assert left(several(tmp_path, engine, GRANITE, GRANITE)) == []
    notes = left(several(tmp_path, engine, GRANITE, STEEL))
    assert len(notes) == 2 and all("--table I J FILE" in note or "pair_coeff 1 2" in note for note in notes)
    assert f"{1 / (2 * (1 - 0.3**2) / 210e9):.4g} Pa" in " ".join(notes)
    given = {"more": "pair_coeff 1 2 hertz/material 90e9 0.5 0.3 tangential mindlin NULL 1 0.5 damping none"}
    tables = [(1, 2), (2, 2)]
    assert left(several(tmp_path, engine, GRANITE, STEEL, tables=tables, **(given if engine == "lammps" else {}))) == []
    words = (tmp_path / "in.case.demlaws").read_text()
    assert ("pairtable 1 2 one.tbl pairtable 2 2 one.tbl" in words) == (engine == "liggghts")


def test_a_law_without_a_length_serves_all_materials(tmp_path):
    (tmp_path / "in.case").write_text(
        f"units si\n{LAMMPS}pair_coeff 2 2 hertz/material 2e9 0.8 0.25 tangential mindlin NULL 1.0 0.4\n"
    )
    assert convert_file(tmp_path / "in.case", "lammps", table_in(tmp_path))[1].complete


def test_moduli_by_variables(tmp_path):
    more = "variable E equal 210e9\nvariable F equal ${E}*2\n"
    found = left(several(tmp_path, "liggghts", ("${E}", 0.3), ("${F}", 0.3), more=more))
    assert [("unknown" in note) for note in found] == [True, True]  # 1 1 is the known one: the table is taken for it
    assert left(several(tmp_path, "liggghts", ("${E}", 0.3), ("${E}", 0.3), more=more)) == []


def test_tables_of_pairs_in_lammps(tmp_path):
    """A line for several pairs gets further lines; one for two types gets their table; types that would be mixed are named."""
    text = f"{LAMMPS.splitlines()[0]}\n{LAMMPS.splitlines()[1].replace('1 *', '1* *2')}\n"
    lines = convert(text, "lammps", "a.tbl", pairs={(2, 1): Table("b.tbl"), (3, 3): Table("c.tbl")}).text.splitlines()
    assert [line.split()[:5] for line in lines[1:]] == [
        ["pair_coeff", "1*", "*2", "demlaws/table", "a.tbl"],
        ["pair_coeff", "1", "2", "demlaws/table", "b.tbl"],
    ]
    (note,) = left(several(tmp_path, "lammps", GRANITE, GRANITE, tables=[(1, 2)]))
    assert note.endswith(
        "add `pair_coeff 1 2 demlaws/table one.tbl 60000000000.0 0.5 0.25 tangential demlaws 1 0.5 damping none`"
    )
    (note,) = left(
        convert(f"{LAMMPS}pair_coeff 3 3 hertz/material 1e9 0.8 0.25 tangential linear_nohistory 1 0.5\n", "lammps", "a.tbl")
    )
    assert "history values" in note


@pytest.mark.parametrize(
    ("given", "named"),
    [
        (["--table", "1", "2", "a.tbl"], "--table FILE is missing"),
        (["--table", "a.tbl", "--table", "b.tbl"], "another table"),
        (["--table", "a.tbl", "--table", "2", "1", "a.tbl", "--table", "1", "2", "b.tbl"], "another table"),
        (["--table", "1", "a.tbl"], "two particle types"),
        (["--table", "x", "2", "a.tbl"], "two particle types"),
    ],
)
def test_tables_that_are_given_wrongly(given, named, tmp_path, capsys):
    (tmp_path / "in.case").write_text(LAMMPS)
    assert cli.main(["lammps", "convert", str(tmp_path / "in.case"), *given]) == 2
    assert named in " ".join(capsys.readouterr().err.split())
    types = several(tmp_path, "liggghts", GRANITE, GRANITE, tables=[(1, 2)])
    assert types.complete
    with pytest.raises(DemlawsError, match="names type 3"):
        several(tmp_path, "liggghts", GRANITE, GRANITE, tables=[(1, 3)])


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
    for name in ("my law.tbl", "häärtz.tbl", "a#b.tbl", "$HOME/a.tbl", "it's.tbl"):
        with pytest.raises(DemlawsError, match="rename"):
            convert(LAMMPS, "lammps", name)
    convert(LIGGGHTS, "liggghts", "häärtz.tbl")
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
            converted = convert(script.with_hertz(path.read_text()), engine, "law.tbl")
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
