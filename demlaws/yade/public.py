"""The law through YADE's public interface only: slow, for YADEs that the native bridge does not know.

InteractionLoop computes the geometry with a law functor whose forces are thrown away; Python sets kno and kso of every
contact; the forces are reset; Mindlin's law then acts through a LawDispatcher of its own. The engines behind the user's
InteractionLoop are hidden from him, as the guard of the native way is (see `scene`).
"""

import numpy as np
import yade

from demlaws.core.shear import CHOICES
from demlaws.errors import DemlawsError
from demlaws.units import LARGEST_OVERLAP, SMALL_OVERLAP, too_large_overlap
from demlaws.yade import kernel
from demlaws.yade.contacts import is_ours, rows_of, write_history
from demlaws.yade.pairs import NOT_SERVED

PREPARE = "__import__('demlaws.yade').yade.public_step({label!r})"
FINISH = "__import__('demlaws.yade').yade.public_finish({label!r})"
AWAY = "demlaws_throws_away_"
HIDDEN = 4
"""Engines behind the InteractionLoop: PyRunner, ForceResetter, LawDispatcher, PyRunner."""


def stands_for(functor):
    """Label of the law in whose stead a functor makes forces that are thrown away, or None."""
    return functor.label.removeprefix(AWAY) if functor.label.startswith(AWAY) else None


def begins_hidden(engine):
    """Whether this is the first of the hidden engines."""
    return isinstance(engine, yade.PyRunner) and engine.command.startswith(PREPARE.split("{")[0])


def check(engines, place, functor):
    """Refuse engine lists in which the public way cannot act; `place`: that of the InteractionLoop."""
    loop = engines[place]
    for engine in engines[:place]:
        if not isinstance(engine, yade.ForceResetter | yade.Collider | yade.PyRunner | yade.TimeStepper):
            raise DemlawsError(
                f"{type(engine).__name__} stands before InteractionLoop: the public way resets forces behind it; put engines "
                "that apply forces after InteractionLoop"
            )
    if not isinstance(loop, yade.InteractionLoop):
        raise DemlawsError(
            f"the public way needs the law in an InteractionLoop of the engine list, not in {type(loop).__name__}"
        )
    others = [f for f in loop.lawDispatcher.functors if f is not functor and stands_for(f) != functor.label]
    if others or loop.callbacks:
        raise DemlawsError("the public way cannot share its InteractionLoop with other law functors or callbacks")


def hidden_engines(functor):
    """The engines to be put behind the user's InteractionLoop."""
    return [
        yade.PyRunner(command=PREPARE.format(label=functor.label), iterPeriod=1, initRun=True),
        yade.ForceResetter(),
        yade.LawDispatcher([functor]),
        yade.PyRunner(command=FINISH.format(label=functor.label), iterPeriod=1, initRun=True),
    ]


def throw_away(label):
    """A functor that stands in the user's InteractionLoop while the law acts behind it."""
    return yade.Law2_ScGeom_MindlinPhys_HertzWithLinearShear(neverErase=True, label=AWAY + label)


def _label(body):
    return yade.O.bodies[body].material.label


class Held:
    """A scene's contacts between steps: reading and writing YADE objects is what the public way costs."""

    def __init__(self):
        self.keys, self.objects, self.rows, self.tangents = [], [], np.zeros(0, kernel.CONTACT), ()
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
                    first_sight(binding, contact, row)
            self.flush()
        self.valid_at = binding.scene, omega.iter + 1


