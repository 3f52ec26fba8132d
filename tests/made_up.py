"""A law that nobody uses: any exponent, any number of kinks, to test tables with what the registry's laws do not have."""

import math
from typing import NamedTuple

from demlaws.core.dispatch import bind
from demlaws.core.fastmath import cbrt, hertz_coefficient, kernel, power, sqrt
from demlaws.curves.closed import ClosedForm
from demlaws.law import Law
from demlaws.laws.definition import Definition

STEP = 0.3


class MadeUpShape(NamedTuple):
    """P = C (σ^(1.5 - n) δ^n + 0.3 √σ Σ (δ - kink σ)), C = (4/3) E* √R, terms of the sum where they are positive."""

    exponent: float
    kinks: tuple  # in δ/σ


class MadeUpParams(NamedTuple):
    """One contact."""

    hertz_coefficient: float
    length: float
    exponent: float
    kinks: tuple


@kernel
def _scale(shape, radius, modulus, roughness):
    return MadeUpParams(hertz_coefficient(radius, modulus), roughness, shape.exponent, shape.kinks)


@kernel
def _virgin(p, overlap):
    u = overlap / p.length
    f = power(u, p.exponent)
    k = p.exponent * f / u
    for kink in p.kinks:
        f += STEP * max(u - kink, 0.0)
        k += STEP if u >= kink else 0.0
    root = cbrt(f)
    scale = p.hertz_coefficient * sqrt(p.length)
    return scale * p.length * f, scale * k, p.length * root * root, p.length * root * root


@kernel
def _inverse(p, force):
    low, high = 0.0, 1e6 * p.length
    for _ in range(200):
        middle = 0.5 * (low + high)
        if _virgin(p, middle)[0] < force:
            low = middle
        else:
            high = middle
    return high


@kernel
def _energy(p, overlap):
    u = overlap / p.length
    work = u * power(u, p.exponent) / (p.exponent + 1.0)
    for kink in p.kinks:
        work += 0.5 * STEP * max(u - kink, 0.0) ** 2
    return p.hertz_coefficient * sqrt(p.length) * p.length * p.length * work


bind(MadeUpShape, scale=_scale)
bind(MadeUpParams, virgin=_virgin, inverse=_inverse, energy=_energy)


def made_up_law(contact, exponent=1.5, kinks=()):
    """The law with kinks of the stiffness at these δ/σ."""
    definition = Definition(
        name="made-up",
        prepare=lambda contact, **options: MadeUpShape(exponent, (*map(float, kinks), math.inf)),
        equation="",
        source="nobody",
        description="a law for tests",
        limits=lambda contact, **options: [],
        kinks=lambda params, **options: [kink * params.length for kink in kinks],
    )
    return Law(contact, ClosedForm(definition, contact, {}))
