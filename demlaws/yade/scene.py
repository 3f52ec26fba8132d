"""What stands in a scene: its engine list as users see it, the guards hidden in it, its laws, what is saved with it.

A guard is a PyRunner right before the engine that holds a law. It runs at the first step, at the second, then every hundred
steps, and before the next step's contacts whenever native code has put it on (`kernel.alarm`). Users do not see it: `O.engines`
leaves it out, and what is assigned gets it back. In a saved scene a functor that no contact of Mindlin's can be given to stands
in the law's place, and the guard, which runs at the first step of whatever process loads it, puts the law there: where no guard
runs YADE ends with an error, and nowhere does the native law act instead.
"""

import builtins
import json
import uuid
import warnings

import yade

from demlaws.errors import DemlawsError
from demlaws.yade import native, public
from demlaws.yade.binding import Binding
from demlaws.yade.functor import Law2_ScGeom_MindlinPhys_Demlaws, TimeStepWarning
from demlaws.yade.omega import O, functors, get_engines, set_engines

GUARD_COMMAND = "__import__('demlaws.yade').yade.guard({label!r})"
PERIOD = 100
"""Steps between two calls of a guard that nothing has put on: a call costs some hundred microseconds."""
IN_SECONDS = 1.0
"""A guard runs at least so often, whatever a step takes."""
TOKEN = "demlaws-scene"
LAW = "demlaws.{label}"
FUNCTOR = "demlaws-functor.{label}"
CONTACT = ["ScGeom", "MindlinPhys"]
"""Classes of the contacts that a law acts on."""

_living = set()
"""Tokens of scenes that hold a law of ours: the tag `TOKEN` of a scene is its own, and is given anew when it is loaded."""


# --- engines


def dispatchers(engine):
    """The law dispatchers within an engine of the list."""
    if isinstance(engine, yade.InteractionLoop):
        yield engine.lawDispatcher
    elif isinstance(engine, yade.LawDispatcher):
        yield engine
    elif isinstance(engine, yade.ParallelEngine):
        for slave in engine.slaves:
            for one in slave if isinstance(slave, list | tuple) else (slave,):
                yield from dispatchers(one)


def law_functors(engines):
    """(engine of the list, dispatcher, functor) of every law functor."""
    for engine in engines:
        for dispatcher in dispatchers(engine):
            for functor in dispatcher.functors:
                yield engine, dispatcher, functor


def is_ours(functor):
    """Whether a functor is a law of this package."""
    return isinstance(functor, Law2_ScGeom_MindlinPhys_Demlaws)


def laws_here():
    """Label → functor of our laws in the current scene."""
    return {functor.label: functor for _, _, functor in law_functors(get_engines()) if is_ours(functor)}


def _is_guard(engine, label=None):
    if not isinstance(engine, yade.PyRunner):
        return False
    begin = GUARD_COMMAND.split("{")[0]
    return engine.command.startswith(begin) if label is None else engine.command == GUARD_COMMAND.format(label=label)


def visible(engines):
    """An engine list without what is hidden from users."""
    shown, skip = [], 0
    for engine in engines:
        if skip:
            skip -= 1
        elif public.begins_hidden(engine):
            skip = public.HIDDEN - 1
        elif not _is_guard(engine):
            shown.append(engine)
    return shown


def get_visible():
    """What `O.engines` is once the patches are installed."""
    return visible(get_engines())


def set_visible(engines):
    """What `O.engines = …` does once the patches are installed."""
    engines = visible(list(engines))
    before = get_engines()
    old = laws_here()
    laws = _laws_in(engines, old)
    _refuse_switch(engines, before, laws)
    for functor in laws.values():
        _take_over(functor, old.get(functor.label))
        functor.binding.check_functor(functor)
    token = _token() if laws else None
    _refuse_second_scene(laws, token)
    set_engines(completed(engines, laws, before))
    for label, functor in old.items():
        if label not in laws or laws[label].binding is not functor.binding:
            functor.binding.leave()
        if label not in laws:
            O.tags[LAW.format(label=label)] = ""
    for functor in laws.values():
        binding = functor.binding
        if binding.scene != token:
            binding.enter(token)
        _watch(binding)
        _remember(functor)
        _warn(binding.bound_steppers(engines))


