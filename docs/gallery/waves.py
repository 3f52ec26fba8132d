"""Pulses in a column of spheres in LAMMPS, with the speeds of the moduli as lines, from docs/tables/case-waves.csv."""

import csv
from pathlib import Path

import matplotlib.pyplot as plt

with open(Path(__file__).parents[1] / "tables" / "case-waves.csv", encoding="utf-8") as file:
    (_, _, _, *layers), *rows = csv.reader(file)

position = [1e3 * float(name.removesuffix(" m")) for name in layers]
fig, axes = plt.subplots(1, 2, figsize=(9.2, 4.0), layout="constrained")
for ax, wave in zip(axes, dict.fromkeys(row[0] for row in rows), strict=True):
    chosen = [row for row in rows if row[0] == wave]
    times = [1e6 * float(row[2]) for row in chosen]
    velocities = [[float(cell) for cell in row[3:]] for row in chosen]
    largest = max(abs(value) for row in velocities for value in row)
    shares = [[value / largest for value in row] for row in velocities]
    image = ax.pcolormesh(position, times, shares, cmap="RdBu_r", vmin=-0.5, vmax=0.5, rasterized=True)
    for sign in (-1, 1):
        ax.plot([sign * 1e-3 * float(chosen[0][1]) * time for time in times], times, "k--", lw=1)
    ax.set(xlabel="position (mm)", ylabel="time (µs)", title=wave, xlim=(position[0], position[-1]))
fig.colorbar(image, ax=axes, label="velocity / largest velocity", extend="both")
fig.savefig("waves.png", dpi=110)
