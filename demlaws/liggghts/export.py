"""Write a case for LIGGGHTS: tables (one, or one per pair of types), input, runscript, and fits of stock models."""

import math
from typing import NamedTuple

import numpy as np

import demlaws
from demlaws.contact import young_against_itself
from demlaws.core.shear import DEFAULT_LEVELS
from demlaws.errors import DemlawsError, quiet
from demlaws.files import write_atomically
from demlaws.laws import USUAL
from demlaws.make import law as make_law
from demlaws.plugins.grains import make_case, output_folder
from demlaws.units import number


class StockFit(NamedTuple):
    """Stock `hertz` that meets a law at one force, and how far it is from it elsewhere."""

    force: float  # [N]
    modulus: float  # effective modulus that the input sets [Pa]
    forces: np.ndarray  # [N]
    error: np.ndarray  # (force of stock hertz at the law's overlap) / force - 1

    def table(self):
        """The errors as text lines."""
        lines = [f"fit of stock hertz at {self.force:g} N: effective modulus [Pa] = {self.modulus:.6g}"]
        return lines + [
            f"  at {p:8.3g} N the force is {100 * e:+7.1f} % off" for p, e in zip(self.forces, self.error, strict=True)
        ]


def stock_fit(law, force, forces=None):
    """Stock `hertz` that has the overlap of `law` (one contact) at `force` [N] of first loading, and its errors at `forces`.

    Elastic, so no hysteresis. Serves all radii as far as Hertz does. [our derivation]
    """
    force = number(force, "force", "N")
    if law.contact.size is not None:
        raise DemlawsError("a stock fit needs one contact, not an array of them")
    forces = force * np.array([0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0]) if forces is None else np.asarray(forces, float)
    with quiet():  # the table of errors goes beyond the law's support on purpose
        overlap, overlaps = float(law.overlap(force)), np.asarray(law.overlap(forces))
    modulus = force / (4.0 / 3.0 * math.sqrt(law.contact.radius) * overlap**1.5)
    stock = 4.0 / 3.0 * modulus * math.sqrt(law.contact.radius) * overlaps**1.5
    return StockFit(force, modulus, forces, stock / forces - 1.0)


def export(folder, law=USUAL, grains=(), *, unloading=None, options=None, **more):
    """Write a ready case into `folder` and return its in.case: grains of all types settle in a box under gravity.

    law: a name, or a whole `Case`; more: further fields of `Case`: rtol, stock, max_force, restitution, friction, count,
    shear_ratio, levels, friction_pressure. Written are the tables (one for all pairs where the law collapses, else one per pair
    of types and a wall), in.case with its property block, run.sh and post/. Walls are of the first grain's material and have
    the last type. With stock="hertz", fitted on the first grain's contact with itself, in.case and fit.txt state the error of
    the fit at other loads.
    """
    case, folder = make_case(law, grains, unloading, options, more), output_folder(folder)
    if case.stock is None:
        words, roughness = table_words(case, folder)
        model = _Model("demlaws/table", "demlaws", words, roughness, [g.material.young for g in case.grains])
        return case.write(folder, _render(case, model), "liggghts")
    if case.stock != "hertz":
        raise DemlawsError(f"stock model {case.stock!r}: only hertz is fitted")
    notes = stock_fit(case.bound(case.grains[0].contact(case.grains[0])), case.max_force).table()
    write_atomically(folder / "fit.txt", "\n".join(notes) + "\n")
    young = []
    for grain in case.grains:
        law = make_law(case.law, grain.contact(grain), **case.options)
        young.append(young_against_itself(stock_fit(law, case.max_force).modulus, grain.material.poisson))
    model = _Model("hertz", "history", "", None, young, notes)
    return case.write(folder, _render(case, model), "liggghts")


class _Model(NamedTuple):
    """What a case says of its contact model."""

    name: str
    tangential: str
    words: str  # behind `tangential ...`, for pairs and walls
    roughness: list | None  # Sq of each type [m], where the table is for all of them
    young: list  # [Pa] of each type
    notes: tuple = ()  # of a fit


