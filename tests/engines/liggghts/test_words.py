"""Words and settings of demlaws/table: what walls take over, what contradicts itself, instances, ranks, restarts."""

import shutil

import numpy as np
import pytest
from inputs import modulus
from inputs_for_liggghts import again, properties, refused, simulate

import demlaws as dl
from demlaws.liggghts.run import HEAD

GRAN = "pair_style gran model demlaws/table tangential history "
WALL = "fix floor all wall/gran model demlaws/table tangential history primitive type 1 zplane 0.0 "
PRESS = [(-0.2, 0, 3000), (0.2, 0, 2000)]
# two spheres of 8 mm, one above the other, fall on a floor
FALL = """\
{head}region box block {box} units box
create_box 2 box
neighbor {skin!r} bin
neigh_modify delay 0
{properties}
fix m9 all property/global surfaceRoughness peratomtype {rough1!r} {rough2!r}
{before}
pair_style gran model demlaws/table tangential history {words}
pair_coeff * *
timestep {step!r}
create_atoms 1 single 0 0 {low!r} units box
create_atoms 2 single 0 0 {high!r} units box
set group all diameter {diameter!r} density {density!r}
fix move all nve/sphere
velocity all set 0 0 {speed!r}
{after}
compute f all property/atom fz z
compute top all reduce max c_f[1] c_f[2]
compute low all reduce min c_f[1] c_f[2]
thermo_style custom step ke c_top[1] c_top[2] c_low[1] c_low[2]
thermo_modify format float %.15e
thermo 100
run 3000
"""


def falling(words, before="", after=WALL):
    """The input."""
    return FALL.format(
        head=HEAD, box="-0.03 0.03 -0.03 0.03 -0.03 0.04", skin=1e-4, properties=properties(2, 60.6e9, 0.8, 0.1),
        rough1=1e-6, rough2=2e-6, step=1e-8, low=0.004, high=0.0119999, diameter=0.008, density=2650.0, speed=-0.1,
        words=words, before=before, after=after,
    )  # fmt: skip


@pytest.fixture
def granite(tmp_path):
    contact = dl.Contact(radius=4e-3, modulus=modulus(), sigma=2.4e-6, fractal_dimension=2.22)
    dl.law("pohrt-popov", contact, unloading="hertz").tabulate().save(tmp_path / "granite.tbl")
    dl.law("hertz", contact).tabulate().save(tmp_path / "hertz.tbl")
    return tmp_path


# --- what a wall takes over


def test_a_wall_takes_over_the_settings_of_the_pair_style(granite):
    """As if the wall's own line had them, be it below the pair style or above; the line's own word goes first."""
    words, own = "table granite.tbl surfaceRoughness on", WALL + "table granite.tbl"
    walls = {"after": WALL}, {"after": WALL + "surfaceRoughness on"}, {"before": WALL, "after": ""}
    taken, said, above = (simulate(granite, falling(words, **wall))["KinEng"] for wall in walls)
    assert np.array_equal(taken, said) and np.array_equal(taken, above)
    off = simulate(granite, falling(words, after=WALL + "surfaceRoughness off"))["KinEng"]
    assert np.abs(taken - off).max() > 1e-3 * taken.max()
    walls = {"after": own}, {"before": own, "after": ""}
    below, above = (simulate(granite, falling("table hertz.tbl", **wall))["KinEng"] for wall in walls)
    assert np.array_equal(below, above)


def test_a_table_for_one_contact_at_a_wall(granite):
    """radius_tolerance of the pair style counts for a wall without one of its own."""
    contact = dl.Contact(radius=2e-3, modulus=modulus(), sigma=2.4e-6, fractal_dimension=2.22)
    dl.law("rough-plastic", contact, "hertz", yield_pressure=1.66e9).tabulate().save(granite / "plastic.tbl")
    words = "table plastic.tbl"
    simulate(granite, falling(words, after=""))
    message = refused(granite, falling(words))
    assert "contact radius 0.004 m" in message and "holds for 0.002 m" in message and "radius_tolerance 0.01" in message
    simulate(granite, falling(words + " radius_tolerance 1.5"))
    own = WALL + "radius_tolerance 0.1"
    assert "radius_tolerance 0.1)" in refused(granite, falling(words + " radius_tolerance 1.5", after=own))


