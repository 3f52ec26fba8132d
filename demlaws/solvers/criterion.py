"""When the bulk of a rough contact yields (Jamari & Schipper 2006, 2008).

The mean pressure in the middle of a rough contact, p(0), is Hertz's p0 lowered by roughness:

    p0 = (6 P E*²/(π³ R²))^(1/3),   α = σ (16 R E*²/(9 P²))^(1/3).

The bulk stays elastic, so that only asperities deform, while p(0)/H_m < 0.6; above, the bulk yields; both deform where
the ratio is close to 0.6. The 2006 paper takes p(0)/p0 from Greenwood & Tripp's solution at the measured μ
(`central_pressure`), and gives 1 - exp(-2/(3 α^0.6)) as a closed fit (`pressure_drop`), which is what is used where μ is
not known. Both papers print 16 in place of the 6 and one loses the cube root; with the 6 of Hertz's theory what they print
is reproduced (studies/jamari).
"""

import math
from typing import Any

import numpy as np

from demlaws.contact import Contact, as_contact, smooth_overlap
from demlaws.errors import DemlawsError, MissingQuantity
from demlaws.solvers import master_curves
from demlaws.solvers.master_curves import ELASTIC_LAYER, YIELD_RATIO
from demlaws.units import as_float, as_given, number, positive

BAND = 0.04
"""Half width of the range around `YIELD_RATIO` in which asperities and bulk deform together.

Ours: the papers say "near 0.6". By Greenwood & Tripp's solution their points with both are at 0.579 and 0.585, asperities
alone at 0.569 and below, the bulk alone at 0.634 and above: the order is theirs, no band of equal halves divides them.
"""

FIT_LIMIT = 10.0
"""α above which `pressure_drop` is far from the solution that it fits."""


def hertz_pressure(contact: Contact, force: Any) -> float | Any:  # any: an array, here and below
    """p0 = (6 P E*²/(π³ R²))^(1/3) [Pa], the largest pressure of a smooth contact under `force` [N]."""
    contact, force = as_contact(contact), positive(force, "force", "N")
    return (6.0 * force * contact.modulus**2 / (math.pi**3 * contact.radius**2)) ** (1 / 3)


def pressure_drop(roughness_parameter: Any) -> float | Any:
    """p(0)/p0 = 1 - exp(-2/(3 α^0.6)): their fit (Eq. 4) to Greenwood & Tripp's results for μ = 4 to 17.

    Within 12 % of them from α = 0.05 to 2 and up to twice as high beyond `FIT_LIMIT` (tests/test_regime.py).
    """
    alpha = _parameter(roughness_parameter)
    with np.errstate(divide="ignore"):
        return -np.expm1(-2.0 / (3.0 * alpha**0.6))


def central_pressure(roughness_parameter: Any, mu: float) -> float | Any:
    """p(0)/p0 by Greenwood & Tripp's own solution at α and μ = (8/3) η σ √(2Rβ): numbers, or arrays of α."""
    alpha = np.maximum(_parameter(roughness_parameter), 1e-4)  # there the ratio is 1 within 1e-3
    mu = number(mu, "mu", "", master_curves.LOWEST, master_curves.HIGHEST, allow_low=True)
    return as_given(master_curves.central_pressure(ELASTIC_LAYER, mu, 4.0 / 3.0 * alpha**-1.5))


def _parameter(value):
    """α as an array; DemlawsError where it is negative or NaN."""
    alpha = as_float(value, "roughness_parameter", array=True)
    if not np.all(alpha >= 0.0):
        raise DemlawsError(f"roughness_parameter = {value!r:.60}: α = σ over Hertz's overlap is 0 or more")
    return alpha


def pressure_ratio(contact: Contact, force: Any, mu: float | None = None) -> float | Any:
    """p(0)/H_m under `force` [N] (number or array), of a contact that has a hardness; mu: see `central_pressure`."""
    force = positive(force, "force", "N")
    alpha = as_contact(contact).roughness_parameter(force)
    drop = pressure_drop(alpha) if mu is None else central_pressure(alpha, mu)
    return as_given(hertz_pressure(contact, force) * drop / hardness_of(contact))


