"""Recommended step of 10 mm granite grains against the largest force, for three laws."""

import warnings

import matplotlib.pyplot as plt
import numpy as np

import demlaws as dl

warnings.simplefilter("ignore", dl.ValidityWarning)
mass = 2680 * 4 / 3 * np.pi * 5e-3**3
granite = dl.materials.granite
pair = dl.Contact.between(granite, granite, radius1=5e-3, radius2=5e-3)
force = np.geomspace(0.01, 1000, 40)
fig, ax = plt.subplots(figsize=(6.0, 4.0), layout="constrained")
for name, rule, style in (("pohrt-popov", "elastic", "C0-"), ("pohrt-popov", "hertz", "C3-"), ("hertz", "elastic", "k--")):
    law = dl.law(name, pair.with_values(sigma=0) if name == "hertz" else pair, unloading=rule)
    steps = [dl.timestep(law, mass=mass, max_force=load) * 1e6 for load in force]
    ax.loglog(force, steps, style, label=name if name == "hertz" else f"{name}, {rule} unloading")
ax.set(xlabel="largest force of a contact (N)", ylabel="recommended step (µs)")
ax.set_yticks([2, 3, 5, 10, 20, 40], ["2", "3", "5", "10", "20", "40"])
ax.set_xticks([0.01, 0.1, 1, 10, 100, 1000], ["0.01", "0.1", "1", "10", "100", "1000"])
ax.yaxis.set_minor_formatter("")
ax.grid(alpha=0.3, which="both")
ax.legend()
fig.savefig("timestep.png", dpi=130)
