"""Which law acts between which surfaces: from a user's arguments to the records that compiled code reads."""

import json
from pathlib import Path

import numba
import numpy as np

from demlaws.contact import Contact, Surface
from demlaws.errors import DemlawsError
from demlaws.law import Law, find, law
from demlaws.unloading import RULES, STATE_NAMES
from demlaws.yade import kernel

NOMINAL = {"radius": 5e-3, "modulus": 30e9}
"""Effective radius [m] and modulus [Pa] with which a law is made and checked where YADE's contacts are not known yet."""


def _surface(label, value):
    if isinstance(value, Surface):
        return value
    if isinstance(value, dict):
        try:
            return Surface(**value)
        except TypeError as error:
            raise DemlawsError(f"surfaces[{label!r}]: {error}") from None
    raise DemlawsError(f"surfaces[{label!r}] must be a demlaws.Surface, got {value!r}")


class Pairs:
    """Laws between labelled surfaces. Number 0 stands for every material whose label is not listed: smooth.

    law: a name, a `Law`, a `Table`, or the path of a saved table. A pair of smooth surfaces is Hertz unless the law
    means more than roughness (a yielding bulk). labels, hashes, numbers (pair of surfaces → record) and records are
    what `kernel.act` reads; shapes and roughnesses are those of each record, None for Hertz.
    """

    def __init__(self, law_given, surfaces, unloading, options, typical=None):
        surfaces = {label: _surface(label, value) for label, value in (surfaces or {}).items()}
        if "" in surfaces:
            raise DemlawsError("a surface needs a label: the label of the YADE materials that have it")
        self.typical = {**NOMINAL, **(typical or {})}
        self.table = _as_table(law_given)
        if self.table is not None:
            self.name, self.options = self.table.name, {}
            if options:
                raise DemlawsError(f"a table takes no options, got {', '.join(options)}: give them when tabulating")
            self.unloading = self.table.unloading if unloading is None else unloading
        elif isinstance(law_given, Law):
            self.name, self.options = law_given.name, {**law_given.options, **options}
            self.unloading = law_given.unloading if unloading is None else unloading
        else:
            self.name, self.options = find(law_given).name, dict(options)
            self.unloading = "elastic" if unloading is None else unloading
        if self.unloading not in RULES:
            raise DemlawsError(f"unknown unloading rule {self.unloading!r}: the rules are {', '.join(RULES)}")
        if isinstance(law_given, Law) and not surfaces:
            raise DemlawsError("give surfaces={label: demlaws.Surface(...)} for the materials that the law or table is for")
        self.rule = RULES[self.unloading]
        self.state_names = STATE_NAMES[self.unloading]
        self.surfaces = surfaces
        self.labels = ["", *surfaces]
        self._make_records([Surface(), *surfaces.values()])
        self.hashes = np.array([0] + [kernel.label_hash(label) for label in surfaces], np.int64)

    def _make_records(self, surfaces):
        count = len(surfaces)
        self.numbers = np.zeros((count, count), np.int64)
        self.shapes, self.roughnesses = [], []
        for i in range(count):
            for j in range(i + 1):
                self.numbers[i, j] = self.numbers[j, i] = len(self.shapes)
                pair = surfaces[i].combined(surfaces[j])
                self.shapes.append(self._shape(pair, self.labels[j], self.labels[i]))
                self.roughnesses.append(pair.roughness)
        kinds = {numba.typeof(shape) for shape in self.shapes if shape is not None}
        if len(kinds) > 1:
            raise DemlawsError(f"the pairs of surfaces need laws of one kind, got {len(kinds)}")
        self.kind = kinds.pop() if kinds else numba.typeof(_hertz_shape())
        self._keep = []
        rows = []
        for shape, roughness in zip(self.shapes, self.roughnesses, strict=True):
            words = [] if shape is None else kernel.pack(shape, self._keep)
            rows.append([int(shape is None), int(np.float64(roughness).view(np.int64)), *words])
        width = max(len(row) for row in rows)
        self.records = np.array([row + [0] * (width - len(row)) for row in rows], np.int64)

    def _shape(self, surface, first, second):
        """The law's shape for a pair, or None where it is Hertz."""
        if self.table is not None:
            return None if surface.roughness == 0.0 else self.table.shape
        dimension = surface.fractal_dimension
        if surface.roughness == 0.0 and dimension is None:
            dimension = 2.0  # without roughness it does not matter, but the law wants one
        contact = Contact(
            roughness=surface.roughness, fractal_dimension=dimension, hardness=surface.hardness, **self.typical
        )
        try:
            return law(self.name, contact, self.unloading, **self.options).shape
        except DemlawsError as error:
            if surface.roughness == 0.0 and any(getattr(contact, name) is None for name in find(self.name).needs):
                return None
            pair = " on ".join(repr(label or "a smooth surface") for label in (first, second))
            raise DemlawsError(f"surfaces {pair}: {error}") from None

    def as_text(self):
        """JSON from which `from_text` makes the same pairs in another process."""
        content = {
            "law": self.name,
            "unloading": self.unloading,
            "options": self.options,
            "typical": self.typical,
            "surfaces": {label: vars(surface) for label, surface in self.surfaces.items()},
        }
        if self.table is not None:
            content["table"] = self.table.as_text()
        try:
            return json.dumps(content)
        except TypeError as error:
            raise DemlawsError(f"the law's options cannot be saved with the simulation: {error}") from None

    @classmethod
    def from_text(cls, text):
        content = json.loads(text)
        given = content["law"]
        if "table" in content:
            from demlaws.table import Table

            given = Table.from_text(content["table"])
        return cls(given, content["surfaces"], content["unloading"], content["options"], content["typical"])


def _hertz_shape():
    from demlaws.laws.hertz import Shape

    return Shape()


def _as_table(given):
    if isinstance(given, Path) or (isinstance(given, str) and ("/" in given or "." in given)):
        from demlaws.table import Table

        return Table.load(given)
    if isinstance(given, Law) and hasattr(given, "save"):
        return given
    return None
