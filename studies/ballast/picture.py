"""The picture of a bed under cyclic load: settlement, 2,000 cycles with fitted laws, resilient modulus, dissipated energy."""

import numpy as np

from studies.ballast.cycles import STAGES
from studies.ballast.report import LONGEST, dissipation, fit, longest, main_cycles, moduli, series, settlement

UNKNOWN = (("all (friction not booked)", 100.0, "0.7"),)
STYLES = {"default": "-", "mindlin": "--", "slip": ":"}


def draw(rows):
    """A figure of four panels."""
    from demlaws.plots import figure

    fig, axes = figure(columns=2, rows=2, width=5.6, height=4.3)
    found = series(rows)
    looks = {look: f"C{n}" for n, look in enumerate(dict.fromkeys(kind[:3] for kind in found))}
    _settlements(axes[0, 0], found, looks)
    _many(axes[0, 1], longest(rows))
    _moduli(axes[1, 0], found, looks)
    _dissipation(axes[1, 1], found)
    return fig


def _settlements(ax, found, looks):
    """Mean of the packings of each kind; bands from the smallest to the largest."""
    for kind, beds in found.items():
        number, _ = main_cycles(next(iter(beds.values())))
        settled = np.array([[settlement(one, n) for n in number] for one in beds.values()])
        more = {"color": looks[kind[:3]], "ls": STYLES[kind.shear]}
        ax.plot(number, settled.mean(axis=0), lw=1.4, label=f"{kind} ({len(beds)})", **more)
        if len(beds) > 1 and kind.shear == "default":
            ax.fill_between(number, settled.min(axis=0), settled.max(axis=0), color=more["color"], alpha=0.12, lw=0)
    ax.set(xscale="log", yscale="log", xlabel="cycle", ylabel="settlement (µm)", title="settlement; in brackets: packings")
    ax.set_ylim(ax.get_ylim()[0], 8.0 * ax.get_ylim()[1])
    ax.legend(fontsize=6, ncols=2, loc="upper left")


def _many(ax, rows):
    """The longest case with both laws fitted to its first cycles and to all."""
    number, settled = main_cycles(rows)
    ax.plot(number, settled, "k.-", ms=4, lw=1, label="pohrt-popov, σ = 2.4 µm, default")
    way = np.geomspace(2, number[-1], 100)
    for last, style in ((LONGEST, ":"), (number[-1], "-")):
        law = fit(rows, last)
        for name, values, colour in zip(("a + b log N", f"N^{law.exponent:.2f}"), law.at(way), ("C0", "C1"), strict=True):
            ax.plot(way, values, style, color=colour, lw=1.2, label=f"{name}, fitted to cycles 2 to {last:.0f}")
    about = {"xlabel": "cycle", "ylabel": "settlement (µm)", "title": f"{number[-1]:.0f} cycles, one packing"}
    ax.set(xscale="log", yscale="log", ylim=(0.3 * settled[0], 2.0 * settled[-1]), **about)
    ax.legend(fontsize=7)


def _moduli(ax, found, looks):
    """Secant moduli over the largest pressure, and the secants of tangent moduli ∝ p^m."""
    for kind, beds in found.items():
        pressure, modulus = np.mean([moduli(one) for one in beds.values()], axis=0)
        ax.plot(pressure, modulus, marker="o", ms=3, lw=1.2, color=looks[kind[:3]], ls=STYLES[kind.shear])
    way = np.geomspace(1e-3 * STAGES[0], 1e-3 * STAGES[-1])
    for m, style in ((1 / 3, "-"), (0.5, "--")):
        secant = (way - 20.0) / (way ** (1 - m) - 20.0 ** (1 - m))
        ax.plot(way, 120.0 * secant / secant[0], color="0.6", lw=1, ls=style, label=f"secant, tangent ∝ p^{m:.2g}")
    ax.set(xscale="log", yscale="log", xlabel="largest pressure (kPa)", ylabel="resilient modulus (MPa)", title="stiffness")
    ax.set_xticks([1e-3 * p for p in STAGES], [f"{1e-3 * p:g}" for p in STAGES])
    ax.set_xticks([], minor=True)
    for form in (ax.yaxis.set_major_formatter, ax.yaxis.set_minor_formatter):
        form("{x:g}")
    ax.legend(fontsize=7)


def _dissipation(ax, found):
    """Friction, plastic flow and damping of a cycle, mean of the packings."""
    kinds = [kind for kind in found if not np.isnan(dissipation(next(iter(found[kind].values()))).total)]
    for place, kind in enumerate(kinds[::-1]):
        mean = np.mean([dissipation(one) for one in found[kind].values()], axis=0)
        total, shares = mean[0], np.array(mean[1:4])
        left = 0.0
        known = not np.isnan(shares).any()
        parts = zip(("friction", "plastic flow", "damping"), shares, ("C0", "C3", "C2"), strict=True) if known else UNKNOWN
        for name, part, colour in parts:
            label = name if name not in ax.get_legend_handles_labels()[1] else None
            ax.barh(place, 0.01 * part * total, left=left, color=colour, label=label, height=0.7)
            left += 0.01 * part * total
    ax.set_yticks(range(len(kinds)), [str(kind).replace(", ", "\n", 1) for kind in kinds[::-1]], fontsize=6)
    ax.set(xlabel="dissipated in a cycle (mJ), cycles 15 to 30", title="where the energy goes")
    ax.legend(fontsize=7)
