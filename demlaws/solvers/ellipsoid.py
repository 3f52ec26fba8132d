"""One elastic-plastic ellipsoid pressed on a flat: Hertz's elliptic contact, first yield, full plasticity, residual shape.

After Jamari & Schipper 2006-2008; the ends of the elastic-plastic range and the residual are our derivation.
"""

import math
from typing import NamedTuple

import numpy as np

from demlaws.core.numba_compat import kernel, loop
from demlaws.errors import DemlawsError
from demlaws.units import number

ELASTIC, ELASTIC_PLASTIC, PLASTIC = 0, 1, 2
STATES = ("elastic", "elastic-plastic", "plastic")


@kernel
def _elliptic(log_k):
    """m = 1 - k², K(m) by the arithmetic-geometric mean, S and m - S with E(m) = K (1 - S); nothing cancels as m → 0."""
    m = -math.expm1(2.0 * log_k)
    a, b, c2, weight = 1.0, math.exp(log_k), m, 0.5
    tail = 0.0
    for _ in range(12):
        if c2 < 1e-34:
            break
        a, b = 0.5 * (a + b), math.sqrt(a * b)
        c = c2 / (4.0 * a)
        c2 = c * c
        weight *= 2.0
        tail += weight * c2
    return m, 0.5 * math.pi / a, 0.5 * m + tail, 0.5 * m - tail


@kernel
def _ellipticity(ratio):
    """ln k, k = a/b ≤ 1, of the Hertz contact whose radii of curvature have this ratio ≥ 1 (Johnson 1985, Eq. 4.28).

    Newton on ln[(E/k² - K)/(K - E)] = ln ratio.
    """
    target = math.log(ratio)
    x = -2.0 / 3.0 * target
    if target < 1e-5:
        return x  # odd in the target: the next term is of third order
    for _ in range(50):
        m, _, s, d = _elliptic(x)
        k2 = math.exp(2.0 * x)
        slope = -1.5 if m < 1e-3 else -k2 / d + (d + k2 * s) / (m * s) - 2.0
        step = (math.log(d / s) - 2.0 * x - target) / slope
        x -= step
        if abs(step) < 4e-16 * abs(x):
            break
    return x


@kernel
def _shape_factors(ratio):
    """ᾱ, β̄, γ̄ of an ellipsoid whose radii of curvature have this ratio ≥ 1."""
    x = _ellipticity(ratio)
    _, k_integral, s, _ = _elliptic(x)
    k_integral *= 2.0 / math.pi
    e_root = (k_integral * (1.0 - s)) ** (1.0 / 3.0)
    third = math.exp(x / 3.0)
    return third * e_root, e_root / (third * third), third * third / e_root * k_integral


@loop
def _factors_loop(ratio, out):
    for i in range(ratio.size):
        out[i, 0], out[i, 1], out[i, 2] = _shape_factors(ratio[i])
        out[i, 3] = math.exp(_ellipticity(ratio[i]))


_STEP = 64.0  # nodes of the table below in a unit of ln ratio


def _factor_table():
    """ln ᾱβ̄ and ln γ̄ at ln ratio = -1/64, 0, 1/64 … 28: what maps with thousands of patches read in place of Newton."""
    exact = np.empty((round(28 * _STEP) + 3, 4))
    _factors_loop(np.exp(np.arange(len(exact)) / _STEP), exact)
    table = np.log(np.column_stack([exact[:, 0] * exact[:, 1], exact[:, 2]]))
    return np.vstack([table[1], table])  # both are even functions of ln ratio


_FACTORS = _factor_table()


