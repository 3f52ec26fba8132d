"""The validation report: its rows pass, its page says what they are, and a wrong coefficient is noticed."""

import math
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from examples import shared

import demlaws
from studies.validation import oblique, published
from studies.validation.__main__ import main
from studies.validation.figure import deviations
from studies.validation.published import GROUPS
from studies.validation.report import CONCLUSIONS, evidence, page
from studies.validation.row import KINDS, SOURCES, between, missing, near

PACKAGE = Path(demlaws.__file__).parent


@pytest.mark.parametrize("group", shared(list(GROUPS), lambda group: not group.startswith("Elastic rough spheres")))
def test_every_published_answer(group):
    rows = list(GROUPS[group]())
    assert rows
    assert not [(row.what, row.expected, row.found) for row in rows if row.verdict != "pass"]
    assert all(row.source in SOURCES for row in rows)


def test_the_places_that_lammps_keeps_tell_a_thousandth_of_a_per_cent_in_stiffness_apart(monkeypatch):
    monkeypatch.setattr(published, "KEPT", tuple(one._replace(modulus=1.00001 * one.modulus) for one in published.KEPT))
    verdicts = [row.verdict for row in published.lammps_impacts()]
    assert verdicts == ["pass", "FAIL", "FAIL"] * 2  # before they touch nothing is told


def some_rows():
    good = near("a length", "Python", 2.0, 2.0000001, 1e-6, "chung-ooi", "m")
    return {
        "one": [good, between("a ratio", "YADE", 0.0, 1.0, 1.5, "bem")],
        "two": [missing("a force", "YADE", "1", "bem", "no YADE")],
    }


def test_the_page():
    text = page(some_rows())
    assert "**1 pass, 1 fail, 1 not run.**" in text
    assert "| a ratio | YADE | 0 to 1 | 1.5 |  | FAIL | bem |" in text
    assert SOURCES["chung-ooi"].licence in text and SOURCES["thornton"].text not in text


def test_rows_stand_under_whose_answer_they_are():
    rows = some_rows() | {"three": [near("restitution", "Python", 1.0, 1.0, 0.1, "kharaz")]}
    text = page(rows)
    order = [text.index(f"## {kind}") for kind in KINDS if f"## {kind}" in text]
    assert order == sorted(order) and len(order) == 3
    assert text.index("| restitution |") < text.index("| a ratio |") < text.index("| a length |")
    assert text.index("One line per law") < text.index("deviations.png") < order[0]


def test_equations_that_we_evaluated_ourselves_are_folded_away():
    text = page({"one": [near("e", "Python", 1.0, 1.0, 0.1, "thornton")]})
    assert text.index("<details>") < text.index("| e | Python") < text.index("</details>")


def test_every_law_has_its_line_and_its_rows():
    assert set(CONCLUSIONS) == set(demlaws.laws())
    groups = {name: [] for name in GROUPS}
    for name in ("Plastic laws of the literature", "A cone", "Granite"):
        groups[name] = list(GROUPS[name]())
    for law in ("goddard", "rms", "bahrami", "thornton-ning", "luding", "eepa"):
        kinds = evidence(groups, CONCLUSIONS[law][0])
        assert kinds and all(law in row.what or law == "goddard" for _, rows in kinds for row in rows)
    failed = page({"one": [near("eepa: x", "Python", 1.0, 2.0, 0.1, "eepa")]})
    assert "printed equations 0/1 **FAIL**" in failed


def test_oblique_impacts_tell_shear_models_apart():
    """Neither Kharaz's spheres nor the finite elements pass with a model without partial slip."""
    assert oblique.misfit(oblique.table()["elastic"]) > 0.04
    assert oblique.spin_row("Python", oblique.spins("force kept")).verdict == "FAIL"


def test_a_value_that_is_not_a_number_does_not_pass():
    assert near("x", "Python", 1.0, math.nan, 0.1, "bem").verdict == "not run"
    assert near("x", "Python", 1.0, math.inf, 0.1, "bem").verdict == "FAIL"


def test_the_picture():
    """One mark a row that was run; the failed one in red beyond the limit."""
    ax = deviations(some_rows()).axes[0]
    marks = {
        line.get_color(): list(line.get_xdata()) for line in ax.lines if len(line.get_xdata()) and line.get_marker() != "None"
    }
    assert marks["tab:blue"] == pytest.approx([0.05]) and marks["tab:red"] == pytest.approx([2.0])


