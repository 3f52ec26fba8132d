"""The standalone C++ header, by its example, against Python; and that no compiler warns."""

import subprocess
import types
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from examples import GRANITE
from programs import compiled

import demlaws as dl
from demlaws.make import example_law

HEADER = Path(dl.__file__).parent / "cpp"
# the paths go where a source does not support its law; the header must agree there, too
pytestmark = pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")


@pytest.fixture(scope="module")
def example(tmp_path_factory):
    program = tmp_path_factory.mktemp("example") / "example"
    command = ["g++", "-std=c++11", "-O2", "-Wall", "-Wextra", "-Werror", "-I", str(HEADER)]
    subprocess.run([*command, str(HEADER / "example.cpp"), "-o", str(program)], check=True)

    def run(table, contact, overlaps):
        text = "\n".join(f"{value:.17g} 0 0" for value in overlaps)
        arguments = [str(v) for v in (table, contact.modulus, contact.radius, contact.sigma, 0.857, 0.5)]
        return subprocess.run([str(program), *arguments], input=text, capture_output=True, text=True)

    return run


@pytest.fixture(scope="module")
def follow(tmp_path_factory):
    program = compiled(tmp_path_factory.mktemp("follow"), "follow.cpp")

    def run(*words):
        out = subprocess.run([str(program), *map(str, words)], capture_output=True, text=True, check=True).stdout
        return [line.split() for line in out.splitlines()]

    return run


@pytest.mark.parametrize(
    ("change", "named"), [({"modulus": 32.0}, "32 Pa"), ({"sigma": -2e-6}, "-2e-06 m"), ({"sigma": 2.4}, "2.4 m")]
)
def test_quantities_in_other_units_are_refused_with_their_value(example, tmp_path, change, named):
    """They were used: a force of 1e-9 of the contact's, or that of a contact of the table's own roughness."""
    law = dl.law("pohrt-popov", GRANITE)
    law.tabulate().save(tmp_path / "law.tbl")
    values = {"modulus": GRANITE.modulus, "radius": GRANITE.radius, "sigma": GRANITE.sigma} | change
    done = example(tmp_path / "law.tbl", types.SimpleNamespace(**values), [1e-6])
    assert done.returncode == 1 and named in done.stderr and not done.stdout


@pytest.mark.parametrize("standard", ["c++11", pytest.param("c++20", marks=pytest.mark.slow)])
def test_no_compiler_warns(standard):
    sources = sorted([*HEADER.glob("*.cpp"), *Path(__file__).parent.glob("*.cpp")])
    assert sources
    warnings = ["-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wno-sign-conversion", "-Werror"]
    for source in sources:
        subprocess.run(["g++", f"-std={standard}", "-fsyntax-only", *warnings, "-I", str(HEADER), str(source)], check=True)


def test_one_table_serves_every_radius_and_roughness(example, tmp_path):
    """Loaded, unloaded, reloaded beyond, separated, loaded; every rule: test_golden_tables.py."""
    dl.law("pohrt-popov", GRANITE, unloading="hertz").tabulate(rtol=1e-8).save(tmp_path / "law.tbl")
    other = GRANITE.with_values(radius=1e-3, modulus=70e9, sigma=1.1e-6)
    law = dl.law("pohrt-popov", other, unloading="hertz")
    turns = np.array([0.0, 0.6, 0.45, 1.0, 0.7, 0.9, -0.1, 0.5]) * law.overlap(3.0)
    overlaps = np.concatenate([np.linspace(a, b, 60) for a, b in pairwise(turns)])
    columns = np.array([line.split() for line in example(tmp_path / "law.tbl", other, overlaps).stdout.splitlines()], float).T
    path = law.follow(overlaps)
    wanted = (path.force, path.stiffness, path.maximum_overlap, path.plastic_overlap, path.stored)
    for column, expected in zip(columns, wanted, strict=False):
        assert np.abs(column - expected).max() <= 1e-7 * np.abs(expected).max()
    first = np.flatnonzero(overlaps <= 0.0)[1]  # the header's dissipation is this contact's, a path's all of them
    assert np.abs(columns[5] - path.dissipated)[:first].max() <= 1e-7 * path.work.max()


@pytest.mark.parametrize("unloading", ["hertz", "table"])
def test_nan_and_negative_overlaps(example, follow, tmp_path, unloading):
    path = tmp_path / "law.tbl"
    example_law("pohrt-popov", GRANITE, unloading).tabulate().save(path)
    rows = follow(path, 1e-6, float("nan"), 0.5e-6, -1e-6, 1e-6, 0.0)
    assert rows[1][0].endswith("nan")
    assert rows[2] == follow(path, 1e-6, 0.5e-6)[1]  # the state of the contact survives the NaN
    assert float(rows[3][0]) == 0.0 and rows[4] == rows[0] and set(map(float, rows[5])) == {0.0}
    result = example(path, GRANITE, [1e-6, float("nan")])
    assert result.returncode == 1 and "not a number" in result.stderr and len(result.stdout.splitlines()) == 1
