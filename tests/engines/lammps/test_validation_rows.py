"""Rows of the validation report that LAMMPS computes: an impact on a plane, and an array along a path of strains."""

import numpy as np
import pytest

from studies.validation import engines, in_lammps, lammps_tests
from studies.validation.jobs import array_jobs


def test_an_array_keeps_the_history_of_its_contacts():
    """Pressure and bulk modulus of a face-centred array, loading and backward, by the lattice sum."""
    job = next(job for job in array_jobs() if job["array"] == "FCC" and job["unloading"] == "hertz")
    rows = list(engines.array_rows("LAMMPS", [job], in_lammps.answer([job])))
    assert [row.verdict for row in rows] == ["pass"] * 3
    loading, backward = (row.found for row in rows[1:])
    assert backward > 5.0 * loading  # Hertz-like unloading of a rough contact is far stiffer


FAST = ("dem01-hertz-tsuji", "dem01-hooke-twosphere", "dem04-mindlin-oblique", "dem06-spin-wall")


@pytest.mark.parametrize(
    "test", [pytest.param(t, id=t["name"], marks=[] if t["name"] in FAST else pytest.mark.slow) for t in lammps_tests.TESTS]
)
def test_lammps_own_tests_keep_their_results_with_a_table(test):
    assert lammps_tests.difference(test, lammps_tests.final_state(test), np.array(test["kept"])) < lammps_tests.TOLERANCE


@pytest.mark.slow
def test_every_row_that_lammps_computes_holds(monkeypatch):
    monkeypatch.setattr(engines, "ENGINES", {"LAMMPS": engines.ENGINES["LAMMPS"]})
    rows = [row for _, row in engines.rows()]
    assert len(rows) >= 34 and {row.where for row in rows} == {"LAMMPS"}
    wrong = [row for row in rows if not row.low <= row.found <= row.high]
    assert wrong == []
