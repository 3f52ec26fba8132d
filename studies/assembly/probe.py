"""Moduli by small strains, beside those of the linearised stiffness of the same contacts; rows in `probes.csv`.

Spheres are strained in LAMMPS, clumps by `march`. With fix rigid/small LAMMPS gives 13 % less for M and 24 % less for G of
clumps, most likely because the velocities of a clump across a face of the box lack the share of fix deform.
"""

import tempfile
from pathlib import Path
from typing import NamedTuple

import numpy as np

from demlaws.errors import quiet
from demlaws.files import csv_text
from demlaws.lammps import run
from demlaws.lammps.run import HEAD
from demlaws.laws import POHRT_POPOV
from studies.assembly.packing import Contacts
from studies.assembly.stiffness import Linear
from studies.assembly.study import BEADS, CLUMPS, HERE, STORE, Series, append, begin, read
from studies.trade.liggghts_oedometer import data_text

STRAIN = {"M": ("z", 3, (2, 2)), "G": ("xz", 5, (0, 2))}
"""Axis of fix deform, number of the stress, component of the strain."""
START = """\
boundary        p p p
newton          on
read_data       start.data
change_box      all triclinic
neighbor        {skin:.10g} bin
neigh_modify    delay 0
pair_style      granular
pair_coeff      * * demlaws/table pair.tbl {young:.10g} 0 {poisson} tangential demlaws 0 {friction:g} damping velocity
timestep        {dt:.10g}
fix             move all nve/sphere
fix             drag all viscous {drag:.10g}
fix             turn all viscous/sphere {turn:.10g}
compute         press all pressure NULL virial
thermo_style    custom step c_press[1] c_press[2] c_press[3] c_press[4] c_press[5] c_press[6] ke
thermo_modify   norm no lost error format float %.17g
thermo          {rest}
run             {rest}
compute         where all property/local patom1 patom2 cutoff radius
dump            places all custom 1 post/places.txt id x y z
dump_modify     places sort id format float %.17g
run             0
undump          places
"""
PUSH = """\
fix             strain all deform 1 {axis} erate {rate:.10g} units box remap v
run             {steps}
unfix           strain
run             {rest}
"""


class Probe(NamedTuple):
    """A modulus [Pa] by a strain, and of the linearised stiffness without and with the terms of the forces carried."""

    engine: float
    linear: float
    exact: float


def contacts_of(places, size, diameter, law):
    """`Contacts` of spheres at these places under an elastic law."""
    from scipy.spatial import cKDTree

    inside = places - size * np.floor(places / size)
    pairs = cKDTree(inside, boxsize=size).query_pairs(diameter, output_type="ndarray")
    apart = inside[pairs[:, 1]] - inside[pairs[:, 0]]
    apart -= size * np.rint(apart / size)
    distance = np.linalg.norm(apart, axis=1)
    overlap = diameter - distance
    stiffness = law.stiffness(overlap)
    return Contacts(pairs, apart / distance[:, None], distance, law.force(overlap), stiffness, stiffness, np.zeros(len(pairs)))


def probe(series, packing, strains=(1e-6, 1e-5), rest=6000, steps=2000):
    """(modulus, strain) → `Probe` of a packing at rest without shear forces; friction is so high that nothing slides."""
    bead, law, size = BEADS[series.bead], series.bound(), packing.size
    frequency = np.sqrt(packing.results[5] / bead.mass)
    values = {
        "skin": 0.05 * bead.diameter,
        "young": bead.young,
        "poisson": bead.poisson,
        "friction": 1e9,
        "dt": 0.2 / frequency,
        "drag": 0.1 * bead.mass * frequency,
        "turn": 0.1 * bead.mass * frequency * bead.diameter**2 / 10.0,
        "rest": rest,
    }
    text, order = HEAD + START.format(**values), []
    for name, (axis, _, _) in STRAIN.items():
        for strain in strains:
            for sign in (1.0, -2.0, 1.0):  # there, twice back, and home
                rate = sign * strain / (steps * values["dt"])
                text += PUSH.format(axis=axis, rate=rate, steps=steps, rest=rest)
            order.append((name, strain))
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "post").mkdir()
        law.tabulate(rtol=1e-7).save(folder / "pair.tbl")
        atoms = [(1, bead.diameter, bead.density, *place) for place in packing.bodies[0]]
        (folder / "start.data").write_text(data_text([(0.0, side) for side in size], atoms, types=1))
        (folder / "in.probe").write_text(text)
        log = run(folder / "in.probe")
        places = np.loadtxt(folder / "post" / "places.txt", skiprows=9)[:, 1:]
    at_rest = np.searchsorted(log["Step"], rest + (rest + steps) * np.arange(3 * len(order) + 1))
    found = {}
    contacts = contacts_of(places, size, bead.diameter, law)
    linear = Linear(contacts, size, contacts.stiffness, bead.shear_ratio * contacts.stiffness)
    exact = Linear(contacts, size, contacts.stiffness, bead.shear_ratio * contacts.stiffness, contacts.force)
    for n, (name, strain) in enumerate(order):
        _, component, (a, b) = STRAIN[name]
        stress = log[f"press[{component}]"][at_rest[1 + 3 * n : 3 + 3 * n]]
        gradient = np.zeros((3, 3))
        gradient[a, b] = 1.0
        measured = float(stress[1] - stress[0]) / (2.0 * strain)
        found[name, strain] = Probe(measured, linear.modulus(gradient), exact.modulus(gradient))
    return found


