"""The granite paper's figures by number: each draws, prints its numbers, and takes a user's points."""

import numpy as np
import pytest

from demlaws import granite
from demlaws.cli import main
from demlaws.granite import figures as pictures

pytestmark = pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")


@pytest.fixture(scope="module")
def paper():
    """The paper with points of SS(18-18) that follow Yip & Venart's law."""
    law = granite.bind("yip-venart", granite.find_test("SS(18-18)"), "elastic")
    force = np.geomspace(0.05, 100.0, 120)
    return pictures.Paper({"SS(18-18)": granite.Points(law.overlap(force) + 1e-6, force, "mine.csv")})


def texts(fig):
    return [t.get_text() for ax in fig.axes if ax.get_legend() for t in ax.get_legend().get_texts()]


@pytest.mark.parametrize("number", pictures.FIGURES)
def test_every_figure(paper, number):
    fig, said = pictures.FIGURES[number](paper)
    assert any(len(line.get_xydata()) > 2 for ax in fig.axes for line in ax.get_lines())
    assert "computed" in " ".join(said)  # what is said says whose number it is
    if number in (3, 4, 6, 8, 9):
        assert any("measured" in text for text in texts(fig)) and any("mine.csv" in line for line in said)
    if number in (11, 12, 13, 14):
        assert any("no measured points are public" in line for line in said)
        assert any("0.104 R at 450 N" in line or "R at 300 N" in line for line in [*said, *(ax.get_title() for ax in fig.axes)])


def test_numbers_said(paper):
    assert "computed 57.47 N" in pictures.FIGURES[5](paper)[1][0] and "printed around 73 N" in pictures.FIGURES[5](paper)[1][0]
    assert any("SS(18-18): hertz 10.6, rms 13.4, pohrt-popov 14.1" in line for line in pictures.FIGURES[6](paper)[1])
    assert any("SS(12-18), pohrt-popov" in line and "(1.70)" in line for line in pictures.FIGURES[4](paper)[1])


def test_tables_and_figures_by_command(tmp_path, capsys):
    assert main(["granite", "--tables", "--figures", "5", "--out", str(tmp_path)]) == 0
    text = capsys.readouterr().out
    assert "E* = 32.320 GPa" in text and "6.05/flat" in text and " 57.47 " in text and " 278.93 " in text
    assert "K_y = 5006 N/mm" in text and "K_y = 2436 N/mm" in text
    assert (tmp_path / "figure-05.png").stat().st_size > 10000
    with pytest.raises(SystemExit):
        main(["granite", "--figures", "10"])
    assert "the figures are 3, 4" in capsys.readouterr().err
    assert main(["granite", "--figures", "5", "--law", "rms"]) == 2


@pytest.mark.slow
def test_the_whole_command(tmp_path, capsys):
    """What `make granite` runs: tables, paths, claims and every figure."""
    assert main(["granite", "--out", str(tmp_path)]) == 0
    assert f"{len(list(tmp_path.iterdir()))} files written" in capsys.readouterr().out
    drawn = {file.stem for file in tmp_path.glob("*.png")}
    assert {f"force-{test.key}" for test in granite.TESTS} < drawn
    assert {"stiffness", "crossover-ss-18-18", "roughness", "plastic-overlap", "effective-radius"} < drawn
    paths = {file.name for file in tmp_path.glob("*.csv")}
    assert {
        f"{test.key}-{name}.csv" for test in granite.TESTS for name in granite.laws_for_tests() if len(test.stages) == 1
    } < paths
    assert {"summary.csv", "claims.csv"} < paths


def test_what_is_printed_of_the_stones_gives_what_is_printed_of_the_pairs():
    """Table 2 against itself: R and σ of the pair follow from both stones, to the digits printed."""
    for test in granite.TESTS:
        if test.bodies:
            (r1, s1, d1), (r2, s2, d2) = test.bodies
            assert 1.0 / (1.0 / r1 + 1.0 / r2) == pytest.approx(test.radius, abs=6e-6)
            assert np.hypot(s1, s2) == pytest.approx(test.roughness, abs=1.5e-8)
            assert 0.5 * (d1 + d2) == pytest.approx(test.fractal_dimension, abs=1e-9)
