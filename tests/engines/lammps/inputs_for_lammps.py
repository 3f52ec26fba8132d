"""Inputs that the tests share."""

import functools

import inputs
from inputs import moves_of

from demlaws.lammps.run import HEAD

simulate = functools.partial(inputs.simulate, "lammps")
refused = functools.partial(inputs.refused, "lammps")

SHEAR = "tangential demlaws 1.0 0.5 damping demlaws/tangent"
TABLE = f"demlaws/table law.tbl 60.6e9 1.0 0.25 {SHEAR}"
STOCK = "hertz/material 60.6e9 1.0 0.25 tangential mindlin NULL 1.0 0.5 damping viscoelastic"

SCENE = """\
boundary        f f f
newton          {newton}
region          box block -0.03 0.03 -0.02 0.02 -0.02 0.02 units box
create_box      2 box
neighbor        1e-4 bin
neigh_modify    delay 0
pair_style      granular
{coefficients}
timestep        5e-8
create_atoms    1 single {x1} 0 0 units box
create_atoms    2 single {x2} 0 0 units box
set             atom 1 diameter {d1} density 2650
set             atom 2 diameter {d2} density 2650
"""
WATCH = """\
group           left id 1
group           right id 2
fix             move all nve/noforce
variable        overlap equal "0.5*({d1}+{d2})-(xcm(right,x)-xcm(left,x))"
compute         pull right reduce sum fx fy
variable        force equal c_pull[1]
variable        side equal c_pull[2]
{more}
thermo_style    custom step v_overlap v_force v_side {columns}
thermo_modify   format float %.17e lost ignore norm no
thermo          {every}
"""


def two_spheres(coefficients, moves, d1=17.4e-3, d2=17.4e-3, every=20, newton="on", more="", columns="", left=0.0, head=HEAD):
    """An input of two spheres of types 1 and 2, 0.1 µm apart; moves: (speed along x, along y, steps) of the second.

    coefficients: pair_coeff lines, or the words of one for all types.
    """
    if not coefficients.startswith(("pair_", "suffix")):
        coefficients = f"pair_coeff * * {coefficients}"
    x2 = left + 0.5 * (d1 + d2) + 1e-7
    values = {"newton": newton, "coefficients": coefficients, "x1": repr(left), "x2": repr(x2), "d1": repr(d1), "d2": repr(d2)}
    return head + SCENE.format(**values) + WATCH.format(**values, more=more, columns=columns, every=every) + moves_of(moves)


def continued(moves, file="now.restart", again="", every=20, more="", columns="", d1=17.4e-3, d2=17.4e-3):
    """The input that goes on from a restart file of `two_spheres`; again: lines after read_restart."""
    lines = f"read_restart    {file}\nneighbor        1e-4 bin\nneigh_modify    delay 0\n{again}\ntimestep        5e-8\n"
    watch = WATCH.format(d1=repr(d1), d2=repr(d2), more=more, columns=columns, every=every)
    return "comm_modify     vel yes\n" + lines + watch + moves_of(moves)
