"""compute demlaws/energy in LIGGGHTS and LAMMPS: contacts that overlap from the start, on ranks; particles deleted beside."""

import inputs_for_lammps
import numpy as np
import pytest
from inputs import ENERGY, LOAD_UNLOAD, modulus, part, simulate
from inputs_for_liggghts import properties
from spheres import both, save_law, spheres

import demlaws as dl
from demlaws.errors import EngineStopped

CONTACT = dl.Contact(radius=4e-3, modulus=modulus(), sigma=2.4e-6, fractal_dimension=2.22)
# three spheres of 8 mm in a row along x that overlap, the second one with a wall
ROW = """\
{boundary}
processors {ranks} 1 1
region box block -0.001 0.03 -0.01 0.01 -0.01 0.01 units box
create_box 2 box
neighbor 1e-3 bin
neigh_modify delay 0
{style}
timestep 1e-8
create_atoms 1 single 0.011988 0 0 units box
create_atoms 1 single 0.003995 0 0 units box
create_atoms 2 single 0.019985 0 0 units box
set group all diameter 0.008 density 2650
{watch}
"""
WATCH = """\
fix move all {mover}
fix w all wall/gran {wall}
compute e all demlaws/energy
thermo_style custom step atoms ke c_e[1] c_e[2] {columns}
thermo_modify format float %.17e lost ignore norm no
thermo 500
"""
LAMMPS = inputs_for_lammps.TABLE.replace("1.0 0.5", "0.0 0.0")
SEEN = "compute c all pair/local p14 p15 p16\ncompute p all reduce sum c_c[*] inputs local\n"


def row(engine, ranks=1, mover="nve/sphere"):
    """The scene, and what watches it, which goes on from a restart file of LAMMPS, too."""
    if engine == "lammps":
        style = f"pair_style granular\npair_coeff * * {LAMMPS}"
        watch = SEEN + WATCH.format(mover=mover, wall=f"granular {LAMMPS} xplane 0 NULL", columns="c_p[1] c_p[2] c_p[3]")
    else:
        model = "model demlaws/table tangential history"
        style = f"{properties(2, friction=0.0)}\npair_style gran {model} table law.tbl\npair_coeff * *"
        watch = WATCH.format(mover=mover, wall=f"{model} primitive type 1 xplane 0.0", columns="")
    # newton off: both ranks compute the pair on their border
    boundary = f"boundary f f f\nnewton {'on' if ranks == 1 else 'off'}" if engine == "lammps" else ""
    return part(engine, "run").HEAD + ROW.format(boundary=boundary, ranks=ranks, style=style, watch=watch), watch


def laws(unloading, folder):
    """The laws of two grains and of a grain and the wall, one table for both."""
    pair = dl.law("pohrt-popov", CONTACT.with_values(radius=2e-3), unloading=unloading)
    wall = dl.law("pohrt-popov", CONTACT, unloading=unloading)
    wall.tabulate(rtol=1e-8).save(folder / "law.tbl")
    return pair, wall


@pytest.mark.parametrize(("unloading", "ranks"), [("elastic", 1), ("hertz", 1), ("hertz", 2)])
@both
def test_energies_of_contacts_that_overlap_from_the_start(engine, tmp_path, unloading, ranks):
    """What the law stores there, before the first step, too; when they have opened, what plastic flow took stays."""
    pair, wall = laws(unloading, tmp_path)
    scene, watch = row(engine, ranks)
    shown = watch[watch.index("thermo_style") :]  # by the second run alone, which sets up the same step again
    log = simulate(engine, tmp_path, f"{scene}thermo_style custom step\nrun 0\n{shown}run 20000\n", ranks)
    at_wall, *pairs = (law.follow(np.array([overlap])) for law, overlap in ((wall, 5e-6), (pair, 7e-6), (pair, 3e-6)))
    for column, name in enumerate(("stored", "dissipated"), 1):
        expected = sum(float(getattr(path, name)[0]) for path in (at_wall, *pairs))
        assert log[f"e[{column}]"][0] == pytest.approx(expected, rel=1e-6), name
    if engine == "lammps":
        for column, name in enumerate(("plastic_overlap", "stored", "dissipated"), 1):
            assert log[f"p[{column}]"][0] == pytest.approx(sum(float(getattr(p, name)[0]) for p in pairs), rel=1e-6)
    total = log["KinEng"] + log["e[1]"] + log["e[2]"]
    assert np.ptp(total) <= 1e-4 * total[0]
    assert log["e[1]"][-1] == 0 and log["e[2]"][-1] >= log["e[2]"][0]


@pytest.mark.parametrize(
    ("name", "words", "moves"),
    [("rough", "", LOAD_UNLOAD), ("rough elastic", "shear elastic", [(-0.2, 0, 600), (0, 0.05, 300), (40, 0, 40)])],
)
@both
def test_what_was_dissipated_stays_when_lists_are_built_in_every_step(engine, tmp_path, name, words, moves):
    """LIGGGHTS drops the history of a contact that opens in such a step: plastic flow, and what its shear had stored."""
    save_law(tmp_path, name)
    text = spheres(engine, words, moves, **ENERGY)
    if engine == "liggghts" and not words:  # the normal model alone
        text = text.replace("tangential demlaws", "tangential off")
    often = text.replace("neigh_modify    delay 0", "neigh_modify    every 1 delay 0 check no")
    rarely, always = (simulate(engine, tmp_path, one)["e[2]"] for one in (text, often))
    assert rarely[-1] > 0.0 and always == pytest.approx(rarely, rel=1e-9)


@pytest.mark.parametrize("ranks", [1, 2])
@both
def test_deleted_particles_take_no_other_contacts_history(engine, tmp_path, ranks):
    """delete_atoms deals new numbers unless told not to, by which the engines would find other histories."""
    pair, _ = laws("hertz", tmp_path)
    scene, watch = row(engine, ranks, "nve/noforce")
    groups = "group one id 2\ngroup last id 3\n"
    moves = "velocity last set -1 0 0\nrun 100\nvelocity last set 1 0 0\nrun 200\nvelocity last set 0 0 0\nrun 1\n"
    path, virgin = (pair.follow(np.array(overlaps)) for overlaps in ([3e-6, 4e-6, 2e-6], [2e-6]))
    assert path.stored[-1] < 0.9 * virgin.stored[-1]
    deleted = "delete_atoms group one compress no\nrun 1\nwrite_restart now.restart\n"
    log = simulate(engine, tmp_path, scene + groups + moves + deleted, ranks)
    assert log["Atoms"][-1] == 2 and log["e[1]"][-1] == pytest.approx(path.stored[-1], rel=1e-6)
    assert log["e[2]"][-1] < log["e[2]"][-2]  # contacts of the deleted particle are gone with it
    new_numbers = ["delete_atoms group one compress yes"] + ["reset_atoms id sort yes"] * (engine == "lammps")
    for renumber in new_numbers:
        with pytest.raises(EngineStopped):
            simulate(engine, tmp_path, scene + groups + moves + f"{renumber}\nrun 1\n", ranks)
    if engine == "lammps":
        again = "comm_modify vel yes\nread_restart now.restart\nneighbor 1e-3 bin\ntimestep 1e-8\n" + watch
        with pytest.raises(EngineStopped):  # before the restart file's histories are given out
            simulate(engine, tmp_path, again + "reset_atoms id sort yes\nrun 1\n")
        apart = scene.replace("0.011988", "0.0121").replace("0.003995", "0.0041").replace("0.019985", "0.0201")
        simulate(engine, tmp_path, apart + groups + f"{renumber}\nrun 1\n", ranks)  # there are no contacts yet
