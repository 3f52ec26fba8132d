"""One law at work in one scene: its account of energy, its state for users, its checks."""

import math
import threading

import numpy as np
import yade.utils

from demlaws.errors import DemlawsError, EngineStopped, LargeOverlap, ShapeWarning, TimeStepWarning, ValidityWarning, warn
from demlaws.units import LARGE_RADIUS, LARGE_ROUGHNESS, SMALL_OVERLAP, judge, large_overlap
from demlaws.yade import layout, native, reports
from demlaws.yade.material_options import difference
from demlaws.yade.omega import (
    FULL_CHECK_STEPS,
    O,
    get_engines,
    invalid_radius,
    is_our_contact,
    law_functors,
    mobilities,
    real_contacts,
)

LARGEST_STEP_RATIO = 4.0
"""Longest step over the P-wave step r √(ρ/E) that is stable for a free sphere with four contacts per side at contact radii up
to 0.3 R: 2 √(m/4K) with m = 4/3 π ρ r³, K = 2 E* a, R = r/2, E* = E/2 is 5.3 r √(ρ/E); less, for safety [our derivation]"""


NO_BOUND = 1e300
"""maxDt [s] of a time stepper that has none is larger."""


NATIVE_CONICAL_LAW = "Law2_ScGeom_MindlinPhysCDM_HertzMindlinCDM"


ACCOUNT = ("banked", "open", "banked_shear", "banked_viscous")
"""Sums of native code over ended contacts."""


