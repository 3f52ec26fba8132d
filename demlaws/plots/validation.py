"""The validation report as a picture."""

import numpy as np

from demlaws.plots import figure


def deviations(groups):
    """Every row's distance from the middle of its range over half the range, by group: 1 is the limit."""
    fig, ax = figure(width=8.0, height=0.42 * len(groups) + 1.4)
    for height, rows in enumerate(groups.values()):
        for verdict, colour, marker in (("pass", "tab:blue", "o"), ("FAIL", "tab:red", "X")):
            chosen = [row for row in rows if row.verdict == verdict]
            distance = [max(abs(2.0 * (row.found - row.low) / (row.high - row.low) - 1.0), 1e-9) for row in chosen]
            spread = np.linspace(-0.25, 0.25, len(distance)) if distance else []
            ax.plot(distance, height + np.asarray(spread), marker, color=colour, ms=4, ls="none")
    ax.axvline(1.0, color="k", lw=0.8)
    ax.set(xscale="log", xlim=(7e-10, 12.0), xlabel="distance from the expected value over tolerance")
    ax.set_yticks(range(len(groups)), list(groups))
    ax.invert_yaxis()
    return fig
