"""Pictures of shear: loops of partial slip, oblique impacts compared with measurements, creep under vibration, and the neck."""

import csv
import itertools
import json
from pathlib import Path

import numpy as np

import demlaws as dl
from demlaws.plots import figure
from demlaws.shear import sheared
from studies.shear import memory
from studies.shear.gas import CONTACT
from studies.shear.oblique import ANGLE, MEASURED, MODELS, impact

RATIO, FRICTION, LOAD = 2 * (1 - 0.25) / (2 - 0.25), 0.5, 10.0
LABELS = {name: "elastic (default)" if name == "elastic" else name for name in MODELS}
COLOURS = dict(zip(MODELS, ("#999999", "#c49a6c", "#9ecae1", "#1f77b4", "#d62728"), strict=True))


def draw():
    """Shear force over displacement at constant overlap, and tangential restitution over the angle of impact."""
    fig, (left, right) = figure(columns=2, width=5.0, height=3.8)
    law = dl.law("pohrt-popov", CONTACT, unloading="hertz")
    overlap = law.overlap(LOAD)
    corners = np.array([0.0, 1.0, -1.0, 1.0])
    for share, shade in ((0.4, 0.35), (0.7, 0.6), (0.95, 1.0)):
        sliding = FRICTION * dl.law("hertz", CONTACT).overlap(LOAD) / RATIO
        along = share * sliding * np.concatenate([np.linspace(a, b, 200) for a, b in itertools.pairwise(corners)])
        path = sheared(law, np.full(along.size, overlap), along, RATIO, "slip", friction=FRICTION, springs=200)
        left.plot(along * 1e9, path.shear_force, color=COLOURS["slip"], alpha=shade)
    path = sheared(law, np.full(along.size, overlap), along, RATIO, "elastic", friction=FRICTION)
    left.plot(along * 1e9, path.shear_force, color=COLOURS["elastic"], lw=1)
    left.axhline(FRICTION * LOAD, color="k", lw=0.8, ls=":")
    left.annotate("Coulomb's limit", (0.03, FRICTION * LOAD), xycoords=("axes fraction", "data"), va="bottom", fontsize=8)
    left.annotate("slip, three amplitudes", (0.62, 0.32), xycoords="axes fraction", color=COLOURS["slip"], fontsize=9)
    left.annotate("elastic", (0.62, 0.25), xycoords="axes fraction", color=COLOURS["elastic"], fontsize=9)
    left.set(xlabel="tangential displacement (nm)", ylabel="shear force (N)", title="granite, 10 N, μ = 0.5")
    angles = np.linspace(1.0, 62.0, 60)
    for model in MODELS:
        right.plot(angles, [impact(angle, model, steps=1500, springs=32).tangential for angle in angles], color=COLOURS[model])
    right.plot(ANGLE, MEASURED, "ko", ms=5)
    places = {
        "displacement kept": (6, 0.985),
        "force kept": (6.5, 0.935),
        "one level": (8, 0.865),
        "elastic": (8.5, 0.79),
        "slip": (1.5, 0.665),
    }
    for model, (x, y) in places.items():
        right.annotate(LABELS[model], (x, y), color=COLOURS[model], fontsize=9)
    right.annotate("measured", (42, 0.74), fontsize=9)
    right.set(xlabel="angle from the normal (degrees)", ylabel="tangential restitution", ylim=(0.55, 1.03))
    right.set(title="5 mm alumina spheres on glass (Kharaz et al. 2001)")
    return fig


RUNS = Path(__file__).with_name("vibration.jsonl")
"""Rows of `--vibrate` that docs/shear.md shows."""
SHADES = {"1 level": "#9ecae1", "2 levels": "#4292c6", "3 levels": "#08519c", "slip": "#d62728", "own": "#999999"}
SHADES |= {"ratio 0.3": "#74c476", "ratio 0.086": "#006d2c"}
RUN_LABELS = {"own": "LIGGGHTS history", "3 levels": "3 levels (default)", "ratio 0.3": "3 levels, K_t/K = 0.3"}
RUN_LABELS |= {"ratio 0.086": "3 levels, K_t/K = 0.086"}


