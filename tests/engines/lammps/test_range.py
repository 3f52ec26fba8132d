"""How far overlaps may go, and which rank's table counts."""

import os
import re
import subprocess

import numpy as np
import pytest
from inputs_for_lammps import SHEAR, continued, modulus, save, simulate, two_spheres

import demlaws as dl
from demlaws.errors import DemlawsError
from demlaws.lammps.check import WALL, follow
from demlaws.lammps.run import command, read_log
from demlaws.units import large_overlap

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


@pytest.mark.parametrize("ranks", [1, 2])
def test_overlaps_that_no_law_holds_for_are_told(folder, ranks):
    """Beyond a tenth of R: one warning, in the words of Python, and a count. On two ranks both have the pair."""
    log = simulate(folder, press(SOFT, left=-8e-3, newton="off", every=1), ranks)
    deep = log["overlap"][1:] > 0.1 * 4e-3
    assert deep.sum() > 500
    said = said_in(folder)
    count = counted(said, "deeper than a tenth of R")
    assert count == ranks * deep.sum()
    assert said.count("reported once") <= 1
    if ranks == 1:
        first = log["overlap"][1:][deep][0]
        assert large_overlap(first, 4e-3) in said.replace("\n", " ")
    simulate(folder, press(SOFT, [(-20, 0, 10)]))
    assert "deeper" not in said_in(folder)


def test_every_run_counts_anew_and_tells_nothing_again(folder):
    simulate(folder, press(SOFT, [*PRESS, (20, 0, 100), (0, 0, 50)], every=1))
    said = said_in(folder)
    counts = [int(found) for found in re.findall(r"in this run (\d+) contact steps were deeper", said)]
    assert len(counts) == 3 and counts[1:] == [100, 50] and said.count("reported once") == 1


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


def test_the_message_beyond_the_table_names_the_ways_out(tmp_path, granite_pair):
    law = dl.law("pohrt-popov", granite_pair.with_values(modulus=modulus()))
    table = law.tabulate(max_force=10.0)
    table.save(tmp_path / "law.tbl")
    with pytest.raises(DemlawsError) as caught:
        simulate(tmp_path, two_spheres(TABLE, [(-0.2, 0, 1000)]))
    message = str(caught.value)
    assert float(re.search(r"\(some (\S+) N\)", message)[1]) == pytest.approx(table.largest_force, rel=0.01)
    for words in ("law.tbl", "--max-force", "time step", "extrapolation on"):
        assert words in message
    log = simulate(tmp_path, two_spheres(TABLE.replace("0.25", "0.25 extrapolation on", 1), [(-0.2, 0, 1000)], every=1))
    last = float(table.overlap(table.largest_force))
    beyond = log["overlap"] > 1.001 * last
    exponent = float(table.stiffness(last)) * last / table.largest_force
    assert beyond.sum() > 100
    expected = table.largest_force * (log["overlap"][beyond] / last) ** exponent
    assert np.abs(log["force"][beyond] / expected - 1).max() < 1e-6
    said = said_in(tmp_path)
    assert said.count("its last power law goes on") == 1
    assert counted(said, "beyond the last row") == pytest.approx(beyond.sum(), abs=3)


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


def test_limits_of_the_law_are_counted(tmp_path, granite_pair):
    """As many steps as there are forces outside of `law.limits()`, each limit reported once with its contact."""
    law = dl.law("rms", granite_pair.with_values(modulus=modulus()))
    law.tabulate().save(tmp_path / "law.tbl")
    log = simulate(tmp_path, two_spheres(TABLE, [(-0.2, 0, 1000)], every=1))
    said, force = said_in(tmp_path), log["force"]
    expected = sum(np.sum((force > 0) & (force < limit.minimum_force)) for limit in law.limits())
    assert said.count("reported once") == 2 and "α > 5" in said and "α > 1" in said
    assert counted(said, "below the range of force of their law") == pytest.approx(expected, abs=3) and expected > 10
    assert "worst: particles 1 and 2" in said.replace("\n", " ")


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


# --- ranks: rank 0 reads

RANK = "${PMI_RANK:-${OMPI_COMM_WORLD_RANK:-0}}"


def on_two_folders(first, second, text):
    """Two ranks, each in a folder of its own, as nodes with unlike file systems have it."""
    for folder in (first, second):
        (folder / "in.case").write_text(text)
    starter = first / "starter"
    starter.write_text(f'#!/bin/sh\n[ "{RANK}" = 0 ] || cd {second}\nexec "$@"\n')
    starter.chmod(0o755)
    line, environment = command("in.case", 2)
    at = next(n for n, word in enumerate(line) if word == "-in") - 1
    line.insert(at, str(starter))
    return subprocess.run(line, env=environment, cwd=first, capture_output=True, text=True, timeout=300)


def test_a_table_that_one_rank_does_not_see(folder, tmp_path_factory):
    """Rank 0 reads it for all; where rank 0 has none, all stop: neither hangs (the timeout is the test)."""
    empty = tmp_path_factory.mktemp("empty")
    text = press(SOFT, [(-20, 0, 300)], left=-8e-3, newton="off")
    done = on_two_folders(folder, empty, text)
    assert done.returncode == 0, done.stdout[-800:] + done.stderr[-800:]
    log = read_log(folder / "log.lammps")
    assert np.array_equal(log["force"], simulate(folder, text, 2)["force"])
    done = on_two_folders(empty, folder, text)
    assert done.returncode and "law.tbl: cannot be opened" in done.stdout + done.stderr


def test_unlike_tables_on_two_ranks_become_rank_0s(folder, tmp_path_factory):
    """The pair lies on the border: with newton off rank 1 computes the force on the second sphere, with rank 0's table."""
    other = tmp_path_factory.mktemp("other")
    contact = dl.Contact(radius=4e-3, modulus=modulus(60.6e5), roughness=5e-5, fractal_dimension=2.22)
    save(dl.law("pohrt-popov", contact), other / "law.tbl")
    text = press(SOFT, [(-20, 0, 300)], left=-8e-3, newton="off")
    alone = simulate(other, text, 2)["force"]
    assert on_two_folders(folder, other, text).returncode == 0
    force = read_log(folder / "log.lammps")["force"]
    assert np.array_equal(force, simulate(folder, text, 2)["force"])
    assert np.abs(alone - force).max() > 0.1 * force.max()


@pytest.mark.parametrize("file", ["/dev/null", "."])
def test_what_is_no_table_stops_every_rank(folder, file):
    with pytest.raises(DemlawsError, match="demlaws/table"):
        simulate(folder, press(SOFT.replace("law.tbl", file)), 2, timeout=60)
    assert os.path.exists(file)
