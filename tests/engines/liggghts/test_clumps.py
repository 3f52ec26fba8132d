"""Clumps in LIGGGHTS (fix multisphere): the history of their contacts over ranks, migration and restart."""

import shutil

import numpy as np
from inputs import modulus
from inputs_for_liggghts import properties, simulate

import demlaws as dl
from demlaws.liggghts.run import HEAD

BOX = """\
region          box block -0.1 0.1 -0.05 0.05 -0.001 0.08 units box
create_box      1 box
"""
COMMON = """\
neighbor        1e-3 bin
neigh_modify    delay 0
{properties}
pair_style      gran model demlaws/table tangential history table law.tbl
pair_coeff      * *
timestep        2e-7
fix             floor all wall/gran model demlaws/table tangential history primitive type 1 zplane 0.0
fix             stone all particletemplate/multisphere 15485863 atom_type 1 density constant 2650 nspheres 2 ntry 100000 &
                spheres file stone.txt scale 1 type 1
fix             mix all particledistribution/discrete 15485867 1 stone 1.0
{insert}
fix             pull all gravity 2000 vector 0 0 -1
fix             move all multisphere allow_group_and_set yes
variable        height equal xcm(all,z)+2*vcm(all,z)*1e-3+vcm(all,y)*1e-3
region          half block -0.1 0.0 -0.05 0.05 -0.001 0.08 units box
variable        left equal count(all,half)
thermo_style    custom step atoms v_height v_left
thermo_modify   format float %.17e lost ignore norm no
thermo          100
"""
INSERT = """\
region          spot block -0.05 0.0 -0.02 0.02 0.0 0.026 units box
fix             fall all insert/pack seed 32452843 distributiontemplate mix vel constant 10 0 -1.0 &
                insert_every once overlapcheck yes all_in yes particles_in_region 3 region spot
"""


def test_the_history_of_clumps_survives_ranks_migration_and_restart(tmp_path, granite_pair):
    """Clumps under strong gravity bounce on a floor and roll across the border of two ranks, each contact with its history."""
    for rule in ("hertz", "elastic"):
        law = dl.law("pohrt-popov", granite_pair.with_values(modulus=modulus()), unloading=rule)
        law.tabulate(rtol=1e-8).save(tmp_path / f"{rule}.tbl")
    shutil.copy(tmp_path / "hertz.tbl", tmp_path / "law.tbl")
    (tmp_path / "stone.txt").write_text("-0.003 0 0 0.0087\n0.003 0 0 0.0087\n")
    start = HEAD + "processors 1 1 1\n" + BOX + COMMON.format(insert=INSERT, properties=properties())
    whole = simulate(tmp_path, start + "run 6000\nwrite_restart now.restart\nrun 18000\n", 1)
    left, whole = whole["left"], whole["height"]
    again = "read_restart now.restart\n" + COMMON.format(insert="", properties=properties()) + "run 18000\n"
    paths = [simulate(tmp_path, HEAD + f"processors {ranks} 1 1\n" + again, ranks)["height"] for ranks in (1, 2)]
    later = whole[-len(paths[0]) :]
    moved = np.ptp(later)
    assert left[-len(later)] > left[-1]  # members that cross the border after the restart
    for path in paths:
        assert np.abs(path - later).max() <= 1e-9 * moved
    shutil.copy(tmp_path / "elastic.tbl", tmp_path / "law.tbl")  # without history another path
    elastic = simulate(tmp_path, start + "run 24000\n", 1)["height"]
    assert abs(elastic[-1] - whole[-1]) > 1e-4 * moved
