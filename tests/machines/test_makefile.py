"""Which numpy the Makefile asks pip for."""

import os
import subprocess
from pathlib import Path

import pytest

PROJECT = Path(__file__).resolve().parents[2]
TRIXIE = "Package: python3-numpy\nVersion: 1:2.2.4+ds-1\nProvides: python3-numpy2-abi0\n"


def asked(python, tmp_path, packaged=None):
    """The Makefile's requirement for numpy, where apt-cache answers `packaged` (None: it fails)."""
    fake = tmp_path / "apt-cache"
    fake.write_text("#!/bin/sh\nexit 100\n" if packaged is None else f"#!/bin/sh\ncat <<E\n{packaged}E\n")
    fake.chmod(0o755)
    line = ["make", "-s", "--eval", 'asked: ; @echo "<$(NUMPY)>"', "asked", f"PYTHON={python}"]
    environment = {**os.environ, "PATH": f"{tmp_path}:{os.environ['PATH']}"}
    made = subprocess.run(line, cwd=PROJECT, env=environment, capture_output=True, text=True, check=True)
    return made.stdout.strip()


@pytest.mark.parametrize(("version", "requirement"), [("1.24.2", "<numpy==1.*>"), ("2.4.6", "<numpy==2.*>")])
def test_the_systems_numpy_decides(tmp_path, version, requirement):
    python = tmp_path / "python"
    python.write_text(f"#!/bin/sh\necho {version}\n")
    python.chmod(0o755)
    assert asked(python, tmp_path, TRIXIE) == requirement


def test_without_one_the_package_decides_for_the_systems_python_only(tmp_path):
    assert asked("/usr/bin/python3-absent", tmp_path, TRIXIE) == "<numpy==2.*>"
    assert asked("/usr/bin/python3-absent", tmp_path, TRIXIE.replace("1:2.2.4+ds-1", "1:1.24.2-1+deb12u1")) == "<numpy==1.*>"
    assert asked("/usr/bin/python3-absent", tmp_path, "N: no such package\n") == "<>"
    assert asked("/usr/bin/python3-absent", tmp_path) == "<>"
    assert asked("/opt/python3/bin/python3", tmp_path, TRIXIE) == "<>"
