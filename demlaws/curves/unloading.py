"""How contacts unload: a rule, the curve that it follows, and the check that the pair of curves is passive."""

import math
from typing import Any, NamedTuple

import numpy as np

from demlaws.contact import PER_CONTACT, Contact
from demlaws.core.loops import (
    FINITE,
    UNBOUNDED,
    batch_loop,
    bind_params,
    energies_loop,
    force_loop,
    inverse_loop,
    loading_part,
    params_at,
)
from demlaws.core.table_types import TableParams
from demlaws.core.unloading import GIVEN, RULES, JoinedParams, JoinedShape, Rule
from demlaws.curves.closed import FormulaCurve
from demlaws.errors import DemlawsError, NotPassive
from demlaws.laws import HERTZ
from demlaws.laws.registry import find, is_user_defined


class Unloading(NamedTuple):
    """A rule with all that it reads beside the curve of first loading."""

    rule: Rule
    curve: Any = None  # of rule "table": the curve to follow
    contact: Contact | None = None  # of that curve
    rule_parameters: Any = None  # of a rule of the law's own where the curve is a table: the Shape that the rule reads


UNKNOWN_AREA = (
    "{} does not contain the contact area of the law, which friction by pressure needs: make a table of a former version "
    "again, take the unloading rule of the law's paper, or in Python and YADE the law without a table"
)
ELASTIC = Unloading(RULES["elastic"])
_LOADED = 1e-5
"""Overlap over R from which on a contact is loaded: below it, `max_force` would leave no use of a law."""


def joined_shape(shape: Any, contact: Contact, unloading: Unloading) -> Any:
    """Shape of a curve of first loading together with what its unloading rule reads."""
    if unloading.curve is not None:
        return JoinedShape(shape, unloading.curve.unloading_shape(), *_ratios(contact, unloading.contact))
    return shape if unloading.rule_parameters is None else JoinedShape(shape, unloading.rule_parameters, 1.0, 1.0, 1.0)


class BoundLaw:
    """A curve of first loading on a contact, joined with an unloading rule: `shape` is what compiled code reads."""

    def __init__(self, contact: Contact, curve: Any, unloading: Unloading = ELASTIC):
        self.contact, self.curve, self.unloading_parts = contact, curve, unloading
        self.definition, self.options, self.name = curve.definition, curve.options, curve.definition.name
        self.shape = joined_shape(curve.shape, contact, unloading)
        self.params: Any = bind_params(self.shape, contact)
        if unloading.rule.curve == "law" and unloading.rule_parameters is None and is_user_defined(self.definition):
            from demlaws.curves.soundness import refuse_unsound_rule

            refuse_unsound_rule(
                self.name, unloading.rule, self.shape, params_at(self.params, 0), float(np.ravel(contact.radius)[0])
            )

    @property
    def knows_area(self) -> bool:
        """Whether the contact area is the law's."""
        return knows_area(self.curve, self.unloading_parts.rule)

    @property
    def unloading(self) -> str:
        """Name of the unloading rule."""
        return self.unloading_parts.rule.name


def beside_table(curve: Any, contact: Contact, unloading: Unloading) -> Unloading:
    """The unloading of a curve's table: Hertz's curve of another radius than R, with which tables scale, is a second curve."""
    radius = curve.definition.bulk_radius(contact, **curve.options)
    if unloading.rule.curve != "hertz" or radius is contact.radius:
        return unloading
    if unloading.rule is not RULES["hertz"]:
        raise DemlawsError(
            f"a table of law {curve.definition.name!r} and its bulk_radius cannot take {unloading.rule.name!r} unloading: use "
            "unloading 'hertz', or the law without a table"
        )
    blunt = contact.with_values(radius=radius)
    return Unloading(RULES[GIVEN], FormulaCurve(find(HERTZ), blunt, {}), blunt)


def _ratios(contact, other):
    """R, E* and σ of the unloading curve's contact over those of the law's, each one number for all contacts."""
    ratios = []
    for name in PER_CONTACT:
        values, others = (np.asarray(0.0 if (v := getattr(c, name)) is None else v, float) for c in (contact, other))
        with np.errstate(divide="ignore", invalid="ignore"):
            try:
                ratio = others / values
            except ValueError:
                raise DemlawsError(f"the law has {contact.size} contacts, its unloading curve {other.size}") from None
        if np.all(values == others):  # smooth contacts, too
            ratio = np.ones(1)
        low, high = float(np.nanmin(ratio)), float(np.nanmax(ratio))
        if not (math.isfinite(high) and high - low <= 1e-9 * high):
            raise DemlawsError(
                f"the {name} of the unloading curve's contact is {low:g} to {high:g} times the law's: the ratio must be "
                "the same for all contacts; make the curve for the same contact or array of contacts"
            )
        ratios.append(low if high > low else high)
    return ratios


