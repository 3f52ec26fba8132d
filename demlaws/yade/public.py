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
_tangents = {}


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


def step(binding):
    """Set kno and kso of every contact and move its history on."""
    from demlaws.yade.functor import real_contacts, rows_of

    yade.O.forces.f(0, True)  # or the threads' own sums survive the reset
    pairs = binding.pairs
    contacts = real_contacts()
    columns = rows_of(contacts)
    for contact, row in zip(contacts, columns, strict=True):
        if row[2] == 0.0:
            first_sight(pairs, binding.ratio, contact, row)
    ending = columns[columns[:, 0] <= 0]
    if len(ending):
        at_rest = ending.copy()
        at_rest[:, 0] = 0.0
        binding.banked += float(binding._energies(at_rest)[:, 1].sum())
    out = np.zeros((len(columns), 3))
    records = pairs.records
    bad = kernel.respond_loop(pairs.kind, pairs.rule, records.ctypes.data, records.strides[0], columns, out)
    if bad >= 0:
        contact = contacts[bad]
        raise DemlawsError(
            f"contact {contact.id1}+{contact.id2} at overlap {columns[bad, 0]:g} m: the law gives no finite force there"
        )
    for contact, row, (kno, kso, _) in zip(contacts, columns, out, strict=True):
        phys = contact.phys
        if row[0] > 0:
            phys.kno, phys.kso = kno, kso
        phys.momentBend = yade.Vector3(*row[2:5])
        phys.momentTwist = yade.Vector3(*row[5:8])
    _tangents[binding.label] = list(zip(contacts, out[:, 2], strict=True))


def first_sight(pairs, ratio, contact, row):
    """What `kernel.first_sight` does."""
    phys, geom = contact.phys, contact.geom
    row[3] = kernel.effective_radius(geom.refR1, geom.refR2)
    row[4] = 0.75 * phys.kno / np.sqrt(row[3])
    row[1] = ratio or phys.kso / (1.5 * phys.kno)
    number = pairs.number(*(_label(body) for body in (contact.id1, contact.id2)))
    if not kernel.serves(pairs.records.ctypes.data + number * pairs.records.strides[0], row[3], row[4]):
        raise DemlawsError(
            f"contact {contact.id1}+{contact.id2} with R = {row[3]:g} m: the table holds only for the radius and modulus it was made for"
        )
    row[2] = number + 1
    phys.prevU = yade.Vector3(row[1], 0, 0)


def finish(binding):
    """Leave the tangent where the time stepper looks for it; erase ended contacts, which LawDispatcher does not."""
    for contact, tangent in _tangents.pop(binding.label, ()):
        if contact.geom.penetrationDepth > 0.0:
            contact.phys.kn = tangent
        elif contact.geom.penetrationDepth < 0.0 and not _never_erase(binding.label):
            yade.O.interactions.erase(contact.id1, contact.id2)


def _never_erase(label):
    return any(
        functor.neverErase
        for engine in yade.O.engines
        if isinstance(engine, yade.LawDispatcher)
        for functor in engine.functors
        if functor.label == label
    )
