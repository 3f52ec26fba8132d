"""The granite tests: published numbers, claims, measured points, files."""

import csv
import warnings

import numpy as np
import pytest
from examples import GRANITE_TESTS

from demlaws import granite
from demlaws.errors import DemlawsError, ValidityWarning


@pytest.fixture(autouse=True)
def quiet():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ValidityWarning)
        yield


@pytest.mark.parametrize("name", GRANITE_TESTS)
def test_displacement_and_stiffness(name):
    """Of each law from its printed inputs; Bahrami's default constant is 0.9 % stiffer than the printed one."""
    test = granite.find_test(name)
    for law, (gained, stiffness) in GRANITE_TESTS[name].expected.items():
        bound = granite.bind(law, test, "elastic")
        share, scatter = {"bahrami": (0.01, 0.0102), "yip-venart": (0.0005, 0.021)}.get(law, (0.0005, 0.0007))
        assert granite.displacement_gained(bound) * 1e6 == pytest.approx(gained, abs=0.06 + share * gained)
        assert granite.stiffness_at(bound, 10.0) / 1e3 == pytest.approx(stiffness, rel=scatter)


def test_protocol_reaches_its_turning_points():
    run, _ = granite.run_test("pohrt-popov", granite.find_test("SS(12-18)"))
    (path,) = run.paths
    assert path.force.max() == pytest.approx(100.0, rel=1e-9)
    assert path.force[-1] == pytest.approx(0.0, abs=1e-9)
    assert path.plastic_overlap[-1] == pytest.approx(path.overlap[-1], rel=1e-9)
    assert np.all(np.diff(path.force[: int(np.argmax(path.force)) + 1]) > 0)


def test_cycles_of_the_cone():
    run, _ = granite.run_test("rough-plastic", granite.find_test("RFC10"))
    stages = granite.stages_of(run)
    assert [round(s.maximum_force) for s in stages] == [20, 40, 80, 150, 300, 450]
    assert all(s.over_hertz == pytest.approx(1.0, abs=1e-3) for s in stages[1:])
    # K_y = π R p_y
    assert all(s.final_stiffness == pytest.approx(np.pi * 0.96e-3 * 1.66e9, rel=1e-9) for s in stages[1:])
    assert np.all(np.diff([s.plastic_overlap for s in stages]) > 0)


def test_points_made_with_a_law_find_it(tmp_path):
    """Points made with a law are matched by that law, and by it best."""
    test = granite.find_test("SS(18-18)")
    bound = granite.bind("yip-venart", test)
    load = np.linspace(0.1, 100.0, 60)
    file = tmp_path / "points.csv"
    rows = [f"{d * 1e6 - 3.0:.6f},{p / 1e3:.6f}" for d, p in zip(bound.overlap(load), load, strict=True)]
    file.write_text("Displacement (µm),Force [kN]\n" + "\n".join(rows) + "\n")
    points = granite.read_points(file)
    assert points.force == pytest.approx(load, rel=1e-3, abs=1e-3)
    assert points.misfit(bound) < 2e-8
    others = [granite.bind(n, test) for n in granite.laws_for_tests() if n != "yip-venart"]
    assert all(points.misfit(other) > 5 * points.misfit(bound) for other in others)


def test_unknown_test():
    with pytest.raises(DemlawsError):
        granite.find_test("SS(8-12)")


def test_path_file(tmp_path):
    run, _ = granite.run_test("rough-plastic", granite.find_test("FC5"))
    file = granite.save_path(tmp_path / "sub" / "path.csv", run.paths[0])
    rows = list(csv.reader(file.open()))
    assert rows[0][:2] == ["overlap (m)", "force (N)"]
    assert len(rows) == run.paths[0].overlap.size + 1
    assert float(rows[200][1]) == pytest.approx(run.paths[0].force[199], rel=1e-8)
