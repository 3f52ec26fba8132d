"""The command line: help, results, and errors in one line without a traceback."""

import subprocess
import sys
import warnings

import pytest

from demlaws import cli
from demlaws.cli import main
from demlaws.table import Table


@pytest.fixture(autouse=True)
def restored():
    """main() shows warnings in its own way: undo that."""
    with warnings.catch_warnings():
        yield


def commands():
    (choices,) = (a.choices for a in cli.build_parser()._subparsers._group_actions)
    return choices


@pytest.mark.parametrize("name", commands())
def test_every_command_has_help(name, capsys):
    with pytest.raises(SystemExit) as end:
        main([name, "--help"])
    assert end.value.code == 0
    assert "usage: demlaws" in capsys.readouterr().out


CONTACT = ["--radius", "4e-3", "--modulus", "3e10", "--sigma", "2e-6", "--fractal-dimension", "2.2"]


def test_curve(tmp_path, capsys):
    file, picture = tmp_path / "c.csv", tmp_path / "c.png"
    options = ["--unloading", "hertz", "--forces", "20", "0", "40", "--csv", str(file), "--figure", str(picture)]
    assert main(["curve", "--law", "pohrt-popov", *CONTACT, *options]) == 0
    assert len(file.read_text().splitlines()) == 602
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert main(["curve", "--law", "hertz", *CONTACT, "--overlaps", "1e-5"]) == 0
    assert "force (N)" in capsys.readouterr().out


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
    options = ["--unloading-law", "pohrt-popov", "--unloading-sigma", "0.5e-6"]
    assert main(["table", "--law", "pohrt-popov", *CONTACT, *options, "--out", str(both), "--figure", str(picture)]) == 0
    assert "unloading along 'pohrt-popov'" in capsys.readouterr().out
    assert picture.stat().st_size > 1000
    assert main(["table", "--law", "pohrt-popov", *smoother, "--out", str(curve)]) == 0
    options = ["--unloading", str(curve), "--out", str(again), "--max-force", "100"]
    assert main(["table", "--law", "pohrt-popov", *CONTACT, *options]) == 0
    one, other = Table.load(both), Table.load(again)
    assert one.unloading == other.unloading == "table"
    assert one.unloading_law.made_for.roughness == other.unloading_law.made_for.roughness == 0.5e-6
    path = [1e-5, 9e-6, 8e-6]
    assert one.follow(path).force == pytest.approx(other.follow(path).force, rel=1e-4)
    forces = ["--unloading", "table", "--unloading-law", "pohrt-popov", "--unloading-sigma", "0.5e-6", "--forces", "9", "0"]
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
        (["curve", "--law", "hertz", "--radius", "-1e-3", "--modulus", "1e9", "--forces", "1"], "radius = -0.001 m"),
        (["curve", "--law", "hertz", "--radius", "1e-3", "--modulus", "nan", "--forces", "1"], "modulus = nan Pa"),
        (["curve", "--law", "hertz", "--radius", "1e-3", "--forces", "1"], "--modulus missing"),
        (["curve", "--law", "pohrt-popov", *CONTACT[:-1], "3.5", "--forces", "1"], "fractal_dimension = 3.5"),
        (["curve", "--law", "hertz", "--radius", "4e-3", "--roughness", "1e-6", "--forces", "1"], "give --sigma"),
        (["table", "--law", "hertz", *CONTACT, "--unloading-roughness", "1e-6", "--out", "t"], "give --unloading-sigma"),
        (["regime", "--roughness", "1e-6"], "give --sigma"),
        (["surface", "synthetic", "--roughness", "1um", "--out", "t"], "give --sq"),
        (["liggghts", "export", "t", "--radius", "1e-3", "--roughness", "1e-6"], "give --sq"),
        (["curve", "--law", "hertz", *CONTACT, "--sigma", "1", "--forces", "1"], "exceeds the effective radius"),
        (["curve", "--law", "hertz", *CONTACT, "--forces", "-1"], "no tension"),
        (["curve", "--law", "bahrami", *CONTACT, "--forces", "1"], "hardness"),
        (["curve", "--law", "hertz", *CONTACT, "--option", "x=1", "--forces", "1"], "'x'"),
        (["curve", "--law", "hertz", *CONTACT, "--forces", "1", "--figure", "c.nonsense"], "nonsense"),
        (["table", "--law", "hertz", *CONTACT, "--rtol", "0", "--out", "t"], "rtol"),
        (["table", "--law", "hertz", *CONTACT, "--out", "/proc/nowhere/t"], "cannot write"),
        (["granite", "--test", "XX"], "unknown test 'XX'"),
        (["granite", "--test", "RFC10", "--data", "/nowhere.csv"], "cannot read points"),
        (["granite", "--data", "/nowhere.csv"], "needs --test"),
    ],
)
def test_errors_are_one_line(arguments, says, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == 2
    captured = capsys.readouterr()
    (line,) = [x for x in captured.err.splitlines() if "warning" not in x]
    assert line.startswith("demlaws: error: ")
    assert says in line


def test_module_and_version():
    result = subprocess.run([sys.executable, "-m", "demlaws", "--version"], capture_output=True, text=True, check=True)
    assert result.stdout.startswith("demlaws ")
