"""The figures of Jamari & Schipper by number: what they draw, and that what is said beside them is what is drawn."""

import re

import numpy as np
import pytest

from demlaws import regime
from studies.jamari import cycles, published
from studies.jamari import figures as jamari
from studies.jamari.__main__ import main

pytestmark = pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")


def labels(ax):
    return [text.get_text() for text in ax.get_legend().get_texts()]


def curve(ax, label):
    return next(line.get_xydata() for line in ax.get_lines() if line.get_label() == label)


def test_central_pressure_against_roughness():
    """Fig. 1: the curves of section 9 of the physics at α = 1 and 5, the printed readings as marks."""
    picture, said = jamari.FIGURES_2006[1]()
    (ax,) = picture.axes
    for mu, at in ((4, {0.05: 0.933, 1.0: 0.475, 5.0: 0.164}), (17, {0.05: 0.956, 1.0: 0.535, 5.0: 0.186})):
        alpha, ratio = curve(ax, f"Greenwood & Tripp, μ = {mu}").T
        for x, wanted in at.items():
            assert np.interp(np.log(x), np.log(alpha), ratio) == pytest.approx(wanted, abs=2e-3)
    marks = {
        (float(x), float(y))
        for line in ax.get_lines()
        if line.get_marker() in "vs^"
        for x, y in line.get_xydata()
        if len(line.get_xydata()) == 1
    }
    assert marks == {(0.09, value) for value in published.PRINTED_RATIOS.values()}
    assert any("printed 0.925" in line and "computed 0.9201" in line for line in said)


def test_what_deforms_by_roughness():
    """Fig. 12: six tests at the values computed with the printed μ; the text says that they are not printed."""
    picture, said = jamari.FIGURES_2006[12]()
    (ax,) = picture.axes
    drawn = sorted(float(line.get_ydata()[0]) for line in ax.get_lines() if len(line.get_xydata()) == 1)
    assert drawn == pytest.approx([0.458, 0.569, 0.579, 0.585, 0.634, 1.087], abs=1e-3)
    assert "the paper prints none of them" in said[0]
    for value in drawn:
        assert any(f"{value:.3f}" in line for line in said)


def test_summits():
    """Fig. 2 of 2008: as the cut goes down nine-point summits become more, while patches merge."""
    picture, said = jamari.FIGURES_2008[2]()
    counts = [tuple(map(int, re.search(r": (\d+) micro.*, (\d+) nine", line).groups())) for line in said[:3]]
    volume, nine = zip(*counts, strict=True)
    assert nine[0] < nine[1] < nine[2] and max(volume) < nine[1]
    titles = [ax.get_title() for ax in picture.axes]
    assert sum(t.startswith("volume") for t in titles) == sum(t.startswith("nine-point") for t in titles) == 3


def test_repeated_contact_of_the_isotropic_surface():
    """Figs. 7 to 9: C_m printed and computed apart; the profiles coincide with a memory of the pressure, not without."""
    _, said = jamari.FIGURES_2008[7]()
    assert any("printed 0.16, by Eq. 4 0.159" in line for line in said)
    _, said = jamari.FIGURES_2008[8]()
    assert "25 plastic" in said[0] and said[0].count("1173.7") == 2  # all plastic: the area is P/(c_h H), and that is said
    picture, said = jamari.FIGURES_2008[9]()
    with_memory, without = picture.axes[0], picture.axes[2]
    profile = {ax: {line.get_label(): line.get_ydata() for line in ax.get_lines()} for ax in (with_memory, without)}
    assert set(profile[with_memory]) == {f"n = {n}" for n in (0, *jamari.CYCLES)}
    for ax, same in ((with_memory, True), (without, False)):
        change = np.max(np.abs(profile[ax]["n = 20"] - profile[ax]["n = 1"]))
        assert (change < 1e-3) == same
    assert [line.split(":")[0] for line in said[:3]] == [f"computed, memory {m}" for m in ("pressure", "blunting", "none")]


@pytest.mark.slow
def test_the_command(tmp_path, capsys):
    assert main(["--figures-2006", "1", "--figures-2008", "2,7-8", "--out", str(tmp_path)]) == 0
    assert "Fig. 1:" in capsys.readouterr().out
    drawn = {path.relative_to(tmp_path).as_posix() for path in tmp_path.rglob("*.png")}
    assert drawn == {"2006/figure-01.png", "2008/figure-02.png", "2008/figure-07.png", "2008/figure-08.png"}
    for given in (["--figures-2006", "3"], ["--figures-2008", "13"], ["--figures-2008", "x"]):
        with pytest.raises(SystemExit):
            main([*given, "--out", str(tmp_path)])


@pytest.mark.parametrize(("kind", "criterion"), [("isotropic", 0.16), ("anisotropic", 0.15)])
def test_repeated_contact_of_the_paper(kind, criterion):
    """0.2 N on aluminium: asperities only; plastic change in the first cycle, practically none after."""
    contact = published.published_contact(kind)
    assert regime.pressure_ratio(contact.pair, 0.2) == pytest.approx(criterion, abs=0.005)
    history = cycles.repeat(contact, 0.2, cycles=20, keep=(1, 2, 3, 10, 20))
    assert history[0].step.counts[1] + history[0].step.counts[2] > 0
    assert history[0].change > 0
    assert all(c.relative_change <= 0.01 for c in history[1:])
    assert cycles.run_in_cycle(history) == 1
    first = history[0].contact.heights.heights
    for cycle in history:
        if cycle.contact is not None:
            assert np.abs(cycle.contact.heights.heights - first).max() <= 0.01 * np.ptp(first - contact.heights.heights)
    assert history[-1].step.counts[1] <= 3 and history[-1].step.counts[2] == 0  # those that share a pixel of their rings
    area = history[0].step.contact_area
    assert history[-1].step.contact_area == pytest.approx(area, rel=0.01)
    assert len(cycles.repeat(contact, 0.2, cycles=20, stop=True)) == 2
