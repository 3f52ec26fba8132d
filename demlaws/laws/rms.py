"""Greenwood, Johnson & Matsubara 1984 with the fit of Yimsiri & Soga 2000: the "RMS" model."""

import math
from typing import NamedTuple

import numpy as np

from demlaws.core.dispatch import bind
from demlaws.core.fastmath import hertz_coefficient, hertz_overlap, kernel, sqrt
from demlaws.laws.definition import (
    SIGMA,
    Advice,
    Definition,
    Drawing,
    Fitting,
    Limit,
    Loading,
    Rules,
    bulk_yield,
    elastic_asperities,
)


class RmsShape(NamedTuple):
    """One curve in u = δ/σ serves every contact."""


class RmsParams(NamedTuple):
    """One contact."""

    hertz_coefficient: float  # (4/3) E* √R [N/m^1.5]
    sigma: float  # σ [m]


@kernel
def _scale(shape, radius, modulus, roughness):
    return RmsParams(hertz_coefficient(radius, modulus), roughness)


@kernel
def _equivalent(u):
    """s = 1/α = δ_H(P)/σ and ds/du at u = δ/σ, from u = s ((2.4 + 2s)/(1 + 2s))².

    With w = 2s and v = 2u, w is the root of N(w) = w (2.4 + w)² - v (1 + w)², a cubic: a rational start (3e-4),
    Chebyshev's third-order step, Newton. Reciprocals of N' are carried along by Newton's own iteration.
    """
    u2 = u * u
    top = (4.97951 + u * 2.19792) + u2 * (1.96485 + u * 0.162915 + u2 * 0.999739)
    bottom = (28.6745 + u * 1.34472) + u2 * (4.71655 + u * 1.52624 + u2)
    v = u + u
    w = v * top / bottom
    a = 4.8 - v
    b = 5.76 - (v + v)
    inverse = 1.0 / ((3.0 * w + (a + a)) * w + b)
    h = (((w + a) * w + b) * w - v) * inverse
    w -= h * (1.0 + h * inverse * (3.0 * w + a))
    derivative = (3.0 * w + (a + a)) * w + b
    inverse *= 2.0 - derivative * inverse
    inverse *= 2.0 - derivative * inverse
    w -= (((w + a) * w + b) * w - v) * inverse
    inverse *= 2.0 - ((3.0 * w + (a + a)) * w + b) * inverse
    m = 1.0 + w
    return 0.5 * w, m * m * inverse


@kernel
def _first_loading(shape, p, overlap):
    s, slope = _equivalent(overlap / p.sigma)
    equivalent = s * p.sigma
    root = p.hertz_coefficient * sqrt(equivalent)
    return root * equivalent, 1.5 * root * slope, equivalent, equivalent


@kernel
def _inverse(shape, p, force):
    equivalent = hertz_overlap(p, force)
    s = equivalent / p.sigma
    ratio = (2.4 + 2.0 * s) / (1.0 + 2.0 * s)
    return equivalent * ratio * ratio


@kernel
def _energy(shape, p, overlap):
    """Closed form [our derivation]: with x = √(2s), ∫f du = f u - (4/5) s^2.5 - (x-integrals of 2.8 and 1.96 terms)."""
    s, _ = _equivalent(overlap / p.sigma)
    x = sqrt(2.0 * s)
    w = 2.0 * s
    if w > 0.25:
        first = x * (w / 3.0 - 1.0) + math.atan(x)
        second = x + 0.5 * x / (1.0 + w) - 1.5 * math.atan(x)
    else:
        first = 0.0
        second = 0.0
        term = x * w * w
        for k in range(30):
            first += term / (2 * k + 5)
            second += (k + 1) * term / (2 * k + 5)
            term *= -w
    integral = 0.8 * s * s * sqrt(s) + (5.6 * first + 3.92 * second) / (2.0 * math.sqrt(2.0))
    scaled = 4.0 / 3.0 * s * sqrt(s) * (overlap / p.sigma) - integral
    return 0.75 * p.hertz_coefficient * p.sigma * p.sigma * sqrt(p.sigma) * scaled


bind(RmsShape, scale=_scale)
bind(RmsParams, first_loading=_first_loading, inverse=_inverse, energy=_energy)


def _limits(contact):
    force = (16.0 * contact.radius * contact.modulus**2 / 9.0) ** 0.5 * np.asarray(contact.sigma) ** 1.5
    reasons = {
        5.0: "α > 5: against Greenwood & Tripp the fitted contact radius is unreliable",
        1.0: "α > 1: beyond the metal surfaces of the fit; it overestimates overlap at low load",
    }
    beyond = [Limit(float(np.max(force)) / alpha**1.5, math.inf, reason) for alpha, reason in reasons.items()]
    return [*bulk_yield(contact), *beyond]


def _suits(conditions):
    alpha = conditions.roughness_parameter
    return elastic_asperities(conditions, alpha <= 1.0, f"α = {alpha:.2g} at low load: the fit covers α up to 1")


LAW = Definition(
    name="rms",
    prepare=lambda contact: RmsShape(),
    equation="δ = a*²/R, a*/a_H = 2.4 - 2.8/(α + 2)",
    source="Greenwood, Johnson & Matsubara 1984; Yimsiri & Soga 2000; Altuhafi, Baudet & Coop 2023, Eq. 5",
    description="rough metal surfaces, fitted",
    limits=_limits,
    loading=Loading(needs=("sigma",)),
    rules=Rules(default="hertz"),
    fitting=Fitting(parameters={"sigma": SIGMA}, free=("sigma",)),
    advice=Advice(suits=_suits, rank=2, candidate=True),
    drawing=Drawing(colour="#1f77b4"),
)