def runs(scene, engine):
    """(model, whether the grains were shaken before, rows) of the runs of `studies.shear.vibration`."""
    for line in map(json.loads, RUNS.read_text().splitlines()):
        if line["scene"] == scene and line["engine"] == engine:
            yield line["model"], line.get("shaken", 0) > 0, np.array(line["rows"])


def draw_creep():
    """Creep of one contact, and settlement of an oedometer, over cycles."""
    fig, (left, right) = figure(columns=2, width=5.0, height=3.8)
    vibration = memory.Vibration(1e-2, True, 3000)
    for count, label in ((1, "1 level"), (3, "3 levels (default)"), (memory.EVERY, "all springs")):
        moved = memory.creep(("pohrt-popov", "hertz"), vibration, count)
        style = {"color": "k", "ls": ":"} if count == memory.EVERY else {"color": SHADES[f"{count} level{'s' * (count > 1)}"]}
        left.plot(np.arange(moved.size), moved, label=label, **style)
    left.set(xlabel="cycles of 1 % of the overlap (noise)", ylabel="displacement over that at rest", yscale="log")
    left.set(title="one contact at half of Coulomb's limit")
    left.legend()
    for model, shaken, rows in runs("oedometer", "liggghts"):
        style = {"lw": 0.8, "ls": "--"} if shaken else {"label": RUN_LABELS.get(model, model)}
        right.plot(rows[:, 0], 1e6 * (rows[0, 2] - rows[:, 2]), color=SHADES[model], **style)
    right.set(xlabel="cycles from 50 to 500 kPa", ylabel="settlement since the first cycle (µm)", xscale="log")
    right.set(title="oedometer, 150 rough granite spheres")
    right.legend()
    return fig


NECK = Path(__file__).with_name("neck.csv")
"""What yade_neck.py prints."""


def draw_neck():
    """Height of a small grain between large ones over time, and its error: against the default with the shortest step."""
    fig, (left, right) = figure(columns=2, width=5.0, height=3.8)
    with NECK.open(newline="") as file:
        rows = {(float(r["ratio"]), float(r["step_us"]), r["model"]): r["heights_mm"].split() for r in csv.DictReader(file)}
    fallen = {run: np.array(heights, float) for run, heights in rows.items()}
    times = 0.3 * np.arange(1, 61) / 60
    for step, shade in ((1.0, "#de2d26"), (0.5, "#fb6a4a"), (0.25, "#fcae91")):
        left.plot(times, fallen[20.0, step, "stock"], color=shade, label=f"Hertz–Mindlin of YADE, {step:g} µs")
    for step, style in ((1.0, "-"), (0.25, ":")):
        left.plot(times, fallen[20.0, step, "elastic"], style, color="k", label=f"default of demlaws, {step:g} µs")
    left.set(xlabel="time (s)", ylabel="height (mm)", title="grain of 0.5 mm between spheres of 10 mm")
    left.legend(fontsize=8)
    ratios = sorted({ratio for ratio, _, _ in fallen})
    for model, colour, label in (
        ("stock", "#de2d26", "Hertz–Mindlin of YADE"),
        ("elastic", "k", "default"),
        ("slip", "#1f77b4", "slip"),
    ):
        last = {r: min(step for ratio, step, _ in fallen if ratio == r) for r in ratios}
        away = [max(abs(fallen[r, 1.0, model][-1] - fallen[r, last[r], "elastic"][-1]), 1e-3) for r in ratios]
        right.plot(ratios, away, "o-", color=colour, label=label)
    right.set(xlabel="ratio of sizes", xscale="log", yscale="log", ylabel="error of the height (mm)")
    right.set(title="step of 1 µs, after 0.3 s", xticks=ratios, xticklabels=[f"{ratio:g}" for ratio in ratios])
    right.minorticks_off()
    right.legend(fontsize=8)
    return fig