def refuse_unless_passive(law: Any, max_force: float = math.inf) -> None:
    """Raise NotPassive unless at every load, up to `max_force` [N], K(P) is at most that of the unloading curve; for Hertz-like
    rules, Hertz's. A rule with a larger radius may also be passive where K is above Hertz's of R."""
    rule = law.unloading_parts.rule
    if rule.curve not in ("hertz", "given"):
        return
    excess, force, first = largest_stiffness_ratio(law, max_force)
    if excess > 1.0 and rule is RULES["thornton"] and _loses_work(law, max_force):
        return
    curve = law.unloading_parts.curve
    # the stiffness of a table is as exact as its certificate states
    uncertainty = 0.0 if curve is None else law.curve.certificate.stiffness_error + curve.certificate.stiffness_error
    if excess > 1.0 + 1e-9 + uncertainty:
        whose = "Hertz's" if curve is None else f"that of its unloading curve ({curve.definition.name!r})"
        ratio = f"{excess:.4g}" if excess > 1.001 else f"1 + {excess - 1.0:.1g}"
        other = law.definition.default_rule(**law.options)
        remedy, more = (other, "") if other != law.unloading else ("elastic", ", or other options of the law")
        if first > 0.0 and not law.curve.tabulated:
            more += f", or, if no contact carries more than {first:.3g} N, max_force (demlaws.law)"
        raise NotPassive(
            f"law {law.name!r} cannot take {law.unloading!r} unloading: at {force:.3g} N its stiffness is {ratio} times "
            f"{whose}, so that unloading would return more work than loading took; "
            f"use unloading {remedy!r}{more}"
        )


def knows_area(curve: Any, rule: Rule) -> bool:
    """Whether the contact area of a curve is the law's: a table may lack it, unless the rule has the numbers of it."""
    return not curve.tabulated or curve.area_known or bool(rule.keys)


def after_loading(law: BoundLaw, p: Any, overlap: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Force [N] at overlaps [m] of first loading, and the energies [J] that contacts of Params `p` store and have lost."""
    rule = law.unloading_parts.rule
    state, force = tuple(np.zeros(overlap.size) for _ in rule.state), np.empty(overlap.size)
    batch_loop(rule.tag, law.shape, p, overlap, state, UNBOUNDED, FINITE, force, np.empty(overlap.size))
    return force, *energies_loop(rule.tag, law.shape, p, overlap, state)


def _loses_work(law, max_force):
    """Whether the lost energy never falls on first loading over the range of `largest_stiffness_ratio`."""
    for index in law.contact.representatives():
        p = params_at(law.params, index)
        radius = float(np.broadcast_to(law.contact.radius, law.contact.size or 1)[index])
        force, stored, lost = after_loading(law, p, np.geomspace(1e-12, 0.1, 2000) * radius)
        rise, work = np.diff(lost), stored + lost
        if not np.all((rise >= -1e-9 * np.diff(work)) | ~(force[1:] <= max_force)):
            return False
    return True


def unloading_curve_at(law: Any, p: Any, force: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Overlap [m] and stiffness [N/m] at loads [N] of the curve along which a contact of Params `p` unloads: Hertz's or a given
    one."""
    if not isinstance(p, JoinedParams):
        overlap = np.cbrt(force / p.hertz_coefficient) ** 2
        return overlap, 1.5 * p.hertz_coefficient ** (2 / 3) * np.cbrt(force)
    overlap = inverse_loop(law.shape.unloading, p.unloading, force)
    return overlap, force_loop(law.shape.unloading, p.unloading, overlap)[1]


def largest_stiffness_ratio(law: Any, max_force: float = math.inf) -> tuple[float, float, float]:
    """Largest K(P)/K_U(P) of first loading over 1e-12 to 0.1 of the radius and up to `max_force` [N], the force [N] where it
    occurs, and one up to which it is at most 1: 0 where that is no load of a contact.

    K_U is the stiffness of the given unloading curve, or else Hertz's.
    """
    contact, largest, where, first = law.contact, 0.0, 0.0, math.inf
    for index in contact.representatives():
        p = params_at(law.params, index)
        radius = float(np.broadcast_to(contact.radius, contact.size or 1)[index])
        overlap = np.geomspace(1e-12 * radius, 0.1 * radius, 2000)
        part = loading_part(p)
        # where K may jump up, between two points; the law of a table was checked in closed form
        steps = [] if isinstance(part, TableParams) else law.curve.kinks(part)
        overlap = np.sort(np.append(overlap, [step * (1.0 + 1e-12) for step in steps if step < 0.1 * radius]))
        force, stiffness = force_loop(law.shape, p, overlap)
        usable = np.isfinite(force) & (force > 0) & (force <= max_force)
        elastic, other = unloading_curve_at(law, p, force)
        if not np.any(usable):
            lowest = f"{np.nanmin(force):.3g} N at an overlap of {overlap[0]:.3g} m"
            raise DemlawsError(
                f"max_force = {max_force:.3g} N is below all forces of law {law.name!r}, which begin with {lowest}"
            )
        usable &= elastic > 0.0  # at a seating load the curve is a step; beyond its end there is none
        if not np.any(usable):
            raise DemlawsError("the unloading curve has no load in common with the law: is it for another contact?")
        ratio = stiffness[usable] / other[usable]
        k = int(np.argmax(ratio))
        if ratio[k] > largest:
            largest, where = float(ratio[k]), float(force[usable][k])
        above = int(np.argmax(ratio > 1.0 + 1e-9))  # 0 if no ratio is above 1
        loaded = ratio[above] > 1.0 + 1e-9 and overlap[usable][above] > _LOADED * radius
        first = min(first, 0.99 * float(force[usable][above]) if loaded else math.inf if ratio[k] <= 1.0 + 1e-9 else 0.0)
    return largest, where, first
