"""Laws whose curve comes from a solver: one master curve a dimensionless number, tabulated, read like a table.

The curve is f(U) with U the approach over σ; it depends on one number A (N_H of Yip & Venart, μ of Greenwood & Tripp).
Gaussian tails never stop touching, so the curve needs a start. It is followed down to the seating load, a share of
E* √R σ^1.5, and continued below it as P ∝ δ^1.5 with the same force and stiffness there [our derivation]: overlap 0 is
where that ends. The stiffness at equal Hertz-equivalent overlap is at most Hertz's, so the law is nowhere stiffer than Hertz.
"""

import functools
import math
from typing import NamedTuple

import numpy as np

from demlaws.core.curve import read_curve, scale_table
from demlaws.core.dispatch import bind
from demlaws.core.fastmath import hertz_coefficient, hertz_overlap, kernel, sqrt
from demlaws.core.grid import Nodes, grid, shape_from_nodes
from demlaws.core.table_types import Grid, TableShape
from demlaws.errors import DemlawsError
from demlaws.laws.definition import Limit
from demlaws.laws.hertz import HertzShape

SEATING_SHARE = 0.0025
"""Default seating load over E* √R σ^1.5: 0.02 N, the resolution of the load cell, in the granite tests."""
_BITS = 6  # cells per octave: the table reproduces the solver's curve to 1e-6 in force
_LOWEST_FORCE, _HIGHEST_FORCE = 1e-8, 1e7  # dimensionless; from the Gaussian tail to α = 3e-5, practically Hertz
SMOOTH = 1e-9
"""σ/R below which the model is its limit, Hertz: roughness then shifts the overlap by some 1e-9 R."""
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(8)


class CurveNumber(NamedTuple):
    """A = factor (E*)^modulus R^radius σ^roughness: the number on which the curve of a contact depends."""

    factor: float
    modulus: float
    radius: float
    roughness: float


class ImplicitShape(NamedTuple):
    """One master curve, for contacts that share A."""

    table: TableShape
    number: CurveNumber
    value: float  # A of the curve


class FamilyShape(NamedTuple):
    """Master curves at a geometric sequence of A, for contacts that differ."""

    grid: Grid  # of every curve; its cells are those of all curves, one after the other
    number: CurveNumber
    lowest_value: float  # A of the first curve
    log_ratio: float  # ln of the ratio of neighbours
    curves: int


class FamilyParams(NamedTuple):
    """One contact between two master curves: s = (1 - w) s_row + w s_(row + 1) at equal approach past a common load."""

    hertz_coefficient: float
    length: float
    inverse_length: float
    offset: float
    row: float  # where the cells of the curve below begin (a whole number)
    weight: float  # w
    grid: Grid


def shared_grid(shapes):
    """Grid of the curves of these TableShapes, which have one grid: its cells are theirs, one after the other."""
    cells = np.ascontiguousarray(np.concatenate([shape.grid.cells for shape in shapes]))
    return shapes[0].grid._replace(cells=cells)


@kernel
def curve_number(law, radius, modulus, roughness):
    """A of a contact."""
    return law.factor * modulus**law.modulus * radius**law.radius * roughness**law.roughness


@kernel
def _scale(shape, radius, modulus, roughness):
    value = curve_number(shape.number, radius, modulus, roughness)
    # A contact with another number has another curve: not a number rather than a wrong one.
    same = abs(value - shape.value) <= 1e-6 * shape.value
    return scale_table(shape.table, radius, modulus, roughness, 0.0 if same else math.nan)


@kernel
def family_params(grid, coefficient, length, offset, row, weight):
    """FamilyParams of a contact, returned by `scale` of a family or of a set of rows."""
    return FamilyParams(coefficient, length, 1.0 / length, offset, row, weight, grid)


@kernel
def _family_scale(shape, radius, modulus, roughness):
    place = math.log(curve_number(shape.number, radius, modulus, roughness) / shape.lowest_value) / shape.log_ratio
    inside = -1e-9 <= place <= shape.curves - 1 + 1e-9
    row = min(max(math.floor(place), 0.0), shape.curves - 2.0)
    coefficient, start = hertz_coefficient(radius, modulus), row * shape.grid.count
    return family_params(shape.grid, coefficient, roughness, 0.0 if inside else math.nan, start, place - row)


@kernel
def _family_read(p, u):
    row = int(p.row)
    s0, slope0 = read_curve(p.grid, u, row)
    s1, slope1 = read_curve(p.grid, u, row + p.grid.count)
    return s0 + p.weight * (s1 - s0), slope0 + p.weight * (slope1 - slope0)


@kernel
def _family_virgin(p, overlap):
    s, slope = _family_read(p, overlap * p.inverse_length + p.offset)
    equivalent = s * p.length
    root = p.hertz_coefficient * sqrt(equivalent)
    return root * equivalent, 1.5 * root * slope, equivalent, equivalent


