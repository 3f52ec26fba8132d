"""The command line: help, results, and errors in one line without a traceback."""

import json
import os
import shlex
import string
import subprocess
import sys
import warnings
from pathlib import Path

import pytest
from own_spring import POWER

from demlaws import cli
from demlaws.cli import main, option
from demlaws.law import Table
from demlaws.laws.registry import registry


@pytest.fixture(autouse=True)
def restored():
    """main() shows warnings in its own way: undo that."""
    with warnings.catch_warnings():
        yield


def commands():
    (choices,) = (a.choices for a in cli.build_parser()._subparsers._group_actions)
    return choices


CONTACT = ["--effective-radius", "4e-3", "--modulus", "3e10", "--sigma", "2e-6", "--fractal-dimension", "2.2"]


def test_curve(tmp_path, capsys):
    file, picture = tmp_path / "c.csv", tmp_path / "c.png"
    options = ["--unloading", "hertz", "--forces", "20", "0", "40", "--csv", str(file), "--figure", str(picture)]
    assert main(["curve", "--law", "pohrt-popov", *CONTACT, *options]) == 0
    assert len(file.read_text().splitlines()) == 602
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert main(["curve", "--law", "hertz", *CONTACT, "--overlaps", "1e-5"]) == 0
    assert "force (N)" in capsys.readouterr().out


def test_soften(capsys):
    """What to give an engine: the softened modulus, roughness and yield pressure."""
    options = ["--law", "rough-plastic", "--option", "yield_pressure=1.6GPa", *CONTACT]
    assert main(["soften", "--factor", "8", *options]) == 0
    said = capsys.readouterr().out
    rows = ("radius [mm]", 4, 4), ("modulus [GPa]", 30, 3.75), ("sigma [µm]", 2, 8), ("yield_pressure [GPa]", 1.6, 0.4)
    for name, before, after in rows:
        line = next(line for line in said.splitlines() if line.startswith(name))
        assert [float(v) for v in line.split()[-2:]] == pytest.approx([before, after])
    assert "e-06" not in said and "e+09" not in said


def test_table_with_an_unloading_curve(tmp_path, capsys):
    """By the file of that curve's table; both in one file."""
    curve, both, picture = (tmp_path / name for name in ("curve.tbl", "both.tbl", "both.png"))
    assert main(["table", "--law", "hertz", *CONTACT, "--out", str(curve)]) == 0
    options = ["--unloading", str(curve), "--out", str(both), "--figure", str(picture)]
    assert main(["table", "--law", "pohrt-popov", *CONTACT, *options]) == 0
    out = capsys.readouterr().out
    assert "unloading along 'hertz'" in out and "largest relative error" in out
    assert picture.stat().st_size > 1000
    one = Table.load(both)
    assert one.unloading == "table" and one.unloading_law.name == "hertz"
    assert main(["curve", "--law", "pohrt-popov", *CONTACT, "--unloading", str(curve), "--forces", "9", "0"]) == 0


def test_a_table_is_a_law(tmp_path, capsys):
    """As in Python; its contact is the default, and what is given replaces a part of it."""
    file = tmp_path / "granite.tbl"
    assert main(["table", "--law", "pohrt-popov", *CONTACT, "--out", str(file)]) == 0
    law, more = Table.load(file), ["--forces", "9", "0", "--json"]
    capsys.readouterr()
    for contact, changed in (([], {}), (["--effective-radius", "5mm"], {"radius": 5e-3})):
        assert main(["curve", "--law", str(file), *contact, *more]) == 0
        values = json.loads(capsys.readouterr().out)
        bound = law.bound_to(law.contact.with_values(**changed))
        assert values["overlap"][200] == pytest.approx(bound.overlap(9.0), rel=1e-9)
    assert main(["curve", "--law", str(file), *more, "--unloading", "hertz"]) == 0
    assert json.loads(capsys.readouterr().out)["unloading"] == "hertz"
    assert main(["curve", "--law", str(file), *more, "--option", "loading=rms"]) == 2
    assert main(["curve", "--law", str(tmp_path / "none.tbl"), *more]) == 2
    assert "none.tbl" in capsys.readouterr().err


def test_granite(tmp_path, capsys):
    assert main(["granite", "--test", "SS(12-18)", "--law", "pohrt-popov", "--out", str(tmp_path)]) == 0
    out = capsys.readouterr().out
    assert "17.8" in out
    names = {file.name for file in tmp_path.iterdir()}
    assert {"force-ss-12-18.png", "ss-12-18-pohrt-popov.csv", "summary.csv"} <= names
    assert not [name for name in names if name.startswith(".")]  # no temporary file left


