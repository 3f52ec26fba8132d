"""Figures of fits, choices, the trade of speed for accuracy, and the extremes."""

import numpy as np

from demlaws.core.unloading import RULES
from demlaws.laws.registry import registry
from demlaws.measure.candidates import NAMES
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
    right.set(title="what the laws leave of the displacement")
    right.set(xlabel="force (N)", ylabel="measured - fitted displacement (µm)", ylim=(-1.2e6 * widest, 1.2e6 * widest))
    left.legend(fontsize=7)
    right.legend(fontsize=7)
    return fig


def _numbered_key(ax, lines, title=None):
    """A legend beside the axes: number in the picture and what it stands for."""
    handles = [
        ax.plot([], [], ls="none", marker=f"${n}$", ms=5 if n < 10 else 7, color="k", mew=0.3, label=text)[0]
        for n, text in lines
    ]
    keep = ax.get_legend()
    ax.legend(handles=handles, fontsize=6.5, loc="upper left", bbox_to_anchor=(1.01, 1.0), title=title, title_fontsize=7)
    if keep is not None:
        ax.add_artist(keep)


def _number(ax, points, near=0.03):
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
    markers = {"closed form": "o", "table": "s", "closed form, float32": "^"}
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
        xlabel=f"ns a contact and reference time step, {choices.measured_in}",
        ylabel=f"largest error of {choices.scene.quantity} (below {lowest:g} drawn there)",
        title=choices.scene.name or "choices",
    )
    ax.legend(fontsize=7)
    _number(ax, [(n + 1, (c.cost, max(c.error, lowest))) for n, c in enumerate(choices)])
    labels = [f"{c.name}{c.branch}, {c.unloading}, {c.evaluation}" for c in choices]
    _numbered_key(ax, [(n + 1, text) for n, text in enumerate(labels)], "in the order of the choice")
    return fig


_GENERAL = dict(zip(RULES, ("-", "--", ":", "-."), strict=True))


def _line(rule):
    """Line style of an unloading rule; a law's own rule has one of its own."""
    return _GENERAL.get(rule, "-.")


_ENGINES = {"YADE": "o", "LIGGGHTS": "x", "LAMMPS": "+"}


def _key(ax, colours, styles, **options):
    """Legend of colours (laws) and of line styles or markers (what else differs), each named once."""
    from matplotlib.lines import Line2D

    handles = [Line2D([], [], color=colour(law), lw=2, label=law) for law in colours]
    for name, style in styles.items():
        marker = {"marker": style, "ls": ""} if style in _ENGINES.values() else {"ls": style}
        handles.append(Line2D([], [], color="#555555", lw=1.2, ms=4, label=name, **marker))
    ax.legend(handles=handles, fontsize=7, **options)


