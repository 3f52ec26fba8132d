"""LAMMPS inputs of two mixtures of large grains and fines: a heap, and an oedometer under cyclic load.

Heap: fines are poured on a bed of large grains in a box, periodic along y; then one wall is removed, and grains that pass its
place are deleted.
Oedometer: a bed, periodic along x and y, under a plate of spheres that move as one. The step is a share of the Rayleigh time of
the fines, as users choose it. All grains have one density, modulus and friction.
"""

from pathlib import Path
from typing import NamedTuple

import numpy as np

import demlaws as dl
from demlaws.lammps.run import HEAD
from studies.trade.liggghts_oedometer import data_text

POISSON, DENSITY, FRICTION, RESTITUTION = 0.3, 2500.0, 0.5, 0.5
LARGE = 10e-3
"""Diameter of a large grain [m]."""
LENGTH, WIDTH = 7 * LARGE, 3 * LARGE
"""Of the heap [m]."""
SIDE = 4 * LARGE
"""Of the oedometer [m]."""
TABLE = "demlaws/table hertz.tbl {young:g} {e} {nu} tangential demlaws 1.0 {mu} damping demlaws/tangent"
STOCK = "hertz/material {young:g} {e} {nu} tangential mindlin NULL 1.0 {mu} damping coeff_restitution"
MODELS = {"before": TABLE, "after": TABLE, "stock": STOCK, "stock synchronized": STOCK}
"""demlaws with the lever of the full step (commit 0ba9c2d4) and of the half step; mindlin of LAMMPS, also with its remedy."""
REMEDY = " synchronized_verlet"
"""Of pairs; LAMMPS's walls refuse the word, and the normal of a plane does not turn."""
GROUND = """\
{head}boundary        {boundary}
newton          off
read_data       start.data
neighbor        {skin:.10g} multi
comm_modify     mode multi
neigh_modify    delay 0 every 1 check yes
group           grains type 1 2
pair_style      granular
pair_coeff      * * {model}{remedy}
timestep        {dt:.10g}
fix             floor grains wall/gran granular {model} zplane 0 NULL
fix             weight grains gravity 9.81 vector 0 0 -1
fix             move grains nve/sphere
"""
WALLS = """\
fix             left all wall/gran granular {model} xplane 0 NULL
fix             right all wall/gran granular {model} xplane NULL {length:.10g}
"""
HEAP = """\
compute         pair all property/local patom1 patom2 cutoff radius
thermo_style    custom step atoms ke
thermo_modify   lost ignore norm no
thermo          {rest}
run             {rest}
{bed}unfix           right
run             {rest}
{heap}"""
LOOKS = """\
dump            grains all custom {every} {name}.grains id type radius x y z
dump            pairs all local {every} {name}.pairs c_pair[1] c_pair[2]
dump_modify     grains format float %.9g sort id
run             {window}
undump          grains
undump          pairs
"""
DEPOSIT = "run             {steps}\n"
PLATE = """\
group           plate type 3
neigh_modify    exclude type 3 3
variable        push equal {force}/count(plate)
fix             straight plate setforce 0 0 NULL
fix             press plate aveforce NULL NULL v_push
fix             sink plate nve
compute         energy grains ke
variable        height equal xcm(plate,z)
variable        moves equal c_energy
thermo_style    custom step v_height v_push v_moves
thermo_modify   norm no format float %.12g
thermo          {every}
run             {steps}
"""
END = "write_dump      all custom end.grains id type radius x y z modify format float %.17g sort id\n"


class Case(NamedTuple):
    """A mixture with a model of shear."""

    ratio: float = 20.0  # of diameters
    model: str = "after"
    seed: int = 1
    share: float = 0.25  # step over the Rayleigh time of the fines
    large: int = 96
    fines: int = 500
    young: float = 5e7  # [Pa]

    @property
    def fine(self):
        """Diameter of a fine grain [m]."""
        return LARGE / self.ratio

    @property
    def dt(self):
        """Step [s]."""
        shear = self.young / (2 * (1 + POISSON))
        return self.share * np.pi * 0.5 * self.fine * np.sqrt(DENSITY / shear) / (0.1631 * POISSON + 0.8766)

    def steps(self, time):
        """Steps of a time [s]."""
        return max(1, round(time / self.dt))

    @property
    def terms(self):
        """Words of the contact model."""
        return MODELS[self.model].format(young=self.young, e=RESTITUTION, nu=POISSON, mu=FRICTION)

    def ground(self, boundary):
        """Input up to the motion of the grains."""
        words = {"head": HEAD, "boundary": boundary, "skin": 0.4 * self.fine, "model": self.terms, "dt": self.dt}
        words["remedy"] = REMEDY if self.model == "stock synchronized" else ""
        return GROUND.format(**words)

    def save_table(self, folder):
        """Write hertz.tbl, which serves all radii."""
        contact = dl.Contact(radius=LARGE / 4, modulus=self.young / (2 * (1 - POISSON**2)))
        dl.law("hertz", contact).tabulate(rtol=1e-5).save(Path(folder) / "hertz.tbl")