PUSHED = {"M": (0.0, 0.0, 1.0), "pure shear": (1.0, -1.0, 0.0)}


def probe_clumps(_, packing, strains=(1e-6, 1e-5), steps=2000, rest=20_000):
    """(modulus, strain) → `Probe` of a packing of clumps at rest without shear forces; nothing slides."""
    packing.friction, packing.contacts[:, :3] = 1e9, 0.0
    frequency, found, contacts = np.sqrt(packing.results[5] / packing.bead.mass), {}, packing.carrying()
    linear, dt = (
        Linear(contacts, packing.size, contacts.stiffness, packing.bead.shear_ratio * contacts.stiffness),
        0.3 / frequency,
    )

    def move(number, goal, fastest):
        packing.run(number, goal, 1e30 * fastest, fastest, 0.1 * frequency, dt)

    for name, axes in PUSHED.items():
        for strain in strains:
            stress = []
            for sign in (1.0, -2.0, 1.0):  # there, twice back, and home; a stress out of reach above or below sets the sign
                goal = [(1e30 if sign * axis > 0 else 1e-30) * (axis != 0.0) for axis in axes]
                move(steps, goal, abs(sign) * strain / (steps * dt))
                move(rest, (0.0, 0.0, 0.0), 0.0)
                stress.append(packing.stress @ axes)
            gradient = np.diag(axes)
            found[name, strain] = Probe(float(stress[0] - stress[1]) / (2.0 * strain), linear.modulus(gradient), np.nan)
    return found


RESULTS = HERE / "probes.csv"
FIELDS = ("bead", "law", "sigma_um", "packing", "count", "kPa", "modulus", "strain", "engine", "linear", "exact")
PROBED = (
    *(Series(), Series(law=POHRT_POPOV, sigma=0.5), Series(law=POHRT_POPOV, sigma=2.0), Series(law="rms", sigma=0.2)),
    *(Series(bead=CLUMPS), Series(bead=CLUMPS, law=POHRT_POPOV, sigma=0.5)),
)


def run_probes(count=1000, path=RESULTS, store=STORE, probed=PROBED, pressure=100e3, progress=print):
    """Probe packings without shear forces, which come to rest without friction; rows that `path` has are not run again."""
    done = {(row["bead"], row["law"], row["sigma_um"], row["count"]) for row in read(path)}
    for series in probed:
        series = series._replace(count=count)
        if (series.bead, series.law, series.sigma, count) in done:
            continue
        with quiet():
            packing = begin(series, store)
            packing.friction = 0.0
            packing.compress([pressure] * 3, balance=1e-4)
            found = (probe_clumps if packing.bead.clump else probe)(series, packing)
        about = (series.bead, series.law, series.sigma, series.packing, count, 1e-3 * pressure)
        append(path, FIELDS, [dict(zip(FIELDS, (*about, *key, *value), strict=True)) for key, value in found.items()])
        progress(f"probe {series.bead} {series.law} {series.sigma}")


def table(path=RESULTS):
    """CSV text: errors of the linearised stiffness."""
    titles = ("bead, law", "modulus", "strain", "probe (MPa)", "linear over probe − 1", "with the forces carried")
    lines = []
    for row in read(path):
        linear, exact = (row[name] / row["engine"] - 1.0 for name in ("linear", "exact"))
        linear, exact = ("–" if np.isnan(error) else f"{error:+.1e}" for error in (linear, exact))
        label = f"{row['bead']}, {row['law']}, σ = {row['sigma_um']:g} µm"
        lines.append([label, row["modulus"], f"{row['strain']:g}", f"{1e-6 * row['engine']:.3f}", linear, exact])
    return csv_text(titles, lines)
