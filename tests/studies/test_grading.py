"""Large grains and fines: what hangs, slopes, tables, and short runs in LAMMPS."""

import csv
import io

import numpy as np
import pytest

from studies.assembly.study import read
from studies.grading import report, runs, scenes
from studies.grading.__main__ import RATIOS, main


def frame(*grains):
    """A frame of bodies, radius 1 mm: (number, place)."""
    return np.array([[n, 2, 1e-3, *place] for n, place in grains])


def test_a_grain_hangs_that_always_touches_the_same_one_or_two():
    """1 has two neighbours, 2 a third one once, 3 is once alone, 4 is on the floor, 5 touches a wall once, 6 has one."""
    middle = (0.03, 0.0, 0.03)
    bodies = frame(*((n, middle) for n in (1, 2, 3)), (4, (0.03, 0.0, 0.9e-3)), (5, middle), (6, middle))
    aside = bodies.copy()
    aside[4, 3] = 0.9e-3
    first = [(1, 11), (12, 1), (2, 11), (2, 12), (3, 11), (3, 12), (4, 11), (5, 11), (5, 12), (6, 11)]
    second = [(1, 11), (2, 11), (2, 13), (4, 11), (5, 11), (6, 11)]
    found = runs.hanging([bodies, aside], [np.array(first), np.array(second)])
    assert found.tolist() == [True, False, False, False, False, True]


def test_slope_of_a_surface():
    """Grains on a slope of 25 degrees."""
    x = np.arange(0.0, scenes.LENGTH, 1e-3)
    y = np.arange(0.0, scenes.WIDTH, 1e-3)
    places = np.array([(a, b, 0.04 - np.tan(np.radians(25.0)) * a) for a in x for b in y])
    grains = np.column_stack([np.arange(len(places)), np.ones(len(places)), np.full(len(places), 1e-3), places])
    assert runs.angle(grains) == pytest.approx(25.0, abs=0.5)


@pytest.mark.parametrize("walls", [True, False])
def test_no_two_grains_touch_at_the_start(walls):
    rows = np.array(scenes.scattered(scenes.Case(ratio=5, large=30, fines=60), 0.05, 0.04, walls))
    radius, place = 0.5 * rows[:, 1], rows[:, 3:]
    gap = place[:, None] - place[None]
    periods = np.array([np.inf if walls else 0.05, 0.04, np.inf])
    gap = np.minimum(np.abs(gap), periods - np.abs(gap))
    space = np.linalg.norm(gap, axis=-1) - radius[:, None] - radius[None]
    assert space[~np.eye(len(rows), dtype=bool)].min() > 0.0
    assert np.all(place[:, 2] >= radius) and np.sum(rows[:, 0] == 2) == 60


def heap_row(model, seed, hang, angle):
    case = scenes.Case(model=model, seed=seed, fines=100)
    return case._asdict() | {"hang_bed": hang, "hang_heap": 2 * hang, "angle": angle, "large_heap": 60, "us_step": 2.0}


def test_changes_are_paired_by_seed():
    """After less before: 1 and 3 degrees in two beds, mean 2, Student's t 12.7 with one degree of freedom."""
    rows = [heap_row("before", s, 3, a) for s, a in ((1, 20.0), (2, 22.0))]
    rows += [heap_row("after", s, 0, a) for s, a in ((1, 21.0), (2, 25.0))]
    before, after, *both = report.heap_table(rows)
    assert before[2:9] == ["before", 2, "3.00", "-3 (-3 to -3)", "6.00", "21.0", "2 (-10.7 to 14.7)"]
    assert after[2:9] == ["after", 2, "0.00", "", "0.00", "23.0", ""] and before[-1] == "1.00"
    assert [row[1:] for row in both] == [before[1:], after[1:]] and both[0][0] == "all"


@pytest.mark.lammps
@pytest.mark.parametrize("scene", ["heap", "oedometer"])
def test_a_quick_run_continues_where_it_stopped(scene, tmp_path, capsys):
    line = [scene, "--quick", "--results", str(tmp_path / "rows.csv"), "--store", str(tmp_path)]
    assert main(line) == 0
    rows = read(tmp_path / "rows.csv")
    assert [row["model"] for row in rows] == ["after", "stock"]
    if scene == "heap":
        assert all(0 < row["fines_heap"] <= 20 and 0 < row["large_heap"] <= 20 for row in rows)
    else:
        assert all(row["largest_kPa"] == pytest.approx(50.0, rel=1e-3) for row in rows)
        assert all(5.0 < row["height_mm"] < 30.0 for row in rows)
    capsys.readouterr()
    assert main(line) == 0 and read(tmp_path / "rows.csv") == rows
    printed = list(csv.DictReader(io.StringIO(capsys.readouterr().out)))
    assert [row["model"] for row in printed[:2]] == ["after", "stock"]


def test_bad_options_name_the_remedy(tmp_path, capsys):
    assert main(["--quick"]) != 0 and "--results" in capsys.readouterr().err
    assert main(["--former", str(tmp_path), "--report"]) != 0 and "no checkout" in capsys.readouterr().err


def test_kept_rows_compare_the_models_on_the_same_beds():
    """Each bed has both levers, and most have the stock model; the former lever lets more fines hang at 1:20."""
    rows = [row for row in read(runs.HEAPS) if row["share"] == report.MAIN]
    beds = {m: {(r["ratio"], r["seed"]): r["hang_bed"] for r in rows if r["model"] == m} for m in scenes.MODELS}
    assert beds["before"].keys() == beds["after"].keys() >= beds["stock"].keys()
    assert {ratio for ratio, _ in beds["stock"]} == set(RATIOS)
    smallest = [bed for bed in beds["after"] if bed[0] == 20]
    assert sum(beds["after"][bed] for bed in smallest) < sum(beds["before"][bed] for bed in smallest)
    assert {row["model"] for row in read(runs.OEDOMETERS)} == set(scenes.MODELS)
