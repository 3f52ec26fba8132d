"""One elastic-plastic ellipsoid pressed on a flat: Hertz's elliptic contact, first yield, full plasticity, residual shape.

After Jamari & Schipper 2006-2008; the ends of the elastic-plastic range and the residual are our derivation.
"""

import math
from typing import NamedTuple

import numpy as np

from demlaws.core.numba_compat import kernel
from demlaws.errors import DemlawsError
from demlaws.units import as_given, number

ELASTIC, ELASTIC_PLASTIC, PLASTIC = 0, 1, 2
STATES = ("elastic", "elastic-plastic", "plastic")


def shape_factors(ratio):
    """ᾱ, β̄, γ̄ and k = a/b of the elliptic Hertz contact whose principal radii have `ratio` (≥ 1); Johnson 1985, Eq. 4.28.

    a = ᾱ (3PRm/(2E*))^(1/3), b = β̄ (…)^(1/3), ω = γ̄ (9P²/(32 E*² Rm))^(1/3). The ratio is (E/k² - K)/(K - E), here by Carlson's
    integrals, of which nothing cancels as k → 1; Newton's method in ln k.
    """
    from scipy.special import ellipe, ellipkm1, elliprd

    ratio = np.asarray(ratio, float)
    if not np.all((ratio >= 1) & (ratio < 1.5e12)):
        raise DemlawsError(f"ratio of radii must be from 1 to 1.5e12 (larger over smaller), got {ratio}")

    def logarithm(x):
        square = np.exp(2.0 * x)
        return np.log(elliprd(0.0, 1.0, square) / elliprd(0.0, square, 1.0))

    x = -2.0 / 3.0 * np.log(ratio)
    for _ in range(12):
        x = x - (logarithm(x) - np.log(ratio)) * 1e-6 / (logarithm(x + 1e-6) - logarithm(x))
    k, third = np.exp(x), np.exp(x / 3.0)
    root = np.cbrt(2.0 / math.pi * ellipe(-np.expm1(2.0 * x)))
    factors = third * root, root / third**2, third**2 / root * ellipkm1(k * k) * 2.0 / math.pi, k
    return tuple(map(as_given, factors))


_STEP = 64.0  # nodes of the table below in a unit of ln ratio


_ALPHA, _BETA, _GAMMA, _ = shape_factors(np.exp(np.arange(round(28 * _STEP) + 3) / _STEP))
_FACTORS = np.log(np.column_stack([_ALPHA * _BETA, _GAMMA]))
_FACTORS = np.vstack([_FACTORS[1], _FACTORS])
"""ln ᾱβ̄ and ln γ̄, even functions of ln ratio, at -1/64, 0, 1/64 … 28: what maps with thousands of patches read in place of
Newton."""


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
def ellipsoid(p, ab, gamma, mean_radius, geometric_radius, indentation, yield_factor):
    """Force, contact area, state, ω1, ω2, elastic area, γ̄/(ᾱβ̄), γ̄ of one ellipsoid.

    ab, gamma: ᾱβ̄ and γ̄; mean_radius: Rm, 1/Rm = 1/Rx + 1/Ry; geometric_radius: √(Rx Ry).
    """
    elastic_area = 2.0 * math.pi * mean_radius * (ab / gamma) * indentation
    relative = indentation / gamma
    elastic_force = 4.0 * math.sqrt(2.0) / 3.0 * p.modulus * math.sqrt(mean_radius * relative) * relative
    pressure = yield_factor * p.hardness / p.modulus
    first = 0.5 * math.pi * math.pi * mean_radius * gamma * (ab * pressure) ** 2
    full = p.plastic_ratio * first * mean_radius * ab / (gamma * geometric_radius)
    if indentation <= first:
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
    factor = number(plastic_factor, "plastic_factor")
    if factor < 2 / 3 * yield_factor(nu):
        raise DemlawsError(
            f"plastic_factor = {factor:g}: the fully plastic pressure cannot be below the mean pressure at first "
            f"yield, {2 / 3 * yield_factor(nu):.3f} H_m",
        )
    ratio = number(plastic_ratio, "plastic_ratio", low=2.0)
    return Plasticity(number(modulus, "modulus", "Pa"), hardness, yield_factor(nu), factor, ratio)
