"""Figures of the trade of speed for accuracy: the laws alone, in a step of each engine, and in a packing."""

import numpy as np

from demlaws.laws.registry import registry
from demlaws.plots import colour, figure
from demlaws.plots.choose import number, numbered_key
from studies.trade.candidates import NAMES


def _laws_panel(ax, entries, floor):
    """Closed forms alone, one marker a law and rule, numbered: error against the richest law over cost; all entries' front."""
    lowest = 1e-16
    closed = sorted((e for e in entries if e.evaluation == "closed form"), key=lambda e: (e.ns, -e.richest["force"]))
    for e in closed:
        filled = {"mfc": "white"} if e.unloading != "elastic" else {}
        ax.plot(e.ns, max(e.richest["force"], lowest), "o", color=colour(e.law), ms=6, **filled)
    front = sorted((e.ns, max(e.richest["force"], lowest)) for e in entries if e.front)
    ax.step([f[0] for f in front], [f[1] for f in front], "k-", where="post", lw=0.8, zorder=0)
    ax.axvline(floor, color="k", lw=0.8, ls=":")
    ax.set(xscale="log", yscale="log", xlabel="ns per contact (dotted: copy kernel)", ylabel="largest error of force")
    _limited(ax, [floor, *(e.ns for e in closed)])
    ax.set(title="what a law leaves out (closed forms; line: front of all ways)")
    number(ax, [(n + 1, (e.ns, max(e.richest["force"], lowest))) for n, e in enumerate(closed)])
    numbered_key(ax, [(n + 1, f"{e.law}, {e.unloading}") for n, e in enumerate(closed)], "hollow: with history")


def _evaluations_panel(ax, entries):
    """Tables: error against the own closed form over cost relative to it."""
    lowest = 1e-16
    closed = {e[:2]: e.ns for e in entries if e.evaluation == "closed form"}
    shown = [e for e in entries if e.evaluation != "closed form" and e[:2] in closed]
    for e in shown:
        place = e.ns / closed[e[:2]], max(e.own["force"], lowest)
        ax.plot(*place, "s", color=colour(e.law), ms=5, alpha=0.8, mec="white", mew=0.4)
    ax.axvline(1.0, color="k", lw=0.8, ls=":")
    ax.set(xscale="log", yscale="log", xlabel="cost over that of the law's closed form", ylabel="largest error of force")
    _limited(ax, [e.ns / closed[e[:2]] for e in shown])
    ax.set(title="what tables cost and err, against the closed form")
    for law in registry():
        if any(e.law == law for e in shown):
            ax.plot([], [], "-", color=colour(law), label=law)
    ax.legend(fontsize=7, loc="upper left", bbox_to_anchor=(1.01, 1.0))


def _limited(ax, costs):
    """One evaluation that was held up must not press all others together."""
    if costs:
        ax.set_xlim(0.8 * min(costs), min(1.3 * max(costs), 30.0 * float(np.median(costs))))


def trade_figure(entries, floor, steps=(), engines=None):
    """Force error against cost with the Pareto front; the time step; the same in a step of each engine, with its own models."""
    panels = 2 * bool(entries) + bool(steps) + len(engines or {})
    fig, axes = figure(columns=2 if panels > 2 else panels, rows=(panels + 1) // 2, width=8.4, height=4.8)
    axes = list(np.ravel(axes))
    if entries:
        _laws_panel(axes.pop(0), entries, floor)
        _evaluations_panel(axes.pop(0), entries)
    if steps:
        ax = axes.pop(0)
        ax.loglog([e.steps for e in steps], [max(e.gain, 1e-17) for e in steps], "o-", ms=3, label="energy drift of an impact")
        ax.loglog(
            [e.steps for e in steps], [max(e.rebound_error, 1e-17) for e in steps], "s-", ms=3, label="error of restitution"
        )
        ax.set(xlabel="steps per contact", ylabel="largest error", title="time step (pohrt-popov, hertz unloading)")
        ax.legend(fontsize=7)
    for engine, found in (engines or {}).items():
        _engine_panel(axes.pop(0), engine, found)
    for ax in axes:
        ax.set_visible(False)
    return fig


def _engine_panel(ax, engine, found):
    """Force error against the cost of a step; the engine's own models are stars."""
    lowest = 1e-7
    ordered = sorted(found, key=lambda e: (e.cost.over_hertz, e.error))
    for e in ordered:
        own = bool(e.cost.way.model)
        marker = "*" if own else "s" if e.cost.way.rtol else "o"
        shade = "k" if own else colour(e.cost.way.law)
        ax.plot(e.cost.over_hertz, max(e.error, lowest), marker, color=shade, ms=10 if own else 6)
    front = [e for e in ordered if e.front]
    ax.step([e.cost.over_hertz for e in front], [max(e.error, lowest) for e in front], "k-", where="post", lw=1.0)
    ax.axvline(1.0, color="k", lw=0.8, ls=":")
    ax.set(
        yscale="log",
        xlabel="time of a step over that with the engine's own Hertz",
        ylabel=f"largest error of force (below {lowest:g} there)",
        title=f"{NAMES[engine]}; stars: its own models; line: Pareto front",
    )
    number(ax, [(n + 1, (e.cost.over_hertz, max(e.error, lowest))) for n, e in enumerate(ordered)])
    numbered_key(ax, [(n + 1, e.cost.way.label) for n, e in enumerate(ordered)])


def scene_figure(found, setup):
    """What each law makes of the scene: errors of the packing's stiffness, and the distribution of forces."""
    from studies.trade.packings import errors

    fig, axes = figure(columns=2, rows=len(found), width=6.4, height=4.2)
    for (engine, outcomes), (left, right) in zip(found.items(), np.reshape(axes, (-1, 2)), strict=True):
        title = f"{setup.count} granite spheres in {NAMES[engine]}"
        kinds = (("low", 0.15), ("loading", 0.75), ("unloading", 0.9))
        place = np.arange(len(outcomes))
        for n, (kind, share) in enumerate(kinds):
            values = [100.0 * getattr(errors(o, outcomes[0]), kind) for o in outcomes]
            name = {"unloading": "unloading from"}.get(kind, "loading at")
            left.barh(place + 0.27 * (n - 1), values, height=0.25, label=f"{name} {share * setup.stress / 1e3:g} kPa")
        left.set_yticks(place, [o.way.label for o in outcomes], fontsize=7)
        left.invert_yaxis()
        left.axvline(0.0, color="k", lw=0.8)
        left.set(xlabel=f"error of the packing's stiffness against {outcomes[0].way.label} (%)", title=title)
        left.legend(fontsize=7)
        for o in outcomes:
            shade = colour(o.way.law) if o.way.law else "#7f7f7f" if o.way.model in registry() else "#bcbd22"
            style = ":" if o.way.model else "-" if o.way.unloading != "elastic" else "--"
            above = 1.0 - (np.arange(o.forces.size) + 0.5) / o.forces.size
            right.semilogy(o.shape, above, style, color=shade, lw=1.0, label=o.way.label)
        right.set(xlabel="normal force over its mean", ylabel="share of contacts above", title="forces after the hold")
        right.legend(fontsize=6)
    return fig
