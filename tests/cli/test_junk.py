"""Junk for every option of every command, taken from the parser itself: one line and status 2, or a result; no traceback.

DEMLAWS_JUNK=200 in the environment tries so many combinations a command in place of the few that a test run tries.
"""

import argparse
import importlib
import os
import random
import resource
import signal
import sys
import traceback

import numpy as np
import pytest
from examples import shared

from demlaws import cli

CONTACT = ["--effective-radius", "4e-3", "--modulus", "3e10", "--fractal-dimension", "2.2", "--hardness", "6e9"]
# what a command needs to run at all, as cheaply as it can; a command that is not named here gets junk alone
BASE = {
    "granite": ["--test", "SS(18-18)", "--law", "hertz"],
    "curve": ["--law", "hertz", *CONTACT, "--overlaps", "1e-6", "--steps", "2"],
    "table": ["--law", "hertz", *CONTACT, "--rtol", "1e-2", "--out", "t.tbl"],
    "regime": [*CONTACT[:2], *CONTACT[-2:], "--young", "6e10", "--poisson", "0.2", "--sigma", "1e-6"],
    "surface": ["map.npy", "--pixel", "1um"],
    "fit": ["points.csv", *CONTACT, "--law", "hertz"],
    "choose": ["scene.toml"],
    "soften": ["--factor", "10", "--law", "hertz", *CONTACT],
    "yade": ["check"],
    "liggghts": ["check"],
}
NUMBERS = ["nan", "inf", "-inf", "0", "-1", "-3mm", "1e400", "1e300", "1e-300", "3parsec", "0x10", "1,5", "", "∞", "{}", "--"]
WORDS = ["", "?!", "{}", "[1]", "x=", "=1", "branch={}", "yield_pressure=-1GPa", "slope=nan", "ünïcode", "a" * 5000]
FILES = [".", "/", "/proc/nowhere/x.png", "x.nonsense", "empty.csv", "empty.sur", "empty.x3p"]
FILES += ["noise.npy", "noise.toml", "noise.tbl"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    here = tmp_path_factory.mktemp("junk")
    for name in ("advice.choose", "advice.fit", "plots", "surface", "granite"):
        importlib.import_module(f"demlaws.{name}")  # once for all children
    for name in FILES:
        if name.startswith(("empty", "noise")):
            (here / name).write_bytes(b"" if name.startswith("empty") else bytes(range(256)) * 3)
    np.save(here / "map.npy", 1e-6 * np.random.default_rng(1).standard_normal((64, 64)))
    load = np.linspace(0.1, 20.0, 12)
    rows = (f"{1e6 * (p / 1e10) ** (2 / 3)},{p}" for p in load)
    (here / "points.csv").write_text("displacement (um),force (N)\n" + "\n".join(rows))
    (here / "scene.toml").write_text("radii = [1e-3]\nforce = [1, 2]\n[material]\nyoung = 'x'\npoisson = 0.2\n")
    return here


def leaves(parser, path=()):
    """Every command (and its own commands) with its options and positional arguments."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for name, sub in action.choices.items():
                yield from leaves(sub, (*path, name))
            return
    yield path, [a for a in parser._actions if not isinstance(a, (argparse._HelpAction, argparse._VersionAction))]


LEAVES = dict(leaves(cli.build_parser()))


def junk_for(action, chance):
    if action.nargs == 0:
        return [action.option_strings[0]]
    value = action.metavar if isinstance(action.metavar, str) else action.dest
    if action.choices is not None:
        pool = WORDS
    elif action.type is not None and action.type is not argparse.FileType and "Path" not in str(action.type):
        pool = NUMBERS + WORDS[:3] + FILES[:1]
    else:
        pool = FILES + WORDS
    count = {None: 1, "+": chance.choice([1, 3]), "*": chance.choice([0, 2]), "?": 1, "...": 1}.get(action.nargs, action.nargs)
    values = [chance.choice(pool) for _ in range(count)]
    assert value
    return [*action.option_strings[:1], *values]


def cases(path, actions, count):
    """Arguments: the base with one option replaced by junk, each option in turn, then any two of them."""
    chance = random.Random(" ".join(path))
    base = BASE.get(path[0], [])
    for turn in range(count):
        picked = [actions[turn % len(actions)]] if turn < 2 * len(actions) else chance.sample(actions, min(2, len(actions)))
        junk = [word for action in picked for word in junk_for(action, chance)]
        yield [*path, *(base if len(path) == 1 else ["x"] * chance.choice([0, 1])), *junk]


def run_in_a_child(arguments, folder):
    """Exit status and output of the command, in a forked process that may take a second of processor time and 3 GB more.

    Status None: it was still at work then, so the arguments were good enough to begin with.
    """
    log = folder / f"log-{os.getpid()}"
    child = os.fork()
    if child == 0:
        status = 99
        try:
            resource.setrlimit(resource.RLIMIT_CPU, (int(sum(resource.getrusage(resource.RUSAGE_SELF)[:2])) + 2,) * 2)
            resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
            signal.alarm(60)
            os.chdir(folder)
            os.environ["PATH"] = "/nowhere"  # no engine is started
            file = open(log, "w", encoding="utf-8")  # noqa: SIM115
            sys.stdin = open(os.devnull)  # noqa: SIM115
            sys.stdout = sys.stderr = file
            try:
                status = cli.main(arguments)
            except SystemExit as end:
                status = end.code
            except BaseException:
                traceback.print_exc()
            file.flush()
        finally:
            os._exit(status if isinstance(status, int) else 98)
    status = os.waitpid(child, 0)[1]
    return (None if os.WIFSIGNALED(status) else os.WEXITSTATUS(status)), log.read_text(encoding="utf-8")


@pytest.mark.parametrize("part", shared(range(4), (0).__eq__))
@pytest.mark.parametrize("path", LEAVES, ids=" ".join)
def test_no_traceback(path, part, folder):
    actions = LEAVES[path]
    if not actions:
        return
    count = int(os.environ.get("DEMLAWS_JUNK", "0")) or 8
    for arguments in list(cases(path, actions, count))[part::4]:
        status, text = run_in_a_child(arguments, folder)
        said = f"demlaws {' '.join(arguments)!r:.300}: status {status}\n{text[-1500:]}"
        assert "Traceback" not in text, said
        assert status in (None, 0, 1, 2), said
        if status == 2:
            lines = [line for line in text.splitlines() if "error:" in line]
            assert len(lines) == 1 and len(lines[0]) < 1000, said


@pytest.mark.parametrize("path", LEAVES, ids=" ".join)
def test_every_command_takes_a_file_of_laws(path):
    assert any("--law-file" in action.option_strings for action in LEAVES[path])
