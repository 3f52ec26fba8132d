"""`demlaws fit`, `choose` and `table --points`: what they print, read and refuse."""

import io
import json
import re
import sys
import warnings

import numpy as np
import pytest
from bench_fit import history

import demlaws as dl
from demlaws.advice.fit_report import Estimate
from demlaws.cli import main
from demlaws.cli.fit import shown
from demlaws.errors import NeedsClasses

PAIR = dl.Contact(4.35e-3, 32.32e9, 2.4e-6, 2.22, 6.266e9)
CONTACT = ["--effective-radius", "4.35mm", "--modulus", "32.32GPa", "--sigma", "2.4um"]
ECHO = "contact: R = 4.35 mm, E* = 32.32 GPa, σ = 2.4 µm"


@pytest.fixture(autouse=True)
def restored():
    """main() shows warnings in its own way: undo that."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", dl.ValidityWarning)
        yield


@pytest.mark.parametrize(
    ("end", "text"),
    [
        ("", "modulus 2 [1, 3] GPa (at its bound)"),
        ("lower", "modulus below 3 GPa (at its bound)"),
        ("upper", "modulus above 1 GPa (at its bound)"),
        ("both", "modulus not determined: at its bound"),
    ],
)
def test_an_open_end_of_an_interval_is_stated(end, text):
    estimate = Estimate(2e9, 5e8, 1e9, 3e9, "at its bound", end)
    assert shown("modulus", estimate, "Pa") == text
    assert (end in estimate.note or "not determined" in estimate.note) and "at its bound" in estimate.note


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    """Points as an indenter writes them, made by a law that the fits of the tests do not include."""
    force = np.concatenate([np.linspace(1.5, 148.0, 50), np.linspace(140.0, 10.0, 15)])
    law = dl.law("rough-plastic", PAIR, "thornton", yield_pressure=0.8e9)
    depth = history(law, force)[0] + 2e-8 * np.random.default_rng(1).standard_normal(force.size)
    path = tmp_path_factory.mktemp("points") / "points.txt"
    rows = "".join(f"{1e9 * d:.1f}\t{1e6 * p:.8g}\n" for d, p in zip(depth, force, strict=True))
    path.write_text("Depth (nm)\tLoad (µN)\n" + rows, encoding="utf-8")
    return path


LAWS = ["--law", "hertz", "--law", "goddard", "--law", "rough-plastic", "--law", "pohrt-popov", "--law", "conical-damage"]


def test_the_table_of_a_fit(file, capsys):
    assert main(["fit", str(file), *CONTACT, "--fractal-dimension", "2.22", *LAWS]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == ECHO
    assert max(map(len, lines)) <= 100
    (best, *others) = [line for line in lines if line.startswith(("hertz", "goddard", "rough", "pohrt", "conical"))]
    assert best.startswith("rough-plastic    thornton") and best.endswith("scatter")
    assert all(line.endswith("systematic") for line in others if line.split()[0] in ("hertz", "goddard"))
    assert sum(line.startswith("systematic: ") for line in lines) == 1
    assert not any(" Pa" in line for line in lines) and any("GPa" in line for line in lines[2:])


def test_the_mark_of_a_systematic_misfit_is_in_json(file, capsys):
    assert main(["fit", str(file), *CONTACT, "--law", "hertz", "--json"]) == 0
    laws = json.loads(capsys.readouterr().out)["laws"]
    assert laws[0]["parameters"]["zero"]["note"] == laws[0]["parameters"]["zero"]["open_end"] == ""
    assert all(law["systematic"] for law in laws)


def test_points_and_scenes_from_standard_input(file, tmp_path, monkeypatch, capsys):
    def given(content):
        monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(content)))

    given(file.read_bytes())
    assert main(["fit", "-", *CONTACT, "--law", "hertz"]) == 0
    assert "standard input: 65 points" in capsys.readouterr().out
    given(file.read_bytes())
    assert main(["table", "--points", "-", *CONTACT, "--out", str(tmp_path / "points.tbl")]) == 0
    assert capsys.readouterr().out.splitlines()[0] == ECHO
    given(SCENE.encode())
    assert main(["choose", "-"]) == 0


ERRORS = [
    (["fit", "FILE", *CONTACT, "--law", "hertz", "--force-noise", "0.1N"], ("force_noise needs displacement_noise",)),
    (["fit", "FILE", *CONTACT, "--law", "hertz", "--displacement-noise", "1m"], ("displacement_noise = 1m",)),
    (["fit", "FILE", *CONTACT, "--law", "rough-plastic", "--free", "yield_pressure"], ("fractal_dimension",)),
]


@pytest.mark.parametrize(("words", "options"), ERRORS)
def test_errors_name_quantities(words, options, file, capsys, tmp_path, monkeypatch):
    """By one name that both Python's arguments and the options have."""
    monkeypatch.chdir(tmp_path)
    assert main([str(file) if word == "FILE" else word for word in words]) == 2
    text = capsys.readouterr().err
    assert all(option in text for option in options)
    assert "Contact(" not in text


