"""The law through YADE's public interface only: slow, for YADEs that the native bridge does not support.

InteractionLoop computes the geometry with a dummy law functor whose forces are discarded; Python sets kno and kso of every
contact; the forces are reset; Mindlin's law then acts through a LawDispatcher. `scene` puts these engines behind the user's
InteractionLoop and hides them.
"""

import numpy as np
import yade

from demlaws.errors import DemlawsError, EngineStopped
from demlaws.units import LARGEST_OVERLAP, SMALL_OVERLAP
from demlaws.yade import kernel
from demlaws.yade import layout as at
from demlaws.yade.contacts import is_ours, rows_of, write_history


class Held:
    """A scene's contacts between steps: reading and writing YADE objects is the cost of the public way."""

    def __init__(self):
        self.keys, self.objects, self.rows, self.tangents = [], [], np.zeros(0, at.CONTACT), ()
        self.valid_at = None  # (scene, step) at which this may be used

    def flush(self):
        """Write the history to YADE's objects, where saving and reading look for it."""
        for (_, phys, _), row in zip(self.objects, self.rows, strict=True):
            write_history(phys, row)

    def take(self, binding):
        """The contacts of this step: those held if they are the same ones."""
        omega = yade.O
        contacts = [contact for contact in omega.interactions if contact.isReal]
        keys = [(contact.id1, contact.id2, contact.iterMadeReal) for contact in contacts]
        known = self.valid_at == (binding.scene, omega.iter)
        if known and keys == self.keys:
            self.rows["overlap"] = [geom.penetrationDepth for geom, _, _ in self.objects]
        else:
            if known:
                self.flush()
            for contact in contacts:
                if not is_ours(contact):
                    raise DemlawsError(f"contact {contact.id1}+{contact.id2} is not described by MindlinPhys")
            self.keys, self.rows = keys, rows_of(contacts)
            self.objects = [(contact.geom, contact.phys, contact) for contact in contacts]
            for contact, row in zip(contacts, self.rows, strict=True):
                if row["tag"] == 0.0:
                    initialise_contact(binding, contact, row)
            self.flush()
        self.valid_at = binding.scene, omega.iter + 1


def step(binding):
    """Set kno and kso of every contact and update its history."""
    yade.O.forces.f(0, True)  # or the threads' own sums survive the reset
    binding.answer()
    if binding.held is None:
        binding.held = Held()
    held, pairs, context = binding.held, binding.pairs, binding.context
    held.take(binding)
    rows = held.rows
    ending = rows[rows["overlap"] <= 0]
    if len(ending):
        at_rest = ending.copy()
        at_rest["overlap"] = 0.0
        context.doubles[at.BANKED] += pairs.energies(at_rest)["dissipated"].sum()
    deep = (rows["overlap"] > SMALL_OVERLAP * rows["radius"]) & (rows["modulus"] > 0.0)
    for n in np.flatnonzero(deep & (rows["overlap"] > LARGEST_OVERLAP * rows["radius"])):
        _stop(binding, held.keys[n], at.TOO_DEEP, rows["overlap"][n], rows["radius"][n])
    if deep.any() and not context.words[at.DEEP]:
        context.words[at.DEEP] = 2
        binding.warn_of_deep(rows)
    answer, bad = pairs.respond(rows)
    if bad >= 0:
        _stop(binding, held.keys[bad], at.NOT_FINITE, rows["overlap"][bad])
    overlaps = rows["overlap"].tolist()
    for (_, phys, _), overlap, (kno, kso, _) in zip(held.objects, overlaps, answer.tolist(), strict=True):
        if overlap > 0.0:
            share = kernel.kept_share(kso, overlap, phys.kso, phys.prevU[2])
            if share < 1.0:
                phys.shearElastic = share * phys.shearElastic
            phys.kno = kno
            phys.kso = kso
            phys.prevU = yade.Vector3(phys.prevU[0], 0, overlap)
    held.tangents = answer["tangent"].tolist()


def _stop(binding, bodies, kind, value, radius=None):
    first, second = bodies[:2]
    raise EngineStopped(f"contact {first}+{second}{binding.fault_text(kind, first, second, value, radius)}")


def initialise_contact(binding, contact, row):
    """Python counterpart of `kernel.initialise_contact`."""
    pairs, phys, geom, bodies = binding.pairs, contact.phys, contact.geom, (contact.id1, contact.id2)
    radius = kernel.effective_radius(geom.refR1, geom.refR2)
    row["modulus"] = 0.75 * phys.kno / np.sqrt(radius)
    flat = any(isinstance(yade.O.bodies[n].shape, yade.Facet | yade.Wall | yade.Box) for n in bodies)
    row["radius"] = geom.refR2 if flat and pairs.flats == "plane" else radius
    labels = [yade.O.bodies[n].material.label for n in bodies]
    if any(label not in pairs.surfaces for label in labels):
        binding.judge_unlisted(bodies)
    number = pairs.number(*labels)
    row["ratio"] = 0.0
    if phys.kno != 0.0:
        if not 0.0 < phys.kno < np.inf:
            _stop(binding, bodies, at.WRONG_MODULUS, row["modulus"])
        if not pairs.serves(number, row["radius"], row["modulus"]):
            _stop(binding, bodies, at.WRONG_CONTACT, row["radius"])
        if pairs.roughnesses[number] > row["radius"]:
            _stop(binding, bodies, at.TOO_ROUGH, row["radius"])
        row["ratio"] = binding.ratio or phys.kso / (1.5 * phys.kno)
    row["tag"] = number + 1
    phys.prevU = yade.Vector3(row["ratio"], 0, 0)
    binding.context.words[at.OPEN] += 1


def finish(binding, never_erase):
    """Leave the tangent where the time stepper looks for it; erase ended contacts, which LawDispatcher does not."""
    held, ended = binding.held, []
    for (_, phys, contact), overlap, tangent in zip(held.objects, held.rows["overlap"].tolist(), held.tangents, strict=True):
        if overlap > 0.0:
            phys.kn = tangent
        elif overlap < 0.0:
            ended.append(contact)
    if ended and not never_erase:
        for contact in ended:
            yade.O.interactions.erase(contact.id1, contact.id2)
        binding.context.words[at.OPEN] -= len(ended)
