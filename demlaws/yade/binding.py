"""One law at work in one scene: its account of energy, what users read of it, what it watches."""

import math
import threading
import warnings
from collections import deque

import numpy as np
import yade
import yade.utils

from demlaws.errors import DemlawsError, ValidityWarning
from demlaws.units import SMALL_OVERLAP, large_overlap, too_large_overlap
from demlaws.yade import kernel, native
from demlaws.yade.contacts import Totals, is_ours, real_contacts, rows_of, state_of
from demlaws.yade.pairs import FLATS, NOT_SERVED, Pairs
from demlaws.yade.public import Held

O = yade.O  # noqa: E741  YADE's name
LOOKS = (2, 3, 12, 102, 1002)  # calls of the guard at which it looks at every contact and body, which takes time
REACH = 4.0
"""Longest step over the P-wave step r √(ρ/E) that a free sphere with four contacts a side stands at contact radii up to 0.3 R:
2 √(m/4K) with m = 4/3 π ρ r³, K = 2 E* a, R = r/2, E* = E/2 is 5.3 r √(ρ/E); less, to be on the safe side [our derivation]"""


class _Request:
    """Something to be done by the thread of a running simulation."""

    def __init__(self, function):
        self.function, self.result, self.error, self.done = function, None, None, threading.Event()

    def answer(self):
        try:
            self.result = self.function()
        except Exception as error:
            self.error = error
        self.done.set()


