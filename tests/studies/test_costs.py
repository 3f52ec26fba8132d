"""What a way costs inside an engine, without the engine: how it is described to one, and what is made of its answer."""

import math

import pytest

import demlaws as dl
from studies.costs import costs
from studies.trade.candidates import Way

CONTACT = dl.Contact(4e-3, 32e9, 2e-6, 2.2, 6e9)


def test_a_way_as_the_scripts_take_it(tmp_path):
    closed = costs.describe(Way("a", "bahrami", "hertz", options=(("constant", 1.6),)), tmp_path, CONTACT, 0)
    assert closed["options"] == {"constant": 1.6} and closed["given"] == "bahrami"
    assert not list(tmp_path.iterdir())
    table = costs.describe(Way("b", "pohrt-popov", "hertz", rtol=1e-3), tmp_path, CONTACT, 7)
    assert table["given"] == str(tmp_path / "7.tbl") and table["options"] == {}
    assert dl.Table.load(table["given"]).unloading == "hertz"


def test_shares_of_a_step_in_yade(monkeypatch):
    """100 contacts, times in ns: the loop with each model, with Mindlin's functor in the same packing, with one that does
    nothing, and the rest of the step."""
    native = {"loop": 5000.0, "rest": 2000.0, "contacts": 100, "nothing": None, "mindlin": None}
    ours = {"loop": 5600.0, "rest": 2500.0, "contacts": 100, "nothing": 3000.0, "mindlin": 5100.0}
    cone = {"loop": 6000.0, "rest": 2100.0, "contacts": 100, "nothing": None, "mindlin": None}
    told = {}

    def script(name, given):
        told.update(given, name=name)
        return [native, ours, cone]

    monkeypatch.setattr(costs, "under_yade", script)
    ways = [Way("ours", "pohrt-popov", "hertz"), Way("cone", model="cdm")]
    one, other = costs.yade_costs(ways, {"radius": 1e-3}, CONTACT)
    assert told["name"] == "costs/yade_cost.py" and [w["label"] for w in told["ways"]] == ["hertz", "ours", "cone"]
    # the rest is the least of all; the native step is 50 + 20
    assert one.step == pytest.approx(70.0 + 5.0) and one.over_hertz == pytest.approx(75.0 / 70.0)
    assert one.law == pytest.approx(5.0 / 75.0) and one.model == pytest.approx(26.0 / 75.0)
    assert other.step == pytest.approx(80.0) and math.isnan(other.law) and other.model == pytest.approx(30.0 / 80.0)


def test_shares_of_a_step_in_liggghts(monkeypatch):
    found = [
        {"step": 1000.0, "contacts": 10, "alone": None, "pair": 800.0},
        {"step": 1200.0, "contacts": 10, "alone": 6.0, "pair": 900.0},
        {"step": 1100.0, "contacts": 10, "alone": None, "pair": 880.0},
    ]
    monkeypatch.setattr("studies.costs.liggghts_cost.measure", lambda *arguments: found)
    table, stock = costs.plugin_costs("liggghts", [Way("t", "hertz", rtol=1e-5), Way("e", model="edinburgh")], {})
    assert (table.step, table.over_hertz, table.law, table.model) == pytest.approx((120.0, 1.2, 0.05, 0.75))
    assert math.isnan(stock.law) and stock.over_hertz == pytest.approx(1.1)


def test_what_yade_said_before_it_stopped(monkeypatch):
    """An engine that ends without an answer is one error with its last words."""
    monkeypatch.setattr("demlaws.yade.run.environment", lambda: None)
    line = ["sh", "-c", "echo PROGRESS one; echo no such body; exit 3"]
    monkeypatch.setattr("demlaws.yade.run.command", lambda script, files: line)
    said = []
    with pytest.raises(dl.DemlawsError, match=r"(?s)YADE stopped \(exit 3\): .*no such body"):
        costs.under_yade("costs/yade_cost.py", {}, said.append)
    assert said == ["one"]
