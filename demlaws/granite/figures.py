"""The figures of Altuhafi, Baudet & Coop 2023 (granite contacts), drawn from the laws that ran.

The measured points of the paper are not public: a law's curve stands where they would be.
"""

import functools

import numpy as np

from demlaws import granite, make
from demlaws.contact import smooth_overlap
from demlaws.laws import BAHRAMI, HERTZ, POHRT_POPOV, RMS, ROUGH_PLASTIC, YIP_VENART
from demlaws.plots import colour, draw_line, figure

MICRO = 1e6
COMPARED = (HERTZ, RMS, POHRT_POPOV)
"""The laws that the paper draws for unloading."""
SPHERES = (HERTZ, RMS, POHRT_POPOV, BAHRAMI, YIP_VENART)
"""The laws that it draws for spheres."""
PRINTED_THRESHOLD = 73.0
"""Load [N] of the paper's text at which SS(18-18) crosses over to Hertz."""


@functools.cache
def _law(name, test, modulus="text"):
    return granite.bind(name, granite.find_test(test, modulus), "elastic")


def force(test, runs):
    """Force against displacement of one test, every law; displacement counted from 0.1 N as in the tables."""
    fig, ax = figure(width=6.4, height=4.8)
    for run in runs:
        path = run.paths[0]
        rise = slice(0, int(np.argmax(path.force)) + 1)
        zero = float(np.interp(0.1, path.force[rise], path.overlap[rise]))
        end = granite.first_rise(-path.force) if test.cyclic else path.force.size
        draw_line(ax, (path.overlap[:end] - zero) * MICRO, path.force[:end], name=run.law.name, lw=1.5)
    ax.set(xlabel="displacement from 0.1 N (µm)", ylabel="force (N)", title=test.name, ylim=(0, None))
    ax.set_xlim(left=-0.05 * ax.get_xlim()[1])
    ax.legend(fontsize=8)
    return fig


def _step_colour(number, count):
    """Colours of a sequence, as many as there are steps, from dark to light."""
    from matplotlib import colormaps

    return colormaps["viridis"](0.9 * number / max(count - 1, 1))


def cycling(run):
    """Cycles of a cone: force against displacement stage by stage, and stiffness of each loading branch."""
    fig, (left, right) = figure(columns=2, width=5.6, height=4.4)
    for number, path in enumerate(run.paths):
        label = f"stage {number + 1}" if len(run.paths) > 1 else run.law.name
        # later stages are thinner: they lie over the earlier ones that they repeat
        width = 1.0 + 0.5 * (len(run.paths) - 1 - number)
        left.plot(path.overlap * MICRO, path.force, color=_step_colour(number, len(run.paths)), lw=width, label=label)
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
    right.loglog(load, granite.hertz_stiffness(run.test, load, run.radius) / 1e3, "k--", lw=1, label="Hertz")
    right.set(xlabel="force (N)", ylabel="stiffness (N/mm)", title="loading stiffness, stage by stage")
    left.legend(fontsize=8)
    right.legend(fontsize=7)
    return fig


def radius(modulus="text"):
    """Fig. 4: a*/a_H against α: Eq. 5, Greenwood & Tripp, and a* back-calculated (a*² = Rδ) from each law."""
    alpha = np.geomspace(0.03, 30.0, 60)
    fig, ax = figure(width=6.0, height=4.4)
    for (name, values), style in zip(granite.effective_radius(alpha).items(), ("-", "--", ":"), strict=True):
        ax.semilogx(alpha, values, style, lw=1.6, label=name)
    ax.axvspan(1.0, alpha.max(), color="k", alpha=0.05, lw=0)
    ax.text(1.1, 0.04, "beyond the data of the fit", fontsize=8, transform=ax.get_xaxis_transform())
    load = np.geomspace(0.3, 100.0, 12)
    for name, marker in zip(granite.ROUGH_SPHERES, "o^sv", strict=True):
        test = granite.find_test(name, modulus)
        for law in SPHERES[1:]:
            hertz = smooth_overlap(test.contact, load)
            size = np.sqrt(_law(law, name, modulus).overlap(load) / hertz)
            ax.plot(test.sigma / hertz, size, marker, color=colour(law), ms=3.5, mfc="none")
        ax.plot([], [], "k" + marker, mfc="none", ms=4, label=f"laws on {name}")
    for law in SPHERES[1:]:
        ax.plot([], [], "s", color=colour(law), ms=4, label=law)
    ax.set(xlabel="α = σR/a_H²", ylabel="a*/a_H", title="effective contact radius", ylim=(0.8, 4.5))
    ax.legend(fontsize=7, ncol=2)
    return fig


