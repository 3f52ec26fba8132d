"""Force and overlap of a rough granite contact: Hertz, the recommended law with its unloading, the other laws in grey."""

import warnings

import matplotlib.pyplot as plt
import numpy as np

import demlaws as dl

granite = dl.materials.granite
pair = dl.Contact.between(granite, granite, radius1=8.7e-3, radius2=8.7e-3)

fig, ax = plt.subplots(figsize=(6.4, 4.2), layout="constrained")
force = np.geomspace(0.02, 50.0, 200)
rough = dl.law("pohrt-popov", pair, unloading="hertz")
for name in ("bahrami", "rms", "greenwood-tripp", "hertz", "pohrt-popov"):
    colour = {"hertz": "tab:blue", "pohrt-popov": "tab:red"}.get(name, "0.65")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", dl.ValidityWarning)  # rms at low load
        overlap = dl.law(name, pair).overlap(force) * 1e6
    ax.plot(overlap, force, color=colour, lw=1.2 if colour == "0.65" else 2.2)
    place = (np.interp(40.0, force, overlap) - 0.1, 40.0) if name == "rms" else (overlap[-1], 51.0)
    horizontal = "right" if name in ("rms", "hertz") else "center"
    ax.text(
        *place, name.replace("d-", "d-\n"), color=colour if colour != "0.65" else "0.4", ha=horizontal, va="bottom", fontsize=9
    )

path = dl.driver.force_controlled(rough, [50, 0])
peak = int(np.argmax(path.force))
path[peak:].plot(ax, color="tab:red", ls="--", lw=2.2)
remains = path.plastic_overlap[-1] * 1e6
ax.annotate(
    f"unloading: {remains:.1f} µm\nof overlap remain", (remains + 0.1, 0.4), (7.2, 3.0), color="tab:red", fontsize=9,
    arrowprops={"arrowstyle": "->", "color": "tab:red"},
)  # fmt: skip
ax.set(xlabel="overlap (µm)", ylabel="force (N)", xlim=(0, 14.2), ylim=(0, 57))
ax.grid(alpha=0.3)
ax.spines[["top", "right"]].set_visible(False)
fig.savefig("granite.png", dpi=130)
print(f"plastic overlap after 50 N: {remains:.2f} µm")