def step(binding):
    """Set kno and kso of every contact and move its history on."""
    yade.O.forces.f(0, True)  # or the threads' own sums survive the reset
    binding.answer()
    held, pairs = binding.held, binding.pairs
    held.take(binding)
    rows = held.rows
    ending = rows[rows["overlap"] <= 0]
    if len(ending):
        at_rest = ending.copy()
        at_rest["overlap"] = 0.0
        binding.banked += float(pairs.energies(at_rest)["dissipated"].sum())
    deepest = rows[rows["overlap"] > SMALL_OVERLAP * rows["radius"]]
    if len(deepest) and np.any(deepest["modulus"] > 0.0):
        for (first, second, _), row in zip(held.keys, rows, strict=True):
            if row["overlap"] > LARGEST_OVERLAP * row["radius"] and row["modulus"] > 0.0:
                raise DemlawsError(f"contact {first}+{second}: {too_large_overlap(row['overlap'], row['radius'])}")
        binding.tell_deep(rows)
    answer, bad = pairs.respond(rows)
    if bad >= 0:
        first, second, _ = held.keys[bad]
        raise DemlawsError(
            f"contact {first}+{second} at overlap {rows['overlap'][bad]:g} m: the law gives no finite force there"
        )
    overlaps = rows["overlap"]
    for (_, phys, _), overlap, (kno, kso, _) in zip(held.objects, overlaps.tolist(), answer.tolist(), strict=True):
        if overlap > 0.0:
            limit_shear(pairs, phys, kno, kso, overlap)
            phys.kno = kno
            phys.kso = kso
            phys.prevU = yade.Vector3(phys.prevU[0], 0, overlap)
    held.tangents = answer["tangent"].tolist()


def limit_shear(pairs, phys, kno, kso, overlap):
    """What `kernel.limit_shear` does."""
    if not CHOICES[pairs.shear_name].limited:
        return
    share = kernel.kept_share(kno, kso, overlap, phys.kno, phys.kso, phys.prevU[2])
    if share < 1.0:
        phys.shearElastic = share * phys.shearElastic


def first_sight(binding, contact, row):
    """What `kernel.first_sight` does."""
    pairs, phys, geom = binding.pairs, contact.phys, contact.geom
    radius = kernel.effective_radius(geom.refR1, geom.refR2)
    row["modulus"] = 0.75 * phys.kno / np.sqrt(radius)
    flat = any(isinstance(yade.O.bodies[n].shape, yade.Facet | yade.Wall | yade.Box) for n in (contact.id1, contact.id2))
    row["radius"] = geom.refR2 if flat and pairs.flats == "plane" else radius
    labels = [_label(body) for body in (contact.id1, contact.id2)]
    if any(label not in pairs.surfaces for label in labels):
        binding.judge_unlisted((contact.id1, contact.id2))
    number = pairs.number(*labels)
    row["ratio"] = 0.0
    if phys.kno != 0.0:
        if not 0.0 < phys.kno < np.inf:
            raise DemlawsError(binding.wrong_modulus(contact.id1, contact.id2, row["modulus"]))
        if not pairs.serves(number, row["radius"], row["modulus"]):
            raise DemlawsError(f"contact {contact.id1}+{contact.id2} with R = {row['radius']:g} m: {NOT_SERVED}")
        if pairs.roughnesses[number] > row["radius"]:
            raise DemlawsError(binding.too_rough(contact.id1, contact.id2, row["radius"]))
        row["ratio"] = binding.ratio or phys.kso / (1.5 * phys.kno)
    row["tag"] = number + 1
    phys.prevU = yade.Vector3(row["ratio"], 0, 0)


def finish(binding, never_erase):
    """Leave the tangent where the time stepper looks for it; erase ended contacts, which LawDispatcher does not."""
    held, ended = binding.held, []
    for (_, phys, contact), overlap, tangent in zip(held.objects, held.rows["overlap"].tolist(), held.tangents, strict=True):
        if overlap > 0.0:
            phys.kn = tangent
        elif overlap < 0.0:
            ended.append(contact)
    if ended and not never_erase:
        interactions = yade.O.interactions
        for contact in ended:  # `step` has banked what they dissipated: YADE's own function, without the account
            erase = type(interactions).erase
            getattr(erase, "native", erase)(interactions, contact.id1, contact.id2)
