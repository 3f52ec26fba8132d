"""compute demlaws/energy at step 0, by group, across ranks; contacts keep their history when particles are deleted."""

import numpy as np
import pytest
from inputs_for_liggghts import again, modulus, simulate

import demlaws as dl
from demlaws.liggghts.run import HEAD

pytestmark = pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")

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
fix m1 all property/global youngsModulus peratomtype 60.6e9 60.6e9
fix m2 all property/global poissonsRatio peratomtype 0.25 0.25
fix m3 all property/global coefficientRestitution peratomtypepair 2 1 1 1 1
fix m4 all property/global coefficientFriction peratomtypepair 2 0 0 0 0
pair_style gran model demlaws/table tangential history table law.tbl
pair_coeff * *
timestep 1e-8
create_atoms 1 single 0.003995 0 0 units box
create_atoms 1 single 0.011988 0 0 units box
create_atoms 2 single 0.019985 0 0 units box
set group all diameter 0.008 density 2650
group one id 1
group rest id 2 3
fix move all nve/sphere
fix w all wall/gran model demlaws/table tangential history primitive type 1 xplane 0.0
compute e all demlaws/energy
compute a one demlaws/energy
compute b rest demlaws/energy
thermo_style custom step ke c_e[1] c_e[2] c_a[1] c_a[2] c_b[1] c_b[2]
thermo_modify format float %.17e lost ignore norm no
thermo 500
"""
)


def laws(unloading, folder):
    """The laws of two grains and of a grain and the wall, one table for both."""
    pair = dl.law("pohrt-popov", CONTACT.with_values(radius=2e-3), unloading=unloading)
    wall = dl.law("pohrt-popov", CONTACT, unloading=unloading)
    wall.tabulate(rtol=1e-8).save(folder / "law.tbl")
    return pair, wall


@pytest.mark.parametrize("ranks", [1, 2])
@pytest.mark.parametrize("unloading", ["elastic", "hertz"])
def test_energies_of_virgin_contacts_at_step_0(tmp_path, unloading, ranks):
    """Contacts that overlap from the start hold what the law stores there; a grain has half of a pair, all of a wall."""
    pair, wall = laws(unloading, tmp_path)
    log = simulate(tmp_path, ROW.format(processors=f"processors {ranks} 1 1") + "run 2000\n", ranks)
    paths = [law.follow(np.array([overlap])) for law, overlap in ((wall, 5e-6), (pair, 7e-6), (pair, 3e-6))]
    for column, name in enumerate(("stored", "dissipated"), 1):
        w, first, second = (float(getattr(path, name)[0]) for path in paths)
        tolerance = 1e-7 * max(w, first, second) + 1e-30
        assert abs(log[f"e[{column}]"][0] - (w + first + second)) <= tolerance, name
        assert abs(log[f"a[{column}]"][0] - (w + first / 2)) <= tolerance
        assert abs(log[f"b[{column}]"][0] - (first / 2 + second)) <= tolerance
        assert np.abs(log[f"a[{column}]"] + log[f"b[{column}]"] - log[f"e[{column}]"]).max() <= tolerance
    total = log["KinEng"] + log["e[1]"] + log["e[2]"]
    assert np.ptp(total) <= 1e-4 * total[0]
    assert log["e[1]"][-1] < 0.8 * log["e[1]"][0]  # they have sprung apart


def test_the_group_keeps_what_ended_contacts_took(tmp_path):
    """All contacts have opened: what plastic flow took stays with the grains, through a restart file too."""
    pair, wall = laws("hertz", tmp_path)
    text = ROW.format(processors="")
    log = simulate(tmp_path, text + "run 20000\nwrite_restart now.restart\nrun 500\n")
    taken = [float(law.follow(np.array([d])).dissipated[0]) for law, d in ((wall, 5e-6), (pair, 7e-6), (pair, 3e-6))]
    assert log["e[1]"][-1] == 0
    # what the first step found, and a little more: the blow of one presses the others further
    assert 1 < log["a[2]"][-1] / (taken[0] + taken[1] / 2) < 1.5
    assert 1 < log["b[2]"][-1] / (taken[1] / 2 + taken[2]) < 1.5
    assert log["a[2]"][-1] + log["b[2]"][-1] == pytest.approx(log["e[2]"][-1], rel=1e-12)
    after = simulate(tmp_path, again(text) + "run 500\n")
    for name in ("e[2]", "a[2]", "b[2]"):
        assert after[name][0] == pytest.approx(log[name][-1], rel=1e-12)


# --- particles deleted

HEAP = (
    HEAD.replace("f f f", "p p f")
    + """\
processors {ranks} 1 1
region box block 0 0.048 0 0.024 -0.001 0.06 units box
create_box 1 box
region fill block 0 0.048 0 0.024 0.0 0.06 units box
neighbor 1e-3 bin
neigh_modify delay 0
fix m1 all property/global youngsModulus peratomtype 60.6e8
fix m2 all property/global poissonsRatio peratomtype 0.25
fix m3 all property/global coefficientRestitution peratomtypepair 1 0.3
fix m4 all property/global coefficientFriction peratomtypepair 1 0.3
pair_style gran model demlaws/table tangential history table law.tbl
pair_coeff * *
timestep 1e-6
fix w all wall/gran model demlaws/table tangential history primitive type 1 zplane 0.0
fix t1 all particletemplate/sphere 15485863 atom_type 1 density constant 2650 radius constant 0.004
fix d1 all particledistribution/discrete/numberbased 86028121 1 t1 1.0
fix i1 all insert/pack seed 86028157 distributiontemplate d1 vel constant 0 0 -0.3 insert_every once &
    overlapcheck yes all_in yes particles_in_region 60 region fill
fix g all gravity 98.1 vector 0 0 -1
fix move all nve/sphere
compute e all demlaws/energy
thermo_style custom step atoms ke c_e[1] c_e[2]
thermo_modify format float %.15e lost ignore norm no
thermo 1000
run 24000
region top block INF INF INF INF 0.02 INF units box
delete_atoms region top compress {compress}
run 1
"""
)


@pytest.mark.parametrize("ranks", [1, 2])
def test_deleted_particles_take_no_other_contacts_history(tmp_path, ranks):
    """delete_atoms deals new numbers unless told not to; the energies of what stays are the same either way."""
    law = dl.law("pohrt-popov", CONTACT.with_values(modulus=modulus() / 10), unloading="hertz")
    law.tabulate().save(tmp_path / "law.tbl")
    found = {}
    for compress in ("no", "yes"):
        log = simulate(tmp_path, HEAP.format(ranks=ranks, compress=compress), ranks)
        found[compress] = np.array([log[name][-1] for name in ("Atoms", "e[1]", "e[2]")])
    before = log["e[2]"][-2]
    assert 10 < found["no"][0] < 55
    assert found["no"][2] < before  # contacts of deleted particles are gone with them
    assert np.abs(found["yes"] / found["no"] - 1).max() <= 1e-6
