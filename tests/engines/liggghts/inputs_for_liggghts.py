"""Inputs that the tests share."""

import math

PROPERTIES = """\
atom_style      granular
atom_modify     map array
boundary        f f f
newton          off
communicate     single vel yes
units           si
hard_particles  yes
region          box block -0.03 0.03 -0.02 0.02 -0.02 0.02 units box
create_box      2 box
neighbor        1e-4 bin
neigh_modify    delay 0
fix             m1 all property/global youngsModulus peratomtype 60.6e9 60.6e9
fix             m2 all property/global poissonsRatio peratomtype 0.25 0.25
fix             m3 all property/global coefficientRestitution peratomtypepair 2 {e} {e} {e} {e}
fix             m4 all property/global coefficientFriction peratomtypepair 2 0.5 0.5 0.5 0.5
fix             m5 all property/global coefficientRollingFriction peratomtypepair 2 0.1 0.1 0.1 0.1
fix             m6 all property/global coefficientRollingViscousDamping peratomtypepair 2 0.1 0.1 0.1 0.1
fix             m7 all property/global surfaceRoughness peratomtype 1e-6 2e-6
{pair_style}
pair_coeff      * *
timestep        1e-8
create_atoms    1 single 0 0 0 units box
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
thermo_style    custom step v_overlap v_force v_side
thermo_modify   format float %.17e lost ignore norm no
thermo          {every}
"""


def two_spheres(pair_style, moves, d1=17.4e-3, d2=17.4e-3, restitution=1.0, every=20):
    """An input of two spheres of types 1 and 2, 0.1 µm apart; moves: (speed along x, along y, steps) of the second."""
    text = PROPERTIES.format(
        pair_style=pair_style, e=restitution, x=repr(0.5 * (d1 + d2) + 1e-7), d1=repr(d1), d2=repr(d2), every=every
    )
    for along, across, steps in moves:
        text += f"velocity right set {along} {across} 0\nrun {steps}\n"
    return text


def modulus(young=60.6e9, poisson=0.25):
    return young / (2 * (1 - poisson**2))


def sphere_mass(diameter):
    return 2650 * math.pi / 6 * diameter**3
