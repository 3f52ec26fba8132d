"""Cycles of load on a sample; a row per kept cycle in `cycles.csv`. An interrupted case continues after its last part.

A sample is pressed by 10 kPa from all sides with Hertz's law and no friction between its grains, so that it is dense: all cases
of one seed have equal initial places. With its own law and friction it is pressed to p, then to p + LOW along z: there strains
begin. Cycles between q = LOW and q follow, the first one ten times slower. A sample that has become shorter by a fifth has
collapsed, and its case ends.
"""

import json
import shutil
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np

from demlaws.files import csv_text
from demlaws.lammps import run
from demlaws.laws import HERTZ, POHRT_POPOV
from studies.assembly.study import read
from studies.triaxial import cell

HERE = Path(__file__).parent
RESULTS = HERE / "cycles.csv"
STORE = Path("results") / "triaxial"
PRESSED = 10e3  # [Pa]
LOW = 20e3  # [Pa], of q
COLLAPSED = 0.2  # share of the height
ENDS = (1, 10, *range(50, 2001, 50))
"""Cycles after which a case can be continued."""
ROWS = 50  # of thermo output in a cycle


class Case(NamedTuple):
    """A sample with a law under a load."""

    law: str = HERTZ
    sigma: float = 0.0  # combined roughness [µm]
    rule: str = "hertz"
    edge: float = 0.0  # radius of the edges [mm], 0: of the spheres
    p: float = 60.0  # [kPa]
    q: float = 230.0  # largest [kPa]
    seed: int = 1
    friction: float = 0.6
    grains: str = "tetrapods"
    count: int = 150
    period: float = 0.035  # [s]
    dt: float = 1.4e-5  # [s]

    @property
    def contact(self):
        """`cell.Law`."""
        return cell.Law(self.law, self.sigma, self.rule, self.edge)

    @property
    def steps(self):
        """Steps of a cycle."""
        return round(self.period / self.dt)


FIELDS = (
    *Case._fields,
    *("cycle", "axial", "volumetric", "resilient", "q_kPa", "side_kPa", "side_off_kPa", "contacts", "steps", "seconds"),
)
"""Strains [%], compression positive: permanent after the cycle, and what the top has recovered in it; largest q, mean of the
side pressures and their largest deviation from p."""


def simulate(folder, name, text):
    """Run an input in a folder; the thermo rows."""
    (folder / "post").mkdir(parents=True, exist_ok=True)
    (folder / f"in.{name}").write_text(text)
    return run(folder / f"in.{name}", log=f"log.{name}")


def prepared(case, store=STORE):
    """The dense sample of a seed, made once: rows as of `cell.Grains`, distances of the walls, volume of the grains."""
    folder = Path(store) / f"{case.grains}-{case.count}-{case.seed}"
    file = folder / "sample.json"
    if not file.is_file():
        grains = cell.loose(case.grains, case.count, case.seed)
        box, radius = [grains.side] * 3, cell.contact_radius(case.grains)
        folder.mkdir(parents=True, exist_ok=True)
        cell.write_data(folder / "start.data", grains.rows, box)
        for name in ("pair", "wall"):
            cell.Law().save(folder / f"{name}.tbl", radius)
        text = cell.ground(cell.Law(), case.grains, "data", case.dt, box, 0.0, reach=grains.side)
        more = "fix             drag all viscous 3.0\n"
        grown = f"{PRESSED:g}*(0.05+0.95*step/60000)*(step<60000)+{PRESSED:g}*(step>=60000)"
        off = "variable        off equal (abs(v_px-v_side)+abs(v_py-v_side)+abs(v_pz-v_side))/v_side+(step<60000)+1e4*c_moves\n"
        more += off + "fix             rest all halt 1000 v_off < 0.15 error continue\n"
        text += cell.pistons(box, grown, "v_side", 150_000, 1000, delay=1e-3, more=more)
        log = simulate(folder, "press", text + cell.WRITE.format("sample.txt"))
        shutil.copy(folder / "post" / "sample.txt", folder / "sample.txt")
        found = {"box": [float(v) for v in cell.walls(log, box)[:, -1]], "solid": grains.solid}
        file.write_text(json.dumps(found))
    found = json.loads(file.read_text())
    return cell.read_dump(folder / "sample.txt"), found["box"], found["solid"]


