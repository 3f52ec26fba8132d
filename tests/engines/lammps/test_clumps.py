"""Clumps in LAMMPS (fix rigid/small): the history of their contacts over ranks, migration and restart."""

import shutil

import numpy as np
import pytest
from inputs import modulus, save
from inputs_for_lammps import SHEAR, simulate

import demlaws as dl
from demlaws.lammps.run import HEAD

BOX = """\
boundary        f f f
newton          on
region          box block -0.1 0.1 -0.03 0.03 -0.03 0.03 units box
create_box      1 box
"""
GRAINS = """\
fix             grain all property/atom mol ghost yes
create_atoms    1 single -0.0180 0 0 units box
create_atoms    1 single -0.0130 0.002 0 units box
create_atoms    1 single 0.004287 0 0 units box
create_atoms    1 single 0.009287 -0.002 0.001 units box
set             group all diameter 17.4e-3 density 2650
set             atom 1*2 mol 1
set             atom 3*4 mol 2
group           left id 1 2
velocity        all set {drift} 0 0
velocity        left set {toward} 0 0
"""
RUN = """\
pair_style      granular
pair_coeff      * * demlaws/table law.tbl 60.6e9 1.0 0.25 {shear}
neighbor        1e-3 bin
neigh_modify    delay 0 exclude molecule/intra all
timestep        2e-7
fix             move all rigid/small molecule
variable        bent equal x[1]-x[3]+2*(y[2]-y[4])+3*(z[1]-z[3])
thermo_style    custom step v_bent
thermo_modify   format float %.17e lost ignore norm no
thermo          50
"""


def whole(drift=0.0):
    return HEAD + BOX + GRAINS.format(drift=drift, toward=drift + 0.1) + RUN.format(shear=SHEAR)


@pytest.fixture
def folder(tmp_path, granite_pair):
    for rule in ("hertz", "elastic"):
        law = dl.law("pohrt-popov", granite_pair.with_values(modulus=modulus()), unloading=rule)
        save(law, tmp_path / f"{rule}.tbl", rtol=1e-8)
    shutil.copy(tmp_path / "hertz.tbl", tmp_path / "law.tbl")
    return tmp_path


def test_the_history_of_clumps_survives_ranks_migration_and_restart(folder):
    """A restart while the clumps push each other apart, and clumps in contact that cross the border of two ranks: one path."""
    one = simulate(folder, whole() + "run 450\nwrite_restart now.restart\nrun 1200\n")["bent"]
    grains = "comm_modify vel yes\nread_restart now.restart\nfix grain all property/atom mol ghost yes\n"
    again = simulate(folder, grains + RUN.format(shear=SHEAR) + "run 1200\n")["bent"]
    approach, moved = abs(one[0] - one[5]), np.ptp(one[-len(again) :])
    assert 0.1 * approach < moved  # they part
    assert np.abs(again - one[-len(again) :]).max() <= 1e-9 * moved
    moving = simulate(folder, whole(-60.0) + "run 1800\n")["bent"]
    shared = simulate(folder, whole(-60.0) + "run 1800\n", ranks=2)["bent"]
    assert np.abs(shared - moving).max() <= 1e-7 * moved
    shutil.copy(folder / "elastic.tbl", folder / "law.tbl")  # without the history another path
    elastic = simulate(folder, whole() + "run 1650\n")["bent"]
    assert abs(elastic[-1] - one[-1]) > 0.05 * moved
