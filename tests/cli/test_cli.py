"""The command line: help, results, and errors in one line without a traceback."""

import inspect
import json
import os
import subprocess
import sys
import threading
import warnings

import pytest

from demlaws import cli
from demlaws.cli import main, option
from demlaws.core import notice
from demlaws.errors import DemlawsError
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


CONTACT = ["--effective-radius", "4e-3", "--modulus", "3e10", "--combined-roughness", "2e-6", "--fractal-dimension", "2.2"]


def test_curve(tmp_path, capsys):
    file, picture = tmp_path / "c.csv", tmp_path / "c.png"
    options = ["--unloading", "hertz", "--forces", "20", "0", "40", "--csv", str(file), "--figure", str(picture)]
    assert main(["curve", "--law", "pohrt-popov", *CONTACT, *options]) == 0
    assert len(file.read_text().splitlines()) == 602
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert main(["curve", "--law", "hertz", *CONTACT, "--overlaps", "1e-5"]) == 0
    assert "force (N)" in capsys.readouterr().out


def test_soften(capsys):
    """What to give an engine: the softened modulus, roughness and yield pressure, and how far E alone is off."""
    options = ["--law", "rough-plastic", "--option", "yield_pressure=1.6GPa", *CONTACT, "--load", "10"]
    assert main(["soften", "--factor", "8", *options]) == 0
    said = capsys.readouterr().out
    for name, before, after in (("modulus", 3e10, 3.75e9), ("roughness", 2e-6, 8e-6), ("yield_pressure", 1.6e9, 4e8)):
        line = next(line for line in said.splitlines() if line.startswith(name))
        assert [float(v) for v in line.split()[-2:]] == pytest.approx([before, after])
    assert "% with E alone" in said
    assert main(["soften", "--factor", "0", *options]) == 2
    assert "factor" in capsys.readouterr().err


def test_table(tmp_path, capsys):
    file, picture = tmp_path / "t.tbl", tmp_path / "t.png"
    assert main(["table", "--law", "rms", *CONTACT, "--rtol", "1e-4", "--out", str(file), "--figure", str(picture)]) == 0
    assert "largest relative error" in capsys.readouterr().out
    assert Table.load(file).force_error <= 1e-4
    assert picture.stat().st_size > 1000


def test_table_with_an_unloading_curve(tmp_path, capsys):
    """By the name of a law, then the file of that law's own table; both in one file."""
    both, curve, again, picture = (tmp_path / name for name in ("both.tbl", "curve.tbl", "again.tbl", "both.png"))
    smoother = [*CONTACT[:-3], "0.5e-6", *CONTACT[-2:]]
    options = ["--unloading-law", "pohrt-popov", "--unloading-roughness", "0.5e-6"]
    assert main(["table", "--law", "pohrt-popov", *CONTACT, *options, "--out", str(both), "--figure", str(picture)]) == 0
    assert "unloading along 'pohrt-popov'" in capsys.readouterr().out
    assert picture.stat().st_size > 1000
    assert main(["table", "--law", "pohrt-popov", *smoother, "--out", str(curve)]) == 0
    options = ["--unloading", str(curve), "--out", str(again), "--max-force", "100"]
    assert main(["table", "--law", "pohrt-popov", *CONTACT, *options]) == 0
    one, other = Table.load(both), Table.load(again)
    assert one.unloading == other.unloading == "table"
    assert one.unloading_law.curve.made_for.roughness == other.unloading_law.curve.made_for.roughness == 0.5e-6
    path = [1e-5, 9e-6, 8e-6]
    assert one.follow(path).force == pytest.approx(other.follow(path).force, rel=1e-4)
    forces = ["--unloading", "table", "--unloading-law", "pohrt-popov", "--unloading-roughness", "0.5e-6", "--forces", "9", "0"]
    assert main(["curve", "--law", "pohrt-popov", *CONTACT, *forces]) == 0
    assert main(["curve", "--law", "pohrt-popov", *CONTACT, "--unloading-radius", "1e-3", "--forces", "9"]) == 2
    assert "name that law" in capsys.readouterr().err


