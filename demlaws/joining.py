"""Joining a law of first loading with an unloading rule; refused where the pair is not passive."""

import math

import numpy as np

from demlaws.core.curve import TableParams
from demlaws.core.loops import inverse_loop
from demlaws.core.params import first_loading, loading_part, one_of
from demlaws.core.unloading import JoinedParams, JoinedShape
from demlaws.errors import DemlawsError, NotPassive
from demlaws.law import Law


def joined_law(law, rule, curve=None):
    """`law` (or a `Table`, as a law of its own shape) with rule `rule`, and its curve where the rule is "table".

    Raises NotPassive, a DemlawsError, where the pair is not passive.
    """
    shape, params = loading_part(law.shape), loading_part(law.params)
    if curve is not None:
        shape, params = joined_shape(law, curve), None
    result = Law(law.definition, law.contact, rule, law.options, shape, params, curve)
    if law.definition.rule(rule).curve in ("hertz", "given"):
        # a table's stiffness is what its certificate says, not more exact
        _refuse_unless_passive(result, *(one.stiffness_error for one in (law, curve) if curve is not None))
    return result


def joined_shape(law, curve):
    """Shape of `law` and an unloading curve: their contacts may differ, in a ratio that is one for all contacts."""
    ratios = {}
    for name in ("radius", "modulus", "roughness"):
        own, others = np.asarray(getattr(law.contact, name), float), np.asarray(getattr(curve.contact, name), float)
        with np.errstate(divide="ignore", invalid="ignore"):
            try:
                ratio = others / own
            except ValueError:
                raise DemlawsError(
                    f"the law holds {law.contact.size} contacts, its unloading curve {curve.contact.size}"
                ) from None
        if np.all(own == others):  # smooth contacts, too
            ratio = np.ones(1)
        low, high = float(np.nanmin(ratio)), float(np.nanmax(ratio))
        if not (math.isfinite(high) and high - low <= 1e-9 * high):
            raise DemlawsError(
                f"the {name} of the unloading curve's contact is {low:g} to {high:g} times the law's: it must be the law's own "
                "or in one ratio to it; make the curve for the same contact or array of contacts"
            )
        ratios[name] = low if high > low else high
    return JoinedShape(loading_part(law.shape), curve.quick_shape(), **ratios)


def _refuse_unless_passive(law, *uncertainties):
    """Passive where at every load K(P) ≤ that of the unloading curve; for the Hertz-like rules dδ_H/dδ ≤ 1."""
    excess, force = largest_stiffness_ratio(law)
    curve = law.unloading_law
    if excess > 1.0 + 1e-9 + sum(uncertainties):
        whose = "Hertz's" if curve is None else f"that of its unloading curve ({curve.name!r})"
        ratio = f"{excess:.4g}" if excess > 1.001 else f"1 + {excess - 1.0:.1g}"
        other = law.definition.default_unloading
        remedy = (
            f"use unloading={other!r}" if other != law.unloading else "use unloading='elastic', or other options of the law"
        )
        raise NotPassive(
            f"law {law.name!r} cannot take {law.unloading!r} unloading: at {force:.3g} N its stiffness is {ratio} times "
            f"{whose}, so that unloading would return more work than loading took; {remedy}"
        )


def largest_stiffness_ratio(law, points=2000):
    """Largest K(P)/K_U(P) of first loading over 1e-12 to 0.1 of the radius, and the force [N] where it occurs.

    K_U is the stiffness of the given unloading curve, or else Hertz's.
    """
    contact, worst, where = law.contact, 0.0, 0.0
    chosen = [0]
    if contact.size is not None:  # the extremes of relative roughness and the middle stand for the rest
        order = np.argsort(np.broadcast_to(contact.roughness, contact.size) / contact.radius)
        chosen = {int(order[0]), int(order[order.size // 2]), int(order[-1])}
    for index in chosen:
        p = one_of(law.params, index)
        radius = float(np.broadcast_to(contact.radius, contact.size or 1)[index])
        overlap = np.geomspace(1e-12 * radius, 0.1 * radius, points)
        part = loading_part(p)
        # where K may jump up, between two points; a table is of a law that was looked at in closed form
        steps = [] if isinstance(part, TableParams) else law.definition.kinks(part, **law.options)
        overlap = np.sort(np.append(overlap, [step * (1.0 + 1e-12) for step in steps if step < 0.1 * radius]))
        force, stiffness = np.empty(overlap.size), np.empty(overlap.size)
        first_loading(p, overlap, force, stiffness)
        usable = np.isfinite(force) & (force > 0)
        if isinstance(p, JoinedParams):
            elastic, own, other = (np.empty(overlap.size) for _ in range(3))
            inverse_loop(p.unloading, force, elastic)
            first_loading(p.unloading, elastic, own, other)
            usable &= elastic > 0.0  # at a seating load the curve is a step; beyond its end there is none
            if not np.any(usable):
                raise DemlawsError("the unloading curve has no load in common with the law: is it for another contact?")
        else:
            other = 1.5 * p.hertz_coefficient ** (2 / 3) * np.cbrt(force)
        ratio = stiffness[usable] / other[usable]
        k = int(np.argmax(ratio))
        if ratio[k] > worst:
            worst, where = float(ratio[k]), float(force[usable][k])
    return worst, where
