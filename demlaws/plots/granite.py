"""The figures of Altuhafi, Baudet & Coop 2023 (granite contacts), each with the numbers in it and who says them.

Every function takes a `Paper` and returns (figure, lines of text). The measured points of the paper are not public: a law's
curve stands where they would be, and a user's points are laid over it.
"""

import functools

import numpy as np

from demlaws import granite
from demlaws.laws.names import BAHRAMI, HERTZ, POHRT_POPOV, RMS, ROUGH_PLASTIC, YIP_VENART
from demlaws.plots import (
    colour,
    figure,
    granite_crossover,
    granite_cycles,
    granite_force,
    granite_plastic,
    granite_radius,
    granite_roughness,
    granite_stiffness,
    granite_unloading,
)

MICRO = 1e6
COMPARED = (HERTZ, RMS, POHRT_POPOV)
"""The laws that the paper draws for unloading and for cones."""
SPHERES = (HERTZ, RMS, POHRT_POPOV, BAHRAMI, YIP_VENART)
"""The laws that it draws for spheres."""
PRINTED_THRESHOLD = 73.0
"""Load [N] of the paper's text at which SS(18-18) crosses over to Hertz."""


class Paper:
    """The tests, run once a law, and a user's points by test name."""

    def __init__(self, points=None):
        self.points = points or {}
        self.run = functools.cache(self._run)
        self.law = functools.cache(self._law)

    def _run(self, name, test):
        return granite.run_test(name, granite.find_test(test))[0]

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
    fig = granite_radius(alpha, granite.effective_radius(alpha))
    (ax,) = fig.axes
    said = ["a*/a_H back-calculated from δ (a*² = Rδ) at 1, 10 and 100 N, computed; α in brackets:"]
    load = np.geomspace(0.3, 100.0, 12)
    for name, marker in zip(granite.ROUGH_SPHERES, "o^sv", strict=True):
        test = granite.find_test(name)
        for law in SPHERES[1:]:
            one = paper.law(law, name)
            hertz = (9.0 * load**2 / (16.0 * test.radius * test.contact.modulus**2)) ** (1 / 3)
            ax.plot(test.roughness / hertz, np.sqrt(one.overlap(load) / hertz), marker, color=colour(law), ms=3.5, mfc="none")
            if law == POHRT_POPOV:
                at = [float(test.contact.roughness_parameter(f)) for f in (1.0, 10.0, 100.0)]
                size = [
                    float(np.sqrt(one.overlap(f) * a / test.roughness)) for f, a in zip((1.0, 10.0, 100.0), at, strict=True)
                ]
                text = ", ".join(f"{s:.2f} ({a:.2f})" for s, a in zip(size, at, strict=True))
                said.append(f"  {name}, {law}: {text}")
        ax.plot([], [], "k" + marker, mfc="none", ms=4, label=f"laws on {name}")
        if name in paper.points:
            ax.plot(*paper.points[name].contact_radius(test.contact), "k" + marker, ms=3, label=f"measured {name}")
    for law in SPHERES[1:]:
        ax.plot([], [], "s", color=colour(law), ms=4, label=law)
    ax.set_ylim(0.8, 4.5)
    ax.legend(fontsize=7, ncol=2)
    return fig, [
        *said,
        "seated laws count δ from their declared seating load; measured points from their first",
        paper.whose(*granite.ROUGH_SPHERES),
    ]


def crossover(paper):
    """Fig. 5: stiffness of Hertz and of Pohrt-Popov, and where the lines cross."""
    test = granite.find_test("SS(18-18)")
    threshold = granite.threshold_force(test)
    fig = granite_crossover(test, [paper.law(name, test.name) for name in (HERTZ, POHRT_POPOV)], threshold)
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
        granite_force(runs[0].test, [run._replace(paths=(_up(run.paths[0]),)) for run in runs], paper.points.get(name), ax)
        said.append(f"  {name}: {_gained(paper, name, SPHERES)}")
    return fig, [*said, paper.whose(*tests)]


def _up(path):
    """A path as far as its largest force."""
    end = int(np.argmax(path.force)) + 1
    return path._replace(**{name: value[:end] for name, value in path._asdict().items() if np.ndim(value)})


