"""LAMMPS inputs of a bed of granite under a plate: grains are deposited, pressed flat, and loaded in cycles.

The bed is 0.3 m long and wide, periodic, about 0.3 m high, on a rough floor. The plate is as long as the bed and narrower (the
width of a sleeper), rough, and moves vertically. Granite has its full modulus and density: the steps per cycle follow from the
bed's own period over that of a contact, which neither a softer modulus nor heavier grains change.
"""

from pathlib import Path
from typing import NamedTuple

import numpy as np

import demlaws as dl
from demlaws.lammps.run import HEAD
from studies.trade.liggghts_oedometer import data_text

YOUNG, POISSON, DENSITY, FRICTION, RESTITUTION = 60.6e9, 0.25, 2650.0, 0.6, 0.7
RADII, SHARES = (18e-3, 20e-3, 22e-3), (0.3, 0.4, 0.3)
WIDTH, PLATE = 0.3, 0.24  # of the bed and of the plate [m]
NEAR = 0.08  # [m]: only grains that begin so near to the floor or the plate can touch it, which saves a third of the time
FOLLOW = 1200.0  # [1/s], of the force that the plate lacks
SHEAR = {
    "default": ("", "demlaws 1.0"),
    "1 level": (" levels 1", "demlaws 1.0"),
    "slip": (" shear slip", "demlaws 1.0"),
    "mindlin": ("", "mindlin NULL 1.0"),
    "mindlin_rescale": ("", "mindlin_rescale NULL 1.0"),
}
"""Words after the table's numbers, and the tangential model up to its friction."""

GROUND = """\
{head}boundary        p p f
newton          on
{start}
neighbor        2e-3 bin
neigh_modify    delay 0{exclude}
variable        model string "demlaws/table pair.tbl {young:g} {restitution} {poisson}{words} &
                tangential {tangential} {friction:g} damping demlaws/tangent"
pair_style      granular
pair_coeff      * * ${{model}}
timestep        {dt:.10g}
fix             pull all gravity 9.81 vector 0 0 -1
{floor}
{move}
compute         moves all ke
compute         met all contact/atom
compute         contacts all reduce sum c_met
variable        upper atom z+radius
compute         top all reduce max v_upper
"""
LOW = "region          low block INF INF INF INF INF {}\ngroup           low region low\n"
FLOOR = "fix             floor {} wall/gran granular ${{model}} zplane 0.0 NULL"
REST = """\
{drag}
variable        slow equal {rest:g}*mass(all)
variable        energy equal c_moves/v_slow
thermo_style    custom step c_contacts c_top c_moves
thermo_modify   norm no format float %.12g
thermo          2000
fix             rest all halt 2000 v_energy < 1 error continue
run             {steps}
unfix           rest
"""
MOLECULES = "fix             grain all property/atom mol ghost yes"
WRITE = "write_dump      all custom post/{name} id {mol} diameter xu yu zu modify sort id format float %.17g\n"
LOAD = """\
reset_timestep  0
variable        load equal {mean:.17g}-{swing:.17g}*cos({turn:.17g}*step)
variable        plate equal {placed:.17g}-f_drive*step*{dt:.17g}
region          high block INF INF INF INF {near:.10g} INF
group           high region high
region          plate block -{half:g} {half:g} -1 1 {top:.17g} {lid:.17g} side out move NULL NULL v_plate units box
fix             press high wall/gran/region granular ${{model}} region plate contacts
compute         pushed high reduce sum f_press[4]
variable        carried equal -c_pushed
# the plate follows its load by the bed's stiffness, about {stiffness:g} sqrt(load), and by the force it lacks; variables are
# read from text at every step: short formulas save a third of the time
variable        speed equal ({follow:g}*(v_load-v_carried)+{change:.17g}*sin({turn:.17g}*step))/({stiffness:g}*sqrt(v_load+100))
variable        slow equal {most}*atan(v_speed/{most})
fix             drive all ave/time 1 1 1 v_{chosen} ave running
{energies}thermo_style    custom step v_load v_carried v_plate v_speed c_contacts c_moves{columns}
thermo_modify   norm no format float %.12g
thermo          {every}
{until}run             {steps}
"""
ENERGIES = """\
compute         energy all demlaws/energy
variable        stored equal c_energy[1]
variable        dissipated equal c_energy[2]
variable        potential equal 9.81*mass(all)*xcm(all,z)
compute         pair all property/local patom1 patom2 cutoff radius
compute         flow all pair/local p16 cutoff radius
dump            flow all local {every} post/flow.txt c_pair[1] c_pair[2] c_flow
dump_modify     flow format float %.12g
"""
STATE = """\
compute         pair all property/local patom1 patom2 cutoff radius
compute         force all pair/local fx fy fz p13 cutoff radius
write_dump      all custom post/grains.txt id x y z radius mass modify format float %.17g
dump            state all local 1 post/contacts.txt index c_pair[*] c_force[*]
dump_modify     state format float %.17g
run             0
"""
"""Grains and contacts, in the columns that `demlaws timestep` expects, then the largest overlap."""
CARRIED = """\
variable        lacks equal abs(v_load-v_carried)/v_load+1e4*c_moves
fix             rest all halt 500 v_lacks < 0.02 error continue
"""


class Law(NamedTuple):
    """Contact law, combined roughness [µm], shear model and rule of unloading."""

    law: str = "hertz"
    sigma: float = 0.0
    shear: str = "default"
    unloading: str = "hertz"

    def save(self, path):
        """Write its table; one serves all radii."""
        modulus = YOUNG / (2 * (1 - POISSON**2))
        contact = dl.Contact(radius=10e-3, modulus=modulus, sigma=1e-6 * self.sigma, fractal_dimension=2.22)
        rule = {} if self.law == "hertz" else {"unloading": self.unloading}
        dl.law(self.law, contact, **rule).tabulate(rtol=1e-5).save(path)


