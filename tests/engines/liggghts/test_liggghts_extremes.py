"""The extremes inside LIGGGHTS, in small (demlaws stability --liggghts measures them in full)."""

import pytest

from demlaws import extremes

pytestmark = pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")


@pytest.mark.slow
def test_extremes():
    *figures, stops = extremes.run("LIGGGHTS", ["pohrt-popov", "rough-plastic"], ["hertz"], quick=True)
    assert [(f.engine, f.law, f.unloading) for f in figures] == [
        ("LIGGGHTS", law, "hertz") for law in ("pohrt-popov", "rough-plastic")
    ]
    assert extremes.failures(figures) == []
    assert all(p.contacts > 100 for f in figures for p in f.packings.values())
    assert len(stops) == 8 and extremes.stop_failures("LIGGGHTS", stops) == []
    for what, message in stops:
        assert ("particle 3 is at (nan" if "NaN" in what else "Lost atoms") in message
