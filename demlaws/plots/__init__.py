"""Every figure of the package. The only module that imports matplotlib; figures are files, never windows."""

import io
import warnings
from pathlib import Path

import numpy as np

from demlaws.errors import DemlawsError, ValidityWarning
from demlaws.files import write_atomically
from demlaws.laws.definition import Definition
from demlaws.laws.names import HERTZ, POHRT_POPOV
from demlaws.laws.registry import registry


def colour(law):
    """A law's colour; grey for what is none of ours."""
    return registry()[law].colour if law in registry() else Definition._field_defaults["colour"]


def line(law):
    """A law's line style."""
    return registry()[law].line if law in registry() else "-"


def __getattr__(name):
    if name == "COLOURS":  # law → colour
        return {law: definition.colour for law, definition in registry().items()}
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def figure(columns=1, rows=1, width=5.2, height=4.0):
    """A figure and its axes (an array if there are several)."""
    try:
        with warnings.catch_warnings():  # two installed versions of matplotlib's 3-D axes, which no figure here uses
            warnings.filterwarnings("ignore", message="Unable to import Axes3D")
            from matplotlib.backends.backend_agg import FigureCanvasAgg
            from matplotlib.figure import Figure
    except ImportError as error:
        raise DemlawsError("figures need matplotlib: pip install 'demlaws[plots]' (apt: python3-matplotlib)") from error
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
    path = Path(path)
    if not path.name or path.is_dir():
        raise DemlawsError(f"cannot draw {path}: that is a folder; name a file in it")
    kind = path.suffix.lstrip(".").lower() or "png"
    buffer = io.BytesIO()
    try:
        fig.savefig(buffer, format=kind, dpi=130)
    except ValueError as error:
        raise DemlawsError(f"cannot draw {path}: {error}") from error
    return write_atomically(path if path.suffix else path.with_suffix(".png"), buffer.getvalue())


def _line(ax, x, y, name, **more):
    ax.plot(x, y, color=colour(name), linestyle=line(name), label=more.pop("label", name), **more)


def path_figure(path, title=""):
    """Force against overlap of one path, and stiffness against force."""
    fig, (left, right) = figure(columns=2)
    left.plot(path.overlap * 1e6, path.force, lw=1.5)
    left.set(xlabel="overlap (µm)", ylabel="force (N)", title=title)
    touching = path.force > 0
    right.loglog(path.force[touching], path.stiffness[touching] / 1e3, ".", ms=3)
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
        shown = rows.nodes.force <= end
        left.loglog(rows.nodes.u[shown], rows.nodes.force[shown], ".", ms=3, label=f"{name or 'loading '}nodes")
        reach = float(np.ravel(exact.contact.radius)[0]) / length  # beyond R a law gives no answer
        u = np.geomspace(rows.nodes.u[0], min(rows.nodes.u[shown][-1], reach) * (1 - 1e-12), 4000)
        for quantity in ("force", "stiffness"):
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", ValidityWarning)  # the table's end, not a load of the user's
                error = getattr(rows, quantity)(u * length) / getattr(exact, quantity)(u * length) - 1
            right.loglog(u, np.maximum(np.abs(error), 1e-17), lw=0.8, label=name + quantity)
    left.set(xlabel="overlap/length", ylabel="force/(E* √R length$^{1.5}$)", title=title)
    if len(curves) > 1:
        left.legend(fontsize=8)
    right.axhline(table.rtol, color="k", ls="--", lw=0.8, label="asked for")
    right.set(xlabel="overlap/length", ylabel="relative error", title="errors against the law, between the nodes")
    right.legend(fontsize=8)
    return fig


def points_figure(table, measured):
    """Measured points with the table's curve, its 95 % band and, where it has one, an unloading from the largest force.

    measured: (overlaps [m], forces [N]) of first loading, and of unloading.
    """
    fig, (left, right) = figure(columns=2)
    knots = table.knots
    at = np.linspace(0.0, knots.overlap[-1], 600)[1:]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ValidityWarning)
        force, band = table.force(at), 1.96 * table.uncertainty(at)
        for axes, name in ((left, "points"), (right, None)):
            for (overlap, load), colour in zip(measured, ("k", "tab:blue"), strict=False):
                axes.plot(overlap * 1e6, load, ".", ms=3, color=colour, label=name)
                name = name and "unloading"
            axes.plot(at * 1e6, force, "-", color="tab:red", lw=1.0, label="table")
            axes.fill_between(at * 1e6, force - band, force + band, color="tab:red", alpha=0.25, lw=0.0)
            axes.plot(knots.overlap * 1e6, knots.force, "o", ms=4, mfc="none", color="tab:red", label="knots")
            axes.set(xlabel="overlap (µm)", ylabel="force (N)")
        if len(measured) > 1:
            back = table.follow(np.append(measured[1][0].max(), np.linspace(measured[1][0].max(), 0.0, 400)[1:]))
            left.plot(back.overlap * 1e6, back.force, "--", color="tab:blue", lw=1.0, label="table, unloading")
    right.set(xscale="log", yscale="log", title=f"stiffness within {table.stiffness_error:.1e} of the curve's")
    left.set_title(f"{table.definition.description}: {knots.points} points")
    left.legend(fontsize=8)
    return fig


