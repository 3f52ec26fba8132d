"""Plate stress against strain of 400 granite spheres in LIGGGHTS, from docs/tables/case-compression.csv."""

import csv
from collections import defaultdict
from pathlib import Path

import matplotlib.pyplot as plt

curves = defaultdict(list)
with open(Path(__file__).parents[1] / "tables" / "case-compression.csv", encoding="utf-8") as file:
    for row in csv.DictReader(file):
        curves[row["law"]].append((100 * float(row["strain"]), 1e-6 * float(row["stress (Pa)"])))

fig, ax = plt.subplots(figsize=(6.0, 4.0), layout="constrained")
for law, points in curves.items():
    ax.plot(*zip(*points, strict=True), label=law)
ax.set(xlabel="axial strain (%)", ylabel="plate stress (MPa)")
ax.grid(alpha=0.3)
ax.legend(frameon=False)
fig.savefig("oedometer.png", dpi=130)