def scattered(case, length, width, walls, solid=0.28):
    """Rows (type, diameter, density, place [m]) of grains that do not touch, by random sequential addition above z = 0.

    Periodic along y, and along x unless there are walls. solid: volume share of the large grains.
    """
    random = np.random.default_rng(case.seed)
    height = case.large * np.pi / 6 * LARGE**3 / (solid * length * width)
    periods = np.array([np.inf if walls else length, width, np.inf])
    places, radii = np.empty((0, 3)), np.empty(0)
    for radius in np.repeat([0.5 * LARGE, 0.5 * case.fine], [case.large, case.fines]):
        edge = radius if walls else 0.0
        while True:
            place = random.uniform([edge, 0.0, radius], [length - edge, width, height + radius])
            gap = np.abs(places - place)
            gap = np.minimum(gap, periods - gap)
            if np.all(np.linalg.norm(gap, axis=1) > radii + radius):
                break
        places, radii = np.vstack([places, place]), np.append(radii, radius)
    return [(1 if r == 0.5 * LARGE else 2, 2 * r, DENSITY, *p) for r, p in zip(radii, places, strict=True)]


def poured(case, height):
    """Rows of fines on a shaken lattice above a height [m], in as many layers as they need."""
    random = np.random.default_rng(case.seed)
    pitch = max(1.2 * case.fine, np.sqrt(LENGTH * WIDTH / case.fines))
    across, deep = int(LENGTH / pitch), int(WIDTH / pitch)
    number = np.arange(case.fines)
    place = np.stack([number % across, number // across % deep, number // (across * deep)], 1) + 0.5
    place *= [LENGTH / across, WIDTH / deep, pitch]
    place += random.uniform(-0.5, 0.5, place.shape) * (pitch - case.fine)
    return [(2, case.fine, DENSITY, x, y, height + z) for x, y, z in place.tolist()]


def settled(case, time):
    """{file: text} of large grains that fall into the box of the heap."""
    rows = scattered(case._replace(fines=0), LENGTH, WIDTH, walls=True)
    text = case.ground("f p f") + WALLS.format(model=case.terms, length=LENGTH) + DEPOSIT.format(steps=case.steps(time)) + END
    return {"in.scene": text, "start.data": _data(rows, LENGTH, WIDTH)}


def heap(case, rows, rest, window, looks):
    """{file: text} of fines on the rows of a bed: `rest` [s] until the wall is removed and again until the end.

    looks: at places and contacts, in a window [s] after each.
    """
    every = case.steps(window / looks)
    bed, last = (LOOKS.format(name=name, every=every, window=every * looks) for name in ("bed", "heap"))
    rows = rows + poured(case, max(row[-1] + 0.5 * row[1] for row in rows))
    text = case.ground("f p f") + WALLS.format(model=case.terms, length=LENGTH)
    text += HEAP.format(rest=case.steps(rest), bed=bed, heap=last)
    return {"in.scene": text, "start.data": _data(rows, LENGTH, WIDTH)}


def _data(rows, length, width):
    top = max(row[-1] for row in rows) + 2 * LARGE
    return data_text(((0.0, length), (0.0, width), (-LARGE, top)), rows, types=max(2, *(row[0] for row in rows)))


def plate(height):
    """Rows of the plate, its lowest points at a height [m]: overlapping spheres, so that no fine passes between them."""
    across = np.arange(0.25 * LARGE, SIDE, 0.5 * LARGE)
    return [(3, LARGE, 0.1 * DENSITY, x, y, height + 0.5 * LARGE) for x in across for y in across]


def oedometer(case, rows, steps, force=None, every=None):
    """{file: text} of a bed of these rows; force: on the plate [N], text of a variable's formula; None: no plate."""
    text = DEPOSIT.format(steps=steps) if force is None else PLATE.format(force=force, steps=steps, every=every)
    return {"in.scene": case.ground("p p f") + text + END, "start.data": _data(rows, SIDE, SIDE)}
