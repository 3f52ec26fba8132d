"""Every function that draws, once, on small data: the picture holds what it should. Nothing is compared pixel by pixel."""

import functools
from types import SimpleNamespace

import numpy as np
import pytest
from examples import make

import demlaws as dl
from demlaws import granite, plots
from demlaws.advice.choose import Choices, Plan
from demlaws.granite import figures
from demlaws.laws.registry import registry
from demlaws.plots import choose as advice
from demlaws.plots import surface
from demlaws.solvers.contact import RoughContact
from demlaws.solvers.summits import nine_point_summits
from demlaws.surface import self_affine
from studies.costs.costs import StepCost
from studies.extremes import extremes, stability
from studies.extremes import figure as extremes_figures
from studies.jamari import cycles, matching
from studies.jamari import figures as jamari
from studies.trade import candidates, packings, trade
from studies.trade import figure as trade_figures
from studies.validation import figure as validation

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


@functools.cache
def run_of(name, test):
    return granite.run_test(name, granite.find_test(test))[0]


# --- single contacts


def path_figure():
    path = dl.driver.displacement_controlled(dl.law("hertz", PAIR), [1e-5, 5e-6], 20)
    left, right = plots.path_figure(path, "a title").axes
    np.testing.assert_array_equal(lines(left)[0], np.column_stack([path.overlap * 1e6, path.force]))
    assert left.get_title() == "a title" and right.get_xscale() == "log"


def table_figure():
    law = dl.law("pohrt-popov", PAIR, "hertz")
    _, right = plots.table_figure(law.tabulate(1e-3), law).axes
    assert {"force", "stiffness", "tolerance"} == set(labels(right))
    drawn = dict(zip(labels(right), lines(right), strict=True))
    # the picture shows the certificate: no error above the tolerance, some near it
    assert 1e-5 < max(drawn["force"][:, 1].max(), drawn["stiffness"][:, 1].max()) <= 1e-3


def points_figure():
    force = np.geomspace(0.5, 50.0, 15)
    overlap = dl.law("rms", PAIR).overlap(force)
    table = dl.Table.from_points(overlap, force, PAIR)
    left, right = plots.points_figure(table, [(overlap, force)]).axes
    assert labels(left) == ["points", "table", "knots"] and right.get_xscale() == "log"
    np.testing.assert_allclose(lines(left)[0], np.column_stack([overlap * 1e6, force]))
    _, (at, curve), *_ = (xy.T for xy in lines(left))
    np.testing.assert_allclose(np.interp(overlap[3:] * 1e6, at, curve), force[3:], rtol=0.02)  # it goes through them


# --- the granite tests


def force():
    runs = [run_of("hertz", "SS(18-18)"), run_of("pohrt-popov", "SS(18-18)")]
    (ax,) = figures.force(runs[0].test, runs).axes
    assert labels(ax) == ["hertz", "pohrt-popov"] and ax.get_title() == "SS(18-18)"
    assert ax.get_lines()[0].get_color() == plots.colour("hertz")


def cycling():
    run = run_of("rough-plastic", "RFC10")
    left, right = figures.cycling(run).axes
    assert len(lines(left)) == len(run.paths) and "Hertz" in labels(right)


