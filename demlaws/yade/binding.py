"""One law at work in one scene: its account of energy, its state for users, its checks."""

import math
import threading
from collections import deque

import numpy as np
import yade
import yade.utils

from demlaws.errors import DemlawsError, EngineStopped, LargeOverlap, ShapeWarning, warn
from demlaws.units import LARGE_RADIUS, LARGE_ROUGHNESS, SMALL_OVERLAP, judge
from demlaws.yade import layout, native
from demlaws.yade.omega import LOOKS, is_our_contact, radius_fault, real_contacts, token_here, with_overlaps

O = yade.O  # noqa: E741  YADE's name
REACH = 4.0
"""Longest step over the P-wave step r √(ρ/E) that is stable for a free sphere with four contacts per side at contact radii up
to 0.3 R: 2 √(m/4K) with m = 4/3 π ρ r³, K = 2 E* a, R = r/2, E* = E/2 is 5.3 r √(ρ/E); less, for safety [our derivation]"""


NO_BOUND = 1e300
"""maxDt [s] of a time stepper that has none is larger."""


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

    runner: the PyRunner before this law's contacts; share: the part of the critical step for a time stepper, from
    `engines(law, timestep=…)`; bound: the maxDt [s] that the law has given a stepper; seen: losses [J] of plasticity, of shear
    and of viscous damping when `O.energy` was last read.
    """

    def __init__(self, label, pairs):
        self.label, self.pairs = label, pairs
        self.runner = self.share = self.bound = None
        self.seen = [0.0, 0.0, 0.0]
        self.attachment = native.Attachment(pairs)
        self.context = self.attachment.context
        self.context["may_be_unlisted"] = pairs.needs_no_judgement
        self.scene, self.left, self.guards, self.warned, self._scenes = None, None, 0, False, 0
        self._messages, self._limits = set(), {}
        self._requests = deque()

    @property
    def account(self):
        """Dissipation [J] of ended contacts, number of contacts that the law has seen begin and not end, energies [J] of shear
        and of viscous damping that ended contacts have lost."""
        shear, viscous = float(self.context["banked_shear"]), float(self.context["banked_viscous"])
        return float(self.context["banked"]), int(self.context["open"]), shear, viscous

    @account.setter
    def account(self, values):
        for name, value in zip(("banked", "open", "banked_shear", "banked_viscous"), values, strict=True):
            self.context[name] = value

    def enter(self, scene, account=(0.0, 0, 0.0, 0.0)):
        """Begin to act in a scene with this account; the account of a scene that was left continues."""
        if scene != self.left:
            self.attachment.rows.release()  # of contacts of another scene, which ends or stops
            self.account, self.seen = account, [0.0, 0.0, 0.0]
            self._scenes += 1
        self.scene, self.left, self.guards, self.warned = scene, None, 0, False
        self._messages, self._limits = set(), {}
        self.context.forget()

    def leave(self):
        """The law is no longer in the engine list of the current scene."""
        self.scene, self.left = None, self.scene
        self.watched_by(None)
        if O.interactions.countReal() == 0:
            self.attachment.rows.release()

    def end(self):
        """The scene of the law is gone, with its contacts."""
        self.scene = self.left = None
        self.watched_by(None)
        self.attachment.rows.release()

    def watched_by(self, runner):
        """Set the guard's PyRunner before this law's contacts, or None."""
        self.runner = runner
        self.attachment.watched_by(runner)

    def rows(self, contacts):
        """The contacts as an array of `layout.CONTACT`; tag 0 where the law has not seen the contact."""
        return with_overlaps(self.attachment.rows_of(contacts), contacts)

    # --- for users

    def between_engines(self, function):
        """function(), called by the simulation's own thread where it runs: contacts do not change while they are read."""
        _ = O.engines  # a scene that was loaded and has not made a step gets its laws
        in_simulation = threading.current_thread().name.startswith("Dummy")  # Python's name for a thread made by C++
        if not O.running or self.runner is None or self.scene != token_here() or in_simulation:
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
        from demlaws.yade.contacts import Totals

        self.raise_fault()
        self.judge_validity()
        rows = self.rows(real_contacts())
        rows = rows[rows["tag"] > 0]
        energies, (past, open_count, loss, viscous) = self.pairs.energies(rows), self.account
        more = {"shear_stored": float(rows["held"].sum()), "shear_dissipated": float(rows["lost"].sum()) + loss}
        if self.attachment.layout.knows_velocities:
            more["viscous"] = float(rows["viscous"].sum()) + viscous
        stored, dissipated = float(energies["stored"].sum()), float(energies["dissipated"].sum()) + past
        return Totals(stored, dissipated, max(open_count - len(rows), 0), **more)

    def account_for(self, tracker):
        """Write the energies [J] to YADE's EnergyTracker, adding what was lost since the last call; None: it does not track."""
        totals = self._totals()
        losses = [totals.dissipated, totals.shear_dissipated, totals.viscous]
        if tracker is not None:
            tracked = dict(tracker.items())
            energies = {"Elastic": totals.stored, "ShearElastic": totals.shear_stored}
            for name, loss, seen in zip(("Plastic", "ShearLost", "Viscous"), losses, self.seen, strict=True):
                energies[name] = tracked.get(self.label + name, 0.0) + loss - seen
            for name, energy in energies.items():
                if energy == energy:  # the work of viscous forces is not known where the native go acts
                    tracker[self.label + name] = energy
        self.seen = losses

    def contacts(self, interactions=None):
        """`Contacts`: all real contacts of the scene (or of the given ones); also while the simulation runs."""

        from demlaws.yade.contacts import SHEAR, state_of

        def read():
            selection = [interactions] if isinstance(interactions, yade.Interaction) else interactions
            contacts = real_contacts() if selection is None else [one for one in selection if is_our_contact(one)]
            known = list(SHEAR)[: 3 if self.attachment.layout.knows_velocities else 2]
            return state_of(self.pairs, contacts, self.rows(contacts), known)

        return self.between_engines(read)

    # --- checks

    def watch(self, functor):
        """Work of the guard: raise the faults of native code, make room, check everything now and then."""
        self.guards += 1
        if not O.dt > 0.0:
            self._judge_step()
        self.check_functor(functor)
        self.raise_fault()
        self.answer()
        self.judge_unlisted(self.context.take_unlisted())
        self.pairs.radii.refresh(self.context)
        self.warn_of_shapes()
        self.warn_of_joints()
        self.refuse_changes()
        if self.context.take("deep"):
            rows = self.rows(real_contacts())
            self.warn_of_deep(rows[rows["tag"] > 0])
        self.attachment.collect(real_contacts if self._scenes == 1 else None)
        thoroughly = self.guards in LOOKS or self.guards % 1000 == 0
        if thoroughly:
            self.verify()
        if self.guards < 20 or self.guards % 10 == 0:
            self.judge_validity()
        self.check_bodies(thoroughly)

    def _judge_step(self):
        """Warn once of a step of 0, raise for one that is not a number or negative."""
        if O.dt != 0.0:
            raise EngineStopped(f"O.dt = {O.dt:g} s: give a positive time step")
        self._warn_once("step", "O.dt = 0 s: bodies do not move, and viscous damping has no velocity; set O.dt")

    def verify(self):
        """Raise unless every contact of the law's class has this law's mark, and materials are admissible.

        kn and ks are not compared: engines of YADE may scale them (TriaxialStressController with internalCompaction).
        """
        contacts = real_contacts()
        touching = [O.bodies[number] for number in {n for contact in contacts for n in (contact.id1, contact.id2)}]
        self._judge_densities(touching)
        for material in {body.material.id: body.material for body in touching}.values():
            if any(getattr(material, name, 0.0) for name in ("c1", "c2")):  # FrictMatCDM
                raise EngineStopped(
                    f"material {material.label!r} has c1 = {material.c1:g}, c2 = {material.c2:g}: a friction that depends on "
                    "the force, which the contacts of Ip2_FrictMat_FrictMat_MindlinPhys do not have; set c1 = c2 = 0"
                )
            if material.young != 0.0:  # 0: a marker, whose contacts have no force
                for finding in judge(young=material.young, poisson=material.poisson):
                    linear = " (k_s/k_n in YADE's linear laws, not here)" if material.poisson > 0.5 else ""
                    raise EngineStopped(f"material {material.label!r}: {finding.text}{linear}")
        for contact, tag in zip(contacts, self.attachment.rows_of(contacts)["tag"], strict=True):
            if tag > 0 or contact.iterMadeReal >= O.iter - 1 or contact.geom.penetrationDepth <= 0:
                continue  # made by another engine just now, or about to end
            raise EngineStopped(
                f"contact {contact.id1}+{contact.id2} was not computed by the law {self.label!r}: another functor computes it, "
                "since YADE keeps the functor of a contact from its first step. O.interactions.clear() lets all contacts begin "
                "again, but erases their history (shear forces, plastic overlaps)"
            )

    def _judge_densities(self, bodies):
        """Warn once per material of a sphere whose mass is not that of a grain; contacts do not use it, the motion does."""
        for body in bodies:
            if type(body.shape) is not yade.Sphere or not body.dynamic or body.isClumpMember or not body.shape.radius > 0.0:
                continue
            density = body.state.mass / (4.0 / 3.0 * math.pi * body.shape.radius**3)
            for finding in judge(density=density):
                self._warn_once(("density", body.material.label), f"body {body.id}, {body.material.label!r}: {finding.text}")

    def judge_unlisted(self, bodies):
        """Raise unless two bodies, of whose materials at least one has no surface, are meant to be smooth."""
        if bodies is None or self.context["may_be_unlisted"]:
            return
        labels = {body.material.label for body in O.bodies if body.material is not None} | {one.label for one in O.materials}
        missing = [label for label in self.pairs.surfaces if label not in labels]  # others than the bodies' may come later
        if not self.pairs.surfaces or missing:
            from demlaws.yade.reports import unlisted_text

            raise EngineStopped(unlisted_text(self, bodies, missing))
        self.context["may_be_unlisted"] = 1

    def warn_of_shapes(self):
        """Warn once where a shape that is neither sphere nor flat has the body's R without a choice."""
        if self.context.take("unknown_shape"):
            from demlaws.yade.reports import body_radius_text

            contact = O.interactions[self.context.bodies("unknown_shape")]
            text = body_radius_text(contact, float(self.attachment.rows_of([contact])["radius"][0]))
            warn(f"law {self.label!r}: {text}", ShapeWarning)

    def warn_of_joints(self):
        """Warn once where two contacts have the same physics."""
        if self.context.take("shared"):
            from demlaws.yade.reports import joint_text

            warn(f"law {self.label!r}: {joint_text(*self.context.bodies('shared'))}", ShapeWarning)

    def refuse_changes(self):
        """Raise where something else has changed the coefficients of a contact."""
        if self.context["changed"]:
            from demlaws.yade.reports import changed_text

            self.context["changed"] = layout.UNSEEN
            raise EngineStopped(f"law {self.label!r}: {changed_text(*self.context.bodies('changed'))}")

    def warn_of_deep(self, rows):
        """Warn of the contacts beyond SMALL_OVERLAP of their R among rows of `layout.CONTACT`."""
        rows = rows[rows["modulus"] > 0.0]
        if np.any(rows["overlap"] > SMALL_OVERLAP * rows["radius"]):
            from demlaws.yade.reports import deep_text

            warn(f"law {self.label!r}: {deep_text(rows)}", LargeOverlap)

    def check_bodies(self, thoroughly=False):
        """Raise if a body without contacts has a velocity (thoroughly: or a position, a radius) that is not a finite number."""
        if not thoroughly and math.isfinite(yade.utils.kineticEnergy()):
            return
        for body in O.bodies:
            text = radius_fault(body)
            if text is not None:
                raise EngineStopped(text)
            place, velocity = body.state.pos, body.state.vel
            if not all(map(math.isfinite, (*place, *velocity))):
                from demlaws.yade.reports import remedy_of_motion

                raise EngineStopped(
                    f"body {body.id} is at {tuple(place)} m with velocity {tuple(velocity)} m/s, which is not finite: "
                    + remedy_of_motion([body.id])
                )

    def check_functor(self, functor):
        """Raise if the functor has settings that do not go together with a law."""
        if functor.includeAdhesion:
            raise DemlawsError("includeAdhesion=True cannot be used with a demlaws law: it changes the force")

    def raise_fault(self):
        """Raise the last fault of native code: a contact that the law does not serve."""
        fault = self.context.take_fault()
        if fault is not None:
            from demlaws.yade.reports import fault_text  # loaded only for a run that stops

            kind, *bodies, value = fault
            raise EngineStopped(f"contact {bodies[0]}+{bodies[1]}{fault_text(self, kind, bodies, value)}")

    def roughness_text(self, first, second, radius):
        """Finding of `judge` on the roughness of a pair of materials' labels, with that of each surface; None: nothing."""
        surfaces = [self.pairs.surfaces.get(label, self.pairs.everywhere) for label in (first, second)]
        each = " and ".join("0 m" if surface is None else f"{surface.roughness:g} m" for surface in surfaces)
        findings = judge(radius=radius, roughness=self.pairs.roughnesses[self.pairs.number(first, second)])
        return f"{findings[0].text} (combined of Sq = {each}; R is that of the contact)" if findings else None

    # --- validity

    def judge_validity(self):
        """Warn once per scene and pair of surfaces of each limit of the law that contacts are beyond, and of roughness."""
        for stone in O.materials:
            angle = getattr(stone, "frictionAngle", 0.0)
            if not 0.0 <= angle < 0.5 * math.pi:
                self._warn_once(
                    ("friction", stone.label),
                    f"material {stone.label!r} has frictionAngle = {angle:g} rad, a friction of {math.tan(angle):.3g}: "
                    "give an angle from 0 to π/2 in radians",
                )
        if any(key not in self._messages for key, _ in self._excesses(self.attachment.live())):
            contacts = real_contacts()  # rows of contacts that were erased have not been looked for yet
            for key, text in self._excesses(self.attachment.rows_of(contacts), contacts):
                self._warn_once(key, text)

    def _excesses(self, rows, contacts=None):
        """(key, message) of each limit that contacts are beyond; without the contacts of the rows the messages are None."""
        places = np.flatnonzero((rows["tag"] > 0.0) & (rows["modulus"] > 0.0) & (rows["overlap"] > 0.0))
        rows = rows[places]
        force = self.pairs.evaluate(rows)[0]["force"]
        for number in np.unique(rows["tag"]).astype(int) - 1:
            mine = np.flatnonzero((rows["tag"] == number + 1) & (force > 0.0))
            if len(mine):
                of_pair = None if contacts is None else [contacts[place] for place in places[mine]]
                yield from self._excesses_of_pair(number, rows[mine], force[mine], of_pair)

    def _excesses_of_pair(self, number, rows, force, contacts):
        if self.pairs.roughnesses[number] > LARGE_ROUGHNESS * np.min(rows["radius"]):
            smallest = int(np.argmin(rows["radius"]))
            labels = contacts and self._labels(contacts[smallest])
            yield (number, "roughness"), labels and self.roughness_text(*labels, float(rows["radius"][smallest]))
        if np.max(rows["radius"]) > LARGE_RADIUS:
            yield "radius", judge(radius=float(np.max(rows["radius"])))[0].text
        for reason, entries in self._beyond_limits(number, rows, force).items():
            count = sum(int(np.sum(excess > 1.0)) for _, excess, _ in entries)
            if count:
                group, excess, limit = max(entries, key=lambda entry: entry[1].max())
                worst = group[int(np.argmax(excess))]
                where = "above" if force[worst] > limit.maximum_force else "below"
                bound = limit.maximum_force if where == "above" else limit.minimum_force
                text = contacts and (
                    f"{count} of {len(rows)} contacts are {where} the range of {self.pairs.name}: {reason}. Worst: "
                    f"{contacts[worst].id1}+{contacts[worst].id2}, {force[worst]:.3g} N, {where} {bound:.3g} N, "
                    f"R = {rows['radius'][worst]:.3g} m"
                )
                yield (number, reason), text

    def _beyond_limits(self, number, rows, force):
        """Reason of a limit → (rows of one size, their forces over the limit, `Limit`)."""
        beyond = {}
        # contacts of one size to a percent have the limits of one of them
        sizes = np.round(100.0 * np.log(rows["radius"])) + 1j * np.round(100.0 * np.log(rows["modulus"]))
        for size in np.unique(sizes):
            group = np.flatnonzero(sizes == size)
            one = rows[group[0]]
            key = number, complex(size)
            if key not in self._limits:
                self._limits[key] = self.pairs.limits(number, float(one["radius"]), float(one["modulus"]))
            for limit in self._limits[key]:
                excess = np.maximum(force[group] / limit.maximum_force, limit.minimum_force / force[group])
                beyond.setdefault(limit.reason, []).append((group, excess, limit))
        return beyond

    @staticmethod
    def _labels(contact):
        return [O.bodies[number].material.label for number in (contact.id1, contact.id2)]

    def _warn_once(self, key, text):
        if text is not None and key not in self._messages:
            self._messages.add(key)
            warn(f"law {self.label!r}: {text}")

    # --- the time step

    def bound_steppers(self, engines):
        """Keep maxDt of GlobalStiffnessTimeSteppers at a bound that is stable for stiff contacts; returns a warning or None.

        They use the present stiffness of contacts, and a young contact is soft until the step in which it is not. The bound
        follows the bodies. A maxDt of the user's, and a stepper with density scaling, are left as they are. YADE computes a
        P-wave step from spheres; before there are any, nothing is changed, and the guard looks again.
        """
        steppers = [e for e in engines if isinstance(e, yade.GlobalStiffnessTimeStepper) and not e.dead and e.active]
        if not steppers:
            return None
        if not any(isinstance(body.shape, yade.Sphere) for body in O.bodies):
            return self._without_wave(steppers)
        wave = yade.utils.PWaveTimeStep()
        message = None
        for stepper in steppers if 0.0 < wave < np.inf else ():
            bound = REACH * wave * min(stepper.timestepSafetyCoefficient, 1.0)
            former, scaled = stepper.maxDt, stepper.densityScaling
            ours = not scaled and (former == self.bound or former > NO_BOUND)
            if ours and former != bound:
                stepper.maxDt = self.bound = bound
            unbounded = former > NO_BOUND if ours else min(former, stepper.targetDt if scaled else former) > REACH * wave
            if unbounded and (self.share is None or not ours) and not self.warned:
                self.warned = True
                from demlaws.yade.reports import stepper_text

                message = stepper_text(self.label, stepper, former, bound, REACH)
        return message

    def _without_wave(self, steppers):
        """Warning about steppers that have no bound, in a scene with contacts of other shapes than spheres; or None."""
        if self.warned or O.interactions.countReal() == 0 or all(stepper.maxDt < NO_BOUND for stepper in steppers):
            return None
        self.warned = True
        from demlaws.yade.reports import no_wave_text

        return no_wave_text(self.label)
