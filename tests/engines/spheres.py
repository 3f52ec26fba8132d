"""Two spheres, and a box of 27, in LIGGGHTS and in LAMMPS from one description: what both plugins do is one test for both."""

import inputs_for_lammps
import inputs_for_liggghts
import numpy as np
import pytest
from inputs import LOAD_UNLOAD, modulus, moves_of

import demlaws as dl
from demlaws.shear import sheared

ENGINES = ("liggghts", "lammps")
both = pytest.mark.parametrize("engine", ENGINES)
DIAMETER, STEP = 17.4e-3, 5e-8
ROUGH = dl.Contact(radius=4.35e-3, modulus=modulus(), roughness=2.4e-6, fractal_dimension=2.22)
LAWS = {
    "hertz elastic": ("hertz", "elastic"),
    "rough elastic": ("pohrt-popov", "elastic"),
    "rough": ("pohrt-popov", "hertz"),
    "thornton": ("pohrt-popov", "thornton"),
    "yielded": ("jackson-green", "etsion", {"yield_strength": 4e9}),
}
"""Laws whose contacts are sheared."""
RATIO = 2 * (1 - 0.25) / (2 - 0.25)
SHEARED = [(-0.2, 0, 600), (0, 0.05, 300), (-0.2, 0.02, 300), (0.2, 0.03, 360), (0, -0.08, 800), (-0.2, 0, 200)]
"""Press, slide partly, press on, lift off partly, slide back past Coulomb's limit, press, slide."""
WATCH = """\
compute er all erotate/sphere
compute en all demlaws/energy
variable spin equal c_er
variable x1 equal x[1]
thermo_style custom step ke v_spin c_en[1] c_en[2] v_x1
thermo_modify norm no lost error format float %.17e
thermo 5000
"""


def save_law(folder, name):
    """One of LAWS of a rough contact; its table is law.tbl."""
    law, rule, *options = LAWS[name]
    law = dl.law(law, ROUGH, rule, **(options[0] if options else {}))
    law.tabulate(rtol=1e-6, max_force=3e4).save(folder / "law.tbl")
    return law


def sheared_along(law, log, shear, every=2):
    """Paths of the sheared and of the normal contact at the rows of a log of SHEARED, displacements, and which rows count."""
    kept = np.append(np.diff(log["Step"]) > 0, True)  # each run begins with the last line of the one before
    across = np.concatenate([[0.0], *[np.full(steps // every, speed * every * STEP) for _, speed, steps in SHEARED]]).cumsum()
    overlap = log["overlap"][kept]
    return sheared(law, overlap, across, RATIO, shear.split()[0], 0.5, 2000), law.follow(overlap), across, kept


def spheres(
    engine, words="", moves=LOAD_UNLOAD, d1=DIAMETER, d2=DIAMETER, restitution=1.0, table="law.tbl", young=60.6e9, **more
):
    """An input of two spheres whose contact is read from a table; words: settings of demlaws/table that both engines have."""
    if engine == "lammps":
        line = f"demlaws/table {table} {young!r} {restitution} 0.25 {words} {inputs_for_lammps.SHEAR}"
        more.pop("ranks", None)
        return inputs_for_lammps.two_spheres(line, moves, d1, d2, **more)
    style = f"pair_style gran model demlaws/table tangential demlaws table {table} {words}"
    more = {"step": STEP, **more}
    return inputs_for_liggghts.two_spheres(style, moves, d1, d2, restitution, young=young, **more)


def continued(engine, text, moves, **watch):
    """The input that goes on from now.restart as `text` did."""
    if engine == "lammps":
        return inputs_for_lammps.continued(moves, **watch)
    return "".join(line for line in inputs_for_liggghts.again(text).splitlines(True) if "run " not in line) + moves_of(moves)


def gas(engine, friction, shear, poisson=0.25, ranks=1, newton="on"):
    """Whole start of a closed box of 27 spheres without damping, and what a run that goes on from its restart file needs."""
    # one by one: LIGGGHTS's `create_atoms region` gives other numbers on two ranks
    places = "\n".join(
        f"create_atoms 1 single {x:.2f} {y:.2f} {z:.2f} units box" for x, y, z in 0.01 + 0.02 * np.argwhere(np.ones((3, 3, 3)))
    )
    random = np.random.default_rng(3)
    velocities = "\n".join(
        f"set atom {i + 1} vx {v[0]:.6f} vy {v[1]:.6f} vz {v[2]:.6f}" for i, v in enumerate(random.normal(0, 0.3, (27, 3)))
    )
    values = {"places": places, "velocities": velocities, "ranks": ranks, "newton": newton}
    if engine == "lammps":
        terms = f"demlaws/table law.tbl 60.6e9 0 {poisson} shear {shear} tangential demlaws 0.0 {friction} damping velocity"
        walls = "\n".join(f"fix {a} all wall/gran granular {terms} {a}plane 0.0 0.06" for a in "xyz")
        common = inputs_for_lammps.GAS_COMMON.format(walls=walls, watch=WATCH)
        return inputs_for_lammps.GAS.format(**values, terms=terms, common=common), "neighbor 0.002 bin\n" + common
    model = "wall/gran model demlaws/table tangential demlaws primitive type 1"
    walls = "\n".join(f"fix {a}{n} all {model} {a}plane {place}" for a in "xyz" for n, place in enumerate((0.0, 0.06)))
    properties = inputs_for_liggghts.properties(friction=friction, poisson=poisson)
    common = inputs_for_liggghts.GAS_COMMON.format(properties=properties, shear=shear, walls=walls, watch=WATCH)
    return inputs_for_liggghts.GAS.format(**values, common=common), common
