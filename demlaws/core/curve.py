"""Look-up of a dimensionless curve on a bit-indexed semi-logarithmic grid.

With u = δ/length and f = P/(E* √R length^1.5) a table holds s(u) = (3f/4)^(2/3), the Hertz-equivalent overlap, as one
cubic per cell. Then f = (4/3) s^1.5, df/du = 2 √s ds/du and the plastic overlap of Hertz unloading is u - s: no power, no
cube root. Each octave of u is cut into 2^bits equal cells, whose number is in the exponent and the top mantissa
bits of u. A cell with a kink is split there, and all cells right of it move up by one.
"""

import math
from typing import NamedTuple

import numpy as np
from numba.extending import overload

from demlaws.core.dispatch import bind, scale, with_pointers
from demlaws.core.fastmath import bits, from_bits, hertz_coefficient, hertz_overlap, read_only, row_of_four, sqrt
from demlaws.core.numba_compat import INLINED, kernel, loop
from demlaws.core.table_types import Grid, TableParams, TableShape
from demlaws.core.unloading import energy_within, first_loading_within, inverse_within

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(6)


@kernel
def scale_table(shape, radius, modulus, roughness, offset):
    """TableParams of one contact, with an offset in u."""
    length = shape.length_over_roughness * roughness + shape.length_over_radius * radius
    return TableParams(hertz_coefficient(radius, modulus), length, 1.0 / length, offset)


@kernel
def _scale(shape, radius, modulus, roughness):
    return scale_table(shape, radius, modulus, roughness, 0.0)


def count_kinks_below(kinks, u):
    """How many of the kinks lie at or below u: one comparison each, no loop, so that the caller's loop vectorises."""
    return sum(u >= kink for kink in kinks)


@overload(count_kinks_below, jit_options=INLINED)
def _count_kinks_below(kinks, u):
    return eval("lambda kinks, u: " + " + ".join(f"(1 if u >= kinks[{n}] else 0)" for n in range(len(kinks))))


@kernel
def cell_and_place(g, u):
    """Row of the cell that holds u, the place t in it, and the reciprocal of the grid cell's width.

    Beyond the last node: its own. No branch and no integer that could leave the table: the loop vectorises.
    """
    inside = u if u <= g.highest else g.highest
    inside = inside if inside >= g.floor else g.floor
    pattern = bits(inside)
    cell = (pattern >> g.shift) - g.first
    cell += count_kinks_below(g.kinks, inside)
    # the bits below the cell number, moved up, are t as the mantissa of a number in [1, 2)
    t = from_bits(((pattern << (52 - g.shift)) & 0x000FFFFFFFFFFFFF) | 0x3FF0000000000000) - 1.0
    inverse_width = from_bits((2046 << 52) - ((pattern & 0x7FF0000000000000) - ((52 - g.shift) << 52)))
    below = u < g.floor
    cell = 0 if below else cell
    t = u * g.inverse_floor if below else t
    inverse_width = g.inverse_floor if below else inverse_width
    return cell, t, inverse_width


@kernel
def read_curve(g, u, row):
    """s(u) ≥ 0 and ds/du of the curve whose cells begin at `row`; s is NaN above the last node and where u is NaN."""
    cell, t, inverse_width = cell_and_place(g, u)
    c0, c1, c2, c3 = row_of_four(g.cells, cell + row)
    s = c0 + t * (c1 + t * (c2 + t * c3))
    slope = (c1 + t * (2.0 * c2 + t * (3.0 * c3))) * inverse_width
    return s if u <= g.highest else math.nan, slope


@kernel
def _first_loading(shape, p, overlap):
    u = overlap * p.inverse_length + p.offset
    s, slope = read_curve(shape.grid, u, 0)
    equivalent = s * p.length
    root = p.hertz_coefficient * sqrt(equivalent)
    bulk = shape.bulk
    more = bulk.slope * (s * sqrt(s) - bulk.area * sqrt(bulk.area))
    area = (bulk.area + more) * p.length if s > bulk.area else equivalent
    return root * equivalent, 1.5 * root * slope, equivalent, area


@kernel
def _rows_below(g):
    """Rows of `cells` before the first node's."""
    return g.count - g.starts.shape[0] - 1


@kernel
def invert_curve(g, s):
    """u at which the curve reaches s: bisection over cells, then Newton inside the cell; NaN above the last node."""
    starts = g.starts
    if not (s <= g.cells[g.count - 1, 0] * (1.0 + 1e-12)):
        return math.nan
    below = _rows_below(g)
    t_low = 0.0
    if s >= starts[0, 1]:
        low = 0
        high = starts.shape[0]
        while high - low > 1:
            middle = (low + high) // 2
            if starts[middle, 1] <= s:
                low = middle
            else:
                high = middle
        t_low = starts[low, 0]
        base = starts[low, 3]
        width = starts[low, 4]
        low += below
    else:
        low = 0
        high = below
        while high - low > 1:
            middle = (low + high) // 2
            if g.cells[middle, 0] <= s:
                low = middle
            else:
                high = middle
        base = from_bits((g.first + low) << g.shift) if low > 0 else 0.0
        width = from_bits((g.first + low + 1) << g.shift) - base if low > 0 else g.floor
    c0, c1, c2, c3 = row_of_four(g.cells, low)
    t_high = 1.0
    t = 0.5 * (t_low + t_high)
    for _ in range(80):
        value = c0 + t * (c1 + t * (c2 + t * c3)) - s
        if value > 0.0:
            t_high = t
        else:
            t_low = t
        slope = c1 + t * (2.0 * c2 + t * (3.0 * c3))
        new = t - value / slope if slope > 0.0 else 0.5 * (t_low + t_high)
        if not (t_low <= new <= t_high):
            new = 0.5 * (t_low + t_high)
        if abs(new - t) <= 1e-17 or t_high - t_low <= 1e-16:
            t = new
            break
        t = new
    return min(base + width * t, g.highest)