def unloading(paper):
    """Fig. 7: unloading of SS(12-18) along each law's own curve."""
    test = granite.find_test("SS(12-18)")
    laws = [paper.law(name, test.name) for name in COMPARED]
    fig = granite_unloading(test, laws, paper.run(POHRT_POPOV, test.name).paths[0], paper.points.get(test.name))
    back = ", ".join(f"{law.name} {float(law.overlap(100.0) - law.overlap(0.1)) * MICRO:.1f}" for law in laws)
    return fig, [
        f"displacement recovered from 100 to 0.1 N along each law's own curve (µm), computed: {back}",
        paper.whose(test.name),
    ]


def stiffness(paper):
    """Fig. 8: stiffness against load of four tests."""
    tests = ("SS(18-18)", "RS(18-18)", "SS(12-18)", "SF(12)")
    fig = granite_stiffness([(granite.find_test(t), [paper.run(law, t) for law in SPHERES]) for t in tests], paper.points)
    said = ["stiffness at 10 N (N/mm), computed:"]
    for name in tests:
        row = ", ".join(f"{law} {granite.stiffness_at(paper.law(law, name), 10.0) / 1e3:.0f}" for law in SPHERES)
        said.append(f"  {name}: {row}")
    return fig, [*said, paper.whose(*tests)]


def roughness(paper):
    """Fig. 9: what roughness does to Pohrt-Popov."""
    tests = [granite.find_test(name) for name in ("VS(18-18)", "SS(18-18)", "RS(18-18)")]
    fig = granite_roughness(tests, lambda name, test: paper.law(name, test.name), paper.points)
    said = [
        f"  {t.name}: m = 0.2567 Df = {0.2567 * t.fractal_dimension:.3f} (Df = {t.fractal_dimension}, mean of the printed two)"
        for t in tests
    ]
    return fig, [
        "exponent of stiffness over load, computed; printed: around 0.56",
        *said,
        paper.whose(*(t.name for t in tests)),
    ]


def cone(paper):
    """Fig. 11: RFC10, loading and unloading, and its first loading to 20 N with the elastic laws."""
    run, test = paper.yielding("RFC10"), granite.find_test("RFC10")
    fig, (left, right) = figure(columns=2, width=5.6, height=4.4)
    _path(left, run.paths[0], paper.points.get(test.name), run)
    left.set(title=f"{test.name}: {run.law.name}, {run.law.unloading} unloading" + (f"\n{run.beyond}" if run.beyond else ""))
    left.title.set_fontsize(9)
    granite_force(test, [paper.run(name, test.name) for name in COMPARED], None, right)
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
    stages = granite.stages_of(run)
    fig = granite_cycles(run, stages, paper.points.get("RFC10"))
    rows = [f"  to {s.maximum_force:.0f} N: {s.final_stiffness / 1e3:.0f} N/mm at the maximum" for s in stages]
    return fig, ["computed (p_y was chosen for the 5000 N/mm that is printed):", *rows, paper.whose("RFC10")]


def plastic(paper):
    """Fig. 13: cumulative plastic deformation of both cones against the largest load."""
    series = [("RFC10", granite.stages_of(paper.yielding("RFC10")))]
    last = max(s.stage for s in granite.stages_of(paper.yielding("FC5"))) - 1
    series.append(("FC5", [s for s in granite.stages_of(paper.yielding("FC5")) if s.stage == last]))
    fig = granite_plastic(series, paper.points)
    said = ["plastic overlap (µm) at the largest load (N), computed:"]
    for name, stages in series:
        said.append(f"  {name}: " + ", ".join(f"{s.plastic_overlap * MICRO:.1f} at {s.maximum_force:.0f}" for s in stages))
    return fig, [*said, *filter(None, [paper.yielding("RFC10").beyond]), paper.whose("RFC10", "FC5")]


def stages(paper):
    """Fig. 14: the five stages of FC5, the first two to 20 N beside three elastic laws."""
    run, test = paper.yielding("FC5"), granite.find_test("FC5")
    fig, axes = figure(columns=3, rows=2, width=4.4, height=3.6)
    first, *others = np.ravel(axes)
    granite_force(test, [paper.run(name, test.name) for name in (*COMPARED, run.law.name)], paper.points.get(test.name), first)
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
