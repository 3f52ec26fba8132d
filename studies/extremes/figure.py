"""Figures of the extremes."""

import numpy as np

from demlaws.core.unloading import RULES
from demlaws.laws.registry import registry
from demlaws.plots import colour, figure

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
