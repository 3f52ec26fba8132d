"""Figure of softer grains, faster loading and longer steps: error of the packing against time to solution."""

import math

from demlaws.plots import figure

_COLOURS = {1.0: "#222222", 3.0: "#9467bd", 10.0: "#1f77b4", 100.0: "#d62728", 1000.0: "#ff7f0e"}
_SHAPES = ((1.5e-4, "v"), (6e-4, "o"), (3e-3, "s"), (math.inf, "^"))
_NAMES = {"yade": "YADE", "liggghts": "LIGGGHTS"}
_WHAT = {"cycles": "largest error of the packing's stiffness", "shear": "error of the peak strength", "pour": "error of height"}
_LOWEST = 1e-3  # an error below is drawn there: a part of chance


def softening_figure(points):
    """One panel a process and engine: errors with the scatter of chance, modulus factors, σ scaled or alone, rates, front."""
    from studies.softening.results import first_quantity, worst
    from studies.softening.study import STUDIED

    keys = sorted({(p.run.process, p.run.engine) for p in points}, key=lambda key: (key[0] != "cycles", key))
    fig, axes = figure(columns=min(2, len(keys)), rows=(len(keys) + 1) // 2, width=7.2, height=4.4)
    axes = list(axes.ravel()) if hasattr(axes, "ravel") else [axes]
    for ax, (process, engine) in zip(axes, keys, strict=False):
        own = [p for p in points if (p.run.process, p.run.engine) == (process, engine) and worst(p) == worst(p)]
        chance = max((p.chance.get(first_quantity(p), math.nan) for p in own), default=math.nan)
        for p in own:
            shade = _COLOURS.get(p.run.factor, "#2ca02c")
            ours = (p.run.law, p.run.unloading) == STUDIED
            shape = next(mark for end, mark in _SHAPES if p.run.inertial <= end) if ours else "*"
            value = max(worst(p), _LOWEST)
            spread = p.chance.get(first_quantity(p), 0.0)
            spread = 0.0 if spread != spread else spread
            ax.errorbar(
                p.seconds,
                value,
                yerr=[[min(spread, 0.9 * value)], [spread]],
                fmt=shape,
                color=shade,
                mfc=shade if p.run.scaled else "white",
                ms=9 if shape == "*" else 6,
                lw=0.8,
                capsize=2,
            )
        front = sorted((p.seconds, max(worst(p), _LOWEST)) for p in own if p.front)
        if front:
            ax.step([f[0] for f in front], [f[1] for f in front], "k-", where="post", lw=0.8, zorder=0)
        if chance == chance:
            ax.axhspan(_LOWEST * 0.7, max(chance, _LOWEST), color="#dddddd", zorder=-1)
        ax.set(xscale="log", yscale="log", xlabel="time to solution (s, one core)", ylabel=_WHAT[process])
        ax.set(ylim=(0.7 * _LOWEST, 3.0), title=f"{'oedometer' if process == 'cycles' else process} in {_NAMES[engine]}")
    for ax in axes[len(keys) :]:
        ax.set_visible(False)
    _legend(axes[min(1, len(keys) - 1)], points)
    return fig


def _legend(ax, points):
    from studies.softening.study import STUDIED

    handles = []

    def entry(text, **style):
        handles.append(ax.plot([], [], **{"ls": "none", "marker": "o", "color": "#666666", "ms": 6, **style}, label=text)[0])

    for factor in sorted({p.run.factor for p in points}):
        entry(f"E/{factor:g}", color=_COLOURS.get(factor, "#2ca02c"))
    entry("filled: σ scaled along")
    entry("hollow: σ left alone", mfc="white")
    for rate in sorted({p.run.inertial for p in points}):
        entry(f"I = {rate:g}", marker=next(mark for end, mark in _SHAPES if rate <= end))
    if any((p.run.law, p.run.unloading) != STUDIED for p in points):
        entry("another law", marker="*", ms=9)
    entry("Pareto front", marker="", ls="-", color="k")
    entry("chance", marker="s", color="#dddddd")
    ax.legend(handles=handles, fontsize=7, loc="upper left", bbox_to_anchor=(1.01, 1.0))
