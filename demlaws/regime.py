"""Which part of a rough contact deforms plastically, the asperities or the bulk (Jamari & Schipper 2006, 2008).

The criterion itself is in `criterion`; here are its answer for one contact (`assess`), a map of it, and which laws fit
(`advise`). The papers' own tests are in studies/jamari.
"""

import math
import warnings
from typing import NamedTuple

import numpy as np

from demlaws.contact import as_contact
from demlaws.criterion import (
    BAND,
    FIT_LIMIT,
    YIELD_RATIO,
    central_pressure,
    checked_loads,
    deforming_part,
    hardness_of,
    hertz_pressure,
    lowest_transition_load,
    pressure_drop,
    pressure_ratio,
    transition_load,
    transition_roughness,
)
from demlaws.errors import DemlawsError, ValidityWarning
from demlaws.laws.definition import Conditions
from demlaws.laws.registry import registry
from demlaws.units import number, real

__all__ = [
    "BAND",
    "YIELD_RATIO",
    "Advice",
    "Regime",
    "advise",
    "assess",
    "central_pressure",
    "deforming_part",
    "hertz_pressure",
    "lowest_transition_load",
    "pressure_drop",
    "pressure_map",
    "pressure_ratio",
    "transition_load",
    "transition_roughness",
]


class Regime(NamedTuple):
    """The criterion at one load. Pressures in Pa, loads in N, roughness in m."""

    load: float
    roughness_parameter: float  # α
    hertz_pressure: float  # p0
    central_pressure: float  # p(0)
    ratio: float  # p(0)/H_m; with a measured yield pressure p0/p_y, which is to be held against 1
    deforms: str  # "asperities", "both" or "bulk"
    transition_load: float  # load at which p(0)/H_m = 0.6
    transition_roughness: float  # roughness at which it is, at this load; 0 where even a smooth bulk stays elastic
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
                f"P = {self.load:g} N: α = {self.roughness_parameter:.3g}, p0 = {self.hertz_pressure / 1e9:.4g} GPa, "
                f"p0/p_y = {self.ratio:.3f} with the measured p_y = {self.yield_pressure / 1e9:.4g} GPa: {part}\n"
                f"the answer changes (p0 = p_y) at {self.transition_load:.4g} N"
            )
        how = "by its closed fit" if self.mu is None else f"by Greenwood & Tripp's solution at μ = {self.mu:g}"
        change = f"{self.transition_load:.4g} N" if math.isfinite(self.transition_load) else "no load"
        roughness = (
            f"σ = {self.transition_roughness * 1e6:.3g} µm at this load"
            if self.transition_roughness > 0
            else "at this load the bulk of a smooth contact is elastic too"
        )
        return (
            f"P = {self.load:g} N: α = {self.roughness_parameter:.3g}, p0 = {self.hertz_pressure / 1e9:.4g} GPa, "
            f"p(0)/H_m = {self.ratio:.3f} {how}: {part}\n"
            f"the answer changes (p(0)/H_m = {YIELD_RATIO}) at {change}; {roughness}"
        )


def assess(contact, load, mu=None, yield_pressure=None):
    """The `Regime` of one contact under `load` [N].

    mu: Greenwood & Tripp's μ of the surface, as the 2006 paper does it: p(0) then comes from their solution, else from the
    paper's closed fit, which warns (ValidityWarning) for α above 10. yield_pressure: a measured limit pressure p_y [Pa]
    (Thornton's: the smooth Hertz p0 of the load at which yield was seen); the bulk then yields where p0 reaches it, whatever
    the hardness says. Raises DemlawsError without either, or for a load that is not positive.
    """
    if as_contact(contact).size is not None:
        raise DemlawsError("assess takes one contact; this one is an array: use pressure_ratio and transition_load")
    load = number(load, "load", "N")
    p0, alpha = float(hertz_pressure(contact, load)), float(contact.roughness_parameter(load))
    if yield_pressure is not None:
        limit = number(yield_pressure, "yield_pressure", "Pa")
        ratio = p0 / limit
        deforms = deforming_part(YIELD_RATIO * ratio)
        yields = float(math.pi**3 * contact.radius**2 * limit**3 / (6.0 * contact.modulus**2))
        return Regime(load, alpha, p0, p0 * float(pressure_drop(alpha)), ratio, deforms, yields, 0.0, mu, limit)
    ratio = pressure_ratio(contact, load, mu)
    if mu is None and alpha > FIT_LIMIT:
        warnings.warn(
            f"α = {alpha:.3g}: above {FIT_LIMIT:g} the closed fit of p(0)/p0 is 1.5 to 2 times too high; give μ",
            ValidityWarning,
            stacklevel=2,
        )
    return Regime(
        load=load,
        roughness_parameter=alpha,
        hertz_pressure=p0,
        central_pressure=ratio * contact.hardness,
        ratio=ratio,
        deforms=deforming_part(ratio),
        transition_load=transition_load(contact, mu=mu),
        transition_roughness=transition_roughness(contact, load, mu=mu),
        mu=mu,
    )


def pressure_map(contact, loads, roughnesses):
    """p(0)/H_m over `loads` [N] (columns) and `roughnesses` [m] (rows); `contact` gives the rest."""
    loads = np.atleast_1d(checked_loads(real(loads, "loads", "N", array=True)))
    roughnesses = np.atleast_1d(real(roughnesses, "roughnesses", "m", array=True))
    as_contact(contact)
    alpha = roughnesses[:, None] * contact.with_values(roughness=1e-9).roughness_parameter(loads)[None, :] / 1e-9
    return hertz_pressure(contact, loads)[None, :] * pressure_drop(alpha) / hardness_of(contact)


class Advice(NamedTuple):
    """Whether a law's physics fits a contact up to a load, and why."""

    law: str
    fits: bool
    reason: str


def advise(contact, load, yield_pressure=None, mu=None):
    """For each law, whether its physics fits this contact from first touch up to `load` [N], with the reason.

    The laws differ in what deforms: elastic asperities on an elastic bulk (rms, pohrt-popov, greenwood-tripp), plastic
    asperities on an elastic bulk (bahrami, yip-venart, asperity), a yielding bulk (rough-plastic), or no roughness
    (hertz); each says itself what it fits (`Definition.advise`). yield_pressure, mu: as for `assess`. Without a hardness or a
    yield pressure the bulk cannot be judged, which the reason then says.
    """
    as_contact(contact)
    load = number(load, "load", "N")
    alpha = float(np.max(contact.roughness_parameter(load)))
    if yield_pressure is not None:
        ratio = float(np.max(hertz_pressure(contact, load))) / number(yield_pressure, "yield_pressure", "Pa")
        yields, state = ratio > 1.0, f"p0/p_y = {ratio:.2f}"
    elif contact.hardness is None:
        yields, state = False, "no hardness given: bulk yield not judged"
    else:
        ratio = float(np.max(pressure_ratio(contact, load, mu)))
        yields, state = ratio > YIELD_RATIO, f"p(0)/H_m = {ratio:.2f}"
    conditions = Conditions(contact, alpha, float(pressure_drop(alpha)), yields, state)
    advice = {name: definition.advice.advise(conditions) for name, definition in registry().items()}
    return [Advice(name, bool(fits), reason) for name, (fits, reason) in advice.items()]
