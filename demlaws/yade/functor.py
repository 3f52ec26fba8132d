"""The functor that a YADE script uses, and what keeps it honest: guard, engine list, saving and loading, energies.

Importing this module imports YADE and wraps some of its Python entry points: assigning `O.engines` (puts the guard before
InteractionLoop, or takes the public way where the bridge cannot act), `O.save` and `O.load` with their relatives (write
the energy account to the scene, read it back), erasing bodies and interactions (keeps the account of what ended contacts
dissipated), and assigning `LawDispatcher.functors` (refused: it goes past the guard).
"""

import math
import warnings
from typing import NamedTuple

import numpy as np
import yade
import yade.utils

from demlaws.errors import DemlawsError
from demlaws.yade import bridge, kernel, public
from demlaws.yade.pairs import Pairs, Span

NATIVE_ATTRIBUTES = frozenset(yade.Law2_ScGeom_MindlinPhys_Mindlin().dict()) | {"preventGranularRatcheting"}
GUARD_COMMAND = "__import__('demlaws.yade').yade.guard({label!r})"
O = yade.O  # noqa: E741  YADE's name

NOT_SERVED = (
    "no law was given for it: the surfaces of its materials are not listed, or a table of a law without a single "
    "dimensionless curve, or a solved curve, was made for other contacts; list the surfaces, make the law after the bodies"
)

_bindings = {}  # label → Binding


class BridgeWarning(UserWarning):
    """The native bridge cannot act here; the public-API way does, at many times the cost."""


class ContactState(NamedTuple):
    """Contacts of a scene: arrays with one entry a contact, SI units. State values that the rule lacks are NaN."""

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


class Totals(NamedTuple):
    """Energy in the normal direction [J]: what the contacts can still return, what they have dissipated by plasticity."""

    stored: float
    dissipated: float


def real_contacts():
    """The current scene's contacts that Mindlin's physics describes."""
    return [i for i in O.interactions if i.isReal and isinstance(i.phys, yade.MindlinPhys)]


def rows_of(contacts):
    """Rows of (overlap, K_t/K, tag, R, E*, 3 state values) as `kernel.respond_loop` takes them."""
    columns = np.empty((len(contacts), 8))
    for row, contact in zip(columns, contacts, strict=True):
        phys = contact.phys
        row[0] = contact.geom.penetrationDepth
        row[1] = phys.prevU[0]
        row[2:5] = phys.momentBend
        row[5:8] = phys.momentTwist
    return columns


