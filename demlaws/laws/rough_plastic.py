"""Bulk yield of a rough contact: any rough law of loading, then constant stiffness after gross yield.

The parameter p_y (`yield_pressure`) is a stiffness over a length, p_y = K_y/(π R): the contact yields where its tangent
stiffness reaches K_y = π R p_y, and keeps that stiffness. Only for a smooth contact is p_y the largest pressure, Hertz's p0, at
that load. Of a rough one it is neither: the granite RFC10 yields at 36.8 N, where the smooth p0 is 2.01 GPa
and the rough one 1.23 GPa, with p_y = 1.66 GPa.

**Yield at a load** (`yield_at="load"`) [our derivation]. The contact yields at π³R²p_y³/(6E*²), where a smooth contact's p0 is
p_y, and keeps the tangent that the rough law has there, as Thornton's smooth sphere keeps Hertz's: the stiffness does not jump.
RFC10 then yields at 20.9 N (printed: 20) and keeps 3620 N/mm (printed: about 5000).

**Two radii** [our derivation]. The tip of an angular grain is sharp at the scale of its roughness and blunt at that of its
shape: the cone FC5 has 0.31 to 0.35 mm under the microscope and 0.62 mm in the camera. Asperities deform on R of the contact;
yield and unloading belong to `bulk_radius` R_b ≥ R. With R_b in place of R in K_y = π R_b p_y, in π³R_b²p_y³/(6E*²) and in
Hertz's unloading curve the pair is passive: K_rough ≤ K_H(R) ≤ K_H(R_b) before yield, and a constant stiffness below K_H(R_b)
after it.
"""

import math
from typing import NamedTuple

import numpy as np

from demlaws.contact import GRANITE_YIELD_PRESSURE, pressure_of
from demlaws.core.dispatch import bind, energy, first_loading, inverse, scale
from demlaws.core.fastmath import bits, cbrt, from_bits, hertz_coefficient, hertz_overlap, kernel
from demlaws.errors import DemlawsError
from demlaws.laws.definition import (
    DIMENSION,
    POSITIVE,
    PRESSURE,
    SIGMA,
    Advice,
    Bulk,
    Definition,
    Drawing,
    Fitting,
    Loading,
    Option,
    Rules,
    pressure_option,
)


class RoughPlasticShape(NamedTuple):
    """The rough law's shape and the stiffness at which the bulk yields, over π R_b."""

    loading: tuple  # Shape of the rough law
    yield_pressure: float  # p_y [Pa]: the bulk yields where K_rough reaches π R p_y
    load_pressure: (
        float  # [Pa] if above 0, it yields at the load at which a smooth contact's p0 is this, with the tangent there
    )
    bulk_radius: float  # R_b [m] of the bulk's shape, which replaces R in all of these; 0: R


class RoughPlasticParams(NamedTuple):
    """One contact."""

    hertz_coefficient: float  # (4/3) E* √R_b [N/m^1.5]: unloading is the bulk's
    loading: tuple  # Params of the rough law
    overlap_ratio: float  # δ_H of R_b over that of R, at one load: (R/R_b)^(1/3)
    yield_overlap: float  # δ_y [m]
    yield_force: float  # P_y [N]
    yield_stiffness: float  # K_y = π R_b p_y, or the rough law's tangent at the load [N/m]
    yield_area: float  # a_y²/R_b = δ_H(P_y) [m]
    area_slope: float  # d(a²/R_b)/dP = 1/(π R_b p_y) [m/N]


@kernel
def _scale(shape, radius, modulus, roughness):
    loading = scale(shape.loading, radius, modulus, roughness)
    bulk = shape.bulk_radius if shape.bulk_radius > 0.0 else radius
    # a bulk that is sharper than the tip would return work: not a number rather than a wrong one
    bulk = bulk if bulk >= radius * (1.0 - 1e-9) else math.nan
    stiffness = math.pi * bulk * shape.yield_pressure
    # Bisection over bit patterns: the stiffness of every rough law rises with overlap, and 62 halvings are exact.
    low = bits(1e-30 * radius)
    high = bits(1e3 * radius)
    while high - low > 1:
        middle = low + ((high - low) >> 1)  # the sum of two bit patterns may overflow
        if first_loading(shape.loading, loading, from_bits(middle))[1] < stiffness:
            low = middle
        else:
            high = middle
    overlap = from_bits(low)
    if shape.load_pressure > 0.0:
        pressure = shape.load_pressure  # p0 of a smooth contact at the load π³R²p³/(6E*²)
        overlap = inverse(shape.loading, loading, math.pi**3 / 6.0 * pressure * (bulk * pressure / modulus) ** 2)
    force, tangent, equivalent, _ = first_loading(shape.loading, loading, overlap)
    after = tangent if shape.load_pressure > 0.0 else stiffness
    ratio = cbrt(radius / bulk)
    coefficient = hertz_coefficient(bulk, modulus)
    return RoughPlasticParams(coefficient, loading, ratio, overlap, force, after, ratio * equivalent, 1.0 / stiffness)


@kernel
def _first_loading(shape, p, overlap):
    rough = overlap if overlap <= p.yield_overlap else p.yield_overlap
    force, stiffness, equivalent, area = first_loading(shape.loading, p.loading, rough)
    plastic_force = p.yield_force + p.yield_stiffness * (overlap - p.yield_overlap)
    plastic_equivalent = hertz_overlap(p, plastic_force)
    if overlap <= p.yield_overlap:
        return force, stiffness, p.overlap_ratio * equivalent, p.overlap_ratio * area
    # [our derivation] a² = a_y² + (P - P_y)/(π p_y), with a_y the Hertz radius at yield: Thornton's a² for smooth spheres
    return plastic_force, p.yield_stiffness, plastic_equivalent, p.yield_area + p.area_slope * (plastic_force - p.yield_force)


