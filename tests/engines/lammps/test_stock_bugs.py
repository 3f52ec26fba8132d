"""Bugs of stock LAMMPS that would make demlaws/table silently wrong: shown on a stock model, then worked round or stopped."""

import re

import numpy as np
import pytest
from inputs import LOAD_UNLOAD, error_of, moves_of
from inputs_for_lammps import HEAD, STOCK, TABLE, continued, refused, simulate, two_spheres

pytestmark = pytest.mark.releases


@pytest.mark.slow
def test_cut_off_after_a_restart(folder, monkeypatch):
    """The cut-off of the pair style is not in the restart file and its memory is left as malloc gave it: contacts get lost."""
    monkeypatch.setenv("MALLOC_PERTURB_", "200")  # glibc fills new memory: a small positive number here
    back = [(0.2, 0, 600)]
    lost = {}
    for words in (STOCK, TABLE):
        text = two_spheres(words, LOAD_UNLOAD[:1]) + "write_restart now.restart\n" + moves_of(back)
        whole, rest = simulate(folder, text), simulate(folder, continued(back))
        rows = np.isin(whole["Step"], rest["Step"])
        lost[words] = np.abs(whole["force"][rows] - rest["force"]).max() / whole["force"].max()
    assert lost[STOCK] > 0.9
    assert lost[TABLE] == 0


# two touching spheres of type 2; the second rolls, and slides through z = 0, where the pair changes its order
ROLLING = """\
boundary        f f f
newton          on
region          box block -0.03 0.03 -0.02 0.02 -0.02 0.02 units box
create_box      2 box
neighbor        1e-4 bin
neigh_modify    every 1 delay 0 check no
pair_style      granular
{lines}
timestep        1e-6
create_atoms    2 single 0 0 0 units box
create_atoms    2 single 0.01739 0 1e-6 units box
set             group all diameter 0.0174 density 2650
group           left id 1
group           right id 2
set             group right omega 0 0.1 0
fix             move all nve/noforce
compute         turn right property/atom tqy
compute         torque right reduce sum c_turn
thermo_style    custom step c_torque
thermo_modify   format float %.17e lost ignore norm no
thermo          100
velocity        right set 0 0 -0.01
run             1000
"""
STOCK_ROLL = {"normal": "hertz/material 60.6e9 1.0 0.25", "damping": "viscoelastic"}
OUR_ROLL = {"normal": "demlaws/table law.tbl 60.6e9 1.0 0.25", "damping": "demlaws/tangent"}
ROLL = "{normal} tangential linear_nohistory 0.0 0.0 rolling sds 1e5 0.0 10.0 damping {damping}"


def rolling(model, first=""):
    return HEAD + ROLLING.format(lines=f"{first}pair_coeff {'* 2' if first else '* *'} {ROLL.format(**model)}")


def straight(torque):
    """How far a torque is from growing in proportion to the time, of the largest."""
    return np.abs(torque / torque[-1] - np.linspace(0, 1, torque.size)).max()


@pytest.mark.parametrize("motion", ["rolling", "twisting"])
def test_rolling_and_twisting_where_a_pair_changes_its_order(folder, motion):
    """Stock turns the sign of the displacement then: the torque of a steady roll or twist drops to zero and grows again."""
    torques = []
    for model in STOCK_ROLL, OUR_ROLL:
        text = rolling(model).replace("rolling sds", f"{motion} sds")
        if motion == "twisting":
            text = text.replace("omega 0 0.1 0", "omega 0.1 0 0").replace("property/atom tqy", "property/atom tqx")
        torques.append(simulate(folder, text)["torque"])
    stock, ours = torques
    assert straight(stock) > 0.1
    assert straight(ours) < 1e-6 and np.abs(ours).max() > 0


def test_type_pairs_of_unlike_history(folder):
    """A line for pairs that do not even occur moves the history of the others to the wrong place; with ours it is refused."""
    rescale = "tangential mindlin_rescale NULL 1.0 0.5"
    other = f"pair_coeff 1 1 {STOCK.replace('tangential mindlin NULL 1.0 0.5', rescale)}\n"
    same = f"pair_coeff 1 1 {ROLL.format(**STOCK_ROLL)}\n"
    alone, beside = (simulate(folder, rolling(STOCK_ROLL, first))["torque"] for first in (same, other))
    assert np.abs(beside - alone).max() > 0.1 * np.abs(alone).max()
    for first in (other, f"pair_coeff 1 1 {TABLE}\n"):
        assert "different numbers of history values" in refused(folder, rolling(OUR_ROLL, first))


UNUSED = f"pair_coeff * * {STOCK} rolling sds 1e3 1.0 0.1\n"