@kernel
def _family_invert(p, s):
    """u at which the blended curve reaches s: bisection, then Newton; NaN above the table."""
    low = 0.0
    high = p.grid.highest
    if not (s <= _family_read(p, high)[0]):
        return math.nan
    u = 0.5 * high
    for _ in range(200):
        value, slope = _family_read(p, u)
        if value > s:
            high = u
        else:
            low = u
        new = u - (value - s) / slope
        if not (low < new < high):
            new = 0.5 * (low + high)
        last = abs(new - u) <= 1e-14 * new
        u = new
        if last:
            break
    return u


@kernel
def _family_inverse(p, force):
    u = _family_invert(p, hertz_overlap(p, force) * p.inverse_length)
    return max((u - p.offset) * p.length, 0.0) if u == u else u


@kernel
def _family_energy(p, overlap):
    """Gauss's rule on panels a thirty-second of an octave wide or narrower, cut where the cells are."""
    top = overlap * p.inverse_length + p.offset
    u = p.offset
    total = 0.0
    while u < top:
        end = min(u + max(u, p.grid.lowest) / 64.0, top)
        half = 0.5 * (end - u)
        for k in range(_NODES.size):
            s, _ = _family_read(p, u + half * (1.0 + _NODES[k]))
            total += half * _WEIGHTS[k] * s * sqrt(s)
        u = end
    return p.hertz_coefficient * p.length * p.length * sqrt(p.length) * total


bind(ImplicitShape, scale=_scale)
bind(FamilyShape, scale=_family_scale)
bind(FamilyParams, virgin=_family_virgin, inverse=_family_inverse, energy=_family_energy)


def seating_limit(contact, share):
    """`Limit` below the seating load, the largest of an array of contacts."""
    load = share * contact.modulus * np.sqrt(contact.radius) * np.asarray(contact.roughness) ** 1.5
    reason = "below the seating load the curve is not the source's: it is continued as P ∝ δ^1.5 (see seating_share)"
    return Limit(float(np.max(load)), math.inf, reason)


@functools.lru_cache(maxsize=64)
def _solve(model, value):
    from demlaws.solvers.axisymmetric import curve

    return curve(model, value)


@functools.lru_cache(maxsize=64)
def _curve_shape(model, value, share, lowest, highest):
    """The curve as a table in the overlap over σ: straight in s, as P ∝ δ^1.5, to the seat, then the solver's."""
    solved = _solve(model, value)
    seat, equivalent, slope = _seat(model, value, share)
    u, _ = grid(lowest, highest, [], _BITS)
    s, slopes = solved.hertz_overlap(np.maximum(u - equivalent / slope, 0.0) + seat)
    below = u * slope < equivalent
    return shape_from_nodes(Nodes.from_curve(u, np.where(below, slope * u, s), np.where(below, slope, slopes)), _BITS, 1.0, 0.0)


@functools.lru_cache(maxsize=64)
def _seat(model, value, share):
    """U, s and ds/dU of a curve at the seating load."""
    solved = _solve(model, value)
    approach = solved.approach(share)
    return tuple(float(v) for v in (approach, *solved.hertz_overlap(approach)))


def prepare(model, law, contact, seating_share, rtol):
    """Shape of an implicit law: one curve if the contacts share A, else a family that blends within `rtol`.

    Contacts smoother than SMOOTH get the Hertz law, to which the model tends.
    """
    share = seating_share
    radius, modulus, roughness = (np.asarray(v, float) for v in (contact.radius, contact.modulus, contact.roughness))
    smooth = roughness < SMOOTH * radius
    if np.all(smooth):
        return HertzShape()
    if np.any(smooth):
        raise DemlawsError(
            f"{int(np.sum(smooth))} contacts are smooth (σ below {SMOOTH:g} R): give them law 'hertz', the others law {model!r}"
        )
    numbers = law.factor * modulus**law.modulus * radius**law.radius * roughness**law.roughness
    low, high = float(np.min(numbers)), float(np.max(numbers))
    values = [low]
    if high > low * (1.0 + 1e-9):
        from demlaws.solvers.axisymmetric import family

        values = [float(v) for v in family(model, low, high, rtol=rtol, reference_force=share)]
    seats = [_seat(model, value, share) for value in values]
    lowest = min(equivalent / slope for _, equivalent, slope in seats)
    end = float(_solve(model, values[0]).approach(_HIGHEST_FORCE)) - seats[0][0]
    highest = max(end, float(np.max(0.1 * radius / roughness)))
    shapes = [_curve_shape(model, value, share, lowest, highest) for value in values]
    if len(shapes) == 1:
        return ImplicitShape(shapes[0], law, low)
    ratio = math.log(values[-1] / values[0]) / (len(values) - 1)
    return FamilyShape(shared_grid(shapes), law, values[0], ratio, len(values))
