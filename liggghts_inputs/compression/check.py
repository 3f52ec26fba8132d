"""Stress–strain of the oedometer: order of the laws, equilibrium, residual strain, and Hertz table against stock Hertz."""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent))
import common

from demlaws.liggghts import read_log


def check(folder):
    logs = {name: read_log(Path(folder) / f"log.{name}") for name in ("hertz", "pohrt-popov", "rough-plastic", "stock")}
    stress = {name: np.abs(log["plate_st"]) for name, log in logs.items()}
    peak = {name: values.max() for name, values in stress.items()}
    print("peak plate stress [MPa]: " + ", ".join(f"{name} {value / 1e6:.2f}" for name, value in peak.items()))
    findings = [
        ("stress, Pohrt–Popov over Hertz", peak["pohrt-popov"] / peak["hertz"], 1.0),
        ("stress, rough-plastic over Pohrt–Popov", peak["rough-plastic"] / peak["pohrt-popov"], 1.0),
        (
            "Hertz table against stock hertz, of the peak stress",
            np.abs(stress["hertz"] - stress["stock"]).max() / peak["stock"],
            1e-3,
        ),
    ]
    for name in ("hertz", "pohrt-popov", "rough-plastic"):
        floor = np.abs(logs[name]["floor_st"])
        at = np.argmax(stress[name])
        findings.append((f"{name}: plate against floor at the peak", abs(floor[at] / stress[name][at] - 1), 0.05))
    return findings


if __name__ == "__main__":
    common.check_main(__file__, check)
