"""What commands refuse at once, in one line, and what they leave behind in the process."""

import ast
import os
import subprocess
import sys
import threading
from pathlib import Path

import pytest

import demlaws as dl
from demlaws import cli
from demlaws.cli import main
from demlaws.core import numba_compat
from demlaws.files import write_atomically

BODIES = ["--young", "60GPa", "--poisson", "0.2", "--roughness", "1um", "--hardness", "6GPa"]


def refused(capsys, *arguments):
    """The one line with which a command ends."""
    try:
        status = main(list(arguments))
    except SystemExit as error:
        status = error.code
    printed = capsys.readouterr()
    lines = printed.err.splitlines()
    assert status == 2 and len(lines) == 1 and not printed.out
    return lines[0]


def test_an_option_is_given_once(capsys):
    curve = ["curve", "--law", "hertz", *BODIES, "--overlaps", "1e-6", "--radius", "8mm"]
    assert "argument --radius: given twice" in refused(capsys, *curve, "--radius", "9mm", "9mm")
    assert "argument --law: given twice" in refused(capsys, *curve, "--law", "rms")
    assert main([*curve, "9mm", "--steps", "1"]) == 0


def test_a_command_is_named(capsys):
    assert main([]) == 2
    printed = capsys.readouterr()
    assert all(name in printed.out for name in cli.COMMANDS) and "no command" in printed.err


def test_a_load_beyond_the_radius(capsys):
    line = refused(capsys, "regime", "--radius", "3mm", "3mm", *BODIES, "--load", "1e9")
    assert "load 1e9 N" in line and "effective radius" in line
    with pytest.raises(dl.DemlawsError):
        dl.regime.advise(dl.Contact(3e-3, 32e9, 1e-6, hardness=6e9), 1e9)


def test_rules_that_are_named_are_accepted(capsys):
    """`table` alone is none: a table's file is."""
    curve = ["curve", "--law", "hertz", "--radius", "8mm", "8mm", *BODIES, "--overlaps", "1e-6", "--steps", "1"]
    line = refused(capsys, *curve, "--unloading", "junk")
    rules = line.partition("The rules are ")[2].partition(" (law")[0].split(", ")
    for rule in rules:
        assert main([*curve, "--unloading", rule]) == 0, rule
    capsys.readouterr()
    assert "needs its curve" in refused(capsys, *curve, "--unloading", "table")
    assert main(["laws"]) == 0 and "elastic, hertz, thornton, or a table" in capsys.readouterr().out


def test_a_closed_output_is_one_line():
    command = f'exec "{sys.executable}" -m demlaws laws >&-'
    ended = subprocess.run(command, shell=True, capture_output=True, text=True, check=False)
    assert ended.returncode == 2 and ended.stderr.count("\n") == 1 and "standard output is closed" in ended.stderr


@pytest.mark.parametrize(("argv", "error"), [(["-m"], SystemExit), (["script.py"], ImportError)])
def test_an_old_python_is_named(monkeypatch, argv, error):
    """The file is read by Python 3.9, and ends before it imports others."""
    source = Path(dl.__file__).read_text()
    ast.parse(source, feature_version=(3, 9))
    monkeypatch.setattr(sys, "version_info", (3, 9, 2))
    monkeypatch.setattr(sys, "argv", argv)
    with pytest.raises(error, match=r"3\.10 or later, this is 3\.9"):
        exec(compile(source, "__init__.py", "exec"), {"__name__": "demlaws"})


def test_a_long_compilation_is_said_once(capsys):
    """In a script as on the command line, with how long it takes; a short one is not said."""
    numba_compat._say_once.cache_clear()
    with numba_compat.announced():
        pass
    assert capsys.readouterr().err == ""
    for _ in range(2):
        with numba_compat.announced():
            for timer in threading.enumerate():
                if isinstance(timer, threading.Timer):
                    timer.join()
    said = capsys.readouterr().err
    assert said.count("compiling") == 1 and "10 s" in said


def test_a_file_is_written_with_the_umask_of_the_process(tmp_path, monkeypatch):
    """Which is never changed, not even for a moment: another thread's files would get it."""
    former = os.umask(0o027)
    try:
        modes, done = set(), threading.Event()

        def other():
            while not done.is_set():
                file = tmp_path / "other"
                file.touch()
                modes.add(file.stat().st_mode & 0o777)
                file.unlink()

        thread = threading.Thread(target=other)
        thread.start()
        with monkeypatch.context() as patch:
            patch.setattr(os, "umask", lambda mask: pytest.fail("the umask was changed"))
            for n in range(50):
                write_atomically(tmp_path / f"file{n}", "text")
        done.set()
        thread.join()
    finally:
        os.umask(former)
    assert modes == {0o640} and {file.stat().st_mode & 0o777 for file in tmp_path.iterdir()} == {0o640}
