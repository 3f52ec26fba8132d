"""Time of a step, or of YADE's interaction loop, over that with the engine's own Hertz law, from docs/tables/cost-steps.csv."""

import csv
import re
from pathlib import Path

import matplotlib.pyplot as plt

LAWS = ("pohrt-popov, elastic", "pohrt-popov, Hertz unloading")
RATIO = "time over the engine's own Hertz and shear"
with open(Path(__file__).parents[1] / "tables" / "cost-steps.csv", encoding="utf-8") as file:
    ROWS = [row for row in csv.DictReader(file) if row["contacts"] in ("4038", "14742") and row["law"] in LAWS]
OTHER = re.compile("--(sizes|damped|periodic)|make bench$")  # rows of the table that the picture leaves out
ROWS = [row for row in ROWS if not OTHER.search(row["command"])]

fig, ax = plt.subplots(figsize=(7.2, 3.6), layout="constrained")
labels = []
for place, row in enumerate(reversed(ROWS)):
    ratio = float(row[RATIO])
    ax.barh(place, ratio, color="tab:blue" if row["shear"] == "3 levels" else "0.7")
    ground = {"facecolor": "w", "edgecolor": "none", "pad": 0.5}  # over the dotted line
    ax.annotate(row[RATIO], (ratio, place), (4, 0), textcoords="offset points", va="center", fontsize=8, bbox=ground)
    law = row["law"].removeprefix("pohrt-popov, ").replace("elastic", "elastic unloading")
    labels.append(f"{row['engine']}: {law}, {'default shear' if row['shear'] == '3 levels' else 'partial slip'}")
ax.axvline(1.0, color="k", lw=0.8, ls=":")
ax.set_yticks(range(len(labels)), labels, fontsize=8)
ax.set(xlabel="time over that with the engine's own Hertz law", xlim=(0, 3.5))
fig.savefig("cost.png", dpi=130)