class Binding:
    """One law at work in YADE, known by its functor's label; outlives the functor object, which loading replaces."""

    def __init__(self, label, pairs, ratio, way):
        self.label, self.pairs, self.ratio = label, pairs, ratio
        self.attachment = None
        self.reason = None
        self.public_banked = 0.0
        self.held = public.Held()
        if way != "public":
            try:
                self.attachment = bridge.Attachment(pairs, ratio)
            except bridge.BridgeUnavailable as error:
                if way == "native":
                    raise
                self.reason = str(error)
        self.guards, self.next_step, self.functor = 0, -1, None

    @property
    def way(self):
        return "public" if self.attachment is None else "native"

    @property
    def banked(self):
        return self.public_banked if self.attachment is None else self.attachment.banked

    @banked.setter
    def banked(self, value):
        if self.attachment is None:
            self.public_banked = value
        else:
            self.attachment.banked = value

    # --- saved with the scene

    @property
    def tag(self):
        return f"demlaws.{self.label}"

    def remember(self):
        """Write all that another process needs to the scene, with which it is saved."""
        self.settle()
        ratio = "" if self.ratio is None else repr(self.ratio)
        O.tags[self.tag] = "|".join((self.way, ratio, repr(self.banked), self.pairs.as_text()))

    @classmethod
    def from_tag(cls, label):
        key = f"demlaws.{label}"
        if key not in O.tags.keys():  # noqa: SIM118  not a dict
            raise DemlawsError(f"the scene does not say what law {label!r} is: its tag {key!r} is missing")
        way, ratio, banked, text = O.tags[key].split("|", 3)
        binding = cls(label, Pairs.from_text(text), float(ratio) if ratio else None, way)
        binding.banked = float(banked)
        _bindings[label] = binding
        return binding

    def settle(self):
        """Bring YADE's objects up to date with what the public way holds."""
        if self.attachment is None and self.held.valid_at == (O.thisScene, O.iter):
            self.held.flush()

    # --- what users read

    def _energies(self, columns):
        out = np.zeros((len(columns), 2))
        records = self.pairs.records
        kernel.energies_loop(self.pairs.kind, self.pairs.rule, records.ctypes.data, records.strides[0], columns, out)
        return out

    def totals(self):
        """Stored energy and plastic dissipation [J] of the current scene, ended contacts included.

        What contacts have stored when they are erased with a body is gone; what they have dissipated stays in the account.
        """
        self.settle()
        columns = rows_of(real_contacts())
        columns = columns[columns[:, 2] > 0]
        stored, dissipated = self._energies(columns).sum(axis=0)
        return Totals(float(stored), float(dissipated) + self.banked)

    def contacts(self, interactions=None):
        """State of all real contacts of the scene (or of the given ones) as arrays: a `ContactState`."""
        self.settle()
        chosen = real_contacts() if interactions is None else list(interactions)
        columns = rows_of(chosen)
        seen = columns[:, 2] > 0
        chosen = [contact for contact, keep in zip(chosen, seen, strict=True) if keep]
        columns = columns[seen]
        out = np.zeros((len(columns), 3))
        records = self.pairs.records
        before = columns.copy()
        kernel.respond_loop(self.pairs.kind, self.pairs.rule, records.ctypes.data, records.strides[0], columns, out)
        energies = self._energies(before)
        nothing = np.full(len(columns), np.nan)
        names = self.pairs.state_names
        known = {name: before[:, 5 + names.index(name)] if name in names else nothing for name in ContactState._fields[8:11]}
        overlap = before[:, 0]
        return ContactState(
            np.array([c.id1 for c in chosen], int),
            np.array([c.id2 for c in chosen], int),
            overlap,
            np.where(overlap > 0, out[:, 0] * overlap * np.sqrt(np.maximum(overlap, 0)), 0.0),
            out[:, 2],
            before[:, 3],
            before[:, 4],
            np.array(self.pairs.roughnesses)[before[:, 2].astype(int) - 1] if len(columns) else np.zeros(0),
            **known,
            stored=energies[:, 0],
            dissipated=energies[:, 1],
        )

    def bank(self, contacts):
        """Keep in the account what these contacts have dissipated: they are about to be erased."""
        self.settle()
        contacts = [i for i in contacts if i.isReal and isinstance(i.phys, yade.MindlinPhys)]
        columns = rows_of(contacts)
        self.banked += float(self._energies(columns[columns[:, 2] > 0])[:, 1].sum())
        for contact in contacts:  # YADE may show it until the next step: its history is not counted twice
            contact.phys.momentTwist = yade.Vector3(0, 0, 0)
        self.held.valid_at = None

    # --- watch

    def verify(self):
        """Every contact that YADE has computed must bear this law's mark and tangent, or a DemlawsError says which does not."""
        contacts = real_contacts()
        columns = rows_of(contacts)
        out = np.zeros((len(columns), 3))
        unseen = columns[:, 2] <= 0
        records = self.pairs.records
        safe = columns.copy()
        safe[unseen, 2:5] = 1.0
        respond = kernel.respond_loop
        respond(self.pairs.kind, self.pairs.rule, records.ctypes.data, records.strides[0], safe, out)
        for contact, u, missing, (_, _, tangent) in zip(contacts, columns[:, 0], unseen, out, strict=True):
            if contact.iterMadeReal == O.iter or u <= 0:
                continue  # made by something else than InteractionLoop, or about to end
            if missing or not np.isclose(contact.phys.kn, tangent, rtol=1e-9, atol=0):
                raise DemlawsError(
                    f"contact {contact.id1}+{contact.id2} was not computed by the law {self.label!r} (tangent stiffness "
                    f"{contact.phys.kn:g} N/m in YADE, {tangent:g} by the law): another functor holds it. Call "
                    "O.interactions.clear() after changing laws"
                )

    def check_bodies(self, thoroughly=False):
        """No body may move with a velocity that is no number, or (thoroughly: a look at each) be where no number says.

        A contact tells this by itself; this is for bodies that touch nothing.
        """
        if not thoroughly and math.isfinite(yade.utils.kineticEnergy()):
            return
        for body in O.bodies:
            place, velocity = body.state.pos, body.state.vel
            if not all(map(math.isfinite, (*place, *velocity))):
                raise DemlawsError(
                    f"body {body.id} is at {tuple(place)} m with velocity {tuple(velocity)} m/s, which is not finite: take a "
                    "smaller time step, or look at what the script did to it"
                )

    def check_functor(self, functor):
        for name in ("includeMoment", "includeAdhesion"):
            if getattr(functor, name):
                raise DemlawsError(
                    f"{name}=True cannot be used with a demlaws law: "
                    + (
                        "its moments live where the law keeps its history"
                        if name == "includeMoment"
                        else "it changes the force"
                    )
                )

    def raise_fault(self):
        found = self.attachment.take_fault() if self.attachment else None
        if found is None:
            return
        kind, first, second, overlap = found
        if kind == kernel.WRONG_CLASS:
            raise DemlawsError(
                f"contact {first}+{second} is not described by ScGeom and MindlinPhys, but by classes that the law cannot act "
                "on: native Mindlin acted on it; use Ig2_…_ScGeom functors and Ip2_FrictMat_FrictMat_MindlinPhys"
            )
        if kind == kernel.WRONG_CONTACT:
            raise DemlawsError(f"contact {first}+{second} with R = {overlap:g} m: {NOT_SERVED}")
        raise DemlawsError(
            f"contact {first}+{second} at overlap {overlap:g} m: the law gives no finite force there (a table ends, its "
            "radius or modulus is outside those that the law was made for, or the overlap is not a number): make the table for "
            "larger forces, give radii=… and moduli=…, or take a smaller time step"
        )


