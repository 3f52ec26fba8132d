"""The figures of Altuhafi, Baudet & Coop 2023 (granite contacts), each with the numbers in it and who says them.

Every function takes a `Paper` and returns (figure, lines of text). The measured points of the paper are not public: a law's
curve stands where they would be, and a user's points are laid over it.
"""

import functools

import numpy as np

from demlaws import granite
from demlaws.laws.names import BAHRAMI, HERTZ, POHRT_POPOV, RMS, ROUGH_PLASTIC, YIP_VENART
from demlaws.plots import colour, draw_line, figure

MICRO = 1e6
COMPARED = (HERTZ, RMS, POHRT_POPOV)
"""The laws that the paper draws for unloading and for cones."""
SPHERES = (HERTZ, RMS, POHRT_POPOV, BAHRAMI, YIP_VENART)
"""The laws that it draws for spheres."""
PRINTED_THRESHOLD = 73.0
"""Load [N] of the paper's text at which SS(18-18) crosses over to Hertz."""


def force(test, runs, points=None, ax=None):
    """Force against displacement of one test, every law; displacement counted from 0.1 N as in the tables."""
    if ax is None:
        _, ax = figure(width=6.4, height=4.8)
    for run in runs:
        path = run.paths[0]
        zero = float(
            np.interp(0.1, path.force[: int(np.argmax(path.force)) + 1], path.overlap[: int(np.argmax(path.force)) + 1])
        )
        end = _first_peak(path.force) if test.cyclic else path.force.size
        draw_line(ax, (path.overlap[:end] - zero) * MICRO, path.force[:end], run.law.name, lw=1.5)
    if points is not None:
        zero, placed_by = points.zero([run.law for run in runs])
        label = f"measured: {points.source}" + (f" (placed by {placed_by.name})" if placed_by is not None else "")
        ax.plot((points.displacement - zero) * MICRO, points.force, "k.", ms=3, label=label)
    ax.set(xlabel="displacement from 0.1 N (µm)", ylabel="force (N)", title=test.name, ylim=(0, None))
    ax.set_xlim(left=-0.05 * ax.get_xlim()[1])
    ax.legend(fontsize=8)
    return ax.figure


def _first_peak(force):
    falls = np.flatnonzero(np.diff(force) < 0)
    return int(falls[0]) + 1 if falls.size else force.size


def _tangent(ax, points, name="measured", branch=None, **style):
    """Stiffness of measured points: slopes over windows of force."""
    load, stiffness = points.tangent(branch)
    ax.plot(load, stiffness / 1e3, **{"marker": ".", "ls": "none", "color": "k", "ms": 4, **style}, label=name)


def _step_colour(number, count):
    """Colours of a sequence, as many as there are steps, from dark to light."""
    from matplotlib import colormaps

    return colormaps["viridis"](0.9 * number / max(count - 1, 1))


def cycling(run, points=None):
    """Cycles of a cone: force against displacement stage by stage, and stiffness of each loading branch; points: measured."""
    fig, (left, right) = figure(columns=2, width=5.6, height=4.4)
    for number, path in enumerate(run.paths):
        label = f"stage {number + 1}" if len(run.paths) > 1 else run.law.name
        # later stages are thinner: they lie over the earlier ones that they repeat
        width = 1.0 + 0.5 * (len(run.paths) - 1 - number)
        left.plot(path.overlap * MICRO, path.force, color=_step_colour(number, len(run.paths)), lw=width, label=label)
    if points is not None:
        start = points.displacement[0]
        left.plot((points.displacement - start) * MICRO, points.force, "k.", ms=2, label=f"measured: {points.source}")
    title = f"{run.test.name}: {run.law.name}, {run.law.unloading} unloading"
    left.set(xlabel="overlap (µm)", ylabel="force (N)", title=title + (f"\n{run.beyond}" if run.beyond else ""))
    left.title.set_fontsize(9 if run.beyond else 12)
    path = run.paths[0] if len(run.paths) == 1 else run.paths[3]
    rising = np.flatnonzero(np.r_[False, np.diff(path.force) > 0] & (path.force > 0.5))
    branches = np.split(rising, np.flatnonzero(np.diff(rising) > 1) + 1)
    for number, branch in enumerate(branches):
        right.loglog(
            path.force[branch],
            path.stiffness[branch] / 1e3,
            lw=1.2 + 0.5 * (len(branches) - 1 - number),
            color=_step_colour(number, len(branches)),
            label=f"to {path.force[branch].max():.0f} N",
        )
    load = np.geomspace(0.5, path.force.max(), 100)
    hertz = (6.0 * load * run.test.radius * run.test.contact.modulus**2) ** (1 / 3)
    right.loglog(load, hertz / 1e3, "k--", lw=1, label="Hertz")
    if points is not None:
        for number, branch in enumerate(measured := points.branches()):
            top = points.force[branch[1]]
            _tangent(right, points, f"measured, to {top:.0f} N", branch, color=_step_colour(number, len(measured)), marker="x")
    right.set(xlabel="force (N)", ylabel="stiffness (N/mm)", title="loading stiffness, stage by stage")
    left.legend(fontsize=8)
    right.legend(fontsize=7)
    return fig


