"""Load against displacement of a plate on a bed in LIGGGHTS, settlement against cycle, from docs/tables/case-ballast.csv."""

import csv
from pathlib import Path

import matplotlib.pyplot as plt

with open(Path(__file__).parents[1] / "tables" / "case-ballast.csv", encoding="utf-8") as file:
    ROWS = list(csv.DictReader(file))

place = [1e3 * float(row["displacement (m)"]) for row in ROWS]
ends = [(int(row["cycle"]), height) for row, height in zip(ROWS, place, strict=True) if row["cycle"]]
fig, (left, right) = plt.subplots(1, 2, figsize=(10.0, 4.0), layout="constrained")
left.plot(place, [1e-3 * float(row["load (N)"]) for row in ROWS], lw=0.6)
left.set(xlabel="displacement of the plate (mm)", ylabel="load (kN)")
right.plot(*zip(*ends, strict=True), "o-", ms=3)
right.set(xlabel="cycle", ylabel="permanent settlement (mm)")
for ax in (left, right):
    ax.grid(alpha=0.3)
fig.savefig("ballast_cycles.png", dpi=130)