@kernel
def quick_factors(ratio):
    """ᾱβ̄ and γ̄ to 1e-10, by cubic interpolation, for ratios up to e^28."""
    place = min(math.log(ratio), 28.0) * _STEP
    i = int(place)
    t = place - i
    w0 = -t * (t - 1.0) * (t - 2.0) / 6.0
    w1 = (t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0
    w2 = -(t + 1.0) * t * (t - 2.0) / 2.0
    w3 = (t + 1.0) * t * (t - 1.0) / 6.0
    f = _FACTORS
    log_ab = w0 * f[i, 0] + w1 * f[i + 1, 0] + w2 * f[i + 2, 0] + w3 * f[i + 3, 0]
    log_gamma = w0 * f[i, 1] + w1 * f[i + 1, 1] + w2 * f[i + 2, 1] + w3 * f[i + 3, 1]
    return math.exp(log_ab), math.exp(log_gamma)


class Plasticity(NamedTuple):
    """Material of the asperities as the compiled code takes it."""

    modulus: float  # E* [Pa]
    hardness: float  # H_m [Pa]
    yield_factor: float  # K_ν: first yield at p0 = K_ν H_m
    plastic_factor: float  # c_h: mean pressure c_h H_m when fully plastic
    plastic_ratio: float  # c_A


@kernel
def ellipsoid(p, ab, gamma, mean_radius, geometric_radius, indentation, yield_factor, elastic_only):
    """Force, contact area, state, ω1, ω2, elastic area, γ̄/(ᾱβ̄), γ̄ of one ellipsoid.

    ab, gamma: ᾱβ̄ and γ̄; mean_radius: Rm, 1/Rm = 1/Rx + 1/Ry; geometric_radius: √(Rx Ry).
    """
    elastic_area = 2.0 * math.pi * mean_radius * (ab / gamma) * indentation
    relative = indentation / gamma
    elastic_force = 4.0 * math.sqrt(2.0) / 3.0 * p.modulus * math.sqrt(mean_radius * relative) * relative
    pressure = yield_factor * p.hardness / p.modulus
    first = 0.5 * math.pi * math.pi * mean_radius * gamma * (ab * pressure) ** 2
    full = p.plastic_ratio * first * mean_radius * ab / (gamma * geometric_radius)
    if elastic_only or indentation <= first:
        return elastic_force, elastic_area, ELASTIC, first, full, elastic_area, gamma / ab, gamma
    plastic_area = 2.0 * math.pi * geometric_radius * indentation
    at_yield = 2.0 / 3.0 * yield_factor
    ceiling = max(p.plastic_factor, at_yield)
    if indentation >= full:
        return ceiling * p.hardness * plastic_area, plastic_area, PLASTIC, first, full, elastic_area, gamma / ab, gamma
    x = (indentation - first) / (full - first)
    area = elastic_area + (plastic_area - elastic_area) * x * x * (3.0 - 2.0 * x)
    mean = p.hardness * (ceiling - (ceiling - at_yield) * math.log(full / indentation) / math.log(full / first))
    return mean * area, area, ELASTIC_PLASTIC, first, full, elastic_area, gamma / ab, gamma


@kernel
def residual(p, mean_radius, force, area, indentation, gamma_over_ab, gamma, state):
    """Indentation left after unloading: the ellipsoid that carries the same force elastically over the same area."""
    if state == ELASTIC:
        return 0.0
    g = area * gamma_over_ab / (2.0 * math.pi)  # Rm' ω' of the unloaded shape
    return indentation - 3.0 * force * gamma * math.sqrt(gamma) / (4.0 * math.sqrt(2.0) * p.modulus * math.sqrt(g))


def shape_factors(ratio):
    """ᾱ, β̄, γ̄ and k = a/b of the elliptic Hertz contact whose principal radii have `ratio` (≥ 1).

    a = ᾱ (3PRm/(2E*))^(1/3), b = β̄ (…)^(1/3), ω = γ̄ (9P²/(32 E*² Rm))^(1/3), by exact elliptic integrals.
    """
    ratio = np.asarray(ratio, float)
    if not np.all((ratio >= 1) & (ratio < 1e12)):
        raise DemlawsError(f"ratio of radii must be from 1 to 1e12 (larger over smaller), got {ratio}")
    out = np.empty((ratio.size, 4))
    _factors_loop(ratio.ravel(), out)
    return tuple(float(c[0]) if ratio.ndim == 0 else c.reshape(ratio.shape) for c in out.T)


def yield_factor(poisson):
    """K_ν = 0.4645 + 0.3141 ν + 0.1943 ν²: p0/H_m at first yield (Lin & Lin)."""
    return 0.4645 + 0.3141 * poisson + 0.1943 * poisson**2


ALUMINIUM_FACTOR, ALUMINIUM_RATIO = 0.71, 160.0
"""c_h and c_A of the aluminium of Jamari & Schipper 2008: inputs of a material, which no paper gives for rock."""


def plasticity(modulus, hardness, poisson, plastic_factor=ALUMINIUM_FACTOR, plastic_ratio=ALUMINIUM_RATIO):
    """The material of asperities: E* [Pa], H_m [Pa], ν; c_h and c_A are known for the aluminium of the papers only.

    hardness=inf: elastic asperities.
    """
    hardness = math.inf if hardness == math.inf else number(hardness, "hardness", "Pa")
    nu = number(poisson, "poisson", low=-1.0, high=0.5)
    factor = number(plastic_factor, "plastic_factor (c_h)")
    if factor < 2 / 3 * yield_factor(nu):
        raise DemlawsError(
            f"plastic_factor (c_h) = {factor:g}: the fully plastic pressure cannot be below the mean pressure at first "
            f"yield, {2 / 3 * yield_factor(nu):.3f} H_m"
        )
    ratio = number(plastic_ratio, "plastic_ratio (c_A)", low=2.0)
    return Plasticity(number(modulus, "modulus", "Pa"), hardness, yield_factor(nu), factor, ratio)
