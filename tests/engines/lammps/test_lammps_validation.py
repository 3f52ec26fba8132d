"""The rows of the validation report that LAMMPS computes: impacts and regular arrays against print and closed form."""

import pytest

from studies.validation import engines

pytestmark = pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")


@pytest.mark.slow
def test_every_row_that_lammps_computes_holds(monkeypatch):
    monkeypatch.setattr(engines, "ENGINES", {"LAMMPS": engines.ENGINES["LAMMPS"]})
    rows = [row for _, row in engines.rows(packing=False)]
    assert len(rows) >= 34 and {row.where for row in rows} == {"LAMMPS"}
    wrong = [row for row in rows if not row.low <= row.found <= row.high]
    assert wrong == []
