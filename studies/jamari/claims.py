"""Statements of Jamari & Schipper 2006 and 2008, compared with what runs give."""

import math

from demlaws.granite.verdicts import Claim, Criterion, built_in, judge, near
from demlaws.solvers import criterion, master_curves
from demlaws.solvers.ellipsoid import plasticity
from studies.jamari.cycles import MAPS, second_changes
from studies.jamari.published import ALUMINIUM, PRINTED_RATIOS, published_contact, published_ratios, swaps

ROWS = published_ratios()
SIX = [row for row in ROWS if not math.isnan(row.solved)]
PAIR = [row for row in ROWS if not math.isnan(row.test.ratio)]


def _pressure(alpha, mu):
    return float(criterion.central_pressure(alpha, mu))


def _mu_and_alpha(_):
    """Largest |Δ ln p(0)| between μ = 4 and 17 over that between the least and largest α of the tests."""
    alphas = [row.alpha for row in SIX]
    by_mu = max(math.log(_pressure(a, 17.0) / _pressure(a, 4.0)) for a in alphas)
    return {"": by_mu / math.log(_pressure(min(alphas), 11.0) / _pressure(max(alphas), 11.0))}


def _plastic_asperities(_):
    """p(0) of plastic asperities (Yip-Venart at the test's N_H) over that of elastic ones (Greenwood-Tripp at its μ)."""
    found = {}
    for row in SIX:
        c = row.test.contact
        number = c.hardness / c.modulus * math.sqrt(8.0 * c.radius / c.sigma)
        plastic = float(master_curves.central_pressure("yip-venart", number, 4.0 / 3.0 * row.alpha**-1.5))
        found[row.test.label] = plastic / _pressure(row.alpha, row.test.mu)
    return found


def _yield_factors(_):
    """K = p0/H at first yield by three formulas, over Tabor's 0.6, for the flats' ν."""
    v = ALUMINIUM.poisson
    return {"Chang et al.": (0.454 + 0.41 * v) / 0.6, "Lin & Lin": (0.4645 + 0.3141 * v + 0.1943 * v**2) / 0.6}


def _mean_pressure(_):
    """Mean pressure over H of an asperity at first yield: 2/3 of the largest pressure."""
    c = PAIR[0].test.contact
    return {"": 2.0 / 3.0 * plasticity(c.modulus, c.hardness, ALUMINIUM.poisson, 0.71, 160.0).yield_factor}


def asperity_counts(shares=(0.3, 0.5, 0.7, 0.85, 0.95)):
    """Numbers of nine-point summits and of patches above cuts at these shares of the depth of the isotropic map of 2008."""
    import numpy as np
    from scipy.ndimage import label, maximum_filter

    z = published_contact("isotropic").heights.heights
    cuts = [z.max() - share * np.ptp(z) for share in shares]
    summits = z == maximum_filter(z, size=3)
    joined = [[1, 1, 0], [1, 1, 1], [0, 1, 1]]  # pixels that the asperity model joins
    return [int(np.sum(summits & (z > cut))) for cut in cuts], [label(z > cut, joined)[1] for cut in cuts]


def _patches(_):
    _, patches = asperity_counts()
    return {"": patches[-1] / max(patches)}


def _misprinted(_):
    return {row.test.label: row.fitted * (16.0 / 6.0) ** (1 / 3) / row.test.ratio for row in PAIR}


def _second_cycle(memory):
    return lambda _: {f"map {n}": change for n, change in enumerate(second_changes(memory), start=1)}


CLAIMS = (
    Claim("2006, Eq. 3", "yield", "three formulas for K differ little", "K over Tabor's 0.6", _yield_factors, near(1.0)),
    Claim("2006, Fig. 1", "p(0)/p0", "μ is secondary to α", "effect of μ = 4 to 17 over that of α", _mu_and_alpha,
          Criterion(high=0.25, reason="a quarter of the effect of α over the six tests")),
    Claim("2006, Fig. 1", "six tests", "plastic and elastic asperities differ very little", "p(0), plastic over elastic",
          _plastic_asperities, near(1.0)),
    Claim("2006, Fig. 1", "α = 0.09", "p(0)/p0 is 0.9, 0.925 and 0.93 for μ = 4, 11 and 17", "computed less read",
          lambda _: {f"μ = {mu:g}": _pressure(0.09, mu) - read for mu, read in PRINTED_RATIOS.items()}, Criterion(-0.01, 0.01)),
    Claim("2006", "six tests", "α as printed", "computed less printed",
          lambda _: {row.test.label: row.alpha - row.test.alpha for row in SIX}, Criterion(-0.011, 0.011)),
    Claim("2006", "six tests", "bulk deforms above p(0)/H = 0.6, asperities below", "tests out of order by Greenwood-Tripp",
          lambda _: {"": swaps(ROWS, "solved")}, Criterion(high=0.0, reason="the order of what was seen, at the printed μ")),
    Claim("2006, Eq. 4", "six tests", "the closed fit serves the criterion", "tests out of order by Eq. 4",
          lambda _: {"": swaps(ROWS, "fitted")}, Criterion(high=0.0, reason="the order of what was seen")),
    Claim("2008, Eq. 2", "two surfaces", "p0 = (16 P E²/(π³ R²))^(1/3)", "C_m over the printed one", _misprinted, near(1.0)),
    Claim("2008", "two surfaces", "C_m = 0.16 and 0.15", "C_m by Hertz's p0 less the printed one",
          lambda _: {row.test.label: row.fitted - row.test.ratio for row in PAIR}, Criterion(-0.006, 0.006)),
    Claim("2008", "asperity", "the mean pressure at first yield is about 0.4 H", "mean pressure/H", _mean_pressure, near(0.4)),
    Claim("2008, Fig. 2", "nine-point", "the number of summits always rises with the indentation", "", None,
          built_in("summits above a cut are above every deeper one")),
    Claim("2008, Fig. 2", "volume", "the number of asperities can fall with the indentation", "deepest cut over the most",
          _patches, Criterion(high=0.5, reason="patches of a synthetic map merge")),
    Claim("2008", "repeated contact", "no change in cycle 2, geometry is the only factor", "change in cycle 2 over cycle 1",
          _second_cycle("none"), Criterion(high=0.01, reason=f"the paper's ε_r, {MAPS} synthetic maps, geometry alone")),
    Claim("2008", "repeated contact", "profiles of cycles 1, 2, 3, 10, 20 almost the same", "change in cycle 2 over cycle 1",
          _second_cycle("pressure"), built_in("the memory of the pressure carried is made for it")),
)  # fmt: skip
"""In the order of the papers."""


def jamari_claims():
    """Every claim of both papers, judged."""
    return judge(CLAIMS, None)
