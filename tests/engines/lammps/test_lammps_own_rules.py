"""A law whose unloading is its own inside LAMMPS: the code of its rule beside the table."""

import subprocess
from pathlib import Path

import numpy as np
import pytest
from examples import shared
from inputs_for_lammps import LOAD_UNLOAD, MINDLIN, continued, moves_of, simulate, two_spheres
from own_spring import FAULTS, registered, spoil
from processes import parted

import demlaws as dl
from demlaws.lammps.check import TWO_PARTICLES, follow
from demlaws.lammps.run import command, executable

CONTACT = dl.Contact(radius=4e-3, modulus=32e9)
YOUNG = 2 * CONTACT.modulus * (1 - 0.25**2)
TABLE = f"demlaws/table law.tbl {YOUNG!r} 1.0 0.25 {MINDLIN}"
ENERGY = "compute e all demlaws/energy"


@pytest.mark.slow  # the one after a restart compares the force, too
@pytest.mark.parametrize("ranks", [1, 2])
def test_a_rule_of_ones_own(tmp_path, ranks):
    """From a file outside the package: within the certificate of the law, and the table's own to rounding."""
    with registered(tmp_path):
        law = dl.law("spring", CONTACT, lost=0.3)
        log, path = follow(law, rtol=1e-6, folder=tmp_path, ranks=ranks)
        table = law.tabulate(1e-6).follow(log["overlap"])
    assert (tmp_path / "law.tbl.so").is_file()
    assert log["overlap"].max() > 1e-5
    assert np.abs(log["force"] - path.force).max() <= 2e-6 * path.force.max()
    np.testing.assert_allclose(log["force"], table.force, rtol=1e-12, atol=1e-11 * table.force.max())
    assert np.abs(log["stored"] - table.stored).max() <= 1e-6 * table.work.max()
    assert np.abs(log["lost"] - table.dissipated).max() <= 1e-6 * table.work.max()


@pytest.mark.parametrize("ranks", shared([1, 2], (1).__eq__))
def test_a_rule_of_ones_own_goes_on_after_a_restart(tmp_path, ranks):
    """Half way back a restart file is written; new processes, on as many ranks and on one, go on to the last bit."""
    with registered(tmp_path):
        law = dl.law("spring", CONTACT, lost=0.3)
        law.tabulate(1e-6).save(tmp_path / "law.tbl")
        first, second = LOAD_UNLOAD[:2], [(-0.2, 0, 400), *LOAD_UNLOAD[2:]]
        across, watch = {"d1": 16e-3, "d2": 16e-3}, {"more": ENERGY, "columns": "c_e[1] c_e[2]"}
        text = two_spheres(TABLE, first, left=-0.008, **across, **watch) + "write_restart now.restart\n" + moves_of(second)
        whole = simulate(tmp_path, text, ranks)
        path = law.follow(whole["overlap"])
    assert np.abs(whole["force"] - path.force).max() <= 2e-6 * path.force.max()
    for later in {1, ranks}:
        rest = simulate(tmp_path, continued(second, **across, **watch), later)
        rows = np.isin(whole["Step"], rest["Step"])
        assert rest["Step"].size == rows.sum() > 150 and 0 < rest["force"][0] < 0.7 * whole["force"].max()
        for column in ("force", "side"):
            np.testing.assert_array_equal(rest[column], whole[column][rows], err_msg=column)
        for column in ("e[1]", "e[2]"):  # sums over ranks, in another order
            np.testing.assert_allclose(rest[column], whole[column][rows], rtol=1e-14, err_msg=column)


@pytest.mark.slow
@pytest.mark.parametrize("fault", shared(FAULTS, "missing".__eq__))
def test_an_object_that_is_not_there_is_refused(tmp_path, fault):
    with registered(tmp_path):
        table = dl.law("spring", CONTACT, lost=0.3).tabulate(1e-4).save(tmp_path / "law.tbl")
    ranks = spoil(Path(f"{table}.so"), fault)
    (tmp_path / "in.contact").write_text(TWO_PARTICLES)
    given = {"young": repr(YOUNG), "radius": repr(8e-3), "table": "law.tbl", "newton": "on", "every": 4}
    line, environment = command("in.contact", ranks, given)
    if ranks > 1:
        line = parted(line, executable().path, tmp_path)
    done = subprocess.run(line, cwd=tmp_path, env=environment, capture_output=True, text=True, errors="replace", timeout=120)
    said = " ".join((done.stdout + done.stderr).split())
    assert done.returncode
    reason = {
        "missing": "rank 0: law.tbl.so: cannot be opened (No such file or directory)",
        "another": "rank 0: law.tbl.so is not the object that the table was written with",
        "missing on one rank": "rank 1: it finds no law.tbl.so, or another than the table was written with",
    }
    assert f"ERROR: demlaws/table: {reason[fault]}" in said, said
