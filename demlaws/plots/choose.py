"""Figures of fits and of choices."""

import numpy as np

from demlaws.plots import colour, figure


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
        shade = colour(fit.name)
        left.plot(fit.displacement * 1e6, force, color=shade, lw=1.2, label=label)
        right.plot(force, (displacement - fit.displacement) * 1e6, ".", ms=3, color=shade, label=fit.name)
    left.set(xlabel="displacement (µm)", ylabel="force (N)", title="measured points and laws fitted to them")
    right.axhline(0.0, color="k", lw=0.8)
    right.set(title="misfit of the fitted laws")
    right.set(xlabel="force (N)", ylabel="measured - fitted displacement (µm)", ylim=(-1.2e6 * widest, 1.2e6 * widest))
    left.legend(fontsize=7)
    right.legend(fontsize=7)
    return fig


def numbered_key(ax, lines, title=None):
    """A legend beside the axes: number in the picture and what it stands for."""
    handles = [
        ax.plot([], [], ls="none", marker=f"${n}$", ms=5 if n < 10 else 7, color="k", mew=0.3, label=text)[0]
        for n, text in lines
    ]
    keep = ax.get_legend()
    ax.legend(handles=handles, fontsize=6.5, loc="upper left", bbox_to_anchor=(1.01, 1.0), title=title, title_fontsize=7)
    if keep is not None:
        ax.add_artist(keep)


def number(ax, points, near=0.03):
    """Number points (n, (x, y)) of axes whose limits are set; points that nearly coincide share a list of numbers."""
    groups = []
    for n, (x, y) in points:
        place = ax.transAxes.inverted().transform(ax.transData.transform((x, y)))
        close = next((g for g in groups if max(abs(g[0] - place)) < near), None)
        if close is None:
            groups.append((place, [n]))
        else:
            close[1].append(n)
    white = {"facecolor": "white", "alpha": 0.6, "edgecolor": "none", "pad": 0.4}
    for place, numbers in groups:
        text = ", ".join(map(str, numbers))
        ax.text(*(place + 0.014), text, transform=ax.transAxes, fontsize=7, zorder=5, bbox=white)


def choices_figure(choices):
    """Error against cost of the candidates of a scene, numbered in the order of the choice."""
    fig, ax = figure(width=8.2, height=4.6)
    markers = {"closed form": "o", "table": "s"}
    lowest = 1e-9
    for evaluation, marker in markers.items():
        chosen = [c for c in choices if c.evaluation == evaluation]
        if chosen:
            colours = [colour(c.name) for c in chosen]
            cost = [c.cost for c in chosen]
            ax.scatter(cost, [max(c.error, lowest) for c in chosen], c=colours, marker=marker, s=42, label=evaluation, zorder=3)
    ax.axhline(choices.scene.tolerance, color="k", ls="--", lw=0.9, label="tolerance")
    best = choices.best
    ax.scatter([best.cost], [max(best.error, lowest)], s=180, facecolors="none", edgecolors="k", lw=1.5, zorder=4)
    costs = [c.cost for c in choices]
    ax.set(
        xscale="log" if max(costs) > 4.0 * min(costs) else "linear",
        yscale="log",
        xlabel="ns per contact and reference time step",
        ylabel=f"largest error of {choices.scene.quantity} (below {lowest:g} drawn there)",
        title=choices.scene.name or "choices",
    )
    ax.legend(fontsize=7)
    number(ax, [(n + 1, (c.cost, max(c.error, lowest))) for n, c in enumerate(choices)])
    labels = [f"{c.name}, {c.unloading}, {c.evaluation}" for c in choices]
    numbered_key(ax, [(n + 1, text) for n, text in enumerate(labels)], "in the order of the choice")
    return fig
