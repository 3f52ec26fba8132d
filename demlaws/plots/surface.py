"""Figures of surfaces, of the regime criterion and of repeated contact. Every function returns a matplotlib figure."""

import numpy as np

from demlaws import regime
from demlaws.plots import figure
from demlaws.surface import box_correction

STATE_COLOURS = ("#4c78a8", "#f2a541", "#d62728")
MICRO = 1e6


def plain(ax):
    """Axes without a grid, for pictures of maps."""
    ax.grid(False)
    return ax


def regime_figure(contact, load=None, title=None):
    """p(0)/H_m of `contact` over load and roughness."""
    fig, ax = figure(width=6.4, height=4.6)
    loads = np.geomspace(1e-3, 1e3, 181) * (load or regime.transition_load(contact.with_values(roughness=1e-6)))
    roughness = np.geomspace(1e-8, 1e-4, 161)
    if contact.roughness:
        roughness = contact.roughness * np.geomspace(1e-2, 1e2, 161)
    regime_bar(fig, regime_axis(ax, contact, loads, roughness), ax)
    if load is not None and contact.roughness:
        ax.plot(load, contact.roughness * MICRO, "k*", ms=13)
        ratio = regime.pressure_ratio(contact, load)
        ax.annotate(f"  {ratio:.3g}: {regime.deforming_part(ratio)}", (load, contact.roughness * MICRO), va="center")
    ax.set_title(title or f"R = {contact.radius * 1e3:.3g} mm, E* = {contact.modulus / 1e9:.3g} GPa")
    return fig


def regime_axis(ax, contact, loads, roughness):
    """The map of p(0)/H_m on axes, with its contours; returns the image."""
    ratio = regime.pressure_map(contact, loads, roughness)
    plain(ax)
    image = ax.pcolormesh(
        loads, roughness * MICRO, np.log10(ratio / regime.YIELD_RATIO), cmap="RdBu_r", vmin=-1, vmax=1, shading="gouraud"
    )
    lines = ax.contour(loads, roughness * MICRO, ratio, [0.1, 0.2, 0.4, 1.0, 2.0], colors="grey", linewidths=0.6)
    ax.clabel(lines, fmt="%g", fontsize=7)
    ax.contour(loads, roughness * MICRO, ratio, [regime.YIELD_RATIO], colors="black", linewidths=1.8)
    edges = [regime.YIELD_RATIO - regime.BAND, regime.YIELD_RATIO + regime.BAND]
    ax.contour(loads, roughness * MICRO, ratio, edges, colors="black", linewidths=0.6, linestyles="--")
    ax.set(xscale="log", yscale="log", xlabel="load (N)", ylabel="roughness σ (µm)")
    return image


def regime_bar(fig, image, axes):
    """Colours are log10 of p(0)/(0.6 H_m); the bar shows p(0)/H_m itself."""
    ratios = np.array([0.06, 0.1, 0.2, 0.4, 0.6, 1.0, 2.0, 4.0, 6.0])
    bar = fig.colorbar(
        image, ax=axes, label="p(0)/H$_m$ (map: closed fit)", shrink=0.9, ticks=np.log10(ratios / regime.YIELD_RATIO)
    )
    bar.ax.set_yticklabels([f"{r:g}" for r in ratios])


def extent(heights):
    """Extent of a map's picture [µm]: left, right, bottom, top."""
    width, height = heights.field_of_view
    return (0, width * MICRO, 0, height * MICRO)


def show(fig, ax, heights, z, label, cmap="viridis", **more):
    """Show an array of the map's shape as a picture with its colour bar."""
    plain(ax)
    image = ax.imshow(z, extent=extent(heights), origin="lower", cmap=cmap, **more)
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
    ax.legend(fontsize=8)
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
    missed = np.exp(box_correction(3.0 - boxes, sizes) - box_correction(3.0 - boxes, sizes[-1:]))
    ax.loglog(sizes * pixel * MICRO, number, "o", mfc="none", ms=5, label="counted")
    ax.loglog(sizes * pixel * MICRO, number / missed, "o", ms=5, label="with what pixels miss")
    fit = (sizes / sizes[-1]) ** -boxes
    ax.loglog(sizes * pixel * MICRO, fit, "k--", lw=1.2, label=f"N ∝ size$^{{-{boxes:.2f}}}$")
    ax.set(xlabel="box side (µm)", ylabel="boxes N / N(largest side)")
    ax.set_title(f"box counting: Df = {boxes:.3f}", fontsize=10)
    ax.legend(fontsize=8)
    return fig