@pytest.mark.parametrize("style", ["granular", "hybrid/overlay granular zero 0.02"])
@pytest.mark.parametrize("first", [UNUSED, f"{UNUSED}pair_coeff * * {STOCK}\n", f"{UNUSED}pair_coeff 1*2 *1 {TABLE}\n"])
def test_lines_that_later_ones_replace_for_all_their_pairs(folder, law, style, first):
    """LAMMPS deals the history for such a line, too, and keeps it in restart files: it becomes a copy of the later one."""
    words = f"{first}pair_coeff 1 * {TABLE}\npair_coeff 2* 2 {TABLE}\n"
    if style != "granular":
        words = re.sub(r"(?m)(pair_coeff \S+ \S+)", r"\1 granular", words) + "pair_coeff * * zero\n"
    text = two_spheres(words, LOAD_UNLOAD[:2]).replace("pair_style      granular", f"pair_style {style}")
    log = simulate(folder, text + "write_restart now.restart\n" + moves_of(LOAD_UNLOAD[2:]))
    assert error_of(log, law) <= 1e-7
    again = "" if style == "granular" else words  # LAMMPS keeps no coefficients of hybrid styles
    rest = simulate(folder, continued(LOAD_UNLOAD[2:], again=again))
    rows = np.isin(log["Step"], rest["Step"])
    np.testing.assert_allclose(rest["force"], log["force"][rows], rtol=0, atol=1e-12 * log["force"].max())


@pytest.mark.parametrize("lines", [f"{UNUSED}pair_coeff 1 * {TABLE}\n", f"{UNUSED}run 1\npair_coeff * * {TABLE}\n"])
def test_lines_in_use_or_whose_histories_exist_are_not_replaced(folder, lines):
    """The pair of types 2 and 2 still has the first line; histories were made in the size of another model."""
    text, late = two_spheres(lines.split("run 1")[0], [(0.2, 0, 1)]), lines.partition("run 1\n")[2]
    assert "different numbers of history values" in refused(folder, f"{text}{late}run 1\n")


def test_one_type_whose_line_is_replaced(folder, law):
    """LAMMPS deletes the models of its earlier lines at once."""
    text = two_spheres(f"{UNUSED}pair_coeff * * {STOCK}\npair_coeff * * {TABLE}\n", LOAD_UNLOAD)
    log = simulate(folder, text.replace("create_box      2", "create_box      1").replace("2 single", "1 single"))
    assert error_of(log, law) <= 1e-7


def test_the_state_is_the_same_seen_from_either_sphere(folder):
    """LAMMPS turns the sign of history values when a pair changes its order, unless a model says otherwise; ours does."""
    text = rolling(OUR_ROLL)
    more = "compute c all pair/local p13 p14 force cutoff radius\ncompute k all reduce sum c_c[1] c_c[2] c_c[3] inputs local\n"
    text = text.replace("thermo_style    custom step c_torque", more + "thermo_style custom step c_k[1] c_k[2] c_k[3]")
    text = text.replace("velocity        right set 0 0 -0.01", "velocity right set 0.002 0 -0.01")  # unloading
    log = simulate(folder, text)
    assert np.ptp(log["k[1]"][1:]) == 0 and np.ptp(log["k[2]"][1:]) == 0 and log["k[2]"][1] > 1e-6
    assert np.all(np.diff(log["k[3]"]) < 0)


def test_mixed_moduli(folder):
    """Two types of one material: stock mixing takes E* for E, so that `mindlin NULL` is too soft by about half."""
    slide = [(-0.2, 0, 1000), (0, 0.001, 20)]
    side = {}
    for words in (STOCK, TABLE):
        for lines in (f"pair_coeff * * {words}\n", f"pair_coeff 1 1 {words}\npair_coeff 2 2 {words}\n"):
            side[words, "mixed" if "2 2" in lines else "given"] = simulate(folder, two_spheres(lines, slide))["side"][-1]
    assert side[STOCK, "mixed"] / side[STOCK, "given"] == pytest.approx(0.533, abs=0.002)
    assert side[TABLE, "mixed"] / side[TABLE, "given"] == pytest.approx(1.0, abs=1e-12)


RESPA = """\
boundary        f f f
newton          off
region          box block -0.03 0.03 -0.02 0.02 -0.02 0.02
create_box      1 box
create_atoms    1 single -0.003 0 0
create_atoms    1 single 0.00299 0 0
set             group all diameter 0.006 density 2650
neighbor        1e-3 bin
pair_style      granular
pair_coeff      * * {model}
group           b id 2
velocity        b set 0 0.01 0
fix             move all nve/noforce
timestep        1e-7
run_style       {style}
compute         f all reduce max fy
thermo_style    custom step c_f
thermo          100
run             200
run             200
"""


def test_shear_under_respa(folder):
    """LAMMPS multiplies displacements by the number of inner steps: refused with a table."""
    sides = {}
    for style in ("verlet", "respa 2 4 pair 1"):
        text = HEAD + RESPA.format(model=STOCK.replace("1.0 0.5", "0.0 5.0"), style=style)
        sides["stock", style] = simulate(folder, text)["f"][-1]
    assert "run_style respa" in refused(folder, HEAD + RESPA.format(model=TABLE, style="respa 2 4 pair 1"))
    assert sides["stock", "respa 2 4 pair 1"] > 3.5 * sides["stock", "verlet"] > 0.0
