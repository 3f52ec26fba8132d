"""The laws of a scene: engine list, guards, saving and loading.

A guard is a PyRunner right before the engine that contains a law. It runs at the first step, at the second, then every hundred
steps, and before the next step's contacts whenever native code asks for it (`records.request_guard`). `O.engines` does not
show it. In a saved scene a functor that does not accept Mindlin's contacts is in the law's place; the guard runs at the first
step after loading and puts the law there. Without a guard YADE ends with an error; the native law never acts instead.
"""

import contextlib
import sys
import uuid
from numbers import Real

import yade

from demlaws.errors import DemlawsError, EngineStopped
from demlaws.yade import native
from demlaws.yade.functor import Law2_ScGeom_MindlinPhys_Demlaws
from demlaws.yade.omega import TOKEN, O, contact_engines, dispatchers, get_engines, law_functors, set_engines, tag, token_here

GUARD_COMMAND = "__import__('demlaws.yade').yade.guard({label!r})"
PERIOD = 100
"""Steps between two calls of a guard that native code has not asked for: a call costs some hundred microseconds."""
IN_SECONDS = 1.0
"""Longest time between two calls of a guard."""
LAW = "demlaws.{label}"
"""Tag that describes a law, with the history of its contacts."""
CONTACT = ["ScGeom", "MindlinPhys"]
"""Classes of the contacts that a law acts on."""


# --- engines


def is_our_law(functor):
    """Whether a functor is a law of this package."""
    return isinstance(functor, Law2_ScGeom_MindlinPhys_Demlaws)


def laws_here():
    """Label → functor of our laws in the current scene."""
    return {functor.label: functor for _, functor in law_functors(get_engines()) if is_our_law(functor)}


def is_guard(engine):
    """Whether an engine is the guard of a law."""
    return isinstance(engine, yade.PyRunner) and engine.command.startswith(GUARD_COMMAND.split("{")[0])


def visible(engines):
    """An engine list without guards."""
    return [engine for engine in engines if not is_guard(engine)]


def get_visible():
    """`O.engines` for users."""
    attach()
    return visible(get_engines())


def set_visible(engines):
    """`O.engines = …` for users: check the list, put guards before the laws, and let the laws enter the scene."""
    engines = visible(list(engines))
    attach()
    refuse_mpi(DemlawsError if any(is_our_law(f) for _, f in law_functors(engines)) else None)
    before, old = get_engines(), laws_here()
    laws = _laws_in(engines)
    _refuse_switch(engines, before, laws, old)
    for functor in laws.values():
        _take_over(functor, old.get(functor.label))
        functor.binding.check_functor(functor)
    set_engines(completed(engines, laws, before))
    for label, functor in old.items():
        if label not in laws or laws[label].binding is not functor.binding:
            functor.binding.attachment.watched_by(None)
    if laws and token_here() is None:
        O.tags[TOKEN] = uuid.uuid4().hex
    for functor in laws.values():
        if functor.binding.scene != token_here():
            functor.binding.enter(token_here())
        functor.binding.bound_steppers(engines)
    _at_work[O.thisScene] = laws


def with_energies(tracker):
    """YADE's EnergyTracker with the present energies [J] of the laws of the scene, if it tracks energies; as YADE's own they
    exist from the first step. It gets what was lost since it was read before: `clear` is such a reading."""
    attach()
    present = tracker if O.trackEnergy and O.iter else None
    for functor in laws_here().values():
        if functor.binding.scene == token_here():
            functor.binding.account_for(present)
    return tracker


def refuse_mpi(error):
    """Raise an error of this kind where YADE runs on several MPI ranks: the history of a contact is in one process."""
    mpi = sys.modules.get("yade.mpy")
    if error is not None and (getattr(mpi, "numThreads", None) or 1) > 1:
        raise error(
            f"yade.mpy runs on {mpi.numThreads} MPI ranks, between which the histories of contacts do not move: run with "
            "OpenMP threads (demlaws yade run -j N), or on ranks in LIGGGHTS or LAMMPS"
        )


