"""Rows of the validation report that LAMMPS computes: an impact on a plane, and an array along a path of strains."""

from demlaws.validation import engines, in_lammps
from demlaws.validation.jobs import array_jobs, impact_jobs
from demlaws.validation.published import IMPACTS


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