def crossover():
    """Fig. 5: stiffness of Hertz and of Pohrt-Popov, and where the lines cross, with both E*."""
    load = np.geomspace(1.0, 500.0, 300)
    fig, ax = figure(width=6.0, height=4.4)
    for (modulus, value), style, side in zip(granite.MODULI.items(), ("-", "--"), (-1, 1), strict=True):
        test = granite.find_test("SS(18-18)", modulus)
        for name in (HERTZ, POHRT_POPOV):
            law, label = _law(name, test.name, modulus), f"{name}, E* = {value / 1e9:.1f} GPa"
            ax.plot(load, law.stiffness(law.overlap(load)) / 1e3, style, color=colour(name), label=label, lw=1.6)
        threshold = granite.threshold_force(test)
        ax.axvline(threshold, color="k", lw=0.8, ls=style)
        place = {"xytext": (6 * side, 0), "textcoords": "offset points", "ha": "right" if side < 0 else "left"}
        ax.annotate(f"F = {threshold:.1f} N with\nE* = {value / 1e9:.1f} GPa", (threshold, 1500), **place)
    ax.axvline(PRINTED_THRESHOLD, color="r", lw=2.5, alpha=0.4, label=f"the paper's text: around {PRINTED_THRESHOLD:g} N")
    ax.set(xscale="log", yscale="log", xlabel="force (N)", ylabel="stiffness (N/mm)", title=f"{test.name}: crossover")
    ax.legend()
    return fig


def unloading(run, modulus="text"):
    """Fig. 7: unloading of SS(12-18) along each law's own curve, as the paper compares them, and along the Hertz rule's.

    run: of Pohrt-Popov.
    """
    test = run.test
    fig, ax = figure(width=6.4, height=4.8)
    top = max(test.stages[0])
    load = np.linspace(0.05, top, 300)
    for law in (_law(name, test.name, modulus) for name in COMPARED):
        displacement = (law.overlap(load) - law.overlap(top)) * MICRO
        draw_line(ax, displacement, load, name=law.name, label=f"{law.name}, elastic", lw=1.3)
    path = run.paths[0]
    back = slice(int(np.argmax(path.force)), None)
    left = (path.overlap[back] - path.overlap[back][0]) * MICRO
    ax.plot(left, path.force[back], color="k", lw=3, alpha=0.35, label="Hertz unloading rule, any law")
    ax.set(xlabel="displacement from the maximum (µm)", ylabel="force (N)", title=f"{test.name}: unloading")
    ax.legend(fontsize=8)
    return fig


def stiffness(modulus="text"):
    """Fig. 8: stiffness against load of four tests, on logarithmic axes."""
    fig, axes = figure(columns=2, rows=2, width=5.0)
    load = np.geomspace(0.1, 100.0, 200)
    for ax, name in zip(np.ravel(axes), ("SS(18-18)", "RS(18-18)", "SS(12-18)", "SF(12)"), strict=True):
        for law in (_law(n, name, modulus) for n in SPHERES):
            draw_line(ax, load, law.stiffness(law.overlap(load)) / 1e3, name=law.name, lw=1.3)
        ax.set(xscale="log", yscale="log", xlabel="force (N)", ylabel="stiffness (N/mm)", title=name)
        ax.legend(fontsize=7)
    return fig


def roughness(modulus="text"):
    """Fig. 9: force and stiffness of Pohrt-Popov on three pairs that differ in roughness, and of Hertz."""
    tests = [granite.find_test(name, modulus) for name in ("VS(18-18)", "SS(18-18)", "RS(18-18)")]
    fig, (left, right) = figure(columns=2)
    load = np.geomspace(0.05, 100.0, 300)
    lines = [(POHRT_POPOV, test, "-", shade) for test, shade in zip(tests, ("#1f77b4", "#ff7f0e", "#d62728"), strict=True)]
    for name, test, style, shade in [*lines, (HERTZ, tests[1], "--", "k")]:
        law = _law(name, test.name, modulus)
        overlap = law.overlap(load)
        label = f"Hertz, {test.name}" if name == HERTZ else f"{test.name}, σ = {test.sigma * MICRO:.2f} µm"
        left.plot((overlap - law.overlap(0.1)) * MICRO, load, style, color=shade, label=label)
        right.loglog(load, law.stiffness(overlap) / 1e3, style, color=shade, label=label)
    left.set(xlabel="displacement from 0.1 N (µm)", ylabel="force (N)", title="effect of roughness, Pohrt-Popov")
    right.set(xlabel="force (N)", ylabel="stiffness (N/mm)", title="tangent stiffness")
    left.legend(fontsize=8)
    return fig


