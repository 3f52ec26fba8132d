"""`choose` measures what laws cost on the machine. Here they cost the same on every machine at every time: what it does with
the costs is tested, and `make bench` times again what it chose."""

import pytest

LAWS = {"hertz": 1.0, "goddard": 1.5, "rms": 2.0, "pohrt-popov": 3.0, "rough-plastic": 4.0, "bahrami": 8.0, "yip-venart": 9.0}
RULES = {"elastic": 0.0, "hertz": 1.0, "thornton": 1.5}


def cost_of(key):
    """ns a contact, as measured on an idle machine, to the nearest half."""
    plan, _ = key
    if plan.evaluation == "table":
        return 2.5 + RULES.get(plan.unloading, 1.0)
    branch = 0.5 if dict(plan.options).get("branch") else 1.0
    memory = 0.6 if plan.evaluation.endswith("float32") else 1.0
    return memory * (branch * LAWS.get(plan.name, 9.0) + RULES.get(plan.unloading, 1.0))


@pytest.fixture(autouse=True)
def steady_costs(monkeypatch):
    monkeypatch.setattr("demlaws.advice.choose.nanoseconds", lambda batches, rounds: ({p: cost_of(p) for p in batches}, 0.5))
