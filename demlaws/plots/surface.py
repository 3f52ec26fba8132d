"""Figures of surfaces and of the regime criterion. Every function returns a matplotlib figure."""

import numpy as np

from demlaws.plots import figure
from demlaws.solvers import criterion
from demlaws.surface import box_correction

MICRO = 1e6


def regime_figure(contact, force=None):
    """p(0)/H_m of `contact` over force and roughness."""
    fig, ax = figure(width=6.4, height=4.6)
    forces = np.geomspace(1e-3, 1e3, 181) * (force or criterion.transition_force(contact.with_values(sigma=1e-6)))
    roughness = np.geomspace(1e-8, 1e-4, 161)
    if contact.sigma:
        roughness = contact.sigma * np.geomspace(1e-2, 1e2, 161)
    regime_bar(fig, regime_axis(ax, contact, forces, roughness), ax)
    if force is not None and contact.sigma:
        ax.plot(force, contact.sigma * MICRO, "k*", ms=14, mec="white")
        ratio = criterion.pressure_ratio(contact, force)
        label, light = (
            f"{ratio:.3g}: {criterion.deforming_part(ratio)}",
            {"fc": "white", "ec": "none", "alpha": 0.8, "pad": 1.5},
        )
        place = {"xytext": (10, 0), "textcoords": "offset points", "va": "center"}
        ax.annotate(label, (force, contact.sigma * MICRO), bbox=light, **place)
    ax.set_title(f"R = {contact.radius * 1e3:.3g} mm, E* = {contact.modulus / 1e9:.3g} GPa")
    return fig


def regime_axis(ax, contact, forces, roughness):
    """The map of p(0)/H_m on axes, with its contours; returns the image."""
    ratio = np.array([criterion.pressure_ratio(contact.with_values(sigma=sigma), forces) for sigma in roughness])
    ax.grid(False)
    ax.set(xscale="log", yscale="log", xlabel="force (N)", ylabel="roughness σ (µm)")  # labels break contours at this scale
    image = ax.pcolormesh(
        forces, roughness * MICRO, np.log10(ratio / criterion.YIELD_RATIO), cmap="RdBu_r", vmin=-1, vmax=1, shading="gouraud"
    )
    lines = ax.contour(forces, roughness * MICRO, ratio, [0.1, 0.2, 0.4, 1.0, 2.0], colors="grey", linewidths=0.6)
    ax.clabel(lines, fmt="%g", fontsize=7)
    ax.contour(forces, roughness * MICRO, ratio, [criterion.YIELD_RATIO], colors="black", linewidths=1.8)
    edges = [criterion.YIELD_RATIO - criterion.BAND, criterion.YIELD_RATIO + criterion.BAND]
    ax.contour(forces, roughness * MICRO, ratio, edges, colors="black", linewidths=0.6, linestyles="--")
    return image


def regime_bar(fig, image, axes):
    """Colours are log10 of p(0)/(0.6 H_m); the bar shows p(0)/H_m itself."""
    ratios = np.array([0.06, 0.1, 0.2, 0.4, 0.6, 1.0, 2.0, 4.0, 6.0])
    bar = fig.colorbar(
        image, ax=axes, label="p(0)/H$_m$ (map: closed fit)", shrink=0.9, ticks=np.log10(ratios / criterion.YIELD_RATIO)
    )
    bar.ax.set_yticklabels([f"{r:g}" for r in ratios])


def show(fig, ax, heights, z, label, cmap="viridis", **more):
    """Show an array of the map's shape as a picture with its colour bar."""
    ax.grid(False)
    width, height = heights.field_of_view
    image = ax.imshow(z, extent=(0, width * MICRO, 0, height * MICRO), origin="lower", cmap=cmap, **more)
    fig.colorbar(image, ax=ax, label=label, shrink=0.8)
    ax.set(xlabel="x (µm)", ylabel="y (µm)")


def surface_figure(heights, wavelengths=None):
    """A height map, its middle profiles, its power spectrum and its box counts, with the fits of the fractal dimension."""
    fig, axes = figure(columns=2, rows=2, width=5.2, height=3.9)
    show(fig, axes[0, 0], heights, heights.heights * MICRO, "height (µm)")
    axes[0, 0].set_title(f"Sq = {heights.sq * MICRO:.3g} µm, Sa = {heights.sa * MICRO:.3g} µm", fontsize=10)
    rows, columns = heights.shape
    ax = axes[0, 1]
    ax.plot(np.arange(columns) * heights.pixel_x * MICRO, heights.heights[rows // 2] * MICRO, lw=0.9, label="along x")
    ax.plot(np.arange(rows) * heights.pixel_y * MICRO, heights.heights[:, columns // 2] * MICRO, lw=0.9, label="along y")
    ax.set(xlabel="distance (µm)", ylabel="height (µm)", title="profiles through the middle")
    ax.title.set_fontsize(10)
    ax.legend(fontsize=9)
    ax = axes[1, 0]
    q, density, _ = heights.spectrum()
    ax.loglog(q, density, ".-", ms=4, lw=0.7)
    dimension = heights.fractal_dimension_by_spectrum(wavelengths)
    shortest, longest = wavelengths or (3 * max(heights.pixel_x, heights.pixel_y), min(heights.field_of_view) / 6)
    inside = (q >= 2 * np.pi / longest) & (q <= 2 * np.pi / shortest)
    slope = 2 * (dimension - 4)
    level = np.exp(np.mean(np.log(density[inside]) - slope * np.log(q[inside])))
    ax.loglog(q[inside], level * q[inside] ** slope, "k--", lw=1.2)
    ax.set(xlabel="wavevector q (rad/m)", ylabel="C(q) (m⁴)")
    ax.set_title(f"spectrum: Df = {dimension:.3f}", fontsize=10)
    ax = axes[1, 1]
    sizes, ranges = heights.box_counts()
    pixel = np.sqrt(heights.pixel_x * heights.pixel_y)
    number = ranges / ranges[-1] * (sizes / sizes[-1]) ** -3.0
    boxes = heights.fractal_dimension_by_boxes(wavelengths)
    correction = np.exp(box_correction(3.0 - boxes, sizes) - box_correction(3.0 - boxes, sizes[-1:]))
    ax.loglog(sizes * pixel * MICRO, number, "o", mfc="none", ms=5, label="counted")
    ax.loglog(sizes * pixel * MICRO, number / correction, "o", ms=5, label="corrected for pixel size")
    fit = (sizes / sizes[-1]) ** -boxes
    ax.loglog(sizes * pixel * MICRO, fit, "k--", lw=1.2, label=f"N ∝ size$^{{-{boxes:.2f}}}$")
    ax.set(xlabel="box side (µm)", ylabel="boxes N / N(largest side)")
    ax.set_title(f"box counting: Df = {boxes:.3f}", fontsize=10)
    ax.legend(fontsize=9)
    return fig