class Paper:
    """The tests, run once per law, and a user's points by test name; runs: those that were made before."""

    def __init__(self, points=None, runs=()):
        self.points = points or {}
        self.known = {(run.law.name, run.test.name): run for run in runs}
        self.run = functools.cache(self._run)
        self.law = functools.cache(self._law)

    def _run(self, name, test):
        return self.known.get((name, test)) or granite.run_test(name, granite.find_test(test))[0]

    def _law(self, name, test):
        return granite.bind(name, granite.find_test(test), "elastic")

    def yielding(self, test):
        """The run of the law whose bulk yields."""
        return self.run(ROUGH_PLASTIC, test)

    def whose(self, *tests):
        """What to say of the points behind a figure."""
        given = [f"{test}: {self.points[test].source}" for test in tests if test in self.points]
        return (
            f"measured points of {'; '.join(given)}" if given else "no measured points are public, and none were given (--data)"
        )


def _gained(paper, test, names):
    return ", ".join(f"{name} {granite.displacement_gained(paper.law(name, test)) * MICRO:.1f}" for name in names)


def displacements(paper):
    """Fig. 3: force against displacement of three pairs of spheres of similar R and different roughness, and of Hertz."""
    fig, ax = figure(width=6.4, height=4.8)
    tests = ("SS(18-18)", "VS(18-18)", "RS(18-18)")
    load = np.geomspace(0.1, 100.0, 200)
    said = ["displacement gained from 0.1 to 100 N (µm), computed:"]
    for name, shade in zip(tests, ("#1f77b4", "#2ca02c", "#d62728"), strict=True):
        test = granite.find_test(name)
        for law, style in ((POHRT_POPOV, "-"), (HERTZ, "--")):
            one = paper.law(law, name)
            overlap = (one.overlap(load) - one.overlap(0.1)) * MICRO
            label = f"{name}, σ = {test.roughness * MICRO:.2f} µm: {law}" if law != HERTZ else f"{name}: hertz"
            ax.plot(overlap, load, style, color=shade, lw=1.6 if style == "-" else 0.9, label=label)
        _measured(ax, paper, name, shade)
        said.append(f"  {name} (σ = {test.roughness * MICRO:.2f}, printed): {_gained(paper, name, COMPARED)}")
    ax.set(xlabel="displacement from 0.1 N (µm)", ylabel="force (N)", title="spheres of similar radius", xlim=(0, None))
    ax.legend(fontsize=7)
    return fig, [*said, paper.whose(*tests)]


def _measured(ax, paper, name, shade):
    if name in paper.points:
        points = paper.points[name]
        zero, _ = points.zero([paper.law(POHRT_POPOV, name)])
        ax.plot((points.displacement - zero) * MICRO, points.force, ".", color=shade, ms=3, label=f"{name}: measured")