class Binding:
    """A law at work under a functor's label, in the scene whose token is `scene` (None: in none).

    share: the part of the critical step for a time stepper, from `engines(law, timestep=…)`; bound: the maxDt [s] that the law
    has given a stepper; seen: losses [J] of plasticity, of shear and of viscous damping when `O.energy` was last read.
    """

    def __init__(self, label, pairs):
        self.label, self.pairs = label, pairs
        self.share = self.bound = None
        self.seen = {}
        self.attachment = native.Attachment(pairs)
        self.context = self.attachment.context
        self.context["may_be_unlisted"] = pairs.needs_no_judgement
        self.scene, self.guards = None, 0
        self._messages = set()

    @property
    def account(self):
        """Dissipation [J] of ended contacts, number of contacts that the law has seen begin and not end, energies [J] of shear
        and of viscous damping that ended contacts have lost."""
        return {name: float(self.context[name]) for name in ACCOUNT}

    def clear(self, account=()):
        """Begin with this account, without contacts."""
        self.attachment.rows.release()
        for name in ACCOUNT:
            self.context[name] = dict(account).get(name, 0.0)

    def enter(self, scene, account=()):
        """Begin to act in a scene with this account; contacts of another scene end or stop."""
        self.clear(account)
        self.seen = {}
        self.scene, self.guards = scene, 0
        self._messages = set()
        self.context.clear_faults()
        for name in ("judged_radii", "judged_moduli"):
            self.pairs.records[name] = 0.0

    def rows(self, contacts):
        """The contacts as an array of `layout.contact_dtype`; tag 0 where the law has not seen the contact."""
        rows = self.attachment.rows_of(contacts)
        for row, contact in zip(rows, contacts, strict=True):
            overlap = contact.geom.penetrationDepth  # a loaded scene does not know it before its first step
            if not math.isnan(overlap):
                row["overlap"] = overlap
        return rows

    # --- for users

    @staticmethod
    def _prepare_reading():
        """Contacts are read between steps, or by a PyRunner, in the simulation's own thread."""
        in_simulation = threading.current_thread().name.startswith("Dummy")  # Python's name for a thread made by C++
        if O.running and not in_simulation:
            raise DemlawsError("contacts change while the simulation runs: call O.pause() first, or read them in a PyRunner")
        _ = O.engines  # a scene that was loaded and has not made a step gets its laws

    def totals(self):
        """`Totals` of the current scene, ended contacts included."""
        from demlaws.yade.contacts import Totals

        self._prepare_reading()
        self.raise_fault()
        self.judge_validity()
        rows = self.rows(real_contacts())
        rows = rows[rows["tag"] > 0]
        energies, ended = self.pairs.evaluate(rows)[0], self.account
        return Totals(
            stored=float(energies["stored"].sum()),
            dissipated=float(energies["dissipated"].sum()) + ended["banked"],
            shear_stored=float(rows["held"].sum()),
            shear_dissipated=float(rows["lost"].sum()) + ended["banked_shear"],
            viscous=float(rows["viscous"].sum()) + ended["banked_viscous"],
            unaccounted=max(int(ended["open"]) - len(rows), 0),
        )

    def account_for(self, tracker):
        """Write the energies [J] to YADE's EnergyTracker, adding what was lost since the last call; None: it does not track."""
        totals = self.totals()
        losses = {"Plastic": totals.dissipated, "ShearLost": totals.shear_dissipated, "Viscous": totals.viscous}
        if tracker is not None:
            tracker[self.label + "Elastic"] = totals.stored
            tracker[self.label + "ShearElastic"] = totals.shear_stored
            tracked = dict(tracker.items())
            for name, loss in losses.items():
                tracker[self.label + name] = tracked.get(self.label + name, 0.0) + loss - self.seen.get(name, 0.0)
        self.seen = losses

    def contacts(self, interactions=None, strength=None):
        """`Contacts`: all real contacts of the scene (or of the given ones); strength: of the column `above` [Pa]."""
        from demlaws.yade.contacts import state_of

        self._prepare_reading()
        selection = [interactions] if isinstance(interactions, yade.Interaction) else interactions
        contacts = real_contacts() if selection is None else [one for one in selection if is_our_contact(one)]
        return state_of(self.pairs, contacts, self.rows(contacts), strength)

    # --- checks

    def watch(self, functor):
        """Work of the guard: raise the faults of native code, make room, check everything now and then."""
        self.guards += 1
        if O.dt == 0.0:
            self._warn_once("step", "O.dt = 0 s: bodies do not move, and viscous damping has no velocity; set O.dt")
        elif not O.dt > 0.0:
            raise EngineStopped(f"O.dt = {O.dt:g} s: give a positive time step")
        self.check_functor(functor)
        self._verify_options(O.materials)
        self.report_notes()
        self.pairs.radii.refresh(self.context)
        self.attachment.collect(real_contacts)
        thoroughly = self.guards in FULL_CHECK_STEPS or self.guards % 1000 == 0
        if thoroughly:
            self.verify()
        if thoroughly or self.guards % 10 == 0:
            self.judge_validity()
        self.check_bodies(thoroughly)

    def verify(self):
        """Raise unless every contact of the law's class has this law's mark, and materials are admissible.

        kn and ks are not compared: engines of YADE may scale them (TriaxialStressController with internalCompaction).
        """
        contacts = real_contacts()
        touching = [O.bodies[number] for number in {n for contact in contacts for n in (contact.id1, contact.id2)}]
        self._judge_densities(touching)
        self._verify_options(body.material for body in touching)
        for material in {body.material.id: body.material for body in touching}.values():
            if material.young != 0.0:  # 0: a marker, whose contacts have no force
                for finding in judge(young=material.young, poisson=material.poisson):
                    linear = " (k_s/k_n in YADE's linear laws, not here)" if material.poisson > 0.5 else ""
                    raise EngineStopped(f"material {material.label!r}: {finding.text}{linear}")
        if any(getattr(body.material, "c1", 0.0) for body in touching):  # FrictMatCDM
            self._verify_friction(contacts)
        conical_law = NATIVE_CONICAL_LAW in {type(functor).__name__ for _, functor in law_functors(get_engines())}
        for contact, tag in zip(contacts, self.attachment.rows_of(contacts)["tag"], strict=True):
            if conical_law and hasattr(contact.phys, "sigmaMax"):
                continue  # it serves these contacts
            if tag > 0 or contact.iterMadeReal >= O.iter - 1 or contact.geom.penetrationDepth <= 0:
                continue  # made by another engine just now, or about to end
            raise EngineStopped(
                f"contact {contact.id1}+{contact.id2} was not computed by the law {self.label!r}: another functor computes it, "
                "since YADE keeps the functor of a contact from its first step. O.interactions.clear() lets all contacts begin "
                "again, but erases their history (shear forces, plastic overlaps)"
            )

    def _verify_options(self, materials):
        """Raise where the law has not taken over what these materials have now."""
        for text in filter(None, (difference(self.pairs.of_materials, material) for material in materials)):
            raise EngineStopped(text)

    def _verify_friction(self, contacts):
        """Raise where two FrictMatCDM have a friction by pressure that neither their contact's physics nor the law has."""
        for contact in contacts:
            stones = [O.bodies[number].material for number in (contact.id1, contact.id2)]
            if hasattr(contact.phys, "mu0") or not all(getattr(stone, "c1", 0.0) for stone in stones):
                continue
            if math.isnan(
                self.pairs.friction.of(*(stone.label if stone.label in self.pairs.surfaces else "" for stone in stones))[0]
            ):
                raise EngineStopped(
                    f"material {stones[0].label!r} has c1 = {stones[0].c1:g}: a friction that depends on the pressure, which "
                    f"contact {contact.id1}+{contact.id2} of {type(contact.phys).__name__} does not have; use "
                    "Ip2_FrictMatCDM_FrictMatCDM_MindlinPhysCDM, or give the law friction=demlaws.PressureFriction(…), or set "
                    "c1 = 0"
                )

    def _judge_densities(self, bodies):
        """Warn once per material of a sphere whose mass is not that of a grain; contacts do not use it, the motion does."""
        for body in bodies:
            if type(body.shape) is not yade.Sphere or not body.dynamic or body.isClumpMember or not body.shape.radius > 0.0:
                continue
            density = body.state.mass / (4.0 / 3.0 * math.pi * body.shape.radius**3)
            for finding in judge(density=density):
                self._warn_once(("density", body.material.label), f"body {body.id}, {body.material.label!r}: {finding.text}")

    def report_notes(self):
        """Raise or warn of what native code has noted of contacts."""
        self.raise_fault()
        unlisted = self.context.pop_fault(layout.UNLISTED)
        if unlisted:
            self.judge_unlisted(unlisted)
        strange = self.context.pop_fault(layout.UNKNOWN_SHAPE, once=True)
        if strange:
            names = " on ".join(type(O.bodies[number].shape).__name__ for number in strange)
            warn(
                f"law {self.label!r}: contact {strange[0]}+{strange[1]} ({names}) has R = "
                f"{float(self.context['values'][layout.UNKNOWN_SHAPE]):.4g} m from the distances between the bodies' centres "
                "and the contact, which is not a radius of curvature; force, yield and the effect of roughness follow from it. "
                'Choose radius="curvature" (level sets), the measured edge radius in m, or radius="body"',
                ShapeWarning,
            )
        joint = self.context.pop_fault(layout.SHARED, once=True)
        if joint:
            warn(
                f"law {self.label!r}: contact {joint[0]}+{joint[1]} has the physics of another one: a sphere passes a joint of "
                "GridConnections or ChainedCylinders. YADE applies Mindlin's force, native or ours, in both contacts: the "
                "sphere gets it twice until it leaves the chain, with CylScGeom6D even longer",
                ShapeWarning,
            )
        if self.context.pop_fault(layout.DEEP, once=True):
            rows = self.rows(real_contacts())
            rows = rows[(rows["tag"] > 0) & (rows["overlap"] > SMALL_OVERLAP * rows["radius"]) & (rows["modulus"] > 0.0)]
            if len(rows):
                deepest = rows[np.argmax(rows["overlap"] / rows["radius"])]
                overlap, radius = float(deepest["overlap"]), float(deepest["radius"])
                text = large_overlap(overlap, radius, len(rows), O.interactions.countReal())
                warn(f"law {self.label!r}: {text}", LargeOverlap)

    def raise_fault(self):
        """Raise a fault of native code: a contact that the law does not serve. All faults are cleared."""
        if self.context.pop_fault(layout.UNJUDGED):
            self._judge_laws()
        seen = np.flatnonzero(self.context["seen"][: layout.FAULTS])
        if len(seen):
            kind = int(seen[0])
            first, second = self.context.pop_fault(kind)
            self.context["seen"][: layout.FAULTS] = layout.UNSEEN
            text = reports.fault_text(self, kind, (first, second), float(self.context["values"][kind]))
            raise EngineStopped(f"contact {first}+{second}{text}")

    def judge_unlisted(self, bodies):
        """Raise unless two bodies, of whose materials at least one has no surface, are meant to be smooth."""
        labels = {body.material.label for body in O.bodies if body.material is not None} | {one.label for one in O.materials}
        missing = [label for label in self.pairs.surfaces if label not in labels]  # others than the bodies' may come later
        if not self.pairs.surfaces or missing:
            raise EngineStopped(reports.unlisted_text(self, bodies, missing))
        self.context["may_be_unlisted"] = 1

    def check_bodies(self, thoroughly=False):
        """Raise if a body without contacts has a velocity (thoroughly: or a position, a radius) that is not a finite number."""
        if not thoroughly and math.isfinite(yade.utils.kineticEnergy()):
            return
        for body in O.bodies:
            text = invalid_radius(body)
            if text is not None:
                raise EngineStopped(text)
            place, velocity = body.state.pos, body.state.vel
            if not all(map(math.isfinite, (*place, *velocity))):
                raise EngineStopped(
                    f"body {body.id} is at {tuple(place)} m with velocity {tuple(velocity)} m/s, which is not finite: "
                    + reports.remedy_of_motion([body.id])
                )

    def check_functor(self, functor):
        """Raise if the functor has settings that do not go together with a law."""
        if functor.includeAdhesion:
            raise DemlawsError("includeAdhesion=True cannot be used with a demlaws law: it changes the force")
        for name, default in native.find_layout().unknown.items():
            if getattr(functor, name) != default:
                raise DemlawsError(f"{name}={not default} cannot be used with a demlaws law, which does not know this option")
        for name in native.OPTIONS if native.find_layout().own_slip else ():
            if getattr(functor, name):
                raise DemlawsError(f"{name}=True cannot be used with a demlaws law in this YADE: {reports.OWN_SLIP}")

    def roughness_text(self, first, second, radius):
        """Finding of `judge` on the roughness of a pair of materials' labels, with that of each surface; None: nothing."""
        surfaces = [self.pairs.surfaces.get(label, self.pairs.everywhere) for label in (first, second)]
        each = " and ".join("0 m" if surface is None else f"{surface.roughness:g} m" for surface in surfaces)
        findings = judge(radius=radius, roughness=self.pairs.roughnesses[self.pairs.number(first, second)])
        return f"{findings[0].text} (combined of Sq = {each}; R is that of the contact)" if findings else None

    # --- validity

    def _judge_laws(self):
        """Raise where a law does not fit the R and E* of contacts of its pair, which were not known when it was made."""
        contacts = real_contacts()
        rows = self.attachment.rows_of(contacts)
        served = (rows["tag"] > 0.0) & (rows["modulus"] > 0.0) & (rows["ratio"] > 0.0)
        for tag in np.unique(rows["tag"][served]):
            places = np.flatnonzero(served & (rows["tag"] == tag))
            radii, moduli = rows["radius"][places], rows["modulus"][places]
            for place in {int(places[find(values)]) for values in (radii, moduli) for find in (np.argmin, np.argmax)}:
                self._judge_law(int(tag) - 1, contacts[place], float(rows["radius"][place]), float(rows["modulus"][place]))
            record = self.pairs.records[int(tag) - 1]
            for name, values, margin in (("judged_radii", radii, 0.1), ("judged_moduli", moduli, 1e-6)):
                known = record[name][record[name] > 0.0]
                ends = np.append(known, [values.min() * (1.0 - margin), values.max() * (1.0 + margin)])
                record[name] = ends.min(), ends.max()
        self._judge_constant_step(contacts, rows, served)

    def _judge_law(self, number, contact, radius, modulus):
        labels = " on ".join(repr(O.bodies[body].material.label) for body in (contact.id1, contact.id2))
        of = f"contact {contact.id1}+{contact.id2} ({labels}), R = {radius:.4g} m, E* = {modulus:.4g} Pa"
        try:
            text = self.pairs.doubt(number, radius, modulus)
        except DemlawsError as error:
            self.context["seen"][: layout.FAULTS] = layout.UNSEEN
            raise EngineStopped(f"{of}: {error}") from None
        self._warn_once((number, "hardness"), text and f"{of}: {text}")

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
        contacts = real_contacts()
        rows = self.attachment.rows_of(contacts)
        answer, _ = self.pairs.evaluate(rows)
        force, pressure = answer["force"], answer["pressure"]
        pressed = (rows["tag"] > 0.0) & (rows["modulus"] > 0.0) & (rows["overlap"] > 0.0) & (force > 0.0)
        for tag in np.unique(rows["tag"][pressed]):
            places = np.flatnonzero(pressed & (rows["tag"] == tag))
            of_pair = [contacts[place] for place in places], rows[places], force[places]
            self._judge_pair(int(tag) - 1, *of_pair, float(pressure[places].max()))

    def _judge_pair(self, number, contacts, rows, force, pressure):
        """Warn once of the limits that contacts of one pair of surfaces are beyond."""
        smallest, largest = int(np.argmin(rows["radius"])), float(np.max(rows["radius"]))
        if self.pairs.roughnesses[number] > LARGE_ROUGHNESS * rows["radius"][smallest]:
            labels = [O.bodies[body].material.label for body in (contacts[smallest].id1, contacts[smallest].id2)]
            self._warn_once((number, "roughness"), self.roughness_text(*labels, float(rows["radius"][smallest])))
        hardness = self.pairs.combined[number][0].hardness
        if self.context["by_pressure"] and hardness is not None:
            from demlaws.shear import _beyond_hardness

            self._warn_once((number, "pressure"), _beyond_hardness(pressure, hardness))
        if largest > LARGE_RADIUS:
            self._warn_once("radius", judge(radius=largest)[0].text)
        for reason, entries in self._beyond_limits(number, rows, force).items():
            count = sum(int(np.sum(excess > 1.0)) for _, excess, _ in entries)
            if count:
                group, excess, limit = max(entries, key=lambda entry: entry[1].max())
                worst = group[int(np.argmax(excess))]
                where = "above" if force[worst] > limit.maximum_force else "below"
                bound = limit.maximum_force if where == "above" else limit.minimum_force
                text = (
                    f"{count} of {len(rows)} contacts are {where} the range of {self.pairs.name}: {reason}. Worst: "
                    f"{contacts[worst].id1}+{contacts[worst].id2}, {force[worst]:.3g} N, {where} {bound:.3g} N, "
                    f"R = {rows['radius'][worst]:.3g} m"
                )
                self._warn_once((number, reason), text)

    def _beyond_limits(self, number, rows, force):
        """Reason of a limit → (rows of one size, their forces over the limit, `Limit`)."""
        beyond = {}
        # contacts of one size to a percent have the limits of one of them
        sizes = np.round(100.0 * np.log(rows["radius"])) + 1j * np.round(100.0 * np.log(rows["modulus"]))
        for size in np.unique(sizes):
            group = np.flatnonzero(sizes == size)
            one = rows[group[0]]
            for limit in self.pairs.limits(number, float(one["radius"]), float(one["modulus"])):
                excess = np.maximum(force[group] / limit.maximum_force, limit.minimum_force / force[group])
                beyond.setdefault(limit.reason, []).append((group, excess, limit))
        return beyond

    def _warn_once(self, key, text, category=ValidityWarning):
        if text is not None and key not in self._messages:
            self._messages.add(key)
            warn(f"law {self.label!r}: {text}", category)

    # --- the time step

    def bound_steppers(self, engines):
        """Keep maxDt of GlobalStiffnessTimeSteppers at a bound that is stable for stiff contacts, and warn once of others.

        They use the present stiffness of contacts, and a young contact is soft until the step in which it is not. The bound
        follows the bodies. A maxDt of the user's, and a stepper with density scaling, are left as they are. YADE computes a
        P-wave step from spheres; before there are any, nothing is changed, and the guard looks again.
        """
        steppers = [e for e in engines if isinstance(e, yade.GlobalStiffnessTimeStepper) and not e.dead and e.active]
        spheres = bool(steppers) and any(isinstance(body.shape, yade.Sphere) for body in O.bodies)
        limit = LARGEST_STEP_RATIO * yade.utils.PWaveTimeStep() if spheres else math.inf
        known = 0.0 < limit < math.inf
        for stepper in steppers:
            former, scaled, bound = stepper.maxDt, stepper.densityScaling, None
            ours = not scaled and (former == self.bound or former > NO_BOUND)
            unbounded = former > NO_BOUND if ours else min(former, stepper.targetDt if scaled else former) > limit
            if known:
                bound = limit * min(stepper.timestepSafetyCoefficient, 1.0)
                if ours:
                    stepper.maxDt = self.bound = bound
            chosen = ours and known and self.share is not None
            if unbounded and not chosen and (known or O.interactions.countReal()):
                self._warn_once("stepper", reports.stepper_text(stepper, bound, LARGEST_STEP_RATIO), TimeStepWarning)

    def _judge_constant_step(self, contacts, rows, served):
        """Warn once of a constant O.dt beyond the longest stable step of two bodies that touch."""
        engines = [engine for engine in get_engines() if not engine.dead]
        moves = any(isinstance(engine, yade.NewtonIntegrator) for engine in engines)
        if not moves or any(isinstance(engine, yade.TimeStepper) and engine.active for engine in engines):
            return
        stiffness = self.pairs.evaluate(rows)[0]["tangent"]
        worst, limit = None, O.dt
        for place in np.flatnonzero(served & (stiffness > 0.0)).tolist():
            mobility = sum(mobilities(contacts[place]))
            if stiffness[place] * mobility * limit**2 > 4.0:
                worst, limit = place, 2.0 / math.sqrt(stiffness[place] * mobility)
        if worst is not None:
            from demlaws.timestep import STEP_SAFETY, packing_estimate

            advised = STEP_SAFETY * packing_estimate(float(stiffness[worst]), 1.0 / max(mobilities(contacts[worst])))
            self._warn_once(
                "long step",
                f"O.dt = {O.dt:g} s is {O.dt / limit:.3g} times the longest stable step of contact {contacts[worst].id1}+"
                f"{contacts[worst].id2} alone at its overlap of {rows['overlap'][worst]:.3g} m, {limit:.3g} s: the bodies gain "
                f"energy and fly apart. In a packing at this overlap O.dt = {advised:.2g} s is advised, less at larger loads "
                "(demlaws.timestep)",
                TimeStepWarning,
            )
