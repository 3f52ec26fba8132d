"""Inputs that the tests share."""

import math

import pytest

from demlaws.errors import DemlawsError
from demlaws.liggghts.run import HEAD, run

PROPERTIES = (
    HEAD
    + """\
{processors}
region          box block -0.03 0.03 -0.02 0.02 -0.02 0.02 units box
create_box      2 box
neighbor        1e-4 bin
neigh_modify    delay 0 page 400000
fix             m1 all property/global youngsModulus peratomtype {young} {young}
fix             m2 all property/global poissonsRatio peratomtype 0.25 0.25
fix             m3 all property/global coefficientRestitution peratomtypepair 2 {e} {e} {e} {e}
fix             m4 all property/global coefficientFriction peratomtypepair 2 0.5 0.5 0.5 0.5
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
    values = {"pair_style": pair_style, "e": restitution, "every": every, "young": young, "more": more, "columns": columns}
    values |= {"d1": repr(d1), "d2": repr(d2), "left": repr(left), "x": repr(left + 0.5 * (d1 + d2) + 1e-7), "step": step}
    processors = f"processors      {ranks} 1 1" if ranks else ""
    return PROPERTIES.format(**values, processors=processors) + moves_of(moves)


def moves_of(moves):
    return "".join(f"velocity right set {along} {across} 0\nrun {steps}\n" for along, across, steps in moves)


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


def simulate(folder, text, ranks=1, **options):
    (folder / "in.case").write_text(text)
    return run(folder / "in.case", ranks, **options)


def refused(folder, text, ranks=1, **options):
    """Message of LIGGGHTS's own error."""
    with pytest.raises(DemlawsError) as caught:
        simulate(folder, text, ranks, **options)
    assert "ERROR" in str(caught.value)
    return str(caught.value)


def modulus(young=60.6e9, poisson=0.25):
    return young / (2 * (1 - poisson**2))


def sphere_mass(diameter):
    return 2650 * math.pi / 6 * diameter**3


GAS = (
    HEAD
    + """\
processors {ranks} 1 1
region box block -0.001 0.061 -0.001 0.061 -0.001 0.061 units box
create_box 1 box
{common}{places}
set group all diameter 0.0174 density 2650
{velocities}
"""
)
GAS_COMMON = """\
neighbor 0.002 bin
neigh_modify delay 0 page 200000
fix m1 all property/global youngsModulus peratomtype 60.6e9
fix m2 all property/global poissonsRatio peratomtype {poisson}
fix m3 all property/global coefficientRestitution peratomtypepair 1 1.0
fix m4 all property/global coefficientFriction peratomtypepair 1 {friction}
pair_style gran model demlaws/table tangential demlaws table law.tbl shear {shear}
pair_coeff * *
timestep 2e-7
{walls}
fix integr all nve/sphere
{watch}"""
