"""Bahrami, Yovanovich & Culham 2005: plastic asperities on an elastic bulk, compact correlations."""

import math
from typing import NamedTuple

import numpy as np

from demlaws.core.dispatch import bind
from demlaws.core.fastmath import hertz_coefficient, hertz_overlap, kernel, root_finder
from demlaws.laws.definition import (
    HARDNESS,
    ROOT,
    SIGMA,
    Advice,
    Definition,
    Drawing,
    Fitting,
    Limit,
    Loading,
    Numbers,
    Option,
    bulk_yield,
    plastic_asperities,
)

_JOINT = 0.47
CONTINUOUS = 1.5975731915314553
"""(3.51 - 2.51 × 0.47) √0.47: a_L'√p0' that makes the two branches meet at p0' = 0.47; with 1.5976 the force would jump there
by 1e-4 of itself."""
PRINTED = 1.605
"""The published constant: δ steps back by 0.5 % of itself at p0' = 0.47, and the force jumps there."""
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(20)


class BahramiShape(NamedTuple):
    """What contacts of one hardness share."""

    hardness: float  # H_m [Pa]
    constant: float  # c in a_L' = c/√p0'


class BahramiParams(NamedTuple):
    """One contact."""

    hertz_coefficient: float  # (4/3) E* √R [N/m^1.5]
    sigma: float  # σ [m]
    softness: float  # b = 1.22 κ^-0.16, so that p0' = s/(s + b) with s = δ_H(P)/σ
    constant: float  # c
    joint: float  # s where p0' = 0.47
    joint_overlap: float  # δ/σ on the low branch there


@kernel
def _low(softness, constant, s):
    """δ/σ less its value at P → 0, and its derivative, for p0' ≤ 0.47.

    s δ/δ_H = s (c²/(2p) + 8 p (c/√p)/(π² D)), D = 4.79 - 3.17 p^3.13, and s/p = s + b exactly, so the limit
    b c²/2 (1.571 κ^-0.16 with the printed constant) drops out without cancellation.
    """
    p = s / (s + softness)
    root = math.sqrt(p)
    high = p**2.13
    d = 4.79 - 3.17 * high * p
    q = root / d
    dq = (0.5 * d / root + root * (3.17 * 3.13) * high) / (d * d) if p > 0.0 else 0.0
    b = 8.0 * constant / math.pi**2
    half = 0.5 * constant * constant
    return s * (half + b * q), half + b * (q + p * (1.0 - p) * dq)


@kernel
def _high(softness, constant, s):
    """The same for p0' > 0.47, where a_L' = 3.51 - 2.51 p0'."""
    p = s / (s + softness)
    a = 3.51 - 2.51 * p
    high = p**2.13
    d = 4.79 - 3.17 * high * p
    c = 8.0 / math.pi**2
    g = 0.5 * a * a + c * p * a / d
    dg = -2.51 * a + c * ((a - 2.51 * p) / d + p * a * (3.17 * 3.13) * high / (d * d))
    return s * g - 0.5 * constant * constant * softness, g + p * (1.0 - p) * dg


@kernel
def _scale(shape, radius, modulus, roughness):
    kappa = shape.hardness / modulus * math.sqrt(radius / roughness)
    softness = 1.22 * kappa**-0.16
    joint = softness * _JOINT / (1.0 - _JOINT)
    joint_overlap, _ = _low(softness, shape.constant, joint)
    return BahramiParams(hertz_coefficient(radius, modulus), roughness, softness, shape.constant, joint, joint_overlap)


@kernel
def _overlap(p, s):
    return _low(p.softness, p.constant, s) if s <= p.joint else _high(p.softness, p.constant, s)


_find = root_finder(_overlap)


@kernel
def _solve(p, u):
    """s = δ_H(P)/σ and ds/du at u = δ/σ."""
    below = u <= p.joint_overlap
    low = 0.0 if below else p.joint
    high = p.joint if below else u + 2.0 * p.softness
    start = min(max(u / 1.6, low), high) if below else 0.5 * (low + high)
    s = _find(p, u, low, high, start, 1e-9)  # Newton's error is squared by the step below
    value, derivative = _overlap(p, s)
    return s - (value - u) / derivative, 1.0 / derivative


