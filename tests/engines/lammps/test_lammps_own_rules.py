"""A law whose unloading is its own inside LAMMPS: the code of its rule beside the table."""

import numpy as np
import pytest
from examples import shared
from inputs_for_lammps import LOAD_UNLOAD, SHEAR, continued, moves_of, simulate, two_spheres
from own_spring import registered

import demlaws as dl

CONTACT = dl.Contact(radius=4e-3, modulus=32e9)
YOUNG = 2 * CONTACT.modulus * (1 - 0.25**2)
TABLE = f"demlaws/table law.tbl {YOUNG!r} 1.0 0.25 {SHEAR}"
ENERGY = "compute e all demlaws/energy"


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
