"""The trade of speed for accuracy: errors fall with table size and with the step, the front is a front."""

import itertools

import pytest

import demlaws as dl
from studies.trade import trade
from studies.trade.__main__ import main
from studies.trade.liggghts_oedometer import edinburgh_fit


@pytest.fixture(scope="module")
def measured():
    return trade.measure(["hertz", "pohrt-popov", "rough-plastic"], count=20_000, rounds=2)


@pytest.mark.slow
def test_entries(measured):
    entries, floor = measured
    assert floor > 0.0
    assert all(e.ns > 0.0 for e in entries)
    closed = {e[:2]: e for e in entries if e.evaluation == "closed form"}
    assert closed["rough-plastic", "thornton"].richest["force"] < 1e-12
    assert closed["pohrt-popov", "hertz"].richest["stiffness"] > 0.01  # the bulk yields
    given = {e.evaluation: e for e in entries if e[:2] == ("pohrt-popov", "table")}  # along a given curve
    assert {"closed form", "table"} <= set(given) and given["closed form"].own["force"] < 1e-12
    assert given["closed form"].state_bytes == 16 and given["closed form"].richest["energy"] > 0.0
    tables = [e for e in entries if e[:3] == ("pohrt-popov", "hertz", "table")]
    assert len(tables) >= 4
    errors = [e.own["stiffness"] for e in tables]
    assert all(a > b for a, b in itertools.pairwise(errors))
    assert [e.rows for e in tables] == sorted(e.rows for e in tables)


def test_command(capsys):
    arguments = ["--law", "hertz", "--contacts", "1e4", "--rounds", "2"]
    assert not main(arguments)
    assert "Pareto" in capsys.readouterr().out
    assert main(["--law", "nonsense"]) == 2
    assert dl.laws()[0] in capsys.readouterr().err


def test_edinburgh_meets_the_law_at_its_load():
    law = dl.law("pohrt-popov", trade.GRANITE, "hertz")
    fit = edinburgh_fit(law, 20.0)
    overlap = float(law.overlap(20.0))
    assert fit.stiffness * overlap**fit.exponent == pytest.approx(20.0, rel=1e-12)
    assert fit.exponent * 20.0 / overlap == pytest.approx(float(law.stiffness(overlap)), rel=1e-12)
    plastic = overlap * (1.0 - 1.0 / fit.ratio) ** (1.0 / fit.exponent)
    assert plastic == pytest.approx(float(law.follow([overlap]).plastic_overlap[0]), rel=1e-9)