def table_words(case, folder):
    """Write the tables of a case; the words of its pair_style and wall lines, and the types' roughness where they need it."""
    tables = case.write_tables(folder, wall=case.grains[0])
    if tables.single:
        roughness = " surfaceRoughness on" if tables.roughness else ""
        return f"table {tables.walls[1]}{roughness}{case.shear_words}", tables.roughness
    wall = len(case.grains) + 1
    # every pair of types needs a table, also the walls', which never meet
    files = [*((*pair, file) for pair, file in tables.pairs.items()), *((i, wall, file) for i, file in tables.walls.items())]
    pairs = " ".join(f"pairtable {i} {j} {file}" for i, j, file in [*files, (wall, wall, tables.walls[1])])
    return pairs + case.shear_words, None


FIRST_OF_HISTORY = 13
"""First column of the history in `pair/gran/local pos id force_normal delta history`; the overlap comes last."""


def _columns(case):
    """Columns of the dump of contacts: places, ids, normal force, largest and plastic overlap if the law has them, overlap."""
    names = list(range(1, FIRST_OF_HISTORY))
    if case.stock:  # shear displacement
        return [*names, FIRST_OF_HISTORY + 3]
    state = case.bound(case.grains[0].contact(case.grains[0])).state_size
    first = FIRST_OF_HISTORY + 4 * (DEFAULT_LEVELS if case.levels is None else case.levels)
    return [*names, *range(first, first + min(state, 2)), first + state + 1]  # one before the last: the identity of the law


_LOOSE = 0.2  # volume fraction at which grains are let go
_GRAVITY = 9.81  # [m/s²]


