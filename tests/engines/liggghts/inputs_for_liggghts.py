"""Inputs that the tests share."""

import functools

import inputs
from inputs import moves_of

from demlaws.liggghts.run import HEAD

simulate = functools.partial(inputs.simulate, "liggghts")
refused = functools.partial(inputs.refused, "liggghts")

PROPERTIES = (
    HEAD
    + """\
{processors}
region          box block -0.03 0.03 -0.02 0.02 -0.02 0.02 units box
create_box      2 box
neighbor        1e-4 bin
neigh_modify    delay 0 page 400000
{properties}
fix             m5 all property/global coefficientRollingFriction peratomtypepair 2 0.1 0.1 0.1 0.1
fix             m6 all property/global coefficientRollingViscousDamping peratomtypepair 2 0.1 0.1 0.1 0.1
fix             m7 all property/global surfaceRoughness peratomtype 1e-6 2e-6
{pair_style}
pair_coeff      * *
timestep        {step}
create_atoms    1 single {left} 0 0 units box
create_atoms    2 single {x} 0 0 units box
set             atom 1 diameter {d1} density 2650
set             atom 2 diameter {d2} density 2650
group           left id 1
group           right id 2
fix             move all nve/noforce
variable        overlap equal "0.5*({d1}+{d2})-(xcm(right,x)-xcm(left,x))"
compute         pull right reduce sum fx
variable        force equal c_pull
compute         side right reduce sum fy
variable        side equal c_side
{more}
thermo_style    custom step v_overlap v_force v_side {columns}
thermo_modify   format float %.17e lost ignore norm no
thermo          {every}
"""
)


def properties(types=1, young=60.6e9, restitution=1.0, friction=0.5, poisson=0.25):
    """Lines of the material properties, the same for all types."""
    names = "youngsModulus", "poissonsRatio", "coefficientRestitution", "coefficientFriction"
    values = [f"peratomtype{f' {value!r}' * types}" for value in (young, poisson)]
    values += [f"peratomtypepair {types}{f' {value!r}' * types**2}" for value in (restitution, friction)]
    lines = zip(names, values, strict=True)
    return "\n".join(f"fix m{n} all property/global {name} {value}" for n, (name, value) in enumerate(lines, 1))


def two_spheres(
    pair_style,
    moves,
    d1=17.4e-3,
    d2=17.4e-3,
    restitution=1.0,
    every=20,
    step=1e-8,
    left=0.0,
    young=60.6e9,
    ranks=None,
    more="",
    columns="",
):
    """An input of two spheres of types 1 and 2, 0.1 µm apart; moves: (speed along x, along y, steps) of the second."""
    values = {"pair_style": pair_style, "properties": properties(2, young, restitution), "every": every}
    values |= {"more": more, "columns": columns}
    values |= {"d1": repr(d1), "d2": repr(d2), "left": repr(left), "x": repr(left + 0.5 * (d1 + d2) + 1e-7), "step": step}
    processors = f"processors      {ranks} 1 1" if ranks else ""
    return PROPERTIES.format(**values, processors=processors) + moves_of(moves)


def again(text, restart="now.restart", change=()):
    """The input that reads the restart file in place of making particles; changes: (old, new) of its text."""
    left_out = ("create_", "set ", "region ", "velocity ", "write_restart")
    lines = [line for line in text.splitlines() if not line.startswith(left_out)]
    lines.insert(next(i for i, line in enumerate(lines) if line.startswith("neighbor")), f"read_restart {restart}")
    out = "\n".join(lines) + "\n"
    for old, new in change:
        assert old in out
        out = out.replace(old, new)
    return out