def _functors(engines):
    """(engine, dispatcher, functor) of every law functor in an engine list."""
    for engine in engines:
        if isinstance(engine, yade.InteractionLoop):
            dispatcher = engine.lawDispatcher
        elif isinstance(engine, yade.LawDispatcher):
            dispatcher = engine
        else:
            continue
        for functor in dispatcher.functors:
            yield engine, dispatcher, functor


def guard(label):
    """Called by a PyRunner before each step: re-attaches after loading, raises what native code could not."""
    here = label, O.thisScene, _engine_lists, O.iter
    binding = _passed.get(here[:3])
    if binding is None or binding.next_step != here[3]:  # else nothing can have been loaded or changed since the last step
        binding = _look(label)
        if binding is None:
            return
        _passed[here[:3]] = binding
    binding.next_step = here[3] + 1
    binding.check_functor(binding.functor)
    binding.raise_fault()
    binding.attachment.make_room(O.interactions.countReal)
    binding.guards += 1
    if binding.guards in (2, 10, 100, 1000) or binding.guards % 100_000 == 0:  # a look at every contact takes time
        binding.verify()
        binding.check_bodies(thoroughly=True)
    elif binding.guards % 100 == 0:
        binding.check_bodies()


_engine_lists = 0  # counts assignments of O.engines and loads
_passed = {}  # (label, scene, _engine_lists) → binding whose functor was found to act


def _look(label):
    """The binding that acts in the functor of this label; None where it had to be attached (again) just now."""
    functor = next((f for _, _, f in _functors(O.engines) if f.label == label), None)
    binding = getattr(functor, "binding", None) or _bindings.get(label)
    if functor is None:
        raise DemlawsError(f"no law functor is labelled {label!r} in O.engines, but its guard is there: remove both or none")
    if binding is not None and binding.attachment is not None and binding.attachment.acts_in(functor):
        binding.functor = functor
        return binding
    _reattach(label, functor)  # the scene was loaded: YADE has made a native functor with this label
    return None


def _forget_passed():
    global _engine_lists
    _engine_lists += 1
    _passed.clear()


def _reattach(label, functor):
    stored = O.tags[f"demlaws.{label}"].split("|", 3) if f"demlaws.{label}" in O.tags.keys() else None  # noqa: SIM118
    binding = _bindings.get(label)
    if binding is None or stored is None or stored[3] != binding.pairs.as_text():
        binding = Binding.from_tag(label)
    else:
        binding.banked = float(stored[2])
    if binding.attachment is None:
        raise DemlawsError(f"law {label!r} was saved under the bridge, which is not available here: {binding.reason}")
    binding.check_functor(functor)
    binding.attachment.patch(functor)
    binding.attachment.context[kernel.GUARDED] = 1
    binding.guards = 0


