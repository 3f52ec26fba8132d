"""Curves of tables in single precision (demlaws_float.h) against double, for every law; -s prints the errors."""

import subprocess
from pathlib import Path

import numpy as np
import pytest
from examples import ALIKE, GRANITE, accepted, options_of, shared

import demlaws as dl
from demlaws.make import example as example_law

pytestmark = pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")
PLACES = ("0.001", "0.01", "0.1", "1")
"""Coordinates [m] from which an overlap is computed as a difference."""


@pytest.fixture(scope="module")
def errors(tmp_path_factory):
    program = tmp_path_factory.mktemp("float") / "float_curve"
    headers, source = Path(dl.__file__).parent / "cpp", Path(__file__).parent / "float_curve.cpp"
    subprocess.run(["g++", "-std=c++11", "-O2", "-I", str(headers), str(source), "-o", str(program)], check=True)

    def run(*words):
        done = subprocess.run([str(program), *map(str, words)], capture_output=True, text=True, check=True)
        return np.array(done.stdout.split(), float)

    return run


@pytest.mark.parametrize("name", ["three-kinks", "kinks-in-one-cell", "most-kinks", "luding-linear"])
def test_kinks_within_a_cell(errors, name):
    assert max(errors(Path(__file__).parents[1] / "data" / "tables" / "good" / f"{name}.tbl")[:2]) <= 4e-7


@pytest.mark.parametrize("name", shared(dl.laws(), lambda name: name not in ALIKE))
def test_force_and_stiffness_in_single_precision(errors, tmp_path, name):
    for rule in [rule for rule in ("elastic", "table") if accepted(name, rule)] or [None]:
        law = example_law(name, GRANITE, rule, **options_of(name))
        file = tmp_path / f"{rule}.tbl"
        law.tabulate().save(file)
        words = ["unloading"] if rule == "table" else []
        force, stiffness, rounded, rounded_stiffness, size = errors(file, *words)
        text = f"force {force:.1e}, stiffness {stiffness:.1e}; overlap rounded: {rounded:.1e}, {rounded_stiffness:.1e}"
        print(f"{name:22s} {rule or 'own rule':9s} {text}; {size:.0f} kB")
        assert max(force, stiffness, rounded, rounded_stiffness) <= 4e-7


def test_an_overlap_between_positions_in_single_precision_is_not_enough(errors, tmp_path):
    example_law("pohrt-popov", GRANITE).tabulate().save(tmp_path / "law.tbl")
    for force in ("1", "10"):
        found = errors(tmp_path / "law.tbl", *(word for place in PLACES for word in (place, force)))[4:-1]
        print(f"{force} N:", ", ".join(f"positions of {x} m: {error:.1e}" for x, error in zip(PLACES, found, strict=True)))
        assert np.all(np.diff(found) > 0.0) and found[-1] > 0.03
