"""Total energy of a closed gas of 64 spheres without damping: a contact model that creates energy heats it."""

import contextlib
import csv
import itertools
import math
import sys
import tempfile
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
from tqdm import tqdm

import demlaws as dl
from demlaws import lammps, liggghts
from demlaws.errors import DemlawsError, quiet
from demlaws.lammps.run import HEAD as LAMMPS_HEAD
from demlaws.laws.registry import registry
from demlaws.liggghts.run import HEAD as LIGGGHTS_HEAD
from demlaws.make import example_law
from studies.engines import under_yade

ENGINES = {"liggghts": liggghts, "lammps": lammps}
STOCK = {"liggghts": ("history",), "lammps": ("mindlin", "mindlin_rescale", "mindlin_rescale/force"), "yade": ("native",)}
DIAMETER, SPACING, TIME = 0.0174, 0.02, 0.03  # [m, m, s]
HEADS = {"liggghts": LIGGGHTS_HEAD, "lammps": f"{LAMMPS_HEAD}boundary f f f\n"}
START = """\
{head}processors {ranks} 1 1
region box block {ends}
create_box 1 box
{places}
set group all diameter 0.0174 density 2650
"""
REST = """\
neighbor 0.002 bin
neigh_modify delay 0
{walls}timestep {step}
fix integr all nve/sphere
compute ke all ke
compute er all erotate/sphere
{energy}thermo_style custom step c_ke c_er v_stored v_lost v_viscous
thermo_modify norm no lost error format float %.17e
thermo {every}
"""
LIGGGHTS = """\
fix m1 all property/global youngsModulus peratomtype 60.6e9
fix m2 all property/global poissonsRatio peratomtype {poisson}
fix m3 all property/global coefficientRestitution peratomtypepair 1 {restitution}
fix m4 all property/global coefficientFriction peratomtypepair 1 {friction}
pair_style gran model {pair}
pair_coeff * *
"""


def contact(poisson=0.25, radius=4.35e-3):
    """Granite of that Poisson's ratio; radius: of two spheres of the gas, or 8.7e-3 for a sphere and a wall [m]."""
    modulus = 60.6e9 / (2 * (1 - poisson**2))
    return dl.Contact(radius=radius, modulus=modulus, sigma=2.4e-6, fractal_dimension=2.22, hardness=6.266e9)


CONTACT = contact()


def cases():
    """Names of (law, rule) pairs that are accepted."""
    for name, definition in registry().items():
        for rule in definition.offered():
            with contextlib.suppress(DemlawsError):
                example_law(name, CONTACT, rule)
                yield name, rule


class Result(NamedTuple):
    """Energies at each output over that of the start."""

    kept: np.ndarray  # kinetic, rotational and stored
    balance: np.ndarray  # with what the contacts report as dissipated; of stock models the same as kept


def places_and_speeds(side=4):
    """Centres [m] and velocities [m/s] of the spheres at the start."""
    speeds = np.random.default_rng(3).normal(0, 0.3, (side**3, 3))
    return list(zip((0.01 + SPACING * np.argwhere(np.ones((side,) * 3))).tolist(), speeds.tolist(), strict=True))


def _places(side):
    """Lines that create the spheres with their velocities."""
    lines = []
    for n, (place, speed) in enumerate(places_and_speeds(side)):
        lines.append("create_atoms 1 single {:.2f} {:.2f} {:.2f} units box".format(*place))
        lines.append("set atom {} vx {:.6f} vy {:.6f} vz {:.6f}".format(n + 1, *speed))
    return "\n".join(lines)


def save_tables(name, rule, poisson, folder):
    """Write pair.tbl and wall.tbl of a law: one that does not collapse has another curve at a wall, whose radius is larger."""
    for file, radius in (("pair.tbl", DIAMETER / 4), ("wall.tbl", DIAMETER / 2)):
        law = example_law(name, contact(poisson, radius), rule)
        with quiet():
            for share in (0.9, 0.3, 0.1):  # of the radius: how far a height map goes is not known before
                with contextlib.suppress(DemlawsError):
                    law.tabulate(rtol=1e-5, max_force=min(2e4, float(law.force(share * radius)))).save(folder / file)
                    break


