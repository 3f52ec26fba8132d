"""Greenwood & Tripp 1967: elastic Gaussian asperities on an elastic bulk, the reference for roughness."""

import math

import numpy as np

from demlaws.errors import DemlawsError
from demlaws.laws.definition import (
    POSITIVE,
    ROUGHNESS,
    SEATING,
    Definition,
    Drawing,
    Fitting,
    Numbers,
    Option,
    Parameter,
    bulk_yield,
)
from demlaws.laws.family import SEATING_SHARE, CurveNumber, prepare, seating_limit
from demlaws.solvers.master_curves import ELASTIC_LAYER
from demlaws.units import number

MU = 4.0
"""μ where nothing is known of the asperities: the lowest of the papers' 4 to 17."""


def _number(contact, mu, asperity_density, asperity_radius):
    """μ = (8/3) η σ √(2Rβ), or one value of μ for all contacts."""
    if (asperity_density is None) != (asperity_radius is None):
        raise DemlawsError("give asperity_density in 1/m² and asperity_radius in m together, or mu alone")
    if asperity_density is None:
        return CurveNumber(MU if mu is None else mu, 0.0, 0.0, 0.0)
    if mu is not None:
        raise DemlawsError(f"mu = {mu!r} and asperity_density are both given: give one of them")
    asperity = number(asperity_radius, "asperity_radius", "m", 0.0, float(np.min(contact.radius)))
    return CurveNumber(8.0 / 3.0 * asperity_density * math.sqrt(2.0 * asperity), 0.0, 0.5, 1.0)


def _prepare(contact, mu=None, asperity_density=None, asperity_radius=None, seating_share=SEATING_SHARE):
    return prepare(ELASTIC_LAYER, _number(contact, mu, asperity_density, asperity_radius), contact, seating_share)


def _limits(contact, seating_share=SEATING_SHARE, **_):
    return [*bulk_yield(contact), seating_limit(contact, seating_share)]


LAW = Definition(
    name="greenwood-tripp",
    prepare=_prepare,
    equation="s(r) = d + r² + w(r) - w(0), p = (μ/2) E* √(σ/2R) F_3/2(s), w from the elastic half-space",
    source="Greenwood & Tripp 1967; Greenwood, Johnson & Matsubara 1984",
    description="elastic Gaussian asperities, solved",
    limits=_limits,
    collapses=False,
    implicit=True,
    solved=True,
    needs=("roughness",),
    default_unloading="hertz",
    example={"mu": MU},
    options={
        "mu": Option(
            "", Numbers(0.05, 1e5, True), f"μ = (8/3) η σ √(2Rβ), or give both asperity quantities; without either {MU:g}"
        ),
        "asperity_density": Option("1/m²", POSITIVE, "η, with asperity_radius in place of mu", -2 / 3),
        "asperity_radius": Option("m", POSITIVE, "β, with asperity_density in place of mu", 0.0),
        "seating_share": SEATING,
    },
    fitting=Fitting(
        parameters={"roughness": ROUGHNESS, "mu": Parameter("", True, lambda c: (0.05, 1e3), lambda c: [MU], option=True)},
        free=("roughness",),
    ),
    drawing=Drawing(colour="#17becf", line=":"),
)
