"""Yip & Venart 1971: a plastic crust of Gaussian asperities on an elastic bulk."""

import math

import numpy as np

from demlaws.laws.definition import (
    CELLS,
    HARDNESS,
    SEATING,
    SIGMA,
    Advice,
    Definition,
    Drawing,
    Fitting,
    Limit,
    Loading,
    Rules,
    plastic_asperities,
)
from demlaws.laws.family import SEATING_SHARE, SMOOTH, CurveNumber, prepare, seating_limit
from demlaws.solvers.master_curves import PLASTIC_LAYER, yield_force


def _limits(contact, seating_share=SEATING_SHARE):
    if not np.all(np.asarray(contact.sigma) >= SMOOTH * np.asarray(contact.radius)):
        return []
    worst = np.argmax(np.ravel(np.asarray(contact.sigma) / np.asarray(contact.radius)))
    radius, modulus, roughness = (
        float(np.broadcast_to(v, contact.size or 1)[worst]) for v in (contact.radius, contact.modulus, contact.sigma)
    )
    value = contact.hardness / modulus * math.sqrt(8.0 * radius / roughness)
    yields = yield_force(value) * modulus * math.sqrt(radius) * roughness**1.5
    return [
        Limit(0.0, yields, "the central pressure passes 0.6 H_m: the bulk yields too, and this law keeps it elastic"),
        seating_limit(contact, seating_share),
    ]


LAW = Definition(
    name="yip-venart",
    prepare=lambda contact, seating_share=SEATING_SHARE: prepare(
        PLASTIC_LAYER,
        CurveNumber(math.sqrt(8.0) * contact.hardness, -1.0, 0.5, -0.5),  # N_H = H_m/(E* √(σ/8R))
        contact,
        seating_share,
    ),
    equation="s(r) = d + r² + w(r) - w(0), p = H_m ½ erfc(s/√2), w from the elastic half-space",
    source="Yip & Venart 1971; Altuhafi, Baudet & Coop 2023, Eqs. 10–11",
    description="plastic crust of Gaussian asperities, solved",
    limits=_limits,
    collapses=False,
    loading=Loading(needs=("sigma", "hardness"), computed=CELLS),
    rules=Rules(default="hertz"),
    options={
        "seating_share": SEATING,
    },
    fitting=Fitting(
        parameters={"sigma": SIGMA, "hardness": HARDNESS},
        free=("sigma",),
    ),
    advice=Advice(suits=plastic_asperities, rank=3),
    drawing=Drawing(colour="#2ca02c"),
)
