"""The extremes inside LIGGGHTS, in small (python -m studies.extremes --liggghts measures them in full)."""

import pytest

from studies.extremes import extremes, report

pytestmark = pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")


@pytest.mark.slow
def test_extremes():
    figures = list(extremes.run("LIGGGHTS", ["pohrt-popov", "rough-plastic"], ["hertz"], quick=True, stops=False))
    assert [(f.engine, f.law, f.unloading) for f in figures] == [
        ("LIGGGHTS", law, "hertz") for law in ("pohrt-popov", "rough-plastic")
    ]
    assert report.failures(figures) == []
    assert all(p.contacts > 100 for f in figures for p in f.packings.values())


@pytest.mark.parametrize(
    "touching, where, value, message",
    [
        pytest.param(
            True,
            "velocity",
            "nan",
            "particle 3 is at (nan, 0, 0) m with velocity (nan, 0, 0) m/s, which is not finite",
            marks=pytest.mark.slow,
        ),
        (False, "position", "nan", "particle 3 is at (nan, 0, 0) m"),
        pytest.param(
            True, "position", "inf", "Lost atoms", marks=pytest.mark.slow
        ),  # LIGGGHTS's own rule for a particle beyond the box
    ],
)
def test_numbers_that_are_none_stop(touching, where, value, message):
    from studies.extremes.liggghts_extremes import stopped_by

    assert message in stopped_by(touching, where, value)
