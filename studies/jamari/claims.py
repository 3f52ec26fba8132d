"""What the papers of 2006 and 2008 say of regime and repeated contact, compared with what runs give."""

import math

from demlaws.granite.verdicts import BUILT_IN, NOT_REPRODUCED, REPRODUCED, Claim
from demlaws.solvers import criterion
from studies.jamari.published import PRINTED_RATIOS, published_ratios, swaps


def verdict(holds):
    """Verdict of a claim that holds or does not."""
    return REPRODUCED if holds else NOT_REPRODUCED


def jamari_claims():
    """What the papers of 2006 and 2008 say of regime and repeated contact."""
    rows = published_ratios()
    six = [row for row in rows if not math.isnan(row.solved)]
    text = ", ".join(f"{row.test.label} {row.solved:.3f} ({row.test.seen})" for row in six)
    yield Claim(
        "2006, six tests",
        "the bulk deforms above p(0)/H = 0.6, asperities below, both near it",
        f"Greenwood & Tripp at the printed μ: {text}; the order is that of what was seen",
        verdict(swaps(rows, "solved") == 0),
        "computed ratios in the order of the observed regimes",
    )
    yield Claim(
        "2006, Eq. 4",
        "the closed fit serves the criterion",
        "by Eq. 4 one of the six tests (Al, Sq = 2.2 µm) stands out of order",
        verdict(swaps(rows, "fitted") == 0),
        "computed ratios in the order of the observed regimes",
    )
    alpha = max(abs(row.alpha - row.test.alpha) for row in six)
    yield Claim(
        "2006", "α of the six tests", f"within {alpha:.3f} of the printed values", verdict(alpha <= 0.011), "within 0.011"
    )
    read = PRINTED_RATIOS
    found = {mu: criterion.central_pressure(0.09, mu) for mu in read}
    yield Claim(
        "2006, Fig. 1",
        "p(0)/p0 at α = 0.09 is 0.9, 0.925 and 0.93 for μ = 4, 11 and 17",
        ", ".join(f"{found[mu]:.3f} for μ = {mu:g}" for mu in read),
        verdict(all(abs(found[mu] - value) < 0.01 for mu, value in read.items())),
        "within 0.01 of each",
    )
    pair = [row for row in rows if not math.isnan(row.test.ratio)]
    yield Claim(
        "2008, both surfaces",
        "C_m = 0.16 and 0.15: deformation at asperity level",
        ", ".join(f"{row.test.label} {row.fitted:.3f}" for row in pair) + " by Eq. 4 (α ≈ 12, beyond its range)",
        verdict(all(abs(row.fitted - row.test.ratio) < 0.006 for row in pair)),
        "within 0.006 of the printed values",
    )
    yield from _repeated()


def _repeated():
    from studies.jamari.cycles import MAPS, MEMORIES, second_changes

    change = {memory: second_changes(memory) for memory in MEMORIES}
    text = ", ".join(f"{name} {100 * min(values):.3g} to {100 * max(values):.3g} %" for name, values in change.items())
    yield Claim(
        "2008, repeated contact",
        "in the second cycle there is no change, and the change of the geometry is the only factor",
        f"cycle 2 changes {MAPS} maps by (of cycle 1's change), by what a pixel remembers: {text}",
        verdict(max(change["none"]) < 0.01),
        "geometry alone changes each map by less than 1 % in cycle 2",
    )
    yield Claim(
        "2008, repeated contact",
        "the profiles of cycles 1, 2, 3, 10 and 20 are almost the same",
        f"with the memory of the pressure carried cycle 2 changes at most {100 * max(change['pressure']):.2g} %",
        BUILT_IN,
        "the memory is made for it",
    )
