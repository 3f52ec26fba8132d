"""Figures of the package: the only modules that import matplotlib."""

import io
import os
import warnings

import numpy as np

from demlaws.errors import DemlawsError, quiet
from demlaws.files import as_path, write_atomically
from demlaws.laws import HERTZ
from demlaws.laws.definition import Drawing
from demlaws.laws.registry import registry

MISSING = "figures need matplotlib: pip install 'demlaws[plots]' (apt: python3-matplotlib)"


def colour(law):
    """Colour of a law; grey for other names."""
    return registry()[law].drawing.colour if law in registry() else Drawing().colour


def figure(*, columns=1, rows=1, width=5.2, height=4.0):
    """A figure and its axes (an array if there are several)."""
    try:
        with warnings.catch_warnings():  # two installed versions of matplotlib's 3-D axes, which no figure here uses
            warnings.filterwarnings("ignore", message="Unable to import Axes3D")
            from matplotlib.backends.backend_agg import FigureCanvasAgg
            from matplotlib.figure import Figure
    except ImportError as error:
        raise DemlawsError(MISSING) from error
    canvas = FigureCanvasAgg(Figure(figsize=(width * columns, height * rows), layout="constrained"))
    axes = canvas.figure.subplots(rows, columns)
    for ax in np.ravel(axes):
        ax.grid(alpha=0.3)
        ax.spines[["top", "right"]].set_visible(False)
    return canvas.figure, axes


def available():
    """Whether figures can be drawn here."""
    import importlib.util

    return importlib.util.find_spec("matplotlib") is not None


def save(fig, path):
    """Write a figure; its format is the file's ending, PNG if there is none."""
    path = as_path(path)
    if not path.name or os.path.isdir(path):
        raise DemlawsError(f"cannot draw {path}: that is a folder; name a file in it")
    kind = path.suffix.lstrip(".").lower() or "png"
    buffer = io.BytesIO()
    try:
        author = {"png": "Software", "pdf": "Creator", "svg": "Creator"}.get(kind)
        fig.savefig(buffer, format=kind, dpi=130, **({"metadata": {author: "demlaws"}} if author else {}))
    except ValueError as error:
        raise DemlawsError(f"cannot draw {path}: {error}") from error
    return write_atomically(path if path.suffix else path.with_suffix(".png"), buffer.getvalue())


def plot(result, ax=None, *, overlap=None, unload_at=None, **style):
    """Draw force against overlap of a path, or of a law that is loaded and unloaded; returns the axes.

    Parameters
    ----------
    result : Path or Law
        A path is drawn as it is.
    ax : matplotlib.axes.Axes, optional
        Axes; default: those of a new figure of `matplotlib.pyplot`.
    overlap : float, optional
        Largest overlap of a law [m]; default: a thousandth of the effective radius, or the end of its table.
    unload_at : float, optional
        Force at which a law is unloaded [N]; default: at the largest overlap.
    **style
        Keywords of `Axes.plot`.

    Returns
    -------
    matplotlib.axes.Axes

    Examples
    --------
    >>> law = dl.law("hertz", dl.Contact(radius=4e-3, modulus=32e9))
    >>> axes = dl.plots.plot(law, unload_at=10.0, label="Hertz")
    >>> axes.get_xlabel(), axes.get_ylabel()
    ('overlap (µm)', 'force (N)')
    """
    try:
        import matplotlib.pyplot as plt
        from matplotlib.axes import Axes
    except ImportError as error:
        raise DemlawsError(MISSING) from error
    if ax is None:
        ax = plt.subplots(layout="constrained")[1]
        ax.grid(alpha=0.3)
        ax.spines[["top", "right"]].set_visible(False)
    elif not isinstance(ax, Axes):
        raise DemlawsError(f"ax must be axes of matplotlib, for instance those of plt.subplots(), got {ax!r:.60}")
    path = result
    if hasattr(result, "follow"):
        if unload_at is not None:
            overlap = result.overlap(unload_at)
        elif overlap is None:
            overlap = min(1e-3 * float(np.min(result.contact.radius)), result.largest_overlap)
        style = {"color": colour(result.name), "label": f"{result.name}, {result.unloading} unloading", **style}
        rise = np.linspace(0.0, overlap, 201)
        path = result.follow(np.append(rise, rise[-2::-1]))
    try:
        ax.plot(path.overlap * 1e6, path.force, **style)
    except (AttributeError, TypeError, ValueError) as error:
        raise DemlawsError(f"matplotlib cannot draw a line with {style}: {error}") from error
    ax.set(xlabel="overlap (µm)", ylabel="force (N)")
    return ax


def draw_line(ax, x, y, *, name, **more):
    """A law's curve in its colour and line style; dashes of Hertz lie over solid lines that coincide with it."""
    order = 3.0 if name == HERTZ else 2.0
    style = registry()[name].drawing.line
    ax.plot(x, y, color=colour(name), linestyle=style, label=more.pop("label", name), zorder=order, **more)


