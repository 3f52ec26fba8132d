"""Tangential model demlaws: force and energy against Python along a path; no energy from nothing; ranks and restart."""

import numpy as np
import pytest
from inputs_for_liggghts import modulus, two_spheres

import demlaws as dl
from demlaws.liggghts import run
from demlaws.shear import sheared

pytestmark = [pytest.mark.liggghts, pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")]
CONTACT = dl.Contact(radius=4.35e-3, modulus=modulus(), roughness=2.4e-6, fractal_dimension=2.22)
LAWS = {"hertz elastic": ("hertz", "elastic"), "rough elastic": ("pohrt-popov", "elastic"), "rough": ("pohrt-popov", "hertz")}
RATIO, DIAMETER = 2 * (1 - 0.25) / (2 - 0.25), 17.4e-3
# 64 spheres in a closed box, no damping
GAS = """\
atom_style granular
atom_modify map array
boundary f f f
newton off
communicate single vel yes
units si
hard_particles yes
processors {ranks} 1 1
region box block -0.001 0.081 -0.001 0.081 -0.001 0.081 units box
create_box 1 box
{common}{places}
set group all diameter 0.0174 density 2650
{velocities}
"""
COMMON = """\
neighbor 0.002 bin
neigh_modify delay 0 page 200000
fix m1 all property/global youngsModulus peratomtype 60.6e9
fix m2 all property/global poissonsRatio peratomtype {poisson}
fix m3 all property/global coefficientRestitution peratomtypepair 1 1.0
fix m4 all property/global coefficientFriction peratomtypepair 1 {friction}
pair_style gran model demlaws/table tangential demlaws table law.tbl shear {shear}
pair_coeff * *
timestep 2e-7
{walls}fix integr all nve/sphere
compute er all erotate/sphere
compute en all demlaws/energy
variable spin equal c_er
variable x1 equal x[1]
variable w1 equal omegaz[1]
thermo_style custom step ke v_spin c_en[1] c_en[2] v_x1
thermo_modify norm no lost error format float %.17e
"""


def inputs(friction, shear, poisson=0.25, ranks=1):
    """The gas's settings, and its whole start."""
    walls = "".join(
        f"fix {a}{i} all wall/gran model demlaws/table tangential demlaws primitive type 1 {a}plane {p}\n"
        for a in "xyz"
        for i, p in (("l", 0.0), ("h", 0.08))
    )
    # one by one: `create_atoms region` gives other numbers on two ranks
    places = "\n".join(
        f"create_atoms 1 single {x:.2f} {y:.2f} {z:.2f} units box" for x, y, z in 0.01 + 0.02 * np.argwhere(np.ones((4, 4, 4)))
    )
    random = np.random.default_rng(3)
    velocities = "\n".join(
        f"set atom {i + 1} vx {v[0]:.6f} vy {v[1]:.6f} vz {v[2]:.6f}" for i, v in enumerate(random.normal(0, 0.3, (64, 3)))
    )
    common = COMMON.format(friction=friction, shear=shear, poisson=poisson, walls=walls)
    return common, GAS.format(common=common, places=places, velocities=velocities, ranks=ranks)


def simulate(folder, text, ranks=1):
    (folder / "in.case").write_text(text)
    return run(folder / "in.case", ranks)


def save(folder, name):
    law = dl.law(LAWS[name][0], CONTACT, LAWS[name][1])
    law.tabulate(rtol=1e-6, max_force=3e4).save(folder / "law.tbl")
    return law


@pytest.mark.parametrize("shear", ["elastic", "loading", "slip", "slip springs 30"])
@pytest.mark.parametrize("name", LAWS)
def test_force_along_a_path_is_pythons(tmp_path, name, shear):
    """Press, slide partly, press on, lift off partly, slide back past Coulomb's limit, press, slide."""
    law = save(tmp_path, name)
    moves = [(-0.2, 0, 3000), (0, 0.05, 1500), (-0.2, 0.02, 1500), (0.2, 0.03, 1800), (0, -0.08, 4000), (-0.2, 0, 1000)]
    style = f"neigh_modify page 400000\npair_style gran model demlaws/table tangential demlaws table law.tbl shear {shear}"
    log = simulate(tmp_path, two_spheres(style, moves, every=10))
    across = np.concatenate([[0.0], *[np.full(steps // 10, speed * 1e-7) for _, speed, steps in moves]]).cumsum()
    kept = np.append(np.diff(log["Step"]) > 0, True)  # each run begins with the last line of the one before
    word = shear.split()[0]
    path = sheared(law, log["overlap"][kept], across, RATIO, word, 0.5, 2000)
    turned = path.force * across / DIAMETER  # the normal turns
    found = turned - log["side"][kept]
    tolerance = {"elastic": 3e-3, "loading": 3e-3, "slip": 2e-2, "slip springs 30": 5e-3}[shear]
    np.testing.assert_allclose(found, path.shear_force, atol=tolerance * 0.5 * path.force.max())


@pytest.mark.parametrize("shear", ["elastic", "slip"])
def test_a_contact_that_carried_no_force_has_lost_its_shear(tmp_path, shear):
    """Press, slide, lift off below the plastic overlap without parting, press again: no shear force is left."""
    law = save(tmp_path, "rough")
    plastic = law.follow([5.9e-6]).plastic_overlap[-1]
    assert plastic > 1e-6
    up = round((5.9e-6 - 0.5 * plastic) / 2e-9)
    moves = [(-0.2, 0, 3000), (0, 0.02, 500), (0.2, 0, up), (-0.2, 0, up)]
    style = f"pair_style gran model demlaws/table tangential demlaws table law.tbl shear {shear}"
    log = simulate(tmp_path, two_spheres(style, moves, every=10))
    sheared_force, left = np.abs(log["side"]).max(), log["side"][-1]
    assert log["overlap"].min() < 0.6 * plastic and log["force"][-1] > 1.0
    assert abs(left - log["force"][-1] * 1e-7 / DIAMETER) < 1e-3 * sheared_force


@pytest.mark.parametrize(
    ("name", "shear", "friction", "poisson"),
    [
        ("hertz elastic", "elastic", 100, 0.25),
        ("rough elastic", "elastic", 100, 0.0),
        ("rough", "elastic", 100, 0.25),
        ("rough", "loading", 100, 0.4),
        ("rough elastic", "slip", 100, 0.25),
        ("rough", "slip", 0.3, 0.25),
        ("rough", "elastic", 0.3, 0.1),
    ],
)
def test_a_gas_gains_no_energy(tmp_path, name, shear, friction, poisson):
    """`tangential history` doubles this energy with rough elastic contacts. The losses are in the balance."""
    save(tmp_path, name)
    log = simulate(tmp_path, inputs(friction, shear, poisson)[1] + "thermo 5000\nrun 100000\n")
    kept = log["KinEng"] + log["spin"] + log["en[1]"]
    assert kept.max() <= 1.001 * kept[0]
    assert kept[-1] < 0.9 * kept[0]
    np.testing.assert_allclose(kept + log["en[2]"], kept[0], rtol=1e-3)


@pytest.mark.parametrize("shear", ["elastic", "slip"])
def test_ranks_and_restart_change_nothing(tmp_path, shear):
    save(tmp_path, "rough")
    common, start = inputs(0.5, shear)
    one = simulate(tmp_path, start + "run 12000\nwrite_restart half.rst\nrun 12000\n")
    two = simulate(tmp_path, inputs(0.5, shear, ranks=2)[1] + "run 24000\n", 2)
    settings = "atom_modify map array\nnewton off\ncommunicate single vel yes\nhard_particles yes\n"
    again = simulate(tmp_path, f"{settings}read_restart half.rst\n{common}run 12000\n")
    for log in (two, again):
        for name in ("KinEng", "en[1]", "en[2]", "x1"):
            assert log[name][-1] == pytest.approx(one[name][-1], rel=1e-7), name