def test_measured_points_are_laid_over_stiffness_cycles_and_residuals():
    run, smooth = run_of("rough-plastic", "RFC10"), run_of("hertz", "SS(18-18)")
    path, up = run.paths[0], np.geomspace(0.05, 100.0, 200)
    keep = np.unique(np.linspace(1, path.force.size - 1, 1200).astype(int))
    points = granite.Points(path.overlap[keep] + 2e-6, path.force[keep], "mine.csv")
    paper = figures.Paper({"RFC10": points, "SS(18-18)": granite.Points(smooth.law.overlap(up), up, "mine.csv")}, [run, smooth])
    left, right = figures.FIGURES[12](paper)[0].axes
    assert "measured: mine.csv" in labels(left)
    assert len([text for text in labels(right) if text.startswith("measured, to")]) == 6
    (ax,) = figures.FIGURES[13](paper)[0].axes
    laws, mine = lines(ax)[:2]
    np.testing.assert_allclose(laws[:, 1], [s.plastic_overlap * 1e6 for s in granite.stages_of(run)])
    np.testing.assert_allclose(mine[:, 0], laws[:, 0], rtol=0.02)
    np.testing.assert_allclose(mine[:, 1], laws[:, 1], rtol=0.05, atol=0.2)
    law, *_, mine = lines(figures.FIGURES[8](paper)[0].axes[0])
    np.testing.assert_allclose(np.interp(mine[5:-1, 0], law[:, 0], law[:, 1]), mine[5:-1, 1], rtol=0.02)


def test_the_lines_of_hertz_and_of_pohrt_popov_cross_at_the_threshold():
    (ax,) = figures.FIGURES[5](figures.Paper())[0].axes
    assert "57.5 N" in ax.texts[0].get_text()
    hertz, rough = lines(ax)[:2]
    crossed = rough[:, 1] >= hertz[:, 1] * (1 - 1e-9)
    assert 50.0 < rough[np.argmax(crossed), 0] < 65.0


def test_unloading_is_drawn_from_the_maximum():
    (ax,) = figures.FIGURES[7](figures.Paper())[0].axes
    assert labels(ax)[0] == "hertz, elastic" and labels(ax)[-1] == "Hertz unloading rule, any law"
    assert all(np.max(xy[:, 0]) < 1e-6 for xy in lines(ax))


# --- advice and measurements


def fit_figure():
    force = np.linspace(1.0, 50.0, 20)
    displacement = dl.law("rms", PAIR).overlap(force) + 1e-8 * np.random.default_rng(0).standard_normal(20)
    ranking = dl.fit(np.column_stack([displacement, force]), PAIR, laws=["hertz", "rms"], unloading="elastic")
    left, right = advice.fit_figure(ranking, "of a test").axes
    assert labels(left)[0] == "measured of a test" and sorted(labels(right)) == ["hertz", "rms"]
    np.testing.assert_allclose(lines(left)[0], np.column_stack([displacement * 1e6, force]))


def choices_figure():
    def choice(name, evaluation, cost, error):
        plan = Plan(name, (), "hertz", evaluation)
        return SimpleNamespace(
            plan=plan, name=name, unloading="hertz", evaluation=evaluation, cost=cost, error=error, meets=True
        )

    made = [choice("hertz", "closed form", 1.0, 1e-2), choice("rms", "table", 3.0, 1e-4)]
    scene = SimpleNamespace(tolerance=0.05, quantity="force", name="mine")
    (ax,) = advice.choices_figure(Choices(made, scene, made[0].plan, {}, [])).axes
    assert {"closed form", "table", "tolerance"} <= set(labels(ax)) and ax.get_title() == "mine"
    assert "rms, hertz, table" in labels(ax)


def stability_figure():
    zero = dict.fromkeys(stability.Figures._fields, 0)
    row = stability.Figures(
        **{**zero, "law": "hertz", "unloading": "elastic", "evaluation": "closed form", "contacts": "extreme"}
        | {"rounding": {-3: 1.0, 0: 2.0}, "gains": {10: 1e-2, 100: 1e-6}, "step_ratio": (0.6, 0.9)}
    )
    compared = extremes.Compared(0, 1e-15, {-3: 2.0, -1: 0.0}, 2.0, 5, 0.0, 0.0, 0)
    impacts = extremes.Impacts(1e-9, 1e-6, {20: 1e-3, 50: 1e-5})
    inside = extremes.Figures("YADE", "hertz", "elastic", "closed form", "extreme", 10, 100, compared, 0.0, 100, impacts, {})
    assert len(extremes_figures.stability_figure([], [inside]).axes) == 2
    gains, rounding, steps, engine = extremes_figures.stability_figure([row], [inside]).axes
    np.testing.assert_allclose(lines(gains)[0], [[10, 1e-2], [100, 1e-6]])
    np.testing.assert_allclose(lines(rounding)[0], [[-3, 1.0], [0, 2.0]])
    assert lines(steps)[0][:, 0].tolist() == [0.6, 0.9] and "YADE" in labels(engine)