def _laws_in(engines, old):
    """Label → functor of our laws in a list that a user assigns."""
    laws, live = {}, []
    for engine in engines:
        _refuse_other_physics(engine)
        for dispatcher in dispatchers(engine):
            _refuse_rivals(dispatcher)
            live += [] if engine.dead else [dispatcher]
    if len(live) > 1 and any(is_ours(f) or public.stands_for(f) for dispatcher in live for f in dispatcher.functors):
        raise DemlawsError(
            f"{len(live)} engines of the list hold law functors, one of them a demlaws law: each would compute every contact, "
            "and forces count more than once. Put all law functors into one InteractionLoop; demlaws laws that differ by pairs "
            "of materials are one law, given as a dict {(label, label): law}"
        )
    for engine, _, functor in law_functors(engines):
        behind = public.stands_for(functor)
        if behind is not None:
            if behind not in old:
                raise DemlawsError(f"this InteractionLoop belongs to a law {behind!r} that is not in the scene: make a new one")
            functor = old[behind]
        if not is_ours(functor):
            continue
        if laws.setdefault(functor.label, functor) is not functor:
            raise DemlawsError(f"two laws of the scene are labelled {functor.label!r}: give one of them another label=…")
        if functor.binding.attachment is None:
            public.check(engines, engines.index(engine), functor)
    return laws


def _refuse_rivals(dispatcher):
    """Of functors for one kind of contact YADE lists the first of a class and asks the last: only one law may be given."""
    takers = [f for f in dispatcher.functors if list(f.bases) == CONTACT]
    if not takers:
        return
    asked = dispatcher.dispFunctor(*(getattr(yade, name)() for name in CONTACT))
    if not any(is_ours(f) for f in (*takers, asked)):
        return
    known = {native.address(f): f for f in (*takers, asked)}
    if len(known) > 1:
        raise DemlawsError(
            f"{type(dispatcher).__name__} was given {len(known)} functors for the same contacts "
            f"({', '.join(map(str, known.values()))}), of which YADE asks one only, and whose scene it may not set: give one"
        )


def _refuse_other_physics(engine):
    """A loop that makes another law's physics: YADE would end the process at the first contact."""
    if not isinstance(engine, yade.InteractionLoop) or not any(is_ours(f) for f in engine.lawDispatcher.functors):
        return
    listed = [type(f).__name__ for f in engine.physDispatcher.functors]
    if listed and not any("Mindlin" in name for name in listed):
        raise DemlawsError(
            f"the law's contacts need Ip2_FrictMat_FrictMat_MindlinPhys, InteractionLoop has {', '.join(listed)}: put it there"
        )


def _take_over(functor, old):
    """Let a functor that is the same law as the one at work go on with its contacts and account."""
    if old is not None and old is not functor and functor.binding is not old.binding and functor.binding.same_as(old.binding):
        functor.binding = old.binding
        if old.binding.attachment is not None:
            old.binding.attachment.patch(functor)


def _refuse_switch(engines, before, laws):
    """YADE caches a functor in each contact: a new one would not act on contacts that live, unless it is the same law."""

    def others(listed):
        return {native.address(f) for _, _, f in law_functors(visible(listed)) if not is_ours(f) and not public.stands_for(f)}

    old = laws_here()
    if not (laws or old) or O.interactions.countReal() == 0:
        return
    new_ones, old_ones = others(engines), others(before)
    if (not laws and not new_ones) or (not old and not old_ones):
        return
    same = set(laws) == set(old) and new_ones == old_ones
    for label, functor in laws.items() if same else ():
        one = old[label]
        same &= functor is one or (one.binding.same_as(functor.binding) and one.settings() == functor.settings())
    if not same:
        raise DemlawsError(
            f"the law is switched while {O.interactions.countReal()} contacts live, which YADE would leave with the old one. "
            "The same law made again (same arguments, label and attributes) goes on with them; for another one call "
            "O.interactions.clear() first, which erases all contacts with their history (shear forces, plastic overlaps)"
        )


def _refuse_second_scene(laws, token):
    for label, functor in laws.items():
        home = functor.binding.scene
        if home is not None and home != token and home in _living:
            raise DemlawsError(
                f"the law {label!r} is at work in another scene, whose account of energy would mix with this one's: make a law "
                "of its own for each scene"
            )