class Binding:
    """A law at work under a functor's label, in the scene whose token is `scene` (None: in none)."""

    def __init__(self, label, pairs, ratio, way):
        self.label, self.pairs, self.ratio = label, pairs, ratio
        self.attachment = None
        self.reason = None
        self.public_banked = 0.0
        self.held = Held()
        if way != "public":
            try:
                self.attachment = native.Attachment(pairs, ratio, FLATS.index(pairs.flats))
            except native.BridgeUnavailable as error:
                if way == "native":
                    raise
                self.reason = str(error)
        if self.attachment is not None:
            self.attachment.unlisted_served = pairs.needs_no_judgement
        self.unlisted_served = pairs.needs_no_judgement
        self.scene, self.left, self.guards, self.runner = None, None, 0, None
        self.share, self.warned, self.deep_told = None, False, False
        self._requests = deque()

    @property
    def way(self):
        """native or public: how the law acts."""
        return "public" if self.attachment is None else "native"

    @property
    def banked(self):
        """Dissipation [J] of contacts that have ended."""
        return self.public_banked if self.attachment is None else self.attachment.banked

    @banked.setter
    def banked(self, value):
        if self.attachment is None:
            self.public_banked = value
        else:
            self.attachment.banked = value

    def enter(self, scene, banked=0.0):
        """Begin to act in a scene, with what was dissipated in it before; a scene that was left is gone on with."""
        if scene != self.left:
            self.banked = banked
        self.scene, self.left, self.guards, self.warned, self.deep_told = scene, None, 0, False, False
        self.held = Held()
        if self.attachment is not None:
            self.attachment.take_fault()
            self.attachment.take_unlisted()
            self.attachment.forget_deep()

    def leave(self):
        """The law is no longer in its scene's engine list."""
        self.scene, self.left = None, self.scene
        self.watched_by(None)

    def watched_by(self, runner):
        """The guard's PyRunner before this law's contacts, or None."""
        self.runner = runner
        if self.attachment is not None:
            self.attachment.watched_by(runner)

    def same_as(self, other):
        """Whether two bindings are the same law: contacts of one may go on with the other."""
        return (self.way, self.ratio, self.pairs.as_text(True)) == (other.way, other.ratio, other.pairs.as_text(True))

    # --- saved with the scene

    def as_text(self):
        """All that another process needs."""
        self.settle()
        ratio = "" if self.ratio is None else repr(float(self.ratio))
        return "|".join((self.way, ratio, repr(float(self.banked)), self.pairs.as_text()))

    @classmethod
    def from_text(cls, label, text):
        """The binding that `as_text` described, with what it had dissipated, in no scene yet."""
        way, ratio, banked, pairs = text.split("|", 3)
        binding = cls(label, Pairs.from_text(pairs), float(ratio) if ratio else None, way)
        binding.banked = float(banked)
        return binding

    def settle(self):
        """Bring YADE's objects up to date with what the public way holds."""
        if self.attachment is None and self.held.valid_at == (self.scene, O.iter):
            self.held.flush()

    # --- what users read

    def between_engines(self, function):
        """function(), by the simulation's own thread where it runs: contacts do not come and go while they are read."""
        if not O.running or self.runner is None or isinstance(threading.current_thread(), threading._DummyThread):
            return function()
        request = _Request(function)
        self._requests.append(request)
        while not request.done.wait(0.02):
            self.runner.nDone = 0
            if not O.running:
                try:
                    self._requests.remove(request)
                except ValueError:
                    continue  # being answered
                return function()
        if request.error is not None:
            raise request.error
        return request.result

    def answer(self):
        """What `between_engines` was asked for."""
        while self._requests:
            try:
                request = self._requests.popleft()
            except IndexError:
                return
            request.answer()

    def totals(self):
        """Stored energy and plastic dissipation [J] of the current scene, ended contacts included; also while it runs.

        What contacts have stored when they are erased with a body is gone; what they have dissipated stays in the account.
        """
        return self.between_engines(self._totals)

    def _totals(self):
        self.settle()
        rows = rows_of(real_contacts())
        found = self.pairs.energies(rows[rows["tag"] > 0])
        return Totals(float(found["stored"].sum()), float(found["dissipated"].sum()) + self.banked)

    def contacts(self, interactions=None):
        """State of all real contacts of the scene (or of the given ones) as arrays: a `ContactState`; also while it runs."""

        def read():
            self.settle()
            given = [interactions] if isinstance(interactions, yade.Interaction) else interactions
            return state_of(self.pairs, real_contacts() if given is None else [one for one in given if is_ours(one)])

        return self.between_engines(read)

    def bank(self, contacts):
        """Keep in the account what these contacts have dissipated: they are about to be erased."""
        self.settle()
        contacts = [contact for contact in contacts if is_ours(contact)]
        rows = rows_of(contacts)
        self.banked += float(self.pairs.energies(rows[rows["tag"] > 0])["dissipated"].sum())
        for contact in contacts:  # YADE may show it until the next step: its history is not counted twice
            contact.phys.momentTwist = yade.Vector3(0, 0, 0)
        self.held.valid_at = None

    def account(self, function):
        """function(), which erases contacts of its own choice: what those had dissipated stays in the account."""
        self.settle()
        contacts = [contact for contact in real_contacts() if contact.phys.momentBend[0] > 0]
        dissipated = self.pairs.energies(rows_of(contacts))["dissipated"]
        names = [(contact.id1, contact.id2) for contact in contacts]
        result = function()
        left = {(contact.id1, contact.id2) for contact in real_contacts()}
        self.banked += float(sum(energy for name, energy in zip(names, dissipated, strict=True) if name not in left))
        self.held.valid_at = None
        return result

    def describe(self):
        """One line: law, surfaces, way, counts."""
        surfaces = ", ".join(
            f"{label}: Sq {s.roughness:g} m" + ("" if s.fractal_dimension is None else f", Df {s.fractal_dimension:g}")
            for label, s in self.pairs.all_surfaces().items()
        )
        there = O.interactions.countReal()
        where = f"{self.contact_count()} contacts of {there}" if not O.running else f"{there} contacts of all kinds, running"
        where = "in no scene" if self.scene is None else where
        reason = f" ({self.reason})" if self.reason else ""
        return (
            f"{self.pairs.name}; surfaces: {surfaces or 'none' + (', meant smooth' if self.pairs.smooth else '')}; "
            f"{self.way} bridge{reason}; {where}"
        )

    def contact_count(self):
        """Number of the current scene's contacts that bear this law's mark."""
        return sum(contact.phys.momentBend[0] > 0 for contact in real_contacts())

    # --- watch

    def watch(self, functor):
        """What the guard does: raises what native code could not, gives it room, looks at everything now and then."""
        self.guards += 1
        self.check_functor(functor)
        self.raise_fault()
        self.answer()
        self.judge_unlisted(self.attachment.take_unlisted())
        if self.attachment.take_deep():
            rows = rows_of(real_contacts())
            self.tell_deep(rows[rows["tag"] > 0])
        self.attachment.make_room(O.interactions.countReal)
        if self.guards in LOOKS or self.guards % 1000 == 0:
            self.verify()
            self.check_bodies(thoroughly=True)
        else:
            self.check_bodies()

    def verify(self):
        """Every contact that is ours by its class must bear this law's mark, or a DemlawsError says which does not.

        Coefficients are not compared: engines of YADE's own may scale them (TriaxialStressController with
        internalCompaction), and go on from there.
        """
        for contact in real_contacts():
            if contact.phys.momentBend[0] > 0 or contact.iterMadeReal >= O.iter - 1 or contact.geom.penetrationDepth <= 0:
                continue  # made by something else than InteractionLoop just now, or about to end
            raise DemlawsError(
                f"contact {contact.id1}+{contact.id2} was not computed by the law {self.label!r}: another functor holds it, "
                "since YADE keeps the functor that a contact began with. O.interactions.clear() lets all contacts begin anew, "
                "but erases their history (shear forces, plastic overlaps)"
            )

    def judge_unlisted(self, bodies):
        """Two bodies met whose materials are not both listed in `surfaces`: whether they were meant to be smooth."""
        if bodies is None or self.unlisted_served:
            return
        borne = {body.material.label for body in O.bodies if body.material is not None}
        known = borne | {one.label for one in O.materials}  # bodies of it may come later
        missing = [label for label in self.pairs.surfaces if label not in known]
        if self.pairs.surfaces and not missing:
            self.unlisted_served = self.attachment_serves_unlisted()
            return
        labels = [O.bodies[number].material.label for number in bodies]
        if missing:
            what = f"no body's material bears the label {' or '.join(map(repr, missing))}, for which a surface was given"
        else:
            what = "no surface was given"
        raise DemlawsError(
            f"{what}: contact {bodies[0]}+{bodies[1]}, of materials labelled {labels[0]!r} and {labels[1]!r}, would be smooth "
            f"under the law {self.pairs.name}. Labels of the bodies' materials: {', '.join(map(repr, sorted(borne)))}. Give "
            "surfaces={label: demlaws.Surface(...)} for those that are rough, or smooth=True if the others are meant smooth"
        )

    def attachment_serves_unlisted(self):
        """Let pairs without a row of their own be served as smooth ones; True."""
        if self.attachment is not None:
            self.attachment.unlisted_served = True
        return True

    def tell_deep(self, rows):
        """Warn once in a scene of contacts beyond SMALL_OVERLAP of their R, out of an array of `kernel.CONTACT`."""
        rows = rows[rows["modulus"] > 0.0]
        ratio = rows["overlap"] / rows["radius"]
        count = int(np.sum(ratio > SMALL_OVERLAP))
        if self.deep_told or not count:
            return
        self.deep_told = True
        worst = rows[np.argmax(ratio)]
        text = large_overlap(float(worst["overlap"]), float(worst["radius"]), count, len(rows))
        warnings.warn(f"law {self.label!r}: {text}", ValidityWarning, stacklevel=2)

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
        """DemlawsError where the functor has settings that a law cannot go with."""
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
        """Raise what native code left as a fault: a contact that the law cannot serve."""
        found = self.attachment.take_fault() if self.attachment else None
        if found is None:
            return
        kind, first, second, overlap = found
        if kind == kernel.WRONG_CLASS:
            raise DemlawsError(
                f"contact {first}+{second} is not described by ScGeom and MindlinPhys, but by classes that the law cannot act "
                "on: native Mindlin acted on it; use Ig2_…_ScGeom functors and Ip2_FrictMat_FrictMat_MindlinPhys"
            )
        if kind == kernel.TOO_DEEP:
            raise DemlawsError(f"contact {first}+{second}: {too_large_overlap(overlap, self.attachment.deep_radius)}")
        if kind == kernel.WRONG_MODULUS:
            raise DemlawsError(self.wrong_modulus(first, second, overlap))
        if kind == kernel.WRONG_CONTACT:
            raise DemlawsError(f"contact {first}+{second} with R = {overlap:g} m: {NOT_SERVED}")
        if kind == kernel.TOO_ROUGH:
            raise DemlawsError(self.too_rough(first, second, overlap))
        raise DemlawsError(
            f"contact {first}+{second} at overlap {overlap:g} m: the law gives no finite force there (a table ends, its "
            "radius or modulus is outside those that the law was made for, or the overlap is not a number): make the table for "
            "larger forces, give radii=… and moduli=…, or take a smaller time step"
        )

    def wrong_modulus(self, first, second, modulus):
        """The sentence about a contact whose effective modulus [Pa] is no positive number."""
        stones = [O.bodies[number].material for number in (first, second)]
        of = ", ".join(f"{stone.label!r} young={stone.young:g} Pa, poisson={stone.poisson:g}" for stone in stones)
        return f"contact {first}+{second}: its materials make E* = {modulus:g} Pa, which must be above 0 and finite: {of}"

    def too_rough(self, first, second, radius):
        """The sentence about a contact whose roughness exceeds its radius [m]."""
        labels = [O.bodies[number].material.label for number in (first, second)]
        roughness = self.pairs.roughnesses[self.pairs.number(*labels)]
        return (
            f"contact {first}+{second} ({labels[0]!r} on {labels[1]!r}): the combined roughness {roughness:g} m exceeds its "
            f"effective radius {radius:g} m: check the units (σ is usually µm, R mm)"
        )

    # --- the time step

    def bound_steppers(self, engines):
        """Keep GlobalStiffnessTimeSteppers below what stiff contacts stand; what is to be said of a user's that had no bound.

        They go by the contacts as they are, and a young rough contact is soft until the step in which it is not.
        """
        steppers = [e for e in engines if isinstance(e, yade.GlobalStiffnessTimeStepper) and not e.dead and e.active]
        if not steppers:
            return None
        wave = yade.utils.PWaveTimeStep()
        if not (0.0 < wave < np.inf):
            return None
        said = None
        for stepper in steppers:
            bound = REACH * wave * min(stepper.timestepSafetyCoefficient, 1.0)
            if stepper.maxDt > bound * (1 + 1e-9):
                if self.share is None and stepper.maxDt > REACH * wave and not self.warned:
                    self.warned = True
                    said = (
                        f"GlobalStiffnessTimeStepper had no bound that holds for law {self.label!r}: it goes by the contacts "
                        "as they are, and a young rough contact is soft until the step in which it is not. Its maxDt was "
                        f"{stepper.maxDt:.3g} s and is now {bound:.3g} s ({REACH:g} PWaveTimeStep() of the bodies times its "
                        "safety coefficient); give it a maxDt to choose another, or use demlaws.yade.engines(law, timestep=…)"
                    )
                if self.share is not None or stepper.maxDt > REACH * wave:
                    stepper.maxDt = bound
        return said