def radius(paper):
    """Fig. 4: a*/a_H against α: Eq. 5, Greenwood & Tripp, and a* back-calculated (a*² = Rδ) from each law and from points."""
    alpha = np.geomspace(0.03, 30.0, 60)
    fig, ax = figure(width=6.0, height=4.4)
    for (name, values), style in zip(granite.effective_radius(alpha).items(), ("-", "--", ":"), strict=True):
        ax.semilogx(alpha, values, style, lw=1.6, label=name)
    ax.axvspan(1.0, alpha.max(), color="k", alpha=0.05, lw=0)
    ax.text(1.1, 0.04, "beyond the data of the fit", fontsize=8, transform=ax.get_xaxis_transform())
    said = ["a*/a_H back-calculated from δ (a*² = Rδ) at 1, 10 and 100 N, computed; α in brackets:"]
    load, shown = np.geomspace(0.3, 100.0, 12), np.array([1.0, 10.0, 100.0])
    for name, marker in zip(granite.ROUGH_SPHERES, "o^sv", strict=True):
        test = granite.find_test(name)
        for law in SPHERES[1:]:
            one = paper.law(law, name)
            hertz = (9.0 * load**2 / (16.0 * test.radius * test.contact.modulus**2)) ** (1 / 3)
            ax.plot(test.roughness / hertz, np.sqrt(one.overlap(load) / hertz), marker, color=colour(law), ms=3.5, mfc="none")
            if law == POHRT_POPOV:
                at = test.contact.roughness_parameter(shown)
                size = np.sqrt(one.overlap(shown) * at / test.roughness)
                text = ", ".join(f"{s:.2f} ({a:.2f})" for s, a in zip(size, at, strict=True))
                said.append(f"  {name}, {law}: {text}")
        ax.plot([], [], "k" + marker, mfc="none", ms=4, label=f"laws on {name}")
        if name in paper.points:
            ax.plot(*paper.points[name].contact_radius(test.contact), "k" + marker, ms=3, label=f"measured {name}")
    for law in SPHERES[1:]:
        ax.plot([], [], "s", color=colour(law), ms=4, label=law)
    ax.set(xlabel="α = σR/a_H²", ylabel="a*/a_H", title="effective contact radius", ylim=(0.8, 4.5))
    ax.legend(fontsize=7, ncol=2)
    return fig, [
        *said,
        "the laws count δ from first touch, Yip-Venart by its continuation; measured points from their first",
        paper.whose(*granite.ROUGH_SPHERES),
    ]


def crossover(paper):
    """Fig. 5: stiffness of Hertz and of Pohrt-Popov, and where the lines cross."""
    test = granite.find_test("SS(18-18)")
    threshold, load = granite.threshold_force(test), np.geomspace(1.0, 500.0, 300)
    fig, ax = figure(width=6.0, height=4.4)
    for name in (HERTZ, POHRT_POPOV):
        law = paper.law(name, test.name)
        draw_line(ax, load, law.stiffness(law.overlap(load)) / 1e3, name, lw=1.6)
    ax.axvline(threshold, color="k", lw=0.8)
    text = f"F = {threshold:.1f} N\n(the paper's text: {PRINTED_THRESHOLD:g} N)"
    ax.annotate(text, (threshold, 2000), xytext=(5, 0), textcoords="offset points")
    ax.set(xscale="log", yscale="log", xlabel="force (N)", ylabel="stiffness (N/mm)", title=f"{test.name}: crossover")
    ax.legend()
    return fig, [
        f"F: computed {threshold:.2f} N from the paper's Eqs. 8 and 9 and its table; printed around {PRINTED_THRESHOLD:g} N"
    ]


def loading(paper):
    """Fig. 6: monotonic loading of four tests with every law."""
    tests = ("SS(18-18)", "SS(12-18)", "SF(12)", "RS(18-18)")
    fig, axes = figure(columns=2, rows=2, width=5.4, height=4.2)
    said = ["displacement gained from 0.1 to 100 N (µm), computed:"]
    for ax, name in zip(np.ravel(axes), tests, strict=True):
        runs = [paper.run(law, name) for law in SPHERES]
        force(runs[0].test, [run._replace(paths=(_up(run.paths[0]),)) for run in runs], paper.points.get(name), ax)
        said.append(f"  {name}: {_gained(paper, name, SPHERES)}")
    return fig, [*said, paper.whose(*tests)]


def _up(path):
    """A path as far as its largest force."""
    end = int(np.argmax(path.force)) + 1
    return path[:end]


def unloading(paper):
    """Fig. 7: unloading of SS(12-18) along each law's own curve, as the paper compares them, and along the Hertz rule's."""
    test = granite.find_test("SS(12-18)")
    laws = [paper.law(name, test.name) for name in COMPARED]
    fig, ax = figure(width=6.4, height=4.8)
    top = max(test.stages[0])
    load = np.linspace(0.05, top, 300)
    for law in laws:
        gained = (law.overlap(load) - law.overlap(top)) * MICRO
        draw_line(ax, gained, load, law.name, label=f"{law.name}, elastic", lw=1.3)
    path = paper.run(POHRT_POPOV, test.name).paths[0]
    back = slice(int(np.argmax(path.force)), None)
    left = (path.overlap[back] - path.overlap[back][0]) * MICRO
    ax.plot(left, path.force[back], color="k", lw=3, alpha=0.35, label="Hertz unloading rule, any law")
    if test.name in paper.points:
        points = paper.points[test.name]
        back = slice(int(np.argmax(points.force)), None)
        left = (points.displacement[back] - points.displacement[back][0]) * MICRO
        ax.plot(left, points.force[back], "k.", ms=3, label="measured")
    ax.set(xlabel="displacement from the maximum (µm)", ylabel="force (N)", title=f"{test.name}: unloading")
    ax.legend(fontsize=8)
    recovered = ", ".join(f"{law.name} {float(law.overlap(100.0) - law.overlap(0.1)) * MICRO:.1f}" for law in laws)
    return fig, [
        f"displacement recovered from 100 to 0.1 N along each law's own curve (µm), computed: {recovered}",
        paper.whose(test.name),
    ]


