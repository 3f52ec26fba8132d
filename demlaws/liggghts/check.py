"""Prove the plugin on this machine: versions, build, and two particles pressed together inside LIGGGHTS."""

from demlaws.liggghts.build import build, engine_library, headers
from demlaws.liggghts.run import ENGINE, HEAD, built_in, executable, versions
from demlaws.plugins.engines import laws_to_check, moves, self_test

_PARTICLES = """\
processors      1 1 1
region          box block -0.03 0.03 -0.02 0.02 -0.02 0.02 units box
create_box      1 box
neighbor        1e-4 bin
neigh_modify    delay 0
fix             m1 all property/global youngsModulus peratomtype ${young}
fix             m2 all property/global poissonsRatio peratomtype 0.25
fix             m3 all property/global coefficientRestitution peratomtypepair 1 1.0
fix             m4 all property/global coefficientFriction peratomtypepair 1 0.5
pair_style      gran model demlaws/table tangential history table ${table}
pair_coeff      * *
timestep        1e-8
create_atoms    1 single 0 0 0 units box
variable        gap equal 2*${radius}+1e-7
variable        diameter equal 2*${radius}
create_atoms    1 single ${gap} 0 0 units box
set             group all diameter ${diameter} density 2650
group           left id 1
group           right id 2
fix             move all nve/noforce
variable        overlap equal "2*v_radius-(xcm(right,x)-xcm(left,x))"
compute         pull right reduce sum fx
variable        force equal c_pull
thermo_style    custom step v_overlap v_force
thermo_modify   format float %.17e lost ignore norm no
thermo          20
"""
TWO_PARTICLES = HEAD + _PARTICLES + moves(1e-8)
_ENERGIES = """\
compute         energy all demlaws/energy
variable        stored equal c_energy[1]
variable        lost equal c_energy[2]
thermo_style    custom step v_overlap v_force v_stored v_lost
"""
WITH_ENERGIES = TWO_PARTICLES.replace("thermo_style    custom step v_overlap v_force\n", _ENERGIES)


def run_path(law, text=WITH_ENERGIES, **options):
    """See `plugins.engines.Engine.run_path`."""
    return ENGINE.run_path(law, text, **options)


def check(report=print):
    """Versions, build and self-test; prints the results, raises DemlawsError at the first failure."""
    report(f"binary    {executable()}: {versions()}")
    if built_in():
        report("models    built into LIGGGHTS: no plugin is loaded")
    else:
        report(f"library   {engine_library()}, headers {headers()}")
        report(f"plugin    {build()}")
    for law, rtol, limit, name in laws_to_check():
        self_test(report, *run_path(law, rtol=rtol), name, limit)
    report("all good")