FC5 = "--effective-radius 0.33mm --young 60.6e9 --poisson 0.25 --hardness 6.266e9 --sigma 5.04um"
ALUMINIUM = "--radius 3.175mm inf --hardness 0.24e9 --young 430e9 75.2e9 --poisson 0.17 0.34"
REFUSED = [line for line in (Path(__file__).parents[1] / "data" / "refused.txt").read_text().splitlines() if line[0] != "#"]


@pytest.mark.parametrize("line", REFUSED)
def test_errors_are_one_line(line, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "map.csv").write_text("1,2,3,4\n5,6,7,8\n1,2,3,4\n1,2,3,4\n")
    names = {"CONTACT": " ".join(CONTACT), "FC5": FC5, "ALUMINIUM": ALUMINIUM, "MAP": "map.csv --pixel 1um"}
    assert main(shlex.split(string.Template(line).substitute(names))) == 2
    (text,) = [x for x in capsys.readouterr().err.splitlines() if "warning" not in x]
    assert text.startswith("demlaws: error: ")


def test_the_laws_are_listed(capsys):
    assert main(["laws"]) == 0
    out = capsys.readouterr().out
    for name, definition in registry().items():
        assert any(line.startswith(f"{name} ") and definition.description in line for line in out.splitlines())


def test_quantities_have_units(capsys):
    for contact, overlaps in (
        (["--effective-radius", "4mm", "--modulus", "30GPa", "--sigma", "2.4um"], ["1um", "0.2um"]),
        (["--effective-radius", "4e-3", "--modulus", "3e10", "--sigma", "2.4e-6"], ["1e-6", "2e-7"]),
    ):
        assert main(["curve", "--law", "rms", *contact, "--overlaps", *overlaps, "--steps", "3"]) == 0
    out = capsys.readouterr().out
    assert out[: len(out) // 2] == out[len(out) // 2 :]
    assert option("yield_pressure=1.66GPa") == ("yield_pressure", "1.66GPa")  # the law reads it
    assert option("loading=rms") == ("loading", "rms")


FULL_OR_ASCII = """
import os, sys
sys.argv = "demlaws curve --law hertz --effective-radius 4mm --modulus 30GPa --overlaps 1um --steps 2".split()
from demlaws.cli import main
sys.exit(main())
"""


def run_alone(code, **more):
    environment = {**os.environ, **more.pop("env", {})}
    return subprocess.run([sys.executable, "-c", code], stderr=subprocess.PIPE, text=True, env=environment, **more)


def test_output_that_cannot_be_written_is_one_line():
    with open("/dev/full", "w") as full:
        result = run_alone(FULL_OR_ASCII, stdout=full)
    assert result.returncode == 2
    assert "Traceback" not in result.stderr
    result = run_alone(FULL_OR_ASCII, stdout=subprocess.PIPE, env={"PYTHONIOENCODING": "ascii"})
    assert result.returncode == 0
    assert "overlap (?m)" in result.stdout


def test_without_machine_code_the_output_is_the_same():
    """NUMBA_DISABLE_JIT was refused."""
    compiled, stepped = (
        run_alone(FULL_OR_ASCII, stdout=subprocess.PIPE, env={"NUMBA_DISABLE_JIT": setting}) for setting in "01"
    )
    assert (stepped.returncode, stepped.stderr) == (0, "")
    assert stepped.stdout == compiled.stdout and stepped.stdout.count("\n") > 3


@pytest.mark.parametrize("engine", ["liggghts", "lammps"])
def test_exports_take_units(engine, tmp_path):
    """A case written with units is the case written in SI."""
    grains = [["0.004", "1.7e-6", "60.6e9", "2650", "10"], ["4mm", "1.7um", "60.6GPa", "2650 kg/m³", "10N"]]
    texts = []
    for number, (radius, sq, young, density, load) in enumerate(grains):
        case = tmp_path / str(number)
        words = ["--radius", radius, "--roughness", sq, "--young", young, "--density", density, "--max-force", load]
        assert cli.main([engine, "export", str(case), *words, "--fractal-dimension", "2.22", "--count", "20"]) == 0
        texts.append(
            {path.name: path.read_text() for path in sorted(case.iterdir()) if path.suffix != ".tbl" and path.is_file()}
        )
        forces = Table.load(next(case.glob("*.tbl"))).force(1e-6)
        texts[-1]["force"] = float(f"{forces:.10g}")  # 1.7 × 1e-6 and 1.7e-6 differ in the last bit
    assert texts[0] == texts[1] and len(texts[0]) > 2


def test_radii_of_both_bodies(capsys):
    radii = [["--radius", "8mm", "8mm"], ["--radius", "4mm", "inf"], ["--radius", "4mm", "flat"], ["--effective-radius", "4mm"]]
    for radius in radii:
        words = ["curve", "--law", "rms", *radius, "--modulus", "30GPa", "--overlaps", "1um"]
        assert main([*words, "--roughness", "3um", "4um"]) == 0
        assert "R = 4 mm, E* = 30 GPa, σ = 5 µm" in capsys.readouterr().out


HERTZ = ["curve", "--law", "hertz", "--radius", "8mm", "8mm", "--modulus", "30GPa", "--overlaps", "1um", "--steps", "2"]


def test_csv_on_standard_output(capsys):
    assert main([*HERTZ, "--csv", "-"]) == 0
    captured = capsys.readouterr()
    assert captured.out.startswith("overlap (m),force (N)") and len(captured.out.splitlines()) == 4
    assert "contact: R = 4 mm" in captured.err


TABLE = ["table", "--law", "hertz", *CONTACT, "--rtol", "1e-2", "--out"]
SCRIPT = "# a script of demlaws for YADE, one of ours\nfrom demlaws.yade import engines\n"


@pytest.mark.parametrize(
    ("words", "name"),
    [([*HERTZ, "--csv"], "a.csv"), *[([*HERTZ, "--figure"], f"a.{e}") for e in ("png", "svg", "pdf")], (TABLE, "a")],
)
def test_a_file_is_replaced_only_by_the_command_that_wrote_it(words, name, tmp_path, capsys):
    file = tmp_path / name
    for content in (SCRIPT, f"# {SCRIPT * 100}"):
        file.write_text(content)
        assert main([*words, str(file)]) == 2
        assert "--overwrite" in capsys.readouterr().err and file.read_text() == content
    file.write_bytes(b"")
    assert main([*words, str(file)]) == 0  # an empty file is nobody's
    assert len(file.read_bytes()) > 100
    assert main([*words, str(file)]) == 0  # the same kind
    file.write_text(SCRIPT)
    assert main([*words, str(file), "--overwrite"]) == 0 and file.read_bytes()[:30] != SCRIPT.encode()[:30]


@pytest.mark.parametrize(
    ("name", "head"),
    [("a.png", b"\x89PNG\r\n\x1a\n"), ("a.svg", b"<?xml version='1.0'?><dc:title>a</dc:title>"), ("a.pdf", b"%PDF-1.4\n")],
)
def test_a_picture_of_another_program_is_replaced_only_by_overwrite(name, head, tmp_path):
    """The test of files that only their writer replaces has files of demlaws and text."""
    file = tmp_path / name
    file.write_bytes(head + b"another program")
    assert main([*HERTZ, "--figure", str(file)]) == 2 and file.read_bytes() == head + b"another program"
    file.write_bytes(b"demlaws, a text: tEXtSoftware\0demlaws <dc:title>demlaws</dc:title> /Creator (demlaws)")
    assert main([*HERTZ, "--figure", str(file)]) == 2


def test_two_outputs_of_one_name_are_refused(tmp_path, monkeypatch, capsys):
    """The picture replaced the rows that the same command had written."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "link").symlink_to(tmp_path)
    curve = ["curve", "--law", "hertz", "--radius", "4mm", "4mm", "--material", "granite", "--overlaps", "1e-6"]
    for csv, figure in (("a.png", "a.png"), ("link/a.png", "a"), ("b.svg", str(tmp_path / "b.svg"))):
        assert main([*curve, "--csv", csv, "--figure", figure]) == 2
        assert "two outputs have the name" in capsys.readouterr().err
    assert not list(tmp_path.glob("*.*"))


def test_names_of_pictures(tmp_path, monkeypatch, capsys):
    """A wrong ending was refused when the rows were written; without one, a stranger's PNG was replaced."""
    pytest.importorskip("matplotlib")
    monkeypatch.chdir(tmp_path)
    curve = ["curve", "--law", "hertz", "--radius", "4mm", "4mm", "--material", "granite", "--overlaps", "1e-6"]
    assert main([*curve, "--csv", "a.csv", "--figure", "a.txt"]) == 2
    assert "a picture must end in .png" in capsys.readouterr().err and not (tmp_path / "a.csv").exists()
    (tmp_path / "mine.png").write_bytes(b"\x89PNG of another program")
    assert main([*curve, "--figure", "mine"]) == 2
    assert "--overwrite" in capsys.readouterr().err and (tmp_path / "mine.png").read_bytes().endswith(b"another program")


def test_a_curve_is_not_replaced_by_a_table_nor_a_map_by_a_map(tmp_path):
    file, heights = tmp_path / "a.csv", tmp_path / "map.asc"
    assert main([*HERTZ, "--csv", str(file)]) == 0 and main([*TABLE, str(file)]) == 2
    generate = ["surface", "synthetic", "--size", "16", "--out", str(heights)]
    assert main(generate) == 0 and main(generate) == 2  # nothing in a map says who measured it
    assert main([*generate, "--overwrite"]) == 0


def test_the_tables_of_a_scene_replace_only_tables(tmp_path, capsys):
    scene, out = tmp_path / "scene.toml", tmp_path / "law.tbl"
    scene.write_text("radii = 1e-3\nforce = [1, 2]\n[material]\nyoung = 6e10\npoisson = 0.2\n")
    out.write_text(SCRIPT)
    assert main(["choose", str(scene), "--out", str(out)]) == 2
    assert "--overwrite" in capsys.readouterr().err and out.read_text() == SCRIPT


@pytest.mark.parametrize("engine", ["liggghts", "lammps"])
def test_an_input_of_somebody_else_is_not_replaced(engine, tmp_path, capsys):
    script = tmp_path / "in.case"
    words = [engine, "export", str(tmp_path), "--law", "hertz", "--radius", "4mm", "--count", "20"]
    assert main(words) == 0 and main(words) == 0
    script.write_text("pair_style granular")
    assert main(words) == 2 and "in.case exists" in capsys.readouterr().err
    assert script.read_text() == "pair_style granular"


@pytest.mark.parametrize(
    ("words", "key"),
    [
        (["laws"], "laws"),
        (["laws", "rough-plastic"], "options"),
        (["regime", *CONTACT, "--hardness", "6GPa"], "transition_force"),
        (["soften", "--factor", "10", "--law", "hertz", *CONTACT], "softened"),
        (["table", "--law", "hertz", *CONTACT, "--rtol", "1e-2", "--out", "t.tbl"], "force_error"),
        (["surface", "synthetic", "--size", "32", "--out", "map.asc"], "sq"),
    ],
)
def test_results_as_json(words, key, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main([*words, "--json"]) == 0
    assert key in json.loads(capsys.readouterr().out)


# --- user-defined laws: --law-file FILE.py of every command, laws --check

RADIUS = ["--radius", "4mm", "4mm", "--modulus", "30GPa"]


@pytest.fixture
def file(tmp_path):
    (tmp_path / "my_laws.py").write_text(POWER)
    return str(tmp_path / "my_laws.py")


def demlaws(*arguments):
    """In a process of its own: a file of laws stays loaded."""
    return subprocess.run([sys.executable, "-m", "demlaws", *arguments], capture_output=True, text=True, timeout=600)


def test_a_file_of_laws_before_and_after_the_command(file, tmp_path):
    done = demlaws("--law-file", file, "laws")
    assert done.returncode == 0 and "power            power of the overlap" in done.stdout, done.stderr
    table = tmp_path / "power.tbl"
    done = demlaws("table", f"--law-file={file}", "--law", "power", *RADIUS, "--option", "factor=2e9", "--out", str(table))
    assert done.returncode == 0 and "this table is valid for this contact only" in done.stdout, done.stderr
    assert "law: power" in table.read_text()


@pytest.mark.slow
def test_the_check_of_one_law(file):
    done = demlaws("laws", "power", "--law-file", file, "--check")
    assert done.returncode == 0 and "power: all checks passed" in done.stdout, done.stderr


def test_a_script_of_yade_loads_its_laws_itself(file, tmp_path):
    (tmp_path / "scene.py").write_text("")
    done = demlaws("yade", "run", "--law-file", file, "-x", str(tmp_path / "scene.py"))
    assert done.returncode == 2 and f"dl.load_laws({file!r})" in done.stderr and done.stderr.count("\n") == 1, done.stderr


def test_a_file_that_raises_is_one_line(tmp_path):
    file = tmp_path / "my_laws.py"
    file.write_text("raise ValueError('on purpose')")
    done = demlaws("laws", "--law-file", str(file))
    assert done.returncode == 2 and done.stderr.count("\n") == 1 and str(file) in done.stderr, done.stderr


def test_a_missing_folder_is_named_and_not_made(tmp_path, capsys):
    """`--out` made all folders of a mistyped path."""
    table = ["table", "--law", "hertz", "--radius", "4mm", "4mm", "--material", "granite", "--out"]
    assert main([*table, str(tmp_path / "none" / "deep" / "a.tbl")]) == 2
    assert f"the folder {tmp_path / 'none' / 'deep'} does not exist" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