def test_the_command(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("studies.validation.report.GROUPS", {"A cone": GROUPS["A cone"]})
    assert main(["--no-engines", "--out", str(tmp_path / "page")]) == 0
    assert "1 rows pass, 0 fail" in capsys.readouterr().out
    for name in ("deviations.png", "asperity.png"):
        assert (tmp_path / "page" / name).stat().st_size > 1000 and name in (tmp_path / "page" / "validation.md").read_text()
    monkeypatch.setattr("studies.validation.report.GROUPS", {"wrong": lambda: [between("x", "Python", 0, 1, 2, "bem")]})
    assert main(["--no-engines", "--out", str(tmp_path / "page")]) == 1


MUTATIONS = {
    "hertz": ("core/fastmath.py", "4.0 * modulus * sqrt(radius)", "2.0 * modulus * sqrt(radius)", ["Hertz impacts"]),
    "rms": ("laws/rms.py", "(2.4 + 2.0 * s)", "(1.2 + 2.0 * s)", ["Granite"]),
    "pohrt-popov": ("laws/pohrt_popov.py", "0.2567", "0.12835", ["Granite"]),
    "goddard": ("laws/goddard.py", "3.0 * math.pi**2 / 16.0", "1.5 * math.pi**2 / 16.0", ["A cone"]),
    "rough-plastic": ("laws/rough_plastic.py", "yield_force + p.yield_stiffness *", "yield_force + 0.5 * p.yield_stiffness *",
                      ["Restitution of a yielding sphere"]),
    "bahrami": ("laws/bahrami.py", "1.22 *", "0.61 *", ["Granite"]),
    "yip-venart": ("solvers/axisymmetric.py", "return 0.5 * erfc(s", "return 0.25 * erfc(s",
                   ["Plastic asperities on an elastic sphere (Yip & Venart)"]),
    "greenwood-tripp": ("solvers/axisymmetric.py", "return f32, -1.5 * f12", "return 0.5 * f32, -0.75 * f12",
                        ["Elastic rough spheres (Greenwood & Tripp)"]),
    "asperity": ("solvers/ellipsoid.py", "4.0 * math.sqrt(2.0) / 3.0 * p.modulus", "2.0 * math.sqrt(2.0) / 3.0 * p.modulus",
                 ["Height maps against boundary elements"]),
    "thornton-ning": ("laws/thornton_ning.py", "2.0 / 3.0 * stiffness", "1.0 / 3.0 * stiffness",
                      ["Plastic laws of the literature"]),
    "jackson-green": ("laws/jackson_green.py", "4.0 * 2.84 /", "2.0 * 2.84 /", ["Plastic laws of the literature"]),
    "kogut-etsion": ("laws/kogut_etsion.py", "_FACTOR2, _POWER2 = 1.03, 1.425, 1.40", "_FACTOR2, _POWER2 = 1.03, 1.425, 0.70",
                     ["Plastic laws of the literature"]),
    "conical-damage": ("laws/conical_damage.py", "ratio = 0.5 * math.pi", "ratio = 0.25 * math.pi",
                       ["Plastic laws of the literature"]),
    "walton-braun": ("laws/walton_braun.py", "first, growth = shape", "first, growth = 0.5 * shape",
                     ["Plastic laws of the literature"]),
    "luding": ("laws/luding.py", "shape.plasticity_depth * 2.0", "shape.plasticity_depth * 1.0",
               ["Plastic laws of the literature"]),
    "eepa": ("laws/eepa.py", "k1, shape.stiffness_ratio * k1", "k1, 0.5 * shape.stiffness_ratio * k1",
             ["Plastic laws of the literature"]),
}  # fmt: skip


def test_every_law_has_a_mutation():
    assert set(demlaws.laws()) == set(MUTATIONS)


@pytest.mark.slow
@pytest.mark.parametrize("law", MUTATIONS)
def test_half_a_coefficient_is_noticed(law, tmp_path):
    """The package copied, one coefficient of the law halved: a row fails (or the program stops at it)."""
    file, old, new, groups = MUTATIONS[law]
    shutil.copytree(PACKAGE, tmp_path / "demlaws", ignore=shutil.ignore_patterns("__pycache__"))
    path = tmp_path / "demlaws" / file
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    code = f"""
import demlaws, studies.validation.row
print("started")
assert demlaws.__file__.startswith({str(tmp_path)!r})
from studies.validation.published import GROUPS
print([row.verdict for group in {groups!r} for row in GROUPS[group]()].count("FAIL"))
"""
    environment = {
        **os.environ,
        "PYTHONPATH": os.pathsep.join([str(tmp_path), str(PACKAGE.parent)]),
        "NUMBA_CACHE_DIR": str(tmp_path / "cache"),
    }
    done = subprocess.run([sys.executable, "-c", code], env=environment, cwd=tmp_path, capture_output=True, text=True)
    assert done.stdout.startswith("started")
    assert done.returncode or int(done.stdout.split()[-1]) > 0, done.stdout
