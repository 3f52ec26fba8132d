"""Write a case for LIGGGHTS: tables (one, or one per pair of types), input, runscript, and fits of stock models."""

import math
import warnings
from typing import NamedTuple

import numpy as np

import demlaws
from demlaws.errors import DemlawsError, ValidityWarning
from demlaws.files import write_atomically
from demlaws.grains import RUN, make_case, output_folder
from demlaws.laws.names import USUAL
from demlaws.make import law as make_law
from demlaws.units import number


class StockFit(NamedTuple):
    """A stock model that meets a law at one load, and how far it is from it elsewhere."""

    model: str  # hertz or edinburgh/stiffness
    load: float  # [N]
    parameters: dict  # what the input sets
    loads: np.ndarray  # [N]
    error: np.ndarray  # (force of the stock model at the law's overlap) / load - 1
    plastic_error: float  # (plastic overlap after unloading from `load`) / (the law's) - 1; NaN where the law has none

    def table(self):
        """The errors as text lines."""
        lines = [
            f"fit of stock {self.model} at {self.load:g} N: " + ", ".join(f"{k} = {v:.6g}" for k, v in self.parameters.items())
        ]
        lines += [f"  at {p:8.3g} N the force is {100 * e:+7.1f} % off" for p, e in zip(self.loads, self.error, strict=True)]
        if not math.isnan(self.plastic_error):
            lines.append(f"  plastic overlap after {self.load:g} N: {100 * self.plastic_error:+.1f} % off")
        return lines


def stock_fit(law, load, model="hertz", loads=None):
    """Stock `hertz` or `edinburgh/stiffness` that meets `law` (one contact) at `load` [N] of first loading.

    hertz: the effective modulus for which Hertz has the law's overlap at that load; elastic, so no hysteresis. Serves
    all radii as far as Hertz does. edinburgh/stiffness: P = k δ^n with the law's overlap and tangent, and k2/k1 for the
    law's plastic overlap after that load; holds for this radius only, loses its history when a contact changes ranks
    and takes no damping: one rank, coefficientRestitution 1. [the fits: our derivation]
    """
    load = number(load, "load", "N")
    contact = law.contact
    if contact.size is not None:
        raise DemlawsError("a stock fit needs one contact, not an array of them")
    loads = load * np.array([0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0]) if loads is None else np.asarray(loads, float)
    with warnings.catch_warnings():  # the table of errors goes beyond the law's support on purpose
        warnings.simplefilter("ignore", ValidityWarning)
        overlap, overlaps = float(law.overlap(load)), np.asarray(law.overlap(loads))
        path = law.follow(np.array([overlap]))
    plastic = float(path.plastic_overlap[0]) if law.state_size else 0.0
    if model == "hertz":
        modulus = load / (4.0 / 3.0 * math.sqrt(contact.radius) * overlap**1.5)
        forces = 4.0 / 3.0 * modulus * math.sqrt(contact.radius) * overlaps**1.5
        parameters, left = {"effective modulus [Pa]": modulus}, 0.0
    elif model in ("edinburgh", "edinburgh/stiffness"):
        model = "edinburgh/stiffness"
        exponent = float(law.stiffness(overlap)) * overlap / load
        stiffness = load / overlap**exponent
        kept = (max(plastic, 0.0) / overlap) ** exponent
        forces = stiffness * overlaps**exponent
        parameters = {
            "LoadingStiffness": stiffness,
            "overlapExponent": exponent,
            "UnloadingStiffness": 1.0 / (1.0 - kept),
        }
        left = overlap * kept ** (1.0 / exponent)
    else:
        raise DemlawsError(f"stock model {model!r}: choose hertz or edinburgh")
    plastic_error = left / plastic - 1.0 if plastic > 0.0 else math.nan
    return StockFit(model, load, parameters, loads, forces / loads - 1.0, plastic_error)


def export(folder, law=USUAL, grains=(), unloading=None, options=None, **more):
    """Write a ready case into `folder` and return its in.case: grains of all types settle in a box under gravity.

    law: a name, or a whole `Case`; more: further fields of `Case`: rtol, stock, load, restitution, friction, count. Written
    are the tables (one for all pairs where the law collapses, else one per pair of types and a wall), in.case with its
    property block, run.sh and post/. Walls are of the first grain's material and have the last type. With stock="hertz" or
    "edinburgh", fitted on the first grain's contact with itself, in.case and fit.txt state the error of the fit at other loads.
    """
    case, folder = make_case(law, grains, unloading, options, more), output_folder(folder)
    if case.stock is None:
        words, roughness = table_words(case, folder)
        model = _Model("demlaws/table", words, roughness, [g.material.young for g in case.grains])
        return case.write(folder, _render(case, model), RUN.replace("@ENGINE@", "liggghts"), stock=None)
    model = _stock_model(case, stock_fit(case.bound(case.grains[0].contact(case.grains[0])), case.load, case.stock))
    write_atomically(folder / "fit.txt", "\n".join(model.notes) + "\n")
    return case.write(folder, _render(case, model), _RUN_STOCK, stock=model.name)