def path_figure(path, law, title=""):
    """Force against overlap of one path; stiffness against force, first loading as a line, the path as points."""
    fig, (left, right) = figure(columns=2)
    left.plot(path.overlap * 1e6, path.force, lw=1.5)
    left.set(xlabel="overlap (µm)", ylabel="force (N)", title=title)
    touching = path.force > 0
    if touching.any():
        overlap = law.overlap(path.force.max() * np.geomspace(1e-4, 1.0, 200))  # even steps of the path leave low forces out
        right.loglog(law.force(overlap), law.stiffness(overlap) / 1e3, color="0.6", label="first loading")
        right.loglog(path.force[touching], path.stiffness[touching] / 1e3, ".", ms=3, label="path")
        right.legend(frameon=False, fontsize=8)
    right.set(xlabel="force (N)", ylabel="tangent stiffness (N/mm)", title="tangent stiffness")
    return fig


def table_figure(table, law):
    """A table's curve with its nodes, and its errors against the law; the unloading curve likewise, where it has one."""
    fig, (left, right) = figure(columns=2)
    length, title, end = float(np.ravel(table.length)[0]), f"{table.name}: {table.nodes.u.size} rows", table.nodes.force[-1]
    curves = [(table, law, "")]
    if table.unloading_law is not None:
        curves.append((table.unloading_law, law.unloading_law, "unloading "))
        title += f"; unloading, {table.unloading_law.name}: {table.unloading_law.nodes.u.size}"
    for rows, exact, name in curves:
        visible = rows.nodes.force <= end
        left.loglog(rows.nodes.u[visible], rows.nodes.force[visible], ".", ms=3, label=f"{name or 'loading '}nodes")
        reach = float(np.ravel(exact.contact.radius)[0]) / length  # a law is undefined beyond R
        u = np.geomspace(rows.nodes.u[0], min(rows.nodes.u[visible][-1], reach) * (1 - 1e-12), 4000)
        for quantity in ("force", "stiffness"):
            with quiet():  # the table's end, not a load of the user's
                error = getattr(rows, quantity)(u * length) / getattr(exact, quantity)(u * length) - 1
            right.loglog(u, np.maximum(np.abs(error), 1e-17), lw=0.8, label=name + quantity)
    left.set(xlabel="overlap/length", ylabel="force/(E* √R length$^{1.5}$)", title=title)
    if len(curves) > 1:
        left.legend(fontsize=8)
    right.axhline(table.rtol, color="k", ls="--", lw=0.8, label="tolerance")
    right.set(xlabel="overlap/length", ylabel="relative error", title="errors against the law, between the nodes")
    right.legend(fontsize=8)
    return fig


def points_figure(table, overlap, load):
    """Measured points of first loading, overlaps [m] and forces [N], with the table's curve and its 95 % band."""
    fig, (left, right) = figure(columns=2)
    knots = table.knots
    at = np.linspace(0.0, knots.overlap[-1], 600)[1:]
    with quiet():
        force, band = table.force(at), 1.96 * table.uncertainty(at)
        for axes in (left, right):
            axes.plot(overlap * 1e6, load, ".", ms=3, color="k", label="points")
            axes.plot(at * 1e6, force, "-", color="tab:red", lw=1.0, label="table")
            axes.fill_between(at * 1e6, force - band, force + band, color="tab:red", alpha=0.25, lw=0.0)
            axes.plot(knots.overlap * 1e6, knots.force, "o", ms=4, mfc="none", color="tab:red", label="knots")
            axes.set(xlabel="overlap (µm)", ylabel="force (N)")
    right.set(xscale="log", yscale="log", title=f"stiffness within {table.stiffness_error:.1e} of the curve's")
    left.set_title(f"{table.definition.description}: {knots.points} points")
    left.legend(fontsize=8)
    return fig


def fit_figure(ranking, source=""):
    """Measured points with the best fits of different laws, and what remains of the displacement."""
    displacement, force = ranking.points
    fig, (left, right) = figure(columns=2, width=5.0)
    left.plot(displacement * 1e6, force, "k.", ms=4, label=f"measured {source}".strip())
    names, widest = [], 0.0
    for fit in ranking:
        if fit.name in names or len(names) == 5:
            continue
        names.append(fit.name)
        widest = max(widest, np.max(np.abs(displacement - fit.displacement)))
        rule = "" if fit.unloading == "elastic" else f", {fit.unloading}"
        label = f"{fit.name}{rule}: {fit.misfit * 1e6:.3g} µm"
        shade = colour(fit.name)
        left.plot(fit.displacement * 1e6, force, color=shade, lw=1.2, label=label)
        right.plot(force, (displacement - fit.displacement) * 1e6, ".", ms=3, color=shade, label=fit.name)
    left.set(xlabel="displacement (µm)", ylabel="force (N)", title="measured points and laws fitted to them")
    right.axhline(0.0, color="k", lw=0.8)
    right.set(title="misfit of the fitted laws")
    right.set(xlabel="force (N)", ylabel="measured - fitted displacement (µm)", ylim=(-1.2e6 * widest, 1.2e6 * widest))
    left.legend(fontsize=8)
    right.legend(fontsize=8)
    return fig
