"""Prove the plugin on this machine: version, plugin, and contacts on a prescribed path inside LAMMPS."""

import tempfile
from pathlib import Path

import numpy as np

from demlaws.contact import Contact
from demlaws.errors import DemlawsError
from demlaws.lammps.build import build
from demlaws.lammps.run import HEAD, command, executable, run, versions
from demlaws.laws.names import USUAL
from demlaws.make import law as make_law

# load, unload, reload, separate, load again; the speed is along x
MOVES = """\
velocity        right set -0.2 0 0
run             1200
velocity        right set 0.2 0 0
run             600
velocity        right set -0.2 0 0
run             900
velocity        right set 0.2 0 0
run             1800
velocity        right set -0.2 0 0
run             800
"""
_WATCH = """\
group           left id 1
group           right id 2
fix             move all nve/noforce
compute         pull right reduce sum fx
compute         energy all demlaws/energy
compute         contacts all pair/local p13 p14 p15 p16 cutoff radius
compute         kept all reduce sum c_contacts[*] inputs local
thermo_style    custom step v_overlap c_pull c_energy[1] c_energy[2] c_kept[1] c_kept[2] c_kept[3] c_kept[4]
thermo_modify   format float %.17e lost ignore norm no
thermo          ${every}
timestep        5e-8
"""
TWO_PARTICLES = (
    HEAD
    + """\
boundary        f f f
newton          ${newton}
region          box block -0.03 0.03 -0.02 0.02 -0.02 0.02 units box
create_box      1 box
neighbor        1e-4 bin
neigh_modify    delay 0
pair_style      granular
pair_coeff      * * demlaws/table ${table} ${young} 1.0 0.25 tangential mindlin NULL 1.0 0.5 damping demlaws/tangent
variable        gap equal 2*${radius}+1e-7
variable        diameter equal 2*${radius}
create_atoms    1 single 0 0 0 units box
create_atoms    1 single ${gap} 0 0 units box
set             group all diameter ${diameter} density 2650
variable        overlap equal "2*v_radius-(xcm(right,x)-xcm(left,x))"
"""
    + _WATCH
    + MOVES
)
# a sphere against a wall at its left: a plane, or the same plane as a region; the first sphere lies far off
WALL = (
    HEAD
    + """\
boundary        f f f
newton          ${newton}
region          box block -0.01 0.06 -0.03 0.03 -0.03 0.03 units box
create_box      1 box
neighbor        1e-4 bin
neigh_modify    delay 0
pair_style      granular
pair_coeff      * * demlaws/table ${table} ${young} 1.0 0.25 tangential mindlin NULL 1.0 0.5 damping demlaws/tangent
variable        model string &
"granular demlaws/table ${table} ${young} 1.0 0.25 tangential mindlin NULL 1.0 0.5 damping demlaws/tangent"
region          ground plane 0 0 0 1 0 0 units box
if "${wall} == plane" then "fix wall all wall/gran ${model} xplane 0 NULL" &
else "fix wall all wall/gran/region ${model} region ground"
variable        gap equal ${radius}+1e-7
variable        diameter equal 2*${radius}
create_atoms    1 single 0.05 0 0.02 units box
create_atoms    1 single ${gap} 0 0 units box
set             group all diameter ${diameter} density 2650
variable        overlap equal "v_radius-xcm(right,x)"
"""
    + _WATCH
    + MOVES
)


def follow(law, text=TWO_PARTICLES, rtol=1e-5, radius=None, folder=None, ranks=1, every=4, **variables):
    """The log of one contact on the prescribed path inside LAMMPS (columns overlap, pull, energy[1] …), and the law's path.

    law: one contact with ν = 0.25; two equal spheres of `radius` (default: twice the law's) or, with `text=WALL`, a sphere
    of the law's radius and a wall.
    """
    wall = text is WALL
    radius = (1 if wall else 2) * law.contact.radius if radius is None else radius
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(folder or scratch)
        law.tabulate(rtol=rtol).save(folder / "law.tbl")
        (folder / "in.contact").write_text(text)
        young = 2 * law.contact.modulus * (1 - 0.25**2)
        given = {"young": repr(young), "radius": repr(radius), "table": "law.tbl", "newton": "on", "every": every, **variables}
        log = run(folder / "in.contact", ranks, given)
    return log, law.follow(log["overlap"])


def check(report=print):
    """Version, plugin and self-test; prints what it finds, raises DemlawsError at the first thing that fails."""
    version = versions()
    report(f"binary    {executable().path}: LAMMPS {version.date}")
    _, environment = command("in.none")
    way = "LAMMPS_PLUGIN_PATH" if "PLUGIN" in version.packages else "LD_PRELOAD"
    report(f"plugin    {build()} by {way}={environment[way]}")
    contact = Contact(radius=4.35e-3, modulus=32.32e9, roughness=2.40e-6, fractal_dimension=2.22)
    for unloading in ("elastic", "hertz"):
        for rtol, limit in ((1e-5, 1e-5), (1e-9, 1e-8)):
            law = make_law(USUAL, contact, unloading=unloading)
            _compare(report, law, f"two spheres, {unloading} unloading, table {rtol:g}", limit, rtol=rtol)
    law = make_law(USUAL, contact, unloading="hertz")
    for wall in ("plane", "region"):
        _compare(report, law, f"{wall} wall, hertz unloading, table 1e-09", 1e-8, text=WALL, rtol=1e-9, wall=wall)
    report("all good")


def _compare(report, law, what, limit, **options):
    log, path = follow(law, **options)
    worst = float(np.max(np.abs(log["pull"] - path.force)) / np.max(path.force))
    energy = float(
        np.max(np.abs(log["energy[1]"] - path.stored) + np.abs(log["energy[2]"] - path.dissipated)) / np.max(path.work)
    )
    line = f"self-test {what}: |force - law| ≤ {worst:.1e} of {path.force.max():.1f} N, energies ≤ {energy:.1e} of the work"
    if not max(worst, energy) <= limit:
        raise DemlawsError(f"{line}; allowed {limit:g}")
    report(line)
