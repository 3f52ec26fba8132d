"""What a terminal gets beside results: progress bars, and words that complete a command line."""

import os
import pty
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

DATA = Path(__file__).parents[1] / "data"
FIT = ["fit", str(DATA / "made_points.csv"), "--test", "SS(18-18)", "--law", "hertz"]
CHOOSE = ["choose", str(DATA / "ballast.toml")]


@pytest.mark.parametrize("words", [FIT, CHOOSE], ids=lambda words: words[0])
def test_progress_is_shown_in_a_terminal(words):
    """Also in one that states no width, as of `script` and docker; not where the errors go to a file."""
    master, slave = pty.openpty()
    line = [sys.executable, "-m", "demlaws", *words]
    done = subprocess.run(line, stdout=subprocess.PIPE, stderr=slave, text=True)
    os.write(slave, b"end")  # a read of nothing would wait
    shown = os.read(master, 100_000).decode()
    os.close(slave)
    os.close(master)
    assert done.returncode == 0 and re.search(rf"{words[0]}:   0%\|.*\| 0/\d+ \[.*\]", shown), shown
    done = subprocess.run(line, capture_output=True, text=True)
    assert done.returncode == 0 and "%|" not in done.stderr


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("demlaws cur", {"curve"}),
        ("demlaws curve --la", {"--law", "--law-file"}),
        ("demlaws curve --law rou", {"rough-plastic"}),
        ("demlaws lammps ex", {"export"}),
    ],
)
def test_words_are_completed(line, words):
    pytest.importorskip("argcomplete")
    asked = {"COMP_LINE": line, "COMP_POINT": str(len(line)), "_ARGCOMPLETE": "1", "_ARGCOMPLETE_IFS": "\n"}
    command = ["sh", "-c", f"exec {shlex.quote(sys.executable)} -m demlaws 8>&1 9>/dev/null"]  # answers go to 8
    done = subprocess.run(command, env={**os.environ, **asked}, stdout=subprocess.PIPE, text=True, timeout=60)
    assert set(done.stdout.split()) == words
