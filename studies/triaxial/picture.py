"""The picture of the triaxial study: simulated strain over cycles above the bands of the measured tests."""

import numpy as np

from studies.triaxial.report import SLOW, groups, measured, simulated

LOADS = ((60.0, 230.0), (60.0, 370.0), (30.0, 230.0), (10.0, 230.0))
COLOURS = ("C0", "C1", "C2", "C9", "C4", "C3", "C8", "C6", "C5")
"""Of the cases; no grey, which is that of the bands."""
NUMBER = np.unique(np.round(np.geomspace(1, 2000, 60)))


def draw(rows):
    """A figure of four panels, one for each load."""
    from demlaws.plots import figure

    fig, axes = figure(rows=2, columns=2, width=4.6, height=3.9)
    found, tests = groups(simulated(rows)), measured()
    names = sorted({name for name, *_ in found})
    for ax, load in zip(np.ravel(axes), LOADS, strict=True):
        _bands(ax, load, tests)
        here = {name: courses for (name, *place), courses in found.items() if tuple(place) == load}
        for line, (name, courses) in enumerate(here.items()):
            _courses(ax, name, courses, COLOURS[names.index(name)], 36.0 * 0.8**line)
        ax.set(xscale="log", yscale="log", xlim=(0.85, 2300), ylim=(0.02, 50.0), title=f"p = {load[0]:g}, q = {load[1]:g} kPa")
        ax.set(xlabel="cycle", ylabel="permanent axial strain (%)")
    lines = {label: line for ax in np.ravel(axes) for line, label in zip(*ax.get_legend_handles_labels(), strict=True)}
    bands = [label for label in lines if label.startswith("measured")]
    axes[0, 1].legend([lines[label] for label in bands], bands, fontsize=9, loc="lower right")
    cases = [label for label in lines if label not in bands]
    axes[1, 1].legend([lines[label] for label in cases], cases, fontsize=7.5, loc="lower right")  # collapses only
    return fig


def _bands(ax, load, tests):
    """Smallest to largest strain of the measured tests of a load: all frequencies, and 5 and 10 Hz."""
    for chosen, alpha, label in ((None, 0.15, "measured, all frequencies"), (SLOW, 0.35, "measured, 5 and 10 Hz")):
        some = [one for key, one in tests.items() if key[:2] == load and (chosen is None or key[2] in chosen)]
        strain = np.array([[one.at(number) for number in NUMBER] for one in some])
        known = ~np.isnan(strain).all(axis=0)
        low, high = np.nanmin(strain[:, known], axis=0), np.nanmax(strain[:, known], axis=0)
        ax.fill_between(NUMBER[known], np.maximum(low, 1e-3), high, color="k", alpha=alpha, lw=0, label=label)


def _courses(ax, name, courses, colour, top):
    """A line for each packing; a cross where it collapsed, at the height `top`."""
    for n, one in enumerate(courses):
        ax.plot(one.cycles, one.strain, color=colour, lw=1.3, label=name if n == 0 else None)
        if not np.isnan(one.collapsed):
            ax.plot([one.collapsed], [top], "x", color=colour, ms=6)
