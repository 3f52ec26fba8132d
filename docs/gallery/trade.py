"""Error of a packing's stiffness against the cost of a step, one panel per engine, from trade.csv."""

import csv
from pathlib import Path

import matplotlib.pyplot as plt

CHANCE = {"YADE": 0.6, "LIGGGHTS": 0.3}  # per cent: the same packing, shaken
lines = [line for line in (Path(__file__).parent / "trade.csv").read_text().splitlines() if not line.startswith("#")]
rows = list(csv.DictReader(lines))
fig, axes = plt.subplots(1, 2, figsize=(9.6, 4.2), sharey=True, layout="constrained")
small = {"fontsize": 8, "textcoords": "offset points", "va": "center"}
for ax, engine in zip(axes, CHANCE, strict=True):
    ax.axhspan(0.1, CHANCE[engine], color="0.9")
    ax.text(0.98, 0.02, "chance: the same packing, shaken", transform=ax.transAxes, ha="right", color="0.4", fontsize=8)
    for row in (row for row in rows if row["engine"] == engine):
        best = row["way"].endswith("Popov, hertz unloading")
        step, error = float(row["step"]), float(row["error"])
        ax.plot(step, error, "*" if best else "o", ms=16 if best else 7, color="tab:red" if best else "tab:blue")
        side = {"ha": "right", "xytext": (-9, 0)} if step > 1.5 else {"ha": "left", "xytext": (9, 0)}
        ax.annotate(row["way"] + (" (recommended)" if best else ""), (step, error), **small, **side)
    ax.axvline(1.0, color="0.6", lw=0.8, ls=":")
    ax.set(yscale="log", xlabel="time of a step / step with the engine's own Hertz", title=engine, ylim=(0.1, 200))
    ax.grid(alpha=0.3)
axes[0].set(ylabel="largest error of the packing's stiffness (%)", xlim=(0.7, 1.7))
axes[1].set(xlim=(0.7, 2.5))
fig.savefig("trade.png", dpi=130)
