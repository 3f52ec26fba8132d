"""Vectors in compiled code: three components, as a tuple; `vector` and `assign` read and write a field of three doubles."""

from demlaws.core.fastmath import sqrt
from demlaws.core.numba_compat import kernel


@kernel
def vector(field):
    """Components of a field of three doubles."""
    return field[0], field[1], field[2]


@kernel
def assign(field, vector):
    """Write a field of three doubles."""
    field[0] = vector[0]
    field[1] = vector[1]
    field[2] = vector[2]


@kernel
def scaled(factor, a):
    """factor a."""
    return factor * a[0], factor * a[1], factor * a[2]


@kernel
def minus_scaled(a, factor, b):
    """a - factor b."""
    return a[0] - factor * b[0], a[1] - factor * b[1], a[2] - factor * b[2]


@kernel
def dot(a, b):
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel
def cross(a, b):
    """Vector product."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@kernel
def unit_perpendicular(a):
    """A unit vector normal to `a`, across the axis that is least along it."""
    if abs(a[0]) <= abs(a[1]) and abs(a[0]) <= abs(a[2]):
        side = (0.0, -a[2], a[1])
    elif abs(a[1]) <= abs(a[2]):
        side = (a[2], 0.0, -a[0])
    else:
        side = (-a[1], a[0], 0.0)
    return scaled(1.0 / sqrt(dot(side, side)), side)