def from_data(clumps):
    """Lines that read the grains of start.data."""
    return f"{MOLECULES}\nread_data       start.data fix grain NULL Molecules" if clumps else "read_data       start.data"


def from_restart(name, clumps):
    """Lines that read a restart file."""
    return f"read_restart    {name}" + f"\n{MOLECULES}" * clumps


def ground(law, start, dt, friction=FRICTION, clumps=False, settled=True, more=""):
    """Input up to the motion of the grains; settled: they move less than NEAR; `start`: lines that read them.

    more: words of the contact model behind those of the shear model.
    """
    words, tangential = SHEAR[law.shear]
    return GROUND.format(
        head=HEAD,
        start=start,
        exclude=" exclude molecule/intra all" * clumps,
        words=words + more,
        tangential=tangential,
        friction=friction,
        young=YOUNG,
        restitution=RESTITUTION,
        poisson=POISSON,
        dt=dt,
        floor=LOW.format(NEAR) + FLOOR.format("low") if settled else FLOOR.format("all"),
        move="fix             move all " + ("rigid/small molecule" if clumps else "nve/sphere"),
    )


def rest(steps, drag=0.0, slow=1e-10):
    """Until the kinetic energy per mass is below `slow` [J/kg], at most `steps`; drag [kg/s]."""
    return REST.format(rest=slow, steps=steps, drag=f"fix drag all viscous {drag:g}" if drag else "") + "unfix drag\n" * (
        drag > 0
    )


def load(low, high, period, steps, dt, top, placed=0.0, width=PLATE, settled=True, stiffness=9e5, rows=50, energies=False):
    """Pressure on the plate [Pa] from `low` to `high` and back in `period` [s], or constant until it is carried.

    top: height of its lower face [m]. energies: printed too, and the plastic work of pairs is written to post/flow.txt, which
    takes three times as long.
    """
    area, every = width * WIDTH, max(1, round(period / dt / rows))
    mean, swing = 0.5 * (high + low) * area, 0.5 * (high - low) * area
    return LOAD.format(
        mean=mean,
        swing=swing,
        turn=2 * np.pi * dt / period,
        change=swing * 2 * np.pi / period,
        follow=FOLLOW,
        most=0.05,
        chosen="speed" if settled else "slow",
        dt=dt,
        steps=steps,
        top=top,
        lid=top + 0.1,
        near=top - NEAR if settled else 0.0,
        placed=placed,
        half=0.5 * width,
        stiffness=stiffness,
        until=CARRIED if low == high else "",
        every=every,
        energies=ENERGIES.format(every=every) if energies else "",
        columns=" v_stored v_dissipated v_potential" if energies else "",
    )


CLUMP = 11.5e-3 * np.array([[1.0, 0.0, 0.0], [-0.5, 0.75**0.5, 0.0], [-0.5, -(0.75**0.5), 0.0]])
"""Places of the three spheres of a clump [m]; each has CLUMP_SHARE of a grain's radius."""
CLUMP_SHARE = 0.75
CLUMP_DENSITY = 0.863 * DENSITY
"""Of the spheres, which overlap by 14 % of their volume: LAMMPS counts these parts twice."""


def loose(count, seed, clumps=False):
    """Molecule, diameter, density and place of every sphere of grains on a shaken lattice above the floor."""
    random = np.random.default_rng(seed)
    reach = CLUMP_SHARE + CLUMP[0, 0] / 20e-3 if clumps else 1.0
    pitch = 2 * reach * max(RADII) + 0.5e-3
    across = int(WIDTH / pitch)
    radius, place = random.choice(RADII, count, p=SHARES), np.arange(count)
    centre = np.stack([place % across, place // across % across, place // across**2], 1) + 0.5
    centre = centre * [WIDTH / across, WIDTH / across, pitch] - [0.5 * WIDTH, 0.5 * WIDTH, 0.0]
    if clumps:
        from scipy.spatial.transform import Rotation

        turns = Rotation.random(count, random_state=seed).as_matrix()
        places = centre[:, None] + np.einsum("nab,mb->nma", turns, CLUMP) * (radius / 20e-3)[:, None, None]
        size, centre = np.repeat(CLUMP_SHARE * radius, 3), places.reshape(-1, 3)
        return np.column_stack([np.repeat(place + 1, 3), 2 * size, np.full(len(size), CLUMP_DENSITY), centre])
    centre += random.uniform(-1, 1, centre.shape) * (0.5 * pitch - radius)[:, None]
    return np.column_stack([place + 1, 2 * radius, np.full(count, DENSITY), centre])


def write_data(path, grains, clumps=False):
    """A data file of spheres (rows as of `loose`)."""
    side = (-0.5 * WIDTH, 0.5 * WIDTH)
    text = data_text((side, side, (-0.01, grains[:, 5].max() + 0.15)), [(1, *row[1:]) for row in grains], types=1)
    if clumps:
        text += "\nMolecules\n\n" + "".join(f"{n} {int(row[0])}\n" for n, row in enumerate(grains, start=1))
    Path(path).write_text(text)


def read_dump(path):
    """Rows as of `loose` of a dump."""
    rows = np.loadtxt(path, skiprows=9)
    clumps = rows.shape[1] == 6
    density = np.full(len(rows), CLUMP_DENSITY if clumps else DENSITY)
    return np.column_stack([rows[:, int(clumps)], rows[:, -4], density, rows[:, -3:]])
