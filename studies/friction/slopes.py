"""Angle of repose of a drained slope, with friction by pressure and constant ones, in LAMMPS.

Grains fall on a rough base between two walls, periodic across; then one wall is removed and what lies above the edge of the
base drains to a lower floor. The slope that remains is measured. All frictions of a seed begin with the same deposit, made
with a constant coefficient. Grains are those of the beds with a hundredth of the modulus of granite, and c2 larger by
100^(2/3).
"""

import shutil
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

import demlaws as dl
from demlaws.lammps.run import HEAD
from studies.assembly.study import append, read
from studies.ballast import bed
from studies.ballast.cycles import simulate
from studies.friction.coefficients import FORCES, POISSON, SETS, YOUNG, Constant, at_mean, read_forces, softer, words
from studies.trade.liggghts_oedometer import data_text

RUNS = Path(__file__).with_name("slopes.csv")
STORE = Path("results") / "friction"
SOFT, COUNT, STEP = 100.0, 520, 5e-5
LENGTH, WIDTH, DROP, AWAY = 0.48, 0.16, 0.3, 0.8
"""Of the base [m]; depth of the lower floor below it, and its length beyond the edge."""
DEPOSITED, FALL, DRAIN = 0.4, 20_000, 36_000
"""Constant coefficient, steps of the deposit, steps after the wall is removed."""
BED = Constant(0.3135)
"""At the mean contact pressure of the beds of spheres with the coefficients of the example, 503 MPa."""
STRIP = 0.04
"""Width of the strips in which the surface is sought [m]."""
FIELDS = ("grains", "seed", "coefficients", "friction", "mu", "mean_MPa", "degrees", "left")
GROUND = """\
{head}boundary        f p f
newton          on
{start}
neighbor        4e-3 bin
neigh_modify    delay 0 exclude type 2 2{exclude}
variable        model string "demlaws/table pair.tbl {young:g} {restitution} {poisson}{more} &
                tangential demlaws 1.0 {friction:g} damping demlaws/tangent"
pair_style      granular
pair_coeff      * * ${{model}}
timestep        {step:g}
group           grains type 1
fix             pull grains gravity 9.81 vector 0 0 -1
fix             back grains wall/gran granular ${{model}} xplane 0.0 NULL
fix             floor grains wall/gran granular ${{model}} zplane -{drop:g} NULL
fix             far grains wall/gran granular ${{model}} xplane NULL {end:g}
fix             move grains {move}
compute         moves grains ke
thermo_style    custom step c_moves
thermo_modify   norm no
thermo          1000
"""
GATE = "fix             gate grains wall/gran granular ${{model}} xplane NULL {:g}\nrun             {}\n"
PLACES = "write_dump      all custom post/{}.txt id type radius x y z modify sort id format float %.9g\n"


