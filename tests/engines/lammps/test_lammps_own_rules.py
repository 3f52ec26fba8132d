"""A law whose unloading is its own inside LAMMPS: the code of its rule beside the table."""

from pathlib import Path

import numpy as np
import pytest
from examples import shared
from own_spring import registered

import demlaws as dl
from demlaws.lammps.check import TWO_PARTICLES, follow
from demlaws.lammps.run import run

CONTACT = dl.Contact(radius=4e-3, modulus=32e9)


@pytest.mark.parametrize("ranks", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_a_rule_of_ones_own(tmp_path, ranks):
    """From a file outside the package: within the certificate of the law, and the table's own to rounding."""
    with registered(tmp_path):
        law = dl.law("spring", CONTACT, lost=0.3)
        log, path = follow(law, rtol=1e-6, folder=tmp_path, ranks=ranks)
        table = law.tabulate(1e-6).follow(log["overlap"])
    assert (tmp_path / "law.tbl.so").is_file()
    assert log["overlap"].max() > 1e-5
    assert np.abs(log["pull"] - path.force).max() <= 2e-6 * path.force.max()
    np.testing.assert_allclose(log["pull"], table.force, rtol=1e-12, atol=1e-11 * table.force.max())
    assert np.abs(log["energy[1]"] - table.stored).max() <= 1e-6 * table.work.max()
    assert np.abs(log["energy[2]"] - table.dissipated).max() <= 1e-6 * table.work.max()


@pytest.mark.parametrize("fault", shared(["missing", "another"], "missing".__eq__))
def test_an_object_that_is_not_there_is_refused(tmp_path, fault):
    with registered(tmp_path):
        table = dl.law("spring", CONTACT, lost=0.3).tabulate(1e-4).save(tmp_path / "law.tbl")
    code = Path(f"{table}.so")
    if fault == "another":
        code.write_bytes(code.read_bytes() + b"\n")
    else:
        code.unlink()
    (tmp_path / "in.contact").write_text(TWO_PARTICLES)
    given = {"young": repr(2 * CONTACT.modulus * (1 - 0.25**2)), "radius": repr(8e-3), "table": "law.tbl", "newton": "on"}
    said = "is not the object that the table was written with" if fault == "another" else "must lie beside the table"
    with pytest.raises(dl.DemlawsError, match=rf"rank 0: law\.tbl\.so.*{said}"):
        run(tmp_path / "in.contact", 1, {**given, "every": 4})
