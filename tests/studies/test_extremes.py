"""What judges the engines at the extremes, without an engine: a law that behaves passes, each fault is found."""

import numpy as np
import pytest

from studies.extremes import extremes, report
from studies.extremes.stability import Case

pytestmark = pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")
ROUGH = Case("pohrt-popov", "hertz", "closed form")


class Python:
    """Stands for an engine: the law itself, with a fault."""

    def __init__(self, fault=None):
        self.fault = fault

    def two_spheres(self, group, wanted):
        left = group.radius1 + group.radius2
        overlap = left - np.sqrt((left - wanted) ** 2)
        state = group.law.new_state(group.size)
        force = np.empty_like(overlap)
        for n, row in enumerate(overlap):
            if self.fault == "remembers":  # no fresh start after parting
                row = np.where(row > 0.0, row, 1e-30)
            force[n], _ = group.law.evaluate(row, state)
        force[overlap <= 0.0] = 0.0
        if self.fault == "gives back":  # stronger while parting than while closing
            force[1:][np.diff(overlap, axis=0) < 0.0] *= 1.0 + 1e-9
        if self.fault == "creeps":
            force *= 1.0 + 1e-12 * np.arange(len(force))[:, None]
        if self.fault == "coarse":
            force *= 1.0 + 1e-13
        if self.fault == "NaN":
            force[len(force) // 2] = np.nan
        return overlap, force


def compared(case, fault=None):
    random = np.random.default_rng(5)
    group = extremes.groups(case, random)[0]
    wanted, kinds = extremes.paths(group, 200, random)
    return extremes.compare(group, wanted, kinds, *Python(fault).two_spheres(group, wanted))


@pytest.mark.parametrize("case", [ROUGH, Case("hertz", "elastic", "table"), Case("yip-venart", "thornton", "closed form")])
def test_the_law_passes_its_own_judgement(case):
    found = compared(case)
    assert found.not_finite == found.broken == 0
    assert found.closed > 10
    assert max(found.later, found.reload, *found.decades.values()) == 0.0
    assert found.to_law <= (1e-5 if case.evaluation == "table" else 1e-14)
    assert abs(found.returned) <= extremes.RETURN
    assert extremes.ratcheting(Python(), case, 50) == 0.0


def test_every_fault_is_found():
    assert compared(ROUGH, "NaN").not_finite > 0
    assert compared(ROUGH, "remembers").broken > 0
    assert compared(ROUGH, "gives back").returned > extremes.RETURN
    assert min(compared(ROUGH, "coarse").decades.values()) > 400.0
    assert compared(ROUGH, "creeps").reload > 100.0
    assert extremes.ratcheting(Python("creeps"), ROUGH, 50) > 1e-11


def test_packing_overlaps_as_stated_and_shares_energy():
    made = extremes.packing(ROUGH, "stiff", 150)
    assert made.radius[0] / made.radius[-1] > 80.0
    distance = np.linalg.norm(made.position[:, None] - made.position, axis=2) + 1e9 * np.eye(150)
    overlap = made.radius[:, None] + made.radius - distance
    effective = made.radius[:, None] * made.radius / (made.radius[:, None] + made.radius)
    assert np.count_nonzero(overlap > 0.0) >= 2 * 149
    assert (overlap / effective).max() <= 0.05
    energy = made.mass * made.speed**2
    np.testing.assert_allclose(energy, energy[0], rtol=1e-12)


GOOD = extremes.Compared(0, 1e-15, {-3: 2.0, -1: 0.0}, 2.0, 5, 0.0, 0.0, 0)
CALM = extremes.Released(1000, 100.0, 4000, 999, 100.0, 0, 1e-6, 1e-16)
IMPACTS = extremes.Impacts(1e-9, 1e-6, {20: 1e-3, 50: 1e-5})
ROW = extremes.Figures("YADE", *ROUGH, "extreme", 10, 100, GOOD, 0.0, 100, IMPACTS, {"soft": CALM, "stiff": CALM})


def test_figures_survive_the_way_between_processes():
    import json

    assert extremes.from_json(json.loads(json.dumps(extremes.as_json(ROW)))) == ROW


def test_an_engine_that_ends_early_is_an_error(monkeypatch, tmp_path):
    """What it said last is in the message."""
    from demlaws.errors import DemlawsError
    from demlaws.yade import run

    script = tmp_path / "dies"
    script.write_text("#!/bin/sh\necho 'Error: no such scene'\nexit 3\n")
    script.chmod(0o755)
    monkeypatch.setattr(run, "command", lambda *arguments, **options: [str(script)])
    monkeypatch.setattr(run, "environment", lambda: None)
    with pytest.raises(DemlawsError, match="YADE ended after 0 results: Error: no such scene"):
        list(extremes.run("YADE", ["hertz"], ["elastic"]))


def test_failures_name_what_is_wrong():
    row, good, calm, impacts = ROW, GOOD, CALM, IMPACTS
    assert report.failures([row]) == []
    assert len(report.csv_row(row)) == len(report.TITLES)
    assert len(report.table([row]).split("\n")[-1]) <= len(report.table([row]).split("\n")[0]) + 2
    wrong = [
        row._replace(compared=good._replace(not_finite=3)),
        row._replace(compared=good._replace(to_law=1e-9)),
        row._replace(compared=good._replace(decades={-3: 1e7})),
        row._replace(compared=good._replace(returned=1e-6)),
        row._replace(compared=good._replace(reload=1e3)),
        row._replace(compared=good._replace(broken=1)),
        row._replace(ratcheting=1e-12),
        row._replace(impacts=impacts._replace(rebound=1e-3)),
        row._replace(packings={"soft": calm._replace(drift=0.1)}),
        row._replace(packings={"soft": calm._replace(momentum=1e-6)}),
    ]
    assert all(len(report.failures([one])) == 1 for one in wrong)
    assert report.stop_failures("YADE", [("NaN position", None), ("NaN velocity", "stopped")]) != []
