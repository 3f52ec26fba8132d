"""Clumps in LIGGGHTS (fix multisphere) and LAMMPS (fix rigid/small): the history of their contacts over ranks and restart."""

import shutil

import inputs_for_lammps
import inputs_for_liggghts
import numpy as np
import pytest
from inputs import modulus, part, save, simulate
from spheres import both

import demlaws as dl

# two clumps of two spheres run into each other
LAMMPS_GRAINS = """\
boundary        f f f
newton          on
region          box block -0.1 0.1 -0.03 0.03 -0.03 0.03 units box
create_box      1 box
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
LAMMPS_RUN = f"""\
pair_style      granular
pair_coeff      * * {inputs_for_lammps.TABLE}
neighbor        1e-3 bin
neigh_modify    delay 0 exclude molecule/intra all
timestep        2e-7
fix             move all rigid/small molecule
variable        seen equal x[1]-x[3]+2*(y[2]-y[4])+3*(z[1]-z[3])
thermo_style    custom step v_seen
thermo_modify   format float %.17e lost ignore norm no
thermo          50
"""
# clumps under strong gravity bounce on a floor and roll across the border of two ranks
LIGGGHTS_RUN = f"""\
neighbor        1e-3 bin
neigh_modify    delay 0
{inputs_for_liggghts.properties()}
pair_style      gran model demlaws/table tangential history table law.tbl
pair_coeff      * *
timestep        2e-7
fix             floor all wall/gran model demlaws/table tangential history primitive type 1 zplane 0.0
fix             stone all particletemplate/multisphere 15485863 atom_type 1 density constant 2650 nspheres 2 ntry 100000 &
                spheres file stone.txt scale 1 type 1
fix             mix all particledistribution/discrete 15485867 1 stone 1.0
{{insert}}
fix             pull all gravity 2000 vector 0 0 -1
fix             move all multisphere allow_group_and_set yes
variable        seen equal xcm(all,z)+2*vcm(all,z)*1e-3+vcm(all,y)*1e-3
region          half block -0.1 0.0 -0.05 0.05 -0.001 0.08 units box
variable        left equal count(all,half)
thermo_style    custom step v_seen v_left
thermo_modify   format float %.17e lost ignore norm no
thermo          100
"""
LIGGGHTS_BOX = "region box block -0.1 0.1 -0.05 0.05 -0.001 0.08 units box\ncreate_box 1 box\n"
INSERT = """\
region          spot block -0.05 0.0 -0.02 0.02 0.0 0.026 units box
fix             fall all insert/pack seed 32452843 distributiontemplate mix vel constant 10 0 -1.0 &
                insert_every once overlapcheck yes all_in yes particles_in_region 3 region spot
"""


@pytest.fixture
def folder(tmp_path, granite_pair):
    for rule in ("hertz", "elastic"):
        law = dl.law("pohrt-popov", granite_pair.with_values(modulus=modulus()), unloading=rule)
        save(law, tmp_path / f"{rule}.tbl", rtol=1e-8)
    shutil.copy(tmp_path / "hertz.tbl", tmp_path / "law.tbl")
    (tmp_path / "stone.txt").write_text("-0.003 0 0 0.0087\n0.003 0 0 0.0087\n")
    return tmp_path


def start(engine, drift=0.0):
    if engine == "lammps":
        text = LAMMPS_GRAINS.format(drift=drift, toward=drift + 0.1) + LAMMPS_RUN
    else:
        text = "processors 1 1 1\n" + LIGGGHTS_BOX + LIGGGHTS_RUN.format(insert=INSERT)
    return part(engine, "run").HEAD + text


@both
def test_the_history_of_clumps_survives_a_restart(engine, folder):
    """Written while clumps push each other apart; in LIGGGHTS on two ranks, too, whose border they cross later."""
    before, after, effect = {"lammps": (450, 1200, 0.05), "liggghts": (6000, 18000, 1e-4)}[engine]
    log = simulate(engine, folder, start(engine) + f"run {before}\nwrite_restart now.restart\nrun {after}\n")
    for ranks in {"lammps": (1,), "liggghts": (1, 2)}[engine]:
        head = f"{part(engine, 'run').HEAD}processors {ranks} 1 1\nread_restart now.restart\n"
        if engine == "lammps":
            again = head + "fix grain all property/atom mol ghost yes\n" + LAMMPS_RUN
        else:
            again = head + LIGGGHTS_RUN.format(insert="")
        path = simulate(engine, folder, again + f"run {after}\n", ranks)["seen"]
        later = log["seen"][-len(path) :]
        moved = np.ptp(later)
        assert np.abs(path - later).max() <= 1e-9 * moved
    if engine == "lammps":
        assert moved > 0.1 * abs(log["seen"][0] - log["seen"][5])  # they part
    else:
        assert log["left"][-len(path)] > log["left"][-1]  # members cross the border after the restart
    shutil.copy(folder / "elastic.tbl", folder / "law.tbl")  # without the history another path
    elastic = simulate(engine, folder, start(engine) + f"run {before + after}\n")["seen"]
    assert abs(elastic[-1] - log["seen"][-1]) > effect * moved


@pytest.mark.parametrize("engine", ["lammps"])
def test_the_history_of_clumps_survives_migration(engine, folder):
    """Clumps in contact cross the border of two ranks."""
    moving, shared = (simulate(engine, folder, start(engine, -60.0) + "run 1800\n", ranks)["seen"] for ranks in (1, 2))
    assert np.abs(shared - moving).max() <= 1e-7 * np.ptp(moving)
