"""The picture of a bed under cyclic load: settlement, 2,000 cycles with fitted laws, dissipated energy."""

import numpy as np

from studies.ballast.report import LONGEST, STOCK, dissipation, fit, longest, main_cycles, series, settlement

STYLES = {"default": "-", "mindlin": "--", "slip": ":"}


def draw(rows, clumps):
    """A figure of three panels, one below the other: readable on a narrow screen; `clumps`: rows of `cycles.LONG`."""
    from demlaws.plots import figure

    fig, axes = figure(rows=3, width=6.4, height=3.8)
    axes[0].get_gridspec().set_height_ratios((1.15, 0.85, 1.2))
    found = series(rows)
    _settlements(axes[0], found)
    _many(axes[1], longest(rows), longest(clumps))
    _dissipation(axes[2], found)
    return fig


def short(kind):
    """Grains and roughness."""
    return f"{kind.grains}, " + (f"σ = {kind.sigma:g} µm" if kind.sigma else "smooth")


def _settlements(ax, found):
    """Mean of the packings of each kind; bands from the smallest to the largest."""
    looks = {look: f"C{n}" for n, look in enumerate(dict.fromkeys(short(kind) for kind in found))}
    for kind, beds in found.items():
        number, _ = main_cycles(next(iter(beds.values())))
        settled = np.array([[settlement(one, n) for n in number] for one in beds.values()])
        more = {"color": looks[short(kind)], "ls": STYLES[kind.shear]}
        ax.plot(number, settled.mean(axis=0), lw=1.4, label=short(kind) if kind.shear == "default" else None, **more)
        if len(beds) > 1 and kind.shear == "default":
            ax.fill_between(number, settled.min(axis=0), settled.max(axis=0), color=more["color"], alpha=0.12, lw=0)
    for shear in ("mindlin", "slip"):
        ax.plot([], [], "k", ls=STYLES[shear], lw=1.4, label=f"shear model {shear}")
    about = {"xlabel": "cycle", "ylabel": "settlement (µm)", "title": "Settlement: σ acts in cycle 1, shape after it"}
    ax.set(xscale="log", yscale="log", **about)
    ax.set_ylim(top=8.0 * ax.get_ylim()[1])
    ax.legend(fontsize=8.5, ncols=2, loc="upper left")


def _many(ax, beds, clumps):
    """The longest cases, each with both laws fitted to its first cycles."""
    labels = set()

    def add(number, values, look, label, **more):
        ax.plot(number, values, look, label=None if label in labels else label, **more)
        labels.add(label)

    marked = [("spheres", ".-", one) for one in beds.values()]
    marked += [("clumps", "x-", one) for one in clumps.values()]
    for name, mark, rows in marked:
        number, settled = main_cycles(rows)
        add(number, settled, f"k{mark}", f"{name}, σ = 2.4 µm", ms=4, lw=1)
        way, law = np.geomspace(2, number[-1], 100), fit(rows, LONGEST)
        for formula, values, colour in zip(("a + b log N", "c N^d"), law.at(way), ("C0", "C1"), strict=True):
            add(way, values, colour, f"{formula}, fitted to cycles 2 to {LONGEST:.0f}", lw=1.2)
    most = max(rows[0]["cycles"] for _, _, rows in marked)
    title = f"Up to {most:,.0f} cycles: fits to {LONGEST} fall short"
    ax.set(xscale="log", yscale="log", ylim=(20.0, None), xlabel="cycle", ylabel="settlement (µm)", title=title)
    ax.legend(fontsize=8.5)


def _dissipation(ax, found):
    """Friction, plastic flow and damping of cycle 1 and of a later one, means of the packings."""
    kinds = [kind for kind in found if kind.shear not in STOCK]
    for (place, kind), (up, cycles) in (
        (pair, bar) for pair in enumerate(kinds[::-1]) for bar in ((0.2, (1, 1)), (-0.2, (15, 30)))
    ):
        total, *shares, _ = np.mean([dissipation(one, *cycles) for one in found[kind].values()], axis=0)
        left = 0.0
        for name, part, colour in zip(("friction", "plastic flow", "damping"), shares, ("C0", "C3", "C2"), strict=True):
            label = name if name not in ax.get_legend_handles_labels()[1] else None
            ax.barh(place + up, 0.01 * part * total, left=left, color=colour, label=label, height=0.36)
            left += 0.01 * part * total
    names = [short(kind) + (", slip" if kind.shear == "slip" else "") for kind in kinds[::-1]]
    ax.set_yticks(range(len(kinds)), names, fontsize=8.5)
    ax.set(xlabel="dissipated (mJ): upper bar cycle 1, lower bar a later cycle", title="Where the energy goes")
    ax.legend(fontsize=8.5)