SCENE = """
radii = [2e-3, 8e-3]
force = [50.0, 2000.0]
quantity = "overlap"
cyclic = true
yield_pressure = 1.66e9
[material]
young = 60.6e9
poisson = 0.25
hardness = 6.266e9
density = 2650
[surface]
roughness = 1.7e-6
fractal_dimension = 2.22
"""


def test_choose_writes_no_table_that_cannot_serve(tmp_path, capsys):
    scene, table = tmp_path / "scene.toml", tmp_path / "law.tbl"
    scene.write_text(SCENE)
    assert main(["choose", str(scene), "--out", str(table)]) == 2
    assert "list grain sizes as classes" in capsys.readouterr().err
    assert not table.exists()
    best = dl.choose(dl.Scene.load(scene)).best
    assert best.name == "rough-plastic"
    with pytest.raises(NeedsClasses):
        best.tables()
    (tmp_path / "one.toml").write_text(SCENE.replace("[2e-3, 8e-3]", "8e-3"))
    assert main(["choose", str(tmp_path / "one.toml"), "--out", str(table)]) == 0 and table.exists()


@pytest.mark.parametrize("given", [[], ["--roughness", "1um"], ["--roughness", "1um", "0.5um"], ["--sigma", "1um"]])
def test_the_roughness_that_a_fit_prints_gives_its_law_again(given, tmp_path, capsys):
    """The σ of the pair that it printed as roughness, copied to --roughness, was another law: √2 times as rough."""
    law = dl.law("rms", PAIR)
    force = np.geomspace(1.0, 100.0, 30)
    points = tmp_path / "points.csv"
    rows = "".join(f"{1e6 * x:.8g},{p:.8g}\n" for x, p in zip(law.overlap(force), force, strict=True))
    points.write_text("displacement (um),force (N)\n" + rows, encoding="utf-8")
    command = ["fit", str(points), *CONTACT[:4], *given, "--law", "rms", "--free", "sigma"]
    assert main([*command, "--json"]) == 0
    (found,) = json.loads(capsys.readouterr().out)["laws"]
    sq = found["roughness"]
    assert np.hypot(*sq) == pytest.approx(found["parameters"]["sigma"]["value"], rel=1e-12)
    assert sq[1] == (0.5e-6 if given[2:] else sq[0])
    assert main(command) == 0
    printed = " ".join(capsys.readouterr().out.split())
    copied = [f"{word}um" for word in re.findall(r"([\d.]+) µm of", printed)]
    assert "sigma 2.4" in printed and len(copied) == len(set(sq))
    forces = []
    for surface in (["--roughness", *map(repr, sq)], ["--roughness", *copied], ["--sigma", "2.4um"]):
        assert main(["curve", "--law", "rms", *CONTACT[:4], *surface, "--overlaps", "2e-6", "--steps", "1", "--json"]) == 0
        forces.append(json.loads(capsys.readouterr().out)["force"][-1])
    assert forces == pytest.approx([law.force(2e-6)] * 3, rel=1e-4)


def test_no_roughness_of_an_end_of_the_range(tmp_path, capsys):
    """σ at the largest of its search was printed as "above 0.93 µm" and, below it, as Sq 0.70711 µm of each surface."""
    law = dl.law("hertz", PAIR.with_values(modulus=PAIR.modulus / 15.0))
    force = np.geomspace(1.0, 100.0, 30)
    rows = "".join(f"{1e6 * x:.8g},{p:.8g}\n" for x, p in zip(law.overlap(force), force, strict=True))
    (tmp_path / "points.csv").write_text("displacement (um),force (N)\n" + rows, encoding="utf-8")
    assert main(["fit", str(tmp_path / "points.csv"), *CONTACT[:4], "--law", "rms", "--free", "sigma"]) == 0
    printed = capsys.readouterr().out
    assert "sigma above" in printed and "roughness Sq" not in printed


def test_a_fit_by_the_former_name_of_sigma(file):
    points = np.loadtxt(file, skiprows=1)[:40] * (1e-9, 1e-6)
    with pytest.warns(FutureWarning, match="of the pair"):
        best = dl.fit(points, PAIR, laws="rms", free=["roughness"]).best
    assert next(iter(best.parameters)) == "sigma"