def scene(
    engine,
    tangential,
    *,
    friction=100.0,
    poisson=0.25,
    words="",
    tables=None,
    restitution=1.0,
    step,
    every,
    side=4,
    ranks=1,
    newton="on",
):
    """Input of side³ spheres in "liggghts" or "lammps" in three parts: spheres, pair style, and all else but `run`.

    tables: files for pairs and for walls (None: the engine's own Hertz); words: settings behind them, as "shear slip".
    restitution: below 1 contacts are damped, with tables only.
    """

    def terms(table, place=""):
        if engine == "liggghts":
            own = f"table {table} {words}" if table else ""
            return f"{'demlaws/table' if table else 'hertz'} tangential {tangential} {place}{own}"
        damped = restitution < 1.0
        law, eta = f"demlaws/table {table}" if table else "hertz/material", restitution if damped else 0
        own = f"demlaws {int(damped)} {friction}" if tangential == "demlaws" else f"{tangential} NULL 0 {friction}"
        damping = "demlaws/tangent" if damped else "velocity"
        return f"{law} 60.6e9 {eta} {poisson} {words} tangential {own} damping {damping}"

    pair, wall = tables or (None, None)
    box = side * SPACING
    sides = [(a, i, p) for a in "xyz" for i, p in (("l", 0.0), ("h", box))]
    if engine == "liggghts":
        contacts = LIGGGHTS.format(poisson=poisson, friction=friction, restitution=restitution, pair=terms(pair))
        walls = [f"fix {a}{i} all wall/gran model {terms(wall, f'primitive type 1 {a}plane {p:.10g} ')}\n" for a, i, p in sides]
    else:
        contacts = f"pair_style granular\npair_coeff * * {terms(pair)}\n"
        walls = [
            f"fix {a}{i} all wall/gran granular {terms(wall)} {a}plane {f'NULL {p:.10g}' if p else '0 NULL'}\n"
            for a, i, p in sides
        ]
    energy = "" if tables is None else "compute en all demlaws/energy\n"
    for n, name in enumerate(("stored", "lost", "viscous"), 1):
        energy += f"variable {name} equal {0 if tables is None else f'c_en[{n}]'}\n"
    head = HEADS[engine] + (f"newton {newton}\n" if engine == "lammps" else "")
    ends = f"-0.001 {box + 0.001:.10g} " * 3 + "units box"
    start = START.format(head=head, ranks=ranks, ends=ends, places=_places(side))
    return start, contacts, REST.format(walls="".join(walls), step=step, energy=energy, every=every)


def simulate(engine, tangential, *, friction=100.0, poisson=0.25, words="", tables=None, steps=150_000):
    """`Result` of TIME in `scene`; tables: folder with those of `save_tables`."""
    files = tables and (f"{tables}/pair.tbl", f"{tables}/wall.tbl")
    text = scene(
        engine, tangential, friction=friction, poisson=poisson, words=words, tables=files, step=TIME / steps, every=steps // 30
    )
    with tempfile.TemporaryDirectory() as name:
        (Path(name) / "in.gas").write_text("".join(text) + f"run {steps}\n")
        log = ENGINES[engine].run(Path(name) / "in.gas")
    kept = log["ke"] + log["er"] + log["stored"]
    return Result(kept / kept[0], (kept + log["lost"]) / kept[0])


def in_yade(law, rule, runs, steps):
    """The same in YADE, for all runs (Poisson's ratio, friction, shear) of a law in one process: `Result`s or refusals."""
    given = {"law": law, "rule": rule, "runs": runs, "steps": steps, "grains": places_and_speeds()}
    for energies in under_yade("shear/yade_gas.py", given):
        if isinstance(energies, str):
            yield DemlawsError(energies)
        else:
            kept, balance = np.array(energies).T
            yield Result(kept / kept[0], balance / balance[0])


def in_engine(engine, law, rule, runs, steps):
    """The same in LIGGGHTS or LAMMPS; law None: the engine's own."""
    with tempfile.TemporaryDirectory() as folder:
        written = None
        for poisson, friction, shear in runs:
            own = {"tangential": shear}
            try:
                if law is not None:
                    own = {"tangential": "demlaws", "words": f"shear {shear}", "tables": folder}
                    if written != poisson:
                        save_tables(law, rule, poisson, Path(folder))
                        written = poisson
                yield simulate(engine, friction=friction, poisson=poisson, steps=steps, **own)
            except DemlawsError as error:
                yield error


FIELDS = ("engine", "law", "rule", "shear", "friction", "poisson", "largest", "end", "balance", "step_us", "time_ms")


def run_all(engines, frictions, poissons, *, shears, steps):
    """Print a row of FIELDS as CSV for each run in these engines; a refused run has its reason in `largest`."""
    writer = csv.writer(sys.stdout)
    writer.writerow(FIELDS)
    for law, rule in tqdm([(None, "elastic"), *cases()], disable=not sys.stderr.isatty()):
        for engine in engines:
            runs = list(itertools.product(poissons, frictions, shears if law else STOCK[engine]))
            results = (in_yade if engine == "yade" else partial(in_engine, engine))(law, rule, runs, steps)
            for (poisson, friction, shear), result in zip(runs, results, strict=True):
                values = [f"refused: {result}", "", ""]
                if isinstance(result, Result):
                    values = [f"{result.kept.max():.5f}", f"{result.kept[-1]:.4f}", f"{result.balance[-1]:.5f}"]
                case = [engine, law or "stock hertz", rule, shear, f"{friction:g}", f"{poisson:g}"]
                writer.writerow([*case, *values, f"{1e6 * TIME / steps:g}", f"{1e3 * TIME:g}"])
                sys.stdout.flush()


def summary(files):
    """Rows (engine, shear, pairs of law and rule, runs, refused, largest energy, error of the balance) of `run_all`'s files."""
    rows = {}
    for file in files:
        with open(file, newline="") as text:
            for line in csv.DictReader(text):
                runs = rows.setdefault((line["engine"], line["shear"]), ([], []))
                runs[line["largest"].startswith("refused")].append(line)
    for (engine, shear), (runs, refused) in rows.items():
        pairs = {(line["law"], line["rule"]) for line in runs}
        largest = max((float(line["largest"]) for line in runs), default=math.nan)
        balance = max((abs(float(line["balance"]) - 1.0) for line in runs), default=math.nan)
        yield engine, shear, len(pairs), len(runs), len(refused), largest, balance
