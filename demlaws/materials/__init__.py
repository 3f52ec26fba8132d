"""Typical values of materials with their sources, and what is taken where nothing is known of a material.

`dl.materials.glass` is a `Material` with a usual `Surface`; `typical("glass")` has the range and source of each value. The
values are in materials.csv. A quantity that no public text gives has no value: a law that needs it raises an error.
"""

import csv
import functools
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

from demlaws.contact import Material, Surface
from demlaws.errors import DemlawsError, did_you_mean
from demlaws.responses.results import Tabular

__all__ = ["Typical", "Value", "basalt", "glass", "granite", "limestone", "names", "quartz", "steel", "typical"]
granite: Material
glass: Material
steel: Material
quartz: Material
basalt: Material
limestone: Material

UNITS = {"GPa": 1e9, "µm": 1e-6}
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
    """A typical value, its smallest and largest in SI units (None: unknown), the unit it is shown in, and its source."""

    value: float | None
    low: float | None
    high: float | None
    unit: str
    source: str

    def shown(self) -> tuple[str, str]:
        """Value and range in the unit; "?" where no value is known."""
        factor = UNITS.get(self.unit, 1.0)
        first, low, high = (None if x is None else f"{x / factor:.3g}" if x < 1000 else f"{x / factor:.4g}" for x in self[:3])
        return first or "?", f"{low}–{high}" if low and low != high else ""


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
            unit = next(value.unit for value in values)
            columns[f"{symbol} ({unit})" if unit else symbol] = [text for value in values for text in value.shown()]
        return columns


@functools.cache
def _read() -> dict[str, dict[str, Value]]:
    """Material → quantity → value."""
    found: dict[str, dict[str, Value]] = {}
    with open(Path(__file__).with_name("materials.csv"), encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            factor = UNITS.get(row["unit"], 1.0)
            first, low, high = (float(row[key]) * factor if row[key] else None for key in ("value", "low", "high"))
            found.setdefault(row["material"], {})[row["quantity"]] = Value(first, low, high, row["unit"], row["source"])
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
        raise DemlawsError(f"no typical values of {name!r}{did_you_mean(name, names())} Materials: {', '.join(names())}")
    return dict(_read()[name])


def __getattr__(name: str) -> Any:
    """The material of this name with its usual surface."""
    if name.startswith("_") or name not in _read():
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}; materials: {', '.join(names())}")
    values = {quantity: value.value for quantity, value in typical(name).items()}
    surface = None
    if values["roughness"] is not None:
        surface = Surface(values["roughness"], values["fractal_dimension"], values["hardness"])
    assert values["young"] is not None and values["poisson"] is not None
    return Material(values["young"], values["poisson"], values["hardness"], values["density"], surface)


def __dir__() -> list[str]:
    return sorted([*(name for name in globals() if name.startswith("__")), *__all__])
