"""`demlaws laws --check`, and --law-file FILE.py of every command."""

import subprocess
import sys

import pytest
from own_spring import POWER

CONTACT = ["--radius", "4mm", "--modulus", "30GPa"]


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
    done = demlaws("table", f"--law-file={file}", "--law", "power", *CONTACT, "--option", "factor=2e9", "--out", str(table))
    assert done.returncode == 0 and "this table holds for this contact only" in done.stdout, done.stderr
    assert "law: power" in table.read_text()


@pytest.mark.slow
def test_the_check_of_one_law(file):
    done = demlaws("laws", "power", "--law-file", file, "--check")
    assert done.returncode == 0 and "power: all checks passed" in done.stdout, done.stderr


def test_a_file_that_raises_is_one_line(tmp_path):
    file = tmp_path / "my_laws.py"
    file.write_text("raise ValueError('on purpose')")
    done = demlaws("laws", "--law-file", str(file))
    assert done.returncode == 2 and done.stderr.count("\n") == 1 and str(file) in done.stderr, done.stderr
