"""The law through YADE's public interface only: slow, for YADEs that the native bridge does not know.

InteractionLoop computes the geometry with a law functor whose forces are thrown away; Python sets kno and kso of every
contact; the forces are reset; Mindlin's law then acts through a LawDispatcher of its own.
"""

import numpy as np
import yade

from demlaws.errors import DemlawsError
from demlaws.yade import kernel

PREPARE = "__import__('demlaws.yade').yade.public_step({label!r})"
FINISH = "__import__('demlaws.yade').yade.public_finish({label!r})"


def rewritten(engines, functor):
    """The engine list with `functor` in a LawDispatcher of its own behind the code that sets its coefficients."""
    label = functor.label
    commands = (PREPARE.format(label=label), FINISH.format(label=label))
    if any(isinstance(e, yade.PyRunner) and e.command in commands for e in engines):
        return engines
    place = next(
        n for n, e in enumerate(engines) if isinstance(e, yade.InteractionLoop) and functor in e.lawDispatcher.functors
    )
    loop = engines[place]
    for engine in engines[:place]:
        if not isinstance(engine, yade.ForceResetter | yade.Collider | yade.PyRunner | yade.TimeStepper):
            raise DemlawsError(
                f"{type(engine).__name__} stands before InteractionLoop: the public way resets forces behind it; put engines "
                "that apply forces after InteractionLoop"
            )
    others = [f for f in loop.lawDispatcher.functors if f is not functor]
    if others or loop.callbacks:
        raise DemlawsError("the public way cannot share its InteractionLoop with other law functors or callbacks")
    throw_away = yade.Law2_ScGeom_MindlinPhys_HertzWithLinearShear(neverErase=True)
    geometry = yade.InteractionLoop(
        list(loop.geomDispatcher.functors), list(loop.physDispatcher.functors), [throw_away], label=loop.label
    )
    return [
        *engines[:place],
        geometry,
        yade.PyRunner(command=commands[0], iterPeriod=1, initRun=True),
        yade.ForceResetter(),
        yade.LawDispatcher([functor]),
        yade.PyRunner(command=commands[1], iterPeriod=1, initRun=True),
        *engines[place + 1 :],
    ]


def _label(body):
    return yade.O.bodies[body].material.label


class Held:
    """A scene's contacts between steps: reading and writing YADE objects is what the public way costs."""

    def __init__(self):
        self.keys, self.objects, self.columns, self.tangents = [], [], np.zeros((0, 8)), ()
        self.valid_at = None  # (scene, step) at which this may be used

    def flush(self):
        """Write the history to YADE's objects, where saving and reading look for it."""
        for (_, phys, _), row in zip(self.objects, self.columns, strict=True):
            phys.momentBend = yade.Vector3(*row[2:5])
            phys.momentTwist = yade.Vector3(*row[5:8])

    def take(self, binding):
        """The contacts of this step: those held if they are the same ones."""
        from demlaws.yade.functor import rows_of

        omega = yade.O
        contacts = [contact for contact in omega.interactions if contact.isReal]
        keys = [(contact.id1, contact.id2, contact.iterMadeReal) for contact in contacts]
        here = omega.thisScene, omega.iter
        known = self.valid_at == here
        if known and keys == self.keys:
            self.columns[:, 0] = [geom.penetrationDepth for geom, _, _ in self.objects]
        else:
            if known:
                self.flush()
            for contact in contacts:
                if not isinstance(contact.phys, yade.MindlinPhys):
                    raise DemlawsError(f"contact {contact.id1}+{contact.id2} is not described by MindlinPhys")
            self.keys, self.columns = keys, rows_of(contacts)
            self.objects = [(contact.geom, contact.phys, contact) for contact in contacts]
            for contact, row in zip(contacts, self.columns, strict=True):
                if row[2] == 0.0:
                    first_sight(binding.pairs, binding.ratio, contact, row)
            self.flush()
        self.valid_at = here[0], here[1] + 1


def step(binding):
    """Set kno and kso of every contact and move its history on."""
    yade.O.forces.f(0, True)  # or the threads' own sums survive the reset
    held, pairs = binding.held, binding.pairs
    held.take(binding)
    columns = held.columns
    ending = columns[columns[:, 0] <= 0]
    if len(ending):
        at_rest = ending.copy()
        at_rest[:, 0] = 0.0
        binding.banked += float(binding._energies(at_rest)[:, 1].sum())
    out = np.zeros((len(columns), 3))
    records = pairs.records
    bad = kernel.respond_loop(pairs.kind, pairs.rule, records.ctypes.data, records.strides[0], columns, out)
    if bad >= 0:
        first, second, _ = held.keys[bad]
        raise DemlawsError(f"contact {first}+{second} at overlap {columns[bad, 0]:g} m: the law gives no finite force there")
    for (_, phys, _), overlap, kno, kso in zip(
        held.objects, columns[:, 0].tolist(), out[:, 0].tolist(), out[:, 1].tolist(), strict=True
    ):
        if overlap > 0.0:
            phys.kno = kno
            phys.kso = kso
    held.tangents = out[:, 2].tolist()


def first_sight(pairs, ratio, contact, row):
    """What `kernel.first_sight` does."""
    phys, geom = contact.phys, contact.geom
    row[3] = kernel.effective_radius(geom.refR1, geom.refR2)
    row[4] = 0.75 * phys.kno / np.sqrt(row[3])
    row[1] = ratio or phys.kso / (1.5 * phys.kno)
    number = pairs.number(*(_label(body) for body in (contact.id1, contact.id2)))
    if not kernel.serves(pairs.records.ctypes.data + number * pairs.records.strides[0], row[3], row[4]):
        from demlaws.yade.functor import NOT_SERVED

        raise DemlawsError(f"contact {contact.id1}+{contact.id2} with R = {row[3]:g} m: {NOT_SERVED}")
    row[2] = number + 1
    phys.prevU = yade.Vector3(row[1], 0, 0)


def finish(binding):
    """Leave the tangent where the time stepper looks for it; erase ended contacts, which LawDispatcher does not."""
    held, ended = binding.held, []
    for (_, phys, contact), overlap, tangent in zip(held.objects, held.columns[:, 0].tolist(), held.tangents, strict=True):
        if overlap > 0.0:
            phys.kn = tangent
        elif overlap < 0.0:
            ended.append(contact)
    if ended and not _never_erase(binding.label):
        interactions = yade.O.interactions
        for contact in ended:  # `step` has banked what they dissipated: YADE's own function, without the account
            type(interactions).erase.native(interactions, contact.id1, contact.id2)


def _never_erase(label):
    return any(
        functor.neverErase
        for engine in yade.O.engines
        if isinstance(engine, yade.LawDispatcher)
        for functor in engine.functors
        if functor.label == label
    )
