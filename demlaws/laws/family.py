"""Laws whose curve comes from a solver: one master curve a dimensionless number, tabulated, read like a table.

The curve is f(U) with U the approach over σ; it depends on one number A (N_H of Yip & Venart, μ of Greenwood & Tripp).
Gaussian tails never stop touching, so overlap 0 is declared: it is where the contact carries the seating load. At
overlap 0+ the force is the seating load, not 0; a smaller seating load starts more softly.
"""

import functools
import math
from typing import NamedTuple

import numpy as np

from demlaws.core.curve import Grid, TableShape, invert_curve, read_curve, scale_table
from demlaws.core.dispatch import bind
from demlaws.core.fastmath import kernel, sqrt
from demlaws.core.grid import Nodes, grid, shape_from_nodes
from demlaws.core.hertz import hertz_coefficient, hertz_overlap
from demlaws.errors import DemlawsError
from demlaws.laws.hertz import HertzShape
from demlaws.units import number

SEATING_LOAD = 0.02
"""Default seating load [N]: the resolution of the load cell of the granite tests."""
_BITS = 6  # cells an octave: the table reproduces the solver's curve to 1e-6 in force
_LOWEST_FORCE, _HIGHEST_FORCE = 1e-8, 1e7  # dimensionless; from the Gaussian tail to α = 3e-5, practically Hertz
SMOOTH = 1e-9
"""σ/R below which the model is its limit, Hertz: roughness then shifts the overlap by some 1e-9 R."""
_NEARLY_SMOOTH = 1e-6
"""σ/R below which a seating load beyond the curve means Hertz too: the stiffness is within 3e-4 of it there (μ ≥ 4)."""
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(8)


class CurveNumber(NamedTuple):
    """A = factor (E*)^modulus R^radius σ^roughness: what the curve of a contact depends on."""

    factor: float
    modulus: float
    radius: float
    roughness: float


class ImplicitShape(NamedTuple):
    """One master curve, for contacts that share A."""

    table: TableShape
    seating_load: float  # [N]
    number: CurveNumber
    value: float  # A of the curve


class FamilyShape(NamedTuple):
    """Master curves at a geometric sequence of A, for contacts that differ."""

    grid: Grid  # of every curve; its cells are those of all curves, one after the other
    seating_load: float
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
    p = scale_table(shape.table, radius, modulus, roughness, 0.0)
    offset = invert_curve(p.grid, hertz_overlap(p, shape.seating_load) / p.length)
    # A contact with another number has another curve: not a number rather than a wrong one.
    same = abs(value - shape.value) <= 1e-6 * shape.value
    return scale_table(shape.table, radius, modulus, roughness, offset if same else math.nan)


@kernel
def family_params(grid, coefficient, length, offset, row, weight):
    """FamilyParams of a contact: what a family's or a set of rows' `scale` returns."""
    return FamilyParams(coefficient, length, 1.0 / length, offset, row, weight, grid)


@kernel
def _family_scale(shape, radius, modulus, roughness):
    place = math.log(curve_number(shape.number, radius, modulus, roughness) / shape.lowest_value) / shape.log_ratio
    inside = -1e-9 <= place <= shape.curves - 1 + 1e-9
    row = min(max(math.floor(place), 0.0), shape.curves - 2.0)
    coefficient, start = hertz_coefficient(radius, modulus), row * shape.grid.count
    p = family_params(shape.grid, coefficient, roughness, 0.0, start, place - row)
    offset = _family_invert(p, hertz_overlap(p, shape.seating_load) / roughness)
    return family_params(shape.grid, coefficient, roughness, offset if inside else math.nan, start, place - row)


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


def _span(contact, law):
    """Smallest and largest A, largest and smallest E* √R σ^1.5, largest R/σ of the contacts."""
    radius, modulus, roughness = (np.asarray(v, float) for v in (contact.radius, contact.modulus, contact.roughness))
    value = law.factor * modulus**law.modulus * radius**law.radius * roughness**law.roughness
    scale = modulus * np.sqrt(radius) * roughness**1.5
    return tuple(map(float, (np.min(value), np.max(value), np.max(scale), np.min(scale), np.max(radius / roughness))))


@functools.lru_cache(maxsize=64)
def _solve(model, value):
    from demlaws.solvers.axisymmetric import curve

    return curve(model, value)


def _curve_shape(solved, start, lowest, highest):
    """The curve as a table in u = U - start."""
    u, _ = grid(lowest, highest, [], _BITS)
    s, slope = solved.hertz_overlap(u + start)
    return shape_from_nodes(Nodes.from_curve(u, s, slope), _BITS, 1.0, 0.0, straight=True)


def prepare(model, law, contact, seating_load, rtol):
    """Shape of an implicit law: one curve if the contacts share A, else a family that blends within `rtol`.

    Contacts smoother than SMOOTH, or so smooth that they are practically Hertz from their seating load on, get the
    Hertz law, to which the model tends.
    """
    load = number(seating_load, "seating_load", "N")
    radius, roughness = np.asarray(contact.radius), np.asarray(contact.roughness)
    seated_as_hertz = load > 0.1 * _HIGHEST_FORCE * contact.modulus * np.sqrt(radius) * roughness**1.5
    smooth = (roughness < SMOOTH * radius) | (seated_as_hertz & (roughness < _NEARLY_SMOOTH * radius))
    if np.all(smooth):
        return HertzShape()
    if np.any(smooth):
        raise DemlawsError(
            f"{int(np.sum(smooth))} contacts are so smooth that they are Hertz's from {load:g} N on: "
            f"give them law 'hertz', the others law {model!r}"
        )
    low, high, largest_scale, smallest_scale, relative_radius = _span(contact, law)
    softest = load / largest_scale
    if load / smallest_scale > 0.1 * _HIGHEST_FORCE or softest < 8.0 * _LOWEST_FORCE:
        raise DemlawsError(
            f"seating_load = {load:g} N: for these contacts it must lie between "
            f"{8.0 * _LOWEST_FORCE * largest_scale:.2g} and {0.1 * _HIGHEST_FORCE * smallest_scale:.2g} N"
        )
    reference = softest / 8.0  # the grid begins before the seat: the power law below its first node is never read
    values = [low]
    if high > low * (1.0 + 1e-9):
        from demlaws.solvers.axisymmetric import family

        values = [float(v) for v in family(model, low, high, rtol=rtol, reference_force=reference).parameters]
    curves = [_solve(model, value) for value in values]
    starts = [float(c.approach(reference)) for c in curves]
    lowest = 0.5 * min(float(c.approach(softest)) - start for c, start in zip(curves, starts, strict=True))
    highest = max(float(curves[0].approach(_HIGHEST_FORCE)) - starts[0], 0.1 * relative_radius)
    shapes = [_curve_shape(c, start, lowest, highest) for c, start in zip(curves, starts, strict=True)]
    if len(shapes) == 1:
        return ImplicitShape(shapes[0], load, law, low)
    ratio = math.log(values[-1] / values[0]) / (len(values) - 1)
    return FamilyShape(shared_grid(shapes), load, law, values[0], ratio, len(values))
