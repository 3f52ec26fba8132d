"""The validation report as a picture."""

import numpy as np

from demlaws.plots import figure
from demlaws.plots.surface import MICRO


def deviations(groups):
    """Every row's distance from the middle of its range over half the range, by group: 1 is the limit.

    A range that begins at 0 limits a difference, which is expected to be 0.
    """

    def distance_of(row):
        expected = 0.5 * (row.low + row.high) if row.low else 0.0
        return max(abs(row.found - expected) / (row.high - expected), 1e-9)

    fig, ax = figure(width=8.0, height=0.42 * len(groups) + 1.4)
    for height, rows in enumerate(groups.values()):
        for verdict, colour, marker in (("pass", "tab:blue", "o"), ("FAIL", "tab:red", "X")):
            chosen = [row for row in rows if row.verdict == verdict]
            distance = [distance_of(row) for row in chosen]
            spread = np.linspace(-0.25, 0.25, len(distance)) if distance else []
            ax.plot(distance, height + np.asarray(spread), marker, color=colour, ms=4, ls="none")
    ax.axvline(1.0, color="k", lw=0.8)
    ax.set(xscale="log", xlim=(7e-10, 12.0), xlabel="distance from the expected value over tolerance")
    ax.set_yticks(range(len(groups)), list(groups))
    ax.invert_yaxis()
    return fig


def boundary_element_figure(rows):
    """The model's load and area over a boundary-element solution's at equal separation; rows: the stored file's."""
    fig, (left, right) = figure(columns=2, width=4.4, height=3.7)
    for name in dict.fromkeys(row["case"] for row in rows):
        chosen = [row for row in rows if row["case"] == name]
        overlap = np.array([float(r["overlap"]) for r in chosen])
        load = np.array([float(r["model_force"]) / float(r["bem_force"]) for r in chosen])
        area = np.array([float(r["model_area"]) / float(r["bem_area"]) for r in chosen])
        left.semilogx(overlap * MICRO, load, "o-", ms=4, label=name.replace(";", ","))
        right.semilogx(overlap * MICRO, area, "o-", ms=4)
    for ax, what in ((left, "load"), (right, "contact area")):
        ax.axhline(1.0, color="black", lw=0.8)
        ax.set(xlabel="overlap (µm)", ylabel=f"{what}: asperity / boundary elements")
    left.legend(fontsize=9)
    return fig
