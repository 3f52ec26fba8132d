"""The bed of `studies.ballast` in cycles of load, with friction by pressure and the constant one of its mean contact pressure.

A bed of a seed begins each run with the same positions; it comes to rest and is loaded to 20 kPa, to 200 kPa and back (cycle 1,
ten times slower), and in cycles of 20 to 200 kPa. The mean pressure is that of the bed with friction by pressure under 110 kPa.
"""

import shutil
from pathlib import Path

import numpy as np

from studies.assembly.study import append, read
from studies.ballast import bed, cycles
from studies.friction.coefficients import FORCES, POISSON, SETS, YOUNG, at_mean, read_forces, words

RUNS = Path(__file__).with_name("beds.csv")
STORE = Path("results") / "friction"
CYCLES = 20
RADIUS = {"spheres": 10e-3, "clumps": 10e-3 * bed.CLUMP_SHARE}
"""Reduced radius of two grains of mean size [m]."""
MIDDLE = 0.5 * (cycles.LOW + cycles.HIGH)
FIELDS = ("grains", "seed", "coefficients", "friction", "mean_mu", "mean_MPa", "s1_um", "s20_um", "resilient_um", "loss_1_J")
"""Settlement in cycle 1 and in all, elastic displacement of the last cycle, work of the plate lost in cycle 1."""


def loaded(case, friction, folder, store):
    """Rows as of `cycles.of_cycles` of all cycles; with friction by pressure also the forces [N] of contacts at MIDDLE."""
    rows = cycles.prepared(case, store)
    (folder / "post").mkdir(parents=True, exist_ok=True)
    case.contact.save(folder / "pair.tbl")
    bed.write_data(folder / "start.data", rows, case.clumps)
    top = float((rows[:, 5] + 0.5 * rows[:, 1]).max()) + 1e-4
    more, mu = words(friction)

    def part(name, start, scene):
        text = bed.ground(case.contact, start, case.dt, mu, case.clumps, more=more)
        return cycles.simulate(folder, name, text + scene)

    scene = bed.rest(round(0.15 / case.dt), drag=20.0)
    scene += bed.load(0.0, cycles.LOW, 0.4, round(0.2 / case.dt), case.dt, top) + "write_restart 0.restart\n"
    log = part("begin", bed.from_data(case.clumps), scene)
    state = {"start": log["plate"][-1], "placed": log["plate"][-1]}
    forces, found = None, []
    if more:
        scene = bed.load(MIDDLE, MIDDLE, 0.2, round(0.1 / case.dt), case.dt, top, state["placed"]) + FORCES
        part("middle", bed.from_restart("0.restart", case.clumps), scene)
        forces = read_forces(folder / "post" / "forces.txt")
    for number, (count, period) in enumerate([(1, 10.0 * case.period), (CYCLES - 1, case.period)]):
        steps = round(period / case.dt)
        scene = bed.load(cycles.LOW, cycles.HIGH, steps * case.dt, count * steps, case.dt, top, state["placed"])
        start = bed.from_restart(f"{number}.restart", case.clumps)
        log = part(f"part{number}", start, scene + f"write_restart {number + 1}.restart\n")
        found += cycles.of_cycles(log, steps, cycles.HIGH, state, case.dt, (top + log["plate"][0], case.count))
        state["placed"] = log["plate"][-1]
    return found, forces


def run_bed(grains, seed, coefficients="example", path=RUNS, store=STORE, progress=print):
    """Run a pair that `path` lacks: with friction by pressure, then with the constant one."""
    there = {(row["grains"], int(row["seed"]), row["coefficients"]) for row in read(path)}
    if (grains, seed, coefficients) in there:
        return
    case, by_pressure = cycles.Case(grains=grains, seed=seed, cycles=CYCLES), SETS[coefficients]
    rows, mean = [], None
    for friction in ("pressure", "mean"):
        folder = Path(store) / f"bed-{grains}-{seed}-{coefficients}-{friction}"
        shutil.rmtree(folder, ignore_errors=True)
        found, forces = loaded(case, by_pressure if mean is None else mean, folder, store)
        mean = mean or at_mean(by_pressure, forces, RADIUS[grains], YOUNG / (2 * (1 - POISSON**2)))
        first, last = found[0], found[-1]
        row = {"grains": grains, "seed": seed, "coefficients": coefficients, "friction": friction}
        row |= {"mean_mu": mean.mu, "mean_MPa": 1e-6 * mean.pressure, "s1_um": first["settlement_um"]}
        rows.append(row | {"s20_um": last["settlement_um"], "resilient_um": last["resilient_um"], "loss_1_J": first["loss_J"]})
        progress(" ".join(f"{v:.4g}" if isinstance(v, float | np.floating) else str(v) for v in rows[-1].values()))
    append(path, FIELDS, rows)
