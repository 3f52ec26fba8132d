"""Prove the plugin on this machine: versions, build, and two particles pressed together inside LIGGGHTS."""

import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from demlaws.contact import Contact
from demlaws.errors import DemlawsError
from demlaws.laws.names import USUAL
from demlaws.liggghts.build import PACKAGES, build, engine_library, headers, packaged
from demlaws.liggghts.run import HEAD, executable, run, versions
from demlaws.make import law as make_law

# two spheres at prescribed approach: load, unload, reload, separate, load again
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
velocity        right set -0.2 0 0
run             6000
velocity        right set 0.2 0 0
run             3000
velocity        right set -0.2 0 0
run             4500
velocity        right set 0.2 0 0
run             9000
velocity        right set -0.2 0 0
run             4000
"""
TWO_PARTICLES = HEAD + _PARTICLES


def packages():
    """Debian's versions of the binary, library and headers; raises where they differ."""
    if not shutil.which("dpkg-query"):
        return {}
    names = ("liggghts", "libliggghts[0-9]*", "libliggghts-dev")  # libliggghts3, since Debian 13 libliggghts3t64
    out = subprocess.run(["dpkg-query", "-W", "-f", "${Package} ${Version}\n", *names], capture_output=True, text=True).stdout
    found = dict(line.split() for line in out.splitlines() if len(line.split()) == 2)
    if len(set(found.values())) > 1:
        raise DemlawsError(f"binary, library and headers differ in version: {found}; {PACKAGES}")
    return found


def two_particles(law, rtol=1e-5, radius=None, folder=None, ranks=1):
    """Force along a load–unload–reload–separate–load path in LIGGGHTS and of the law: (overlap, LIGGGHTS, law) arrays.

    law: one contact with a hertz-like or rough law of two equal spheres (effective radius radius/2, ν = 0.25).
    """
    radius = 2 * law.contact.radius if radius is None else radius
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(folder or scratch)
        law.tabulate(rtol=rtol).save(folder / "law.tbl")
        (folder / "in.two_particles").write_text(TWO_PARTICLES)
        young = 2 * law.contact.modulus * (1 - 0.25**2)
        log = run(folder / "in.two_particles", ranks, {"young": repr(young), "radius": repr(radius), "table": "law.tbl"})
    overlap, force = log["overlap"], log["force"]
    return overlap, force, law.follow(overlap).force


def check(report=print):
    """Versions, build and self-test; prints what it finds, raises DemlawsError at the first thing that fails."""
    report(f"binary    {executable()}: {versions()}")
    library = engine_library()
    if packaged(library):
        for name, version in packages().items():
            report(f"package   {name} {version}")
    else:
        report(f"library   {library}, headers {headers()}")
    report(f"plugin    {build()}")
    contact = Contact(radius=4.35e-3, modulus=32.32e9, roughness=2.40e-6, fractal_dimension=2.22)
    for unloading in ("elastic", "hertz"):
        for rtol, limit in ((1e-5, 1e-5), (1e-9, 1e-8)):
            law = make_law(USUAL, contact, unloading=unloading)
            _, force, expected = two_particles(law, rtol)
            worst = float(np.max(np.abs(force - expected)) / np.max(expected))
            line = (
                f"self-test pohrt-popov, {unloading} unloading, table {rtol:g}: "
                f"|force - law| ≤ {worst:.1e} of {expected.max():.1f} N"
            )
            if not worst <= limit:
                raise DemlawsError(f"{line}; allowed {limit:g}")
            report(line)
    report("all good")
