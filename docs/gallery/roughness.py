"""Tangent stiffness of a granite contact against force, for several roughnesses: above the threshold F all follow Hertz."""

import matplotlib.pyplot as plt
import numpy as np

import demlaws as dl

force = np.geomspace(0.1, 1000, 300)
fig, ax = plt.subplots(figsize=(6.0, 4.0), layout="constrained")
smooth = dl.Contact(radius=4.35e-3, modulus=32.3e9)
hertz = dl.law("hertz", smooth)
ax.loglog(force, hertz.stiffness(hertz.overlap(force)) / 1e3, "k--")
ax.annotate("hertz", (0.2, hertz.stiffness(hertz.overlap(0.2)) / 1e3), (-4, 12), textcoords="offset points")
for sigma, shade in zip((0.3e-6, 1e-6, 2.4e-6, 5e-6), plt.colormaps["plasma"]([0.1, 0.35, 0.6, 0.8]), strict=True):
    law = dl.law("pohrt-popov", smooth.with_values(sigma=sigma, fractal_dimension=2.22))
    stiffness = law.stiffness(law.overlap(force)) / 1e3
    ax.loglog(force, stiffness, color=shade)
    ax.annotate(
        f"σ = {sigma * 1e6:g} µm", (force[0], stiffness[0]), (-4, 0), textcoords="offset points", color=shade, ha="right"
    )
ax.set(xlim=(0.008, 1000), xlabel="force (N)", ylabel="tangent stiffness (N/mm)")
ax.grid(alpha=0.3)
fig.savefig("roughness.png", dpi=130)