def entry(law, evaluation, ns, error, front=False):
    return trade.Entry(law, "hertz", evaluation, "", ns, 2.0, 16, 0, {"force": error}, {"force": error}, front)


def trade_figure():
    entries = [entry("hertz", "closed form", 1.0, 0.5, True), entry("rough-plastic", "closed form", 2.0, 1e-15, True)]
    entries += [entry("rough-plastic", "table", 3.0, 1e-5)]
    steps = [trade.StepEntry(10, 1e-2, 1e-2, 9.0), trade.StepEntry(100, 1e-9, 1e-7, 90.0)]
    stock = candidates.Way("YADE's Hertz-Mindlin", model="hertz")
    engine = [trade.EngineEntry(StepCost(stock, 300.0, 1.0, 0.0, 0.5), 1.2, True)]
    fig = trade_figures.trade_figure(entries, 0.5, steps, {"yade": engine})
    against, own, step, yade = fig.axes[:4]
    assert labels(against) == ["hertz, hertz", "rough-plastic, hertz"]  # one marker a law and rule
    assert "rough-plastic" in labels(own) and "hertz" not in labels(own)
    assert sorted(line[0, 0] for line in lines(own) if len(line) == 1) == [1.5]  # over the closed form's cost
    assert labels(step) == ["energy drift of an impact", "error of restitution"]
    assert "YADE's Hertz-Mindlin" in labels(yade)
    assert len(trade_figures.trade_figure(entries, 0.5).axes) == 2


def scene_figure():
    forces = np.random.default_rng(1).exponential(5.0, 100)
    one = packings.Outcome(candidates.RICHEST, 1e-2, 1e8, 2e8, 3e8, 5e5, forces, 100, 1.0)
    other = one._replace(way=candidates.Way("hertz", "hertz"), low=1.5e8)
    left, right = trade_figures.scene_figure({"yade": [one, other]}, packings.QUICK).axes
    widths = [bar.get_width() for bar in left.patches]
    assert len(widths) == 6 and max(widths) == pytest.approx(50.0)
    assert labels(right) == ["rough-plastic, thornton", "hertz"]


def deviations():
    row = SimpleNamespace(verdict="pass", found=1.05, low=0.9, high=1.1)
    worse = SimpleNamespace(verdict="FAIL", found=1.2, low=0.9, high=1.1)
    (ax,) = validation.deviations({"one": [row], "two": [row, worse]}).axes
    assert [t.get_text() for t in ax.get_yticklabels()] == ["one", "two"]
    found = np.concatenate(lines(ax))
    assert np.isclose(found[:, 0], 2.0).sum() == 1 and np.isclose(found[:, 0], 0.5).sum() == 2


# --- surfaces


@functools.cache
def rough():
    """A small map under load, and three cycles of it."""
    pair = dl.Contact(radius=5e-3, modulus=50e9, hardness=1e9)
    contact = RoughContact(self_affine(64, 1e-6, 0.8, 0.5e-6, 1), pair, flat=True)
    return contact, cycles.repeat(contact, 0.02, 3, keep=(1, 2, 3))


def regime_figure():
    assert len(jamari.regime_map().axes) > 2  # the published tests, by material, and the key of the map
    fig = surface.regime_figure(PAIR, 10.0, "mine")
    star = [line for line in fig.axes[0].get_lines() if line.get_marker() == "*"]
    assert star[0].get_xydata().ravel().tolist() == pytest.approx([10.0, 2.4])


