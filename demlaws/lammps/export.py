"""Write a case for LAMMPS: tables (one, or one a pair of types and a wall), input, runscript."""

import json
import math
import os
import shlex
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np

import demlaws
from demlaws.errors import DemlawsError
from demlaws.files import write_atomically
from demlaws.laws.names import USUAL
from demlaws.laws.registry import find
from demlaws.make import law as make_law
from demlaws.make import rebound, rule_and_curve, unloading_of_case
from demlaws.materials import DENSITY
from demlaws.timestep import timestep
from demlaws.units import number


class Models(NamedTuple):
    """What the input says of the contacts."""

    pairs: list  # pair_coeff lines
    walls: list  # the words of a wall's model, one entry a type; equal where one serves all
    alike: bool  # one table serves all


def joined(one, other):
    """Young's modulus [Pa] and Poisson's ratio of the material that, against itself, has E* and G* of the two."""
    modulus = 1.0 / ((1.0 - one.poisson**2) / one.young + (1.0 - other.poisson**2) / other.young)
    shear = 1.0 / sum(2.0 * (2.0 - m.poisson) * (1.0 + m.poisson) / m.young for m in (one, other))
    ratio = modulus / shear
    poisson = (ratio - 4.0) / (ratio - 2.0)
    return 2.0 * (1.0 - poisson**2) * modulus, poisson


def stock_models(grains, restitution=0.5, friction=0.5):
    """`Models` of LAMMPS's own hertz/material; a line a pair of types, for what it mixes is too soft in shear."""

    def words(one, other):
        young, poisson = joined(one.material, other.material)
        text = f"hertz/material {young:.12g} {restitution:.12g} {poisson:.12g}"
        return f"{text} tangential mindlin NULL 1 {friction:g} damping coeff_restitution"

    count = len(grains)
    pairs = [f"pair_coeff {i + 1} {j + 1} {words(grains[i], grains[j])}" for i in range(count) for j in range(i, count)]
    return Models(pairs, [words(g, g) for g in grains], True)


def models(
    folder, law, grains, unloading, options, rtol, restitution=0.5, friction=0.5, wall_friction=None, tangential_damping=1.0
):
    """Write the tables of a case and say what its pair_coeff and wall lines hold, as `Models`.

    One table where the law collapses and the surfaces have one fractal dimension and hardness; then LAMMPS mixes the types.
    A wall is a plane made as the grain that touches it. wall_friction: that of the walls, if another.
    """

    def bound(contact):
        return make_law(law, contact, unloading=rebound(unloading, contact), **options)

    def words(file, grain, roughness, against=None, mu=friction):
        text = f"demlaws/table {file} {grain.material.young:.12g} {restitution:.12g} {grain.material.poisson:g}"
        if roughness:
            text += f" roughness {roughness:.12g}"
        if against is not None:
            text += f" against {against.material.young:.12g} {against.material.poisson:g}"
        return f"{text} tangential mindlin NULL {tangential_damping:g} {mu:g} damping demlaws/tangent"

    wall_mu = friction if wall_friction is None else wall_friction
    first = grains[0]
    alike = all(
        (g.surface.fractal_dimension, g.surface.hardness, g.material.hardness)
        == (first.surface.fractal_dimension, first.surface.hardness, first.material.hardness)
        for g in grains
    )
    if bound(first.contact(first)).collapses and alike:
        # the table ends at a tenth of the radius over the length: take the pair for which that is most
        count = len(grains)
        contacts = [grains[i].contact(grains[j]) for i in range(count) for j in range(i, count)]
        contacts += [g.contact(g, wall=True) for g in grains]
        file = f"{law}.tbl"
        bound(max(contacts, key=lambda c: c.radius / (c.roughness or c.radius))).tabulate(rtol=rtol).save(folder / file)
        same = len({g.surface.roughness for g in grains}) == 1
        rough = [0.0 if same else math.sqrt(2.0) * g.surface.roughness for g in grains]
        if not same and min(rough) <= 0.0:
            raise DemlawsError("a smooth grain beside a rough one: give every grain a roughness, or none")
        pairs = [f"pair_coeff {i + 1} {i + 1} {words(file, g, rough[i])}" for i, g in enumerate(grains)]
        walls = [words(file, g, rough[i], mu=wall_mu) for i, g in enumerate(grains)]
        return Models(pairs, walls, True)
    pairs, walls = [], []
    for i, one in enumerate(grains):
        for j in range(i, len(grains)):
            file = f"{law}.{i + 1}-{j + 1}.tbl"
            bound(one.contact(grains[j])).tabulate(rtol=rtol).save(folder / file)
            other = grains[j].material
            unlike = grains[j] if (other.young, other.poisson) != (one.material.young, one.material.poisson) else None
            pairs.append(f"pair_coeff {i + 1} {j + 1} {words(file, one, 0.0, unlike)}")
        file = f"{law}.{i + 1}-wall.tbl"
        bound(one.contact(one, wall=True)).tabulate(rtol=rtol).save(folder / file)
        walls.append(words(file, one, 0.0, mu=wall_mu))
    return Models(pairs, walls, False)