def completed(engines, laws, before):
    """A user's list with guards and hidden engines."""
    guards = {engine.command: engine for engine in before if _is_guard(engine)}
    complete = []
    for engine in engines:
        behind = []
        for dispatcher in dispatchers(engine):
            for functor in dispatcher.functors:
                law = laws.get(public.stands_for(functor) or functor.label)
                if law is None or (law is not functor and not public.stands_for(functor)):
                    continue
                if law.binding.attachment is not None:
                    command = GUARD_COMMAND.format(label=law.label)
                    runner = guards.get(command) or yade.PyRunner(command=command)
                    runner.iterPeriod, runner.realPeriod, runner.initRun, runner.dead = PERIOD, IN_SECONDS, True, False
                    runner.nDone = 0
                    complete.append(runner)
                    law.binding.runner = runner
                else:
                    if law is functor:
                        functors.__set__(dispatcher, [public.throw_away(law.label)])
                    behind = public.hidden_engines(law)
                    law.binding.runner = behind[0]
        complete += [engine, *behind]
    return complete


def _watch(binding):
    binding.watched_by(binding.runner)


def _warn(line):
    if line is not None:
        warnings.warn(line, TimeStepWarning, stacklevel=5)


# --- scenes


def _token():
    """The current scene's token, made if it has none."""
    if TOKEN not in O.tags.keys():  # noqa: SIM118  not a dict
        O.tags[TOKEN] = uuid.uuid4().hex
    _living.add(O.tags[TOKEN])
    return O.tags[TOKEN]


def token_here():
    """The current scene's token, or None."""
    return O.tags[TOKEN] if TOKEN in O.tags.keys() else None  # noqa: SIM118


def scene_ended(token):
    """The scene of this token is no more."""
    _living.discard(token)


def all_scenes_ended():
    """After O.reset()."""
    _living.clear()


def _remember(functor):
    """Write all that another process needs to the scene's tags, with which it is saved."""
    O.tags[LAW.format(label=functor.label)] = functor.binding.as_text()
    O.tags[FUNCTOR.format(label=functor.label)] = json.dumps(functor.attributes())


def _saved_laws():
    """Labels of the laws that the scene's tags describe."""
    prefix = LAW.format(label="")
    return [key.removeprefix(prefix) for key in O.tags.keys() if key.startswith(prefix) and O.tags[key]]  # noqa: SIM118


def _placeholder(label):
    """A functor that no contact of Mindlin's is given to."""
    return yade.Law2_L3Geom_FrictPhys_ElPerfPl(label=label)


class as_saved:
    """Within this context the scene is as it is to be saved: tags written, laws out, guards due at the first step."""

    def __enter__(self):
        self.kept = []
        for _, dispatcher, functor in law_functors(get_engines()):
            if is_ours(functor):
                _remember(functor)
                self.kept.append((dispatcher, list(dispatcher.functors)))
        self.runners = [e for e in get_engines() if _is_guard(e)]
        self.done = [runner.nDone for runner in self.runners]
        for dispatcher, listed in self.kept:
            functors.__set__(dispatcher, [_placeholder(f.label) if is_ours(f) else f for f in listed])
        for runner in self.runners:
            runner.nDone = 0

    def __exit__(self, *error):
        for dispatcher, listed in self.kept:
            functors.__set__(dispatcher, listed)
        for runner, done in zip(self.runners, self.done, strict=True):
            runner.nDone = done


def attach_saved(reusable=None):
    """Put the laws that the scene's tags describe where placeholders (or, in old files, native functors) stand.

    reusable: label → functor of a scene that has just ended, which go on if they are what was saved.
    """
    labels = _saved_laws()
    waiting = {}
    for _, dispatcher, functor in law_functors(get_engines()):
        if functor.label in labels and not is_ours(functor):
            waiting[functor.label] = dispatcher, functor
    if not waiting:
        return
    if token_here() is not None:
        O.tags[TOKEN] = uuid.uuid4().hex  # the one in the file may be that of a scene that is here, too
    token = _token()
    for label, (dispatcher, stand_in) in waiting.items():
        law = _restored(label, (reusable or {}).get(label), stand_in)
        banked = law.binding.banked
        functors.__set__(dispatcher, [law if f.label == label else f for f in dispatcher.functors])
        law.binding.enter(token, banked)
        law.binding.runner = next((e for e in get_engines() if _runs(e, label)), None)
        if (
            law.binding.runner is not None and law.binding.attachment is not None
        ):  # files of earlier versions have another period
            law.binding.runner.iterPeriod, law.binding.runner.realPeriod = PERIOD, IN_SECONDS
        _watch(law.binding)
        setattr(builtins, label, law)  # YADE's variable of this name


