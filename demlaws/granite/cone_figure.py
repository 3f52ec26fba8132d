"""Both cones of the granite paper against what it prints of them: laws with one radius and with two."""

import numpy as np

from demlaws import granite
from demlaws.granite import MICRO
from demlaws.laws import HERTZ, POHRT_POPOV, RMS, ROUGH_PLASTIC
from demlaws.make import law
from demlaws.plots import colour, figure

PRINTED = {"RFC10": (20.0, 450.0), "FC5": (7.0, 150.0)}
"""Loads [N] to which the elastic models hold by the paper's text, and largest load drawn."""
PRINTED_STIFFNESS = 5000.0
"""RFC10 after gross yield [N/mm], by the text."""


def cone_figure(cone, small):
    """Stiffness and displacement of both cones on first loading, and plastic overlap; runs of RFC10 and FC5."""
    fig, axes = figure(columns=3, rows=2, width=4.6)
    for column, run in enumerate((cone, small)):
        _first_loading(axes[0][column], axes[1][column], run)
    axes[0][0].axhline(
        PRINTED_STIFFNESS, color="r", lw=2.5, alpha=0.4, label=f"printed: {PRINTED_STIFFNESS:g} N/mm after yield"
    )
    _plastic(axes[0][2], axes[1][2], cone, small)
    for ax in np.ravel(axes):
        ax.legend(fontsize=7, loc="upper left")
    return fig


def _laws(run):
    """Label → law, style of line: the elastic laws on R, the law that yields with two radii and with one."""
    test = run.test
    lines = {name: (granite.bind(name, test, "elastic"), {"color": colour(name)}) for name in (HERTZ, RMS, POHRT_POPOV)}
    radii = {run.radius: "-", test.radius: "--"}
    for radius, style in radii.items():
        options = {"yield_pressure": test.yield_pressure, "yield_at": test.yield_at, "bulk_radius": radius}
        label = f"{ROUGH_PLASTIC}, bulk {1e3 * radius:.2f} mm"
        lines[label] = law(ROUGH_PLASTIC, test.contact, **options), {"color": "k", "ls": style, "lw": 1.8}
    return lines


def _first_loading(left, right, run):
    printed, most = PRINTED[run.test.name]
    load, low = np.geomspace(0.5, most, 300), np.linspace(0.05, 20.0, 300)
    for label, (one, style) in _laws(run).items():
        left.loglog(load, one.stiffness(one.overlap(load)) / 1e3, label=label, **style)
        right.plot(one.overlap(low) / MICRO, low, label=label, **style)
    left.axvline(printed, color="r", lw=1, ls=":", label=f"printed: elastic models to {printed:g} N")
    right.axhline(printed, color="r", lw=1, ls=":")
    left.set(xlabel="force (N)", ylabel="stiffness (N/mm)", title=f"{run.test.name}, R = {1e3 * run.test.radius:.2f} mm")
    right.set(xlabel="displacement (µm)", ylabel="force (N)", title=f"{run.test.name}: first loading to 20 N")


def _plastic(ax, cycles, cone, small):
    """Plastic overlap against the largest load, both cones, straight lines through the points, and the cycles."""
    for run, stage, marker in ((cone, 1, "o"), (small, 4, "s")):
        rows = [row for row in granite.stages_of(run) if row.stage == stage]
        load, plastic = (np.array([getattr(row, name) for row in rows]) for name in ("maximum_force", "plastic_overlap"))
        (points,) = ax.plot(load, plastic / MICRO, marker, ms=5, label=run.test.name)
        line = np.polynomial.Polynomial.fit(load, plastic / MICRO, 1)
        ax.plot(load, line(load), "--", lw=1, color=points.get_color())
        path = run.paths[stage - 1]
        cycles.plot(path.overlap / MICRO, path.force, lw=1, color=points.get_color(), label=run.test.name)
    ax.plot([], [], "k--", lw=1, label="straight lines")
    ax.set(xlabel="largest force (N)", ylabel="plastic overlap (µm)", title="printed: nearly linear, both similar")
    cycles.set(xlabel="overlap (µm)", ylabel="force (N)", title="cycles, Hertz unloading of the bulk")
