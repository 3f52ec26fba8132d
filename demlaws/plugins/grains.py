"""Grains, and cases of LIGGGHTS and LAMMPS: grains that settle in a box, with the tables of their contacts."""

import math
import os
import shlex
import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from demlaws.contact import DENSITY, Contact, Material, Surface, softer_hardness, surface_of
from demlaws.core.shear import LARGEST_SHEAR_RATIO, MOST_LEVELS
from demlaws.errors import DemlawsError
from demlaws.files import as_path, write_atomically
from demlaws.laws import USUAL
from demlaws.laws.registry import find
from demlaws.make import check_unloading, law as make_law, unloading_for
from demlaws.timestep import timestep
from demlaws.units import number, whole


@dataclass(frozen=True)
class Grain:
    """One particle type: radius [m], material, surface (default: the material's). The first of a case is type 1."""

    radius: float
    material: Material
    surface: Surface | None = None

    def __post_init__(self):
        if self.surface is None:
            object.__setattr__(self, "surface", surface_of(self.material))

    def contact(self, other, wall=False):
        """Contact of this grain with another, or with a plane wall of the other's material and surface (`wall`)."""
        return Contact.between(
            self.material,
            other.material,
            radius1=self.radius,
            radius2=math.inf if wall else other.radius,
            roughness1=self.surface.roughness,
            roughness2=other.surface.roughness,
            fractal_dimension=self.surface.combined(other.surface).fractal_dimension,
            hardness=softer_hardness((self.material, self.surface), (other.material, other.surface)),
        )

    @property
    def density(self):
        """Density [kg/m³]; that of granite where the material has none."""
        return DENSITY if self.material.density is None else self.material.density

    @property
    def mass(self):
        """Mass of one grain [kg]."""
        return self.density * 4.0 / 3.0 * math.pi * self.radius**3


class Tables(NamedTuple):
    """Table files of a case."""

    pairs: dict  # (type, type), the smaller first → file name
    walls: dict  # type → file name of its contact with a wall
    roughness: list | None  # Sq [m] of each type where one table serves types of unlike roughness

    @property
    def single(self):
        """Whether one table serves all contacts."""
        return len({*self.pairs.values(), *self.walls.values()}) == 1


