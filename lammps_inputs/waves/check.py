"""Speeds by time of flight against √(M/ρ) and √(G/ρ) of the same packing: within 2 %."""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent))
import common

from demlaws.lammps import read_log

RUN = common.load(Path(__file__).parent / "run.py")
NEAR, FAR = 18e-3, 40e-3  # distances of two layers from the middle [m]
LIMIT = 0.02


def density(folder):
    """Density of the packing [kg/m³]."""
    lines = (folder / "box.data").read_text().splitlines()
    sides = [float(line.split()[1]) for line in lines if line.endswith("hi")]
    return int(lines[2].split()[0]) * RUN.DENSITY * np.pi * RUN.DIAMETER**3 / 6 / np.prod(sides)


def static(folder, axis):
    """Speed [m/s] of a wave from the modulus by small strains."""
    log = read_log(folder / f"log.{RUN.AXES[axis]}")
    stress = log["press[3]" if axis == "z" else "press[5]"]
    there, back = (stress[np.searchsorted(log["Step"], step)] for step in (12000, 20000))
    return np.sqrt((back - there) / 2e-6 / density(folder))


def motion(folder, axis):
    """Times [s], places of the layers from the middle [m], velocities of each time and layer [m/s]."""
    rows = [line.split() for line in (folder / "post" / f"motion.{axis}.txt").read_text().splitlines() if line[0] != "#"]
    layers = int(rows[0][1])
    table = np.array([row for row in rows if len(row) == 4], float).reshape(-1, layers, 4)
    times = np.array([int(row[0]) for row in rows if len(row) == 3]) * float(np.loadtxt(folder / "post" / "dt.txt"))
    boxes = table[0, :, 1]
    return times, boxes - 0.5 * (boxes[0] + boxes[-1]), table[:, :, 3]


def signals(folder, axis):
    """Times [s] and the velocities [m/s] at NEAR and FAR, means of both sides."""
    times, places, velocities = motion(folder, axis)

    def at(distance):
        return sum(np.array([np.interp(side * distance, places, row) for row in velocities]) for side in (-1, 1)) / 2

    return times, at(NEAR), at(FAR)


def peak(times, signal):
    """Time [s] of the largest value, by the parabola through three samples."""
    n = int(np.argmax(signal))
    if not 0 < n < len(signal) - 1:
        return np.nan
    a, b, c = signal[n - 1 : n + 2]
    return times[n] + (times[1] - times[0]) * 0.5 * (a - c) / (a - 2 * b + c)


def flight(folder, axis):
    """Speed [m/s] of the peak between NEAR and FAR, and the height of the peak at FAR over that at NEAR."""
    times, near, far = signals(folder, axis)
    return (FAR - NEAR) / (peak(times, far) - peak(times, near)), far.max() / near.max()


def folders(folder):
    return sorted(Path(folder).glob("*kPa"), key=lambda path: int(path.name[:-3]))


def check(folder):
    """(what, deviation, limit) of each wave."""
    for here in folders(folder):
        for axis in RUN.AXES:
            speed, height = flight(here, axis)
            known = static(here, axis)
            wave = f"{here.name}, {'longitudinal' if axis == 'z' else 'transverse'}"
            what = f"{wave}: {speed:.1f} m/s, by the modulus {known:.1f} m/s; height {height:.2f}"
            yield what, abs(speed / known - 1.0) if np.isfinite(speed) else np.inf, LIMIT


def draw(folder, path):
    """Velocities over place and time, with the speeds of the moduli as lines."""
    from demlaws.plots import figure, save

    fig, axes = figure(columns=2, width=4.2, height=3.8)
    here = folders(folder)[-1]
    for ax, axis in zip(axes, RUN.AXES, strict=True):
        times, places, velocities = motion(here, axis)
        span = np.abs(velocities).max() / 2
        ax.pcolormesh(1e3 * places, 1e6 * times, velocities, cmap="RdBu_r", vmin=-span, vmax=span, rasterized=True)
        for sign in (-1, 1):
            ax.plot(sign * 1e3 * static(here, axis) * times, 1e6 * times, "k--", lw=1)
        title = "longitudinal, √(M/ρ)" if axis == "z" else "transverse, √(G/ρ)"
        ax.set(xlabel="place (mm)", ylabel="time (µs)", title=f"{title}, {here.name}", xlim=1e3 * places[[0, -1]])
    return save(fig, path)


if __name__ == "__main__":
    common.check_main(__file__, check)
