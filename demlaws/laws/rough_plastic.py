"""Bulk yield of a rough contact: any rough law of loading, then constant stiffness after gross yield."""

import math
from typing import NamedTuple

import numpy as np

from demlaws.checks import number
from demlaws.core.dispatch import bind, energy, inverse, scale, virgin
from demlaws.core.fastmath import bits, from_bits, kernel
from demlaws.core.hertz import hertz_overlap
from demlaws.errors import DemlawsError
from demlaws.laws.definition import DIMENSION, PRESSURE, ROUGHNESS, Definition, Option, Parameter
from demlaws.laws.extended import PI, extended
from demlaws.materials import GRANITE, GRANITE_YIELD_PRESSURE


class RoughPlasticShape(NamedTuple):
    """The rough law's shape and the pressure at which the bulk yields."""

    loading: tuple  # Shape of the rough law
    yield_pressure: float  # p_y [Pa]


class RoughPlasticParams(NamedTuple):
    """One contact."""

    hertz_coefficient: float  # (4/3) E* √R [N/m^1.5]
    loading: tuple  # Params of the rough law
    yield_overlap: float  # δ_y [m]
    yield_force: float  # P_y [N]
    yield_stiffness: float  # K_y = π R p_y [N/m]
    yield_area: float  # a_y²/R = δ_H(P_y) [m]
    area_slope: float  # d(a²/R)/dP = 1/K_y [m/N]


@kernel
def _scale(shape, radius, modulus, roughness):
    loading = scale(shape.loading, radius, modulus, roughness)
    stiffness = math.pi * radius * shape.yield_pressure
    # Bisection over bit patterns: the stiffness of every rough law rises with overlap, and 62 halvings are exact.
    low = bits(1e-30 * radius)
    high = bits(1e3 * radius)
    while high - low > 1:
        middle = low + ((high - low) >> 1)  # the sum of two bit patterns may overflow
        if virgin(loading, from_bits(middle))[1] < stiffness:
            low = middle
        else:
            high = middle
    overlap = from_bits(low)
    force, _, equivalent, _ = virgin(loading, overlap)
    return RoughPlasticParams(loading.hertz_coefficient, loading, overlap, force, stiffness, equivalent, 1.0 / stiffness)


@kernel
def _virgin(p, overlap):
    rough = overlap if overlap <= p.yield_overlap else p.yield_overlap
    force, stiffness, equivalent, area = virgin(p.loading, rough)
    yielded = p.yield_force + p.yield_stiffness * (overlap - p.yield_overlap)
    yielded_equivalent = hertz_overlap(p, yielded)
    if overlap <= p.yield_overlap:
        return force, stiffness, equivalent, area
    # [our derivation] a² = a_y² + (P - P_y)/(π p_y), with a_y the Hertz radius at yield: Thornton's a² for smooth spheres
    return yielded, p.yield_stiffness, yielded_equivalent, p.yield_area + p.area_slope * (yielded - p.yield_force)


@kernel
def _inverse(p, force):
    if force <= p.yield_force:
        return inverse(p.loading, force)
    return p.yield_overlap + (force - p.yield_force) / p.yield_stiffness


@kernel
def _energy(p, overlap):
    if overlap <= p.yield_overlap:
        return energy(p.loading, overlap)
    more = overlap - p.yield_overlap
    return energy(p.loading, p.yield_overlap) + more * (p.yield_force + 0.5 * p.yield_stiffness * more)


bind(RoughPlasticShape, scale=_scale)
bind(RoughPlasticParams, virgin=_virgin, inverse=_inverse, energy=_energy)


def _loading_definition(loading):
    from demlaws.laws.registry import find  # the registry imports this module

    definition = find(loading)
    if definition.default_unloading != "elastic":
        raise DemlawsError(
            f"loading={loading!r} is a law that yields by itself: give the law that holds before, or that law alone"
        )
    if definition.name == LAW.name:
        raise DemlawsError(f"loading={loading!r}: give the rough law that holds before yield, for instance 'pohrt-popov'")
    return definition


