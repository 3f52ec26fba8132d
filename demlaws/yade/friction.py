"""Coefficient of friction of a contact: YADE's constant one, or one that depends on the mean pressure. `apply` is compiled code
in the contact step, before Coulomb's limit is computed; `keep_radius` writes what else scripts read of a MindlinPhysCDM."""

import math
from typing import NamedTuple

from demlaws.core.dispatch import bind, generic
from demlaws.core.numba_compat import kernel
from demlaws.core.shear import friction_at, mean_pressure
from demlaws.core.unloading import Thornton
from demlaws.errors import DemlawsError, did_you_mean
from demlaws.yade import objects
from demlaws.yade.records import type_of, view

OF_MATERIALS = "materials"
"""The choice of the c1 and c2 of FrictMatCDM."""


class Constant(NamedTuple):
    """MindlinPhys.tangensOfFrictionAngle, as the functor of physics or a script has set it."""


class ByPressure(NamedTuple):
    """μ0 + c1/(1 + c2 p) of the pair of surfaces; where it has none, that of a MindlinPhysCDM, else constant."""


@generic(
    lambda *_: lambda friction, context, phys, phys_address, pair, row, rule, shape, p, overlap, force, stiffness, state: None
)
def apply(friction, context, phys, phys_address, pair, row, rule, shape, p, overlap, force, stiffness, state):
    """Write the coefficient of friction of this step to the contact's physics; the last four are what `step` has returned."""


@kernel
def _by_pressure(friction, context, phys, phys_address, pair, row, rule, shape, p, overlap, force, stiffness, state):
    if row.modulus == 0.0:
        return
    mu0, c1, c2 = pair.mu0, pair.c1, pair.c2
    if mu0 != mu0:
        if type_of(phys.vtable) != context.conical:
            return
        conical = view(phys_address, objects.MindlinPhysCDM)
        mu0, c1, c2 = conical.mu0, conical.c1, conical.c2
    pressure = mean_pressure(rule, shape, p, row.modulus, overlap, force, stiffness, state)
    phys.tangensOfFrictionAngle = friction_at(mu0, c1, c2, pressure)


bind(ByPressure, apply=_by_pressure)


@generic(lambda *_: lambda rule, phys_address, row, overlap, state: None)
def keep_radius(rule, phys_address, row, overlap, state):
    """Write R and isYielding of a MindlinPhysCDM, as the native law has them; `state` is of this step."""


@kernel
def _radius_of_thornton(rule, phys_address, row, overlap, state):
    conical = view(phys_address, objects.MindlinPhysCDM)
    conical.R = row.radius * state[2]
    conical.isYielding = overlap >= state[0] and state[2] > 1.0


bind(Thornton, keep_radius=_radius_of_thornton)


class Choice:
    """What a user gave as `friction`: entries (one label, or two of them, sorted → PressureFriction; "": the materials that are
    not listed), of_materials: whether FrictMatCDM's is used.

    labels: of the surfaces, "" first; everything: label by which a dict names the materials that are not listed.
    """

    def __init__(self, friction, labels, everything):
        self.entries = {}
        self.of_materials = isinstance(friction, str) and friction == OF_MATERIALS
        if friction is None or self.of_materials:
            return
        from demlaws.shear import PressureFriction

        if isinstance(friction, PressureFriction):
            self.entries = {(label,): friction for label in labels}
        elif isinstance(friction, dict):
            for key, value in friction.items():
                names = tuple("" if name == everything else name for name in (key if isinstance(key, tuple) else (key,)))
                unknown = [name for name in names if name not in labels]
                if unknown or not 1 <= len(names) <= 2:
                    known = ", ".join(map(repr, [*labels[1:], everything]))
                    more = did_you_mean(unknown[0], labels) if unknown and isinstance(unknown[0], str) else ""
                    raise DemlawsError(
                        f"friction: {key!r} is not a label, or a pair of labels, of surfaces={{…}}{more} Labels: {known}"
                    )
                if not isinstance(value, PressureFriction):
                    raise DemlawsError(f"friction[{key!r}] must be a demlaws.PressureFriction, got {value!r:.60}")
                self.entries[tuple(sorted(names))] = value
        else:
            raise DemlawsError(
                "friction must be a demlaws.PressureFriction, a dict from labels or pairs of labels to them, or "
                f"{OF_MATERIALS!r}, got {friction!r:.60}; a constant one is the materials' frictionAngle"
            )

    @property
    def tag(self):
        """`Constant` or `ByPressure`."""
        return ByPressure() if self.entries or self.of_materials else Constant()

    def of(self, first, second):
        """μ0, c1, c2 [1/Pa] of two labels; NaN where the contact has its own."""
        found = self.entries.get(tuple(sorted((first, second))))
        if found is None and (first,) in self.entries and (second,) in self.entries:
            found = self.entries[first,].combined(self.entries[second,])
        return (math.nan, 0.0, 0.0) if found is None else (found.mu0, found.c1, found.c2)

    def content(self):
        """Plain content, from which `choice_from` makes it again."""
        pairs = [[list(labels), [value.mu0, value.c1, value.c2]] for labels, value in self.entries.items()]
        return {"of_materials": self.of_materials, "pairs": pairs}


def choice_from(content, everything):
    """The argument `friction` that has this `Choice.content`."""
    if content is None or not content["pairs"]:
        return OF_MATERIALS if content is not None and content["of_materials"] else None
    from demlaws.shear import PressureFriction

    named = [tuple(label or everything for label in labels) for labels, _ in content["pairs"]]
    return {
        labels if len(labels) == 2 else labels[0]: PressureFriction(*values)
        for labels, (_, values) in zip(named, content["pairs"], strict=True)
    }
