"""Rows of the validation report that LAMMPS computes: an impact on a plane, and an array along a path of strains."""

import pytest

from studies.validation import engines, in_lammps
from studies.validation.jobs import array_jobs, impact_jobs, kept_jobs
from studies.validation.published import IMPACTS, KEPT, kept_rows


@pytest.mark.slow
def test_an_impact_on_a_rigid_plane_gives_the_printed_peak():
    number = next(n for n, one in enumerate(IMPACTS) if one.plane)
    (found,) = in_lammps.answer(impact_jobs()[number : number + 1])
    assert found["parted"] and abs(found["peak"] / IMPACTS[number].peak - 1.0) < 1e-5
    assert abs(found["restitution"] - 1.0) < 1e-6


def test_an_array_keeps_the_history_of_its_contacts():
    """Pressure and bulk modulus of a face-centred array, loading and backward, by the lattice sum."""
    job = next(job for job in array_jobs() if job["array"] == "FCC" and job["unloading"] == "hertz")
    rows = list(engines.array_rows("LAMMPS", [job], in_lammps.answer([job])))
    assert [row.verdict for row in rows] == ["pass"] * 3
    loading, backward = (row.found for row in rows[1:])
    assert backward > 5.0 * loading  # Hertz-like unloading of a rough contact is far stiffer


def test_the_places_that_lammps_keeps_are_met_in_lammps():
    """LAMMPS's own DEM tests 02 and 03, with the law in place of stock hertz."""
    found = engines.in_lammps(kept_jobs())
    rows = [row for one, answer in zip(KEPT, found, strict=True) for row in kept_rows(one, "LAMMPS", answer["places"])]
    assert len(rows) == 6 and [row for row in rows if row.verdict != "pass"] == []


@pytest.mark.parametrize("one", in_lammps.OBLIQUE, ids=lambda one: one.name)
def test_oblique_impacts_are_those_of_hertz_material_to_round_off(one):
    ours, stock = in_lammps.oblique(one), in_lammps.oblique(one, "hertz/material")
    assert ours == pytest.approx(stock, rel=1e-13)
    assert ours == pytest.approx(list(one.kept), rel=in_lammps.OBLIQUE_TOLERANCE)
