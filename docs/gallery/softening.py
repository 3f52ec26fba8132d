"""Error of a packing whose modulus is divided by a factor: roughness scaled with it (`dl.soften`) or left alone."""

import csv
from pathlib import Path

import matplotlib.pyplot as plt

FACTORS = (3, 10, 100, 1000)
with open(Path(__file__).parents[1] / "tables" / "trade-softening.csv", encoding="utf-8") as file:
    ROWS = {(row["table"], row["case"]): row for row in csv.DictReader(file)}


def errors(alone, engine):
    """Error (%) of the first stiffness at E/1, E/3 ... in an engine."""
    cases = [f"E/{factor}{', σ alone' if alone else ''}, I = 0.0003" for factor in FACTORS]
    return [0.0, *(float(ROWS[f"cycles in {engine.lower()}", case]["low"].strip("%")) for case in cases)]


fig, ax = plt.subplots(figsize=(6.4, 4.0), layout="constrained")
for alone, colour, text in ((True, "tab:red", "E alone"), (False, "tab:blue", "E and σ (dl.soften)")):
    ax.semilogx((1, *FACTORS), errors(alone, "YADE"), "o-", color=colour)
    ax.semilogx((1, *FACTORS), errors(alone, "LIGGGHTS"), "s--", color=colour)
    ax.annotate(text, (10, errors(alone, "YADE")[2]), (8, -22), textcoords="offset points", color=colour)
ax.plot([], [], "ko-", label="YADE")
ax.plot([], [], "ks--", label="LIGGGHTS")
ax.axhline(0, color="0.5", lw=0.8)
ax.set(xlabel="modulus divided by", ylabel="error of the packing's stiffness, 37 to 75 kPa (%)")
ax.legend(frameon=False)
ax.grid(alpha=0.3)
fig.savefig("softening.png", dpi=130)
