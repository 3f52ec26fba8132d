"""The unloading rules on one contact whose bulk yields at 1.66 GPa: loaded to 50 N and unloaded."""

import matplotlib.pyplot as plt

import demlaws as dl

pair = dl.Contact(radius=0.96e-3, modulus=32.3e9, sigma=5.1e-6, fractal_dimension=2.22)
fig, ax = plt.subplots(figsize=(6.0, 4.0), layout="constrained")
for rule, colour in (("hertz", "tab:red"), ("thornton", "tab:blue"), ("elastic", "0.3")):
    law = dl.law("rough-plastic", pair, unloading=rule, yield_pressure=1.66e9)
    law.plot(ax, unload_at=50.0, color=colour, ls="--" if rule == "elastic" else "-", label=f'unloading="{rule}"')
ax.set(xlim=(0, None), ylim=(0, None))
ax.legend(frameon=False)
ax.grid(alpha=0.3)
fig.savefig("unloading.png", dpi=130)
