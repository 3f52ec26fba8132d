"""The same load again and again on one map: `repeat`, when the map has run in, and its figure."""

import dataclasses
import functools
from typing import NamedTuple

import numpy as np

from demlaws import plots
from demlaws.plots import figure
from demlaws.plots.surface import MICRO, show
from demlaws.regime import regime
from demlaws.solvers.contact import LoadStep, RoughContact
from studies.jamari.published import LOAD, published_contact


class Cycle(NamedTuple):
    """One cycle of loading and unloading."""

    number: int
    step: LoadStep
    contact: RoughContact  # after unloading
    change: float  # volume by which the map changed [m³], ∫|Δz|
    relative_change: float  # over the change of the first cycle


RUN_IN = 0.01
"""ε_r: change of the map in a cycle over that in the first one, below which it has run in."""
SHOWN = (1, 2, 3, 10, 20)
"""Cycles whose profiles the paper of 2008 draws."""
MEMORIES = {
    "pressure": "how blunt its patch has become and the pressure it has carried",
    "blunting": "how blunt its patch has become",
    "none": "nothing: geometry alone",
}
"""What a pixel remembers of a contact that has yielded; the package has the first."""


def reduced(worn, memory):
    """A contact after unloading that keeps no more than this memory."""
    if memory == "pressure":
        return worn
    if memory == "none":
        return dataclasses.replace(worn, spread=None, limit=None, before=None)
    return dataclasses.replace(worn, limit=np.full_like(worn.limit, worn.material.yield_factor), before=None)


def repeat(contact, load, cycles=20, tolerance=1e-3, keep=SHOWN, memory="pressure"):
    """Load to `load` [N] and unload, `cycles` times, each time on the map that the last one left: list of `Cycle`.

    keep: numbers of the cycles whose maps are kept; others hold contact=None. memory: of `MEMORIES`.
    """
    history = []
    first = None
    for n in range(1, cycles + 1):
        step = contact.load(load, tolerance)
        worn = reduced(contact.unload(step), memory)
        change = worn.change_from(contact)
        first = change if first is None else first
        relative = change / first if first > 0 else 0.0
        history.append(Cycle(n, step, worn if n in keep else None, change, relative))
        contact = worn
    return history


STATE_COLOURS = ("#4c78a8", "#f2a541", "#d62728")
"""Of patches that are elastic, elastic-plastic, plastic."""
MAPS = 10
"""Synthetic maps of one statistics, over which ranges are given."""


@functools.cache
def second_changes(memory):
    """Change of each of `MAPS` isotropic maps in cycle 2 over that in cycle 1, by what a pixel remembers."""
    contacts = (published_contact("isotropic", seed=seed) for seed in range(MAPS))
    return tuple(repeat(contact, LOAD, cycles=2, keep=(), memory=memory)[1].relative_change for contact in contacts)


def print_memories():
    """Print the lowest, median and highest change of ten maps for each memory."""
    print(f"change of {MAPS} isotropic maps in cycle 2, of that in cycle 1 (%)")
    print(f"{'memory':10} {'lowest':>9} {'median':>9} {'highest':>9}")
    for memory in MEMORIES:
        change = 100.0 * np.array(second_changes(memory))
        print(f"{memory:10} {change.min():9.3g} {np.median(change):9.3g} {change.max():9.3g}")


def run_in_cycle(history):
    """Number of the last cycle that still changed the map by more than `RUN_IN` of the first's change."""
    return max((c.number for c in history if c.relative_change > RUN_IN), default=0)


def press(contact, load, picture, name):
    """Press a ball on a map 20 times, print what each cycle does and draw it to `picture` (None: nowhere)."""
    print(regime(contact.pair, load))
    history = repeat(contact, load, tolerance=0.01)
    others = {memory: repeat(contact, load, 5, 0.01, keep=(), memory=memory) for memory in MEMORIES if memory != "pressure"}
    for cycle in history:
        if cycle.number in SHOWN:
            print(f"cycle {cycle.number}: {cycle.step}; change of the map {cycle.relative_change:.3g} of the first")
    print(
        f"run in after cycle {run_in_cycle(history)} (ε_r = {RUN_IN:g}), on the assumption that a pixel "
        f"remembers {MEMORIES['pressure']} (memory pressure)"
    )
    for memory, few in others.items():
        print(f"  with memory {memory} cycle 2 changes the map by {100 * few[1].relative_change:.2g} % of cycle 1's change")
    if picture is not None:
        print(plots.save(repeated_figure(contact, history, name, others), picture))


