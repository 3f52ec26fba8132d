"""The limits of the C++ header and their words are those of Python."""

import subprocess
from pathlib import Path

import pytest

import demlaws as dl
from demlaws.admissible import judge


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
    """Of a contact's modulus and roughness: the plugins get single materials from their engine."""
    moduli = {f"modulus {E:g}": judge(modulus=E) for E in (-1.0, 0.0, 60.6, 999.0, 1001.0, 6e10, 1e15)}
    pairs = {f"roughness {s:g} 0.005": judge(roughness=s, radius=0.005) for s in (-1e-6, 0.0, 2e-6, 5e-4, 6e-4, 2.5e-3, 3.4e-3)}
    assert in_cpp([*moduli, *pairs]) == [words(found) for found in (*moduli.values(), *pairs.values())]
    assert {line[0] for line in in_cpp([*moduli, *pairs])} == {"0", "1"}