@kernel
def _inverse(shape, p, force):
    u = invert_curve(shape.grid, hertz_overlap(p, force) * p.inverse_length)
    return max((u - p.offset) * p.length, 0.0) if u == u else u


@kernel
def integrate_curve(g, u):
    """∫f du from 0 to u."""
    if u <= 0.0:
        return 0.0
    s, _ = read_curve(g, u, 0)
    if u < g.lowest and g.seat > 0.0:
        total = 0.0
        for k in range(_NODES.size):
            y = g.seat + 0.5 * (1.0 + _NODES[k]) * (s - g.seat)
            total += _WEIGHTS[k] * y * sqrt(y)
        return 2.0 / 3.0 * u * total
    if u < g.lowest:
        return 4.0 / 3.0 * s * sqrt(s) * u / (1.5 * g.exponent + 1.0)
    cell, t, inverse_width = cell_and_place(g, u)
    c0, c1, c2, c3 = row_of_four(g.cells, cell)
    begin = cell - _rows_below(g)
    if begin >= g.starts.shape[0]:  # the last node is the end of the last cell
        begin = g.starts.shape[0] - 1
        c0, c1, c2, c3 = row_of_four(g.cells, cell - 1)
        t = 1.0
        inverse_width = 1.0 / g.starts[begin, 4]
    start = g.starts[begin, 0]
    half = 0.5 * (t - start)
    total = 0.0
    for k in range(_NODES.size):
        x = start + half * (1.0 + _NODES[k])
        y = c0 + x * (c1 + x * (c2 + x * c3))
        total += _WEIGHTS[k] * y * sqrt(y)
    return g.starts[begin, 2] + 4.0 / 3.0 * total * half / inverse_width


@kernel
def _energy(shape, p, overlap):
    more = overlap * p.inverse_length
    if more < 1e-3 * p.offset:  # far below a seat the difference of two energies would cancel
        half = 0.5 * more
        scaled = 0.0
        for k in range(_NODES.size):
            s, _ = read_curve(shape.grid, p.offset + half * (1.0 + _NODES[k]), 0)
            scaled += half * _WEIGHTS[k] * 4.0 / 3.0 * s * sqrt(s)
    else:
        scaled = integrate_curve(shape.grid, more + p.offset) - integrate_curve(shape.grid, p.offset)
    return 0.75 * p.hertz_coefficient * p.length * p.length * sqrt(p.length) * scaled


@kernel
def _grid_with_pointers(g):
    """A grid whose cells are a `read_only` pointer, as are the parts that `inverse` and `energy` need: for `first_loading`."""
    place = g.shift, g.first, g.kinks, g.lowest, g.highest, g.floor, g.inverse_floor, g.exponent, g.seat, g.count
    return Grid(read_only(g.cells), read_only(g.starts), *place)


bind(Grid, with_pointers=_grid_with_pointers)
bind(TableShape, scale=_scale)
bind(TableParams, first_loading=_first_loading, inverse=_inverse, energy=_energy)


class CurveShape(NamedTuple):
    """A table to unload along: the curve s(u) and its reverse, u as a curve of s less the seat, on a grid of the same kind."""

    loading: TableShape
    reverse: TableShape


class CurveParams(NamedTuple):
    """One contact."""

    hertz_coefficient: float
    loading: TableParams


@kernel
def _curve_scale(shape, radius, modulus, roughness):
    loading = scale(shape.loading, radius, modulus, roughness)
    return CurveParams(loading.hertz_coefficient, loading)


@kernel
def _curve_inverse_near(shape, p, force, equivalent):
    """One look-up where `inverse` searches; NaN above the last node of the reverse."""
    above = equivalent * p.loading.inverse_length - shape.loading.grid.seat
    u, _ = read_curve(shape.reverse.grid, 0.0 if above <= 0.0 else above, 0)
    highest = shape.loading.grid.highest
    return (highest if u > highest else u) * p.loading.length


@kernel
def _curve_to_invert(shape):
    return with_pointers(shape)


bind(CurveShape, scale=_curve_scale, with_pointers_to_invert=_curve_to_invert)
bind(
    CurveParams,
    first_loading=first_loading_within,
    inverse=inverse_within,
    inverse_near=_curve_inverse_near,
    energy=energy_within,
)


@loop
def invert_loop(g, s, u):
    """u [-] where curve g has the Hertz-equivalent overlap s, entry by entry, into `u`."""
    for i in range(s.size):
        u[i] = invert_curve(g, s[i])


@loop
def _read_loop(g, u, s, slope):
    for i in range(u.size):
        s[i], slope[i] = read_curve(g, u[i], 0)


def read(g, u):
    """s and ds/du at an array of u."""
    s, slope = np.empty(u.size), np.empty(u.size)
    _read_loop(g, u, s, slope)
    return s, slope
