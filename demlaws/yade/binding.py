"""One law at work in one scene: its account of energy, its state for users, its checks."""

import json
import math
import threading
import warnings
from collections import deque

import numpy as np
import yade
import yade.utils

from demlaws.errors import DemlawsError, EngineStopped, ValidityWarning
from demlaws.units import SMALL_OVERLAP, large_overlap, too_large_overlap
from demlaws.yade import layout as at
from demlaws.yade import native
from demlaws.yade.contacts import Totals, is_ours, real_contacts, rows_of, state_of
from demlaws.yade.pairs import NOT_SERVED, Pairs

O = yade.O  # noqa: E741  YADE's name
LOOKS = (2, 3, 12, 102, 1002)  # calls of the guard at which it looks at every contact and body, which takes time
REACH = 4.0
"""Longest step over the P-wave step r √(ρ/E) that is stable for a free sphere with four contacts per side at contact radii up
to 0.3 R: 2 √(m/4K) with m = 4/3 π ρ r³, K = 2 E* a, R = r/2, E* = E/2 is 5.3 r √(ρ/E); less, for safety [our derivation]"""


class _Request:
    """Work for the thread of a running simulation."""

    def __init__(self, function):
        self.function, self.result, self.error, self.done = function, None, None, threading.Event()

    def answer(self):
        try:
            self.result = self.function()
        except Exception as error:
            self.error = error
        self.done.set()