def repeated_figure(contact, history, name, others):
    """Repeated contact: map before and after the first cycle, contact area, profiles and change over cycles.

    others: memory → history of the same contact with another assumption of what a pixel remembers.
    """
    fig, axes = figure(columns=2, rows=3, width=4.8, height=4.0)
    _draw_maps(fig, [*axes[0], axes[1, 0]], contact, history[0], name)
    _draw_patches(fig, axes[1, 1], contact, history[0].step)
    _draw_profiles(axes[2, 0], contact.heights, history)
    _draw_run_in(axes[2, 1], contact, history, others)
    return fig


def _draw_maps(fig, axes, contact, first, name):
    heights = contact.heights
    after = first.contact.heights.heights
    span = {"vmin": np.nanmin(heights.heights) * MICRO, "vmax": np.nanmax(heights.heights) * MICRO}
    show(fig, axes[0], heights, heights.heights * MICRO, "height (µm)", **span)
    axes[0].set_title(f"{name} before: Sq = {heights.sq * MICRO:.2f} µm", fontsize=10)
    show(fig, axes[1], heights, after * MICRO, "height (µm)", **span)
    axes[1].set_title(f"after cycle 1 at {first.step.force:.3g} N", fontsize=10)
    change = (after - heights.heights) * MICRO
    limit = max(abs(np.nanmin(change)), 1e-9)
    show(fig, axes[2], heights, change, "change (µm)", cmap="RdBu", vmin=-limit, vmax=limit)
    touched = np.argwhere(change != 0)
    (row0, column0), (row1, column1) = touched.min(axis=0), touched.max(axis=0)
    px, py = heights.pixel_x * MICRO, heights.pixel_y * MICRO
    axes[2].set(xlim=((column0 - 8) * px, (column1 + 8) * px), ylim=((row0 - 8) * py, (row1 + 8) * py))
    axes[2].set_title("plastic change (contact region)", fontsize=10)


def _draw_patches(fig, ax, contact, step):
    from matplotlib.patches import Circle

    heights = contact.heights
    show(fig, ax, heights, heights.heights * MICRO, "height (µm)", cmap="Greys_r", alpha=0.6)
    _ellipses(ax, step)
    radius = (step.force * 0.75 * contact.pair.radius / contact.pair.modulus) ** (1 / 3)
    middle = np.array(contact.centre) * MICRO
    ax.add_patch(Circle(middle, radius * MICRO, fill=False, ls="--", label="Hertz radius"))
    ax.legend(fontsize=8, loc="upper right")
    counts = step.counts
    ax.set_title(f"cycle 1: {counts[0]} elastic, {counts[1]} elastic-plastic, {counts[2]} plastic", fontsize=10)


def _ellipses(ax, step):
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
            facecolors=[STATE_COLOURS[int(s)] for s in micro.state],
        )
    )


def _draw_profiles(ax, heights, history):
    """Profiles through the pixel that lost most."""
    change = history[0].contact.heights.heights - heights.heights
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
    ax.legend(fontsize=8, ncol=2)


def _draw_run_in(ax, contact, history, others):
    number = [c.number for c in history]
    ax.semilogy(
        number,
        [max(c.relative_change, 1e-6) for c in history],
        "o-",
        label="change of map, memory: pressure",
    )
    for memory, few in others.items():
        ax.semilogy(
            [c.number for c in few], [max(c.relative_change, 1e-6) for c in few], "x:", label=f"change of map, memory: {memory}"
        )
    ax.axhline(RUN_IN, color="black", lw=0.8, ls="--", label=f"run-in, ε$_r$ = {RUN_IN:g}")
    ax.semilogy(number, [c.step.contact_area / history[0].step.contact_area for c in history], "s-", ms=4, label="contact area")
    ax.set(xlabel="cycle", ylim=(5e-7, 3))
    ax.set_title("relative to cycle 1 (0 is drawn at 1e-6)", fontsize=10)
    ax.legend(fontsize=8)
