"""The contacts of the current scene as arrays, and their energies."""

import math
from typing import NamedTuple

import numpy as np
import yade

from demlaws.yade import layout as at

O = yade.O  # noqa: E741  YADE's name


class ContactState(NamedTuple):
    """Contacts of a scene: arrays with one entry per contact, SI units. A state that the unloading rule does not have is NaN.

    branch: 0 where a contact is at its largest overlap so far (first loading), 1 below it (unloading or reloading).
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


class _Energies(NamedTuple):
    stored: float
    dissipated: float


class Totals(_Energies):
    """Energy in the normal direction [J]: `stored` in the contacts, and `dissipated` by plasticity since the law began.

    unaccounted: number of contacts that ended without the law (erased with a body, by the script or by another engine). What
    they had dissipated is not known and is missing in `dissipated`.
    """

    def __new__(cls, stored, dissipated, unaccounted=0):
        totals = super().__new__(cls, stored, dissipated)
        totals.unaccounted = unaccounted
        return totals

    def __repr__(self):
        missing = f", without the dissipation of {self.unaccounted} erased contacts" if self.unaccounted else ""
        return f"Totals(stored={self.stored!r}, dissipated={self.dissipated!r}{missing})"


def real_contacts():
    """The current scene's contacts that a law of ours acts on: exactly Mindlin's physics, not a class derived from it."""
    return [i for i in O.interactions if is_ours(i)]


def is_ours(contact):
    """Whether a contact is real and of the class that a law of ours acts on."""
    return contact.isReal and type(contact.phys) is yade.MindlinPhys


def rows_of(contacts):
    """The contacts as an array of `layout.CONTACT`."""
    rows = np.empty(len(contacts), at.CONTACT)
    for n, contact in enumerate(contacts):
        phys, overlap = contact.phys, contact.geom.penetrationDepth
        ratio, _, last = phys.prevU
        # a scene that has been loaded knows its overlaps only after a step
        known = last if math.isnan(overlap) else overlap
        rows[n] = (known, ratio, *phys.momentBend, *phys.momentTwist)
    return rows


def write_history(phys, row):
    """Put the history in a `layout.CONTACT` where `rows_of` reads it."""
    phys.momentBend = yade.Vector3(row["tag"], row["radius"], row["modulus"])
    phys.momentTwist = yade.Vector3(row["state0"], row["state1"], row["state2"])


def state_of(pairs, contacts):
    """`ContactState` of contacts that a law has seen."""
    rows = rows_of(contacts)
    seen = rows["tag"] > 0
    contacts = [contact for contact, keep in zip(contacts, seen, strict=True) if keep]
    rows = rows[seen]
    before = rows.copy()
    answer, _ = pairs.respond(rows)
    energies = pairs.energies(before)
    nothing = np.full(len(rows), np.nan)
    fields = dict(zip(pairs.state_names, ("state0", "state1", "state2"), strict=False))
    known = {
        name: before[fields[name]] if name in fields else nothing
        for name in ("maximum_overlap", "plastic_overlap", "radius_ratio")
    }
    if not fields:
        known["plastic_overlap"] = np.zeros(len(rows))
    overlap = before["overlap"].copy()
    touching = np.maximum(overlap, 0.0)
    return ContactState(
        np.array([c.id1 for c in contacts], int),
        np.array([c.id2 for c in contacts], int),
        overlap,
        answer["kno"] * touching * np.sqrt(touching),
        answer["tangent"].copy(),
        before["radius"].copy(),
        before["modulus"].copy(),
        np.array(pairs.roughnesses)[before["tag"].astype(int) - 1] if len(rows) else np.zeros(0),
        **known,
        stored=energies["stored"].copy(),
        dissipated=energies["dissipated"].copy(),
        branch=(overlap < known["maximum_overlap"]).astype(int),
    )
