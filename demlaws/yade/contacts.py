"""The contacts of the current scene as arrays, and their energies."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import yade

from demlaws.admissible import RANGES
from demlaws.results import Tabular

O = yade.O  # noqa: E741  YADE's name
PHYSICS = tuple(getattr(yade, name) for name in ("MindlinPhys", "MindlinCapillaryPhys") if hasattr(yade, name))
LOOKS = (2, 3, 12, 102, 1002)
"""Calls of the guard with a check of every contact and body, which takes time."""


@dataclass(frozen=True, eq=False, repr=False)
class ContactState(Tabular):
    """Contacts of a scene: arrays with one entry per contact, SI units. A state that the unloading rule does not have is NaN.

    `len(state)` is the number of contacts; `print`, `to_dataframe()` give a row for each. `COLUMNS` describes the arrays.
    """

    body1: np.ndarray
    body2: np.ndarray
    overlap: np.ndarray
    force: np.ndarray
    stiffness: np.ndarray
    radius: np.ndarray
    modulus: np.ndarray
    roughness: np.ndarray
    maximum_overlap: np.ndarray
    plastic_overlap: np.ndarray
    radius_ratio: np.ndarray
    stored: np.ndarray
    dissipated: np.ndarray
    branch: np.ndarray
    yielded: np.ndarray

    def __len__(self):
        return self.overlap.size

    def __repr__(self):
        return f"<{len(self)} contacts: {', '.join(COLUMNS)}>"

    def columns(self):
        """Title with unit → values of each array."""
        return {f"{name} ({unit})" if unit else name: getattr(self, name) for name, (unit, _) in COLUMNS.items()}


COLUMNS = {
    "body1": ("", "number of the first body"),
    "body2": ("", "number of the second body"),
    "overlap": ("m", "present overlap δ"),
    "force": ("N", "normal force P of the law, without damping"),
    "stiffness": ("N/m", "tangent dP/dδ, of unloading where the contact unloads"),
    "radius": ("m", "effective radius R with which the law computes"),
    "modulus": ("Pa", "contact modulus E*"),
    "roughness": ("m", "combined roughness σ"),
    "maximum_overlap": ("m", "largest overlap since the bodies touched; NaN with unloading `elastic`"),
    "plastic_overlap": ("m", "overlap at which the force vanishes on unloading"),
    "radius_ratio": ("", "R_p/R of the curve of unloading (rules `thornton`, `etsion`, `jackson`); NaN with others"),
    "stored": ("J", "energy that unloading returns"),
    "dissipated": ("J", "energy that plastic deformation has taken since the bodies touched"),
    "branch": ("", "0: at the largest overlap so far (first loading); 1: below it (unloading or reloading)"),
    "yielded": (
        "",
        "whether the bulk has yielded since the bodies touched; of a law without a yield point, whether the contact has "
        "dissipated energy",
    ),
}
"""Name of an array of `ContactState` → unit, meaning."""


class _Energies(NamedTuple):
    stored: float
    dissipated: float


class Totals(_Energies):
    """Energy in the normal direction [J]: `stored` in the contacts, and `dissipated` by plasticity since the law began.

    unaccounted: number of contacts that ended without the law (erased with a body, by the script or by another engine). What
    they had dissipated is not known and is missing in `dissipated`.
    """

    def __new__(cls, stored, dissipated, unaccounted=0, *, shear_stored=math.nan, shear_dissipated=math.nan, viscous=math.nan):
        """A pair of energies, and what else is known of them."""
        totals = super().__new__(cls, stored, dissipated)
        totals.unaccounted, totals.shear_stored, totals.shear_dissipated = unaccounted, shear_stored, shear_dissipated
        totals.viscous = viscous
        return totals

    def __repr__(self):
        missing = f", without the dissipation of {self.unaccounted} erased contacts" if self.unaccounted else ""
        shear = f"shear_stored={self.shear_stored!r}, shear_dissipated={self.shear_dissipated!r}, viscous={self.viscous!r}"
        return f"Totals(stored={self.stored!r}, dissipated={self.dissipated!r}, {shear}{missing})"


def real_contacts():
    """The current scene's contacts that a law of ours acts on."""
    return [i for i in O.interactions if is_ours(i)]


def is_ours(contact):
    """Whether a contact is real and of a class that a law of ours acts on."""
    return contact.isReal and type(contact.phys) in PHYSICS


def radius_fault(body):
    """Message about a sphere whose radius is not a positive number, or None."""
    radius = body.shape.radius if isinstance(body.shape, yade.Sphere) else 1.0
    if 0.0 < radius < math.inf:
        return None
    return f"body {body.id} is a sphere with radius = {radius:g} m: {RANGES['radius'].remedy}"


def with_overlaps(rows, contacts):
    """Rows of `layout.CONTACT` with the present overlaps, which a loaded scene does not know before its first step."""
    for row, contact in zip(rows, contacts, strict=True):
        overlap = contact.geom.penetrationDepth
        if not math.isnan(overlap):
            row["overlap"] = overlap
    return rows


def state_of(pairs, contacts, rows):
    """`ContactState` of contacts that a law has seen; rows: their histories."""
    active = rows["tag"] > 0
    contacts = [contact for contact, keep in zip(contacts, active, strict=True) if keep]
    rows = rows[active]
    before = rows.copy()
    answer, _ = pairs.respond(rows)
    energies = pairs.energies(before)
    nothing = np.full(len(rows), np.nan)
    fields = {name: before["state"][:, n] for n, name in enumerate(pairs.state_names)}
    columns = {name: fields.get(name, nothing) for name in ("maximum_overlap", "plastic_overlap", "radius_ratio")}
    if not fields:
        columns["plastic_overlap"] = np.zeros(len(rows))
    overlap = before["overlap"].copy()
    highest = np.fmax(overlap, columns["maximum_overlap"])
    return ContactState(
        np.array([c.id1 for c in contacts], int),
        np.array([c.id2 for c in contacts], int),
        overlap,
        answer["force"].copy(),
        answer["tangent"].copy(),
        before["radius"].copy(),
        before["modulus"].copy(),
        np.array(pairs.roughnesses)[before["tag"].astype(int) - 1] if len(rows) else np.zeros(0),
        **columns,
        stored=energies["stored"].copy(),
        dissipated=energies["dissipated"].copy(),
        branch=(overlap < columns["maximum_overlap"]).astype(int),
        yielded=pairs.yielded(before, highest, energies),
    )