def _refuse_integrator(engine):
    """An integrator that has the contacts computed at trial positions corrupts their history."""
    slaves = () if isinstance(engine, yade.ParallelEngine) else getattr(engine, "slaves", ())
    nested = [one for slave in slaves for one in (slave if isinstance(slave, list | tuple) else (slave,))]
    if any(is_our_law(functor) for _, functor in law_functors(nested)):
        raise DemlawsError(
            f"{type(engine).__name__} computes contacts several times per step, at trial positions that it may reject: the "
            "history of a law (largest overlap, shear) would be of positions that never occurred. Use NewtonIntegrator, with "
            "InteractionLoop in O.engines"
        )


def _laws_in(engines):
    """Label → functor of our laws in a list that a user assigns."""
    laws, live = {}, []
    for engine in engines:
        _refuse_integrator(engine)
        _refuse_other_physics(engine)
        for dispatcher in dispatchers(engine):
            _refuse_rivals(dispatcher)
            live += [] if engine.dead else [dispatcher]
    if len(live) > 1 and any(is_our_law(f) for dispatcher in live for f in dispatcher.functors):
        raise DemlawsError(
            f"{len(live)} engines of the list have law functors, one of them a demlaws law: each would compute every contact, "
            "and forces count more than once. Put all law functors into one InteractionLoop; demlaws laws that differ by pairs "
            "of materials are one law, given as a dict {(label, label): law}"
        )
    for _, functor in law_functors(engines):
        if is_our_law(functor) and laws.setdefault(functor.label, functor) is not functor:
            raise DemlawsError(f"two laws of the scene are labelled {functor.label!r}: give one of them another label=…")
    return laws


def _refuse_rivals(dispatcher):
    """YADE lists the first of two functors for the same contacts and calls the last: only one is allowed beside a law."""
    takers = [f for f in dispatcher.functors if list(f.bases) == CONTACT]
    if not takers:
        return
    active = dispatcher.dispFunctor(*(getattr(yade, name)() for name in CONTACT))
    functors = {native.address(f): f for f in (*takers, active)}
    if len(functors) > 1 and any(map(is_our_law, functors.values())):
        raise DemlawsError(
            f"{type(dispatcher).__name__} was given {len(functors)} functors for the same contacts "
            f"({', '.join(map(str, functors.values()))}), of which YADE calls one only, possibly without its scene: give one"
        )


def _refuse_other_physics(engine):
    """YADE would end the process at the first contact of a loop that makes another law's physics."""
    if not isinstance(engine, yade.InteractionLoop) or not any(is_our_law(f) for f in engine.lawDispatcher.functors):
        return
    names = [type(f).__name__ for f in engine.physDispatcher.functors]
    if names and not any("Mindlin" in name for name in names):
        raise DemlawsError(
            f"the law's contacts need Ip2_FrictMat_FrictMat_MindlinPhys, InteractionLoop has {', '.join(names)}: put it there"
        )


def _take_over(functor, old):
    """Let a functor that is the same law as the one at work continue its contacts and account."""
    if old is None or functor.binding is old.binding:
        return
    from demlaws.yade.saving import same_law

    if same_law(functor.binding, old.binding):
        old.binding.attachment.point(functor)
        functor.binding = old.binding


def _refuse_switch(engines, before, laws, old):
    """YADE keeps the functor of each contact: only the same law may be assigned while contacts exist."""

    def others(engines):
        return {native.address(f) for _, f in law_functors(visible(engines)) if not is_our_law(f)}

    if not (laws or old) or O.interactions.countReal() == 0:
        return
    new_others, old_others = others(engines), others(before)
    if (not laws and not new_others) or (not old and not old_others):
        return
    from demlaws.yade.saving import same_law

    same = set(laws) == set(old) and new_others == old_others
    for label, functor in laws.items() if same else ():
        former = old[label]
        same &= functor is former or (same_law(former.binding, functor.binding) and former.settings() == functor.settings())
    if not same:
        raise DemlawsError(
            f"the law is switched while there are contacts ({O.interactions.countReal()}), which would keep the old one. "
            "The same law made again (same arguments, label and attributes) continues them; for another one call "
            "O.interactions.clear() first, which erases all contacts with their history (shear forces, plastic overlaps)"
        )