def stability_figure(rows, inside=()):
    """Energy gain against steps per contact; rounding by decade; stable step; the same inside the engines.

    rows: `stability.Figures`; inside: `extremes.Figures`. Either may be empty.
    """
    closed = [r for r in rows if r.evaluation == "closed form"]
    laws = list(dict.fromkeys(r.law for r in [*closed, *inside]))
    parts = [_gains, *([_rounding, _steps] if closed else []), *([_inside] if inside else [])]
    fig, axes = figure(columns=2 if len(parts) > 1 else 1, rows=(len(parts) + 1) // 2, width=6.0, height=4.4)
    axes = list(np.ravel(axes))
    for part in parts:
        part(axes.pop(0), closed, inside, laws)
    for ax in axes:
        ax.set_visible(False)
    return fig


def _gains(ax, closed, inside, laws):
    lowest = 1e-12
    for r in closed:
        steps = sorted(r.gains)
        gain = [max(r.gains[s], lowest) for s in steps]
        ax.loglog(steps, gain, _line(r.unloading), color=colour(r.law), lw=1.2)
    for r in inside:
        steps = sorted(r.impacts.gains)
        gain = [max(r.impacts.gains[s], lowest) for s in steps]
        line = "" if closed else _line(r.unloading)  # beside the laws' own lines marks are enough
        ax.loglog(steps, gain, line + _ENGINES[r.engine], color=colour(r.law), ms=4, mfc="none", lw=0.8)
    ax.axhline(1e-4, color="k", lw=0.8)
    ax.set(xlabel="steps per contact", ylabel="largest energy gain of an impact")
    ax.set_title("impacts, 1e-6 to 100 m/s" + (" (inside an engine from 0.01 m/s)" if inside else ""), fontsize=9)
    styles = {rule: _line(rule) for rule in dict.fromkeys((*RULES, *(r.unloading for r in (*closed, *inside))))}
    styles |= {**{e: m for e, m in _ENGINES.items() if any(r.engine == e for r in inside)}}
    _key(ax, laws, styles, ncols=2, loc="lower left")


def _rounding(ax, closed, inside, laws):
    drawn = [r for r in closed if r.rounding and r.unloading == "elastic"]
    for r in drawn:
        decades = sorted(r.rounding)
        style = "o-" if registry()[r.law].before_yield is None else "o--"  # before yield it is the law that it joins
        ax.plot(decades, [r.rounding[d] for d in decades], style, ms=3, color=colour(r.law))
    others = ", ".join(name for name, definition in registry().items() if definition.length == "radius")
    ax.set(xlabel=f"decade of δ/σ ({others}: of δ/R)", ylabel="largest error of force (ε = 2.2e-16)", ylim=(0.0, None))
    ax.set_title("rounding, against extended precision", fontsize=9)
    _key(ax, list(dict.fromkeys(r.law for r in drawn)), {})


def _steps(ax, closed, inside, laws):
    names = [f"{r.law}, {r.unloading}" for r in closed]
    for place, r in enumerate(closed):
        low, high = r.step_ratio
        ax.plot([low, high], [place, place], "|-", color=colour(r.law), lw=3, ms=8)
    ax.set_yticks(range(len(names)), names, fontsize=7)
    ax.invert_yaxis()
    for limit in (0.5, 1.0):
        ax.axvline(limit, color="k", lw=0.8)
    ax.set(xlabel="dl.timestep over the measured stable step (allowed: 0.5 to 1)", xlim=(0.45, 1.05))
    ax.set_title("time step, over loads and contacts", fontsize=9)


def _inside(ax, closed, inside, laws):
    highest = max((e for r in inside for e in r.compared.decades.values()), default=1.0)
    for r in inside:
        if r.unloading == "elastic" or r.unloading == next(x.unloading for x in inside if x.law == r.law):
            decades = sorted(r.compared.decades)
            errors = [max(r.compared.decades[d], 0.3) for d in decades]
            ax.plot(decades, errors, _ENGINES[r.engine] + "-", ms=4, lw=0.8, mfc="none", color=colour(r.law))
    ax.set(
        xlabel="decade of δ/R",
        ylabel="largest error of force (ε = 2.2e-16)",
        yscale="log",
        ylim=(0.3, 30.0 * max(highest, 1.0)),
    )
    ax.set_title("inside the engines: against the law (YADE), its table (LIGGGHTS, LAMMPS), in Python", fontsize=9)
    engines = {e: m for e, m in _ENGINES.items() if any(r.engine == e for r in inside)}
    _key(ax, list(dict.fromkeys(r.law for r in inside)), engines, ncols=2)


_MARKERS = {"closed form": "o", "float32": "^", "table": "s", "lazy": "x"}


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
    ax.set(xscale="log", yscale="log", xlabel="ns a contact (dotted: copy kernel)", ylabel="largest error of force")
    _limited(ax, [floor, *(e.ns for e in closed)])
    ax.set(title="what a law leaves out (closed forms; line: front of all ways)")
    _number(ax, [(n + 1, (e.ns, max(e.richest["force"], lowest))) for n, e in enumerate(closed)])
    _numbered_key(ax, [(n + 1, f"{e.law}, {e.unloading}") for n, e in enumerate(closed)], "hollow: with history")


def _evaluations_panel(ax, entries):
    """Tables, single precision and lazy refresh: error against the own closed form over cost relative to it."""
    lowest = 1e-16
    closed = {e[:2]: e.ns for e in entries if e.evaluation == "closed form"}
    shown = [e for e in entries if e.evaluation != "closed form" and e[:2] in closed]
    for e in shown:
        edge = {} if e.evaluation == "lazy" else {"mec": "white", "mew": 0.4}
        place = e.ns / closed[e[:2]], max(e.own["force"], lowest)
        ax.plot(*place, _MARKERS[e.evaluation], color=colour(e.law), ms=5, alpha=0.8, **edge)
    ax.axvline(1.0, color="k", lw=0.8, ls=":")
    ax.set(xscale="log", yscale="log", xlabel="cost over that of the law's closed form", ylabel="largest error of force")
    _limited(ax, [e.ns / closed[e[:2]] for e in shown])
    ax.set(title="what an evaluation costs and errs, against the closed form")
    for name, marker in _MARKERS.items():
        if name != "closed form":
            ax.plot([], [], marker, color="#666666", label=name, ms=4)
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
    _number(ax, [(n + 1, (e.cost.over_hertz, max(e.error, lowest))) for n, e in enumerate(ordered)])
    _numbered_key(ax, [(n + 1, e.cost.way.label) for n, e in enumerate(ordered)])


def scene_figure(found, setup):
    """What each law makes of the scene: errors of the packing's stiffness, and the distribution of forces."""
    from demlaws.measure.packings import errors

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
