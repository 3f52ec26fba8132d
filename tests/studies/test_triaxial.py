"""The triaxial study: known courses, the measured data, a short run that continues after an interruption, kept results."""

import csv
import re
from pathlib import Path

import numpy as np
import pytest
from making.apart import cells

import demlaws as dl
from studies.assembly.study import read
from studies.triaxial import cell, cycles, report
from studies.triaxial.__main__ import QUICK

PAGE = Path(__file__).parents[2] / "docs" / "validation" / "triaxial.md"


def test_numbers_of_a_known_course():
    number = np.unique(np.round(np.geomspace(1, 2000, 60)))
    one = report.Course(number, 0.4 * number**0.25)
    assert one.at(200) == pytest.approx(0.4 * 200**0.25, rel=1e-3) and np.isnan(one.at(3000))
    assert one.exponent(2, 200) == pytest.approx(0.25)
    assert report.SHAPES["s(1)/s(200)"](one) == pytest.approx(200**-0.25, rel=1e-3)
    assert np.isnan(report.Course(number[number < 100], number[number < 100]).exponent(2, 200))


def test_measured_tests_have_the_ranges_of_the_criteria():
    tests = report.measured()
    assert len(tests) == len(report.measured("volumetric")) == 23
    shares = [one.at(200) / one.at(2000) for one in tests.values()]
    assert (np.nanmin(shares), np.nanmax(shares)) == pytest.approx((0.43, 0.84), abs=0.01)
    assert np.isfinite(shares).sum() == 20
    assert max(one.at(1) / one.at(200) for one in tests.values()) == pytest.approx(0.33, abs=0.01)
    exponents = [one.exponent(2, 200) for one in tests.values()]
    assert [min(exponents), np.median(exponents), max(exponents)] == pytest.approx([0.16, 0.30, 0.76], abs=6e-3)
    assert max(np.nan_to_num(one.exponent(1000, 1e6)) for one in tests.values()) == pytest.approx(0.10, abs=5e-3)


def test_grains_have_their_volume_and_mass():
    grains = cell.loose("tetrapods", 20, 1)
    mass = np.bincount(grains.rows[:, 0].astype(int), grains.rows[:, 2] * np.pi / 6 * grains.rows[:, 1] ** 3)[1:]
    assert mass.sum() == pytest.approx(cell.DENSITY * grains.solid) and mass.size == 20
    places = grains.rows[:, 3:]
    assert places.min() > 0.0 and places.max() < grains.side


@pytest.mark.parametrize("law", dict.fromkeys(case.contact for case, _ in cycles.wanted()), ids=str)
def test_each_law_has_a_table(tmp_path, law):
    law.save(tmp_path / "pair.tbl", cell.contact_radius("tetrapods"))
    assert dl.Table.load(tmp_path / "pair.tbl").largest_force >= 5e3


@pytest.fixture(scope="module")
def quick(tmp_path_factory):
    folder = tmp_path_factory.mktemp("triaxial")
    case, number = QUICK[0]
    cycles.run_case(case, number, folder / "cycles.csv", folder)
    return case, folder


@pytest.mark.slow
@pytest.mark.lammps
def test_pistons_carry_their_loads(quick):
    rows = read(quick[1] / "cycles.csv")
    for row in rows:
        assert row["q_kPa"] == pytest.approx(230.0, rel=0.02) and row["side_kPa"] == pytest.approx(60.0, rel=0.02)
        assert 0.0 < row["resilient"] < 1.0 and row["side_off_kPa"] < 12.0  # the pistons swing after one of 30 grains slips
    assert [row["cycle"] for row in rows][:3] == [1, 2, 3]


@pytest.mark.slow
@pytest.mark.lammps
def test_a_case_continues_after_its_last_part(quick):
    case, folder = quick
    before = read(folder / "cycles.csv")
    cycles.run_case(case, 10, folder / "cycles.csv", folder)
    assert read(folder / "cycles.csv") == before  # ten cycles are there
    cycles.run_case(case, 11, folder / "cycles.csv", folder)
    after = read(folder / "cycles.csv")
    assert after[: len(before)] == before and after[-1]["cycle"] == 50