def contact_figure(contact, step, worn=None):
    """The map under load: what touches, coloured by state, beside the sizes and loads of the micro-contacts."""
    fig, (left, right) = figure(columns=2, width=5.4, height=4.4)
    heights = contact.heights
    show(fig, left, heights, heights.heights * MICRO, "height (µm)", cmap="Greys_r", alpha=0.6)
    ellipses(left, step)
    if not contact.flat:
        radius = (step.load * 0.75 * contact.pair.radius / contact.pair.modulus) ** (1 / 3)
        circle(left, contact.centre, radius, "--", "Hertz radius")
    left.set_title(f"{step.load:.3g} N: {len(step.micro)} micro-contacts, {step.contact_area * 1e12:.4g} µm²", fontsize=10)
    micro = step.micro
    for state, (name, colour) in enumerate(zip(("elastic", "elastic-plastic", "plastic"), STATE_COLOURS, strict=True)):
        chosen = micro.state == state
        right.loglog(micro.area[chosen] * 1e12, micro.force[chosen], "o", color=colour, ms=5, label=f"{name}: {chosen.sum()}")
    right.set(xlabel="contact area (µm²)", ylabel="force (N)", title="micro-contacts")
    right.title.set_fontsize(10)
    right.legend(fontsize=8)
    return fig


def ellipses(ax, step):
    """Outline the contact patches of a step as ellipses of their contact area."""
    from matplotlib.collections import EllipseCollection

    micro = step.micro
    # the contact area has the shape of the patch
    share = np.sqrt(micro.area / micro.cut_area)
    ax.add_collection(
        EllipseCollection(
            micro.length_long * share * MICRO,
            micro.length_short * share * MICRO,
            np.degrees(micro.angle),
            units="xy",
            offsets=np.column_stack([micro.x, micro.y]) * MICRO,
            transOffset=ax.transData,
            facecolors=[STATE_COLOURS[s] for s in micro.state],
        )
    )


def circle(ax, centre, radius, style, label):
    """Outline a circle, centre and radius in m."""
    angle = np.linspace(0, 2 * np.pi, 200)
    ax.plot(
        (centre[0] + radius * np.cos(angle)) * MICRO,
        (centre[1] + radius * np.sin(angle)) * MICRO,
        "k" + style,
        lw=1,
        label=label,
    )
    ax.legend(fontsize=8, loc="upper right")


def repeated_figure(contact, history, name="", others=None):
    """Repeated contact: map before and after the first cycle, contact area, profiles and change over cycles.

    others: memory → history of the same contact with another assumption of what a pixel remembers.
    """
    fig, axes = figure(columns=3, rows=2, width=5.0, height=4.1)
    heights, first = contact.heights, history[0]
    after = first.contact.heights.heights
    span = {"vmin": np.nanmin(heights.heights) * MICRO, "vmax": np.nanmax(heights.heights) * MICRO}
    show(fig, axes[0, 0], heights, heights.heights * MICRO, "height (µm)", **span)
    axes[0, 0].set_title(f"{name} before: Sq = {heights.sq * MICRO:.2f} µm", fontsize=10)
    show(fig, axes[0, 1], heights, after * MICRO, "height (µm)", **span)
    axes[0, 1].set_title(f"after cycle 1 at {first.step.load:.3g} N", fontsize=10)
    change = (after - heights.heights) * MICRO
    limit = max(abs(np.nanmin(change)), 1e-9)
    show(fig, axes[0, 2], heights, change, "change (µm)", cmap="RdBu", vmin=-limit, vmax=limit)
    touched = np.argwhere(change != 0)
    if touched.size:
        (row0, column0), (row1, column1) = touched.min(axis=0), touched.max(axis=0)
        px, py = heights.pixel_x * MICRO, heights.pixel_y * MICRO
        axes[0, 2].set(xlim=((column0 - 8) * px, (column1 + 8) * px), ylim=((row0 - 8) * py, (row1 + 8) * py))
    axes[0, 2].set_title("plastic change (contact region)", fontsize=10)
    ax = axes[1, 0]
    show(fig, ax, heights, heights.heights * MICRO, "height (µm)", cmap="Greys_r", alpha=0.6)
    ellipses(ax, first.step)
    radius = (first.step.load * 0.75 * contact.pair.radius / contact.pair.modulus) ** (1 / 3)
    if not contact.flat:
        circle(ax, contact.centre, radius, "--", "Hertz radius")
    counts = first.step.counts
    ax.set_title(f"contact, cycle 1: {counts[0]} elastic, {counts[1]} el.-plastic, {counts[2]} plastic", fontsize=10)
    # profiles through the pixel that lost most
    ax = axes[1, 1]
    row, column = np.unravel_index(np.nanargmin(change), change.shape)
    x = np.arange(heights.shape[1]) * heights.pixel_x * MICRO
    ax.plot(x, heights.heights[row] * MICRO, "k-", lw=1.6, label="before")
    for cycle in history:
        if cycle.contact is not None:
            ax.plot(
                x,
                cycle.contact.heights.heights[row] * MICRO,
                lw=1.0,
                ls=(0, (2 + cycle.number % 5, 1.5)),
                label=f"n = {cycle.number}",
            )
    centre = column * heights.pixel_x * MICRO
    ax.set(xlim=(centre - 25, centre + 25), xlabel="x (µm)", ylabel="height (µm)")
    near = np.abs(x - centre) < 25
    ax.set_ylim(np.nanmin(heights.heights[row][near]) * MICRO, np.nanmax(heights.heights[row][near]) * MICRO + 0.1)
    ax.set_title(f"profile at y = {row * heights.pixel_y * MICRO:.0f} µm", fontsize=10)
    ax.legend(fontsize=7, ncol=2)
    ax = axes[1, 2]
    number = [c.number for c in history]
    ax.semilogy(
        number,
        [max(c.relative_change, 1e-6) for c in history],
        "o-",
        label=f"change of the map / first, memory: {contact.memory}",
    )
    for memory, few in (others or {}).items():
        ax.semilogy([c.number for c in few], [max(c.relative_change, 1e-6) for c in few], "x:", label=f"memory: {memory}")
    ax.axhline(0.01, color="black", lw=0.8, ls="--", label="run-in, ε$_r$ = 0.01")
    ax.semilogy(
        number, [c.step.contact_area / first.step.contact_area for c in history], "s-", ms=4, label="contact area / first"
    )
    ax.set(xlabel="cycle", ylim=(5e-7, 3))
    ax.set_title("run-in (0 is drawn at 1e-6)", fontsize=10)
    ax.legend(fontsize=8)
    return fig


