"""The granite tests: published numbers, protocol, runs, files."""

import numpy as np
import pytest

import demlaws as dl
from demlaws import granite
from demlaws.cli import main
from demlaws.granite import claims

pytestmark = pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")


@pytest.mark.parametrize("name", granite.STONES)
def test_pairs_of_the_printed_stones(name):
    """R, σ and Df of the tests are those of both stones, σ to 1.5 of the last printed digit."""
    test, ((r1, s1, d1), (r2, s2, d2)) = granite.find_test(name), granite.STONES[name]
    assert 1.0 / (1.0 / r1 + 1.0 / r2) == pytest.approx(1e3 * test.radius, abs=6e-3)
    assert np.hypot(s1, s2) == pytest.approx(1e6 * test.sigma, abs=0.015)
    assert 0.5 * (d1 + d2) == pytest.approx(test.fractal_dimension, abs=1e-9)


def test_protocols_and_loads_of_the_tests():
    """Turning points [N] of each test; forces of the tables; laws that the published quantities suffice for."""
    spheres = {name: granite.find_test(name).stages for name in granite.STONES}
    assert spheres == {name: ((100.0, 0.0),) if name == "SS(12-18)" else ((100.0,),) for name in granite.STONES}
    cone, sphere = granite.find_test("RFC10"), granite.find_test("RS(18-18)")
    assert granite.forces_of(cone) == (0.1, 20.0, (1.0, 7.0, 10.0, 20.0))
    assert granite.forces_of(sphere) == (0.1, 100.0, (1.0, 10.0, 50.0, 100.0))
    names = granite.laws_for_tests()
    assert "hertz" in names and "asperity" not in names and "luding" not in names and len(names) >= 8
    for name in names:  # what `demlaws granite` runs on every test
        for test in granite.TESTS:
            assert granite.bind(name, test).force(1e-6) > 0.0


THRESHOLDS = {"SS(18-18)": 57.5, "SS(12-18)": 106.9, "SF(12)": 278.9, "RS(18-18)": 194.0, "VS(18-18)": 1.14}
"""F of Pohrt & Popov [N]; of SS(18-18) not the 73 N of the paper's text."""


@pytest.mark.parametrize("name", THRESHOLDS)
def test_threshold_force(name):
    """At F the stiffness joins Hertz's, and stays there."""
    contact = granite.find_test(name).contact
    law, hertz = dl.law("pohrt-popov", contact), dl.law("hertz", contact)
    (kink,) = law.kinks()
    assert law.force(kink) == pytest.approx(THRESHOLDS[name], abs=0.005 if THRESHOLDS[name] < 2.0 else 0.06)
    for factor, ratio in ((1.0, 1.0), (3.0, 1.0), (0.5, 0.5 ** (0.2567 * contact.fractal_dimension - 1 / 3))):
        force = factor * law.force(kink)
        stiffness = law.stiffness(law.overlap(force))
        assert stiffness / hertz.stiffness(hertz.overlap(force)) == pytest.approx(ratio, rel=1e-12)


def test_cycles_of_the_cone():
    run = granite.run_test("rough-plastic", granite.find_test("RFC10"))
    stages = granite.stages_of(run)
    assert [round(s.maximum_force) for s in stages] == [20, 40, 80, 150, 300, 450]
    assert run.law.params.yield_force == pytest.approx(20.86, abs=0.005)
    assert all(s.over_hertz == pytest.approx(1.0, abs=1e-3) for s in stages[1:])
    rough = granite.bind("pohrt-popov", run.test)  # it keeps the tangent that it has at yield
    tangent = rough.stiffness(rough.overlap(run.law.params.yield_force))
    assert all(s.final_stiffness == pytest.approx(tangent, rel=1e-9) for s in stages[1:])
    assert tangent == pytest.approx(3.620e6, rel=1e-3)
    assert np.all(np.diff([s.plastic_overlap for s in stages]) > 0)


def test_both_radii_of_a_cone():
    """Yield, unloading and the range of overlaps follow the bulk's radius, roughness the tip's."""
    run = granite.run_test("rough-plastic", granite.find_test("FC5"))
    assert run.radius == 0.62e-3 and run.law.contact.radius == 0.33e-3
    assert run.law.params.area_slope == pytest.approx(1.0 / (np.pi * 0.62e-3 * 1.66e9), rel=1e-12)
    assert run.law.force(0.1 * 0.62e-3) == pytest.approx(float(run.beyond.split()[1]), rel=0.02) and "at 300 N" in run.beyond
    again = [s.over_hertz for s in granite.stages_of(run) if np.isfinite(s.over_hertz)]
    assert again == pytest.approx([1.0] * len(again), abs=1e-3)
    assert "assumed" in run.test.assumed


def test_one_screen_and_all_numbers(tmp_path, capsys):
    """By default one line per claim and a count of warnings; with --verbose every number, and each warning once."""
    assert main(["granite", "--test", "RS(18-18)", "--out", str(tmp_path)]) == 0
    short = capsys.readouterr().out.splitlines()
    judged = claims.granite_claims(["RS(18-18)"])
    assert sum(line.endswith(claim.claim) for claim in judged for line in short) >= len(judged)
    assert len(short) < len(judged) + 30 and not any("[" in line for line in short)
    assert main(["granite", "--test", "RS(18-18)", "--out", str(tmp_path), "--verbose"]) == 0
    long = " ".join(capsys.readouterr().out.split())
    assert all(" ".join(claim.gives.split()) in long for claim in judged)
    warnings = [part.split(": ", 1)[1][:40] for part in long.split("warning: ")[1:]]
    assert warnings and len(set(warnings)) == len(warnings)


def test_a_warning_of_several_tests_is_one_line_with_the_range_of_its_load():
    from demlaws.granite.command import note_lines

    tests = granite.TESTS[:2]
    runs = {test.name: [granite.run_test(name, test) for name in ("rms", "bahrami")] for test in tests}
    loads = sorted(f"{breach.bound:.3g}" for _, bahrami in runs.values() for breach in bahrami.breaches)
    lines = [" ".join(line.split()) for line in note_lines(tests, runs, True)]
    assert f"warning: bahrami below {loads[0]} to {loads[1]} N: p0' < 0.01" in " ".join(lines)
    assert len(lines) == 3
    assert list(note_lines(tests, runs, False)) == ["3 warnings of loads outside the range of a law: --verbose"]


@pytest.mark.slow
def test_the_whole_command(tmp_path, capsys):
    """What `make granite` runs: tables, paths, claims and every figure."""
    assert main(["granite", "--out", str(tmp_path)]) == 0
    out = capsys.readouterr().out
    assert f"{len(list(tmp_path.iterdir()))} files written" in out and len(out.splitlines()) < 80
    drawn = {file.stem for file in tmp_path.glob("*.png")}
    assert {f"force-{test.key}" for test in granite.TESTS} < drawn
    assert {"stiffness", "crossover-ss-18-18", "roughness", "effective-radius", "cones"} < drawn
    paths = {file.name for file in tmp_path.glob("*.csv")}
    assert {
        f"{test.key}-{name}.csv" for test in granite.TESTS for name in granite.laws_for_tests() if len(test.stages) == 1
    } < paths
    assert {"summary.csv", "claims.csv"} < paths
