"""One branch of Pohrt & Popov alone: for scenes whose loads all lie below, or all above, the threshold."""

from typing import NamedTuple

from demlaws.core.dispatch import bind
from demlaws.core.fastmath import kernel, power, sqrt
from demlaws.core.hertz import hertz_coefficient, hertz_overlap


class PowerBranchShape(NamedTuple):
    """As PohrtPopovShape."""

    ratio: float  # r
    kappa: float


class PowerBranchParams(NamedTuple):
    """One contact: δ_H(P) = δ^r/(r δ(F)^(r-1)) at every load, the law below its threshold force F."""

    hertz_coefficient: float  # (4/3) E* √R [N/m^1.5]
    inverse_threshold: float  # 1/δ(F) [1/m]
    ratio: float
    inverse_ratio: float


class HertzBranchShape(NamedTuple):
    """As PohrtPopovShape."""

    ratio: float
    kappa: float


class HertzBranchParams(NamedTuple):
    """One contact: P = (4/3) E* √R (δ - offset)^1.5, the law above its threshold force; no force below the offset."""

    hertz_coefficient: float  # (4/3) E* √R [N/m^1.5]
    offset: float  # δ(F) - δ_H(F) [m]


@kernel
def _scale_power(shape, radius, modulus, roughness):
    threshold = shape.kappa * roughness * shape.ratio
    return PowerBranchParams(hertz_coefficient(radius, modulus), 1.0 / threshold, shape.ratio, 1.0 / shape.ratio)


@kernel
def _virgin_power(p, overlap):
    slope = power(overlap * p.inverse_threshold, p.ratio - 1.0)
    equivalent = overlap * slope * p.inverse_ratio
    root = p.hertz_coefficient * sqrt(equivalent)
    return root * equivalent, 1.5 * root * slope, equivalent, equivalent


@kernel
def _inverse_power(p, force):
    return power(hertz_overlap(p, force) * (p.inverse_threshold * p.ratio), p.inverse_ratio) / p.inverse_threshold


@kernel
def _energy_power(p, overlap):
    return _virgin_power(p, overlap)[0] * overlap / (1.5 * p.ratio + 1.0)


@kernel
def _scale_hertz(shape, radius, modulus, roughness):
    return HertzBranchParams(hertz_coefficient(radius, modulus), shape.kappa * roughness * (shape.ratio - 1.0))


@kernel
def _virgin_hertz(p, overlap):
    equivalent = overlap - p.offset
    equivalent = 0.0 if equivalent <= 0.0 else equivalent
    root = p.hertz_coefficient * sqrt(equivalent)
    return root * equivalent, 1.5 * root, equivalent, equivalent


@kernel
def _inverse_hertz(p, force):
    return hertz_overlap(p, force) + p.offset


@kernel
def _energy_hertz(p, overlap):
    force, _, equivalent, _ = _virgin_hertz(p, overlap)
    return 0.4 * force * equivalent


bind(PowerBranchShape, scale=_scale_power)
bind(PowerBranchParams, virgin=_virgin_power, inverse=_inverse_power, energy=_energy_power)
bind(HertzBranchShape, scale=_scale_hertz)
bind(HertzBranchParams, virgin=_virgin_hertz, inverse=_inverse_hertz, energy=_energy_hertz)