# --- the granite tests


def granite_force(test, runs, points=None, ax=None):
    """Force against displacement of one test, every law; displacement counted from 0.1 N as in the tables."""
    if ax is None:
        _, ax = figure(width=6.4, height=4.8)
    for run in runs:
        path = run.paths[0]
        zero = float(
            np.interp(0.1, path.force[: int(np.argmax(path.force)) + 1], path.overlap[: int(np.argmax(path.force)) + 1])
        )
        end = _first_peak(path.force) if test.cyclic else path.force.size
        _line(ax, (path.overlap[:end] - zero) * 1e6, path.force[:end], run.law.name, lw=1.5)
    if points is not None:
        zero, placed_by = points.zero([run.law for run in runs])
        label = f"measured: {points.source}" + (f" (placed by {placed_by.name})" if placed_by is not None else "")
        ax.plot((points.displacement - zero) * 1e6, points.force, "k.", ms=3, label=label)
    ax.set(xlabel="displacement from 0.1 N (µm)", ylabel="force (N)", title=test.name, ylim=(0, None))
    ax.set_xlim(left=-0.05 * ax.get_xlim()[1])
    ax.legend(fontsize=8)
    return ax.figure


def _first_peak(force):
    falls = np.flatnonzero(np.diff(force) < 0)
    return int(falls[0]) + 1 if falls.size else force.size


def _tangent(ax, points, name="measured", branch=None, **style):
    """Stiffness of measured points: slopes over windows of force."""
    load, stiffness = points.tangent(branch)
    ax.plot(load, stiffness / 1e3, **{"marker": ".", "ls": "none", "color": "k", "ms": 4, **style}, label=name)


def granite_stiffness(tests_and_runs, points=None):
    """Stiffness against load on logarithmic axes, one panel a test; points: measured ones by test name."""
    fig, axes = figure(columns=2, rows=2, width=5.0)
    for ax, (test, runs) in zip(np.ravel(axes), tests_and_runs, strict=False):
        load = np.geomspace(0.1, 100.0, 200)
        for run in runs:
            _line(ax, load, run.law.stiffness(run.law.overlap(load)) / 1e3, run.law.name, lw=1.3)
        if points and test.name in points:
            _tangent(ax, points[test.name], f"measured: {points[test.name].source}")
            ax.legend(fontsize=7)
        ax.set(xscale="log", yscale="log", xlabel="force (N)", ylabel="stiffness (N/mm)", title=test.name)
    np.ravel(axes)[0].legend(fontsize=7)
    return fig


def granite_crossover(test, laws, threshold):
    """Stiffness of Hertz and Pohrt-Popov, and where the lines cross."""
    fig, ax = figure(width=6.0, height=4.4)
    load = np.geomspace(1.0, 500.0, 300)
    for bound in laws:
        _line(ax, load, bound.stiffness(bound.overlap(load)) / 1e3, bound.name, lw=1.6)
    ax.axvline(threshold, color="k", lw=0.8)
    ax.annotate(
        f"F = {threshold:.1f} N\n(the paper's text: 73 N)", (threshold, 2000), xytext=(5, 0), textcoords="offset points"
    )
    ax.set(xscale="log", yscale="log", xlabel="force (N)", ylabel="stiffness (N/mm)", title=f"{test.name}: crossover")
    ax.legend()
    return fig


def granite_roughness(tests, make, points=None):
    """Force and stiffness of Pohrt-Popov for tests that differ in roughness, and of Hertz; points: by test name."""
    fig, (left, right) = figure(columns=2)
    load = np.geomspace(0.05, 100.0, 300)
    for test, shade in zip(tests, ("#1f77b4", "#ff7f0e", "#d62728"), strict=True):
        bound = make(POHRT_POPOV, test)
        overlap = bound.overlap(load)
        label = f"{test.name}, σ = {test.roughness * 1e6:.2f} µm"
        left.plot((overlap - bound.overlap(0.1)) * 1e6, load, color=shade, label=label)
        right.loglog(load, bound.stiffness(overlap) / 1e3, color=shade, label=label)
        if points and test.name in points:
            one = points[test.name]
            left.plot((one.displacement - one.zero([bound])[0]) * 1e6, one.force, ".", color=shade, ms=3, label="measured")
            _tangent(right, one, color=shade)
    hertz = make(HERTZ, tests[1])
    left.plot((hertz.overlap(load) - hertz.overlap(0.1)) * 1e6, load, "k--", label=f"Hertz, {tests[1].name}")
    right.loglog(load, hertz.stiffness(hertz.overlap(load)) / 1e3, "k--", label=f"Hertz, {tests[1].name}")
    left.set(xlabel="displacement from 0.1 N (µm)", ylabel="force (N)", title="effect of roughness, Pohrt-Popov")
    right.set(xlabel="force (N)", ylabel="stiffness (N/mm)", title="tangent stiffness")
    left.legend(fontsize=8)
    return fig