def attached(label="demlaws"):
    """The law at work in this process or in the loaded scene under this label: totals(), contacts(), verify()."""
    return _bindings.get(label) or Binding.from_tag(label)


class Law2_ScGeom_MindlinPhys_Demlaws(yade.Law2_ScGeom_MindlinPhys_Mindlin):
    """A demlaws law as a YADE Law2 functor: put it where Law2_ScGeom_MindlinPhys_Mindlin would go.

    law: a law's name (`demlaws.laws()`), a `Law`, a `Table`, or the path of a saved table; unloading: "elastic",
    "hertz", "thornton", or a `Law` or `Table` whose curve the contacts unload along (on their own surfaces); surfaces:
    label of a YADE material → `demlaws.Surface`; a material whose label is not listed is smooth, and a pair of smooth
    surfaces is Hertz. Of two surfaces σ² = Sq1² + Sq2². tangential_ratio: K_t/K; None takes YADE's, 2(1-ν)/(2-ν) for
    equal materials. bridge: "native", "public" or "auto" (public with a `BridgeWarning` where the native one is not
    available). label: how guard and saved files know the law; one label a law. radii, moduli: smallest and
    largest effective radius [m] and modulus [Pa] of the contacts, which laws with a solved curve (Yip–Venart,
    Greenwood–Tripp) must know; by default those of the bodies that the scene holds now. Further arguments are the
    law's own options, or attributes of Law2_ScGeom_MindlinPhys_Mindlin (neverErase, calcEnergy,
    preventGranularRatcheting). E*, R, friction and damping are the contact's, as YADE has them.
    """

    def __init__(
        self,
        law="hertz",
        unloading=None,
        surfaces=None,
        *,
        bridge="auto",
        tangential_ratio=None,
        label="demlaws",
        radii=None,
        moduli=None,
        **options,
    ):
        native = {name: options.pop(name) for name in list(options) if name in NATIVE_ATTRIBUTES}
        if bridge not in ("auto", "native", "public"):
            raise DemlawsError(f'bridge must be "auto", "native" or "public", got {bridge!r}')
        if not isinstance(label, str) or not label.isidentifier():
            raise DemlawsError(f"label must be a Python name, got {label!r}: YADE makes a variable of it")
        if tangential_ratio is not None and not 0.0 < tangential_ratio < 10.0:
            raise DemlawsError(f"tangential_ratio = {tangential_ratio:g}: K_t/K must be positive (2(1-ν)/(2-ν) is below 2)")
        super().__init__(label=label, **native)
        pairs = Pairs(law, surfaces, unloading, options, _spans(radii, moduli))
        binding = Binding(label, pairs, tangential_ratio, bridge)
        binding.check_functor(self)
        if binding.attachment is not None:
            binding = _attach(self, binding, bridge)
        if binding.attachment is None and bridge == "auto":
            warnings.warn(
                f"the native bridge is not available ({binding.reason}); the public-API way acts, at some ten times the cost",
                BridgeWarning,
                stacklevel=2,
            )
        self.binding = binding

    @property
    def way(self):
        """How the law acts: "native" or "public"."""
        return self.binding.way

    def totals(self):
        """`Totals` of the current scene: stored energy and plastic dissipation [J], ended contacts included."""
        return self.binding.totals()

    def contacts(self, interactions=None):
        """`ContactState` of all real contacts, or of the given interactions."""
        return self.binding.contacts(interactions)

    def normElastEnergy(self):
        """Stored normal energy [J]; replaces Mindlin's formula, which holds for Hertz only."""
        return self.totals().stored