def completed(engines, laws, before):
    """A user's list with guards."""
    guards = {engine.command: engine for engine in before if is_guard(engine)}
    complete = []
    for engine in engines:
        for _, law in law_functors([engine]):
            if laws.get(law.label) is not law:
                continue
            command = GUARD_COMMAND.format(label=law.label)
            runner = guards.get(command) or yade.PyRunner(command=command)
            runner.iterPeriod, runner.realPeriod, runner.initRun, runner.dead = PERIOD, IN_SECONDS, True, False
            runner.nDone = 0
            complete.append(runner)
            law.binding.attachment.watched_by(runner)
        complete.append(engine)
    return complete


def engines(law, *, geometries=None, bounds=None, physics=None, before=(), after=(), newton=None, verlet=0.1, timestep=None):
    """A whole engine list for spheres, facets, walls and boxes: `O.engines = engines(law)`.

    geometries, bounds: functors in place of the usual ones; physics: an Ip2_FrictMat_FrictMat_MindlinPhys, for damping; before,
    after: engines before and behind the contacts (forces, boundaries); newton: a NewtonIntegrator (default: no damping);
    verlet: `InsertionSortCollider.verletDist` in units of the smallest radius; timestep: the part, up to 1, of the critical
    step for a GlobalStiffnessTimeStepper, None for a constant `O.dt`. The stepper's step stays below this part of 4
    PWaveTimeStep() of the bodies, later ones included: the present stiffness of a contact does not bound that of the next step,
    and 4 r √(ρ/E) is stable for a sphere with four contacts per side that have grown to 0.3 R, under every law.
    """
    if not isinstance(law, yade.LawFunctor):
        raise DemlawsError(f"engines(law): give the law functor, Law2_ScGeom_MindlinPhys_Demlaws(…), got {law!r}")
    stepper = []
    if timestep is not None:
        if not (isinstance(timestep, Real) and 0.0 < timestep <= 1.0):
            raise DemlawsError(f"timestep = {timestep!r}: a share of the critical step, above 0 and up to 1")
        stepper = [yade.GlobalStiffnessTimeStepper(timestepSafetyCoefficient=timestep, timeStepUpdateInterval=10)]
    if hasattr(law, "binding"):
        law.binding.share = timestep
    physics = physics or yade.Ip2_FrictMat_FrictMat_MindlinPhys()
    contacts = contact_engines(law, physics, -verlet, before, geometries, bounds)
    return [*contacts, *stepper, *after, newton or yade.NewtonIntegrator(damping=0)]


# --- saving and loading


@contextlib.contextmanager
def as_saved():
    """Within this context the scene is as in its file: laws in tags, placeholders in their places, guards due at once."""
    from demlaws.yade import saving

    _ = O.energy  # gets what was lost until now
    kept = []
    for dispatcher, functor in law_functors(get_engines()):
        if is_our_law(functor):
            O.tags[LAW.format(label=functor.label)] = saving.law_text(functor)
            kept.append((dispatcher, list(dispatcher.functors)))
    runners = [(engine, engine.nDone) for engine in get_engines() if is_guard(engine)]
    for dispatcher, functors in kept:
        dispatcher.functors = [_placeholder(label=f.label) if is_our_law(f) else f for f in functors]
    for runner, _ in runners:
        runner.nDone = 0
    try:
        yield
    finally:
        for dispatcher, functors in kept:
            dispatcher.functors = functors
        for runner, count in runners:
            runner.nDone = count


