"""The figures of Jamari & Schipper 2006 and 2008, each with the numbers in it and who says them.

Every function returns (figure, lines of text). The papers' maps and measured profiles are not public: they are replaced by
a synthetic map of the printed roughness (`published.published_contact`).
"""

import functools

import numpy as np

from demlaws import regime
from demlaws.plots import figure
from demlaws.plots.surface import MICRO, regime_axis, regime_bar
from studies.jamari import published
from studies.jamari.cycles import SHOWN, repeat

SEEN = {"asperities": ("o", "white"), "both": ("s", "#ffbf00"), "bulk": ("D", "black")}

LOAD = 0.2  # [N]


def regime_map():
    """p(0)/H_m over load and roughness for the published tests, with what was seen there."""
    fig, axes = figure(columns=3, width=4.6, height=4.4)
    ratios = {row.test.label: row for row in published.published_ratios()}
    tests = [row.test for row in ratios.values()]
    groups = (
        ("aluminium, steel ball R = 5 mm (2006)", [t for t in tests if t.label.startswith("Al")]),
        ("brass, steel ball R = 5 mm (2006)", [t for t in tests if t.label.startswith("Br")]),
        ("aluminium, SiC ball R = 3.175 mm (2008)", [t for t in tests if t.label.startswith("2008")]),
    )
    image = None
    for ax, (name, group) in zip(axes, groups, strict=True):
        image = regime_axis(ax, group[0].contact, np.geomspace(0.03, 100, 161), np.geomspace(2e-8, 2e-5, 161))
        for n, test in enumerate(group):
            marker, face = SEEN[test.seen]
            x, y = test.load, test.contact.roughness * MICRO
            ax.plot(x, y, marker, mfc=face, mec="black", ms=8, zorder=5)
            side = {"Al_A": (8, 7), "Al_AB": (8, -12)}.get(test.label, (8, -3 + 10 * n if "2008" in test.label else -3))
            solved, fitted = ratios[test.label].solved, ratios[test.label].fitted
            ax.annotate(
                f"{fitted:.3f}" if np.isnan(solved) else f"{solved:.3f} at μ = {test.mu:g}",
                (x, y),
                side,
                textcoords="offset points",
                fontsize=8,
                bbox={"boxstyle": "round,pad=0.15", "fc": "white", "ec": "none", "alpha": 0.7},
            )
        ax.set_title(name, fontsize=10)
    regime_bar(fig, image, axes)
    for seen, (marker, face) in SEEN.items():
        axes[0].plot([], [], marker, mfc=face, mec="black", ls="none", label=f"seen: {seen}")
    axes[0].legend(loc="upper left", fontsize=8)
    return fig


# --- 2006


def central_pressure():
    """Fig. 1 of 2006: p(0)/p0 against α for two μ, the fit of Eq. 4, and what the text reads off it at α = 0.09."""
    fig, ax = figure(width=6.2, height=4.4)
    alpha = np.geomspace(0.01, 30.0, 70)
    said = ["computed (Greenwood & Tripp's solution; Eq. 4 beside it):"]
    shown = np.array([0.05, 0.2, 1.0, 5.0, 20.0])
    columns = {}
    for mu, style in ((4.0, "-"), (17.0, "--")):
        ax.semilogx(alpha, regime.central_pressure(alpha, mu), style, color="#1f77b4", label=f"Greenwood & Tripp, μ = {mu:g}")
        columns[mu] = regime.central_pressure(shown, mu)
    ax.semilogx(alpha, regime.pressure_drop(alpha), ":", color="#d62728", lw=1.8, label="the paper's fit, Eq. 4")
    for n, value in enumerate(shown):
        said.append(
            f"  α = {value:g}: {columns[4.0][n]:.3f} at μ = 4, {columns[17.0][n]:.3f} at μ = 17; "
            f"{regime.pressure_drop(value):.3f} by Eq. 4"
        )
    for (mu, printed), marker in zip(published.PRINTED_RATIOS.items(), "vs^", strict=True):
        ax.plot(0.09, printed, "k" + marker, mfc="none", ms=6, label=f"printed: {printed:g} at α = 0.09, μ = {mu:g}")
        found = regime.central_pressure(0.09, mu)
        said.append(f"  α = 0.09, μ = {mu:g}: printed {printed:g} (read from the figure by its authors), computed {found:.4f}")
    ax.set(xlabel="α = σR/a_H²", ylabel="p(0)/p$_0$", ylim=(0, 1), title="central pressure of a rough contact")
    ax.legend(fontsize=8)
    return fig, said


