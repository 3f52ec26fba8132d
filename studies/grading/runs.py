"""Runs of `scenes`, a row of results per run. Bodies, contacts and heights are read from LAMMPS's dumps."""

import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from demlaws.errors import DemlawsError
from demlaws.lammps import read_log, run
from studies.assembly.study import append, read
from studies.grading.scenes import DENSITY, LARGE, LENGTH, SIDE, WIDTH, Case, heap, oedometer, plate, scattered, settled

HERE = Path(__file__).parent
HEAPS, OEDOMETERS = HERE / "heap.csv", HERE / "oedometer.csv"
REST, WINDOW, LOOKS = 0.25, 0.1, 20
"""Times [s] until the wall is removed and again until the end; between records of the contacts after each; their number."""
LOW, HIGH, PERIOD = 5e3, 50e3, 0.02
"""Pressures of a cycle [Pa] and its time [s]."""
HEAP_FIELDS = (*Case._fields, "hang_bed", "hang_heap", "fines_heap", "large_heap", "angle", "steps", "us_step")
OEDOMETER_FIELDS = (*Case._fields, "cycles", "height_mm", "first_um", "later_um", "largest_kPa", "steps", "us_step")


def simulate(texts, folder, former=None):
    """Run in.scene of {file: text}; (thermo rows, CPU time [µs] of a step). former: a checkout whose plugin is loaded."""
    for name, text in texts.items():
        (folder / name).write_text(text)
    if former is None:
        log = run(folder / "in.scene")
    else:
        line = [sys.executable, "-m", "demlaws", "lammps", "run", "in.scene"]
        result = subprocess.run(line, cwd=folder, env={**os.environ, "PYTHONPATH": str(former)}, capture_output=True, text=True)
        if result.returncode:
            raise DemlawsError(f"LAMMPS with the plugin of {former}: {result.stderr.strip()[-500:]}")
        log = read_log(folder / "log.lammps")
    text = (folder / "log.lammps").read_text()
    loops = re.findall(r"Loop time of (\S+) on 1 procs for (\d+) steps", text)
    shares = re.findall(r"^ *(\S+)% CPU use", text, re.MULTILINE)
    spent = sum(float(time) * float(share) / 100 for (time, _), share in zip(loops, shares, strict=True))
    return log, 1e6 * spent / sum(int(steps) for _, steps in loops)


def frames(path, columns):
    """Arrays (rows, columns) of the frames of a dump."""
    parts = Path(path).read_text().split("ITEM: TIMESTEP")[1:]
    bodies = (re.split(r"ITEM: (?:ATOMS|ENTRIES)[^\n]*\n", part, maxsplit=1)[1] for part in parts)
    return [np.fromstring(body, sep=" ").reshape(-1, columns) for body in bodies]


def hanging(grains, pairs, length=LENGTH):
    """Mask of the last frame's grains that hang.

    In every frame they touch at least one other grain, in all together not more than two, and never a wall. Without a third
    contact nothing balances the moment of the weight about the line between two, except right above or below it.
    """
    names = grains[-1][:, 0].astype(int)
    partners, always, walls = {n: set() for n in names}, dict.fromkeys(names, True), dict.fromkeys(names, False)
    for bodies, touching in zip(grains, pairs, strict=True):
        met = {n: set() for n in names}
        for one, other in touching.astype(int):
            for n, m in ((one, other), (other, one)):
                if n in met:
                    met[n].add(m)
        for n, found in met.items():
            partners[n] |= found
            always[n] &= bool(found)
        radius, x, z = bodies[:, 2], bodies[:, 3], bodies[:, 5]
        for n in bodies[(z < radius) | (x < radius) | (x > length - radius), 0].astype(int):
            walls[n] = True
    return np.array([always[n] and len(partners[n]) <= 2 and not walls[n] for n in names])


def surface(grains, pitch=0.1 * LARGE):
    """Heights [m] of the upper surface on a grid: (places along x, heights averaged over y; 0 on the floor)."""
    x, y = (pitch * (0.5 + np.arange(round(length / pitch))) for length in (LENGTH, WIDTH))
    top = np.zeros((x.size, y.size))
    for radius, *place in grains[:, 2:]:
        across = np.abs(y - place[1])
        square = radius**2 - ((x - place[0]) ** 2)[:, None] - (np.minimum(across, WIDTH - across) ** 2)[None, :]
        top = np.where(square > 0.0, np.maximum(top, place[2] + np.sqrt(np.maximum(square, 0.0))), top)
    return x, top.mean(axis=1)


def angle(grains):
    """Slope of the surface [degrees] by a straight line, without the last grain at each end."""
    x, height = surface(grains)
    inner = (x > LARGE) & (x < LENGTH - LARGE)
    return float(np.degrees(np.arctan(-np.polyfit(x[inner], height[inner], 1)[0])))