@dataclass(frozen=True)
class Case:
    """Grains of all types that settle in a box under gravity; `export` of an engine writes it.

    law, unloading, options: as for `demlaws.law` (a law to unload along is bound to each contact); grains: `Grain`s, one per
    particle type; max_force: largest force [N] expected in a contact, and that of a stock fit; stock: model of the engine's own
    in place of tables, a case that needs no plugin; shear_ratio: K_t/K (default: that of ν); levels: levels of shear (default:
    the plugin's); friction_pressure: (c1, c2 [1/Pa]), with which friction falls to `friction` (`demlaws.PressureFriction`).
    """

    law: str = USUAL
    grains: tuple = ()
    unloading: object = None  # default: that of the law
    options: dict = field(default_factory=dict)
    rtol: float = 1e-5
    stock: str | None = None
    max_force: float = 10.0
    restitution: float = 0.5
    friction: float = 0.5
    count: int = 1000
    shear_ratio: float | None = None
    levels: int | None = None
    friction_pressure: tuple | None = None

    def __post_init__(self):
        if not self.grains:
            raise DemlawsError("grains is empty: give at least one Grain(radius, material, surface)")
        definition = find(self.law)
        object.__setattr__(self, "options", definition.read_options(self.options))
        unloading = definition.default_rule(**self.options) if self.unloading is None else self.unloading
        object.__setattr__(self, "unloading", check_unloading(unloading))
        number(self.max_force, "max_force", "N")
        whole(self.count, "count")
        if self.shear_ratio is not None:
            number(self.shear_ratio, "shear_ratio", high=LARGEST_SHEAR_RATIO)
        if self.levels is not None:
            whole(self.levels, "levels", high=MOST_LEVELS)
        if self.friction_pressure is not None:
            from demlaws.shear import PressureFriction

            law = PressureFriction(self.friction, *self.friction_pressure)
            object.__setattr__(self, "friction_pressure", (law.c1, law.c2))
        if self.stock and self.shear_words:
            raise DemlawsError(f"stock = {self.stock!r} has the engine's own shear: leave out{self.shear_words}")

    def bound(self, contact):
        """The law of one contact; MissingQuantity names what the grains' surfaces lack."""
        return make_law(self.law, contact, unloading=unloading_for(self.unloading, contact), **self.options)

    @property
    def curve(self):
        """The law or table that contacts unload along, or None."""
        return None if isinstance(self.unloading, str) else self.unloading

    @property
    def title(self):
        """One line about the case."""
        unloads = f"{self.unloading} unloading" if self.curve is None else f"unloading along {self.curve.name}"
        return f"{self.count} grains settle in a box: law {self.law}, {unloads}"

    @property
    def shear_words(self):
        """Words of demlaws/table for shear; empty for its defaults."""
        values = {"shear_ratio": self.shear_ratio, "levels": self.levels}
        words = "".join(f" {name} {value:.12g}" for name, value in values.items() if value is not None)
        falls = "" if self.friction_pressure is None else " friction_pressure {:.12g} {:.12g}".format(*self.friction_pressure)
        return words + falls

    def time_step(self):
        """Time step [s] for forces up to `max_force`: a tenth of that of two grains without friction, since grains collide.

        It is below half of the stable step of a packing with the largest K_t/K.
        """
        pairs = [(self.bound(g.contact(g)), g.mass) for g in self.grains]
        step = min(timestep(law, mass, self.max_force, other_mass=mass, shear_ratio=0.0) for law, mass in pairs)
        return float(f"{0.1 * step:.1e}")

    def write_tables(self, folder, wall=None):
        """Write the case's tables: one where the law collapses and the surfaces have one fractal dimension and hardness.

        wall: the grain of whose material and surface the walls are (default: of each grain's own). Returns `Tables`.
        """
        grains = dict(enumerate(self.grains, start=1))
        pairs = {(i, j): grains[i].contact(grains[j]) for i in grains for j in grains if i <= j}
        walls = {i: grain.contact(wall or grain, wall=True) for i, grain in grains.items()}
        alike = len({(g.surface.fractal_dimension, g.surface.hardness, g.material.hardness) for g in self.grains}) == 1
        if alike and self.bound(pairs[1, 1]).collapses:
            roughness = [g.surface.roughness for g in self.grains]
            same = len(set(roughness)) == 1
            if not same and not all(roughness):  # two smooth ones have no length that scales the table
                raise DemlawsError("a smooth grain beside a rough one: give a roughness to all grains, or to none")
            # the table ends at a tenth of the radius over the length: take the pair for which that is most
            widest = max([*pairs.values(), *walls.values()], key=lambda c: c.radius / (c.sigma or c.radius))
            file = self._save(folder, widest, f"{self.law}.tbl")
            return Tables(dict.fromkeys(pairs, file), dict.fromkeys(walls, file), None if same else roughness)
        return Tables(
            {(i, j): self._save(folder, contact, f"{self.law}.{i}-{j}.tbl") for (i, j), contact in pairs.items()},
            {i: self._save(folder, contact, f"{self.law}.{i}-wall.tbl") for i, contact in walls.items()},
            None,
        )

    def _save(self, folder, contact, file):
        self.bound(contact).tabulate(rtol=self.rtol).save(Path(folder) / file)
        return file

    def write(self, folder, script, engine):
        """Write in.case with the text `script` and its run.sh; returns in.case."""
        write_atomically(folder / "in.case", script)
        run = _RUN.format(python=shlex.quote(sys.executable), engine=engine, more=" --stock" if self.stock else "")
        write_atomically(folder / "run.sh", run)
        os.chmod(folder / "run.sh", 0o755)
        return folder / "in.case"


def make_case(law, grains, unloading, options, more):
    """The `Case` of an engine's `export`; law: also a Case itself."""
    return law if isinstance(law, Case) else Case(law, tuple(grains), unloading, dict(options or {}), **more)


def output_folder(folder):
    """`folder` as a Path, made with its folder post, into which a run writes; an in.case of somebody else is an error."""
    folder = as_path(folder)
    script = folder / "in.case"
    if os.path.isfile(script) and b"# written by demlaws " not in script.read_bytes()[:1000]:
        raise DemlawsError(f"{script} exists and was not written by demlaws: name another folder, or rename that file")
    try:
        (folder / "post").mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise DemlawsError(f"cannot make folder {folder / 'post'}: {error.strerror}") from error
    return folder


_RUN = """\
#!/bin/sh
# ./run.sh [ranks]
set -e
cd "$(dirname "$0")"
# DEMLAWS: another demlaws than the one that wrote this case
exec ${{DEMLAWS:-{python} -m demlaws}} {engine} run in.case -np "${{1:-1}}"{more}
"""