class Binding:
    """A law at work under a functor's label, in the scene whose token is `scene` (None: in none).

    runner: the PyRunner before this law's contacts; held: contacts that the public way keeps between steps; share: the part of
    the critical step for a time stepper, from `engines(law, timestep=…)`.
    """

    def __init__(self, label, pairs, ratio, way):
        self.label, self.pairs, self.ratio = label, pairs, ratio
        self.attachment = self.reason = self.held = self.runner = self.share = None
        if way != "public":
            try:
                self.attachment = native.Attachment(pairs, ratio)
            except native.BridgeUnavailable as error:
                if way == "native":
                    raise
                self.reason = str(error)
        self.context = at.Context() if self.attachment is None else self.attachment.context
        self.context.words[at.UNLISTED] = pairs.needs_no_judgement
        self.scene, self.left, self.guards, self.warned = None, None, 0, False
        self._requests = deque()

    @property
    def way(self):
        """native or public: how the law acts."""
        return "public" if self.attachment is None else "native"

    @property
    def account(self):
        """Dissipation [J] of ended contacts, and the number of contacts that the law has seen begin and not end."""
        return float(self.context.doubles[at.BANKED]), int(self.context.words[at.OPEN])

    @account.setter
    def account(self, values):
        self.context.doubles[at.BANKED], self.context.words[at.OPEN] = values

    def enter(self, scene, account=(0.0, 0)):
        """Begin to act in a scene with this account; the account of a scene that was left continues."""
        if scene != self.left:
            self.account = account
        self.scene, self.left, self.guards, self.warned, self.held = scene, None, 0, False, None
        self.context.forget()

    def leave(self):
        """The law is no longer in its scene's engine list."""
        self.scene, self.left = None, self.scene
        self.watched_by(None)

    def watched_by(self, runner):
        """Set the guard's PyRunner before this law's contacts, or None."""
        self.runner = runner
        if self.attachment is not None:
            self.attachment.watched_by(runner)

    def same_as(self, other):
        """Whether two bindings are the same law: contacts of one may continue with the other."""
        return (self.way, self.ratio, self.pairs.as_text(True)) == (other.way, other.ratio, other.pairs.as_text(True))

    # --- saved with the scene

    def as_text(self, attributes):
        """JSON from which `from_text` restores the law in another process; attributes: the functor's."""
        self.settle()
        ratio = None if self.ratio is None else float(self.ratio)
        content = {"way": self.way, "ratio": ratio, "account": self.account, "attributes": attributes}
        return json.dumps(content | {"pairs": self.pairs.as_text()})

    @classmethod
    def from_text(cls, label, text):
        """The binding described by `as_text`, in no scene, and the functor's attributes."""
        content = json.loads(text)
        binding = cls(label, Pairs.from_text(content["pairs"]), content["ratio"], content["way"])
        return binding, content["attributes"]

    def settle(self):
        """Write the history of contacts that the public way keeps to YADE's objects."""
        if self.held is not None and self.held.valid_at == (self.scene, O.iter):
            self.held.flush()

    # --- for users

    def between_engines(self, function):
        """function(), called by the simulation's own thread where it runs: contacts do not change while they are read."""
        in_simulation = threading.current_thread().name.startswith("Dummy")  # Python's name for a thread made by C++
        if not O.running or self.runner is None or in_simulation:
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
        """Call the functions that `between_engines` has queued."""
        while self._requests:
            self._requests.popleft().answer()

    def totals(self):
        """`Totals` of the current scene, ended contacts included; also while the simulation runs."""
        return self.between_engines(self._totals)

    def _totals(self):
        self.settle()
        rows = rows_of(real_contacts())
        rows = rows[rows["tag"] > 0]
        found, (banked, opened) = self.pairs.energies(rows), self.account
        return Totals(float(found["stored"].sum()), float(found["dissipated"].sum()) + banked, max(opened - len(rows), 0))

    def contacts(self, interactions=None):
        """`ContactState` of all real contacts of the scene (or of the given ones); also while the simulation runs."""

        def read():
            self.settle()
            given = [interactions] if isinstance(interactions, yade.Interaction) else interactions
            return state_of(self.pairs, real_contacts() if given is None else [one for one in given if is_ours(one)])

        return self.between_engines(read)

    def describe(self):
        """One line: law, surfaces, way, counts."""
        surfaces = ", ".join(
            f"{label}: Sq {s.roughness:g} m" + ("" if s.fractal_dimension is None else f", Df {s.fractal_dimension:g}")
            for label, s in self.pairs.all_surfaces().items()
        )
        count = O.interactions.countReal()
        if self.scene is None:
            where = "in no scene"
        elif O.running:
            where = f"{count} contacts of all kinds, running"
        else:
            where = f"{sum(contact.phys.momentBend[0] > 0 for contact in real_contacts())} contacts of {count}"
        reason = f" ({self.reason})" if self.reason else ""
        smooth = ", meant smooth" if self.pairs.smooth else ""
        return f"{self.pairs.name}; surfaces: {surfaces or 'none' + smooth}; {self.way} bridge{reason}; {where}"

    # --- checks

    def watch(self, functor):
        """Work of the guard: raise the faults of native code, make room, check everything now and then."""
        self.guards += 1
        self.check_functor(functor)
        self.raise_fault()
        self.answer()
        self.judge_unlisted(self.context.take_unlisted())
        if self.context.take_deep():
            rows = rows_of(real_contacts())
            self.warn_of_deep(rows[rows["tag"] > 0])
        self.attachment.make_room(O.interactions.countReal)
        thoroughly = self.guards in LOOKS or self.guards % 1000 == 0
        if thoroughly:
            self.verify()
        self.check_bodies(thoroughly)

    def verify(self):
        """Raise unless every contact of the law's class has this law's mark.

        Coefficients are not compared: engines of YADE may scale them (TriaxialStressController with internalCompaction).
        """
        for contact in real_contacts():
            if contact.phys.momentBend[0] > 0 or contact.iterMadeReal >= O.iter - 1 or contact.geom.penetrationDepth <= 0:
                continue  # made by another engine just now, or about to end
            raise EngineStopped(
                f"contact {contact.id1}+{contact.id2} was not computed by the law {self.label!r}: another functor computes it, "
                "since YADE keeps the functor of a contact from its first step. O.interactions.clear() lets all contacts begin "
                "again, but erases their history (shear forces, plastic overlaps)"
            )

    def judge_unlisted(self, bodies):
        """Raise unless two bodies, of whose materials at least one has no surface, are meant to be smooth."""
        if bodies is None or self.context.words[at.UNLISTED]:
            return
        borne = {body.material.label for body in O.bodies if body.material is not None}
        known = borne | {one.label for one in O.materials}  # bodies of it may come later
        missing = [label for label in self.pairs.surfaces if label not in known]
        if self.pairs.surfaces and not missing:
            self.context.words[at.UNLISTED] = 1
            return
        labels = [O.bodies[number].material.label for number in bodies]
        what = "no surface was given"
        if missing:
            what = f"no body's material has the label {' or '.join(map(repr, missing))}, for which a surface was given"
        raise EngineStopped(
            f"{what}: contact {bodies[0]}+{bodies[1]}, of materials labelled {labels[0]!r} and {labels[1]!r}, would be smooth "
            f"under the law {self.pairs.name}. Labels of the bodies' materials: {', '.join(map(repr, sorted(borne)))}. Give "
            "surfaces={label: demlaws.Surface(...)} for those that are rough, or smooth=True if the others are meant smooth"
        )

    def warn_of_deep(self, rows):
        """Warn of the contacts beyond SMALL_OVERLAP of their R among rows of `layout.CONTACT`."""
        rows = rows[rows["modulus"] > 0.0]
        ratio = rows["overlap"] / rows["radius"]
        count = int(np.sum(ratio > SMALL_OVERLAP))
        if count:
            deepest = rows[np.argmax(ratio)]
            text = large_overlap(float(deepest["overlap"]), float(deepest["radius"]), count, len(rows))
            warnings.warn(f"law {self.label!r}: {text}", ValidityWarning, stacklevel=2)

    def check_bodies(self, thoroughly=False):
        """Raise if a body without contacts has a velocity (thoroughly: or a position) that is not finite."""
        if not thoroughly and math.isfinite(yade.utils.kineticEnergy()):
            return
        for body in O.bodies:
            place, velocity = body.state.pos, body.state.vel
            if not all(map(math.isfinite, (*place, *velocity))):
                raise EngineStopped(
                    f"body {body.id} is at {tuple(place)} m with velocity {tuple(velocity)} m/s, which is not finite: take a "
                    "smaller time step, or check what the script did to it"
                )

    def check_functor(self, functor):
        """Raise if the functor has settings that do not go together with a law."""
        reasons = {
            "includeMoment": "its moments use the memory of the law's history",
            "includeAdhesion": "it changes the force",
        }
        for name, reason in reasons.items():
            if getattr(functor, name):
                raise DemlawsError(f"{name}=True cannot be used with a demlaws law: {reason}")

    def raise_fault(self):
        """Raise the last fault of native code: a contact that the law does not serve."""
        fault = self.context.take_fault()
        if fault is not None:
            kind, first, second, value = fault
            raise EngineStopped(f"contact {first}+{second}{self.fault_text(kind, first, second, value)}")

    def fault_text(self, kind, first, second, value, radius=None):
        """Message about a fault of the contact of two bodies; value: overlap or R [m], or E* [Pa]; radius: R [m]."""
        stones = [O.bodies[number].material for number in (first, second)]
        if kind == at.WRONG_CLASS:
            return (
                " is not described by ScGeom and MindlinPhys, but by classes that the law does not act on: native Mindlin "
                "acted on it; use Ig2_…_ScGeom functors and Ip2_FrictMat_FrictMat_MindlinPhys"
            )
        if kind == at.TOO_DEEP:
            return f": {too_large_overlap(value, float(self.context.doubles[at.DEEP_RADIUS]) if radius is None else radius)}"
        if kind == at.WRONG_MODULUS:
            of = ", ".join(f"{stone.label!r} young={stone.young:g} Pa, poisson={stone.poisson:g}" for stone in stones)
            return f": its materials make E* = {value:g} Pa, which must be above 0 and finite: {of}"
        if kind == at.WRONG_CONTACT:
            return f" with R = {value:g} m: {NOT_SERVED}"
        if kind == at.TOO_ROUGH:
            labels = [stone.label for stone in stones]
            roughness = self.pairs.roughnesses[self.pairs.number(*labels)]
            return (
                f" ({labels[0]!r} on {labels[1]!r}): the combined roughness {roughness:g} m exceeds its effective radius "
                f"{value:g} m: check the units (σ is usually µm, R mm)"
            )
        return (
            f" at overlap {value:g} m: the law gives no finite force there (a table ends, its radius or modulus is outside "
            "those that the law was made for, or the overlap is not finite): make the table for larger forces, give radii=… "
            "and moduli=…, or take a smaller time step"
        )

    # --- the time step

    def bound_steppers(self, engines):
        """Set maxDt of GlobalStiffnessTimeSteppers to a bound that is stable for stiff contacts; returns a warning or None.

        They use the present stiffness of contacts, and a young rough contact is soft until the step in which it is not.
        """
        steppers = [e for e in engines if isinstance(e, yade.GlobalStiffnessTimeStepper) and not e.dead and e.active]
        wave = yade.utils.PWaveTimeStep() if steppers else 0.0
        message = None
        for stepper in steppers if 0.0 < wave < np.inf else ():
            bound = REACH * wave * min(stepper.timestepSafetyCoefficient, 1.0)
            unbounded = stepper.maxDt > REACH * wave
            if stepper.maxDt <= bound * (1 + 1e-9) or not (unbounded or self.share is not None):
                continue
            if self.share is None and not self.warned:
                self.warned = True
                message = (
                    f"GlobalStiffnessTimeStepper had no bound that is valid for law {self.label!r}: it uses the present "
                    "stiffness of contacts, and a young rough contact is soft until the step in which it is not. Its maxDt was "
                    f"{stepper.maxDt:.3g} s and is now {bound:.3g} s ({REACH:g} PWaveTimeStep() of the bodies times its safety "
                    "coefficient); give it a maxDt to choose another, or use demlaws.yade.engines(law, timestep=…)"
                )
            stepper.maxDt = bound
        return message