def _render(case, model):
    """in.case."""
    grains, n, types = case.grains, len(case.grains), len(case.grains) + 1
    step = case.time_step()
    largest = max(g.radius for g in grains)
    volume = case.count / n * sum(4.0 / 3.0 * math.pi * g.radius**3 for g in grains)
    # a column twice as high as wide: grains fall half of it, and are at rest after some three times that
    side = max((volume / (2.0 * _LOOSE)) ** (1.0 / 3.0), 12.0 * largest)
    height = max(volume / (_LOOSE * side**2), 6.0 * largest)
    roll = math.sqrt(largest / _GRAVITY)  # time in which a grain rolls off another
    steps = math.ceil((4.0 * math.sqrt(2.0 * height / _GRAVITY) + 100.0 * roll) / step / 20000) * 20000
    mean_mass = sum(g.mass for g in grains) / n

    def of_types(name):
        values = [getattr(g.material, name) for g in grains]
        return [*values, values[0]]

    more = ""
    if model.roughness is not None:
        roughness = " ".join(f"{v:.10g}" for v in [*model.roughness, model.roughness[0]])
        more = f"fix             p5 all property/global surfaceRoughness peratomtype {roughness}\n"
    values = {
        "title": case.title + (f", as a fit of stock {model.name}" if model.notes else ""),
        "version": demlaws.__version__,
        "notes": "".join(f"# {line}\n" for line in model.notes),
        "side": side,
        "height": height,
        "types": types,
        "young": " ".join(f"{v:.10g}" for v in [*model.young, model.young[0]]),
        "poisson": " ".join(f"{v:g}" for v in of_types("poisson")),
        "restitution": f"{types} {_matrix(case.restitution, types)}",
        "friction": f"{types} {_matrix(case.friction, types)}",
        "more": more,
        "model": model.name,
        "tangential": model.tangential,
        "words": f" {model.words}" if model.words else "",
        "step": f"{step:g}",
        "steps": steps,
        "longest": steps * step,
        "rest": case.count * _REST * mean_mass * _GRAVITY * largest,
        "gravity": _GRAVITY,
        "drag": f"{grains[0].mass / (4.0 * roll):.4g}"
        + "".join(f" scale {i + 1} {g.mass / grains[0].mass:.6g}" for i, g in enumerate(grains) if i),
        "skin": 0.2 * min(g.radius for g in grains),
        "templates": "".join(
            f"fix             t{i + 1} all particletemplate/sphere {seed} atom_type {i + 1} density constant "
            f"{g.density:g} radius constant {g.radius:.10g}\n"
            for i, (g, seed) in enumerate(zip(grains, _SEEDS * (n // len(_SEEDS) + 1), strict=False))
        ),
        "mixture": f"{n} " + " ".join(f"t{i + 1} {1.0 / n:.8f}" for i in range(n)),
        "count": case.count,
        "max_force": case.max_force,
        "columns": " ".join(f"c_contacts[{i}]" for i in _columns(case)),
    }
    return _CASE.format(**values)


_REST = 1e-5  # kinetic energy of a grain at rest, over its weight times its radius
_SEEDS = [15485863, 15485867, 32452843, 32452867, 49979687, 49979693, 67867967, 67867979]


def _matrix(value, n):
    return " ".join([f"{value:.12g}"] * (n * n))


_CASE = """\
# {title}
# written by demlaws {version}; start: ./run.sh [ranks]
# The time step holds for forces up to {max_force:g} N in a contact. The run ends when the grains rest, or after the variable
# steps ({longest:.2g} s; less: -var steps 5000).
{notes}atom_style      granular
atom_modify     map array
boundary        m m m
newton          off
communicate     single vel yes
units           si
# without this LIGGGHTS refuses a Young's modulus above 1 GPa
hard_particles  yes
variable        steps index {steps}
region          box block 0 {side:g} 0 {side:g} 0 {height:g} units box
create_box      {types} box
neighbor        {skin:g} bin
neigh_modify    delay 0

# types 1 to n: the grains; the last: the walls
fix             p1 all property/global youngsModulus peratomtype {young}
fix             p2 all property/global poissonsRatio peratomtype {poisson}
fix             p3 all property/global coefficientRestitution peratomtypepair {restitution}
fix             p4 all property/global coefficientFriction peratomtypepair {friction}
{more}pair_style      gran model {model} tangential {tangential}{words}
pair_coeff      * *
timestep        {step}

# pos 6, id 3, normal force 3, history, overlap; to be defined before the first run
compute         contacts all pair/gran/local pos id force_normal delta history
fix             gravity all gravity {gravity:g} vector 0 0 -1
# a drag that brings single grains, which roll without resistance, to rest; without it for anything that moves
fix             drag all viscous {drag}
fix             floor all wall/gran model {model} tangential {tangential} primitive type {types} zplane 0.0{words}
fix             left all wall/gran model {model} tangential {tangential} primitive type {types} xplane 0.0{words}
fix             right all wall/gran model {model} tangential {tangential} primitive type {types} xplane {side:g}{words}
fix             front all wall/gran model {model} tangential {tangential} primitive type {types} yplane 0.0{words}
fix             rear all wall/gran model {model} tangential {tangential} primitive type {types} yplane {side:g}{words}

{templates}fix             sizes all particledistribution/discrete/numberbased 86028121 {mixture}
fix             insert all insert/pack seed 86028157 distributiontemplate sizes vel constant 0 0 -0.2 &
                insert_every once overlapcheck yes all_in yes particles_in_region {count} region box
fix             move all nve/sphere
run             1
unfix           insert

variable        piece equal "ceil(v_steps/20)"
dump            grains all custom ${{piece}} post/grains.*.txt id type x y z radius vx vy vz fx fy fz
dump            contacts all local ${{piece}} post/contacts.*.txt {columns}
thermo_style    custom step atoms ke cpu
thermo          ${{piece}}
variable        moving equal ke
variable        turn loop 20
label           settle
run             ${{piece}}
if "${{moving}} < {rest:.3g}" then "jump in.case rest"
next            turn
jump            in.case settle
label           rest
print           "kinetic energy ${{moving}} J; grains at rest have less than {rest:.3g} J"
"""
