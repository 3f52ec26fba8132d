"""compute demlaws/energy at step 0, across ranks, through a restart; particles deleted."""

import numpy as np
import pytest
from inputs import modulus
from inputs_for_liggghts import again, properties, simulate

import demlaws as dl
from demlaws.errors import EngineStopped
from demlaws.liggghts.run import HEAD

CONTACT = dl.Contact(radius=4e-3, modulus=modulus(), roughness=2.4e-6, fractal_dimension=2.22)
# three spheres of 8 mm in a row along x that overlap, the first with a wall
ROW = (
    HEAD
    + """\
{processors}
region box block 0 0.03 -0.01 0.01 -0.01 0.01 units box
create_box 2 box
neighbor 1e-3 bin
neigh_modify delay 0
{properties}
pair_style gran model demlaws/table tangential history table law.tbl
pair_coeff * *
timestep 1e-8
create_atoms 1 single 0.003995 0 0 units box
create_atoms 1 single 0.011988 0 0 units box
create_atoms 2 single 0.019985 0 0 units box
set group all diameter 0.008 density 2650
fix move all nve/sphere
fix w all wall/gran model demlaws/table tangential history primitive type 1 xplane 0.0
compute e all demlaws/energy
thermo_style custom step ke c_e[1] c_e[2]
thermo_modify format float %.17e lost ignore norm no
thermo 500
"""
)


def row(processors=""):
    return ROW.format(processors=processors, properties=properties(2, friction=0.0))


def laws(unloading, folder):
    """The laws of two grains and of a grain and the wall, one table for both."""
    pair = dl.law("pohrt-popov", CONTACT.with_values(radius=2e-3), unloading=unloading)
    wall = dl.law("pohrt-popov", CONTACT, unloading=unloading)
    wall.tabulate(rtol=1e-8).save(folder / "law.tbl")
    return pair, wall


@pytest.mark.parametrize("ranks", [1, 2])
@pytest.mark.parametrize("unloading", ["elastic", "hertz"])
def test_energies_of_virgin_contacts_at_step_0(tmp_path, unloading, ranks):
    """Contacts that overlap from the start hold what the law stores there."""
    pair, wall = laws(unloading, tmp_path)
    log = simulate(tmp_path, row(f"processors {ranks} 1 1") + "run 2000\n", ranks)
    paths = [law.follow(np.array([overlap])) for law, overlap in ((wall, 5e-6), (pair, 7e-6), (pair, 3e-6))]
    for column, name in enumerate(("stored", "dissipated"), 1):
        w, first, second = (float(getattr(path, name)[0]) for path in paths)
        tolerance = 1e-7 * max(w, first, second) + 1e-30
        assert abs(log[f"e[{column}]"][0] - (w + first + second)) <= tolerance, name
    total = log["KinEng"] + log["e[1]"] + log["e[2]"]
    assert np.ptp(total) <= 1e-4 * total[0]
    assert log["e[1]"][-1] < 0.8 * log["e[1]"][0]  # they have sprung apart


def test_what_ended_contacts_took(tmp_path):
    """All contacts have opened: what plastic flow took stays in the sum, through a restart file too."""
    pair, wall = laws("hertz", tmp_path)
    text = row()
    log = simulate(tmp_path, text + "run 20000\nwrite_restart now.restart\nrun 500\n")
    taken = [float(law.follow(np.array([d])).dissipated[0]) for law, d in ((wall, 5e-6), (pair, 7e-6), (pair, 3e-6))]
    assert log["e[1]"][-1] == 0
    # what the first step found, and a little more: the blow of one presses the others further
    assert 1 < log["e[2]"][-1] / sum(taken) < 1.5
    after = simulate(tmp_path, again(text) + "run 500\n")
    assert after["e[2]"][0] == pytest.approx(log["e[2]"][-1], rel=1e-12)
    with pytest.raises(EngineStopped):  # of all contacts only
        simulate(tmp_path, text.replace("compute e all", "group one id 1\ncompute e one") + "run 1\n")


@pytest.mark.parametrize("ranks", [1, 2])
def test_deleted_particles_take_no_other_contacts_history(tmp_path, ranks):
    """delete_atoms deals new numbers unless told not to, by which LIGGGHTS would find other histories."""
    pair, _ = laws("hertz", tmp_path)
    moves = "group one id 1\ngroup last id 3\nvelocity last set -1 0 0\nrun 100\nvelocity last set 1 0 0\nrun 200\n"
    text = row(f"processors {ranks} 1 1").replace("nve/sphere", "nve/noforce") + moves + "velocity last set 0 0 0\n"
    path, virgin = (pair.follow(np.array(overlaps)) for overlaps in ([3e-6, 4e-6, 2e-6], [2e-6]))
    assert path.stored[-1] < 0.9 * virgin.stored[-1]
    log = simulate(tmp_path, text + "delete_atoms group one compress no\nrun 1\n", ranks)
    assert log["e[1]"][-1] == pytest.approx(path.stored[-1], rel=1e-6)
    assert log["e[2]"][-1] < log["e[2]"][-2]  # contacts of the deleted particle are gone with it
    with pytest.raises(EngineStopped):
        simulate(tmp_path, text + "delete_atoms group one compress yes\nrun 1\n", ranks)