def deforming_part(ratio: float) -> str:
    """ "asperities", "both" or "bulk" for a ratio p(0)/H_m."""
    ratio = number(ratio, "ratio", allow_low=True)
    return "asperities" if ratio < YIELD_RATIO - BAND else "bulk" if ratio > YIELD_RATIO + BAND else "both"


def transition_force(contact: Contact, mu: float | None = None) -> float | Any:
    """Force [N] at which p(0)/H_m reaches `YIELD_RATIO`; below it only asperities deform.

    p(0) rises with the force at every roughness, as P^0.733 where roughness rules and as P^(1/3) without it, so there is
    one such force. One number, or one entry per contact. mu: see `central_pressure`; of one contact, to 1e-5.
    """
    limit = YIELD_RATIO * hardness_of(contact)
    if mu is not None:
        return _root(lambda force: pressure_ratio(contact, force, mu) - YIELD_RATIO, transition_force(contact))
    log = np.log(math.pi**3 * np.square(contact.radius) * limit**3 / (6.0 * np.square(contact.modulus)))
    scale = contact.roughness_parameter(1.0)  # α = scale / P^(2/3)
    # Newton's method in ln P from the smooth contact: ln p(0) is concave, its slope 1/3 to 0.733, so that no step is too long
    for _ in range(100):
        drop = pressure_drop(scale * np.exp(-2.0 / 3.0 * log))
        with np.errstate(divide="ignore"):
            exponent = np.minimum(-np.log1p(-np.minimum(drop, 1.0 - 1e-16)), 700.0)
        value = np.log(hertz_pressure(contact, np.exp(log)) * drop / limit)
        step = value / (1.0 / 3.0 + 0.4 * exponent / np.expm1(exponent))
        log = log - step
        if np.any(log > 600.0):
            raise DemlawsError(
                f"no force below 1e260 N brings p(0)/H_m to {YIELD_RATIO:g}: check roughness, radius and hardness units"
            )
        if np.max(np.abs(step)) < 1e-14:
            break
    return as_given(np.exp(log))


def transition_sigma(contact: Contact, force: Any, *, mu: float | None = None) -> float | Any:
    """Combined roughness σ [m] at which p(0)/H_m equals `YIELD_RATIO` under `force` [N]; 0 where no roughness is needed.

    mu: see `central_pressure`; of one contact and one force, to 1e-5."""
    force = positive(force, "force", "N")
    share, hertz = YIELD_RATIO * hardness_of(contact) / hertz_pressure(contact, force), smooth_overlap(contact, force)
    with np.errstate(divide="ignore", invalid="ignore"):
        alpha = np.where(share < 1.0, (-2.0 / (3.0 * np.log1p(-np.minimum(share, 1.0)))) ** (1 / 0.6), 0.0)
    roughness = as_given(alpha * hertz)
    # what differs from the smooth contact by less than the solution resolves needs no roughness either
    if mu is None or np.all(share >= 0.999):
        return roughness if mu is None else 0.0
    return _root(lambda sigma: share - central_pressure(sigma / hertz, mu), roughness)


def _root(function, near):
    """Where a function that rises is 0, within a factor of 1000 of a number."""
    from scipy.optimize import brentq

    if np.ndim(near):
        raise DemlawsError("Greenwood & Tripp's solution needs one contact and one force, got an array")
    middle = math.log(near)
    return math.exp(brentq(lambda log: function(math.exp(log)), middle - math.log(1e3), middle + math.log(1e3), xtol=1e-6))


def hardness_of(contact: Contact) -> float:
    """Hardness H_m of the contact [Pa]; DemlawsError where it has none."""
    if as_contact(contact).hardness is None:
        raise MissingQuantity.of("the criterion", "hardness")
    return contact.hardness