def criterion():
    """Fig. 12 of 2006: p(0)/H against roughness, with the six tests that the paper names."""
    fig, ax = figure(width=6.6, height=4.4)
    rows = [row for row in published.published_ratios() if not np.isnan(row.solved)]
    said = ["p(0)/H computed at the printed μ (the paper prints none of them), and by Eq. 4; seen as printed:"]
    for name, colour in (("aluminium", "#4c78a8"), ("brass", "#b8860b")):
        chosen = [row for row in rows if row.test.material == name]
        contact, load = chosen[0].test.contact, chosen[0].test.load
        roughness = np.geomspace(0.02e-6, 3e-6, 25)
        alpha = np.array([contact.with_values(roughness=r).roughness_parameter(load) for r in roughness])
        smooth = float(regime.hertz_pressure(contact, load)) / contact.hardness
        low, high = (smooth * regime.central_pressure(alpha, mu) for mu in (4.0, 17.0))
        ax.fill_between(roughness * MICRO, low, high, color=colour, alpha=0.25, lw=0, label=f"{name}, {load:g} N: μ = 4 to 17")
        ax.plot(roughness * MICRO, smooth * regime.pressure_drop(alpha), ":", color=colour, label=f"{name}: Eq. 4")
        for row in chosen:
            marker, face = SEEN[row.test.seen]
            sigma = row.test.contact.roughness * MICRO
            ax.plot(sigma, row.solved, marker, mfc=face, mec=colour, ms=8, mew=1.6, zorder=4)
            said.append(
                f"  {row.test.label:5} σ = {sigma:.2f} µm, α = {row.alpha:.3f} (printed {row.test.alpha:g}), "
                f"μ = {row.test.mu:g} (printed): {row.solved:.3f}; Eq. 4 {row.fitted:.3f}; seen: {row.test.seen}"
            )
    for seen, (marker, face) in SEEN.items():
        ax.plot([], [], marker, mfc=face, mec="black", ls="none", label=f"seen: {seen} (at the printed μ)")
    ax.axhline(regime.YIELD_RATIO, color="black", lw=1)
    ax.axhspan(regime.YIELD_RATIO - regime.BAND, regime.YIELD_RATIO + regime.BAND, color="grey", alpha=0.2, lw=0)
    ax.set(xlabel="roughness Sq (µm)", ylabel="p(0)/H", ylim=(0, 1.9), xlim=(0, 3), title="what deforms, by roughness")
    ax.legend(fontsize=7, ncol=2, loc="upper right")
    return fig, said


# --- 2008


@functools.cache
def _history(kind, memory):
    """The contact of the paper before and after each of its cycles; kept: it is drawn three times."""
    contact = published.published_contact(kind, memory=memory)
    return contact, repeat(contact, LOAD)


def _profiles(kind):
    """Figs. 9 and 12: x and y profile through the pixel that lost most, before and after cycles 1, 2, 3, 10, 20."""
    from demlaws.solvers.contact import MEMORIES

    contact, history = _history(kind, "pressure")
    heights = contact.heights
    change = history[0].contact.heights.heights - heights.heights
    row, column = np.unravel_index(np.nanargmin(change), change.shape)
    fig, axes = figure(columns=2, rows=2, width=5.4, height=3.6)
    said = []
    for line, memory in enumerate(("pressure", "none")):
        _, cycles = _history(kind, memory)
        maps = {0: heights, **{c.number: c.contact.heights for c in cycles if c.contact is not None}}
        for ax, along in zip(axes[line], "xy", strict=True):
            pixel = (heights.pixel_x if along == "x" else heights.pixel_y) * MICRO
            at = (column if along == "x" else row) * pixel
            for n, one in maps.items():
                z = (one.heights[row] if along == "x" else one.heights[:, column]) * MICRO
                place = np.arange(z.size) * pixel
                near = np.abs(place - at) < 22
                style = {"color": "k", "lw": 1.8} if n == 0 else {"lw": 1.1, "ls": (0, (3 + n % 4, 1.5))}
                ax.plot(place[near], z[near], label=f"n = {n}", **style)
            fixed = (
                f"y = {row * heights.pixel_y * MICRO:.0f}" if along == "x" else f"x = {column * heights.pixel_x * MICRO:.0f}"
            )
            ax.set(xlabel=f"{along} (µm)", ylabel="height (µm)")
            ax.set_title(f"{along}-profile at {fixed} µm; memory: {memory}", fontsize=9)
    axes[0, 0].legend(fontsize=7, ncol=2)
    for memory in MEMORIES:
        _, cycles = _history(kind, memory)
        first, last = (cycles[n - 1].contact.heights.heights for n in (1, SHOWN[-1]))
        lowered = -np.nanmin(first - heights.heights) * MICRO
        further = max(-np.nanmin(last - first) * MICRO, 0.0)
        said.append(
            f"computed, memory {memory}: cycle 1 lowers the map by up to {lowered:.3f} µm, cycles 2 to {SHOWN[-1]} by up to "
            f"{further:.3f} more; cycle 2 changes {100 * cycles[1].relative_change:.2g} % of what cycle 1 did"
        )
    place = {"isotropic": "y = 120 µm and x = 129 µm", "anisotropic": "y = 118 µm and x = 126 µm"}[kind]
    said.append(
        f"printed: almost no difference between cycles {', '.join(map(str, SHOWN))} (its profiles: {place} of its own map)"
    )
    return fig, said


FIGURES_2006 = {1: central_pressure, 12: criterion}
FIGURES_2008 = {
    9: functools.partial(_profiles, "isotropic"),
    12: functools.partial(_profiles, "anisotropic"),
}
"""Number of a figure → function that draws it."""
