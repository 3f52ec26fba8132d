"""Write a case for LIGGGHTS: tables (one, or one a pair of types), input, runscript, and fits of stock models."""

import json
import math
import os
import shlex
import sys
import warnings
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np

import demlaws
from demlaws.checks import number
from demlaws.contact import Contact, Material, Surface
from demlaws.driver import timestep
from demlaws.errors import DemlawsError, ValidityWarning
from demlaws.files import write_atomically
from demlaws.make import law as make_law
from demlaws.make import rebound, rule_and_curve


@dataclass(frozen=True)
class Grain:
    """One particle type: radius [m], material, surface. The first of a case is type 1."""

    radius: float
    material: Material
    surface: Surface = field(default_factory=Surface)

    def contact(self, other, wall=False):
        """Contact of this grain with another, or with a plane wall made as the other is (`wall`)."""
        joined = self.surface.combined(other.surface)
        return Contact.between(
            self.material,
            other.material,
            radius1=self.radius,
            radius2=math.inf if wall else other.radius,
            roughness1=self.surface.roughness,
            roughness2=other.surface.roughness,
            fractal_dimension=joined.fractal_dimension,
            hardness=joined.hardness,
        )

    @property
    def mass(self):
        density = 2650.0 if self.material.density is None else self.material.density
        return density * 4.0 / 3.0 * math.pi * self.radius**3


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


def _pairs(grains):
    return [(i, j) for i in range(len(grains)) for j in range(i, len(grains))]


def _tables(folder, name, grains, unloading, options, rtol):
    """Write the tables; return the words of the pair_style line and of the wall lines, and per-type roughness or None."""

    def bound(contact):
        return make_law(name, contact, unloading=rebound(unloading, contact), **options)

    first = bound(grains[0].contact(grains[0]))
    alike = all(
        (g.surface.fractal_dimension, g.surface.hardness, g.material.hardness)
        == (grains[0].surface.fractal_dimension, grains[0].surface.hardness, grains[0].material.hardness)
        for g in grains
    )
    if first.collapses and alike:
        # the table ends at a tenth of the radius over the length: take the pair for which that is most
        pairs = [grains[i].contact(grains[j]) for i, j in _pairs(grains)] + [g.contact(g, wall=True) for g in grains]
        widest = max(pairs, key=lambda c: c.radius / (c.roughness or c.radius))
        bound(widest).tabulate(rtol=rtol).save(folder / f"{name}.tbl")
        same = len({g.surface.roughness for g in grains}) == 1
        words = f"table {name}.tbl" + ("" if same else " surfaceRoughness on")
        return words, [words] * len(grains), None if same else [g.surface.roughness for g in grains]
    words, walls = [], []
    for i, j in _pairs(grains):
        file = f"{name}.{i + 1}-{j + 1}.tbl"
        bound(grains[i].contact(grains[j])).tabulate(rtol=rtol).save(folder / file)
        words.append(f"pairtable {i + 1} {j + 1} {file}")
    wall_type = len(grains) + 1
    for i, grain in enumerate(grains):
        file = f"{name}.{i + 1}-wall.tbl"
        bound(grain.contact(grain, wall=True)).tabulate(rtol=rtol).save(folder / file)
        walls.append(f"pairtable {i + 1} {wall_type} {file}")
    # every pair that the box has needs a table, also those that never meet
    walls.append(f"pairtable {wall_type} {wall_type} {name}.1-wall.tbl")
    return " ".join(words + walls), [" ".join(words + walls)] * len(grains), None


def _matrix(value, n):
    return " ".join([f"{value:.12g}"] * (n * n))