def test_a_wall_has_the_table_that_the_pair_style_has_read(granite):
    """Though another file of that name lies where the input has gone meanwhile."""
    (granite / "results").mkdir()
    shutil.copy(granite / "hertz.tbl", granite / "results" / "granite.tbl")
    places = (
        {"before": "", "after": WALL},
        {"before": "", "after": "shell cd results\n" + WALL},
        {"before": WALL, "after": "shell cd results"},
    )
    plain, *elsewhere = (simulate(granite, falling("table granite.tbl", **p).replace("run 3000", "run 800")) for p in places)
    assert all(np.array_equal(one["KinEng"], plain["KinEng"]) for one in elsewhere)


def test_a_wall_whose_contacts_are_of_another_table_is_refused(granite):
    """A pair_style line that is given again starts with virgin contacts, a wall's go on."""
    contact = dl.Contact(radius=4e-3, modulus=modulus(), sigma=1e-6, fractal_dimension=2.22)
    dl.law("pohrt-popov", contact, unloading="hertz").tabulate().save(granite / "other.tbl")
    text = falling("table granite.tbl").replace("run 3000", "run 800")
    again = GRAN.join(["pair_style ", "table {}\npair_coeff * *\nrun 200\n"]).replace("pair_style pair_style", "pair_style")
    message = refused(granite, text + again.format("other.tbl"))
    assert "and the wall (types 1 and 1): this contact began under another law" in message
    simulate(granite, text + again.format("granite.tbl"))
    simulate(granite, text + "unfix floor\n" + again.format("other.tbl").replace("run", WALL + "\nrun"))


def test_a_sphere_that_is_put_elsewhere_and_back_meets_the_wall_as_a_virgin(granite):
    """Stock keeps the wall's history of a particle that goes without passing the gap above the wall."""
    text = falling("table granite.tbl", after=WALL + "\ncompute e all demlaws/energy").replace("nve/sphere", "nve/noforce")
    for old, new in (("step ke", "step c_e[1] c_e[2]"), ("create_atoms 2", "# create_atoms 2"), ("run 3000", "run 500")):
        text = text.replace(old, new)
    moves = "".join(f"displace_atoms all move 0 0 {way} units box\nrun 1\n" for way in ("0.01", "-0.01"))
    log = simulate(granite, text + "velocity all set 0 0 0\nrun 1\n" + moves)
    assert log["Step"].tolist()[-3:] == [501, 502, 503] and log["e[1]"][-2] == 0
    assert log["e[1]"][-1] == pytest.approx(log["e[1]"][-3], rel=1e-6) and log["e[1]"][-1] > 0
    assert log["e[2]"][-1] == pytest.approx(2 * log["e[2]"][-3], rel=1e-6)


def test_nothing_is_left_after_clear(granite):
    """A wall without a table does not find the one of the pair style before `clear`."""
    first = falling("table granite.tbl")
    second = first.replace("demlaws/table tangential history table granite.tbl", "hertz tangential history")
    assert "has no table" in refused(granite, first + "clear\n" + second)


# --- restart files


@pytest.mark.parametrize("ranks", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_a_restart_with_another_table_is_refused(granite, ranks):
    first = falling("table granite.tbl") + "write_restart now.restart\n"
    simulate(granite, first, ranks)
    (granite / "copy.tbl").write_bytes((granite / "granite.tbl").read_bytes())
    second = again(falling("table granite.tbl"))
    good = simulate(granite, second, ranks)
    assert good["Step"][-1] == 6000
    copied = simulate(granite, second.replace("granite.tbl", "copy.tbl"), ranks)  # the contents count, not the name
    assert np.array_equal(copied["KinEng"], good["KinEng"])
    contact = dl.Contact(radius=4e-3, modulus=modulus(), sigma=3e-6, fractal_dimension=2.22)
    dl.law("pohrt-popov", contact, unloading="hertz").tabulate().save(granite / "other.tbl")
    message = refused(granite, second.replace("granite.tbl", "other.tbl"), ranks)
    assert "began under another law" in message
    wall = again(falling("table granite.tbl", after=WALL + "table other.tbl"))
    assert "and the wall (types 1 and 1): this contact began under another law" in refused(granite, wall, ranks)


def test_a_restart_file_of_a_stock_run(granite):
    """Elastic tables keep what stock hertz keeps and go on; those with a history cannot, and LIGGGHTS says so."""
    stock = falling("").replace("demlaws/table", "hertz") + "write_restart stock.restart\n"
    simulate(granite, stock, plugin=False)
    assert simulate(granite, again(falling("table hertz.tbl"), "stock.restart"))["Step"][-1] == 6000
    text = again(falling("table granite.tbl"), "stock.restart")
    assert "history_floor" in refused(granite, text)
    text = text.replace("fix floor", "fix ground")
    assert "different contact history model" in refused(granite, text)