def surface_figure():
    heights = self_affine(128, 1e-6, 0.8, 0.5e-6, 1)
    fig = surface.surface_figure(heights)
    assert f"Sq = {heights.sq * 1e6:.3g} µm" in fig.axes[0].get_title()
    np.testing.assert_array_equal(fig.axes[0].images[0].get_array(), heights.heights * 1e6)
    assert any("Df = " in ax.get_title() for ax in fig.axes)


def contact_figure():
    contact, history = rough()
    left, right, *_ = surface.contact_figure(contact, history[0].step).axes
    assert len(left.collections[0].get_offsets()) == len(history[0].step.micro)
    assert sum(len(xy) for xy in lines(right)) == len(history[0].step.micro)


def repeated_figure():
    contact, history = rough()
    fig = cycles.repeated_figure(contact, history, "mine")
    assert fig.axes[0].get_title().startswith("mine before")
    before, after, change = (ax.images[0].get_array() for ax in fig.axes[:3])
    np.testing.assert_allclose(after - before, change, atol=1e-12)
    assert np.min(change) < 0.0  # it wears


def nine_point_figure():
    heights = self_affine(64, 1e-6, 0.8, 0.5e-6, 1)
    left, right, *_ = surface.nine_point_figure(heights).axes
    count = len(nine_point_summits(heights)[0])
    assert left.get_title() == f"{count} nine-point summits" and len(lines(right)[0]) == count


def change_figure():
    heights = self_affine(96, 1e-6, 0.8, 0.5e-6, 1, shortest=5e-6)
    lower = heights.heights.copy()
    lower[40:50, 30:40] -= 1e-6
    match = matching.matched(heights, heights.with_heights(lower))
    _, middle, right, *_ = matching.change_figure(heights, match).axes
    np.testing.assert_allclose(np.asarray(middle.images[0].get_array()), match.difference.heights * 1e6)
    assert np.nanmin(lines(right)[0][:, 1]) == pytest.approx(-1.0, abs=0.05)


def law_figure():
    law = make("asperity")
    contact = RoughContact(registry()["asperity"].example["surface"], law.contact)
    left, right = surface.law_figure(contact, {"loading": law}).axes
    assert labels(left) == ["Hertz", "loading", "model, one cut each"] and labels(right) == ["Hertz", "loading"]


def boundary_element_figure():
    values = {"overlap": "1e-6", "bem_force": "2.0", "model_force": "1.0", "bem_area": "1e-9", "model_area": "9e-10"}
    rows = [{"case": "a", **values}, {"case": "b", **values}, {"case": "a", **values, "overlap": "2e-6"}]
    left, right = validation.boundary_element_figure(rows).axes
    np.testing.assert_allclose(lines(left)[0], [[1.0, 0.5], [2.0, 0.5]])
    np.testing.assert_allclose(lines(right)[1], [[1.0, 0.9]])
    assert labels(left) == ["a", "b"]


DRAWN = {
    function.__name__: function
    for function in (
        *(path_figure, table_figure, points_figure, force),
        *(cycling, fit_figure, choices_figure),
        *(stability_figure, trade_figure, scene_figure, deviations, regime_figure, surface_figure),
        *(contact_figure, repeated_figure, nine_point_figure, change_figure, law_figure, boundary_element_figure),
    )
}


@pytest.mark.parametrize("name", DRAWN)
def test_draws(name):
    DRAWN[name]()


def test_every_law_has_a_line_of_its_own():
    looks = {(plots.colour(name), plots.line(name)) for name in registry()}
    assert len(looks) == len(registry())


def test_saved_in_the_format_of_its_name(tmp_path):
    fig, _ = plots.figure()
    assert plots.save(fig, tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    assert plots.save(fig, tmp_path / "a.pdf").read_bytes().startswith(b"%PDF")
    assert plots.save(fig, tmp_path / "bare").name == "bare.png"
    with pytest.raises(dl.DemlawsError, match=r"cannot draw .*a\.nonsense"):
        plots.save(fig, tmp_path / "a.nonsense")
    assert len(list(tmp_path.iterdir())) == 3