# --- both cones against what the paper prints of them: laws with one radius and with two

PRINTED = {"RFC10": (20.0, 450.0), "FC5": (7.0, 150.0)}
"""Loads [N] to which the elastic models hold by the paper's text, and largest load drawn."""
PRINTED_STIFFNESS = 5000.0
"""RFC10 after gross yield [N/mm], by the text."""


def cones(cone, small):
    """Stiffness and displacement of both cones on first loading, and plastic overlap; runs of RFC10 and FC5."""
    fig, axes = figure(columns=2, rows=3, width=4.8)
    for column, run in enumerate((cone, small)):
        _first_loading(axes[0][column], axes[1][column], run)
    axes[0][0].axhline(
        PRINTED_STIFFNESS, color="r", lw=2.5, alpha=0.4, label=f"printed: {PRINTED_STIFFNESS:g} N/mm after yield"
    )
    _plastic(axes[2][0], axes[2][1], cone, small)
    for ax in axes[0]:
        ax.legend(fontsize=8, loc="lower right")
    for ax in axes[2]:
        ax.legend(fontsize=9, loc="upper left")
    return fig


def _cone_laws(run):
    """Label → law, style of line: the elastic laws on R, the law that yields with two radii and with one."""
    test = run.test
    lines = {name: (granite.bind(name, test, "elastic"), {"color": colour(name)}) for name in (HERTZ, RMS, POHRT_POPOV)}
    radii = {run.radius: "-", test.radius: "--"}
    for radius, style in radii.items():
        options = {"yield_pressure": test.yield_pressure, "yield_at": test.yield_at, "bulk_radius": radius}
        label = f"{ROUGH_PLASTIC}, bulk {1e3 * radius:.2f} mm"
        lines[label] = make.law(ROUGH_PLASTIC, test.contact, **options), {"color": "k", "ls": style, "lw": 1.8}
    return lines


def _first_loading(left, right, run):
    printed, most = PRINTED[run.test.name]
    load, low = np.geomspace(0.5, most, 300), np.linspace(0.05, 20.0, 300)
    for label, (one, style) in _cone_laws(run).items():
        left.loglog(load, one.stiffness(one.overlap(load)) / 1e3, label=label, **style)
        right.plot(one.overlap(low) * MICRO, low, label=label, **style)
    left.axvline(printed, color="r", lw=1, ls=":", label=f"printed: elastic models to {printed:g} N")
    right.axhline(printed, color="r", lw=1, ls=":")
    left.set(xlabel="force (N)", ylabel="stiffness (N/mm)", title=f"{run.test.name}, R = {1e3 * run.test.radius:.2f} mm")
    right.set(xlabel="displacement (µm)", ylabel="force (N)", title=f"{run.test.name}: first loading, lines as above")


def _plastic(ax, cycles, cone, small):
    """Plastic overlap against the largest load, both cones, straight lines through the points, and the cycles."""
    for run, stage, marker in ((cone, 1, "o"), (small, 4, "s")):
        rows = [row for row in granite.stages_of(run) if row.stage == stage]
        load, plastic = (np.array([getattr(row, name) for row in rows]) for name in ("maximum_force", "plastic_overlap"))
        (points,) = ax.plot(load, plastic * MICRO, marker, ms=5, label=run.test.name)
        line = np.polynomial.Polynomial.fit(load, plastic * MICRO, 1)
        ax.plot(load, line(load), "--", lw=1, color=points.get_color())
        path = run.paths[stage - 1]
        cycles.plot(path.overlap * MICRO, path.force, lw=1, color=points.get_color(), label=run.test.name)
    ax.plot([], [], "k--", lw=1, label="straight lines")
    ax.set(xlabel="largest force (N)", ylabel="plastic overlap (µm)", title="printed: nearly linear, both similar")
    cycles.set(xlabel="overlap (µm)", ylabel="force (N)", title="cycles, Hertz unloading of the bulk")