def falling(grains, seed):
    """Rows (molecule, type, diameter, density, place) of the base (type 2) and of grains on a shaken lattice above it."""
    random, clumps = np.random.default_rng(seed), grains == "clumps"
    reach = bed.CLUMP_SHARE + bed.CLUMP[0, 0] / 20e-3 if clumps else 1.0
    pitch, wide = 2 * reach * max(bed.RADII) + 0.5e-3, 2.0 * bed.RADII[1]
    across, deep = int(LENGTH / pitch), int(WIDTH / pitch)
    radius, place = random.choice(bed.RADII, COUNT, p=bed.SHARES), np.arange(COUNT)
    centre = np.stack([place % across, place // across % deep, place // (across * deep)], 1) + 0.5
    centre = centre * [LENGTH / across, WIDTH / deep, pitch] + [0.0, 0.0, bed.RADII[1]]
    base = [
        (x, y, -bed.RADII[1] + random.uniform(0.0, 5e-3))
        for x in np.arange(0.5 * wide, LENGTH, wide)
        for y in np.arange(0.5 * wide, WIDTH, wide)
    ]
    rows = [(n, 2, wide, bed.DENSITY, *one) for n, one in enumerate(base, start=1)]
    if clumps:
        turns = Rotation.random(COUNT, random_state=seed).as_matrix()
        places = centre[:, None] + np.einsum("nab,mb->nma", turns, bed.CLUMP) * (radius / 20e-3)[:, None, None]
        size, density, molecule = np.repeat(bed.CLUMP_SHARE * radius, 3), bed.CLUMP_DENSITY, np.repeat(place, 3)
    else:
        places = centre + random.uniform(-1, 1, centre.shape) * (0.5 * pitch - radius)[:, None]
        size, density, molecule = radius, bed.DENSITY, place
    found = zip(molecule + len(base) + 1, 2 * size, places.reshape(-1, 3), strict=True)
    return rows + [(int(n), 1, d, density, *one) for n, d, one in found]


def write_data(path, rows, clumps):
    """The data file of these rows."""
    ends = (-0.05, LENGTH + AWAY + 0.05), (0.0, WIDTH), (-DROP - 0.05, max(row[-1] for row in rows) + 0.1)
    text = data_text(ends, [row[1:] for row in rows], types=2)
    if clumps:
        text += "\nMolecules\n\n" + "".join(f"{n} {row[0]}\n" for n, row in enumerate(rows, start=1))
    Path(path).write_text(text)


def ground(start, friction, clumps):
    """Input up to the motion of the grains."""
    more, mu = words(friction)
    return GROUND.format(
        head=HEAD,
        start=start,
        exclude=" exclude molecule/intra all" * clumps,
        young=YOUNG / SOFT,
        restitution=bed.RESTITUTION,
        poisson=POISSON,
        more=more,
        friction=mu,
        step=STEP,
        drop=DROP,
        end=LENGTH + AWAY,
        move="rigid/small molecule" if clumps else "nve/sphere",
    )


def slope(path):
    """(angle [degrees], share of the spheres that are left) of a dump: of a line through the highest points of strips."""
    rows = np.loadtxt(path, skiprows=9)
    rows = rows[rows[:, 1] == 1]
    on = rows[(rows[:, 3] < LENGTH) & (rows[:, 5] > 0)]
    strips = np.floor(on[:, 3] / STRIP).astype(int), np.floor(on[:, 4] % WIDTH / STRIP).astype(int)
    tops = {}
    for x, y, top in zip(*strips, on[:, 5] + on[:, 2], strict=True):
        tops[x, y] = max(top, tops.get((x, y), 0.0))
    x, z = np.array([((x + 0.5) * STRIP, top) for (x, _), top in tops.items() if 1 <= x < LENGTH / STRIP - 1]).T
    return float(np.degrees(np.arctan(-np.polyfit(x, z, 1)[0]))), len(on) / len(rows)


def run_slope(grains, seed, coefficients="example", path=RUNS, store=STORE, progress=print):
    """Run a seed that `path` lacks with friction by pressure, the constant one of its mean pressure, and BED."""
    there = {(row["grains"], int(row["seed"]), row["coefficients"]) for row in read(path)}
    if (grains, seed, coefficients) in there:
        return
    clumps, by_pressure = grains == "clumps", softer(SETS[coefficients], SOFT)
    modulus, radius = YOUNG / SOFT / (2 * (1 - POISSON**2)), 10e-3 * (bed.CLUMP_SHARE if clumps else 1.0)
    folder = Path(store) / f"slope-{grains}-{seed}"
    shutil.rmtree(folder, ignore_errors=True)
    (folder / "post").mkdir(parents=True)
    dl.law("hertz", dl.Contact(radius, modulus)).tabulate(max_force=1.5e3).save(folder / "pair.tbl")
    write_data(folder / "start.data", falling(grains, seed), clumps)
    text = ground(bed.from_data(clumps), Constant(DEPOSITED), clumps) + GATE.format(LENGTH, FALL)
    simulate(folder, "fall", text + FORCES + "write_restart rest.restart\n")
    mean = at_mean(by_pressure, read_forces(folder / "post" / "forces.txt"), radius, modulus)
    rows = []
    for name, friction in {"pressure": by_pressure, "mean": mean, "bed": BED}.items():
        text = ground(bed.from_restart("rest.restart", clumps), friction, clumps) + f"run {DRAIN}\n" + PLACES.format(name)
        simulate(folder, name, text)
        degrees, left = slope(folder / "post" / f"{name}.txt")
        row = {"grains": grains, "seed": seed, "coefficients": coefficients, "friction": name}
        row |= {"mu": mean.mu if name == "pressure" else friction.mu, "mean_MPa": 1e-6 * mean.pressure * SOFT ** (2 / 3)}
        rows.append(row | {"degrees": degrees, "left": left})
        progress(" ".join(f"{v:.4g}" if isinstance(v, float) else str(v) for v in rows[-1].values()))
    append(path, FIELDS, rows)