def _prepare(contact, yield_pressure=None, loading="pohrt-popov", **loading_options):
    if yield_pressure is None:
        of_granite = (
            f"{GRANITE_YIELD_PRESSURE / 1e9:g}e9, that is {GRANITE_YIELD_PRESSURE / GRANITE.hardness:.3f} times its hardness"
        )
        raise DemlawsError(f"law 'rough-plastic' needs yield_pressure in Pa (granite of the tests: {of_granite})")
    definition = _loading_definition(loading)
    for field in definition.needed(**loading_options):
        if getattr(contact, field) is None:
            raise DemlawsError(f"loading {loading!r} needs the contact's {field}: give Contact(..., {field}=...)")
    pressure = number(yield_pressure, "yield_pressure", "Pa")
    return RoughPlasticShape(definition.shape(contact, **loading_options), pressure)


def _before_yield(yield_pressure=None, loading="pohrt-popov", **loading_options):
    return _loading_definition(loading), loading_options


def _kinks(p, yield_pressure=None, loading="pohrt-popov", **loading_options):
    kinks = _loading_definition(loading).kinks(p.loading, **loading_options)
    return [*(k for k in kinks if k < p.yield_overlap), p.yield_overlap]


def _seated(yield_pressure=None, loading="pohrt-popov", **loading_options):
    return _loading_definition(loading).seated(**loading_options)


def _bulk(p):
    return p.yield_overlap, p.yield_area, p.area_slope


def _limits(contact, yield_pressure=None, loading="pohrt-popov", **loading_options):
    # The upper limits of the rough law say that the bulk yields; here it does.
    limits = _loading_definition(loading).limits(contact, **loading_options)
    return [limit._replace(maximum_force=math.inf) for limit in limits if limit.minimum_force > 0.0]


def _exact(contact, overlap, yield_pressure, loading="pohrt-popov", **loading_options):
    exact = _loading_definition(loading).exact
    if exact is None:
        return None
    delta, stiffness = extended(overlap), PI * extended(contact.radius) * extended(yield_pressure)
    middle = np.log(extended(contact.radius))
    low, high = middle - 70, middle + 7
    for _ in range(45):  # to 2e-12 of δ_y: where K = K_y the force changes with the square of that
        middle = (low + high) / 2
        softer = exact(contact, np.exp(middle), **loading_options)[1] < stiffness
        low, high = np.where(softer, middle, low), np.where(softer, high, middle)
    yields = np.exp(low)
    force, tangent = exact(contact, np.minimum(delta, yields), **loading_options)
    return force + stiffness * np.maximum(delta - yields, 0), np.where(delta > yields, stiffness, tangent)


def _advise(conditions):
    part = "the bulk yields" if conditions.yields else "the bulk is elastic; a rough law alone will do"
    return conditions.yields, f"{conditions.state}: {part}"


LAW = Definition(
    name="rough-plastic",
    prepare=_prepare,
    equation="K = min(K_rough(P), π R p_y)",
    source="Thornton 1997 (limit pressure); Altuhafi, Baudet & Coop 2023 (constant stiffness after yield)",
    description="any rough law, then bulk yield",
    limits=_limits,
    kinks=_kinks,
    seated=_seated,
    bulk=_bulk,
    collapses=False,
    before_yield=_before_yield,
    example={"yield_pressure": GRANITE_YIELD_PRESSURE},
    exact=_exact,
    advise=_advise,
    unloading=("elastic", "hertz", "thornton"),
    fitted={
        "roughness": ROUGHNESS,
        "fractal_dimension": DIMENSION,
        "yield_pressure": Parameter(
            "Pa", True, lambda c: (1e-4 * c.modulus, c.modulus), lambda c: c.modulus * np.geomspace(0.01, 0.3, 6), option=True
        ),
    },
    free=("roughness", "fractal_dimension", "yield_pressure"),
    label="rough-plastic",
    colour="#ff7f0e",
    line="-.",
    options={
        "yield_pressure": Option("Pa", "above 0", "contact pressure p_y at which the bulk yields; needed", PRESSURE),
        "loading": Option("", "name of a law", "law that holds before the bulk yields; that law's options can be given, too"),
    },
)
