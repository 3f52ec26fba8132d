"""Cycles of load on a bed; a row per kept cycle in `cycles.csv`. An interrupted case continues after its last part.

A bed is deposited with little friction and pressed flat under 50 kPa, with Hertz's law and the default shear: all cases of one
seed have equal initial places. With its own law and friction it comes to rest, is loaded to 20 kPa, slowly to 200 kPa and back
(cycle 1), and in cycles. At the end follow cycles from 20 kPa to other pressures: the resilient modulus over stress.
"""

import json
import shutil
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np

from demlaws.cli import main as command
from demlaws.lammps import run
from demlaws.laws import HERTZ, POHRT_POPOV
from studies.assembly.study import append, read
from studies.ballast import bed

HERE = Path(__file__).parent
RESULTS = HERE / "cycles.csv"
REPEATS = HERE / "repeats.csv"
"""Two beds with another rounding of the load."""
CONTROL = HERE / "elastic.csv"
"""Beds of `control`; other packings than those of RESULTS, which settled with another default shear."""
LONG = HERE / "long.csv"
"""Clumps in more cycles; packings as those of CONTROL."""
STORE = Path("results") / "ballast"
LOW, HIGH = 20e3, 200e3  # [Pa]
STAGES = (35e3, 60e3, 100e3, 200e3)
"""Largest pressures of the last cycles [Pa]; three cycles each."""
PART = 50  # cycles between two states from which a case continues
SPLIT = 30
"""Energies are computed in the first cycles, and in the last ones to HIGH."""


class Case(NamedTuple):
    """A bed with a law."""

    grains: str = "spheres"
    law: str = HERTZ
    sigma: float = 0.0  # combined roughness [µm]
    shear: str = "default"
    seed: int = 1
    cycles: int = 200
    period: float = 0.035  # [s]
    dt: float = 1.4e-5  # [s]
    count: int = 500
    rule: str = "hertz"  # of unloading

    @property
    def contact(self):
        """`bed.Law`."""
        return bed.Law(self.law, self.sigma, self.shear, self.rule)

    @property
    def clumps(self):
        """Whether its grains are clumps."""
        return self.grains == "clumps"


SENSITIVITY = {
    "as in the study": Case(law=POHRT_POPOV, sigma=2.4),
    "half the step": Case(law=POHRT_POPOV, sigma=2.4, cycles=20, dt=7e-6),
    "half the speed": Case(law=POHRT_POPOV, sigma=2.4, cycles=20, period=0.07),
}
"""One bed with other settings; 20 cycles are compared."""
FIELDS = (
    *Case._fields,
    *(
        "cycle",
        "high_kPa",
        "settlement_um",
        "resilient_um",
        "loss_J",
        "work_J",
        "least_kPa",
        "peak_kPa",
        "contacts",
        "height_mm",
    ),
    *("steps", "seconds"),
    *("dissipated_J", "plastic_J", "rest_J"),  # of the cycles whose energies are computed
)


def simulate(folder, name, text):
    """Run an input in a folder; the thermo rows."""
    (folder / "post").mkdir(parents=True, exist_ok=True)
    (folder / f"in.{name}").write_text(text)
    return run(folder / f"in.{name}", log=f"log.{name}")


def prepared(case, store=STORE):
    """The flat bed of a seed, made once: rows as of `bed.loose`."""
    folder = Path(store) / f"{case.grains}-{case.count}-{case.seed}"
    file, work = folder / "bed.txt", folder / "work"
    if not file.is_file():
        law, friction, dt = bed.Law(), 0.1, case.dt
        work.mkdir(parents=True, exist_ok=True)
        law.save(work / "pair.tbl")
        write = bed.WRITE.format(mol="mol" * case.clumps, name="bed.txt")
        rows = bed.loose(case.count, case.seed, case.clumps)
        for name, more in (
            ("deposit", lambda top: bed.rest(200_000, slow=1e-7)),
            ("press", lambda top: bed.load(50e3, 50e3, 1.0, 110_000, dt, top, width=bed.WIDTH, settled=False)),
            ("release", lambda top: bed.load(50e3, 0.0, 0.2, round(0.1 / dt), dt, top, width=bed.WIDTH, settled=False)),
        ):
            bed.write_data(work / "start.data", rows, case.clumps)
            top = float((rows[:, 5] + 0.5 * rows[:, 1]).max())
            simulate(
                work,
                name,
                bed.ground(law, bed.from_data(case.clumps), dt, friction, case.clumps, settled=False) + more(top) + write,
            )
            rows = bed.read_dump(work / "post" / "bed.txt")
        shutil.copy(work / "post" / "bed.txt", file)
    return bed.read_dump(file)