@kernel
def _inverse(shape, p, force):
    if force <= p.yield_force:
        return inverse(shape.loading, p.loading, force)
    return p.yield_overlap + (force - p.yield_force) / p.yield_stiffness


@kernel
def _energy(shape, p, overlap):
    if overlap <= p.yield_overlap:
        return energy(shape.loading, p.loading, overlap)
    more = overlap - p.yield_overlap
    return energy(shape.loading, p.loading, p.yield_overlap) + more * (p.yield_force + 0.5 * p.yield_stiffness * more)


bind(RoughPlasticShape, scale=_scale)
bind(RoughPlasticParams, first_loading=_first_loading, inverse=_inverse, energy=_energy)


def _loading_definition(loading):
    from demlaws.laws.registry import find  # the registry imports this module

    definition = find(loading)
    if definition.name == LAW.name or definition.has_own_rule:
        raise DemlawsError(f"loading={loading!r} yields by itself: give the rough law before yield, for instance 'pohrt-popov'")
    return definition


def _prepare(
    contact,
    yield_pressure,
    loading="pohrt-popov",
    yield_at="stiffness",
    bulk_radius=None,
    **loading_options,
):
    definition = _loading_definition(loading)
    if yield_at not in ("stiffness", "load"):
        raise DemlawsError(f"yield_at = {yield_at!r}: the bulk yields at 'stiffness' or at 'load'")
    pressure = pressure_of(contact, yield_pressure, "yield_pressure")
    load_pressure = pressure if yield_at == "load" else 0.0
    loading_shape = definition.shape(contact, **loading_options)
    return RoughPlasticShape(loading_shape, pressure, load_pressure, _bulk_radius(contact, bulk_radius=bulk_radius) or 0.0)


def _bulk_radius(contact, bulk_radius=None, **_):
    """R_b [m] of the options, or None: it is the contact's R."""
    if bulk_radius is None:
        return None
    largest = float(np.max(contact.radius))
    if bulk_radius < largest * (1.0 - 1e-9):
        raise DemlawsError(
            f"bulk_radius = {bulk_radius:g} m is below the contact's effective radius R = {largest:g} m: R is that of the "
            "sharp tip, on which asperities deform, bulk_radius that of the blunter shape that yields"
        )
    return bulk_radius


_BULK_OPTIONS = ("yield_pressure", "yield_at", "bulk_radius")


def _before(**options):
    """Definition of the rough law, and its options among all that were given."""
    rest = {name: value for name, value in options.items() if name not in (*_BULK_OPTIONS, "loading")}
    return _loading_definition(options.get("loading", "pohrt-popov")), rest


def _default_unloading(**options):
    """Hertz's, unless the rough law, as bahrami, cannot take it."""
    definition, rest = _before(**options)
    return "elastic" if definition.loading.needs and definition.default_rule(**rest) == "elastic" else "hertz"


def _kinks(p, **options):
    definition, rest = _before(**options)
    return [*(k for k in definition.loading.kinks(p.loading, **rest) if k < p.yield_overlap), p.yield_overlap]


def _limits(contact, **options):
    # The upper limits of the rough law are those of bulk yield, which this law includes.
    definition, rest = _before(**options)
    limits = definition.limits(contact, **rest)
    return [limit._replace(maximum_force=math.inf) for limit in limits if limit.minimum_force > 0.0]


def _suits(conditions):
    part = "the bulk yields" if conditions.yields else "the bulk is elastic; a rough law alone will do"
    return conditions.yields, f"{conditions.state}: {part}"


LAW = Definition(
    name="rough-plastic",
    prepare=_prepare,
    equation="K = min(K_rough(P), π R p_y)",
    source="Thornton 1997 (limit pressure); Altuhafi, Baudet & Coop 2023 (constant stiffness after yield)",
    description="any rough law, then bulk yield",
    limits=_limits,
    loading=Loading(
        kinks=_kinks, bulk=Bulk(lambda p: (p.yield_overlap, p.yield_area, p.area_slope), radius=_bulk_radius, before=_before)
    ),
    collapses=False,
    rules=Rules(default=_default_unloading),
    unloading=("elastic", "hertz", "thornton"),
    options={
        "yield_pressure": Option(
            "Pa", POSITIVE, "p_y = K_y/(π R) of stiffness K_y from yield on; granite: 0.265 of the hardness", PRESSURE
        ),
        "loading": Option("", "name of a law", "law that holds before the bulk yields; that law's options can be given, too"),
        "yield_at": Option(
            "", "stiffness, load", "yield where K_rough = π R p_y, or at the load π³R²p_y³/(6E*²) with the tangent there"
        ),
        "bulk_radius": Option("m", POSITIVE, "R_b ≥ R of yield and unloading, in place of R; roughness keeps R", 0.0),
    },
    fitting=Fitting(
        parameters={
            "sigma": SIGMA,
            "fractal_dimension": DIMENSION,
            "yield_pressure": pressure_option(1e-4, 1.0, *np.geomspace(0.01, 0.3, 6)),
        },
        free=("sigma", "fractal_dimension", "yield_pressure"),
    ),
    advice=Advice(suits=_suits),
    drawing=Drawing(colour="#ff7f0e", line="-.", example={"yield_pressure": GRANITE_YIELD_PRESSURE}),
)