def test_granite(tmp_path, capsys):
    assert main(["granite", "--test", "SS(12-18)", "--law", "pohrt-popov", "--out", str(tmp_path)]) == 0
    out = capsys.readouterr().out
    assert "17.8" in out
    names = {file.name for file in tmp_path.iterdir()}
    assert {"force-ss-12-18.png", "unloading-ss-12-18.png", "ss-12-18-pohrt-popov.csv", "summary.csv"} <= names
    assert not [name for name in names if name.startswith(".")]  # no temporary file left


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["curve", "--law", "nonsense", *CONTACT, "--forces", "1"], "unknown law 'nonsense'"),
        (["curve", "--law", "hertz", "--effective-radius", "-1e-3", "--modulus", "1e9", "--forces", "1"], "radius = -0.001 m"),
        (["curve", "--law", "hertz", "--effective-radius", "1e-3", "--modulus", "nan", "--forces", "1"], "modulus = nan Pa"),
        (["curve", "--law", "hertz", "--effective-radius", "1e-3", "--forces", "1"], "(or --modulus) missing"),
        (["curve", "--law", "pohrt-popov", *CONTACT[:-1], "3.5", "--forces", "1"], "fractal_dimension = 3.5"),
        (["curve", "--law", "hertz", *CONTACT, "--combined-roughness", "1", "--forces", "1"], "roughness = 1 m"),
        (["curve", "--law", "hertz", *CONTACT, "--forces", "-1"], "no tension"),
        (["curve", "--law", "bahrami", *CONTACT, "--forces", "1"], "hardness"),
        (["curve", "--law", "hertz", *CONTACT, "--option", "x=1", "--forces", "1"], "'x'"),
        (["curve", "--law", "hertz", *CONTACT, "--forces", "1", "--figure", "c.nonsense"], "nonsense"),
        (["table", "--law", "hertz", *CONTACT, "--rtol", "0", "--out", "t"], "rtol"),
        (["table", "--law", "hertz", *CONTACT, "--out", "/proc/nowhere/t"], "cannot write"),
        (["granite", "--test", "XX"], "unknown test 'XX'"),
        (["granite", "--test", "RFC10", "--data", "/nowhere.csv"], "cannot read points"),
        (["granite", "--data", "/nowhere.csv"], "say which test"),
    ],
)
def test_errors_are_one_line(arguments, says, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == 2
    captured = capsys.readouterr()
    (line,) = [x for x in captured.err.splitlines() if "warning" not in x]
    assert line.startswith("demlaws: error: ")
    assert says in line


@pytest.mark.parametrize("arguments", [["curve", "--law", "?"], ["fit", "--law", "?"], ["laws"]])
def test_the_laws_are_listed(arguments, capsys):
    """Before: `--law ?`, which the help names, was an unknown law."""
    try:
        assert main(arguments) == 0
    except SystemExit as end:
        assert end.code == 0
    out = capsys.readouterr().out
    for name, definition in registry().items():
        assert any(line.startswith(f"{name} ") and definition.description in line for line in out.splitlines())


@pytest.mark.parametrize("name", registry())
def test_options_of_a_law_are_listed(name, capsys):
    """Each option of a law's `prepare` with unit, range and default, and an unknown one is told of them."""
    definition = registry()[name]
    taken = inspect.signature(definition.prepare).parameters.values()
    named = [p.name for p in taken if p.kind is not inspect.Parameter.VAR_KEYWORD][1:]
    assert list(definition.options) == named
    assert main(["laws", name]) == 0
    out = capsys.readouterr().out
    for one in named:
        assert f"    {one}" in out
        assert definition.options[one].values in out
    if name != "rough-plastic":
        with pytest.raises(DemlawsError, match=", ".join(named) or "it has no options"):
            definition.shape(None, nonsense=1)


def test_quantities_have_units(capsys):
    """Before: of a contact's arguments only some of `surface` and `regime` took a unit."""
    for contact, overlaps in (
        (["--effective-radius", "4mm", "--modulus", "30GPa", "--combined-roughness", "2.4um"], ["1um", "0.2um"]),
        (["--effective-radius", "4e-3", "--modulus", "3e10", "--combined-roughness", "2.4e-6"], ["1e-6", "2e-7"]),
    ):
        assert main(["curve", "--law", "rms", *contact, "--overlaps", *overlaps, "--steps", "3"]) == 0
    out = capsys.readouterr().out
    assert out[: len(out) // 2] == out[len(out) // 2 :]
    assert option("yield_pressure=1.66GPa") == ("yield_pressure", 1.66e9)
    assert option("loading=rms") == ("loading", "rms")
    with pytest.raises(SystemExit):
        main(["curve", "--law", "rms", "--radius", "4parsec", "--overlaps", "1"])
    (line,) = capsys.readouterr().err.splitlines()
    assert "--radius: a radius must be a number in m, or with one of the units m, cm, mm, inch" in line


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
    """Before: OSError at the end of the process, and UnicodeEncodeError at the first µ."""
    with open("/dev/full", "w") as full:
        result = run_alone(FULL_OR_ASCII, stdout=full)
    assert result.returncode == 2
    assert [x for x in result.stderr.splitlines() if "compiling" not in x] == [
        "demlaws: error: output: No space left on device"
    ]
    result = run_alone(FULL_OR_ASCII, stdout=subprocess.PIPE, env={"PYTHONIOENCODING": "ascii"})
    assert result.returncode == 0
    assert "overlap (?m)" in result.stdout


def test_without_machine_code_there_is_one_clear_error():
    result = run_alone(FULL_OR_ASCII, stdout=subprocess.PIPE, env={"NUMBA_DISABLE_JIT": "1"})
    assert result.returncode == 2
    (line,) = result.stderr.splitlines()
    assert line.startswith("demlaws: error: NUMBA_DISABLE_JIT is set")


def test_a_compilation_that_takes_long_says_so(capsys, monkeypatch):
    told = threading.Event()
    monkeypatch.setattr(notice, "say", told.set)
    monkeypatch.setattr(notice, "timers", [])  # loops of other tests that could not be compiled have left theirs
    notice.begin()
    notice.end()
    assert not notice.timers
    notice.begin()
    assert told.wait(60)
    assert notice.say is None  # once in a process
    notice.end()


def test_module_and_version():
    result = subprocess.run([sys.executable, "-m", "demlaws", "--version"], capture_output=True, text=True, check=True)
    assert result.stdout.startswith("demlaws ")


@pytest.mark.parametrize("engine", ["liggghts", "lammps"])
def test_exports_take_units(engine, tmp_path):
    """A case written with units is the case written in SI."""
    grains = [["0.004", "1.7e-6", "60.6e9", "2650", "10"], ["4mm", "1.7um", "60.6GPa", "2650 kg/m³", "10N"]]
    texts = []
    for number, (radius, sq, young, density, load) in enumerate(grains):
        case = tmp_path / str(number)
        words = ["--radius", radius, "--roughness", sq, "--young", young, "--density", density, "--load", load]
        assert cli.main([engine, "export", str(case), *words, "--fractal-dimension", "2.22", "--count", "20"]) == 0
        texts.append(
            {path.name: path.read_text() for path in sorted(case.iterdir()) if path.suffix != ".tbl" and path.is_file()}
        )
        forces = Table.load(next(case.glob("*.tbl"))).force(1e-6)
        texts[-1]["force"] = float(f"{forces:.10g}")  # 1.7 × 1e-6 and 1.7e-6 differ in the last bit
    assert texts[0] == texts[1] and len(texts[0]) > 2


def test_one_radius_is_that_of_two_equal_spheres(capsys):
    """Before: --radius was the effective radius in four commands and a sphere's in two."""
    radii = [["--radius", "8mm"], ["--radius", "8mm", "8mm"], ["--radius", "4mm", "inf"], ["--effective-radius", "4mm"]]
    for radius in radii:
        words = ["curve", "--law", "rms", *radius, "--modulus", "30GPa", "--overlaps", "1um", "--json"]
        assert main([*words, "--roughness", "3um", "4um"]) == 0
        contact = json.loads(capsys.readouterr().out)["contact"]
        assert contact["radius"] == pytest.approx(4e-3) and contact["roughness"] == pytest.approx(5e-6)
    assert main(["curve", "--law", "hertz", *radii[0], *radii[3], "--modulus", "1e9", "--overlaps", "1um"]) == 2
    assert "give either --radius or --effective-radius" in capsys.readouterr().err
    assert main(["curve", "--law", "hertz", "--radius", "1mm", "1mm", "1mm", "--modulus", "1e9", "--overlaps", "1um"]) == 2
    assert "--radius has 3 values" in capsys.readouterr().err


HERTZ = ["curve", "--law", "hertz", "--radius", "8mm", "--modulus", "30GPa", "--overlaps", "1um", "--steps", "2"]


def test_csv_on_standard_output(capsys):
    assert main([*HERTZ, "--csv", "-"]) == 0
    captured = capsys.readouterr()
    assert captured.out.startswith("overlap (m),force (N)") and len(captured.out.splitlines()) == 4
    assert "contact: R = 4 mm" in captured.err
    assert main([*HERTZ, "--csv", "-", "--json"]) == 2
    assert "without --json" in capsys.readouterr().err
    assert main([*HERTZ, "--figure", "-"]) == 2


def test_files_are_overwritten_only_if_this_command_wrote_them(tmp_path, capsys):
    for flag, name in (("--csv", "a.csv"), ("--figure", "a.png")):
        file = tmp_path / name
        for content in (b"notes of another program", b""):
            file.write_bytes(content)
            assert main([*HERTZ, flag, str(file)]) == (2 if content else 0)
            assert ("exists and was not written by this command" in capsys.readouterr().err) == bool(content)
        first = file.read_bytes()
        assert main([*HERTZ, flag, str(file)]) == 0  # the same kind
        file.write_bytes(b"notes")
        assert main([*HERTZ, flag, str(file), "--force"]) == 0 and file.read_bytes() == first
    table = tmp_path / "a.csv"
    assert main(["table", "--law", "hertz", *CONTACT, "--rtol", "1e-2", "--out", str(table)]) == 2  # a curve, not a table


@pytest.mark.parametrize(
    ("words", "key"),
    [
        (["laws"], "laws"),
        (["laws", "rough-plastic"], "options"),
        (["regime", *CONTACT, "--hardness", "6GPa"], "transition_load"),
        (["soften", "--factor", "10", "--law", "hertz", *CONTACT], "softened"),
        (["table", "--law", "hertz", *CONTACT, "--rtol", "1e-2", "--out", "t.tbl"], "force_error"),
        (["surface", "synthetic", "--size", "32", "--out", "map.asc"], "sq"),
    ],
)
def test_results_as_json(words, key, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main([*words, "--json"]) == 0
    assert key in json.loads(capsys.readouterr().out)


def test_similar_options_and_commands_are_suggested(capsys):
    for words, suggestion in ((["curve", "--modulos", "1"], "--modulus"), (["curv"], "curve"), (["curve", "--sigma", "1"], "")):
        with pytest.raises(SystemExit):
            main([*HERTZ, *words[1:]] if words[0] == "curve" else words)
        assert (f"did you mean {suggestion}" if suggestion else "unrecognized") in capsys.readouterr().err


def test_warnings_show_no_place_in_our_files(tmp_path, capsys):
    (tmp_path / "t.tbl").write_text("notes")
    arguments = ["table", "--law", "hertz", *CONTACT, "--rtol", "1e-2", "--out", str(tmp_path / "t.tbl"), "--force"]
    assert main(arguments) == 0
    warned = [line for line in capsys.readouterr().err.splitlines() if "t.tbl" in line]
    assert warned and all(line.startswith("demlaws: warning: ") for line in warned)