_placeholder = yade.Law2_L3Geom_FrictPhys_ElPerfPl
"""A functor that does not accept Mindlin's contacts."""


_at_work = {}
"""Number of a scene → label → functor: those that were at work before loading continue if the file describes the same laws."""


def end_laws():
    """All scenes are gone: return the memory of their contacts."""
    for laws in _at_work.values():
        for functor in laws.values():
            functor.binding.attachment.rows.release()


def attach():
    """Replace placeholders, of a scene that was loaded, by the laws that its tags describe."""
    placeholders = [
        (dispatcher, functor.label, tag(LAW.format(label=functor.label)))
        for dispatcher, functor in law_functors(get_engines())
        if type(functor) is _placeholder
    ]
    placeholders = [one for one in placeholders if one[-1]]
    if not placeholders:
        return
    from demlaws.yade import saving

    token = O.tags[TOKEN] = uuid.uuid4().hex  # the one in the file may be that of another scene of this process
    for dispatcher, label, text in placeholders:
        content = saving.content_of(text, label)
        former = _at_work.get(O.thisScene, {}).get(label)
        if former is not None and saving.pairs_text(former.binding.pairs) == content["pairs"]:
            law = former
            law.updateAttrs(content["attributes"])
        else:
            law = Law2_ScGeom_MindlinPhys_Demlaws._remade(label, content["pairs"], content["attributes"])
        dispatcher.functors = [law if f.label == label else f for f in dispatcher.functors]
        law.binding.enter(token, content["account"])
        law.binding.seen, law.binding.bound = content["seen"], content["bound"]
        saving.restore(law.binding, content)
        command = GUARD_COMMAND.format(label=label)
        law.binding.attachment.watched_by(next((e for e in get_engines() if getattr(e, "command", None) == command), None))
    set_engines(get_engines())  # YADE sets its variables named by labels
    _at_work[O.thisScene] = laws_here()


# --- called by engines


stops = []
"""Messages with which guards have stopped the scene since O.run was called."""


def guard(label):
    """Called by a law's PyRunner: `watch`. YADE ends the run where this raises an error, prints it and raises it in O.run."""
    try:
        watch(label)
    except DemlawsError as error:
        stops.append(str(error))
        raise error.with_traceback(None) from None


def report_stop():
    """After a run: raise the message of the guard that has stopped it."""
    if stops:
        raise EngineStopped(stops[-1])


def begin():
    """Before a run: attach the laws of a loaded scene, and raise where a law has no guard."""
    stops.clear()
    attach()
    for label in laws_here():
        at_work(label)


def watch(label):
    """Attach the law in a new process, raise the faults of native code."""
    refuse_mpi(EngineStopped)
    functor = at_work(label)
    binding = functor.binding
    if not binding.attachment.acts_in(functor):
        raise EngineStopped(f"the functor of law {label!r} does not use it: assign O.engines again")
    binding.watch(functor)
    binding.bound_steppers(get_engines())
    if binding.guards == 1:
        binding.attachment.runner.nDone = 0  # once more at the second step, when there are contacts


def at_work(label):
    """The functor of this label in the current scene."""
    attach()
    functor = laws_here().get(label)
    if functor is None:
        labels = ", ".join(map(repr, laws_here())) or "none"
        raise EngineStopped(
            f"law {label!r} is not used in this scene, or its tag {LAW.format(label=label)!r} is missing: {labels}"
        )
    if functor.binding.scene != token_here() or functor.binding.attachment.runner is None:
        raise EngineStopped(
            f"the law {label!r} has no guard in this scene: it is now used in another scene, and its energies would be mixed, "
            "or it was given to a dispatcher. Make one law functor for each scene, and assign O.engines (O.engines = O.engines)"
        )
    return functor


def attached(label="demlaws"):
    """The law at work in the current scene under this label: totals(), contacts(), verify()."""
    return at_work(label).binding
