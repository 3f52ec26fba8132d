"""A law whose unloading is its own inside LIGGGHTS and LAMMPS: the code of its rule beside the table."""

from pathlib import Path

import numpy as np
import pytest
from examples import shared
from inputs import ENERGY, LOAD_UNLOAD, part, started
from own_spring import FAULTS, registered, spoil
from spheres import ENGINES, assert_goes_on, spheres

import demlaws as dl

CONTACT = dl.Contact(radius=4e-3, modulus=32e9)


def text_on(engine, ranks):
    """The self-test's input: each of two ranks has one of the spheres."""
    check = part(engine, "check")
    if engine == "lammps":
        return check.TWO_PARTICLES
    return check.WITH_ENERGIES.replace("processors      1 1 1", f"processors {ranks} 1 1")


@pytest.mark.parametrize(
    "engine, ranks", shared([(engine, ranks) for engine in ENGINES for ranks in (1, 2)], ("liggghts", 1).__eq__)
)
def test_a_rule_of_ones_own(tmp_path, engine, ranks):
    """From a file outside the package: within the certificate of the law, and the table's own to rounding."""
    with registered(tmp_path):
        law = dl.law("spring", CONTACT, lost=0.3)
        log, path = part(engine, "check").follow(law, text_on(engine, ranks), rtol=1e-6, folder=tmp_path, ranks=ranks)
        table = law.tabulate(1e-6).follow(log["overlap"])
    assert (tmp_path / "law.tbl.so").is_file()
    assert path.overlap.max() > 1e-5 and np.count_nonzero(log["force"]) > 300
    assert np.abs(log["force"] - path.force).max() <= 2e-6 * path.force.max()
    # the overlap is read with an error of some 1e-18 m, where k/P may be large
    np.testing.assert_allclose(log["force"], table.force, rtol=1e-12, atol=1e-11 * table.force.max())
    assert np.abs(log["stored"] - table.stored).max() <= 1e-6 * table.work.max()
    assert np.abs(log["lost"] - table.dissipated).max() <= 1e-6 * table.work.max()


@pytest.mark.parametrize("engine, ranks", shared([("liggghts", 1), ("lammps", 1), ("lammps", 2)], ("lammps", 1).__eq__))
def test_a_rule_of_ones_own_goes_on_after_a_restart(engine, tmp_path, ranks):
    """During unloading a restart file is written; new processes, on as many ranks and on one, go on to the last bit."""
    with registered(tmp_path):
        law = dl.law("spring", CONTACT, lost=0.3)
        law.tabulate(1e-6).save(tmp_path / "law.tbl")
        first, second = LOAD_UNLOAD[:2], [(-0.2, 0, 400), *LOAD_UNLOAD[2:]]
        kind = {"d1": 16e-3, "d2": 16e-3, "left": -0.008, "young": 2 * CONTACT.modulus * (1 - 0.25**2), "ranks": ranks}
        text = spheres(engine, "", first, **kind, **ENERGY)
        whole, rest = assert_goes_on(engine, tmp_path, text, second, ranks, d1=16e-3, d2=16e-3)
        path = law.follow(whole["overlap"])
    assert np.abs(whole["force"] - path.force).max() <= 2e-6 * path.force.max()
    assert 0 < rest["force"][0] < 0.7 * whole["force"].max()


REASONS = {
    "missing": "must lie beside the table",
    "another": "is not the object that the table was written with",
    "missing on one rank": "must lie beside the table",
}


@pytest.mark.parametrize(
    "engine, fault", shared([(engine, fault) for engine in ENGINES for fault in FAULTS], ("liggghts", "missing").__eq__)
)
def test_an_object_that_is_not_there_is_refused(tmp_path, engine, fault):
    with registered(tmp_path):
        table = dl.law("spring", CONTACT, lost=0.3).tabulate(1e-4).save(tmp_path / "law.tbl")
    ranks = spoil(Path(f"{table}.so"), fault)
    variables = {"young": repr(2 * CONTACT.modulus * (1 - 0.25**2)), "radius": repr(8e-3), "table": "law.tbl"}
    variables |= {"newton": "on", "every": 4}
    done = started(engine, tmp_path, text_on(engine, ranks), ranks, variables, away=1 if ranks > 1 else None)
    said = " ".join((done.stdout + done.stderr).split())
    assert done.returncode
    assert f"rank {ranks - 1}: " in said and "law.tbl.so" in said
    assert REASONS[fault] in said
