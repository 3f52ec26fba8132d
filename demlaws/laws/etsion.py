"""Unloading of a yielded sphere from its largest force, contact radius and overlap (Etsion, Kligerman & Kadin 2005)."""

from typing import NamedTuple

from demlaws.core.dispatch import bind, parts, virgin
from demlaws.core.fastmath import kernel, sqrt
from demlaws.core.unloading import Rule, own_rule, thornton_stored_and_dissipated, thornton_unloaded


class Etsion(NamedTuple):
    """Back along Hertz's curve of R_p = 4 E* a_max³/(3 Pmax) from δp = δmax - 3 Pmax/(4 E* a_max); reloading likewise.

    The formula is Thornton's; the contact radius a is the law's own function of the overlap, not that of a limit pressure.
    """


@kernel
def _step(rule, p, overlap, state):
    positive = 0.0 if overlap <= 0.0 else overlap
    if overlap >= state[0]:
        force, stiffness, hertz_overlap, _ = virgin(p, positive)
        area = virgin(parts(p)[1], positive)[3]  # of a table, too, the law's; LLVM leaves out what is not used
        growth = area / hertz_overlap
        ratio = growth * sqrt(growth)
        maximum, plastic = overlap, overlap - area / ratio
    else:
        maximum, plastic, ratio = state
        elastic = positive - plastic
        elastic = 0.0 if elastic <= 0.0 else elastic
        root = p.hertz_coefficient * sqrt(ratio * elastic)
        force, stiffness = root * elastic, 1.5 * root
    if overlap <= 0.0:
        force, stiffness, maximum, plastic, ratio = 0.0, 0.0, 0.0, 0.0, 0.0
    return force, stiffness, (maximum, plastic, ratio)


bind(Etsion, step=_step, stored_and_dissipated=thornton_stored_and_dissipated, unloaded=thornton_unloaded)

ETSION = own_rule(
    Rule(
        "etsion",
        Etsion(),
        ("maximum_overlap", "plastic_overlap", "radius_ratio"),
        "law",
        6,
        "back along Hertz's curve of the radius that Pmax and the law's own contact radius leave",
        ("etsion_overlap", "etsion_power"),  # a²/(R δ) = max(1, δ/overlap)^power
    )
)

NOT_THORNTON = {"thornton": "a limit pressure gives that rule its contact radius; 'etsion' takes this law's own"}