@kernel
def _first_loading(shape, p, overlap):
    s, slope = _solve(p, overlap / p.sigma)
    equivalent = s * p.sigma
    root = p.hertz_coefficient * math.sqrt(equivalent)
    return root * equivalent, 1.5 * root * slope, equivalent, equivalent


@kernel
def _inverse(shape, p, force):
    s = hertz_overlap(p, force) / p.sigma
    u, _ = _low(p.softness, p.constant, s) if s <= p.joint else _high(p.softness, p.constant, s)
    return u * p.sigma


@kernel
def _moment(p, low, high):
    """∫ u df = ∫ u(s) 2√s ds over [low, high] on one branch, by Gauss's rule in √s on halving panels."""
    total = 0.0
    top = math.sqrt(high)
    bottom = math.sqrt(low)
    end = top
    while end > bottom:
        start = max(0.5 * end, bottom) if end > 1e-4 * top else bottom
        half = 0.5 * (end - start)
        for k in range(_NODES.size):
            x = start + half * (1.0 + _NODES[k])
            u, _ = _low(p.softness, p.constant, x * x) if high <= p.joint else _high(p.softness, p.constant, x * x)
            total += half * _WEIGHTS[k] * 4.0 * x * x * u
        end = start
    return total


@kernel
def _energy(shape, p, overlap):
    u = overlap / p.sigma
    s, _ = _solve(p, u)
    scaled = 4.0 / 3.0 * s * math.sqrt(s) * u
    if u <= p.joint_overlap:
        scaled -= _moment(p, 0.0, s)
    else:
        # with the printed constant the force jumps at the joint, at one overlap
        first = p.joint
        scaled -= _moment(p, 0.0, first)
        start, _ = _solve(p, p.joint_overlap * (1.0 + 1e-15))
        scaled -= 4.0 / 3.0 * (start * math.sqrt(start) - first * math.sqrt(first)) * p.joint_overlap
        scaled -= _moment(p, start, s)
    return 0.75 * p.hertz_coefficient * p.sigma * p.sigma * math.sqrt(p.sigma) * scaled


bind(BahramiShape, scale=_scale)
bind(BahramiParams, first_loading=_first_loading, inverse=_inverse, energy=_energy)


def _limits(contact, **_):
    # p0' = 0.01 is where the published correlation begins
    kappa = contact.hardness / contact.modulus * np.sqrt(contact.radius / np.maximum(contact.sigma, 1e-40))
    alpha = 99.0 / (1.22 * kappa**-0.16)
    force = 4 / 3 * contact.modulus * np.sqrt(contact.radius) * (np.asarray(contact.sigma) / alpha) ** 1.5
    reason = "p0' < 0.01: below the range of the published correlation"
    return [*bulk_yield(contact), Limit(float(np.max(force)), math.inf, reason)]


LAW = Definition(
    name="bahrami",
    prepare=lambda contact, constant=CONTINUOUS: BahramiShape(contact.hardness, constant),
    equation="δ/δ_H = a_L'²/2 + 8 p0' a_L'/(π²(4.79 - 3.17 p0'^3.13)), p0' = 1/(1 + 1.22 α κ^-0.16)",
    source="Bahrami, Yovanovich & Culham 2005; Altuhafi, Baudet & Coop 2023, Eqs. 12–14, κ and exponents mended",
    description="plastic asperities, compact",
    limits=_limits,
    loading=Loading(needs=("sigma", "hardness"), kinks=lambda p, **_: [p.joint_overlap * p.sigma], computed=ROOT),
    collapses=False,
    options={
        "constant": Option(
            "", Numbers(1.5, 1.7, True), "of the published correlation; the default makes it continuous (printed: 1.605)"
        ),
    },
    fitting=Fitting(parameters={"sigma": SIGMA, "hardness": HARDNESS}, free=("sigma",)),
    advice=Advice(suits=plastic_asperities),
    drawing=Drawing(colour="#9467bd"),
)