def _spans(radii, moduli):
    """Label pair → `Span` of the contacts: what the user gave, else what the scene's bodies and materials allow."""
    for name, unit, pair in (("radii", "m", radii), ("moduli", "Pa", moduli)):
        if pair is not None and not (len(pair) == 2 and 0.0 < pair[0] <= pair[1]):
            raise DemlawsError(f"{name} must be (smallest, largest) in {unit}, got {pair!r}")
    sizes, flats, materials = set(), False, {}
    for body in O.bodies:
        if isinstance(body.shape, yade.Sphere):
            sizes.add(body.shape.radius)
        elif not isinstance(body.shape, yade.Clump):
            flats = True
        if isinstance(body.material, yade.FrictMat):
            materials.setdefault(body.material.label, set()).add((body.material.young, body.material.poisson))
    if radii is None and sizes:
        # YADE's effective radius of a sphere is r/2 against its like or a wall, 2r/3 against a facet
        radii = (min(sizes) / 2.0, max(sizes) * (2.0 / 3.0 if flats else 0.5))

    def span(labels, known=frozenset(materials)):
        if radii is None:
            return None
        if moduli is not None:
            return Span(tuple(radii), tuple(moduli))
        first, second = ({m for label in known if label == wanted or not wanted for m in materials[label]} for wanted in labels)
        values = [1.0 / ((1.0 - p**2) / y + (1.0 - q**2) / z) for y, p in first for z, q in second]
        return Span(tuple(radii), (min(values), max(values))) if values else None

    return span


def _attach(functor, binding, way):
    from demlaws.yade.selftest import SelfTestFailed, run

    try:
        run(binding)
    except SelfTestFailed as error:
        if way == "native":
            raise
        binding.attachment, binding.reason = None, str(error)
        return binding
    binding.attachment.patch(functor)
    return binding


# --- the engine list

_native_engines = yade.wrapper.Omega.engines
_native_functors = yade.LawDispatcher.functors


def _is_guard(engine, label):
    return isinstance(engine, yade.PyRunner) and engine.command == GUARD_COMMAND.format(label=label)


def set_engines(engines):
    """What `O.engines = …` does once this module is imported."""
    engines = list(engines)
    found = [(e, f) for e, _, f in _functors(engines) if isinstance(f, Law2_ScGeom_MindlinPhys_Demlaws)]
    _refuse_switch(engines)
    for _, functor in found:
        binding = functor.binding
        binding.check_functor(functor)
        engines = public.rewritten(engines, functor) if binding.attachment is None else _guarded(engines, functor)
    before = {bridge.address(f) for _, _, f in _functors(O.engines)}
    _native_engines.__set__(O, engines)
    _forget_passed()
    for _, functor in found:
        binding = functor.binding
        if bridge.address(functor) not in before:
            _bindings[binding.label] = binding
            binding.banked, binding.guards = 0.0, 0
        if binding.attachment is not None:
            binding.attachment.context[kernel.GUARDED] = 1
        binding.remember()


def _guarded(engines, functor):
    """The list with this law's guard right before the engine that holds it, and nowhere else."""
    engines = [e for e in engines if not _is_guard(e, functor.label)]
    place = next(n for n, (e, fs) in enumerate(_laws_by_engine(engines)) if functor in fs)
    runner = yade.PyRunner(command=GUARD_COMMAND.format(label=functor.label), iterPeriod=1, initRun=True)
    return [*engines[:place], runner, *engines[place:]]


def _laws_by_engine(engines):
    return [(engine, [f for _, _, f in _functors([engine])]) for engine in engines]


def _refuse_switch(engines):
    """YADE caches a functor in each contact: a new one would not act on contacts that live."""
    new = {bridge.address(f): f for _, _, f in _functors(engines)}
    old = {bridge.address(f): f for _, _, f in _functors(_native_engines.__get__(O))}
    ours = [f for f in (*new.values(), *old.values()) if isinstance(f, Law2_ScGeom_MindlinPhys_Demlaws)]
    if not ours or not new or not old or set(new) == set(old) or O.interactions.countReal() == 0:
        return
    raise DemlawsError(
        f"the law is switched while {O.interactions.countReal()} contacts live, which YADE would leave with the old one: "
        "call O.interactions.clear() first"
    )


def _set_functors(dispatcher, functors):
    if any(isinstance(f, Law2_ScGeom_MindlinPhys_Demlaws) for f in functors):
        raise DemlawsError("give the law to InteractionLoop(…) and assign O.engines, so that its guard is put before it")
    _native_functors.__set__(dispatcher, functors)