def export(
    folder,
    law="pohrt-popov",
    grains=(),
    unloading="hertz",
    options=None,
    *,
    rtol=1e-5,
    stock=None,
    load=None,
    restitution=0.5,
    friction=0.5,
    count=1000,
):
    """Write a ready case into `folder` and return its in.case: grains of all types settle in a box under gravity.

    law, unloading, options: as for `demlaws.law` (a law to unload along is bound to each contact); grains: `Grain`s, one a
    particle type. Written are the tables (one for all pairs where the law collapses, else one a pair of types and a wall),
    in.case with its property block, run.sh and post/. stock: "hertz" or "edinburgh" writes a case for the stock binary
    alone, fitted at `load` [N] on the first grain's contact with itself; in.case and fit.txt state the error at other loads.
    """
    grains = list(grains)
    if not grains:
        raise DemlawsError("grains is empty: give at least one Grain(radius, material, surface)")
    folder = Path(folder)
    options = dict(options or {})
    load = number(10.0 if load is None else load, "load", "N")
    try:
        (folder / "post").mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise DemlawsError(f"cannot make folder {folder / 'post'}: {error.strerror}") from error
    n, roughness, fit, notes = len(grains), None, None, []
    rule, curve = rule_and_curve(unloading)
    unloading = rule if curve is None else curve
    young = [g.material.young for g in grains]
    if stock is None:
        words, walls, roughness = _tables(folder, law, grains, unloading, options, rtol)
        model = "demlaws/table"
    else:
        first = grains[0].contact(grains[0])
        one = make_law(law, first, unloading=rebound(unloading, first), **options)
        fit = stock_fit(one, load, stock)
        words, model = "", fit.model
        walls = [words] * n
        notes = fit.table()
        if model == "hertz":
            young = []
            for grain in grains:
                own = stock_fit(make_law(law, grain.contact(grain), **options), load, "hertz")
                young.append(2.0 * own.parameters["effective modulus [Pa]"] * (1.0 - grain.material.poisson**2))
        else:
            notes.append("one rank only, no damping: stock edinburgh loses its history across ranks and blows up with damping")
            restitution = 1.0
        write_atomically(folder / "fit.txt", "\n".join(notes) + "\n")
    types = n + 1  # the walls have a type of their own, made of the first grain's stuff
    young, poisson = [*young, young[0]], [g.material.poisson for g in [*grains, grains[0]]]
    contacts = [g.contact(g) for g in grains]
    bound = [make_law(law, c, unloading=rebound(unloading, c), **options) for c in contacts]
    # a grain has several contacts in one direction: a tenth of the single-contact limit
    step = 0.1 * min(timestep(one, 0.5 * g.mass, load) for one, g in zip(bound, grains, strict=True))
    step = float(f"{step:.1e}")
    largest = max(g.radius for g in grains)
    side = 12.0 * largest
    volume = count / n * sum(4.0 / 3.0 * math.pi * g.radius**3 for g in grains)
    height = max(volume / (0.28 * side**2), 6.0 * largest)
    unloads = f"{rule} unloading" if curve is None else f"unloading along {curve.name}"
    values = {
        "title": f"{count} grains settle in a box: law {law}, {unloads}" + (f", as a fit of stock {fit.model}" if fit else ""),
        "version": demlaws.__version__,
        "notes": "".join(f"# {line}\n" for line in notes),
        "side": side,
        "height": height,
        "types": types,
        "young": " ".join(f"{v:.10g}" for v in young),
        "poisson": " ".join(f"{v:g}" for v in poisson),
        "restitution": f"{types} {_matrix(restitution, types)}",
        "friction": f"{types} {_matrix(friction, types)}",
        "more": more_properties(roughness, grains, fit, types),
        "model": model,
        "words": f" {words}" if words else "",
        "walls": f" {walls[0]}" if walls[0] else "",
        "step": f"{step:g}",
        "skin": 0.2 * min(g.radius for g in grains),
        "templates": "".join(
            f"fix             t{i + 1} all particletemplate/sphere {seed} atom_type {i + 1} density constant "
            f"{2650.0 if g.material.density is None else g.material.density:g} radius constant {g.radius:.10g}\n"
            for i, (g, seed) in enumerate(zip(grains, _SEEDS * (n // len(_SEEDS) + 1), strict=False))
        ),
        "mixture": f"{n} " + " ".join(f"t{i + 1} {1.0 / n:.8f}" for i in range(n)),
        "count": count,
        "load": load,
        "columns": " ".join(f"c_contacts[{i}]" for i in range(1, 13)),
    }
    write_atomically(folder / "in.case", _CASE.format(**values))
    write_atomically(folder / "run.sh", (_RUN_STOCK if fit else _RUN).replace("@PYTHON@", shlex.quote(sys.executable)))
    os.chmod(folder / "run.sh", 0o755)
    write_atomically(
        folder / "case.json",
        json.dumps(
            {
                "law": law,
                "unloading": rule,
                "options": options,
                **({"unloading_law": curve.name, "unloading_options": curve.options} if curve else {}),
                "stock": fit.model if fit else None,
            },
            indent=1,
            default=lambda value: value.record(),
        )
        + "\n",
    )
    return folder / "in.case"


_SEEDS = [15485863, 15485867, 32452843, 32452867, 49979687, 49979693, 67867967, 67867979]


def more_properties(roughness, grains, fit, types):
    lines = []
    if roughness is not None:
        values = " ".join(f"{v:.10g}" for v in [*roughness, roughness[0]])
        lines.append(f"fix             p5 all property/global surfaceRoughness peratomtype {values}")
    if fit is not None and fit.model != "hertz":
        values = {
            "LoadingStiffness": fit.parameters["LoadingStiffness"],
            "UnloadingStiffness": fit.parameters["UnloadingStiffness"],
            "pullOffForce": 0.0,
            "surfaceEnergy": 0.0,
            "coefficientAdhesionStiffness": 0.0,
        }
        lines += [
            f"fix             p6_{name} all property/global {name} peratomtypepair {types} {_matrix(value, types)}"
            for name, value in values.items()
        ]
        for name, value in (("overlapExponent", fit.parameters["overlapExponent"]), ("adhesionExponent", 1.0)):
            lines.append(f"fix             p7_{name} all property/global {name} scalar {value:.12g}")
    return "".join(line + "\n" for line in lines)


_CASE = """\
# {title}
# written by demlaws {version}; start: ./run.sh [ranks]
# The time step holds for forces up to {load:g} N in a contact. Variable steps: length of the run.
{notes}atom_style      granular
atom_modify     map array
boundary        m m m
newton          off
communicate     single vel yes
units           si
# without this LIGGGHTS refuses a Young's modulus above 1 GPa
hard_particles  yes
variable        steps index 20000
region          box block 0 {side:g} 0 {side:g} 0 {height:g} units box
create_box      {types} box
neighbor        {skin:g} bin
neigh_modify    delay 0

# types 1 to n: the grains; the last: the walls
fix             p1 all property/global youngsModulus peratomtype {young}
fix             p2 all property/global poissonsRatio peratomtype {poisson}
fix             p3 all property/global coefficientRestitution peratomtypepair {restitution}
fix             p4 all property/global coefficientFriction peratomtypepair {friction}
{more}pair_style      gran model {model} tangential history{words}
pair_coeff      * *
timestep        {step}

# pos 6, id 3, normal force 3, history, overlap; to be defined before the first run
compute         contacts all pair/gran/local pos id force_normal delta history
fix             gravity all gravity 9.81 vector 0 0 -1
fix             floor all wall/gran model {model} tangential history primitive type {types} zplane 0.0{walls}
fix             left all wall/gran model {model} tangential history primitive type {types} xplane 0.0{walls}
fix             right all wall/gran model {model} tangential history primitive type {types} xplane {side:g}{walls}
fix             front all wall/gran model {model} tangential history primitive type {types} yplane 0.0{walls}
fix             rear all wall/gran model {model} tangential history primitive type {types} yplane {side:g}{walls}

{templates}fix             sizes all particledistribution/discrete/numberbased 86028121 {mixture}
fix             insert all insert/pack seed 86028157 distributiontemplate sizes vel constant 0 0 -0.2 &
                insert_every once overlapcheck yes all_in yes particles_in_region {count} region box
fix             move all nve/sphere
run             1
unfix           insert

dump            grains all custom 5000 post/grains.*.txt id type x y z radius vx vy vz fx fy fz
dump            contacts all local 5000 post/contacts.*.txt {columns}
thermo_style    custom step atoms ke cpu
thermo          1000
run             ${{steps}}
"""

_RUN = """\
#!/bin/sh
# ./run.sh [ranks]: the stock liggghts with the demlaws plugin; demlaws liggghts build compiles it at first use
set -e
cd "$(dirname "$0")"
# DEMLAWS: another demlaws than the one that wrote this case
plugin=$(${DEMLAWS:-@PYTHON@ -m demlaws} liggghts build)
ranks=${1:-1}
if [ "$ranks" -gt 1 ]; then
  root=; [ "$(id -u)" = 0 ] && root="--allow-run-as-root --oversubscribe"
  exec mpirun $root -np "$ranks" -x LD_PRELOAD="$plugin" liggghts -in in.case
fi
exec env LD_PRELOAD="$plugin" liggghts -in in.case
"""

_RUN_STOCK = """\
#!/bin/sh
# ./run.sh [ranks]: stock liggghts, no plugin
set -e
cd "$(dirname "$0")"
ranks=${1:-1}
if [ "$ranks" -gt 1 ]; then
  root=; [ "$(id -u)" = 0 ] && root="--allow-run-as-root --oversubscribe"
  exec mpirun $root -np "$ranks" liggghts -in in.case
fi
exec liggghts -in in.case
"""
