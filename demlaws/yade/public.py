"""The law through YADE's public interface only: slow, for YADEs that the native bridge does not support.

InteractionLoop computes the geometry with a dummy law functor whose forces are discarded; Python sets kno and kso of every
contact; the forces are reset; Mindlin's law then acts through a LawDispatcher. `scene` puts these engines behind the user's
InteractionLoop and hides them.
"""

import numpy as np
import yade

from demlaws.errors import DemlawsError, EngineStopped
from demlaws.units import LARGEST_OVERLAP, LARGEST_ROUGHNESS, SMALL_OVERLAP, outside
from demlaws.yade import kernel, layout, native
from demlaws.yade.omega import LOOKS, is_our_contact
from demlaws.yade.shear import move_loop, relax_loop


class Held:
    """The history of a scene's contacts: reading and writing YADE objects is the cost of the public way."""

    def __init__(self, pairs):
        # the normal of the last step: vectors are turned by its change
        self.saved_dtype = np.dtype([("normal", "f8", (3,)), *pairs.saved.descr])
        self.keys, self.objects, self.rows, self.tangents = [], [], np.zeros(0, self.saved_dtype), ()

    def _rows(self, contacts):
        row_of = dict(zip(self.keys, self.rows, strict=True))
        rows = np.zeros(len(contacts), self.saved_dtype)
        for n, contact in enumerate(contacts):
            rows[n] = row_of.get(_key(contact), rows[n])
        return rows

    def rows_of(self, contacts):
        """The contacts as an array of `layout.CONTACT`; tag 0 where the law has not seen the contact."""
        return layout.copied(self._rows(contacts), layout.CONTACT)

    def saved(self, contacts):
        """Bodies and histories of contacts that the law has seen: what `restore` takes."""
        rows = self._rows(contacts)
        bodies = np.array([(c.id1, c.id2) for c in contacts], np.int64).reshape(-1, 2)
        return bodies[rows["tag"] > 0], rows[rows["tag"] > 0]

    def restore(self, bodies, saved, contacts):
        """Hold the history that `saved` has of contacts of a loaded scene; not of those that were cleared and made again."""
        place_of = {pair: place for place, pair in enumerate(map(tuple, bodies.tolist()))}
        mine = [c for c in contacts if (c.id1, c.id2) in place_of and c.phys.prevU[1] != 0.0]
        self.keys, self.objects = [_key(contact) for contact in mine], []
        self.rows = saved[[place_of[contact.id1, contact.id2] for contact in mine]].copy()

    def take(self, binding):
        """Read the contacts of this step."""
        contacts = [contact for contact in yade.O.interactions if contact.isReal]
        keys = [_key(contact) for contact in contacts]
        if keys == self.keys and len(self.objects) == len(keys):
            self.rows["overlap"] = [geom.penetrationDepth for geom, _, _ in self.objects]
            return
        for contact in contacts:
            if not is_our_contact(contact):
                raise DemlawsError(f"contact {contact.id1}+{contact.id2} is not described by MindlinPhys")
        self.rows = self._rows(contacts)
        self.keys, self.objects = keys, [(contact.geom, contact.phys, contact) for contact in contacts]
        for contact, row in zip(contacts, self.rows, strict=True):
            row["overlap"] = contact.geom.penetrationDepth
            if row["tag"] == 0.0:
                initialise_contact(binding, contact, row)


def _key(contact):
    return contact.id1, contact.id2, contact.iterMadeReal


def step(binding):
    """Set kno and kso of every contact and update its history."""
    yade.O.forces.f(0, True)  # or the threads' own sums survive the reset
    binding.answer()
    binding.guards += 1
    if binding.guards % 50 == 0:
        binding.judge_validity()
    if binding.guards % 50 == 0 or binding.guards in LOOKS:
        binding.check_bodies(thoroughly=True)
    memory, pairs, context = binding.memory, binding.pairs, binding.context
    memory.take(binding)
    rows = memory.rows
    if pairs.radii.mode == layout.CURVATURE_RADIUS:
        for (_, _, contact), row in zip(memory.objects, rows, strict=True):
            if row["modulus"] > 0.0 and row["overlap"] > 0.0:
                follow(binding, contact, row)
    separations = rows[rows["overlap"] <= 0]
    if len(separations):
        at_rest = separations.copy()
        at_rest["overlap"] = 0.0
        context["banked"] += pairs.energies(at_rest)["dissipated"].sum()
    deep = (rows["overlap"] > SMALL_OVERLAP * rows["radius"]) & (rows["modulus"] > 0.0)
    for n in np.flatnonzero(deep & (rows["overlap"] > LARGEST_OVERLAP * rows["radius"])):
        _stop(binding, memory.keys[n], layout.TOO_DEEP, rows["overlap"][n], rows["radius"][n])
    if deep.any() and not context["deep"]:
        context["deep"] = layout.REPORTED
        binding.warn_of_deep(rows)
    answer, bad = pairs.respond(rows)
    if bad >= 0:
        _stop(binding, memory.keys[bad], layout.NOT_FINITE, rows["overlap"][bad])
    stiffness = answer["kso"] * np.sqrt(np.maximum(rows["overlap"], 0.0))
    forces = relax_loop(rows, stiffness).tolist() if pairs.levels else None
    for n, ((_, phys, _), (kno, kso, *_)) in enumerate(zip(memory.objects, answer.tolist(), strict=True)):
        if forces is not None:
            phys.shearElastic = yade.Vector3(*forces[n])
        written = rows["written"][n]
        if abs(phys.kno + phys.kso - written) > 1e-9 * written and context["changed"] == layout.UNSEEN:
            context["changed"] = layout.SEEN
            context["changed_body1"], context["changed_body2"] = memory.keys[n][:2]
        if rows["overlap"][n] > 0.0:
            phys.kno, phys.kso = kno, kso
            rows["written"][n] = kno + kso
    rows["shear"] = stiffness
    memory.tangents = answer["tangent"].tolist()
    binding.warn_of_shapes()
    binding.refuse_changes()