def begin(case, folder, store):
    """Rest and first load to LOW; the state to continue with."""
    rows = prepared(case, store)
    case.contact.save(folder / "pair.tbl")
    bed.write_data(folder / "start.data", rows, case.clumps)
    top = float((rows[:, 5] + 0.5 * rows[:, 1]).max()) + 1e-4
    text = bed.ground(case.contact, bed.from_data(case.clumps), case.dt, clumps=case.clumps)
    text += bed.rest(round(0.15 / case.dt), drag=20.0)
    text += bed.load(0.0, LOW, 0.4, round(0.2 / case.dt), case.dt, top) + "write_restart 0.restart\n"
    log = simulate(folder, "begin", text)
    return {"top": top, "placed": log["plate"][-1], "start": log["plate"][-1], "done": 0, "part": 0, "steps": 0, "rows": []}


def plastic(path):
    """Work of plastic flow [J] in the contacts of pairs between each two frames of post/flow.txt, also in those that end."""
    before, gains = {}, []
    for frame in Path(path).read_text().split("ITEM: TIMESTEP")[1:]:
        body = frame.split("ITEM: ENTRIES", 1)[1].partition("\n")[2]
        now = {(i, j): work for i, j, work in np.fromstring(body, sep=" ").reshape(-1, 3)}
        earlier = {pair: before.get(pair, 0.0) for pair in now}
        gains.append(sum(work - (earlier[pair] if work >= earlier[pair] else 0.0) for pair, work in now.items()))
        before = now
    return np.array(gains[1:])


def balance(log, one, work, flow):
    """Columns of the energy [J] of a cycle, without the first row of a log: the books of walls are opened in the first step.

    rest: work without the changes of stored, kinetic and potential energy and without what the contacts dissipated.
    """
    one = one & (log["Step"] > 0)
    inside = one[:-1] & one[1:]
    change = {name: float(log[name][one][-1] - log[name][one][0]) for name in ("stored", "moves", "potential", "dissipated")}
    return {
        "dissipated_J": change["dissipated"],
        "plastic_J": float(flow[inside].sum()),
        "rest_J": float(work[inside].sum()) - sum(change.values()),
    }


def plate(log, placed, dt):
    """Place of the plate [m] with which the forces of each row were computed; the row has the place one step later."""
    step = np.maximum(log["Step"], 2.0)
    return np.where(log["Step"] > 0, placed - (placed - log["plate"] - log["speed"] * dt) * step / (step - 1.0), placed)


def of_cycles(log, steps, high, state, dt, height, flow=None):
    """A row (dict) of each cycle of `steps` steps in a log that begins at LOW."""
    area, places = bed.PLATE * bed.WIDTH, plate(log, state["placed"], dt)
    work = -0.5 * (log["carried"][1:] + log["carried"][:-1]) * np.diff(places)
    for first in range(0, int(log["Step"][-1]), steps):
        one = (log["Step"] >= first) & (log["Step"] <= first + steps)
        way, force, taken = places[one], log["carried"][one], work[one[:-1] & one[1:]]
        middle = int(np.argmin(way))
        yield {
            "high_kPa": 1e-3 * high,
            "settlement_um": 1e6 * float(state["start"] - way[-1]),
            "resilient_um": 1e6 * float(way[-1] - way[middle]),
            "loss_J": float(taken.sum()),
            "work_J": float(taken[:middle].sum()),
            "least_kPa": 1e-3 * float(force[-1]) / area,
            "peak_kPa": 1e-3 * float(force.max()) / area,
            "contacts": float(log["contacts"][one][-1]) / height[1],
            "height_mm": 1e3 * height[0],
        } | ({} if flow is None else balance(log, one, work, flow))


def parts(case):
    """(cycles, largest pressure, period, whether energies are computed) of each part of a case."""
    yield 1, HIGH, 10.0 * case.period, True
    first = min(case.cycles, SPLIT) - 1
    yield first, HIGH, case.period, True
    for done in range(first + 1, case.cycles, PART):
        yield min(case.cycles - done, PART), HIGH, case.period, False
    for high in STAGES:
        yield 3, high, case.period, high == HIGH


def kept(cycle, cycles):
    """Whether the row of a cycle is kept: about 15 per decade, and the last."""
    return cycle >= cycles or cycle in np.unique(np.round(10.0 ** (np.arange(60) / 15.0)))


