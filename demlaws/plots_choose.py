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


def stability_figure(rows):
    """Energy gain per impact against steps per contact, and rounding error by decade of overlap."""
    fig, (left, right) = figure(columns=2, width=5.6)
    styles = {"elastic": "-", "hertz": "--", "thornton": ":"}
    for r in rows:
        if r.evaluation != "closed form":
            continue
        steps = sorted(r.gains)
        gain = [max(r.gains[s], 1e-17) for s in steps]
        left.loglog(steps, gain, styles[r.unloading], color=COLOURS.get(r.law), lw=1.2, label=f"{r.law}, {r.unloading}")
        if r.rounding and r.unloading == "elastic":
            decades = sorted(r.rounding)
            right.plot(decades, [r.rounding[d] for d in decades], "o-", ms=3, color=COLOURS.get(r.law), label=r.law)
    left.axhline(1e-4, color="k", lw=0.8)
    left.set(xlabel="steps per contact", ylabel="largest energy gain of an impact", title="impacts, 1e-6 to 100 m/s")
    right.set(xlabel="decade of δ/σ (Hertz, Goddard: δ/R)", ylabel="largest error of force (ε)", title="rounding")
    left.legend(fontsize=5, ncols=2)
    right.legend(fontsize=7)
    return fig


_MARKERS = {"closed form": "o", "float32": "^", "table": "s", "lazy": "x"}


def _against(ax, entries, floor, errors):
    """Force error against cost; a law's closed form and its tables are joined by a thin line."""
    lowest = 1e-16
    for e in entries:
        colour, marker = COLOURS.get(e.law, "#888888"), _MARKERS[e.evaluation]
        ax.plot(e.ns, max(getattr(e, errors)["force"], lowest), marker, color=colour, ms=5 if e.unloading == "elastic" else 3.5)
    ax.axvline(floor, color="k", lw=0.8, ls=":")
    ax.set(xscale="log", yscale="log", xlabel="ns a contact", ylabel="largest error of force")


def trade_figure(entries, floor, steps=(), peers=None):
    """Force error against cost with the Pareto front; the time step; engines beside their own laws."""
    panels = 2 + bool(steps) + len(peers or {})
    fig, axes = figure(columns=2 if panels > 2 else panels, rows=(panels + 1) // 2, width=6.6, height=4.6)
    axes = list(np.ravel(axes))
    ax = axes.pop(0)
    _against(ax, entries, floor, "richest")
    front = sorted((e.ns, max(e.richest["force"], 1e-16), e) for e in entries if e.front)
    ax.step([f[0] for f in front], [f[1] for f in front], "k-", where="post", lw=1.0)
    named = set()
    for ns, error, e in front:
        if (e.law, e.unloading) not in named:
            named.add((e.law, e.unloading))
            text = f"{e.law}, {e.unloading}, {e.evaluation}"
            ax.annotate(text, (ns, error), xytext=(5, -2 - 9 * (len(named) % 2)), textcoords="offset points", fontsize=6)
    ax.set(title="against rough-plastic, thornton; line: Pareto front")
    for name, marker in _MARKERS.items():
        ax.plot([], [], marker, color="#666666", label=name, ms=4)
    for law, colour in COLOURS.items():
        if any(e.law == law for e in entries):
            ax.plot([], [], "-", color=colour, label=law)
    ax.legend(fontsize=6, ncols=2, title="dotted: copy kernel; small: with history", title_fontsize=6)
    ax = axes.pop(0)
    _against(ax, entries, floor, "own")
    ax.set(title="against the closed form of the same law")
    if steps:
        ax = axes.pop(0)
        ax.loglog([e.steps for e in steps], [max(e.gain, 1e-17) for e in steps], "o-", ms=3, label="energy drift of an impact")
        ax.loglog(
            [e.steps for e in steps], [max(e.rebound_error, 1e-17) for e in steps], "s-", ms=3, label="error of restitution"
        )
        ax.set(xlabel="steps per contact", ylabel="largest error", title="time step (pohrt-popov, hertz unloading)")
        ax.legend(fontsize=7)
    for engine, values in (peers or {}).items():
        ax = axes.pop(0)
        names = [n for n in values if values[n][1] < 5.0]
        ax.barh(range(len(names)), [values[n][1] for n in names], color="#1f77b4", height=0.6)
        ax.set_yticks(range(len(names)), names, fontsize=6)
        ax.invert_yaxis()
        ax.axvline(1.0, color="k", lw=0.8)
        ax.set(xlabel="cost over its own Hertz", title=engine)
    for ax in axes:
        ax.set_visible(False)
    return fig
