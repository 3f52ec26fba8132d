"""What the validation report asks of LIGGGHTS."""

from studies.validation import engines
from studies.validation.jobs import kept_jobs
from studies.validation.published import KEPT, kept_rows


def test_the_places_that_lammps_keeps_are_met_in_liggghts():
    """LAMMPS's own DEM tests 02 and 03, with the law in place of stock hertz."""
    found = engines.in_liggghts(kept_jobs())
    rows = [row for one, answer in zip(KEPT, found, strict=True) for row in kept_rows(one, "LIGGGHTS", answer["places"])]
    assert len(rows) == 6 and [row for row in rows if row.verdict != "pass"] == []
