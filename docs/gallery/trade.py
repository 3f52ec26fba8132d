"""Error of a packing's stiffness against the cost of a step, one panel per engine, from docs/tables/trade-*.csv."""

import csv
from pathlib import Path

import matplotlib.pyplot as plt

COSTS = {"YADE": "interaction loop", "LIGGGHTS": "step"}


def rows(name):
    """Cells of the rows of a file of docs/tables, by the names of its columns."""
    with open(Path(__file__).parents[1] / "tables" / f"{name}.csv", encoding="utf-8") as file:
        yield from csv.DictReader(file)


steps = {row["law"]: row for row in rows("trade-contact")}
errors = {
    (row["law"], row["engine"]): max(abs(float(cell)) for cell in list(row.values())[3:])
    for row in rows("trade-packing")
    if row["stresses"] == "75 and 375 kPa"
}
fig, axes = plt.subplots(1, 2, figsize=(9.6, 4.2), sharey=True, layout="constrained")
small = {"fontsize": 8, "textcoords": "offset points", "va": "center"}
for ax, engine in zip(axes, COSTS, strict=True):
    cost = f"{engine} {COSTS[engine]}"
    ax.axhspan(0.1, errors["random scatter", engine], color="0.9")
    ax.text(0.98, 0.02, "random scatter: positions perturbed", transform=ax.transAxes, ha="right", color="0.4", fontsize=8)
    for law in steps:
        error = errors.get((law.replace("the engine's own Hertz", "hertz"), engine))
        if error is None or steps[law][cost] == "–":
            continue
        best = law == "pohrt-popov, Hertz unloading"
        step = float(steps[law][cost])
        ax.plot(step, error, "*" if best else "o", ms=16 if best else 7, color="tab:red" if best else "tab:blue")
        place = (-9, 13) if law == "hertz" else (9, 0)
        if step > 1.5:
            place = (-9, 0)
        align = "right" if step > 1.5 else "left"
        ax.annotate(law + (" (recommended)" if best else ""), (step, error), xytext=place, ha=align, **small)
    ax.axvline(1.0, color="0.6", lw=0.8, ls=":")
    ax.set(yscale="log", xlabel=f"time of the {COSTS[engine]} / with the engine's own Hertz", title=engine, ylim=(0.1, 200))
    ax.grid(alpha=0.3)
axes[0].set(ylabel="largest error of the packing's stiffness (%)", xlim=(0.7, 1.2))
axes[1].set(xlim=(0.7, 2.5))
fig.savefig("trade.png", dpi=130)
