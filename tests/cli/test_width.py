"""Printed results of every command have lines of at most 100 characters."""

import argparse
import contextlib
import io
import re
from pathlib import Path

import numpy as np
import pytest

from demlaws import cli
from demlaws.cli import COMMANDS, arguments
from demlaws.files import WIDTH

ROUGH = [
    "--radius",
    "8mm",
    "8mm",
    "--modulus",
    "32GPa",
    "--roughness",
    "1.7um",
    "--fractal-dimension",
    "2.2",
    "--hardness",
    "6.27GPa",
]
PLASTIC = ["--law", "rough-plastic", "--option", "yield_pressure=1.66GPa"]
ELASTIC = ["--law", "hertz", "--young", "60GPa", "--poisson", "0.25"]
TESTS = Path(__file__).resolve().parents[1]
DATA, DUMPS = TESTS / "data", TESTS / "data" / "dumps"
SHOWN = {
    "granite": ["--test", "RFC10", "--out", "{out}"],
    "laws": ["rough-plastic"],
    "materials": ["granite"],
    "curve": [*PLASTIC, *ROUGH, "--forces", "50", "0"],
    "table": [*PLASTIC, *ROUGH, "--out", "{out}/law.tbl"],
    "regime": [*ROUGH, "--load", "20"],
    "surface": ["{map}"],
    "fit": [TESTS.parent / "docs" / "tutorials" / "contact.csv", *ROUGH, "--law", "pohrt-popov", "--law", "hertz"],
    "choose": [DATA / "ballast.toml", "--all"],
    "soften": ["--factor", "100", *PLASTIC, *ROUGH],
    "timestep": [DUMPS / "grains.txt", DUMPS / "contacts-lammps.txt", *ELASTIC],
    "contacts": [DUMPS / "grains.txt", DUMPS / "contacts-lammps.txt"],
    "liggghts": ["convert", "{out}/in.liggghts", "--table", "{out}/law.tbl"],
    "lammps": ["convert", "{out}/in.lammps", "--table", "{out}/law.tbl"],
}
"""Command → arguments of a result; `yade` and `check` print what the engines and their self-tests print."""


def test_every_command_is_shown():
    assert {*SHOWN, "yade", "check"} == {*COMMANDS}


@pytest.mark.parametrize("command", SHOWN)
def test_lines_of_results(command, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    table = ["table", *PLASTIC, *ROUGH, "--out", "law.tbl"]
    if "convert" in SHOWN[command]:
        cli.main(table)
        (tmp_path / "in.liggghts").write_text("pair_style gran model hertz tangential history rolling_friction $v\nrun 1\n")
        (tmp_path / "in.lammps").write_text(
            "pair_style granular\npair_coeff * * jkr 1e9 1 0.25 1 tangential mindlin NULL 1 1\n"
        )
    if command == "surface":
        np.save("map.npy", 1e-6 * np.random.default_rng(1).standard_normal((64, 64)))
    words = [str(word).format(out=".", map="map.npy") for word in SHOWN[command]]
    cli.main([command, *words, *(["--pixel", "1um"] if command == "surface" else [])])
    lines = capsys.readouterr().out.splitlines()
    code = ("import", "from", "law =", "#")  # of a script that `choose` prints for copying
    assert lines and [line for line in lines if len(line) > WIDTH and not line.startswith(code)] == []


def kinds(parser):
    """(command, shown kind of value, type) of every option with one."""
    formatter = parser._get_formatter()
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for sub in dict.fromkeys(action.choices.values()):
                yield from kinds(sub)
        elif action.option_strings and action.nargs != 0 and action.choices is None:
            yield parser.prog, formatter._format_args(action, formatter._get_default_metavar_for_optional(action)), action.type


def test_a_kind_of_value_has_one_name():
    shown = list(kinds(cli.build_parser()))
    names = {arguments.length: "LENGTH", arguments.force: "FORCE", arguments.pressure: "PRESSURE", arguments.plain: "NUMBER"}
    for command, name, kind in shown:
        if kind in names and name not in ("WIDTH", "SHORTEST LONGEST"):
            assert set(re.findall("[A-Z]+", name)) == {names[kind]}, command
        elif kind is not arguments.radius:
            assert not set(re.findall("[A-Z]+", name)) & set(names.values()), (command, name)
    assert len(shown) > 150


def test_json_is_offered_where_it_works():
    """The programs of `run` print to the standard output themselves."""
    for words in (["yade", "run"], ["liggghts", "run"], ["lammps", "run"], ["lammps", "check"], ["curve"]):
        with pytest.raises(SystemExit), contextlib.redirect_stdout(io.StringIO()) as out:
            cli.main([*words, "--help"])
        assert ("--json" in out.getvalue()) is (words[-1] != "run")