class _Model(NamedTuple):
    """What a case says of its contact model."""

    name: str
    words: str  # behind `tangential ...`, for pairs and walls
    roughness: list | None  # Sq of each type [m], where the table is for all of them
    young: list  # [Pa] of each type
    fit: StockFit | None = None
    notes: tuple = ()
    damped: bool = True


def _stock_model(case, fit):
    notes = fit.table()
    if fit.model == "hertz":
        young = []
        for grain in case.grains:
            own = stock_fit(make_law(case.law, grain.contact(grain), **case.options), case.load, "hertz")
            young.append(2.0 * own.parameters["effective modulus [Pa]"] * (1.0 - grain.material.poisson**2))
        return _Model("hertz", "", None, young, fit, tuple(notes))
    notes.append("one rank only, no damping: stock edinburgh loses its history across ranks and blows up with damping")
    return _Model(fit.model, "", None, [g.material.young for g in case.grains], fit, tuple(notes), damped=False)


def table_words(case, folder):
    """Write the tables of a case; the words of its pair_style and wall lines, and the types' roughness where they need it."""
    tables = case.write_tables(folder, wall=case.grains[0])
    if tables.single:
        return f"table {tables.walls[1]}{' surfaceRoughness on' if tables.roughness else ''}", tables.roughness
    wall = len(case.grains) + 1
    # every pair of types needs a table, also the walls', which never meet
    files = [*((*pair, file) for pair, file in tables.pairs.items()), *((i, wall, file) for i, file in tables.walls.items())]
    return " ".join(f"pairtable {i} {j} {file}" for i, j, file in [*files, (wall, wall, tables.walls[1])]), None


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

    values = {
        "title": case.title + (f", as a fit of stock {model.name}" if model.fit else ""),
        "version": demlaws.__version__,
        "notes": "".join(f"# {line}\n" for line in model.notes),
        "side": side,
        "height": height,
        "types": types,
        "young": " ".join(f"{v:.10g}" for v in [*model.young, model.young[0]]),
        "poisson": " ".join(f"{v:g}" for v in of_types("poisson")),
        "restitution": f"{types} {_matrix(case.restitution if model.damped else 1.0, types)}",
        "friction": f"{types} {_matrix(case.friction, types)}",
        "more": _more_properties(model, types),
        "model": model.name,
        "tangential": "history" if model.fit else "demlaws",
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
        "load": case.load,
        "columns": " ".join(f"c_contacts[{i}]" for i in range(1, 13)),
    }
    return _CASE.format(**values)


_REST = 1e-5  # kinetic energy of a grain at rest, over its weight times its radius
_SEEDS = [15485863, 15485867, 32452843, 32452867, 49979687, 49979693, 67867967, 67867979]


def _matrix(value, n):
    return " ".join([f"{value:.12g}"] * (n * n))


def _more_properties(model, types):
    lines = []
    if model.roughness is not None:
        values = " ".join(f"{v:.10g}" for v in [*model.roughness, model.roughness[0]])
        lines.append(f"fix             p5 all property/global surfaceRoughness peratomtype {values}")
    return "".join(line + "\n" for line in lines) + (stock_properties(model.fit, types) if model.fit else "")


def stock_properties(fit, types):
    """The property lines that a stock model's fit needs; none for hertz."""
    if fit.model == "hertz":
        return ""
    parameters = fit.parameters
    values = {
        "LoadingStiffness": parameters["LoadingStiffness"],
        "UnloadingStiffness": parameters["UnloadingStiffness"],
        "pullOffForce": 0.0,
        "surfaceEnergy": 0.0,
        "coefficientAdhesionStiffness": 0.0,
    }
    lines = [
        f"fix             p6_{name} all property/global {name} peratomtypepair {types} {_matrix(value, types)}"
        for name, value in values.items()
    ]
    for name, value in (("overlapExponent", parameters["overlapExponent"]), ("adhesionExponent", 1.0)):
        lines.append(f"fix             p7_{name} all property/global {name} scalar {value:.12g}")
    return "".join(line + "\n" for line in lines)


_CASE = """\
# {title}
# written by demlaws {version}; start: ./run.sh [ranks]
# The time step holds for forces up to {load:g} N in a contact. The run ends when the grains rest, or after the variable
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

_RUN_STOCK = """\
#!/bin/sh
# ./run.sh [ranks]: stock liggghts, no plugin
set -e
cd "$(dirname "$0")"
ranks=${1:-1}
if [ "$ranks" -gt 1 ]; then
  root=; [ "$(id -u)" = 0 ] && root=--allow-run-as-root
  exec mpirun $root --oversubscribe -np "$ranks" "${DEMLAWS_LIGGGHTS:-liggghts}" -in in.case
fi
exec "${DEMLAWS_LIGGGHTS:-liggghts}" -in in.case
"""
