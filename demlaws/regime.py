"""Which part of a rough contact deforms plastically, the asperities or the bulk (Jamari & Schipper 2006, 2008).

The criterion itself is in `criterion`; here are its answer for one contact (`regime`), and which laws fit
(`advise`). The papers' own tests are in studies/jamari.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from demlaws.contact import Contact, as_contact, smooth_overlap
from demlaws.errors import DemlawsError, warn
from demlaws.laws.definition import Conditions
from demlaws.laws.registry import registry
from demlaws.solvers.criterion import (
    BAND,
    FIT_LIMIT,
    YIELD_RATIO,
    central_pressure,
    deforming_part,
    hertz_pressure,
    pressure_drop,
    pressure_ratio,
    transition_force,
    transition_sigma,
)
from demlaws.units import as_typed, check_overlaps, number

__all__ = [
    "BAND",
    "YIELD_RATIO",
    "LawAdvice",
    "Regime",
    "advise",
    "central_pressure",
    "deforming_part",
    "hertz_pressure",
    "pressure_drop",
    "pressure_ratio",
    "regime",
    "transition_force",
    "transition_sigma",
]


YIELD_PRESSURES = 1.0, 1e15
"""Smallest and largest measured yield pressure [Pa] that is accepted."""
FIRST = 0.01
"""Share of the force from which on a law must fit a contact (`advise`): roughness matters most at small forces."""


class Regime(NamedTuple):
    """The criterion at one force. Pressures in Pa, forces in N, roughness in m."""

    force: float
    roughness_parameter: float  # α
    hertz_pressure: float  # p0
    central_pressure: float  # p(0)
    ratio: float  # p(0)/H_m; with a measured yield pressure p0/p_y, to be compared with 1
    deforms: str  # "asperities", "both" or "bulk"
    transition_force: float  # force at which p(0)/H_m = 0.6
    transition_sigma: float  # σ at which it is, at this force; 0 where even a smooth bulk stays elastic
    mu: float | None = None  # of Greenwood & Tripp's solution, where p(0) comes from it
    yield_pressure: float | None = None  # [Pa], measured

    def __str__(self):
        part = {
            "asperities": "asperities deform, the bulk stays elastic",
            "both": "asperities and bulk deform together",
            "bulk": "the bulk yields",
        }[self.deforms]
        if self.yield_pressure is not None:
            return (
                f"P = {self.force:g} N: {part}\n"
                f"α = {self.roughness_parameter:.3g}, p0 = {self.hertz_pressure / 1e9:.4g} GPa, "
                f"p0/p_y = {self.ratio:.3f} with the measured p_y = {self.yield_pressure / 1e9:.4g} GPa\n"
                f"transition (p0 = p_y) at {self.transition_force:.4g} N"
            )
        how = "(closed fit)" if self.mu is None else f"(Greenwood & Tripp's solution at μ = {self.mu:g})"
        change = f"{self.transition_force:.4g} N" if math.isfinite(self.transition_force) else "no force"
        roughness = (
            f"at this force for σ below {self.transition_sigma * 1e6:.3g} µm"
            if self.transition_sigma > 0
            else "at this force even a smooth contact has an elastic bulk"
        )
        return (
            f"P = {self.force:g} N: {part}\n"
            f"α = {self.roughness_parameter:.3g}, p0 = {self.hertz_pressure / 1e9:.4g} GPa, p(0)/H_m = {self.ratio:.3f} {how}\n"
            f"transition (p(0)/H_m = {YIELD_RATIO}) at {change}; {roughness}"
        )


def _check_load(contact: Contact, force: Any) -> float:
    """The force [N]; an error where a smooth contact's overlap under it is beyond R, a warning where it is beyond R/10."""
    load = number(force, "force", "N")
    try:
        text = check_overlaps(smooth_overlap(contact, load), contact.radius)
    except DemlawsError as error:
        raise DemlawsError(f"load {as_typed(force, 'N')}: {error}") from None
    if text is not None:
        warn(f"load {as_typed(force, 'N')}: {text}")
    return load


