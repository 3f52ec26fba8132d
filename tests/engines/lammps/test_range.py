"""How far overlaps may go, and which rank's table counts."""

import re

import numpy as np
import pytest
from inputs_for_lammps import SHEAR, continued, modulus, save, simulate, two_spheres

import demlaws as dl
from demlaws.errors import DemlawsError
from demlaws.lammps.check import WALL, follow

pytestmark = pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")

TABLE = f"demlaws/table law.tbl 60.6e9 1.0 0.25 {SHEAR}"
SOFT = TABLE.replace("60.6e9", "60.6e5")
PRESS = [(-20, 0, 1000)]
"""1 mm in 50 µs, a quarter of the spheres' R = 4 mm."""


@pytest.fixture
def folder(tmp_path):
    save(dl.law("hertz", dl.Contact(radius=4e-3, modulus=modulus(60.6e5))), tmp_path / "law.tbl", rtol=1e-8)
    return tmp_path


def said_in(folder):
    return (folder / "log.lammps").read_text()


def counted(text, where):
    return int(re.search(rf"in this run (\d+) contact steps were {where}", text)[1])


def press(words, moves=PRESS, **options):
    return two_spheres(words, moves, 16e-3, 16e-3, **options)


def test_what_a_compute_asks_is_not_counted(folder):
    watch = {"more": "compute c all pair/local p13 force cutoff radius\ncompute k all reduce sum c_c[1] inputs local"}
    counts = []
    for more, columns in (({}, ""), (watch, "c_k")):
        simulate(folder, press(SOFT, every=1, columns=columns, **more))
        counts.append(counted(said_in(folder), "deeper"))
    assert counts[0] == counts[1]


def test_beyond_the_radius_there_is_no_answer(folder):
    with pytest.raises(DemlawsError) as caught:
        simulate(folder, press(SOFT, [(-20, 0, 5000)]))
    message = str(caught.value)
    assert re.search(r"particles [12] and [12]: overlap 0\.00400\d* m is 1 times the effective radius R = 0\.004 m", message)
    for words in (
        "contact laws hold for overlaps up to 0.1 R",
        "no answer",
        "check units, loads and the step",
        "extrapolation on",
    ):
        assert words in message
    log = simulate(folder, press(f"{SOFT.replace('0.25', '0.25 extrapolation on', 1)}", [(-20, 0, 5000)]))
    overlap = log["overlap"][log["overlap"] > 0.004]
    expected = 4 / 3 * modulus(60.6e5) * np.sqrt(4e-3) * overlap**1.5
    assert overlap.size > 10
    assert np.abs(log["force"][-overlap.size :] / expected - 1).max() < 1e-7


@pytest.mark.parametrize("wall", ["plane", "region"])
def test_walls_tell(tmp_path, wall):
    """LAMMPS takes the distance of a centre behind a wall as one before it, so that R is the most a wall can see."""
    law = dl.law("hertz", dl.Contact(radius=4e-3, modulus=modulus(60.6e5)))
    soft = WALL.replace("right set -0.2 0 0\nrun             1200", "right set -20 0 0\nrun 1000")
    log, _ = follow(law, soft, folder=tmp_path, radius=4e-3, wall=wall, every=1)
    said = said_in(tmp_path)
    assert re.search(r"particle 2 and the wall: overlap 0\.00040\d* m is 0\.1 of the effective radius R = 0\.004 m", said)
    runs = [int(found) for found in re.findall(r"in this run (\d+) contact steps were deeper", said)]
    assert sum(runs) == pytest.approx(np.sum(log["overlap"] > 0.4e-3), abs=3)
    assert said.count("reported once") == 1


@pytest.mark.parametrize(("model", "count"), [("hertz/material 60.6e9 1.0 0.25", 1), (TABLE.partition(" tangential")[0], 0)])
def test_a_wall_left_with_a_stock_model_is_reported(folder, model, count):
    wall = f"fix wall all wall/gran granular {model} tangential linear_nohistory 1.0 0.5 xplane NULL 16e-3\n"
    simulate(folder, press(TABLE, [(0.2, 0, 100)], left=-8e-3 - 1e-7, more=wall))
    assert said_in(folder).count("has the stock model hertz/material") == count


@pytest.mark.parametrize(
    "change, message",
    [
        (("60.6e9 1.0 0.25", "60.6 1.0 0.25"), "did you mean GPa"),
        (("60.6e9 1.0 0.25", "60.6e9 0.25 0.4"), "eta and nu are exchanged"),
        (("60.6e9 1.0 0.25", "60.6e9 1.0 tangential"), "FILE E eta nu"),
        (("60.6e9 1.0 0.25", "60.6e9 1.0 0.25 roughness 2.4"), "did you mean µm"),
    ],
)
def test_numbers_in_the_wrong_unit_or_order_are_refused(tmp_path, granite_pair, change, message):
    dl.law("pohrt-popov", granite_pair.with_values(modulus=modulus())).tabulate().save(tmp_path / "law.tbl")
    with pytest.raises(DemlawsError, match=message):
        simulate(tmp_path, two_spheres(TABLE.replace(*change), [(-0.2, 0, 1000)]))


def test_extrapolation_is_on_or_off_and_goes_through_restarts(tmp_path, granite_pair):
    dl.law("pohrt-popov", granite_pair.with_values(modulus=modulus())).tabulate(max_force=10.0).save(tmp_path / "law.tbl")
    with pytest.raises(DemlawsError, match="extrapolation is on or off, not maybe"):
        simulate(tmp_path, two_spheres(TABLE.replace("0.25", "0.25 extrapolation maybe", 1), []))
    on = TABLE.replace("0.25", "0.25 extrapolation on", 1)
    simulate(tmp_path, two_spheres(on, [(-0.2, 0, 1000)]) + "write_restart now.restart\n")
    simulate(tmp_path, continued([(-0.2, 0, 100)]))
    lines = f"pair_coeff 1 1 {on}\npair_coeff 2 2 {TABLE}\n"  # mixed: only where both have it
    with pytest.raises(DemlawsError, match="beyond the last row"):
        simulate(tmp_path, two_spheres(lines, [(-0.2, 0, 1000)]))
