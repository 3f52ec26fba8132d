"""Figures of fits, choices, the trade of speed for accuracy, and the extremes."""

import numpy as np

from demlaws.plots import COLOURS, figure


def fit_figure(ranking, source=""):
    """Measured points with the best fits of different laws, and what remains of the displacement."""
    displacement, force = ranking.points
    fig, (left, right) = figure(columns=2, width=5.6)
    left.plot(displacement * 1e6, force, "k.", ms=4, label=f"measured {source}".strip())
    drawn, widest = [], 0.0
    for fit in ranking:
        if fit.name in drawn or len(drawn) == 5:
            continue
        drawn.append(fit.name)
        widest = max(widest, np.max(np.abs(displacement - fit.displacement)))
        rule = "" if fit.unloading == "elastic" else f", {fit.unloading}"
        label = f"{fit.name}{rule}: {fit.misfit * 1e6:.3g} µm"
        colour = COLOURS.get(fit.name)
        left.plot(fit.displacement * 1e6, force, color=colour, lw=1.2, label=label)
        right.plot(force, (displacement - fit.displacement) * 1e6, ".", ms=3, color=colour, label=fit.name)
    left.set(xlabel="displacement (µm)", ylabel="force (N)", title="measured points and laws fitted to them")
    right.axhline(0.0, color="k", lw=0.8)
    right.set(xlabel="force (N)", ylabel="measured - fitted displacement (µm)", ylim=(-1.2e6 * widest, 1.2e6 * widest))
    left.legend(fontsize=7)
    right.legend(fontsize=7)
    return fig
