import json
import subprocess
import sys

import numpy as np
import pytest

import demlaws as dl
from demlaws import cli, surface
from demlaws.surface import self_affine

ALUMINIUM = ["--radius", "3.175mm", "inf", "--hardness", "0.24e9", "--young", "430e9", "75.2e9", "--poisson", "0.17", "0.34"]


@pytest.fixture
def map_file(tmp_path):
    return str(surface.write(tmp_path / "map.asc", self_affine(128, 2e-6, 0.8, roughness=1.3e-6, seed=1, longest=60e-6)))


def test_regime_of_one_contact(capsys, tmp_path):
    figure = tmp_path / "regime.png"
    arguments = ["regime", *ALUMINIUM, "--sigma", "1.3um", "--load", "0.2", "--figure", str(figure)]
    assert cli.main(arguments) == 0
    text = capsys.readouterr().out
    assert "0.159" in text and "1.373 N" in text and "asperity         applies" in text
    assert figure.stat().st_size > 10000
    assert cli.main(["regime", *ALUMINIUM, "--sigma", "1.3um"]) == 0
    assert "bulk yields" in capsys.readouterr().out


FC5 = "--effective-radius 0.33mm --young 60.6e9 --poisson 0.25 --hardness 6.266e9 --sigma 5.04um".split()  # noqa: SIM905


def test_a_measured_yield_decides_the_regime(capsys):
    """FC5 yielded at 7 N: at 20 N its bulk is not elastic, whatever 0.6 of its hardness says."""
    contact = [*FC5, "--fractal-dimension", "2.22", "--load", "20"]
    assert cli.main(["regime", *contact]) == 0
    assert "the bulk stays elastic" in capsys.readouterr().out
    for given in (["--yield-load", "7"], ["--yield-pressure", "2.35GPa"]):
        assert cli.main(["regime", *contact, *given]) == 0
        text = capsys.readouterr().out
        assert "the bulk yields" in text and "transition (p0 = p_y) at" in text
        assert "rough-plastic    applies" in text and "pohrt-popov      no" in text


def test_surface_prints_and_writes(capsys, tmp_path, map_file):
    out, figure = tmp_path / "level.npy", tmp_path / "map.png"
    assert cli.main(["surface", map_file, "--form", "2", "--out", str(out), "--figure", str(figure)]) == 0
    assert "128 x 128 pixels" in capsys.readouterr().out
    assert np.load(out).shape == (128, 128) and figure.stat().st_size > 10000


def test_summits_and_a_field_of_view(capsys, tmp_path, map_file):
    figure = tmp_path / "summits.png"
    assert (
        cli.main(["surface", "summits", map_file, "--effective-radius", "5mm", "--crop", "200um", "--figure", str(figure)]) == 0
    )
    text = capsys.readouterr().out
    assert "nine-point summits on 200 x 200 µm" in text and "for R = 5 mm" in text and figure.stat().st_size > 10000
    assert cli.main(["surface", map_file, "--crop", "160um"]) == 0
    assert "80 x 80 pixels" in capsys.readouterr().out


def test_synthetic_map_has_the_roughness_asked_for(capsys, tmp_path):
    out = tmp_path / "made.csv"
    arguments = ["surface", "synthetic", "--size", "64", "--pixel", "1um", "--roughness", "2um", "--out", str(out)]
    assert cli.main(arguments) == 0
    assert "Sq = 2 µm" in capsys.readouterr().out
    assert surface.read(out, pixel="1um").sq == pytest.approx(2e-6, rel=1e-6)


def test_from_a_map_to_a_table(capsys, tmp_path, map_file):
    table, worn, figure = (tmp_path / n for n in ("map.tbl", "worn.npy", "contact.png"))
    arguments = ["surface", "contact", map_file, *ALUMINIUM, "--load", "0.05", "--table", str(table)]
    assert cli.main([*arguments, "--out", str(worn), "--figure", str(figure)]) == 0
    text, warned = capsys.readouterr()
    assert "give plastic_factor and plastic_ratio (--plastic-factor, --plastic-ratio)" in warned
    assert "micro-contacts" in text and "hertz unloading" in text
    assert dl.Table.load(table).force(1e-7) > 0
    assert np.load(worn).shape == (128, 128) and figure.stat().st_size > 10000


def test_cycles(capsys, map_file):
    """The same load changes the map in the first cycle only."""
    press = [*ALUMINIUM, "--load", "0.05", "--plastic-factor", "0.71", "--plastic-ratio", "160", "--json"]
    assert cli.main(["surface", "contact", map_file, *press, "--cycles", "3"]) == 0
    first, second, third = json.loads(capsys.readouterr().out)["cycles"]
    assert first["change"] > 0.0 and max(second["change"], third["change"]) < 1e-3 * first["change"]


def test_options_that_are_refused_are_not_offered(capsys):
    """The map's Poisson's ratio is needed by itself: E* does not do."""
    with pytest.raises(SystemExit):
        cli.main(["surface", "--help"])
    text = capsys.readouterr().out
    assert "--young" in text and "--modulus" not in text and "--load" in text


def test_a_figure_in_a_process_that_has_drawn_nothing(tmp_path):
    """Its module is loaded with the figure."""
    pytest.importorskip("matplotlib")
    figure = tmp_path / "regime.png"
    line = [sys.executable, "-m", "demlaws", "regime", *ALUMINIUM, "--sigma", "1.3um", "--load", "0.2", "--figure", str(figure)]
    subprocess.run(line, check=True, capture_output=True)
    assert figure.read_bytes().startswith(b"\x89PNG")