def rows_of(grains):
    """Rows of `scenes` of a frame of bodies."""
    return [(int(k), 2 * r, 0.1 * DENSITY if k == 3 else DENSITY, x, y, z) for _, k, r, x, y, z in grains.tolist()]


def kept(file, simulated):
    """The array of a file, from `simulated` () where the file is missing."""
    if not file.is_file():
        file.parent.mkdir(parents=True, exist_ok=True)
        np.save(file, simulated())
    return np.load(file)


def last(texts, case):
    """Bodies at the end of an input that writes them."""
    with tempfile.TemporaryDirectory() as name:
        case.save_table(name)
        simulate(texts, Path(name))
        return frames(Path(name) / "end.grains", 6)[-1]


def large_bed(case, store, time=0.5):
    """Bodies of a bed of large grains for the heap, the same for all models and ratios."""
    case = Case(ratio=5.0, large=case.large, seed=case.seed, young=case.young)
    return kept(Path(store) / f"heap-{case.large}-{case.young:g}-{case.seed}.npy", lambda: last(settled(case, time), case))


def run_heap(case, store, former=None, rest=REST, window=WINDOW, looks=LOOKS):
    """Row of a heap: fines that hang before and after the wall is removed, what is left of both sizes, and the slope."""
    rows, found = rows_of(large_bed(case, store)), {}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        case.save_table(folder)
        _, cost = simulate(heap(case, rows, rest, window, looks), folder, former)
        for stage, length in (("bed", LENGTH), ("heap", np.inf)):
            grains, pairs = frames(folder / f"{stage}.grains", 6), frames(folder / f"{stage}.pairs", 2)
            found[f"hang_{stage}"] = int(np.sum(hanging(grains, pairs, length) & (grains[-1][:, 1] == 2)))
    kinds = grains[-1][:, 1]
    return (
        case._asdict()
        | found
        | {
            "fines_heap": int(np.sum(kinds == 2)),
            "large_heap": int(np.sum(kinds == 1)),
            "angle": angle(grains[-1]),
            "steps": 2 * (case.steps(rest) + looks * case.steps(window / looks)),
            "us_step": cost,
        }
    )


def loaded_bed(case, store, rest=0.2, squeeze=0.1):
    """Bodies of a bed and its plate at rest under LOW, the same for all models."""
    case = case._replace(model="after")

    def made():
        rows = rows_of(last(oedometer(case, scattered(case, SIDE, SIDE, walls=False), case.steps(rest)), case))
        rows += plate(max(row[-1] + 0.5 * row[1] for row in rows))
        steps = case.steps(squeeze)
        return last(oedometer(case, rows, steps, f"-{LOW * SIDE**2:.10g}*ramp(0,1)", steps), case)

    return kept(Path(store) / f"oedometer-{case.ratio:g}-{case.large}-{case.fines}-{case.young:g}-{case.seed}.npy", made)


def run_oedometer(case, store, former=None, cycles=20):
    """Row of a bed under cycles from LOW to HIGH: settlement in the first one and from its end to the last one."""
    period, half = case.steps(PERIOD), 0.5 * (HIGH - LOW) * SIDE**2
    period -= period % 20
    # a period under LOW, in which the shear forces come back that the stored places lack
    swing = f"{half:.10g}*(1-cos({2 * np.pi / period:.17g}*step))*(step>={period})"
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        case.save_table(folder)
        force = f"-({LOW * SIDE**2:.10g}+{swing})"
        texts = oedometer(case, rows_of(loaded_bed(case, store)), (cycles + 1) * period, force, period // 20)
        log, cost = simulate(texts, folder, former)
    height = log["height"][log["Step"] % period == 0][1:]
    carried = -log["push"].min() * sum(row[0] == 3 for row in rows_of(loaded_bed(case, store))) / SIDE**2
    return case._asdict() | {
        "cycles": cycles,
        "height_mm": 1e3 * float(height[0] - 0.5 * LARGE),
        "first_um": 1e6 * float(height[0] - height[1]),
        "later_um": 1e6 * float(height[1] - height[-1]),
        "largest_kPa": 1e-3 * float(carried),
        "steps": (cycles + 1) * period,
        "us_step": cost,
    }


def run_cases(cases, path, fields, simulated, progress=print):
    """Append the row `simulated(case)` of each case that the file lacks."""
    done = {tuple(row[name] for name in Case._fields) for row in read(path)}
    for case in cases:
        if tuple(case) not in done:
            append(path, fields, [simulated(case)])
            progress(f"{Path(path).stem}: 1:{case.ratio:g}, {case.model}, seed {case.seed}")