def run_case(case, store=STORE, progress=lambda text: None):
    """Rows of a case; it continues after the last complete part."""
    folder = Path(store) / "-".join(map(str, case))
    (folder / "post").mkdir(parents=True, exist_ok=True)
    file = folder / "state.json"
    if not file.is_file():
        file.write_text(json.dumps(begin(case, folder, store)))
    state = json.loads(file.read_text())
    for number, (cycles, high, period, energies) in enumerate(parts(case)):
        if number < state["part"]:
            continue
        began, steps = time.perf_counter(), round(period / case.dt)
        text = bed.ground(case.contact, bed.from_restart(f"{number}.restart", case.clumps), case.dt, clumps=case.clumps)
        text += bed.load(LOW, high, steps * case.dt, cycles * steps, case.dt, state["top"], state["placed"], energies=energies)
        log = simulate(folder, "part", text + f"write_restart {number + 1}.restart\n")
        height = state["top"] + log["plate"][0], case.count
        flow = plastic(folder / "post" / "flow.txt") if energies else None
        for row in of_cycles(log, steps, high, state, case.dt, height, flow):
            state["done"] += 1
            if kept(state["done"], case.cycles):
                row |= {"cycle": state["done"], "steps": steps, "seconds": (time.perf_counter() - began) / cycles}
                state["rows"].append(case._asdict() | row)
        state |= {"placed": log["plate"][-1], "part": number + 1}
        file.write_text(json.dumps(state))
        (folder / f"{number}.restart").unlink()
        progress(f"{' '.join(map(str, case))}: cycle {state['done']}, {state['rows'][-1]['settlement_um']:.1f} µm")
    return state["rows"]


def stability(case, store=STORE):
    """Print the largest stable step of a finished case of spheres at HIGH, by `demlaws timestep`; walls not included."""
    folder, steps, law = Path(store) / "-".join(map(str, case)), round(case.period / case.dt), case.contact
    state = json.loads((folder / "state.json").read_text())
    text = bed.ground(law, bed.from_restart(f"{len(list(parts(case)))}.restart", False), case.dt)
    text += bed.load(LOW, HIGH, case.period, steps // 2, case.dt, state["top"], state["placed"]) + bed.STATE
    simulate(folder, "state", text)
    rough = f"--unloading hertz --sigma {law.sigma}um --fractal-dimension 2.22".split()
    about = f"--law {law.law} --young {bed.YOUNG:g} --poisson {bed.POISSON} --columns 2 3 4 5 6".split()
    files = [str(folder / "post" / name) for name in ("grains.txt", "contacts.txt")]
    return command(["timestep", *files, *about, *(["7", *rough] if law.sigma else [])])


def wanted():
    """All cases, those first that the page needs most."""
    hertz, rough = Case(), Case(law=POHRT_POPOV, sigma=2.4)
    yield rough._replace(cycles=2000)
    yield from list(SENSITIVITY.values())[1:]
    kinds = [case._replace(grains=grains) for grains in ("spheres", "clumps") for case in (hertz, rough)]
    kinds += [case._replace(shear=shear) for shear in ("slip", "mindlin") for case in (hertz, rough)]
    kinds += [rough._replace(sigma=sigma) for sigma in (10.0, 0.5, 5.0, 1.0)]
    yield from (case._replace(seed=seed) for seed in (1, 2) for case in kinds)
    yield rough._replace(cycles=2000, seed=2)
    yield from (case._replace(seed=3) for case in kinds)


def control():
    """Cases that show which part of an effect of roughness is that of the rule of unloading."""
    smooth, rough = Case(cycles=SPLIT), Case(law=POHRT_POPOV, sigma=2.4, cycles=SPLIT)
    for seed in range(1, 8):
        for grains in ("spheres", "clumps"):
            yield from (case._replace(grains=grains, seed=seed) for case in (smooth, rough, rough._replace(rule="elastic")))


def long():
    """Cases of clumps in as many cycles as the longest of spheres."""
    yield from (Case(grains="clumps", law=POHRT_POPOV, sigma=2.4, cycles=2000, seed=seed) for seed in (1, 2))


def case_of(row):
    """`Case` of a row."""
    return Case(*(type(value)(row[name]) for name, value in Case()._asdict().items()))


def run_cases(cases, path=RESULTS, store=STORE, progress=print):
    """Run the cases that `path` lacks."""
    for case in dict.fromkeys(cases):
        if case not in map(case_of, read(path)):
            append(path, FIELDS, run_case(case, store, progress))
