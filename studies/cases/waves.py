"""Speeds of the pulses of `waves` by time of flight, and by the moduli of the same packing."""

import numpy as np

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


def rows(found):
    """Head and rows of the pulses at the last pressure: velocities of the layers at every fourth time, speed of the moduli."""
    yield "wave", "speed by the moduli (m/s)", "time (s)", *(f"{place:.5g} m" for place in found[-1].places)
    for wave in found[-2:]:
        for time, velocities in zip(wave.times[::4], wave.velocities[::4], strict=True):
            yield wave.name, f"{wave.static:.2f}", f"{time:.6g}", *(f"{velocity:.2g}" for velocity in velocities)
