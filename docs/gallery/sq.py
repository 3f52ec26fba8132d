"""Sq of one synthetic granite sphere: over the field of view with three ways to remove the form, and by wavelength."""

import matplotlib.pyplot as plt
import numpy as np

import demlaws as dl
from demlaws.surfaces.heightmap import self_affine

RADIUS, LOAD = 8.7e-3, 100.0  # m, N
granite = dl.materials.granite
rough = self_affine(2000, "0.5um", hurst=3 - granite.surface.fractal_dimension, roughness="1.7um", seed=44)
side = np.arange(2000) * 0.5e-6 - 0.5e-3
sphere = rough.with_heights(rough.heights - (side[:, None] ** 2 + side**2) / (2 * RADIUS))
contact = dl.Contact.between(granite, granite, radius1=RADIUS, radius2=RADIUS, roughness1=0, roughness2=0)
width = 2 * float(np.sqrt(contact.radius * dl.law("hertz", contact).overlap(LOAD)))  # of Hertz's contact

fields = np.geomspace(0.02e-3, 0.99e-3, 24)
fig, (left, right) = plt.subplots(1, 2, figsize=(10.4, 4.0), layout="constrained", sharey=True)
for order, name, colour in (
    (0, "mean only", "tab:red"),
    (2, "sphere removed", "tab:blue"),
    (6, "order 6 removed", "tab:green"),
):
    sq = [sphere.cropped(field).without_form(order).sq * 1e6 for field in fields]
    left.loglog(fields * 1e3, sq, "o-", ms=3, color=colour, label=name)
    print(f"{name}: Sq = {sphere.cropped(width).without_form(order).sq * 1e6:.2f} µm on the contact, {sq[-1]:.2f} µm on all")
left.axvline(width * 1e3, color="0.4", ls="--")
left.annotate(
    f"contact at {LOAD:g} N\n({width * 1e3:.2f} mm)", (width * 1e3, 0.03), (-5, 0), textcoords="offset points", ha="right"
)
left.set(xlabel="side of the measured square (mm)", ylabel="Sq (µm)", title="area and form", ylim=(0.02, 10))
left.legend()

level = sphere.cropped(width).without_form(2)
q, density, count = level.spectrum(200)
order = np.argsort(-q)
cell = count[order] * (2 * np.pi / width) ** 2  # area in the plane of wavevectors
below = np.sqrt(np.cumsum(density[order] * cell)) * level.sq / np.sqrt(np.sum(density[order] * cell))
right.semilogx(2 * np.pi / q[order] * 1e3, below * 1e6, color="tab:blue")
for cut in (0.025e-3, 0.08e-3):
    part = np.interp(cut, 2 * np.pi / q[order], below)
    right.plot(cut * 1e3, part * 1e6, "ko")
    right.annotate(
        f"cut-off {cut * 1e3:g} mm: {part * 1e6:.2f} µm",
        (cut * 1e3, part * 1e6),
        (-6, 6),
        textcoords="offset points",
        ha="right",
    )
    print(f"cut-off {cut * 1e3:g} mm: Sq = {part * 1e6:.2f} µm, {part / level.sq:.2f} of that on the contact")
right.set(xlabel="longest wavelength kept (mm)", title="cut-off, on the contact")
for ax in (left, right):
    ax.grid(alpha=0.3)
fig.savefig("sq.png", dpi=130)