def granite_unloading(test, elastic, hertz, points=None):
    """Unloading from the maximum along each law's own curve, as the paper compares them, and along the Hertz rule's."""
    fig, ax = figure(width=6.4, height=4.8)
    top = max(test.stages[0])
    load = np.linspace(0.05, top, 300)
    for bound in elastic:
        _line(ax, (bound.overlap(load) - bound.overlap(top)) * 1e6, load, bound.name, label=f"{bound.name}, elastic", lw=1.3)
    peak = int(np.argmax(hertz.force))
    ax.plot(
        (hertz.overlap[peak:] - hertz.overlap[peak]) * 1e6,
        hertz.force[peak:],
        color="k",
        lw=3,
        alpha=0.35,
        label="Hertz unloading rule, any law",
    )
    if points is not None:
        peak = int(np.argmax(points.force))
        ax.plot(
            (points.displacement[peak:] - points.displacement[peak]) * 1e6, points.force[peak:], "k.", ms=3, label="measured"
        )
    ax.set(xlabel="displacement from the maximum (µm)", ylabel="force (N)", title=f"{test.name}: unloading")
    ax.legend(fontsize=8)
    return fig


def _step_colour(number, count):
    """Colours of a sequence, as many as there are steps, from dark to light."""
    from matplotlib import colormaps

    return colormaps["viridis"](0.9 * number / max(count - 1, 1))


def granite_cycles(run, stages, points=None):
    """Cycles of a cone: force against displacement stage by stage, and stiffness of each loading branch; points: measured."""
    fig, (left, right) = figure(columns=2, width=5.6, height=4.4)
    for number, path in enumerate(run.paths):
        label = f"stage {number + 1}" if len(run.paths) > 1 else run.law.name
        # later stages are thinner: they lie over the earlier ones that they repeat
        width = 1.0 + 0.5 * (len(run.paths) - 1 - number)
        left.plot(path.overlap * 1e6, path.force, color=_step_colour(number, len(run.paths)), lw=width, label=label)
    if points is not None:
        start = points.displacement[0]
        left.plot((points.displacement - start) * 1e6, points.force, "k.", ms=2, label=f"measured: {points.source}")
    title = f"{run.test.name}: {run.law.name}, {run.law.unloading} unloading"
    left.set(xlabel="overlap (µm)", ylabel="force (N)", title=title + (f"\n{run.beyond}" if run.beyond else ""))
    left.title.set_fontsize(9 if run.beyond else 12)
    path = run.paths[0] if len(run.paths) == 1 else run.paths[3]
    rising = np.flatnonzero(np.r_[False, np.diff(path.force) > 0] & (path.force > 0.5))
    branches = np.split(rising, np.flatnonzero(np.diff(rising) > 1) + 1)
    for number, branch in enumerate(branches):
        right.loglog(
            path.force[branch],
            path.stiffness[branch] / 1e3,
            lw=1.2 + 0.5 * (len(branches) - 1 - number),
            color=_step_colour(number, len(branches)),
            label=f"to {path.force[branch].max():.0f} N",
        )
    load = np.geomspace(0.5, path.force.max(), 100)
    hertz = (6.0 * load * run.test.radius * run.test.contact.modulus**2) ** (1 / 3)
    right.loglog(load, hertz / 1e3, "k--", lw=1, label="Hertz")
    if points is not None:
        for number, branch in enumerate(measured := points.branches()):
            top = points.force[branch[1]]
            _tangent(right, points, f"measured, to {top:.0f} N", branch, color=_step_colour(number, len(measured)), marker="x")
    right.set(xlabel="force (N)", ylabel="stiffness (N/mm)", title="loading stiffness, stage by stage")
    left.legend(fontsize=8)
    right.legend(fontsize=7)
    return fig


def granite_plastic(series, points=None):
    """Cumulative plastic overlap against the largest load; points: measured ones by test name."""
    fig, ax = figure(width=5.6, height=4.2)
    for (name, stages), marker in zip(series, "os^", strict=False):
        ax.plot([s.maximum_force for s in stages], [s.plastic_overlap * 1e6 for s in stages], marker + "-", label=name)
        if points and name in points and (left := points[name].residuals()):
            load, residual = np.array(left).T
            ax.plot(load, residual * 1e6, "k" + marker, mfc="none", label=f"measured {name}: {points[name].source}")
    ax.set(xlabel="maximum force (N)", ylabel="plastic overlap (µm)", title="cumulative plastic overlap")
    ax.legend()
    return fig


def granite_radius(alpha, curves):
    """a*/a_H against the roughness parameter."""
    fig, ax = figure(width=6.0, height=4.4)
    for (name, values), style in zip(curves.items(), ("-", "--", ":"), strict=True):
        ax.semilogx(alpha, values, style, lw=1.6, label=name)
    ax.axvspan(1.0, alpha.max(), color="k", alpha=0.05, lw=0)
    ax.text(1.1, 0.04, "beyond the data of the fit", fontsize=8, transform=ax.get_xaxis_transform())
    ax.set(xlabel="α = σR/a_H²", ylabel="a*/a_H", title="effective contact radius")
    ax.legend()
    return fig
