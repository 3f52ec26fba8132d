"""What lammps_source.py reports; `make lammps-source` builds LAMMPS."""

import importlib.util
import os
import sys
from pathlib import Path

import pytest


@pytest.fixture
def script(monkeypatch):
    spec = importlib.util.spec_from_file_location("machines_lammps", Path(__file__).with_name("lammps_source.py"))
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def last_line(capsys):
    return capsys.readouterr().out.strip().splitlines()[-1]


def test_without_an_archive_it_is_not_run(script, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(script, "ARCHIVE", f"file://{tmp_path}/nothing")
    monkeypatch.setattr(script.shutil, "which", lambda name: name)
    assert script.main(["--folder", str(tmp_path / "kept")]) == 75
    assert "NOT RUN: the lists of" in last_line(capsys)


def test_without_tools_it_is_not_run(script, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(script.shutil, "which", lambda name: None if name == "cmake" else name)
    assert script.main(["--folder", str(tmp_path)]) == 75
    assert "no cmake here" in last_line(capsys)


def test_a_build_that_fails_or_takes_too_long_fails(script, tmp_path, monkeypatch, capsys):
    (tmp_path / "unpacked").write_text("nowhere")
    (tmp_path / "tree" / "cmake").mkdir(parents=True)
    (tmp_path / "tree" / "cmake" / "CMakeLists.txt").touch()
    (tmp_path / "tree" / "src").mkdir()
    cmake = tmp_path / "bin" / "cmake"
    cmake.parent.mkdir()
    cmake.write_text("#!/bin/sh\nexit 1\n")
    cmake.chmod(0o755)
    monkeypatch.setenv("PATH", str(cmake.parent), prepend=os.pathsep)
    monkeypatch.setattr(script, "PYTHON", sys.executable)
    monkeypatch.setattr(script.shutil, "which", lambda name: name)
    assert script.main(["--folder", str(tmp_path)]) == 1
    assert "FAILED: cmake -S" in last_line(capsys)
    assert script.main(["--folder", str(tmp_path), "--minutes", "0"]) == 1
    assert "no time left" in last_line(capsys)
