"""Speeds of the pulses of `waves` by time of flight, and by the moduli of the same packing."""

import numpy as np

from demlaws import plots
from studies.cases import prepared, run_input

NEAR, FAR = 18e-3, 40e-3  # distances of two layers from the middle [m]
AXES = {"z": "z", "x": "xz"}  # polarisation of the wave → strain of its modulus
STEPS = {"z": 570, "x": 850}
NAMES = {"z": "longitudinal", "x": "transverse"}


class Wave:
    """One pulse in the packing of a pressure [kPa]."""

    def __init__(self, folder, pressure, axis, ranks=1):
        self.name, self.axis, self.pressure = f"{pressure} kPa, {NAMES[axis]}", axis, pressure
        values = {"pressure": pressure, "axis": axis, "steps": STEPS[axis]}
        log = run_input("lammps", folder / "in.waves", ranks, values)
        rows = [line.split() for line in (folder / "motion.txt").read_text().splitlines() if line[0] != "#"]
        cells = np.array([row for row in rows if len(row) == 4], float).reshape(-1, int(rows[0][1]), 4)
        self.times = np.array([int(row[0]) for row in rows if len(row) == 3]) * log["Dt"][0]
        self.places = cells[0, :, 1] - 0.5 * (cells[0, 0, 1] + cells[0, -1, 1])  # of the layers, from the middle [m]
        self.velocities = cells[:, :, 3]
        stopped = {"pressure": pressure, "axis": AXES[axis]}
        run_input("lammps", folder / "in.moduli", ranks, stopped)
        (line,) = [text for text in (folder / "log.lammps").read_text().splitlines() if text.startswith("speed by the mod")]
        self.static = float(line.split()[-2])
        near, far = (self._signal(distance) for distance in (NEAR, FAR))
        self.speed = (FAR - NEAR) / (self._peak(far) - self._peak(near))
        self.height = far.max() / near.max()

    def _signal(self, distance):
        sides = [[np.interp(side * distance, self.places, row) for row in self.velocities] for side in (-1, 1)]
        return np.mean(sides, axis=0)

    def _peak(self, signal):
        """Time [s] of the largest value, by the parabola through three samples."""
        n = int(np.argmax(signal))
        if not 0 < n < len(signal) - 1:
            return np.nan
        a, b, c = signal[n - 1 : n + 2]
        return self.times[n] + (self.times[1] - self.times[0]) * 0.5 * (a - c) / (a - 2 * b + c)


def waves(folder, pressures=(10, 100), ranks=1):
    """Both waves at each pressure."""
    folder = prepared("lammps", "waves", folder)
    return [Wave(folder, pressure, axis, ranks) for pressure in pressures for axis in AXES]


def table(found):
    """The lines of the table."""
    yield f"{'':24}{'by time of flight':>20}{'by the modulus':>20}{'difference':>12}{'height':>8}"
    for wave in found:
        difference = wave.speed / wave.static - 1
        yield f"{wave.name:24}{wave.speed:16.1f} m/s{wave.static:16.1f} m/s{difference:12.2%}{wave.height:8.2f}"


def draw(found, path):
    """Velocities over place and time at the last pressure, with the speeds of the moduli as lines."""
    figure, axes = plots.figure(columns=2, width=4.2, height=3.8)
    for ax, wave in zip(axes, found[-2:], strict=True):
        span = np.abs(wave.velocities).max() / 2
        ax.grid(False)
        colours = {"cmap": "RdBu_r", "vmin": -span, "vmax": span, "rasterized": True}
        ax.pcolormesh(1e3 * wave.places, 1e6 * wave.times, wave.velocities, **colours)
        for sign in (-1, 1):
            ax.plot(sign * 1e3 * wave.static * wave.times, 1e6 * wave.times, "k--", lw=1)
        title = f"{NAMES[wave.axis]}, √({'M' if wave.axis == 'z' else 'G'}/ρ), {wave.pressure} kPa"
        ax.set(xlabel="place (mm)", ylabel="time (µs)", title=title, xlim=1e3 * wave.places[[0, -1]])
    return plots.save(figure, path)
