"""The published tests of Jamari & Schipper 2006 and 2008 over load and roughness."""

import numpy as np

from demlaws.plots import figure
from demlaws.plots.surface import MICRO, regime_axis, regime_bar
from studies.jamari import published

SEEN = {"asperities": ("o", "white"), "both": ("s", "#ffbf00"), "bulk": ("D", "black")}


def regime_map():
    """p(0)/H_m over load and roughness for the published tests, with what was seen there."""
    fig, axes = figure(rows=3, width=6.6, height=3.7)
    ratios = {row.test.label: row for row in published.published_ratios()}
    tests = [row.test for row in ratios.values()]
    groups = (
        ("aluminium, steel ball R = 5 mm (2006)", [t for t in tests if t.label.startswith("Al")]),
        ("brass, steel ball R = 5 mm (2006)", [t for t in tests if t.label.startswith("Br")]),
        ("aluminium, SiC ball R = 3.175 mm (2008)", [t for t in tests if t.label.startswith("2008")]),
    )
    image = None
    for ax, (name, group) in zip(axes, groups, strict=True):
        image = regime_axis(ax, group[0].contact, np.geomspace(0.03, 100, 161), np.geomspace(2e-8, 2e-5, 161))
        for n, test in enumerate(group):
            marker, face = SEEN[test.seen]
            x, y = test.load, test.contact.sigma * MICRO
            ax.plot(x, y, marker, mfc=face, mec="black", ms=8, zorder=5)
            side = {"Al_A": (8, 7), "Al_AB": (8, -12)}.get(test.label, (8, -3 + 10 * n if "2008" in test.label else -3))
            solved, fitted = ratios[test.label].solved, ratios[test.label].fitted
            ax.annotate(
                f"{fitted:.3f}" if np.isnan(solved) else f"{solved:.3f} at μ = {test.mu:g}",
                (x, y),
                side,
                textcoords="offset points",
                fontsize=9,
                bbox={"boxstyle": "round,pad=0.15", "fc": "white", "ec": "none", "alpha": 0.7},
            )
        ax.set_title(name, fontsize=11)
    regime_bar(fig, image, axes)
    for seen, (marker, face) in SEEN.items():
        axes[0].plot([], [], marker, mfc=face, mec="black", ls="none", label=f"observed: {seen}")
    axes[0].legend(loc="upper left", fontsize=9)
    return fig
