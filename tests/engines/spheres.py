"""Two spheres, and a box of 27, in LIGGGHTS and in LAMMPS from one description: what both plugins do is one test for both."""

import inputs_for_lammps
import inputs_for_liggghts
import numpy as np
import pytest
from inputs import ENERGY, LOAD_UNLOAD, modulus, moves_of, simulate

import demlaws as dl
from demlaws.core.shear import SPRINGS
from demlaws.shear import sheared
from studies.shear.gas import scene

ENGINES = ("liggghts", "lammps")
both = pytest.mark.parametrize("engine", ENGINES)
DIAMETER, STEP = 17.4e-3, 5e-8
ROUGH = dl.Contact(radius=4.35e-3, modulus=modulus(), sigma=2.4e-6, fractal_dimension=2.22)
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


def save_law(folder, name):
    """One of LAWS of a rough contact; its table is law.tbl."""
    law, rule, *options = LAWS[name]
    law = dl.law(law, ROUGH, rule, **(options[0] if options else {}))
    law.tabulate(rtol=1e-6, max_force=3e4).save(folder / "law.tbl")
    return law


def sheared_along(law, log, shear, every=2):
    """Paths of the sheared and of the normal contact at the rows of a log of SHEARED, displacements, and which rows count.

    Of as many springs as the engine has.
    """
    springs = int(shear.split()[-1]) if "springs" in shear else SPRINGS
    kept = np.append(np.diff(log["Step"]) > 0, True)  # each run begins with the last line of the one before
    across = np.concatenate([[0.0], *[np.full(steps // every, speed * every * STEP) for _, speed, steps in SHEARED]]).cumsum()
    overlap = log["overlap"][kept]
    return (
        sheared(law, overlap, across, RATIO, shear.split()[0], friction=0.5, springs=springs),
        law.follow(overlap),
        across,
        kept,
    )


def spheres(
    engine, words="", moves=LOAD_UNLOAD, d1=DIAMETER, d2=DIAMETER, restitution=1.0, table="law.tbl", young=60.6e9, **more
):
    """An input of two spheres whose contact is read from a table; words: settings of demlaws/table that both engines have."""
    if engine == "lammps":
        line = f"demlaws/table {table} {young!r} {restitution} 0.25 {words} {inputs_for_lammps.SHEAR}"
        more.pop("ranks", None)
        return inputs_for_lammps.two_spheres(line, moves, d1=d1, d2=d2, **more)
    style = f"pair_style gran model demlaws/table tangential demlaws table {table} {words}"
    more = {"step": STEP, **more}
    return inputs_for_liggghts.two_spheres(style, moves, restitution, young=young, d1=d1, d2=d2, **more)


def continued(engine, text, moves, **watch):
    """The input that goes on from now.restart as `text` did."""
    if engine == "lammps":
        return inputs_for_lammps.continued(moves, **watch)
    return "".join(line for line in inputs_for_liggghts.again(text).splitlines(True) if "run " not in line) + moves_of(moves)


def assert_goes_on(engine, folder, text, moves, ranks, **watch):
    """A restart file is written before `moves`: new processes, on as many ranks and on one, go on to the last bits."""
    whole = simulate(engine, folder, text + "write_restart now.restart\n" + moves_of(moves), ranks)
    for later in {1, ranks}:
        again = text.replace(f"{ranks} 1 1", f"{later} 1 1")
        rest = simulate(engine, folder, continued(engine, again, moves, **watch, **ENERGY), later)
        rows = np.isin(whole["Step"], rest["Step"])
        assert rest["Step"].size == rows.sum() > 100
        for column in ("force", "side", "e[1]", "e[2]"):
            scale = np.abs(whole[column]).max()
            np.testing.assert_allclose(rest[column], whole[column][rows], rtol=1e-12, atol=1e-12 * scale, err_msg=column)
    return whole, rest


def gas(engine, friction, shear, **more):
    """A closed box of 27 spheres without damping: spheres, pair style, and all else but `run`."""
    options = {"words": f"shear {shear}", "tables": ["law.tbl"] * 2, "side": 3, "step": 2e-7, "every": 5000}
    return scene(engine, "demlaws", friction=friction, **options, **more)