def _runs(engine, label):
    return _is_guard(engine, label) or (
        isinstance(engine, yade.PyRunner) and engine.command == public.PREPARE.format(label=label)
    )


def _restored(label, known, stand_in):
    text = O.tags[LAW.format(label=label)]
    key = FUNCTOR.format(label=label)
    attributes = json.loads(O.tags[key]) if key in O.tags.keys() else {}  # noqa: SIM118
    if not attributes:  # files of earlier versions hold the native functor itself
        attributes = {n: v for n, v in stand_in.dict().items() if n in ("neverErase", "calcEnergy")}
    way, ratio, banked, pairs = text.split("|", 3)
    if known is not None:
        binding = known.binding
        own = "" if binding.ratio is None else repr(float(binding.ratio))
        if (binding.way, own, binding.pairs.as_text()) == (way, ratio, pairs):
            binding.banked = float(banked)
            known.updateAttrs(attributes)
            return known
    binding = Binding.from_text(label, text)
    if binding.way != way:
        raise DemlawsError(f"law {label!r} was saved under the {way} bridge, which is not available here: {binding.reason}")
    return Law2_ScGeom_MindlinPhys_Demlaws._restored(binding, attributes)


# --- what engines call


def guard(label):
    """Called by a law's PyRunner: puts the law in place in a new process, raises what native code could not."""
    functor = _at_work(label)
    if functor is None:
        raise DemlawsError(f"no law functor is labelled {label!r} in O.engines, but its guard is there: remove both or none")
    binding = functor.binding
    if binding.attachment is None or not binding.attachment.acts_in(functor):
        raise DemlawsError(f"the functor of law {label!r} does not act by it: assign O.engines anew")
    binding.watch(functor)
    _warn(binding.bound_steppers(get_engines()))
    if binding.guards == 1:
        binding.runner.nDone = 0  # once more at the second step, when there are contacts


def _at_work(label):
    functor = laws_here().get(label)
    if functor is None and any(f.label == label for _, _, f in law_functors(get_engines())):
        if label not in _saved_laws():
            raise DemlawsError(f"the scene does not say what law {label!r} is: its tag {LAW.format(label=label)!r} is missing")
        attach_saved()
        functor = laws_here().get(label)
    return functor


def public_step(label):
    """Called by the first hidden engine of the public way, before the law acts."""
    functor = _at_work(label)
    public.step(functor.binding)
    _warn(functor.binding.bound_steppers(get_engines()))


def public_finish(label):
    """Called by the last hidden engine of the public way, after the law has acted."""
    functor = _at_work(label)
    public.finish(functor.binding, functor.neverErase)


def attached(label="demlaws"):
    """The law at work in the current scene under this label: totals(), contacts(), verify()."""
    functor = _at_work(label)
    if functor is None:
        raise DemlawsError(
            f"no law {label!r} is at work in this scene; there are: {', '.join(map(repr, laws_here())) or 'none'}"
        )
    return functor.binding


def refuse_functors(dispatcher, listed):
    """What assigning `LawDispatcher.functors` does once the patches are installed."""
    if any(is_ours(functor) for functor in listed):
        raise DemlawsError("give the law to InteractionLoop(…) and assign O.engines, so that its guard is put before it")
    if any(is_ours(functor) for functor in functors.__get__(dispatcher)) and O.interactions.countReal():
        raise DemlawsError(
            "this dispatcher holds a demlaws law, whose contacts live: call O.interactions.clear() first, which erases all "
            "contacts with their history (shear forces, plastic overlaps)"
        )
    functors.__set__(dispatcher, listed)
