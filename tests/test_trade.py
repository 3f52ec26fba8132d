"""The trade of speed for accuracy: errors fall with table size and with the step, the front is a front."""

import itertools

import numpy as np
import pytest

import demlaws as dl
from demlaws import trade


@pytest.fixture(scope="module")
def measured():
    return trade.measure(["hertz", "pohrt-popov", "rough-plastic"], count=20_000, rounds=2)


def test_entries(measured):
    entries, floor = measured
    assert floor > 0.0
    assert all(e.ns > 0.0 for e in entries)
    closed = {e[:2]: e for e in entries if e.evaluation == "closed form"}
    assert closed["rough-plastic", "thornton"].richest["force"] < 1e-12
    assert closed["pohrt-popov", "hertz"].richest["stiffness"] > 0.01  # the bulk yields
    tables = [e for e in entries if e[:3] == ("pohrt-popov", "hertz", "table")]
    assert len(tables) >= 4
    errors = [e.own["stiffness"] for e in tables]
    assert all(a > b for a, b in itertools.pairwise(errors))
    assert [e.rows for e in tables] == sorted(e.rows for e in tables)
    lazy = [e for e in entries if e[:3] == ("pohrt-popov", "elastic", "lazy")]
    assert lazy[0].refreshed > lazy[1].refreshed > lazy[2].refreshed
    assert lazy[0].own["force"] < lazy[2].own["force"]


def test_front(measured):
    entries, _ = measured
    front = sorted((e for e in entries if e.front), key=lambda e: e.ns)
    assert len(front) >= 2
    for e in entries:
        assert any(f.ns <= e.ns and trade.GAIN * f.richest["force"] <= e.richest["force"] for f in front)


def test_steps():
    entries = trade.steps_trade(2.0, speeds=(0.1,), phases=2)
    gains = np.array([e.gain for e in entries])
    assert gains[0] > 1e-2
    assert gains[-1] < 1e-9
    assert entries[-1].rebound_error < 1e-6


def test_command(tmp_path, capsys):
    from demlaws.cli import main

    arguments = ["trade", "--law", "hertz", "--contacts", "1e4", "--rounds", "2"]
    assert main([*arguments, "--csv", str(tmp_path / "t.csv"), "--figure", str(tmp_path / "t.png")]) == 0
    assert "Pareto" in capsys.readouterr().out
    assert main(["trade", "--law", "nonsense"]) == 2
    assert dl.laws()[0] in capsys.readouterr().err
