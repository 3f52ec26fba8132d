"""The contacts of the current scene as a table, and their energies."""

from collections import namedtuple

import numpy as np
import yade

from demlaws.responses.results import Tabular
from demlaws.units import number

O = yade.O  # noqa: E741  YADE's name


class Totals(Tabular, namedtuple("Energies", ("stored", "dissipated"))):
    """Energies [J] in the normal direction: `stored` in the contacts, and `dissipated` by plasticity since the law began.

    shear_stored, shear_dissipated: of shear, the latter by friction and opening; viscous: taken by damping. unaccounted: number
    of contacts that ended without the law (erased with a body, by the script or by another engine). What they had dissipated is
    not known and is missing.
    """

    def __new__(cls, stored, dissipated, **more):
        """A pair of energies, and what else is known of them."""
        totals = super().__new__(cls, stored, dissipated)
        vars(totals).update(more)
        return totals

    def __array__(self, dtype=None, copy=None):
        return np.array(tuple(self), dtype)

    def columns(self):
        """One row: the energies and the number of contacts that are unaccounted for."""
        energies = self._asdict() | vars(self)
        return {name.replace("_", " ") + " (J)" * (name != "unaccounted"): [value] for name, value in energies.items()}


SHEAR = {"shear_stored": "held", "shear_dissipated": "lost", "viscous": "viscous"}
"""Energy of `Contacts` → field of a contact's history."""


def state_of(pairs, contacts, rows, strength=None):
    """`Contacts` that a law has seen; rows: their histories; strength: of the column `above` [Pa]."""
    from demlaws.responses.contacts import Contacts

    active = rows["tag"] > 0
    contacts = [contact for contact, keep in zip(contacts, active, strict=True) if keep]
    rows = rows[active]
    before = rows.copy()
    answer, _ = pairs.evaluate(rows)
    nothing = np.full(len(rows), np.nan)
    fields = {name: before["state"][:, n] for n, name in enumerate(pairs.state_names)}
    columns = {name: fields.get(name, nothing) for name in ("maximum_overlap", "plastic_overlap", "radius_ratio")}
    if not fields:
        columns["plastic_overlap"] = np.zeros(len(rows))
    overlap = before["overlap"].copy()
    centres = [_ends(contact) for contact in contacts]
    shears = [contact.phys.shearForce.norm() for contact in contacts]
    return Contacts(
        body1=np.array([c.id1 for c in contacts], int),
        body2=np.array([c.id2 for c in contacts], int),
        overlap=overlap,
        force=answer["force"].copy(),
        stiffness=answer["tangent"].copy(),
        radius=before["radius"].copy(),
        modulus=before["modulus"].copy(),
        sigma=np.array(pairs.roughnesses)[before["tag"].astype(int) - 1] if len(rows) else np.zeros(0),
        **columns,
        stored=answer["stored"].copy(),
        dissipated=answer["dissipated"].copy(),
        branch=(overlap < columns["maximum_overlap"]).astype(int),
        flattened=answer["dissipated"] > 1e-9 * (answer["stored"] + answer["dissipated"]),
        bulk_yielded=answer["yielded"] > 0.0 if pairs.yields.any() else None,
        mean_pressure=answer["pressure"].copy(),
        above=None if strength is None else answer["pressure"] > number(strength, "strength", "Pa"),
        sliding=np.array([bool(c.phys.isSliding) for c in contacts], bool),
        shear_force=np.array(shears, float),
        **{name: before[field].copy() for name, field in SHEAR.items()},
        centre1=np.array([ends[0] for ends in centres], float).reshape(-1, 3),
        centre2=np.array([ends[1] for ends in centres], float).reshape(-1, 3),
    )


def _ends(contact):
    """Centres of both bodies, the second one's image where it lies across a periodic face; on a wall the contact's point."""
    ends = []
    for body_number, image in ((contact.id1, (0, 0, 0)), (contact.id2, contact.cellDist)):
        body = O.bodies[body_number]
        if body is None or not isinstance(body.shape, yade.Sphere):
            ends.append(tuple(contact.geom.contactPoint))
        elif O.periodic:
            ends.append(tuple(body.state.pos + O.cell.hSize * type(body.state.pos)(*image)))
        else:
            ends.append(tuple(body.state.pos))
    return ends
