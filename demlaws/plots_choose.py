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


def choices_figure(choices):
    """Error against cost of the candidates of a scene."""
    fig, ax = figure(width=6.4, height=4.6)
    markers = {"closed form": "o", "table": "s", "closed form, float32": "^"}
    lowest = 1e-9
    for evaluation, marker in markers.items():
        chosen = [c for c in choices if c.evaluation == evaluation]
        if chosen:
            colours = [COLOURS.get(c.name, "#888888") for c in chosen]
            cost = [c.cost for c in chosen]
            ax.scatter(cost, [max(c.error, lowest) for c in chosen], c=colours, marker=marker, s=42, label=evaluation, zorder=3)
    for c in choices:
        text = f"{c.name}{'' if c.unloading == 'elastic' else ', ' + c.unloading}"
        ax.annotate(text, (c.cost, max(c.error, lowest)), xytext=(4, 3), textcoords="offset points", fontsize=6)
    ax.axhline(choices.scene.tolerance, color="k", ls="--", lw=0.9)
    best = choices.best
    ax.scatter([best.cost], [max(best.error, lowest)], s=180, facecolors="none", edgecolors="k", lw=1.5, zorder=4)
    ax.set(
        xscale="log",
        yscale="log",
        xlabel="ns a contact and reference time step",
        ylabel=f"largest error of {choices.scene.quantity} (below {lowest:g} drawn there)",
        title=choices.scene.name or "choices",
    )
    ax.legend(fontsize=7)
    return fig