def stiffness(paper):
    """Fig. 8: stiffness against load of four tests, on logarithmic axes."""
    tests = ("SS(18-18)", "RS(18-18)", "SS(12-18)", "SF(12)")
    fig, axes = figure(columns=2, rows=2, width=5.0)
    load, said = np.geomspace(0.1, 100.0, 200), ["stiffness at 10 N (N/mm), computed:"]
    for ax, name in zip(np.ravel(axes), tests, strict=True):
        for law in (paper.law(n, name) for n in SPHERES):
            draw_line(ax, load, law.stiffness(law.overlap(load)) / 1e3, law.name, lw=1.3)
        if name in paper.points:
            _tangent(ax, paper.points[name], f"measured: {paper.points[name].source}")
        ax.set(xscale="log", yscale="log", xlabel="force (N)", ylabel="stiffness (N/mm)", title=name)
        ax.legend(fontsize=7)
        row = ", ".join(f"{law} {granite.stiffness_at(paper.law(law, name), 10.0) / 1e3:.0f}" for law in SPHERES)
        said.append(f"  {name}: {row}")
    return fig, [*said, paper.whose(*tests)]


def roughness(paper):
    """Fig. 9: force and stiffness of Pohrt-Popov on three pairs that differ in roughness, and of Hertz."""
    tests = [granite.find_test(name) for name in ("VS(18-18)", "SS(18-18)", "RS(18-18)")]
    fig, (left, right) = figure(columns=2)
    load, said = np.geomspace(0.05, 100.0, 300), ["exponent of stiffness over load, computed; printed: around 0.56"]
    lines = [(POHRT_POPOV, test, "-", shade) for test, shade in zip(tests, ("#1f77b4", "#ff7f0e", "#d62728"), strict=True)]
    for name, test, style, shade in [*lines, (HERTZ, tests[1], "--", "k")]:
        law = paper.law(name, test.name)
        overlap = law.overlap(load)
        label = f"Hertz, {test.name}" if name == HERTZ else f"{test.name}, σ = {test.roughness * MICRO:.2f} µm"
        left.plot((overlap - law.overlap(0.1)) * MICRO, load, style, color=shade, label=label)
        right.loglog(load, law.stiffness(overlap) / 1e3, style, color=shade, label=label)
        if name != HERTZ:
            exponent = 0.2567 * test.fractal_dimension
            said.append(
                f"  {test.name}: m = 0.2567 Df = {exponent:.3f} (Df = {test.fractal_dimension}, mean of the printed two)"
            )
            _measured(left, paper, test.name, shade)
            if test.name in paper.points:
                _tangent(right, paper.points[test.name], color=shade)
    left.set(xlabel="displacement from 0.1 N (µm)", ylabel="force (N)", title="effect of roughness, Pohrt-Popov")
    right.set(xlabel="force (N)", ylabel="stiffness (N/mm)", title="tangent stiffness")
    left.legend(fontsize=8)
    return fig, [*said, paper.whose(*(t.name for t in tests))]


def cone(paper):
    """Fig. 11: RFC10, loading and unloading, and its first loading to 20 N with the elastic laws."""
    run, test = paper.yielding("RFC10"), granite.find_test("RFC10")
    fig, (left, right) = figure(columns=2, width=5.6, height=4.4)
    _path(left, run.paths[0], paper.points.get(test.name), run)
    left.set(title=f"{test.name}: {run.law.name}, {run.law.unloading} unloading" + (f"\n{run.beyond}" if run.beyond else ""))
    left.title.set_fontsize(9)
    force(test, [paper.run(name, test.name) for name in COMPARED], None, right)
    if test.name in paper.points:
        points = paper.points[test.name]
        first = points.first_loading() & (points.force <= 20.0)
        zero, _ = points.zero([paper.law(name, test.name) for name in COMPARED])
        right.plot((points.displacement[first] - zero) * MICRO, points.force[first], "k.", ms=3, label="measured")
        right.legend(fontsize=8)
    right.set_title("first loading to 20 N")
    said = [f"computed: yields at {run.law.params.yield_force:.1f} N (printed: elastic models hold to 20 N); {test.assumed}"]
    return fig, [*said, *([run.beyond] if run.beyond else []), paper.whose(test.name)]


