"""Every function that draws, once, on small data: the picture holds what it should. Nothing is compared pixel by pixel."""

import numpy as np
import pytest

import demlaws as dl
from demlaws import plots
from demlaws.granite import figures
from demlaws.plots import surface
from demlaws.surface import self_affine

pytestmark = pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")
PAIR = dl.Contact(4.35e-3, 32.32e9, 2.4e-6, 2.22, 6.266e9)


@pytest.fixture(autouse=True)
def closed_afterwards():
    import matplotlib

    matplotlib.use("Agg")
    yield
    from matplotlib import pyplot

    pyplot.close("all")


def labels(ax):
    """Texts of the legends of an axes."""
    legends = [child for child in ax.get_children() if type(child).__name__ == "Legend"]
    return [text.get_text() for legend in legends for text in legend.get_texts()]


def lines(ax):
    """(x, y) of every line with points in it."""
    return [line.get_xydata() for line in ax.get_lines() if len(line.get_xydata())]


# --- single contacts


def test_path_figure():
    law = dl.law("hertz", PAIR)
    path = dl.driver.displacement_controlled(law, [1e-5, 5e-6], 20)
    left, right = plots.path_figure(path, law, "a title").axes
    first_loading = lines(right)[0]
    assert np.allclose(np.diff(np.log(first_loading[:, 0])), np.log(1e4) / 199)  # even in the logarithm
    np.testing.assert_array_equal(lines(left)[0], np.column_stack([path.overlap * 1e6, path.force]))
    assert left.get_title() == "a title" and right.get_xscale() == "log"


@pytest.mark.parametrize("bad", [{"ax": 3}, {"ax": "axes"}, {"colour": "red"}, {"color": 7}])
def test_axes_and_styles_that_are_none(bad):
    law = dl.law("hertz", PAIR)
    for result in law, law.follow([1e-7, 0.0]):
        with pytest.raises(dl.DemlawsError):
            result.plot(**bad)


def test_table_figure():
    law = dl.law("pohrt-popov", PAIR, "hertz")
    _, right = plots.table_figure(law.tabulate(1e-3), law).axes
    assert {"force", "stiffness", "tolerance"} == set(labels(right))
    drawn = dict(zip(labels(right), lines(right), strict=True))
    # the picture shows the certificate: no error above the tolerance, some near it
    assert 1e-5 < max(drawn["force"][:, 1].max(), drawn["stiffness"][:, 1].max()) <= 1e-3


def test_points_figure():
    force = np.geomspace(0.5, 50.0, 15)
    overlap = dl.law("rms", PAIR).overlap(force)
    table = dl.Table.from_points(np.column_stack([overlap, force]), PAIR)
    left, right = plots.points_figure(table, overlap, force).axes
    assert labels(left) == ["points", "table", "knots"] and right.get_xscale() == "log"
    np.testing.assert_allclose(lines(left)[0], np.column_stack([overlap * 1e6, force]))
    _, (at, curve), *_ = (xy.T for xy in lines(left))
    np.testing.assert_allclose(np.interp(overlap[3:] * 1e6, at, curve), force[3:], rtol=0.02)  # it goes through them


# --- the granite tests


def test_the_lines_of_hertz_and_of_pohrt_popov_cross_at_the_threshold():
    (ax,) = figures.crossover().axes
    assert "57.5 N" in ax.texts[0].get_text()
    hertz, rough = lines(ax)[:2]
    crossed = rough[:, 1] >= hertz[:, 1] * (1 - 1e-9)
    assert 50.0 < rough[np.argmax(crossed), 0] < 65.0


# --- advice


def test_fit_figure():
    force = np.linspace(1.0, 50.0, 20)
    displacement = dl.law("rms", PAIR).overlap(force) + 1e-8 * np.random.default_rng(0).standard_normal(20)
    ranking = dl.fit(np.column_stack([displacement, force]), PAIR, laws=["hertz", "rms"], unloading="elastic")
    left, right = plots.fit_figure(ranking, "of a test").axes
    assert labels(left)[0] == "measured of a test" and sorted(labels(right)) == ["hertz", "rms"]
    np.testing.assert_allclose(lines(left)[0], np.column_stack([displacement * 1e6, force]))


# --- surfaces


def test_regime_figure():
    fig = surface.regime_figure(PAIR, 10.0)
    star = [line for line in fig.axes[0].get_lines() if line.get_marker() == "*"]
    assert star[0].get_xydata().ravel().tolist() == pytest.approx([10.0, 2.4])


def test_surface_figure():
    heights = self_affine(128, 1e-6, 0.8, roughness=0.5e-6, seed=1)
    fig = surface.surface_figure(heights)
    assert f"Sq = {heights.sq * 1e6:.3g} µm" in fig.axes[0].get_title()
    np.testing.assert_array_equal(fig.axes[0].images[0].get_array(), heights.heights * 1e6)
    assert any("Df = " in ax.get_title() for ax in fig.axes)


def test_saved_in_the_format_of_its_name(tmp_path):
    fig, _ = plots.figure()
    assert plots.save(fig, tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    assert plots.save(fig, tmp_path / "a.pdf").read_bytes().startswith(b"%PDF")
    assert plots.save(fig, tmp_path / "bare").name == "bare.png"
    with pytest.raises(dl.DemlawsError, match=r"cannot draw .*a\.nonsense"):
        plots.save(fig, tmp_path / "a.nonsense")
    assert len(list(tmp_path.iterdir())) == 3
