"""The limits of the C++ header and their words are those of Python."""

import subprocess
from pathlib import Path

import pytest

import demlaws as dl
from demlaws.admissible import RANGES, judge


@pytest.fixture(scope="module")
def in_cpp(tmp_path_factory):
    program = tmp_path_factory.mktemp("limits") / "limits"
    include = ["-I", str(Path(dl.__file__).parent / "cpp")]
    subprocess.run(
        ["g++", "-std=c++11", "-Wall", *include, str(Path(__file__).with_name("limits.cpp")), "-o", program], check=True
    )
    return lambda lines: subprocess.run([program], input="\n".join(lines), capture_output=True, text=True).stdout.splitlines()


def words(found):
    return f"{int(all(one.admissible for one in found))}{''.join(one.text for one in found[:1])}"


def test_both_judge_alike(in_cpp):
    values = (-1.0, -0.5, 0.0, 1e-6, 0.25, 0.5, 0.7, 1.5, 10.0, 11.0, 999.0, 1001.0, 1999.0, 2001.0, 6e10, 1e15, 2e15)
    of_python = ("hardness", "fractal_dimension", "edge_radius")  # of the table, not of an engine's input
    names = [name for name in RANGES if name not in of_python]
    single = {f"{name} {value:g}": judge(**{name: value}) for name in names for value in values}
    assert in_cpp(single) == [words(found) for found in single.values()]
    pairs = {f"roughness {s:g} 0.005": judge(roughness=s, radius=0.005) for s in (-1e-6, 0.0, 2e-6, 5e-4, 6e-4, 2.5e-3, 3.4e-3)}
    assert in_cpp(pairs) == [words(found) for found in pairs.values()]
    assert {line[0] for line in in_cpp([*single, *pairs])} == {"0", "1"}
