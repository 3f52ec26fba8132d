"""The extremes inside LAMMPS, in small (python -m studies.extremes --lammps measures them in full)."""

import pytest

from demlaws.lammps.run import command
from studies.extremes import extremes, report

pytestmark = pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")


@pytest.mark.slow
def test_extremes():
    figures = list(extremes.run("LAMMPS", ["pohrt-popov", "rough-plastic"], ["hertz"], quick=True, stops=False))
    assert [(f.engine, f.law, f.unloading) for f in figures] == [
        ("LAMMPS", law, "hertz") for law in ("pohrt-popov", "rough-plastic")
    ]
    assert report.failures(figures) == []
    assert all(p.contacts > 100 for f in figures for p in f.packings.values())


@pytest.mark.parametrize(
    "touching, where, value, message",
    [
        pytest.param(True, "velocity", "nan", "particle 3 is at (nan, 0, 0) m, which is not finite", marks=pytest.mark.slow),
        (False, "position", "nan", "particle 3 is at (nan, 0, 0) m, which is not finite"),
        # LAMMPS itself looks, when lists of neighbours are made anew
        pytest.param(True, "position", "inf", "Non-numeric atom coords", marks=pytest.mark.slow),
    ],
)
def test_numbers_that_are_none_stop(monkeypatch, touching, where, value, message):
    from studies.extremes.liggghts_extremes import stopped_by

    monkeypatch.setenv("LD_LIBRARY_PATH", command("none", plugin=False)[1].get("LD_LIBRARY_PATH", ""))
    said = stopped_by(touching, where, value, "LAMMPS")
    assert said and message in said