def wall_lines(models, fixes):
    """fix lines of walls: `fixes` is (name, style, arguments after the model); one fix a type where the models differ."""
    lines = []
    if len(set(models.walls)) == 1:
        return [f"fix {name} all {style} granular {models.walls[0]} {rest}" for name, style, rest in fixes]
    for n, words in enumerate(models.walls, start=1):
        lines += [f"group of_type_{n} type {n}"]
        lines += [f"fix {name}_{n} of_type_{n} {style} granular {words} {rest}" for name, style, rest in fixes]
    return lines


def loose(grains, count, seed=15485863):
    """Types, radii, centres and box of `count` grains on a shaken lattice, all kinds equally often; nobody touches."""
    random = np.random.default_rng(seed)
    largest = max(g.radius for g in grains)
    types = np.arange(count) % len(grains)
    random.shuffle(types)
    radii = np.array([g.radius for g in grains])[types]
    across, pitch = 6, 2.05 * largest
    place = np.arange(count)
    centres = (np.stack([place % across, place // across % across, place // across**2], 1) + 0.5) * pitch
    centres += random.uniform(-1.0, 1.0, centres.shape) * 0.98 * (0.5 * pitch - radii)[:, None]
    return types, radii, centres, (across * pitch, centres[:, 2].max() + 3.0 * pitch)


def export(
    folder,
    law=USUAL,
    grains=(),
    unloading=None,
    options=None,
    *,
    rtol=1e-5,
    load=10.0,
    restitution=0.5,
    friction=0.5,
    count=1000,
    stock=None,
):
    """Write a ready case into `folder` and return its in.case: grains of all types settle in a box under gravity.

    law, unloading, options: as for `demlaws.law` (a law to unload along is bound to each contact); grains:
    `demlaws.liggghts.Grain`s, one a particle type. Written are the tables (one for all pairs where the law collapses, else one
    a pair of types and a wall), grains.data, in.case, run.sh and post/. load [N]: the largest contact force of the time step.
    stock="hertz", for law hertz: LAMMPS's own hertz/material instead of tables; the case needs no plugin.
    """
    grains = list(grains)
    if not grains:
        raise DemlawsError("grains is empty: give at least one Grain(radius, material, surface)")
    folder, options = Path(folder), dict(options or {})
    load = number(load, "load", "N")
    if stock is not None and stock != find(law).native.get("lammps"):
        raise DemlawsError(f"stock = {stock!r} with law {law!r}: LAMMPS has only law 'hertz' of its own, as stock='hertz'")
    if not (isinstance(count, int) and count > 0):
        raise DemlawsError(f"count = {count!r}: a whole number of at least 1")
    try:
        (folder / "post").mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise DemlawsError(f"cannot make folder {folder / 'post'}: {error.strerror}") from error
    rule, curve = rule_and_curve(unloading_of_case(law) if unloading is None else unloading)
    unloading = rule if curve is None else curve
    if stock:
        said = stock_models(grains, restitution, friction)
    else:
        said = models(folder, law, grains, unloading, options, rtol, restitution, friction)
    contacts = [g.contact(g) for g in grains]
    bound = [make_law(law, c, unloading=rebound(unloading, c), **options) for c in contacts]
    # grains have several contacts, and fall on each other: a tenth of the step for two grains without friction
    steps = [timestep(one, g.mass, load, other_mass=g.mass, shear_ratio=0.0) for one, g in zip(bound, grains, strict=True)]
    step = 0.1 * min(steps)
    types, radii, centres, (side, height) = loose(grains, count)
    densities = [DENSITY if g.material.density is None else g.material.density for g in grains]
    margin = 0.1 * max(radii)
    lines = [f"{count} grains, written by demlaws {demlaws.__version__}", "", f"{count} atoms", f"{len(grains)} atom types", ""]
    lines += [f"{-margin:.10g} {side + margin:.10g} {axis}lo {axis}hi" for axis in "xy"]
    lines += [f"{-margin:.10g} {height:.10g} zlo zhi", "", "Atoms", ""]
    for n, (kind, radius, place) in enumerate(zip(types, radii, centres, strict=True), start=1):
        x, y, z = (f"{v:.12g}" for v in place)
        lines.append(f"{n} {kind + 1} {2 * radius:.12g} {densities[kind]:.10g} {x} {y} {z}")
    write_atomically(folder / "grains.data", "\n".join(lines) + "\n")
    walls = [
        ("floor", "wall/gran", "zplane 0.0 NULL"),
        ("sides", "wall/gran", f"xplane 0.0 {side:.10g}"),
        ("faces", "wall/gran", f"yplane 0.0 {side:.10g}"),
    ]
    unloads = f"{rule} unloading" if curve is None else f"unloading along {curve.name}"
    values = {
        "title": f"{count} grains settle in a box: law {law}, {unloads}",
        "version": demlaws.__version__,
        "load": load,
        "skin": 0.2 * min(g.radius for g in grains),
        "pairs": "\n".join(said.pairs),
        "walls": "\n".join(wall_lines(said, walls)),
        "step": float(f"{step:.1e}"),
        "words": "" if stock else _WORDS,
        "outputs": "" if stock else " p13 p14 p15 p16",
        "energy": "" if stock else "compute         energy all demlaws/energy\n",
        "energies": "" if stock else " c_energy[1] c_energy[2]",
        "taken": "" if stock else " d_demlaws_dissipated",
    }
    write_atomically(folder / "in.case", _CASE.format(**values))
    write_atomically(folder / "run.sh", _RUN.replace("@PYTHON@", shlex.quote(sys.executable)))
    os.chmod(folder / "run.sh", 0o755)
    record = {"law": law, "unloading": rule, "options": options}
    if curve:
        record.update(unloading_law=curve.name, unloading_options=curve.options)
    write_atomically(folder / "case.json", json.dumps(record, indent=1, default=lambda value: value.record()) + "\n")
    return folder / "in.case"


_WORDS = "# demlaws/table FILE E restitution nu [roughness of the pair] [against E nu of the other body]\n"
_CASE = """\
# {title}
# written by demlaws {version}; start: ./run.sh [ranks], or lmp -in in.case where LAMMPS finds the plugin
# The time step holds for forces up to {load:g} N in a contact. Variable steps: length of the run.
units           si
atom_style      sphere
atom_modify     map array
comm_modify     vel yes
boundary        f f f
variable        steps index 20000
read_data       grains.data
neighbor        {skin:g} bin
neigh_modify    delay 0

{words}pair_style      granular
{pairs}
timestep        {step:g}

fix             gravity all gravity 9.81 vector 0 0 -1
{walls}
fix             move all nve/sphere

# ids, normal force, largest and plastic overlap, energies; [1] stored, [2] taken by plastic flow
compute         ids all property/local patom1 patom2 cutoff radius
compute         contacts all pair/local fx fy fz{outputs} cutoff radius
{energy}dump            grains all custom 5000 post/grains.*.txt id type x y z radius vx vy vz fx fy fz{taken}
dump            contacts all local 5000 post/contacts.*.txt index c_ids[*] c_contacts[*]
thermo_style    custom step atoms ke{energies} cpu
thermo_modify   norm no
thermo          1000
run             ${{steps}}
"""

_RUN = """\
#!/bin/sh
# ./run.sh [ranks]: the stock LAMMPS with the demlaws plugin; `demlaws lammps build` compiles it at first use
set -e
cd "$(dirname "$0")"
# DEMLAWS: another demlaws than the one that wrote this case
exec ${DEMLAWS:-@PYTHON@ -m demlaws} lammps run in.case -np "${1:-1}"
"""