def begin(case, folder, store):
    """Press to p, then to q = LOW; the state to continue with."""
    rows, box, solid = prepared(case, store)
    radius, steps = cell.contact_radius(case.grains), case.steps
    case.contact.save(folder / "pair.tbl", radius)
    cell.Law().save(folder / "wall.tbl", radius)
    cell.write_data(folder / "start.data", rows, box)
    side = f"{PRESSED:g}+{1e3 * case.p - PRESSED:g}*(1-exp(-step/{0.5 * steps:g}))"
    top = f"v_side+{LOW:g}*(step>{4 * steps})*(1-exp(-(step-{4 * steps})/{0.5 * steps:g}))"
    text = cell.ground(case.contact, case.grains, "data", case.dt, box, case.friction)
    text += cell.pistons(box, side, top, 8 * steps, steps // ROWS) + "write_restart 0.restart\n"
    log = simulate(folder, "begin", text)
    places = cell.walls(log, box)[:, -1].tolist()
    return {"box": places, "start": places, "solid": solid / float(np.prod(places)), "done": 0, "rows": []}


def of_cycles(log, case, state, steps):
    """A row (dict) of each complete cycle of `steps` steps in the log of a part."""
    places, start = cell.walls(log, state["box"]), state["start"]
    q = 1e-3 * (log["pz"] - 0.5 * (log["px"] + log["py"]))
    sides = 1e-3 * np.array([log["px"], log["py"]])
    for first in range(0, int(log["Step"][-1]) - steps + 1, steps):
        one = (log["Step"] >= first) & (log["Step"] <= first + steps)
        z, last = places[2][one], places[:, one][:, -1]
        yield {
            "axial": 100.0 * (1.0 - last[2] / start[2]),
            "volumetric": 100.0 * (1.0 - np.prod(last) / np.prod(start)),
            "resilient": 100.0 * (last[2] - z.min()) / start[2],
            "q_kPa": q[one].max(),
            "side_kPa": sides[:, one].mean(),
            "side_off_kPa": np.abs(sides[:, one] - case.p).max(),
            "contacts": log["contacts"][one][-1] / case.count,
            "steps": steps,
        }


def kept(cycle, last):
    """Whether the row of a cycle is kept: about 15 per decade, and the last of a part."""
    return cycle >= last or cycle in np.unique(np.round(10.0 ** (np.arange(60) / 15.0)))


def advance(case, folder, state, end):
    """Cycles up to `end`, from the state after `state["done"]`, which is changed."""
    began, done = time.perf_counter(), state["done"]
    steps = case.steps * (1 if done else 10)
    wave = 5e2 * case.q - 0.5 * LOW
    load = f"{1e3 * case.p + LOW + wave:.17g}-{wave:.17g}*cos({2 * np.pi / steps:.17g}*step)"
    text = cell.ground(case.contact, case.grains, f"{done}.restart", case.dt, state["box"], case.friction)
    more = cell.COLLAPSE.format((1.0 - COLLAPSED) * state["start"][2])
    text += cell.pistons(state["box"], f"{1e3 * case.p:g}", load, steps * (end - done), steps // ROWS, more=more)
    log = simulate(folder, "part", text + f"write_restart {end}.restart\n")
    found = list(of_cycles(log, case, state, steps))
    collapsed = len(found) < end - done
    for row in found:
        state["done"] += 1
        if kept(state["done"], end):
            each = (time.perf_counter() - began) / (end - done)
            state["rows"].append(case._asdict() | {"cycle": state["done"], "seconds": each} | row)
    state["box"] = cell.walls(log, state["box"])[:, -1].tolist()
    if collapsed:  # the cycle in which it does so, with the strain reached
        axial = 100.0 * (1.0 - state["box"][2] / state["start"][2])
        volumetric = 100.0 * (1.0 - float(np.prod(state["box"]) / np.prod(state["start"])))
        state["rows"].append(case._asdict() | {"cycle": state["done"] + 1, "axial": axial, "volumetric": volumetric})
        state["collapsed"] = state["done"] + 1
    (folder / f"{done}.restart").unlink()


def keep(case, rows, path):
    """The rows of a case in the file of results, in place of fewer ones."""
    there = read(path)
    others = [row for row in there if case_of(row) != case]
    if len(there) - len(others) <= len(rows):
        lines = [[text_of(row.get(name)) for name in FIELDS] for row in (*others, *rows)]
        new = Path(f"{path}.new")
        new.write_text(csv_text(FIELDS, lines))
        new.replace(path)


def text_of(value):
    """A number with five digits, or a text."""
    if value is None or (isinstance(value, float) and np.isnan(value)):
        return ""
    return f"{value:.5g}" if isinstance(value, float) else str(value)


def run_case(case, cycles, path=RESULTS, store=STORE, progress=lambda text: None):
    """Run a case up to this number of cycles; it continues after the last complete part."""
    folder = Path(store) / "-".join(map(str, case))
    (folder / "post").mkdir(parents=True, exist_ok=True)
    file = folder / "state.json"
    if not file.is_file():
        file.write_text(json.dumps(begin(case, folder, store)))
    state = json.loads(file.read_text())
    while state["done"] < cycles and "collapsed" not in state:
        end = next(one for one in ENDS if one > state["done"])
        advance(case, folder, state, end)
        keep(case, state["rows"], path)  # first: an interruption between the two repeats the part
        file.write_text(json.dumps(state))
        last = state["rows"][-1]
        progress(f"{' '.join(map(str, case[:8]))}: cycle {last['cycle']}, {last['axial']:.4g} %")
    return state["rows"]


def wanted():
    """(case, cycles) in the order in which they are run: those first that the page needs most."""
    smooth, rough = Case(), Case(law=POHRT_POPOV, sigma=2.4)
    rougher, corners = rough._replace(sigma=10.0), Case(law="rough-plastic", sigma=2.4, edge=0.35)
    laws, ends = (smooth, rougher, corners, rough), (smooth, corners)
    loads = [(60.0, 370.0), (30.0, 230.0), (10.0, 230.0)]
    yield from ((case, 200) for case in laws)
    yield from ((case._replace(p=p, q=q), 200) for p, q in loads for case in ends)
    yield from ((case._replace(seed=2), 200) for case in laws)
    yield corners._replace(law=HERTZ, sigma=0.0), 200
    yield from ((case._replace(seed=3), 200) for case in laws)
    yield rough._replace(rule="elastic"), 200
    yield from ((case._replace(friction=0.9), 200) for case in ends)
    yield from ((case._replace(friction=0.9, p=p, q=q), 200) for p, q in loads for case in ends)
    yield from ((case._replace(grains="spheres"), 200) for case in ends)
    yield from ((case, 2000) for case in ends)
    yield from ((rough._replace(rule="elastic", seed=seed), 200) for seed in (2, 3))
    yield from ((case._replace(seed=seed), 500) for seed in (1, 2, 3) for case in laws)
    yield from ((case._replace(p=p, q=q, seed=seed), 500) for seed in (1, 2, 3) for p, q in loads for case in laws)
    yield from ((case._replace(friction=0.9, p=30.0, seed=seed), 200) for seed in (2, 3) for case in ends)


def case_of(row):
    """`Case` of a row."""
    return Case(*(type(value)(row[name]) for name, value in Case()._asdict().items()))
