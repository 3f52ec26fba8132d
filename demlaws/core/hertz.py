"""The smooth sphere that every law is measured against: all Params hold its coefficient."""

from demlaws.core.fastmath import cbrt, kernel, sqrt


@kernel
def hertz_coefficient(radius, modulus):
    """(4/3) E* √R [N/m^1.5]."""
    return 4.0 * modulus * sqrt(radius) / 3.0


@kernel
def hertz_overlap(p, force):
    """δ_H(P) = (9 P²/(16 R E*²))^(1/3) [m] of any law's params."""
    root = cbrt(force / p.hertz_coefficient)
    return root * root
