"""Plastic laws on one contact with the modulus of granite: loaded to 200 N (conical-damage: to 30 µm) and unloaded."""

import warnings

import matplotlib.pyplot as plt

import demlaws as dl

warnings.simplefilter("ignore", dl.ValidityWarning)
pair = dl.Contact(radius=4e-3, modulus=32.3e9)
LAWS = {
    "thornton-ning": {"yield_pressure": 0.8e9},
    "jackson-green": {"yield_strength": 0.4e9},
    "kogut-etsion": {"yield_strength": 0.4e9},
    "conical-damage": {"strength": 1.2e9, "angle": 0.6},
    "eepa": {"stiffness_ratio": 3.0},
    "walton-braun": {"loading_stiffness": 2e7, "stiffness_ratio": 2.0},
    "luding": {"loading_stiffness": 1.5e7, "stiffness_ratio": 3.0, "plasticity_depth": 0.003},
}
fig, axes = plt.subplots(1, 2, figsize=(9.0, 3.8), layout="constrained", sharey=True)
for number, (name, options) in enumerate(LAWS.items()):
    law = dl.law(name, pair, **options)
    path = {"overlap": 30e-6} if name == "conical-damage" else {"unload_at": 200.0}
    law.plot(axes[int(number > 2)], **path, color=f"C{number}", label=name)
for ax, title in zip(axes, ("one contact, yield computed", "calibrated on the bulk"), strict=True):
    dl.law("hertz", pair).plot(ax, unload_at=200.0, color="0.3", ls=":", label="hertz")
    ax.set(title=title, xlim=(0, None), ylim=(0, 210))
    ax.legend(frameon=False, fontsize=8)
    ax.grid(alpha=0.3)
axes[1].set(xlim=(0, 30), ylabel="")
fig.savefig("plastic.png", dpi=130)
