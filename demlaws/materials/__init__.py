"""Typical values of materials with their sources, and what is taken where nothing is known of a material.

`dl.materials.glass` is a `Material` with a usual `Surface`; `typical("glass")` has the range and source of each value. The
values are in materials.csv. A quantity without a published value has none: a law that needs it raises an error.
"""

import csv
import functools
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from demlaws.contact import Material, Surface
from demlaws.errors import DemlawsError, did_you_mean
from demlaws.responses.results import Tabular
from demlaws.units import HANDY

__all__ = ["Typical", "Value", "basalt", "glass", "granite", "limestone", "material", "names", "quartz", "steel", "typical"]
granite: Material
glass: Material
steel: Material
quartz: Material
basalt: Material
limestone: Material

UNITS = {"GPa": ("Pa", 1e9), "µm": ("m", 1e-6)}
"""Unit in materials.csv → SI unit, and the unit in it."""
SYMBOLS = {
    "young": "E",
    "poisson": "ν",
    "hardness": "H",
    "density": "ρ",
    "roughness": "Sq",
    "fractal_dimension": "Df",
    "friction": "μ",
}


class Value(NamedTuple):
    """A typical value, its smallest and largest (None: unknown) in the SI unit `unit`, and its source."""

    value: float | None
    low: float | None
    high: float | None
    unit: str
    source: str

    def shown(self) -> tuple[str, str]:
        """Value and range in the unit in which people read them (`HANDY`); "?" where no value is known."""
        per = HANDY.get(self.unit, ("", 1.0))[1]
        first, low, high = (None if x is None else f"{x * per:.3g}" if x < 1000 else f"{x * per:.4g}" for x in self[:3])
        return first or "?", f"{low}–{high}" if low and low != high else ""

    def display(self) -> str:
        """Value, unit and range as text.

        >>> dl.materials.typical("granite")["young"].display()
        '60.6 GPa (50–62.1)'
        """
        first, between = self.shown()
        unit = HANDY.get(self.unit, (self.unit, 1.0))[0] if self.value is not None else ""
        return f"{first} {unit}".rstrip() + (f" ({between})" if between else "")


class Typical(Tabular):
    """Typical values of some materials: prints as a table, value above range."""

    most_rows = 100

    def __init__(self, names: Sequence[str]) -> None:
        self.names = names

    def columns(self) -> dict[str, Sequence]:
        """Materials and their values with units."""
        columns: dict[str, Sequence] = {"material": [text for name in self.names for text in (name, "")]}
        for quantity, symbol in SYMBOLS.items():
            values = [typical(name)[quantity] for name in self.names]
            unit = HANDY.get(values[0].unit, (values[0].unit, 1.0))[0]
            columns[f"{symbol} ({unit})" if unit else symbol] = [text for value in values for text in value.shown()]
        return columns


@functools.cache
def _read() -> dict[str, dict[str, Value]]:
    """Material → quantity → value."""
    found: dict[str, dict[str, Value]] = {}
    with open(Path(__file__).with_name("materials.csv"), encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            unit, factor = UNITS.get(row["unit"], (row["unit"], 1.0))
            first, low, high = (float(row[key]) * factor if row[key] else None for key in ("value", "low", "high"))
            found.setdefault(row["material"], {})[row["quantity"]] = Value(first, low, high, unit, row["source"])
    return found


def names() -> list[str]:
    """Names of the materials, each an attribute of this module.

    >>> dl.materials.names()
    ['granite', 'glass', 'steel', 'quartz', 'basalt', 'limestone']
    """
    return list(_read())


def typical(name: str) -> dict[str, Value]:
    """Values of a material with range and source: young, poisson, hardness, density, roughness, fractal_dimension, friction.

    >>> dl.materials.typical("glass")["friction"][:3]
    (0.16, 0.16, 0.28)
    """
    if name not in _read():
        hint = did_you_mean(name, names(), likeness=0.75)  # ballast is not basalt
        raise DemlawsError(f"no typical values of {name!r:.60}{hint} Materials: {', '.join(names())}")
    return dict(_read()[name])


def material(name: str) -> Material:
    """The material of this name with its usual surface.

    >>> dl.materials.material("granite") == dl.materials.granite
    True
    """
    values = {quantity: value.value for quantity, value in typical(name).items()}
    surface = None
    if values["roughness"] is not None:
        surface = Surface(values["roughness"], values["fractal_dimension"], values["hardness"])
    assert values["young"] is not None and values["poisson"] is not None
    return Material(values["young"], values["poisson"], values["hardness"], values["density"], surface)


if not TYPE_CHECKING:  # a type checker knows the names above and reports any other

    def __getattr__(name: str) -> Material:
        """The material of this name with its usual surface."""
        if name.startswith("_") or name not in _read():
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}; materials: {', '.join(names())}")
        return material(name)


def __dir__() -> list[str]:
    return sorted([*(name for name in globals() if name.startswith("__")), *__all__])
