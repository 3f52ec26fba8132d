"""Simple shear of 330 spheres between two rough plates at three normal stresses: friction by pressure beside constant friction.

A packing is pressed at each stress once and then sheared with every friction, so that runs of one packing are pairs.
Frictions: `pressure`; `mean`: constant, that of the mean pressure of the contacts (by force) of the pressed packing at this
stress; `one`: constant, that of the middle stress at all of them. Grains have a hundredth of the modulus of granite.
"""

import csv
import tempfile
from pathlib import Path

import numpy as np

import demlaws as dl
from demlaws.lammps.run import HEAD, run
from studies.friction.coefficients import POISSON, SETS, YOUNG, Constant, at_mean, read_forces, softer, words
from studies.paired import change, clear, interval

RUNS = Path(__file__).with_name("shear.csv")
RADIUS, SOFT, SIDE, LAYERS = 0.02, 100.0, 6, 9
STRESSES = (20e3, 60e3, 200e3)  # [Pa]
MODULUS = YOUNG / SOFT / (2 * (1 - POISSON**2))
FRICTION = softer(SETS["assumed"], SOFT)
FRICTIONS = ("pressure", "mean", "one")
STEP, SPEED, SETTLE, SHEAR, SLOW = 2e-5, 0.1, 30000, 40000, 20.0
SCENE = """{head}boundary p p f
newton off
region box block 0 {side!r} 0 {side!r} -0.05 {height!r}
create_box 3 box
{atoms}
group bottom type 2
group top type 3
group grains type 1
neighbor 0.004 bin
pair_style granular
{pair}
timestep {step!r}
"""
MOVE = """fix walls bottom setforce 0 0 0
fix slow top viscous {slow!r}
fix press top aveforce NULL NULL {push!r}
fix drag top setforce 0 0 NULL
fix move all nve/sphere
velocity bottom set 0 0 0
compute f all pair/local force
variable height equal xcm(top,z)
thermo_style custom step f_drag[1] v_height
thermo_modify format float %.9e norm no lost error
thermo 200
"""


def pair(friction):
    """The line of the contact model."""
    more, mu = words(friction)
    table = f"demlaws/table law.tbl {YOUNG / SOFT!r} 0.5 {POISSON}{more}"
    return f"pair_coeff * * {table} tangential demlaws 1 {mu!r} damping demlaws/tangent\n"


def packing(seed):
    """Lines that create the grains on a loose lattice with frozen plates below and above."""
    random, pitch = np.random.default_rng(seed), 2.2 * RADIUS
    lines = []
    for layer in range(LAYERS + 2):
        kind = 2 if layer == 0 else 3 if layer == LAYERS + 1 else 1
        for i in range(SIDE):
            for j in range(SIDE):
                jitter = random.uniform(-0.04, 0.04, 3) * pitch * (kind == 1)
                x, y, z = np.array([i + 0.5, j + 0.5, layer]) * pitch + jitter
                diameter = 2.0 * RADIUS * (random.uniform(0.9, 1.1) if kind == 1 else 1.0)  # a plate moves as one
                lines.append(f"create_atoms {kind} single {x:.9g} {y:.9g} {z:.9g}")
                lines.append(f"set atom {len(lines) // 2 + 1} diameter {diameter:.9g} density 2650")
    return "\n".join(lines), SIDE * pitch


def sheared(seed, stress):
    """Rows (seed, stress, friction, μ of a constant one, stress ratio, change of height over that of the pressed packing)."""
    atoms, side = packing(seed)
    push = -stress * side**2 / SIDE**2
    common = {"head": HEAD, "side": side, "height": 0.05 + (LAYERS + 2) * 2.2 * RADIUS, "step": STEP}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        dl.law("hertz", dl.Contact(RADIUS / 2, MODULUS)).tabulate(max_force=3e4).save(folder / "law.tbl")
        scene = SCENE.format(atoms=atoms, pair=pair(Constant(0.3)), **common)
        moving = MOVE.format(push=push, slow=SLOW)
        dump = "dump d all local 1 contacts.txt c_f\nrun 0 post no\nundump d\n"
        (folder / "in.press").write_text(scene + moving + f"run {SETTLE}\n{dump}write_restart pressed.rst\n")
        run(folder / "in.press")
        mean = at_mean(FRICTION, read_forces(folder / "contacts.txt"), RADIUS / 2, MODULUS)
        rows = []
        for friction, chosen in zip(FRICTIONS, (FRICTION, mean, MIDDLE), strict=True):
            text = f"comm_modify vel yes\nread_restart pressed.rst\npair_style granular\n{pair(chosen)}timestep {STEP!r}\n"
            text += moving + f"velocity top set {SPEED} 0 NULL\nrun {SHEAR}\n"
            (folder / "in.shear").write_text(text)
            log = run(folder / "in.shear")
            late = log["Step"] > log["Step"][0] + SHEAR // 2
            drag = -float(np.mean(log["drag[1]"][late])) - SIDE**2 * SLOW * SPEED  # without that of `fix viscous`
            ratio = drag / (stress * side**2)
            grown = float(log["height"][-1] / log["height"][0] - 1.0)
            rows.append((seed, stress, friction, mean.mu, ratio, grown))
            print(*rows[-1], flush=True)
        return rows


MIDDLE = at_mean(FRICTION, np.array([STRESSES[1] * (2.2 * RADIUS) ** 2]), RADIUS / 2, MODULUS)
"""Constant friction `one`: of a contact that carries what a grain of the plate carries at the middle stress."""


def make(packings):
    """Make the runs of so many packings again."""
    rows = [row for seed in range(packings) for stress in STRESSES for row in sheared(seed, stress)]
    with open(RUNS, "w", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows([("seed", "stress", "friction", "mean_mu", "ratio", "dilation"), *rows])


def read():
    """{(seed, stress, friction): (μ at the mean pressure, stress ratio)} of the stored runs."""
    with open(RUNS, newline="") as file:
        rows = list(csv.DictReader(file))
    return {(int(r["seed"]), float(r["stress"]), r["friction"]): (float(r["mean_mu"]), float(r["ratio"])) for r in rows}


def effects():
    """(stress, former friction) → `Estimate` of the change of the stress ratio to friction by pressure, of pairs."""
    runs, found = read(), {}
    seeds = sorted({seed for seed, _, _ in runs})
    for stress in STRESSES:
        for former in FRICTIONS[1:]:
            before, after = ([runs[seed, stress, name][1] for seed in seeds] for name in (former, "pressure"))
            found[stress, former] = change(before, after)
    return found


def table():
    """The table as text."""
    runs, found = read(), effects()
    which = dict(zip(found, clear(found.values()), strict=True))
    lines = ["stress (kPa)  μ at mean p  τ/σ of pressure (95 %)      change against mean, one (95 %; *: clear)"]
    for stress in STRESSES:
        ratios = [value[1] for (_, at, name), value in runs.items() if at == stress and name == "pressure"]
        mu = np.mean([value[0] for (_, at, name), value in runs.items() if at == stress and name == "pressure"])
        mean = interval(ratios)
        parts = [
            f"{100 * e.mean:+.1f} % ({100 * e.low:+.1f} to {100 * e.high:+.1f}){'*' if which[stress, name] else ' '}"
            for (at, name), e in found.items()
            if at == stress
        ]
        lines.append(
            f"{1e-3 * stress:8.0f} {mu:12.3f} {mean.mean:10.3f} ({mean.low:.3f} to {mean.high:.3f})   {'  '.join(parts)}"
        )
    return "\n".join(lines)