def _saving(native):
    def save(omega, *arguments, **keywords):
        for label, binding in _bindings.items():
            if any(f.label == label for _, _, f in _functors(O.engines)):
                binding.remember()
        return native(omega, *arguments, **keywords)

    save.__doc__ = native.__doc__
    return save


def _loading(native):
    def load(omega, *arguments, **keywords):
        native(omega, *arguments, **keywords)
        _forget_passed()
        for binding in _bindings.values():
            if binding.tag in O.tags.keys():  # noqa: SIM118  not a dict
                binding.banked = float(O.tags[binding.tag].split("|", 3)[2])

    load.__doc__ = native.__doc__
    return load


def _erasing(native, contacts):
    """`native`, a function that erases, with the account of the `contacts` that it erases kept before."""

    def erase(container, *arguments, **keywords):
        present = {f.label for _, _, f in _functors(O.engines)}
        for label, binding in _bindings.items():
            if label in present:
                binding.bank(contacts(container, *arguments, **keywords))
        return native(container, *arguments, **keywords)

    erase.__doc__, erase.native = native.__doc__, native
    return erase


def _of_body(bodies, number, eraseClumpMembers=False):
    body = bodies[number] if 0 <= number < len(bodies) else None
    if body is None:
        return []
    members = body.shape.members if eraseClumpMembers and isinstance(body.shape, yade.Clump) else ()
    return [contact for one in (number, *members) for contact in bodies[one].intrs()]


def _of_two(interactions, first, second):
    return [interactions[first, second]] if interactions.has(first, second) else []


def _all(container, *arguments):
    return O.interactions


def _wrap_yade():
    omega = yade.wrapper.Omega
    if getattr(omega, "demlaws_wrapped", False):
        return
    omega.demlaws_wrapped = True
    omega.engines = property(_native_engines.__get__, lambda omega, engines: set_engines(engines))
    for name in ("save", "saveTmp", "sceneToString"):
        setattr(omega, name, _saving(getattr(omega, name)))
    for name in ("load", "loadTmp", "reload", "stringToScene"):
        setattr(omega, name, _loading(getattr(omega, name)))
    for container, name, contacts in (
        (yade.wrapper.BodyContainer, "erase", _of_body),
        (yade.wrapper.BodyContainer, "clear", _all),
        (yade.wrapper.InteractionContainer, "erase", _of_two),
        (yade.wrapper.InteractionContainer, "clear", _all),
    ):
        setattr(container, name, _erasing(getattr(container, name), contacts))
    yade.LawDispatcher.functors = property(_native_functors.__get__, _set_functors)


_wrap_yade()


def engines(law, *, geometries=None, bounds=None, physics=None, before=(), after=(), newton=None, verlet=0.1, timestep=None):
    """A whole engine list for spheres, facets, walls and boxes: `O.engines = engines(law)`.

    geometries, bounds: functors in place of the usual ones; physics: an Ip2_FrictMat_FrictMat_MindlinPhys, for damping;
    before, after: engines before and behind the contacts (forces, boundaries); newton: a NewtonIntegrator (no damping);
    verlet: `InsertionSortCollider.verletDist` in units of the smallest radius; timestep: a share of the critical step for
    GlobalStiffnessTimeStepper, None to leave `O.dt` to you.
    """
    bounds = bounds or [yade.Bo1_Sphere_Aabb(), yade.Bo1_Facet_Aabb(), yade.Bo1_Wall_Aabb(), yade.Bo1_Box_Aabb()]
    geometries = geometries or [
        yade.Ig2_Sphere_Sphere_ScGeom(),
        yade.Ig2_Facet_Sphere_ScGeom(),
        yade.Ig2_Wall_Sphere_ScGeom(),
        yade.Ig2_Box_Sphere_ScGeom(),
    ]
    stepper = []
    if timestep is not None:
        stepper = [yade.GlobalStiffnessTimeStepper(timestepSafetyCoefficient=timestep, timeStepUpdateInterval=10)]
    return [
        yade.ForceResetter(),
        yade.InsertionSortCollider(bounds, verletDist=-verlet),
        *before,
        yade.InteractionLoop(geometries, [physics or yade.Ip2_FrictMat_FrictMat_MindlinPhys()], [law]),
        *stepper,
        *after,
        newton or yade.NewtonIntegrator(damping=0),
    ]
