"""Greenwood & Tripp 1967: elastic Gaussian asperities on an elastic bulk, the reference for roughness."""

from demlaws.laws.definition import (
    CELLS,
    SEATING,
    SIGMA,
    Definition,
    Drawing,
    Fitting,
    Loading,
    Numbers,
    Option,
    Parameter,
    Rules,
    bulk_yield,
)
from demlaws.laws.family import SEATING_SHARE, CurveNumber, prepare, seating_limit
from demlaws.solvers.master_curves import ELASTIC_LAYER

MU = 4.0
"""μ where nothing is known of the asperities: the lowest of the papers' 4 to 17."""


LAW = Definition(
    name="greenwood-tripp",
    prepare=lambda contact, mu=MU, seating_share=SEATING_SHARE: prepare(
        ELASTIC_LAYER, CurveNumber(mu, 0.0, 0.0, 0.0), contact, seating_share
    ),
    equation="s(r) = d + r² + w(r) - w(0), p = (μ/2) E* √(σ/2R) F_3/2(s), w from the elastic half-space",
    source="Greenwood & Tripp 1967; Greenwood, Johnson & Matsubara 1984",
    description="elastic Gaussian asperities, solved",
    limits=lambda contact, seating_share=SEATING_SHARE, **_: [*bulk_yield(contact), seating_limit(contact, seating_share)],
    collapses=False,
    loading=Loading(needs=("sigma",), computed=CELLS),
    rules=Rules(default="hertz"),
    options={
        "mu": Option("", Numbers(0.05, 1e5, True), "μ = (8/3) η σ √(2Rβ), from `demlaws surface summits`"),
        "seating_share": SEATING,
    },
    fitting=Fitting(
        parameters={"sigma": SIGMA, "mu": Parameter("", True, lambda c: (0.05, 1e3), lambda c: [MU], option=True)},
        free=("sigma",),
    ),
    drawing=Drawing(colour="#17becf", line=":", example={"mu": MU}),
)