def _stop(binding, bodies, kind, value, radius=None):
    text = binding.fault_text(kind, bodies[:2], value, radius=radius)
    raise EngineStopped(f"contact {bodies[0]}+{bodies[1]}{text}")


def initialise_contact(binding, contact, row):
    """Python counterpart of `kernel.initialise_contact`."""
    pairs, phys, geom, bodies = binding.pairs, contact.phys, contact.geom, (contact.id1, contact.id2)
    if phys.prevU[1] != 0.0:
        _stop(binding, bodies, layout.LOST_ROW, 0.0)
    radius = kernel.effective_radius(geom.refR1, geom.refR2)
    row["modulus"] = 0.75 * phys.kno / np.sqrt(radius)
    flat = any(isinstance(yade.O.bodies[n].shape, yade.Facet | yade.Wall | yade.Box) for n in bodies)
    row["radius"] = geom.refR2 if flat and pairs.flats == "plane" else radius
    labels = [yade.O.bodies[n].material.label for n in bodies]
    row["radius"] = starting_radius(binding, contact, row["radius"], labels, flat)
    if any(label not in pairs.surfaces for label in labels):
        binding.judge_unlisted(bodies)
    number = pairs.number(*labels)
    row["ratio"] = 0.0
    if phys.kno != 0.0:
        if outside("modulus", row["modulus"]):
            _stop(binding, bodies, layout.WRONG_MODULUS, row["modulus"])
        if not pairs.serves(number, row["radius"], row["modulus"]):
            _stop(binding, bodies, layout.WRONG_CONTACT, row["radius"])
        if pairs.roughnesses[number] > LARGEST_ROUGHNESS * row["radius"]:
            _stop(binding, bodies, layout.TOO_ROUGH, row["radius"])
        row["ratio"] = pairs.shear_ratio or phys.kso / (1.5 * phys.kno)
    row["tag"], row["normal"], row["written"] = number + 1, tuple(geom.normal), phys.kno + phys.kso
    phys.prevU = yade.Vector3(0, row["tag"], 0)
    binding.context["open"] += 1


def starting_radius(binding, contact, radius, labels, flat):
    """Python counterpart of `kernel.chosen_radius`."""
    radii, geom = binding.pairs.radii, contact.geom
    if radii.mode == layout.FUNCTION_RADIUS:
        return radii.call(contact)
    bodies = [yade.O.bodies[n] for n in (contact.id1, contact.id2)]
    odd = [type(body.shape).__name__ not in (*native.ROUND_SHAPES, "Facet", "Wall", "Box") for body in bodies]
    if not any(odd) or radii.mode != layout.BODY_RADIUS:
        return radius
    places = [binding.pairs.labels.index(label) if label in binding.pairs.surfaces else 0 for label in labels]
    edges = [radii.edges[place] if strange else 0.0 for place, strange in zip(places, odd, strict=True)]
    if any(strange and edge == 0.0 for strange, edge in zip(odd, edges, strict=True)):
        context = binding.context
        context["unknown_shape"] = max(context["unknown_shape"], layout.SEEN)
        context["unknown_shape_body1"], context["unknown_shape_body2"] = contact.id1, contact.id2
    return kernel.edged_radius(radius, geom.refR1, geom.refR2, *edges, flat)


def follow(binding, contact, row):
    """Python counterpart of `kernel.follow`."""
    bodies = contact.id1, contact.id2
    if all(isinstance(yade.O.bodies[n].shape, yade.Sphere | yade.Facet | yade.Wall | yade.Box) for n in bodies):
        return
    radius = binding.pairs.radii.shapes.of_contact(contact)
    if not radius > 0.0:
        _stop(binding, bodies, layout.FLAT_GAP if radius < 0.0 else layout.NO_CURVATURE, row["radius"])
    row["radius"] = binding.checked_radius(contact, row, radius)


def move_levels(memory):
    """Turn the stretches of all contacts with the contact, as ScGeom::rotate does, and add the displacement of the step; reduce
    them where Coulomb's limit has reduced the force."""
    motion = np.zeros((len(memory.objects), 4, 3))
    for n, (geom, phys, contact) in enumerate(memory.objects):
        first, second = (yade.O.bodies[number].state.angVel for number in (contact.id1, contact.id2))
        former = yade.Vector3(*memory.rows["normal"][n])
        twist = 0.5 * yade.O.dt * former.dot(first + second) * former
        if contact.iterMadeReal == yade.O.iter:  # it has no former normal
            twist = former = yade.Vector3.Zero
        motion[n] = former.cross(geom.normal), twist, geom.shearInc, phys.shearElastic
        memory.rows["normal"][n] = geom.normal
    move_loop(memory.rows, motion, np.array([phys.isSliding for _, phys, _ in memory.objects], bool))


def finish(binding, never_erase):
    """Leave the tangent where the time stepper looks for it; erase ended contacts, which LawDispatcher does not."""
    memory, separations = binding.held, []
    if binding.pairs.levels:
        move_levels(memory)
    for (_, phys, contact), overlap, tangent in zip(
        memory.objects, memory.rows["overlap"].tolist(), memory.tangents, strict=True
    ):
        if overlap > 0.0:
            phys.kn = tangent
        elif overlap < 0.0:
            separations.append(contact)
    if separations and not never_erase:
        for contact in separations:
            yade.O.interactions.erase(contact.id1, contact.id2)
        binding.context["open"] -= len(separations)
