"""Write a case for LAMMPS: tables (one, or one per pair of types), input, runscript."""

import math
from typing import NamedTuple

import numpy as np

import demlaws
from demlaws.contact import effective_modulus, young_against_itself
from demlaws.errors import DemlawsError
from demlaws.files import write_atomically
from demlaws.laws import USUAL
from demlaws.laws.registry import find
from demlaws.plugins.grains import make_case, output_folder
from demlaws.timestep import shear_ratio


class Models(NamedTuple):
    """Contact models of an input."""

    pairs: list  # pair_coeff lines
    walls: list  # the words of a wall's model, one entry per type; equal where one serves all


def stock_models(grains, restitution=0.5, friction=0.5):
    """`Models` of LAMMPS's own hertz/material; one line per pair of types, for its mixing is too soft in shear."""

    def words(one, other):
        # of the material that, against itself, has E* and G* of the two
        ratio = shear_ratio(one.material, other.material)
        poisson = 2.0 * (1.0 - ratio) / (2.0 - ratio)
        young = young_against_itself(effective_modulus(one.material, other.material), poisson)
        text = f"hertz/material {young:.12g} {restitution:.12g} {poisson:.12g}"
        return f"{text} tangential mindlin_rescale/force NULL 1 {friction:g} damping coeff_restitution"

    count = len(grains)
    pairs = [f"pair_coeff {i + 1} {j + 1} {words(grains[i], grains[j])}" for i in range(count) for j in range(i, count)]
    return Models(pairs, [words(g, g) for g in grains])


def models(case, folder, wall_friction=None, tangential_damping=1.0):
    """Write the tables of a case and return the words of its pair_coeff and wall lines, `Models`.

    One table where the law collapses and the surfaces have one fractal dimension and hardness; then LAMMPS mixes the types.
    A wall is a plane of the material of the grain that touches it. wall_friction: that of the walls, if another.
    """
    tables, grains = case.write_tables(folder), dict(enumerate(case.grains, start=1))

    def words(file, one, other=None, friction=case.friction):
        mine = grains[one].material
        text = f"demlaws/table {file} {mine.young:.12g} {case.restitution:.12g} {mine.poisson:g}"
        text += case.shear_words
        if tables.roughness:
            text += f" roughness {math.sqrt(2.0) * tables.roughness[one - 1]:.12g}"
        if other is not None and (other.young, other.poisson) != (mine.young, mine.poisson):
            text += f" against {other.young:.12g} {other.poisson:g}"
        return f"{text} tangential demlaws {tangential_damping:g} {friction:g} damping demlaws/tangent"

    wall_friction = case.friction if wall_friction is None else wall_friction
    pairs = {(i, j): file for (i, j), file in tables.pairs.items() if i == j or not tables.single}
    return Models(
        [f"pair_coeff {i} {j} {words(file, i, grains[j].material)}" for (i, j), file in pairs.items()],
        [words(file, i, friction=wall_friction) for i, file in tables.walls.items()],
    )


def wall_lines(models, fixes):
    """fix lines of walls: `fixes` is (name, style, arguments after the model); one fix a type where the models differ."""
    lines = []
    if len(set(models.walls)) == 1:
        return [f"fix {name} all {style} granular {models.walls[0]} {rest}" for name, style, rest in fixes]
    for n, words in enumerate(models.walls, start=1):
        lines += [f"group of_type_{n} type {n}"]
        lines += [f"fix {name}_{n} of_type_{n} {style} granular {words} {rest}" for name, style, rest in fixes]
    return lines


def random_positions(grains, count, seed=15485863):
    """Types, radii, centres and box of `count` grains on a shaken lattice, all kinds equally often; without contacts."""
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


def export(folder, law=USUAL, grains=(), *, unloading=None, options=None, **more):
    """Write a ready case into `folder` and return its in.case: grains of all types settle in a box under gravity.

    law: a name, or a whole `Case`; more: further fields of `demlaws.plugins.grains.Case`: rtol, stock, max_force, restitution,
    friction, count, shear_ratio, levels, friction_pressure. Written are the tables (one for all pairs where the law collapses,
    else one per pair of types and a wall), grains.data, in.case, run.sh and post/. stock="hertz", for law hertz: LAMMPS's own
    hertz/material instead of tables; the case needs no plugin.
    """
    case, folder = make_case(law, grains, unloading, options, more), output_folder(folder)
    stock, grains = case.stock, case.grains
    if stock is not None and stock != find(case.law).advice.native.get("lammps"):
        raise DemlawsError(f"stock = {stock!r} with law {case.law!r}: LAMMPS has only law 'hertz' of its own, as stock='hertz'")
    lines = stock_models(grains, case.restitution, case.friction) if stock else models(case, folder)
    types, radii, centres, (side, height) = random_positions(grains, case.count)
    margin = 0.1 * max(radii)
    data = [f"{case.count} grains, written by demlaws {demlaws.__version__}", "", f"{case.count} atoms"]
    data += [f"{len(grains)} atom types", "", *(f"{-margin:.10g} {side + margin:.10g} {axis}lo {axis}hi" for axis in "xy")]
    data += [f"{-margin:.10g} {height:.10g} zlo zhi", "", "Atoms", ""]
    for n, (kind, radius, place) in enumerate(zip(types, radii, centres, strict=True), start=1):
        x, y, z = (f"{v:.12g}" for v in place)
        data.append(f"{n} {kind + 1} {2 * radius:.12g} {grains[kind].density:.10g} {x} {y} {z}")
    write_atomically(folder / "grains.data", "\n".join(data) + "\n")
    walls = [
        ("floor", "wall/gran", "zplane 0.0 NULL"),
        ("sides", "wall/gran", f"xplane 0.0 {side:.10g}"),
        ("faces", "wall/gran", f"yplane 0.0 {side:.10g}"),
    ]
    values = {
        "title": case.title,
        "version": demlaws.__version__,
        "max_force": case.max_force,
        "skin": 0.2 * min(g.radius for g in grains),
        "pairs": "\n".join(lines.pairs),
        "walls": "\n".join(wall_lines(lines, walls)),
        "step": case.time_step(),
        "words": "" if stock else _WORDS,
        "outputs": "" if stock else " p13 p14 p15 p16",
        "energy": "" if stock else "compute         energy all demlaws/energy\n",
        "energies": "" if stock else " c_energy[1] c_energy[2]",
        "taken": "" if stock else " d_demlaws_dissipated",
    }
    return case.write(folder, _CASE.format(**values), "lammps")


_WORDS = "# demlaws/table FILE E restitution nu [roughness of the pair] [against E nu of the other body]\n"
_CASE = """\
# {title}
# written by demlaws {version}; start: ./run.sh [ranks], or lmp -in in.case where LAMMPS finds the plugin
# The time step holds for forces up to {max_force:g} N in a contact. Variable steps: length of the run.
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
dump_modify     grains format float %.10g
dump            contacts all local 5000 post/contacts.*.txt index c_ids[*] c_contacts[*]
thermo_style    custom step atoms ke{energies} cpu
thermo_modify   norm no
thermo          1000
run             ${{steps}}
"""
