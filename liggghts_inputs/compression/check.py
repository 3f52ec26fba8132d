"""Stress against strain of the oedometer: order of the laws, equilibrium, residual strain, Hertz table against stock Hertz."""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent))
import common

from demlaws import plots
from demlaws.liggghts import read_log

LAWS = ("hertz", "pohrt-popov", "rough-plastic")


def curves(folder):
    """name → (strain, plate stress [Pa], row of the largest strain, log)."""
    found = {}
    for name in (*LAWS, "stock"):
        log = read_log(Path(folder) / f"log.{name}")
        found[name] = log["strain"], np.abs(log["plate_st"]), int(np.argmax(log["strain"])), log
    return found


def work(stress, strain):
    """∫ stress d strain [J/m³]."""
    return float(np.sum(0.5 * (stress[1:] + stress[:-1]) * np.diff(strain)))


def residual(strain, stress, turn):
    """Permanent strain: unloading against loading, at 5 % of the peak stress."""
    low = 0.05 * stress[turn]
    there = strain[np.argmax(stress > low)]
    return float(np.interp(-low, -stress[turn:], strain[turn:]) - there)


def check(folder):
    found = curves(folder)
    largest = found["hertz"][0].max()
    parts = (0.25, 0.5, 0.75, 1.0)
    columns = "".join(f"{100 * part * largest:8.3f}%" for part in parts)
    print(f"{'plate stress [MPa] at':22}{columns}  exponent  residual strain  loop, of the work")
    peak, left, lost = {}, {}, {}
    for name, (strain, stress, turn, _) in found.items():
        loading = np.interp(np.array(parts) * largest, strain[: turn + 1], stress[: turn + 1])
        exponent = np.log(loading[3] / loading[1]) / np.log(2)
        taken = work(stress[: turn + 1], strain[: turn + 1])
        peak[name], left[name] = stress[turn], residual(strain, stress, turn)
        lost[name] = 1 + work(stress[turn:], strain[turn:]) / taken
        values = "".join(f"{value / 1e6:9.3f}" for value in loading)
        print(f"{name:22}{values}{exponent:10.3f}{100 * left[name]:16.4f}%{lost[name]:18.3f}")
    strain, stress, turn, _ = found["hertz"]
    difference = np.abs(stress - found["stock"][1]) / peak["stock"]
    early = strain[:turn] < 0.25 * largest
    findings = [
        ("stress, Pohrt–Popov over Hertz", peak["pohrt-popov"] / peak["hertz"], 1.0),
        ("stress, rough-plastic over Pohrt–Popov", peak["rough-plastic"] / peak["pohrt-popov"], 1.0),
        ("residual strain, Hertz less Pohrt–Popov, of the largest", (left["hertz"] - left["pohrt-popov"]) / largest, 0.0),
        (
            "residual strain, Pohrt–Popov less rough-plastic, of the largest",
            (left["pohrt-popov"] - left["rough-plastic"]) / largest,
            0.0,
        ),
        ("energy of the loop, Hertz over Pohrt–Popov", lost["hertz"] / lost["pohrt-popov"], 1.0),
        (
            "Hertz table against stock hertz, first quarter of the loading, of the peak stress",
            difference[:turn][early].max(),
            1e-4,
        ),
        # later a grain may slip from between others, and what the table differs by, 1e-6, grows to 1e-3
        ("Hertz table against stock hertz, median row, of the peak stress", np.median(difference), 1e-3),
    ]
    for name in LAWS:
        _, stress, turn, log = found[name]
        findings.append((f"{name}: plate against floor at the peak", abs(abs(log["floor_st"][turn]) / stress[turn] - 1), 0.05))
    return findings


def draw(folder, path):
    figure, axes = plots.figure(width=6)
    for name, (strain, stress, _, _) in curves(folder).items():
        if name in LAWS:
            axes.plot(strain * 100, stress / 1e6, color=plots.COLOURS[name], label=name)
    axes.set(xlabel="axial strain (%)", ylabel="plate stress (MPa)")
    axes.legend(frameon=False)
    return plots.save(figure, path)


if __name__ == "__main__":
    common.check_main(__file__, check)
