"""Small-strain bulk stiffness of 500 clumps in YADE against pressure, from docs/tables/yade-ballast.csv."""

import csv
from pathlib import Path

import matplotlib.pyplot as plt

with open(Path(__file__).parents[1] / "tables" / "yade-ballast.csv", encoding="utf-8") as file:
    ROWS = list(csv.DictReader(file))

fig, ax = plt.subplots(figsize=(6.4, 4.2), layout="constrained")
cells = {name: float(name.removesuffix(" kPa")) for name in ROWS[0] if name.endswith("kPa")}
for row in ROWS:
    loading, unloading = zip(*(map(float, row[name].split("/")) for name in cells), strict=True)
    (line,) = ax.loglog(cells.values(), loading, "o-", label=f"{row['law, unloading']}: n = {row['n'].replace(' / ', ', ')}")
    ax.loglog(cells.values(), unloading, "s--", ms=4, color=line.get_color())
ax.set(
    xlabel="pressure (kPa)",
    ylabel="bulk stiffness (MPa)",
    title="probe that loads (—) and unloads (- -); stiffness ∝ pressure^n",
)
ax.set_xticks([20, 50, 100, 200], ["20", "50", "100", "200"])
ax.set_yticks([50, 100, 150], ["50", "100", "150"])
ax.minorticks_off()
ax.legend(frameon=False, fontsize=9)
ax.grid(alpha=0.3)
fig.savefig("ballast.png", dpi=130)