def test_effects_and_packings_of_the_page_are_those_of_the_kept_runs():
    rows = read(cycles.RESULTS)
    for name, text in (("triaxial", report.table(rows)), ("triaxial-effects", report.effects(rows))):
        with (PAGE.parents[1] / "tables" / f"{name}.csv").open() as table:
            assert [cells(line) for k, line in enumerate(text.splitlines()) if k != 1] == list(csv.reader(table))
    found = report.simulated(rows)
    slight, rough = (report.SMOOTH._replace(law="pohrt-popov", sigma=sigma) for sigma in (2.4, 10.0))
    for law, whole, ends in (
        (report.CORNERS, [11.5, 2.0], [298.0, 48.0]),
        (report.SMOOTH, [1.6], [143.0, 1.0]),
        (slight, [1.6], [137.0, 1.0, 266.0]),
        (rough, [1.7], [167.0, 1.0, 437.0]),
    ):
        near = [found[law._replace(q=370.0, seed=seed)] for seed in (1, 2, 3)]
        assert [round(one.at(200), 1) for one in near if np.isfinite(one.at(200))] == whole
        assert [one.collapsed for one in near if not np.isnan(one.collapsed)] == ends


def test_verdicts_of_the_page_follow_from_the_kept_runs():
    """Of the two cases with 2,000 cycles each misses one half of the criterion of shakedown."""
    rows, page = read(cycles.RESULTS), PAGE.read_text()
    found = report.simulated(rows)
    ends = [(one.at(200) / one.at(2000), one.exponent(1000, 2000)) for one in map(found.get, (report.SMOOTH, report.CORNERS))]
    assert ends == [pytest.approx((0.74, 0.14), abs=6e-3), pytest.approx((0.90, 0.04), abs=6e-3)]
    assert "hertz has 0.74, but 0.14 beyond 1,000 cycles; corners have 0.90, slower than measured, and 0.04" in page
    low = [one.at(1) / one.at(200) for case, one in found.items() if (case.p, case.q) == (60.0, 230.0)]
    assert (np.nanmin(low), np.nanmax(low)) == pytest.approx((0.35, 0.90), abs=6e-3)
    side, high = re.search(r"within ([\d.]+) % of p, largest q within ([\d.]+) %", report.course_text(rows)).groups()
    assert f"within {float(side):.0f} % of p and the largest q within {high} %" in " ".join(page.split())


def test_runs_that_the_page_names():
    """Four contacts, each measured load with q of 230 or 370 kPa, three packings, 500 cycles or to collapse; two over 2,000."""
    rows = [row for row in read(cycles.RESULTS) if row["friction"] == 0.6 and row["grains"] == "tetrapods"]
    ends = {}
    for row in rows:
        case = cycles.case_of(row)
        ends[case] = max(ends.get(case, 0), row["cycle"])
    loads = {key[:2] for key in report.measured() if key[1] in (230.0, 370.0)}
    assert {(case.p, case.q) for case in ends} == loads == {(60.0, 230.0), (60.0, 370.0), (30.0, 230.0), (10.0, 230.0)}
    found, stopped = report.simulated(rows), report.SMOOTH._replace(q=370.0, seed=3)
    assert ends[stopped] == 350
    for law in (report.SMOOTH, report.CORNERS, *(report.SMOOTH._replace(law="pohrt-popov", sigma=s) for s in (2.4, 10.0))):
        for p, q in loads:
            for case in (law._replace(p=p, q=q, seed=seed) for seed in (1, 2, 3)):
                assert ends[case] >= 500 or found[case].collapsed == ends[case] or case == stopped
    assert {case for case, end in ends.items() if end == 2000} == {report.SMOOTH, report.CORNERS}