def nine_point_figure(heights):
    """Nine-point summits on the map, and how their radii and heights are distributed."""
    from demlaws.solvers.patches import nine_point_summits

    x, y, z, radius = nine_point_summits(heights)
    fig, (left, right) = figure(columns=2, width=5.4, height=4.2)
    show(fig, left, heights, heights.heights * MICRO, "height (µm)")
    left.plot(x * MICRO, y * MICRO, "r.", ms=2)
    left.set_title(f"{x.size} nine-point summits", fontsize=10)
    right.semilogx(np.abs(radius) * MICRO, z * MICRO, ".", ms=3)
    right.set(xlabel="radius of curvature (µm)", ylabel="height of the summit (µm)")
    return fig


def change_figure(before, match):
    """A map, what has changed after it was laid over a second one, and profiles of that through its middle of change."""
    fig, (left, middle, right) = figure(columns=3, width=5.0, height=4.2)
    show(fig, left, before, before.heights * MICRO, "height (µm)")
    left.set_title("before", fontsize=10)
    change = match.difference.heights * MICRO
    limit = max(float(np.nanmax(np.abs(change))), 1e-9)
    show(fig, middle, before, change, "after - before (µm)", cmap="RdBu", vmin=-limit, vmax=limit)
    middle.set_title(f"difference, noise {match.noise * 1e9:.3g} nm", fontsize=10)
    weight = np.where(match.changed(), np.abs(np.nan_to_num(change)), 0.0) + 1e-300
    row = int(np.argmax(weight.sum(axis=1)))
    column = int(np.argmax(weight.sum(axis=0)))
    for values, pixel, place in (
        (change[row], before.pixel_x, f"along x at y = {row * before.pixel_y * MICRO:.0f} µm"),
        (change[:, column], before.pixel_y, f"along y at x = {column * before.pixel_x * MICRO:.0f} µm"),
    ):
        right.plot(np.arange(values.size) * pixel * MICRO, values, lw=1.0, label=place)
    right.set(xlabel="distance (µm)", ylabel="after - before (µm)")
    right.legend(fontsize=8)
    return fig


def law_figure(contact, laws):
    """Force against overlap of loading and reloading laws of a map, beside Hertz and the model's own points.

    laws: name → demlaws.Law.
    """
    fig, (left, right) = figure(columns=2, width=5.2, height=4.1)
    pair = contact.pair
    first = next(iter(laws.values()))
    limits = [limit.maximum_force * (1 - 1e-9) for limit in first.limits()]
    end = min([4.0 * contact.heights.sq, *(first.overlap(force) for force in limits)])
    force = np.geomspace(1e-4, 1.0, 200) * contact.at(end).load
    left.loglog(
        (9 * force**2 / (16 * pair.radius * pair.modulus**2)) ** (1 / 3) * MICRO, force, "--", color="#222222", label="Hertz"
    )
    stiffness = (6 * force * pair.radius * pair.modulus**2) ** (1 / 3)
    right.loglog(force, stiffness / 1e3, "--", color="#222222", label="Hertz")
    for (name, law), colour in zip(laws.items(), ("#e377c2", "#7f3fbf", "#2ca02c"), strict=False):
        overlap = np.array([law.overlap(float(f)) for f in force])
        left.loglog(overlap * MICRO, force, color=colour, label=name)
        right.loglog(force, np.array([law._both(d)[1] for d in overlap]) / 1e3, color=colour, label=name)
    overlaps = end * np.geomspace(1e-3, 1, 40)
    left.loglog(overlaps * MICRO, [contact.at(d).load for d in overlaps], "k.", ms=4, label="model, one cut each")
    left.set(xlabel="overlap (µm)", ylabel="force (N)")
    right.set(xlabel="force (N)", ylabel="tangent stiffness (N/mm)")
    left.legend(fontsize=8)
    right.legend(fontsize=8)
    return fig