def _path(ax, path, points, run):
    ax.plot(path.overlap * MICRO, path.force, color=colour(run.law.name), lw=1.4, label=run.law.name)
    if points is not None:
        ax.plot((points.displacement - points.displacement[0]) * MICRO, points.force, "k.", ms=2, label="measured")
    ax.set(xlabel="displacement (µm)", ylabel="force (N)")
    ax.legend(fontsize=8)


def cycles(paper):
    """Fig. 12: stiffness of the loading stages of RFC10."""
    run = paper.yielding("RFC10")
    rows = [f"  to {s.maximum_force:.0f} N: {s.final_stiffness / 1e3:.0f} N/mm at the maximum" for s in granite.stages_of(run)]
    said = ["computed (p_y was chosen for the 5000 N/mm that is printed):", *rows, paper.whose("RFC10")]
    return cycling(run, paper.points.get("RFC10")), said


def plastic(paper):
    """Fig. 13: cumulative plastic deformation of both cones against the largest load."""
    fig, ax = figure(width=5.6, height=4.2)
    said = ["plastic overlap (µm) at the largest load (N), computed:"]
    for name, stage, marker in (("RFC10", 1, "o"), ("FC5", 4, "s")):
        rows = [s for s in granite.stages_of(paper.yielding(name)) if s.stage == stage]
        ax.plot([s.maximum_force for s in rows], [s.plastic_overlap * MICRO for s in rows], marker + "-", label=name)
        said.append(f"  {name}: " + ", ".join(f"{s.plastic_overlap * MICRO:.1f} at {s.maximum_force:.0f}" for s in rows))
        if name in paper.points and (left := paper.points[name].residuals()):
            load, residual = np.array(left).T
            ax.plot(load, residual * MICRO, "k" + marker, mfc="none", ls="none", label=f"{name}, measured")
    ax.set(xlabel="largest force (N)", ylabel="cumulative plastic overlap (µm)", title="plastic overlap of the cones")
    ax.legend()
    return fig, [*said, *filter(None, [paper.yielding("RFC10").beyond]), paper.whose("RFC10", "FC5")]


def stages(paper):
    """Fig. 14: the five stages of FC5, the first two to 20 N beside three elastic laws."""
    run, test = paper.yielding("FC5"), granite.find_test("FC5")
    fig, axes = figure(columns=3, rows=2, width=4.4, height=3.6)
    first, *others = np.ravel(axes)
    force(test, [paper.run(name, test.name) for name in (*COMPARED, run.law.name)], paper.points.get(test.name), first)
    first.set_title("a: first loading to 20 N", fontsize=10)
    points = paper.points.get(test.name)
    top = 0.0 if points is None else float(points.force.max())
    nearest = min(range(2, 6), key=lambda n: abs(max(test.stages[n - 1]) - top))  # whose largest load the points have
    for ax, number, letter in zip(others, (2, 3, 4, 5), "bcde", strict=False):
        _path(ax, run.paths[number - 1], points if number == nearest else None, run)
        tops = ", ".join(f"{force:g}" for force in test.stages[number - 1] if force > 0.0)
        ax.set_title(f"{letter}: to {tops} N" + (" (the tip that fails is not modelled)" if number == 5 else ""), fontsize=9)
    others[-1].set_axis_off()
    said = [f"computed: yields at {run.law.params.yield_force:.1f} N (printed: Pohrt-Popov good below 7 N); {test.assumed}"]
    for s in granite.stages_of(run):
        said.append(f"  stage {s.stage}, to {s.maximum_force:.0f} N: plastic overlap {s.plastic_overlap * MICRO:.1f} µm")
    return fig, [*said, *filter(None, [run.beyond]), paper.whose(test.name)]


FIGURES = {
    3: displacements,
    4: radius,
    5: crossover,
    6: loading,
    7: unloading,
    8: stiffness,
    9: roughness,
    11: cone,
    12: cycles,
    13: plastic,
    14: stages,
}
"""Number of a figure → function of a `Paper` that draws it. Figs. 1, 2 and 10 are photographs and maps that are not public."""