def regime(contact: Contact, force: Any, mu: float | None = None, *, yield_pressure: float | str | None = None) -> Regime:
    """The criterion of Jamari & Schipper at one force: whether asperities or the bulk deform.

    Attributes of this function are the other public names of its module: `dl.regime.advise`, `dl.regime.transition_force`.

    Parameters
    ----------
    contact : Contact
        One contact.
    force : float or str
        Load [N].
    mu : float, optional
        Greenwood & Tripp's μ of the surface: p(0) then comes from their solution, as in the 2006 paper. Default: the closed
        fit, with a warning for α above 10.
    yield_pressure : float or str, optional
        Measured limit pressure p_y [Pa] (the smooth Hertz p0 of the force at which yield was seen). The bulk then yields
        where p0 reaches it, independent of the hardness.

    Returns
    -------
    Regime
        Pressures, ratio and transition force.

    Raises
    ------
    DemlawsError
        Without hardness and yield pressure, or for a force that is not positive.

    Examples
    --------
    >>> pair = dl.Contact(radius=4.35e-3, modulus=32.32e9, sigma=2.4e-6, hardness=6.266e9)
    >>> found = dl.regime(pair, "10N")
    >>> found.deforms, round(found.ratio, 3)
    ('asperities', 0.036)
    """
    if as_contact(contact).size is not None:
        raise DemlawsError("regime takes one contact; this one is an array: use pressure_ratio and transition_force")
    force = _check_load(contact, force)
    p0, alpha = float(hertz_pressure(contact, force)), float(contact.roughness_parameter(force))
    if yield_pressure is not None:
        limit = number(yield_pressure, "yield_pressure", "Pa", *YIELD_PRESSURES)
        ratio = p0 / limit
        deforms = deforming_part(YIELD_RATIO * ratio)
        yields = float(math.pi**3 * contact.radius**2 * limit**3 / (6.0 * contact.modulus**2))
        return Regime(force, alpha, p0, p0 * float(pressure_drop(alpha)), ratio, deforms, yields, 0.0, mu, limit)
    ratio = pressure_ratio(contact, force, mu)
    if mu is None and alpha > FIT_LIMIT:
        warn(f"α = {alpha:.3g}: above {FIT_LIMIT:g} the closed fit of p(0)/p0 is 1.5 to 2 times too high; give μ")
    return Regime(
        force=force,
        roughness_parameter=alpha,
        hertz_pressure=p0,
        central_pressure=ratio * contact.hardness,
        ratio=ratio,
        deforms=deforming_part(ratio),
        transition_force=transition_force(contact, mu=mu),
        transition_sigma=transition_sigma(contact, force, mu=mu),
        mu=mu,
    )


class LawAdvice(NamedTuple):
    """Whether a law applies to a contact up to a force, and why."""

    law: str
    fits: bool
    reason: str


def advise(contact: Contact, force: Any, yield_pressure: Any = None, *, mu: float | None = None) -> list[LawAdvice]:
    """Which laws apply to a contact from first touch up to a force.

    Parameters
    ----------
    contact : Contact
        One contact.
    force : float or str
        Load [N].
    yield_pressure : float or str, optional
        As in `regime`.
    mu : float, optional
        As in `regime`.

    Returns
    -------
    list of LawAdvice
        One per law, with the reason.

    Raises
    ------
    DemlawsError
        For a force that is not positive.

    Notes
    -----
    Laws differ in the part that deforms: elastic or plastic asperities on an elastic bulk, a yielding bulk, or no roughness.
    Without hardness and yield pressure the bulk is not judged, and the reason states it.
    """
    as_contact(contact)
    force = _check_load(contact, force)
    alpha = float(np.max(contact.roughness_parameter(FIRST * force)))
    if yield_pressure is not None:
        limit = number(yield_pressure, "yield_pressure", "Pa", *YIELD_PRESSURES)
        ratio = float(np.max(hertz_pressure(contact, force))) / limit
        yields, state = ratio > 1.0, f"p0/p_y = {ratio:.2f}"
    elif contact.hardness is None:
        yields, state = False, "no hardness: bulk yield unknown"
    else:
        ratio = float(np.max(pressure_ratio(contact, force, mu)))
        yields, state = ratio > YIELD_RATIO, f"p(0)/H_m = {ratio:.2f}"
    conditions = Conditions(contact, alpha, float(pressure_drop(alpha)), yields, state)
    advice = {name: definition.advice.suits(conditions) for name, definition in registry().items()}
    return [LawAdvice(name, bool(fits), reason) for name, (fits, reason) in advice.items()]


class RegimeFunctions:
    """Type of `dl.regime`: the function, whose attributes are the other public names of this module."""

    __call__ = staticmethod(regime)
    advise = staticmethod(advise)
    central_pressure = staticmethod(central_pressure)
    deforming_part = staticmethod(deforming_part)
    hertz_pressure = staticmethod(hertz_pressure)
    pressure_drop = staticmethod(pressure_drop)
    pressure_ratio = staticmethod(pressure_ratio)
    transition_force = staticmethod(transition_force)
    transition_sigma = staticmethod(transition_sigma)
    BAND, YIELD_RATIO = BAND, YIELD_RATIO
    LawAdvice, Regime = LawAdvice, Regime


regime.__dict__.update({name: getattr(RegimeFunctions, name) for name in vars(RegimeFunctions) if name[0] != "_"})
