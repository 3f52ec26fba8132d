"""Error of a packing whose modulus is divided by a factor: roughness scaled with it (`dl.soften`) or left alone."""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

data = np.genfromtxt(Path(__file__).parent / "softening.csv", delimiter=",", skip_header=1, names=True)
fig, ax = plt.subplots(figsize=(6.4, 4.0), layout="constrained")
for kind, colour, text in (("alone", "tab:red", "E alone"), ("scaled", "tab:blue", "E and σ (dl.soften)")):
    ax.semilogx(data["factor"], data[f"{kind}_yade"], "o-", color=colour)
    ax.semilogx(data["factor"], data[f"{kind}_liggghts"], "s--", color=colour)
    ax.annotate(text, (10, data[f"{kind}_yade"][2]), (8, -14), textcoords="offset points", color=colour)
ax.plot([], [], "ko-", label="YADE")
ax.plot([], [], "ks--", label="LIGGGHTS")
ax.axhline(0, color="0.5", lw=0.8)
ax.set(xlabel="modulus divided by", ylabel="error of the packing's stiffness, 37 to 75 kPa (%)")
ax.legend(frameon=False)
ax.grid(alpha=0.3)
fig.savefig("softening.png", dpi=130)
