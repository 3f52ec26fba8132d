"""Tables: a law's dimensionless curve on a bit-indexed semi-logarithmic grid, certified, saved as readable text.

With u = δ/length and f = P/(E* √R length^1.5) a table holds s(u) = (3f/4)^(2/3), the Hertz-equivalent overlap, as one
cubic a cell. Then f = (4/3) s^1.5, df/du = 2 √s ds/du and the plastic overlap of Hertz unloading is u - s: no power, no
cube root. Each octave of u is cut into 2^bits equal cells, whose number stands in the exponent and the top mantissa
bits of u. A cell with a kink is split there, and all cells right of it move up by one.
"""

import json
import math
import zlib
from pathlib import Path
from typing import NamedTuple

import numpy as np

from demlaws.contact import Contact
from demlaws.dispatch import bind, energy, virgin
from demlaws.errors import DemlawsError
from demlaws.fastmath import bits, from_bits, kernel, loop, row_of_four, sqrt
from demlaws.files import write_atomically
from demlaws.law import (
    SMOOTHEST,
    Law,
    bind_params,
    evaluate_loop,
    find,
    inverse_loop,
    loading_part,
    one_of,
    rule_and_curve,
    scale_one,
)
from demlaws.laws.hertz import hertz_coefficient, hertz_overlap
from demlaws.unloading import GIVEN, RULES, Elastic, JoinedShape

FORMAT = "# demlaws-table 1"
_TITLES = "overlap force stiffness"
_UNLOADING_TITLES = "unloading overlap force stiffness"
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(6)
_MOST_BITS = 12
_OCTAVES_BELOW = 40
"""Octaves of cells that continue the power law below the first node, so that reading it takes no power."""
_SEATED = 0.5
"""Exponent of s at the first node below which the law starts from a force, not from 0: K ∝ u^(1.5 p - 1) would explode."""


class TableShape(NamedTuple):
    """One dimensionless curve."""

    cells: np.ndarray  # (count, 4): s as a cubic in t, the place in the grid cell from 0 to 1; first those of `_below`
    starts: np.ndarray  # (cells between nodes, 5): t, s, ∫f du where a cell or its part after a kink begins; grid u, width
    shift: int  # 52 - bits
    first: int  # grid number of row 0 of `cells`
    kink1: float  # u of the kinks, infinity where there is none
    kink2: float
    lowest: float  # u of the first node
    highest: float  # u of the last node
    floor: float  # u where the cells below the first node begin; linear to 0 from there
    inverse_floor: float
    exponent: float  # of the power law below the first node
    yield_overlap: float  # u above which the bulk has yielded (infinity: never): there the contact radius follows
    yield_area: float  # a²/(R length) = yield_area + yield_area_slope (s^1.5 - yield_area^1.5)
    yield_area_slope: float
    length_over_roughness: float  # length = this σ + the next R
    length_over_radius: float
    count: int  # rows of `cells`


class TableParams(NamedTuple):
    """One contact."""

    hertz_coefficient: float  # (4/3) E* √R [N/m^1.5]
    length: float  # [m]
    inverse_length: float  # [1/m]
    offset: float  # added to u before the curve is read: 0, but for laws with a seating load
    cells: np.ndarray
    starts: np.ndarray
    shift: int
    first: int
    kink1: float
    kink2: float
    lowest: float
    highest: float
    floor: float
    inverse_floor: float
    exponent: float
    yield_overlap: float
    yield_area: float
    yield_area_slope: float
    count: int


@kernel
def scale_table(shape, radius, modulus, roughness, offset):
    """TableParams of one contact, with an offset in u."""
    length = shape.length_over_roughness * roughness + shape.length_over_radius * radius
    return TableParams(
        hertz_coefficient(radius, modulus),
        length,
        1.0 / length,
        offset,
        shape.cells,
        shape.starts,
        shape.shift,
        shape.first,
        shape.kink1,
        shape.kink2,
        shape.lowest,
        shape.highest,
        shape.floor,
        shape.inverse_floor,
        shape.exponent,
        shape.yield_overlap,
        shape.yield_area,
        shape.yield_area_slope,
        shape.count,
    )


@kernel
def _scale(shape, radius, modulus, roughness):
    return scale_table(shape, radius, modulus, roughness, 0.0)


@kernel
def cell_and_place(p, u):
    """Row of the cell that holds u, the place t in it, and the reciprocal of the grid cell's width.

    Beyond the last node: its own. No branch and no integer that could leave the table: the loop vectorises.
    """
    inside = u if u <= p.highest else p.highest
    inside = inside if inside >= p.floor else p.floor
    pattern = bits(inside)
    cell = (pattern >> p.shift) - p.first
    cell += (1 if inside >= p.kink1 else 0) + (1 if inside >= p.kink2 else 0)
    # the bits below the cell number, moved up, are t as the mantissa of a number in [1, 2)
    t = from_bits(((pattern << (52 - p.shift)) & 0x000FFFFFFFFFFFFF) | 0x3FF0000000000000) - 1.0
    inverse_width = from_bits(((2046 + 52 - p.shift) << 52) - (pattern & 0x7FF0000000000000))
    below = u < p.floor
    cell = 0 if below else cell
    t = u * p.inverse_floor if below else t
    inverse_width = p.inverse_floor if below else inverse_width
    return cell, t, inverse_width


@kernel
def read_curve(p, u, row):
    """s(u) ≥ 0 and ds/du of the curve whose cells begin at `row`; s is NaN above the last node and where u is NaN."""
    cell, t, inverse_width = cell_and_place(p, u)
    c0, c1, c2, c3 = row_of_four(p.cells, cell + row)
    s = c0 + t * (c1 + t * (c2 + t * c3))
    slope = (c1 + t * (2.0 * c2 + t * (3.0 * c3))) * inverse_width
    return s if u <= p.highest else math.nan, slope


@kernel
def _virgin(p, overlap):
    u = overlap * p.inverse_length + p.offset
    s, slope = read_curve(p, u, 0)
    equivalent = s * p.length
    root = p.hertz_coefficient * sqrt(equivalent)
    more = p.yield_area_slope * (s * sqrt(s) - p.yield_area * sqrt(p.yield_area))
    area = (p.yield_area + more) * p.length if u > p.yield_overlap else equivalent
    return root * equivalent, 1.5 * root * slope, equivalent, area


@kernel
def _rows_below(p):
    """Rows of `cells` before the first node's."""
    return p.count - p.starts.shape[0] - 1


@kernel
def invert_curve(p, s):
    """u at which the curve reaches s: bisection over cells, then Newton inside the cell; NaN above the last node."""
    starts = p.starts
    if not (s <= p.cells[p.count - 1, 0] * (1.0 + 1e-12)):
        return math.nan
    below = _rows_below(p)
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
            if p.cells[middle, 0] <= s:
                low = middle
            else:
                high = middle
        base = from_bits((p.first + low) << p.shift) if low > 0 else 0.0
        width = from_bits((p.first + low + 1) << p.shift) - base if low > 0 else p.floor
    c0, c1, c2, c3 = row_of_four(p.cells, low)
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
    return min(base + width * t, p.highest)


@kernel
def _inverse(p, force):
    u = invert_curve(p, hertz_overlap(p, force) * p.inverse_length)
    return max((u - p.offset) * p.length, 0.0) if u == u else u


@kernel
def integrate_curve(p, u):
    """∫f du from 0 to u."""
    if u <= 0.0:
        return 0.0
    s, _ = read_curve(p, u, 0)
    if u < p.lowest and p.exponent < _SEATED:
        seat = p.starts[0, 1] * (1.0 - p.exponent)
        total = 0.0
        for k in range(_NODES.size):
            y = seat + 0.5 * (1.0 + _NODES[k]) * (s - seat)
            total += _WEIGHTS[k] * y * sqrt(y)
        return 2.0 / 3.0 * u * total
    if u < p.lowest:
        return 4.0 / 3.0 * s * sqrt(s) * u / (1.5 * p.exponent + 1.0)
    cell, t, inverse_width = cell_and_place(p, u)
    c0, c1, c2, c3 = row_of_four(p.cells, cell)
    begin = cell - _rows_below(p)
    if begin >= p.starts.shape[0]:  # the last node is the end of the last cell
        begin = p.starts.shape[0] - 1
        c0, c1, c2, c3 = row_of_four(p.cells, cell - 1)
        t = 1.0
        inverse_width = 1.0 / p.starts[begin, 4]
    start = p.starts[begin, 0]
    half = 0.5 * (t - start)
    total = 0.0
    for k in range(_NODES.size):
        x = start + half * (1.0 + _NODES[k])
        y = c0 + x * (c1 + x * (c2 + x * c3))
        total += _WEIGHTS[k] * y * sqrt(y)
    return p.starts[begin, 2] + 4.0 / 3.0 * total * half / inverse_width


@kernel
def _energy(p, overlap):
    more = overlap * p.inverse_length
    if more < 1e-3 * p.offset:  # far below a seat the difference of two energies would cancel
        half = 0.5 * more
        scaled = 0.0
        for k in range(_NODES.size):
            s, _ = read_curve(p, p.offset + half * (1.0 + _NODES[k]), 0)
            scaled += half * _WEIGHTS[k] * 4.0 / 3.0 * s * sqrt(s)
    else:
        scaled = integrate_curve(p, more + p.offset) - integrate_curve(p, p.offset)
    return 0.75 * p.hertz_coefficient * p.length * p.length * sqrt(p.length) * scaled


bind(TableShape, scale=_scale)
bind(TableParams, virgin=_virgin, inverse=_inverse, energy=_energy)


class CurveShape(NamedTuple):
    """A table to unload along: the curve s(u) and its reverse, u as a curve of s less the seat, on a grid of the same kind."""

    curve: TableShape
    reverse: TableShape
    seat: float  # s at u = 0+: 0, but for curves that begin with a seating load


class CurveParams(NamedTuple):
    """One contact."""

    hertz_coefficient: float
    curve: TableParams
    reverse: TableParams
    seat: float


@kernel
def _curve_scale(shape, radius, modulus, roughness):
    curve = scale_table(shape.curve, radius, modulus, roughness, 0.0)
    reverse = scale_table(shape.reverse, radius, modulus, roughness, 0.0)
    return CurveParams(curve.hertz_coefficient, curve, reverse, shape.seat)


@kernel
def _curve_virgin(p, overlap):
    return virgin(p.curve, overlap)


@kernel
def _curve_inverse(p, force):
    return _inverse(p.curve, force)


@kernel
def _curve_energy(p, overlap):
    return energy(p.curve, overlap)


@kernel
def _curve_recover(p, force, equivalent):
    """One look-up where `inverse` searches; NaN above the last node of the reverse."""
    above = equivalent * p.curve.inverse_length - p.seat
    u, _ = read_curve(p.reverse, 0.0 if above <= 0.0 else above, 0)
    return (p.curve.highest if u > p.curve.highest else u) * p.curve.length


bind(CurveShape, scale=_curve_scale)
bind(CurveParams, virgin=_curve_virgin, inverse=_curve_inverse, recover=_curve_recover, energy=_curve_energy)


@loop
def _invert_loop(p, s, u):
    for i in range(s.size):
        u[i] = invert_curve(p, s[i])


@loop
def _read_loop(p, u, s, slope):
    for i in range(u.size):
        s[i], slope[i] = read_curve(p, u[i], 0)


def _read(p, u):
    """s and ds/du at an array of u."""
    s, slope = np.empty(u.size), np.empty(u.size)
    _read_loop(p, u, s, slope)
    return s, slope


# --- building


def node_number(u, bits_per_octave):
    """Number of the grid cell that holds u."""
    return int(np.float64(u).view(np.int64)) >> (52 - bits_per_octave)


def node(number, bits_per_octave):
    """u at which the grid cell of this number begins."""
    return np.asarray(np.asarray(number, dtype=np.int64) << (52 - bits_per_octave)).view(np.float64)


class Nodes(NamedTuple):
    """Rows of a table: u, f, df/du; a kink is two rows with one u, left and right stiffness."""

    u: np.ndarray
    force: np.ndarray
    stiffness: np.ndarray

    @classmethod
    def from_curve(cls, u, s, slope):
        """From the Hertz-equivalent overlap s(u) and its slope."""
        return cls(u, 4.0 / 3.0 * s * np.sqrt(s), 2.0 * np.sqrt(s) * slope)

    @property
    def kinks(self):
        """u of the kinks."""
        return self.u[:-1][np.diff(self.u) == 0.0]

    def curve(self):
        """u, s, ds/du: what the cells interpolate."""
        s = np.cbrt(0.75 * self.force) ** 2
        return self.u, s, self.stiffness / (2.0 * np.sqrt(s))


def grid(lowest, highest, kinks, bits_per_octave):
    """Node positions from the grid cell that holds `lowest` to the end of the one that holds `highest`; kinks twice."""
    first, last = node_number(lowest, bits_per_octave), node_number(highest, bits_per_octave) + 1
    u = node(np.arange(first, last + 1), bits_per_octave)
    inside = [k for k in kinks if u[0] < k < u[-1]]
    extra = [k for k in inside if k not in u]
    u = np.sort(np.concatenate([u, inside, extra]))
    return u, inside


def _hermite(t0, t1, width, s0, s1, slope0, slope1):
    """Coefficients in t of the cubics that have values s0, s1 and slopes ds/du at t0, t1 of cells of this width in u."""
    # in r = (t - t0)/h, then expanded in t
    h = t1 - t0
    b, end, rise = slope0 * width * h, slope1 * width * h, s1 - s0
    sliver = h < 1e-3  # a part beside a kink so narrow that a cubic through it would be rounding noise
    c = np.where(sliver, 0.5 * (end - b), 3.0 * rise - 2.0 * b - end)
    d = np.where(sliver, 0.0, b + end - 2.0 * rise)
    b, c, d = b / h, c / h**2, d / h**3
    return np.column_stack([s0 - b * t0 + c * t0**2 - d * t0**3, b - 2.0 * c * t0 + 3.0 * d * t0**2, c - 3.0 * d * t0, d])


def _below(u0, s0, exponent, first, bits_per_octave, seated, floor):
    """Rows of cells below the first node and the u where they begin: one linear from 0, then the power law s0 (u/u0)^p.

    floor: s about where the power law ends, or None: 40 octaves of u down. A curve that starts from a seating load (p near
    0) goes on straight, with the slope of the first node.
    """
    octaves = _OCTAVES_BELOW if floor is None or seated else max(1.0, math.log2(s0 / floor) / exponent)
    u = node(np.arange(first - round(octaves * 2**bits_per_octave), first + 1), bits_per_octave)
    if seated:
        seat, slope = s0 * (1.0 - exponent), exponent * s0 / u0
        width = np.append(u[0], np.diff(u))  # the slope as it is: differences of s would be nothing but rounding here
        none = np.zeros(u.size)
        return np.column_stack([seat + slope * np.append(0.0, u[:-1]), slope * width, none, none]), float(u[0])
    s = s0 * (u / u0) ** exponent
    slope = exponent * s / u
    cells = _hermite(0.0, 1.0, np.diff(u), s[:-1], s[1:], slope[:-1], slope[1:])
    return np.concatenate([[[0.0, s[0], 0.0, 0.0]], cells]), float(u[0])


def shape_from_nodes(
    nodes, bits_per_octave, length_over_roughness, length_over_radius, bulk_yield=(math.inf, 0.0, 0.0), seated=None, floor=None
):
    """Cubic Hermite cells through the rows of a table; bulk_yield: see TableShape.yield_overlap and what follows it.

    seated: whether the curve starts from a seating load, None to decide by the exponent of the first node; floor: see `_below`.
    """
    u, s, slope = nodes.curve()
    shift = 52 - bits_per_octave
    kinks = u[:-1][np.diff(u) == 0.0]
    keep = np.diff(u) > 0.0
    left, right = np.flatnonzero(keep), np.flatnonzero(keep) + 1
    numbers = u[left].view(np.int64) >> shift
    base = (numbers << shift).view(np.float64)
    width = ((numbers + 1) << shift).view(np.float64) - base
    t0, t1 = (u[left] - base) / width, (u[right] - base) / width
    exponent = float(u[0] * slope[0] / s[0])
    cells = _hermite(t0, t1, width, s[left], s[right], slope[left], slope[right])
    x = 0.5 * (t0 + t1)[:, None] + 0.5 * (t1 - t0)[:, None] * _NODES
    y = cells[:, :1] + x * (cells[:, 1:2] + x * (cells[:, 2:3] + x * cells[:, 3:4]))
    pieces = 4.0 / 3.0 * (np.maximum(y, 0.0) ** 1.5 @ _WEIGHTS) * 0.5 * (t1 - t0) * width
    below = 4.0 / 3.0 * s[0] ** 1.5 * u[0] / (1.5 * exponent + 1.0)
    if exponent < _SEATED:
        line = s[0] * (1.0 + exponent * (0.5 * (1.0 + _NODES) - 1.0))
        below = 2.0 / 3.0 * float(line**1.5 @ _WEIGHTS) * u[0]
    energy = below + np.concatenate([[0.0], np.cumsum(pieces)[:-1]])
    # a kink that lies on the grid splits no cell: the cells on either side have their own slopes there
    pair = [*(float(k) for k in kinks if k.view(np.int64) & ((1 << shift) - 1)), math.inf, math.inf]
    seated = exponent < _SEATED if seated is None else seated
    below, floor = _below(u[0], s[0], exponent, int(numbers[0]), bits_per_octave, seated, floor)
    end = slope[-1] * float(node(numbers[-1] + 2, bits_per_octave) - u[-1])
    cells = np.concatenate([below, cells, [[s[-1], end, 0.0, 0.0]]])  # the last row is read at the last node only
    return TableShape(
        cells,
        np.ascontiguousarray(np.column_stack([t0, s[left], energy, base, width])),
        shift,
        int(numbers[0]) - below.shape[0],
        pair[0],
        pair[1],
        float(u[0]),
        float(u[-1]),
        floor,
        1.0 / floor,
        exponent,
        *map(float, bulk_yield),
        float(length_over_roughness),
        float(length_over_radius),
        cells.shape[0],
    )


class Source(NamedTuple):
    """A curve to tabulate: Params of one contact, and the scales of the table."""

    params: tuple
    length: float  # [m]
    hertz_coefficient: float  # [N/m^1.5]
    kinks: list  # u
    solved: bool

    def curve(self, u):
        """s(u) and ds/du."""
        force, stiffness = np.empty(u.size), np.empty(u.size)
        evaluate_loop(Elastic(), self.params, u * self.length, (), force, stiffness)
        equivalent = np.cbrt(force / self.hertz_coefficient) ** 2
        return equivalent / self.length, stiffness / (1.5 * self.hertz_coefficient * np.sqrt(equivalent))

    def nodes(self, lowest, highest, bits_per_octave):
        """Rows of the table from `lowest` to `highest` u."""
        u, kinks = grid(lowest, highest, self.kinks, bits_per_octave)
        place = u.copy()
        for kink in kinks:  # one-sided stiffness: just left and just right of the kink
            first, second = np.flatnonzero(u == kink)
            place[first] = kink * (1.0 - 1e-14)
            place[second] = kink * (1.0 + 1e-14)
        s, slope = self.curve(place)
        for kink in kinks:
            second = np.flatnonzero(u == kink)[1]
            if abs(s[second] / s[second - 1] - 1.0) < 1e-10:  # no jump of force: one value for both sides
                s[second] = s[second - 1]
        return Nodes.from_curve(u, s, slope)

    def lowest(self, rtol):
        """Largest u, but at least 2^-30, below which the curve is its own power law within a small part of rtol."""
        u = 2.0 ** np.arange(-30.0, 1.0)
        s, slope = self.curve(u)
        exponent = u * slope / s
        with np.errstate(all="ignore"):
            bend = np.abs(exponent - exponent[0])
        good = np.flatnonzero(bend <= 0.02 * rtol)
        return float(u[good[-1]]) if good.size else float(u[0])

    def certify(self, shape, table):
        """`Certificate` of a table's shape, bound to the contact as `table`."""
        u = np.append(shape.starts[:, 3] + shape.starts[:, 4] * shape.starts[:, 0], shape.highest)
        # where cubics through exact ends err most in value and in slope; closer together for laws that have cells of their own
        fractions = np.unique([0.2113, 0.5, 0.7887, *np.linspace(0.0, 1.0, 32 if self.solved else 12)[1:-1]])
        width = np.diff(u)
        points = (u[:-1, None] + width[:, None] * fractions).ravel() * self.length
        force, stiffness, exact_force, exact_stiffness = (np.empty(points.size) for _ in range(4))
        evaluate_loop(Elastic(), table, points, (), force, stiffness)
        evaluate_loop(Elastic(), self.params, points, (), exact_force, exact_stiffness)
        with np.errstate(divide="ignore", invalid="ignore"):
            errors = np.abs(force / exact_force - 1.0), np.abs(stiffness / exact_stiffness - 1.0)
        return Certificate(float(np.max(errors[0])), float(np.max(errors[1])))


def quick_to_invert(shape, kinks=()):
    """A table's shape with its reverse; any other shape, whose `inverse` is a formula, as it is. kinks: u of the table's."""
    if not isinstance(shape, TableShape):
        return shape
    bits_per_octave = 53 - shape.shift  # finer by a bit, so that one step of Newton's method is exact to rounding
    # the curve in its own units: length 1
    p = scale_one(shape._replace(length_over_roughness=0.0, length_over_radius=1.0), 1.0, 1.0, 0.0)
    highest, seat = float(shape.cells[-1, 0]), 0.0
    lowest = float(shape.cells[0, 1])  # where the curve begins to be straight: the reverse of a straight line is one
    if shape.exponent < _SEATED:
        lowest = float(shape.starts[0, 1])
        seat = lowest * (1.0 - shape.exponent)
    corners = np.array([k for k in kinks if shape.lowest < k < shape.highest])
    last = node_number(highest - seat, bits_per_octave)  # this node and those before it lie on the curve
    end = float(node(last - 1, bits_per_octave))
    y, corners = grid(lowest - seat, end, list(_read(p, corners)[0] - seat), bits_per_octave)
    place = y.copy()
    for corner in corners:
        first, second = np.flatnonzero(y == corner)
        place[first], place[second] = corner * (1.0 - 1e-14), corner * (1.0 + 1e-14)
    u = np.empty(y.size)
    _invert_loop(p, place + seat, u)
    slope = 1.0 / _read(p, u)[1]
    for corner in corners:
        first, second = np.flatnonzero(y == corner)
        u[second] = u[first]
    nodes = Nodes.from_curve(y, u, slope)
    reverse = shape_from_nodes(nodes, bits_per_octave, 0.0, 0.0, seated=seat > 0.0, floor=float(u[0]))
    lengths = {"length_over_roughness": shape.length_over_roughness, "length_over_radius": shape.length_over_radius}
    return CurveShape(shape, reverse._replace(**lengths), seat)


class Certificate(NamedTuple):
    """Largest relative errors measured between the nodes against the law itself."""

    force_error: float
    stiffness_error: float


def _length(definition, contact):
    """Dimensionless length of a law's table: multiples of σ and of R."""
    smooth = np.all(np.asarray(contact.roughness) <= SMOOTHEST * np.asarray(contact.radius))
    return (0.0, 1.0) if definition.length == "radius" or smooth else (1.0, 0.0)


def tabulate(law, rtol=1e-5, max_force=None):
    """The smallest `Table` of `law` whose force and stiffness lie within `rtol`, measured between the nodes.

    The range ends at the overlap of `max_force` [N] or at a tenth of the radius, and goes down to where the law is a
    power law within `rtol`. A law whose curve collapses gives one table for every radius, modulus and roughness.
    """
    try:
        rtol = float(rtol)
    except (TypeError, ValueError):
        rtol = math.nan
    if not 1e-12 <= rtol <= 0.1:
        raise DemlawsError(f"rtol = {rtol:g}: give a relative tolerance from 1e-12 to 0.1")
    definition, contact = law.definition, law.contact
    _refuse_too_fine(law, rtol)
    if contact.size is not None and not law.collapses:
        raise DemlawsError(
            f"law {law.name!r} has no single dimensionless curve for contacts that differ: tabulate one contact of each kind"
        )
    if law.unloading_law is not None:
        return _join(tabulate(law.joined("elastic"), rtol, max_force), law.unloading_law)
    largest = 0.1 * np.max(np.asarray(contact.radius) / _lengths(definition, contact))
    index, one = _pick(contact)
    over_roughness, over_radius = _length(definition, one)
    roughness = max(one.roughness, SMOOTHEST * one.radius)
    length = over_roughness * roughness + over_radius * one.radius
    if max_force is not None:
        from demlaws.laws.definition import number

        force = number(max_force, "max_force", "N")
        largest = float(np.max(law.overlap(np.broadcast_to(force, contact.size or ()))) / length) * (1.0 + 1e-9)
    params = loading_part(bind_params(law.shape, one))
    kinks = [k / length for k in _kinks_of_one(law, index)]
    source = Source(params, length, params.hertz_coefficient, kinks, definition.solved)
    smallest = min(source.lowest(rtol), largest / 64.0)
    bulk_yield = _bulk_yield(params, length)
    for bits_per_octave in range(1, _MOST_BITS + 1):
        nodes = source.nodes(smallest, largest, bits_per_octave)
        shape = shape_from_nodes(nodes, bits_per_octave, over_roughness, over_radius, bulk_yield)
        certificate = source.certify(shape, bind_params(shape, one))
        if max(certificate) <= rtol:
            return Table(law, shape, nodes, certificate, rtol)
    raise _out_of_reach(law, rtol, certificate)


def _out_of_reach(law, rtol, certificate):
    return DemlawsError(
        f"rtol = {rtol:g} is out of reach: with {2**_MOST_BITS} cells an octave the table of {law.name!r} errs by "
        f"{max(certificate):.2g}; ask for more than that"
    )


def _refuse_too_fine(law, rtol):
    if law.definition.solved and rtol < 1e-5:
        raise DemlawsError(
            f"rtol = {rtol:g}: the curve of {law.name!r} comes from a solver, to 1e-6 itself; ask for 1e-5 or more"
        )


def _pick(contact):
    """The contact of an array of contacts for which its one table is made: the smoothest has the longest range."""
    if contact.size is None:
        return 0, contact
    index = int(np.argmin(np.broadcast_to(contact.roughness, contact.size)))
    names = ("radius", "modulus", "roughness")
    return index, contact.with_values(**{n: float(np.broadcast_to(getattr(contact, n), contact.size)[index]) for n in names})


def _kinks_of_one(law, index):
    """Overlaps [m] of the kinks of contact `index`."""
    if isinstance(law, Table):
        return list(law.nodes.kinks * np.ravel(law.length)[min(index, np.size(law.length) - 1)])
    if law.contact.size is None:
        return law.kinks()
    return list(law.definition.kinks(one_of(loading_part(law.params), index), **law.options))


def _join(table, curve):
    """A `Table` of an elastic one and an unloading curve; the curve's rows are its own, in the table's scales."""
    _refuse_too_fine(curve, table.rtol)
    joined = Law.joined(table, curve)
    index, one = _pick(table.contact)
    own = loading_part(table.shape)
    params = bind_params(joined.shape, one)
    length, coefficient = params.loading.length, params.hertz_coefficient
    kinks = [k / length for k in _kinks_of_one(curve, index)]
    source = Source(params.unloading, length, coefficient, kinks, curve.definition.solved)
    end, top = 0.75 * coefficient * length**1.5 * table.nodes.force[-1], np.empty(1)
    for bits_per_octave in range(52 - own.shift, _MOST_BITS + 1):
        # some cells beyond the end of the loading, so that the reverse, which ends with a whole cell, reaches it, too
        inverse_loop(params.unloading, np.array([end * (1.0 + 4.0 * 0.5**bits_per_octave)]), top)
        if not np.isfinite(top[0]):
            raise DemlawsError(
                f"the unloading curve, a table of {curve.name!r}, must reach beyond this table's {end:.4g} N: make it with a "
                "larger max_force, or this one with a smaller"
            )
        largest = top[0] / length
        nodes = source.nodes(min(source.lowest(table.rtol), largest / 64.0), largest, bits_per_octave)
        if not np.all(np.isfinite(nodes.force)):  # a table as the curve ends within the last cell
            continue
        lengths = own.length_over_roughness, own.length_over_radius
        shape = shape_from_nodes(nodes, bits_per_octave, *lengths, floor=_floor(own))
        certificate = source.certify(shape, bind_params(shape, one))
        if max(certificate) <= table.rtol:
            law = Law(curve.definition, table.contact, "elastic", curve.options, shape)
            rows = Table(law, shape, nodes, certificate, table.rtol)
            rows.made_for = curve.made_for if isinstance(curve, Table) else curve.contact
            return _joined_table(table, rows)
    raise _out_of_reach(curve, table.rtol, certificate)


def _floor(shape):
    """s where the power law of a loading curve ends below: the unloading curve's ends there, too, and stays the stiffer one."""
    return None if shape.exponent < _SEATED else float(shape.cells[0, 1])


def _joined_table(table, rows):
    """`table` with another table in its scales as its unloading curve."""
    shape = JoinedShape(loading_part(table.shape), quick_to_invert(rows.shape, rows.nodes.kinks), 1.0, 1.0, 1.0)
    law = Law(table.definition, table.contact, GIVEN, table.options, shape, None, rows)
    return Table(law, shape, table.nodes, (table.force_error, table.stiffness_error), table.rtol)


def _bulk_yield(params, length):
    """What Thornton's rule needs of a law whose bulk yields, dimensionless; see `TableShape`."""
    if not hasattr(params, "area_slope"):
        return math.inf, 0.0, 0.0
    slope = params.area_slope * params.hertz_coefficient * math.sqrt(length)
    return params.yield_overlap / length, params.yield_area / length, slope


def _lengths(definition, contact):
    if _length(definition, contact)[1]:
        return np.asarray(contact.radius)
    return np.maximum(contact.roughness, SMOOTHEST * np.asarray(contact.radius))


# --- the table as a law, and its file


class Table(Law):
    """A law read from its certified table: all methods of `Law`, and `force_error`, `stiffness_error`, `save`, `load`."""

    def __init__(self, law, shape, nodes, certificate, rtol, contact=None):
        curve = law.unloading_law
        if curve is not None and contact is not None:
            curve = curve.bound_to(contact)
        super().__init__(law.definition, contact or law.contact, law.unloading, law.options, shape, None, curve)
        self.nodes = nodes
        self.force_error, self.stiffness_error = certificate
        self.rtol = rtol
        self.made_for = self.contact  # of a table that is the unloading curve of another: the contact of its law

    def __repr__(self):
        text = (
            f"demlaws.Table of {self.name!r}: {self.nodes.u.size} rows, force within {self.force_error:.1e}, "
            f"stiffness within {self.stiffness_error:.1e}"
        )
        return text if self.unloading_law is None else f"{text}; unloading along {self.unloading_law!r}"

    def joined(self, unloading):
        """This table with another unloading rule: a name, or a law or a `Table` as the curve; see `Law.joined`."""
        rule, curve = rule_and_curve(unloading)
        shape, certificate = self.loading_shape, (self.force_error, self.stiffness_error)
        elastic = Law(self.definition, self.contact, "elastic", self.options, shape, loading_part(self.params))
        plain = Table(elastic if curve is not None else elastic.joined(rule), shape, self.nodes, certificate, self.rtol)
        return plain if curve is None else _join(plain, curve)

    def kinks(self):
        return list(self.nodes.kinks * np.ravel(self.length)[0])

    @property
    def loading_shape(self):
        """`TableShape` of first loading."""
        return loading_part(self.shape)

    @property
    def length(self):
        """Length [m] that makes overlaps dimensionless, one a contact."""
        return loading_part(self.params).length

    @property
    def largest_overlap(self):
        """End of the table [m]."""
        return self.loading_shape.highest * np.min(self.length)

    @property
    def largest_force(self):
        """Force [N] at the end of the table."""
        scale = 0.75 * np.min(self.params.hertz_coefficient * np.asarray(self.length) ** 1.5)
        return float(scale * self.nodes.force[-1])

    def _out_of_range(self, overlap):
        return (
            f"overlap {overlap:g} m is beyond the table, which ends at {self.largest_overlap:g} m ({self.largest_force:g} N): "
            "make it with a larger max_force"
        )

    def _force_out_of_range(self, force):
        return f"force {force:g} N is beyond the table, which ends at {self.largest_force:g} N: make it with a larger max_force"

    def bound_to(self, contact):
        """The same curve for another contact (or array of contacts); only a law whose curve collapses allows that."""
        if not self.collapses:
            raise DemlawsError(
                f"the table of {self.name!r} holds for the contact it was made for only: make one for this contact"
            )
        if self.loading_shape.length_over_roughness and np.any(np.asarray(contact.roughness) == 0.0):
            raise DemlawsError("roughness = 0 m: this table scales with roughness; use law 'hertz' for a smooth contact")
        return Table(self, self.shape, self.nodes, (self.force_error, self.stiffness_error), self.rtol, contact)

    def save(self, path):
        """Write the table as text with its certificate, its unloading curve below it; see `Table.load`."""
        from demlaws import __version__

        shape, curve = self.loading_shape, self.unloading_law
        header = {
            "law": self.name,
            "description": f"{self.definition.description}; {self.definition.equation}",
            "source": self.definition.source,
            "unloading": self.unloading,
            "options": json.dumps(self.options, default=lambda value: value.record()),
            "contact": json.dumps(_first(self.contact).as_dict()),
            "collapses": "yes" if self.collapses else "no",
            "scales": "overlap/length, force/(E* sqrt(R) length^1.5), stiffness/(E* sqrt(R length)), R and E* effective",
            "length": repr(float(np.ravel(self.length)[0])),
            "length_over_roughness": repr(shape.length_over_roughness),
            "length_over_radius": repr(shape.length_over_radius),
            **_describe_rows(self),
            "rtol": repr(self.rtol),
            "demlaws": __version__,
        }
        if math.isfinite(shape.yield_overlap):  # f at yield, and d(a²/(R length))/df after it
            header["yield_overlap"] = repr(shape.yield_overlap)
            header["yield_force"] = repr(4.0 / 3.0 * shape.yield_area**1.5)
            header["yield_area"] = repr(shape.yield_area)
            header["yield_area_slope"] = repr(0.75 * shape.yield_area_slope)
        if curve is not None:
            about = {
                "law": curve.name,
                "description": f"{curve.definition.description}; {curve.definition.equation}",
                "source": curve.definition.source,
                "options": json.dumps(curve.options, default=lambda value: value.record()),
                "contact": json.dumps(_first(curve.made_for).as_dict()),
                **_describe_rows(curve),
            }
            header |= {f"unloading_{key}": value for key, value in about.items()}
        lines = [*(f"{key}: {value}".rstrip() for key, value in header.items()), _TITLES, *_text_rows(self.nodes)]
        if curve is not None:
            lines += [_UNLOADING_TITLES, *_text_rows(curve.nodes)]
        lines.append(f"end: {self.nodes.u.size + (0 if curve is None else curve.nodes.u.size)} rows")
        text, check = FORMAT + "\n", zlib.crc32((FORMAT + "\n").encode())
        parts = [text]
        for line in lines:
            check = zlib.crc32(line.encode(), check)
            tail = f" {check:08x}\n"
            check = zlib.crc32(tail.encode(), check)
            parts.append(line + tail)
        return write_atomically(path, "".join(parts))

    @classmethod
    def load(cls, path):
        """Read a table written by `save`. A truncated, edited or foreign file is refused with its line number."""
        path = Path(path)
        try:
            lines = path.read_bytes().split(b"\n")
        except OSError as error:
            raise DemlawsError(f"cannot read table {path}: {error.strerror or error}") from error

        def refuse(number, why):
            raise DemlawsError(f"{path}, line {number}: {why}")

        if lines[0].decode(errors="replace") != FORMAT:
            refuse(1, f"not a demlaws table (the first line must be {FORMAT!r})")
        check = zlib.crc32(lines[0] + b"\n")
        header, rows, curve_rows, ended, places = {}, [], [], None, {}
        reading = None
        for number, raw in enumerate(lines[1:], start=2):
            if ended is not None:
                if raw:
                    refuse(number, f"text after the last line ({ended})")
                continue
            body, separator, mark = raw.rpartition(b" ")
            check = zlib.crc32(body, check)
            if not separator or mark != b"%08x" % check:
                what = "the file ends here: it was cut short" if number >= len(lines) - 1 else "this line was changed"
                refuse(number, f"{what} (its check mark does not fit); write the table again with Table.save or demlaws table")
            check = zlib.crc32(b" " + mark + b"\n", check)
            try:
                line = body.decode()
                places[line.partition(":")[0]] = number
                if line.startswith("end: "):
                    ended = line
                    count = len(rows) + len(curve_rows)
                    if line != f"end: {count} rows" or header.get("rows") != str(len(rows)):
                        refuse(number, f"{len(rows)} rows were read, {header.get('rows')} were promised")
                    if header.get("unloading_rows", "0") != str(len(curve_rows)):
                        promised = header.get("unloading_rows", "none")
                        refuse(number, f"{len(curve_rows)} rows of unloading were read, {promised} were promised")
                elif line == _UNLOADING_TITLES and reading is rows:
                    reading = curve_rows
                elif reading is not None:
                    reading.append(_row(line, reading))
                elif line == _TITLES:
                    reading = rows
                else:
                    key, _, value = line.partition(": ")
                    header[key.rstrip(":")] = value
            except DemlawsError:
                raise
            except ValueError as error:
                refuse(number, f"not a line of a table: {error}")
        if ended is None:
            refuse(len(lines), "the file ends without its 'end:' line: it was cut short")
        if len(rows) < 2:
            refuse(places["end"], f"a table needs 2 rows or more, this one has {len(rows)}")

        def read(key, convert, suits=lambda value: True):
            if key not in header:
                refuse(places[_TITLES], f"the lines above lack {key!r}")
            try:
                value = convert(header[key])
                if suits(value):
                    return value
            except (TypeError, ValueError):
                pass
            refuse(places[key], f"{header[key]!r} will not do")

        positive = (float, lambda value: 0.0 <= value < math.inf)
        lengths = (read("length_over_roughness", *positive), read("length_over_radius", *positive))
        rtol = read("rtol", *positive)

        def table(rows, prefix, unloading, contact, bulk_yield=(math.inf, 0.0, 0.0), floor=None):
            """What the rows and the keys with this prefix make."""
            nodes = Nodes(*np.array(rows).T)
            options = read(f"{prefix}options", json.loads, lambda value: isinstance(value, dict))
            definition = read(f"{prefix}law", find)
            suits = lambda value: 1 <= value <= _MOST_BITS and _fits_grid(nodes.u, value)  # noqa: E731
            shape = shape_from_nodes(nodes, read(f"{prefix}bits", int, suits), *lengths, bulk_yield, floor=floor)
            # bound to the file's curve, not to the law's own: a solved law would be solved again, a measured one is not here
            source = Law(definition, contact, unloading, options, shape)
            certificate = Certificate(read(f"{prefix}force_error", *positive), read(f"{prefix}stiffness_error", *positive))
            return cls(source, shape, nodes, certificate, rtol)

        contact = read("contact", lambda text: Contact(**json.loads(text)))
        unloading = read("unloading", str, lambda value: value in RULES)
        bulk_yield = (math.inf, 0.0, 0.0)
        if "yield_overlap" in header:
            bulk_yield = (
                read("yield_overlap", *positive),
                read("yield_area", *positive),
                read("yield_area_slope", *positive) / 0.75,
            )
        if unloading != GIVEN:
            if curve_rows:
                refuse(places["unloading"], f"unloading {unloading!r} has no rows of its own, this file has {len(curve_rows)}")
            return table(rows, "", unloading, contact, bulk_yield)
        if len(curve_rows) < 2:
            refuse(
                places["end"], f"unloading {GIVEN!r} needs 2 rows or more below {_UNLOADING_TITLES!r}, got {len(curve_rows)}"
            )
        first = table(rows, "", "elastic", contact, bulk_yield)
        curve = table(curve_rows, "unloading_", "elastic", contact, floor=_floor(first.shape))
        curve.made_for = read("unloading_contact", lambda text: Contact(**json.loads(text)))
        return _joined_table(first, curve)


def _first(contact):
    """The contact that a file names: of an array of contacts, which one curve serves, the first."""
    if contact.size is None:
        return contact
    return contact.with_values(**{n: float(np.ravel(getattr(contact, n))[0]) for n in ("radius", "modulus", "roughness")})


def _describe_rows(table):
    """What the header says of a table's rows."""
    u, force, _ = table.nodes
    return {
        "bits": str(52 - table.loading_shape.shift),
        "kinks": " ".join(repr(float(k)) for k in table.nodes.kinks),
        "range_overlap": f"{u[0]!r} {u[-1]!r}",
        "range_force": f"{float(force[0])!r} {float(force[-1])!r}",
        "force_error": repr(table.force_error),
        "stiffness_error": repr(table.stiffness_error),
        "rows": str(u.size),
    }


def _text_rows(nodes):
    return [f"{u:.17g} {f:.17g} {k:.17g}" for u, f, k in zip(*nodes, strict=True)]


def _row(line, rows):
    """u, f, k of a line; ValueError where it cannot follow the rows before it."""
    row = [float(v) for v in line.split()]
    if len(row) != 3 or not all(0.0 < v < math.inf for v in row):
        raise ValueError(f"{line!r} is not three positive numbers")
    if rows and (row[0] < rows[-1][0] or row[1] < rows[-1][1]):
        raise ValueError(f"{line!r} does not increase")
    return row


def _fits_grid(u, bits_per_octave):
    """Whether every grid cell between the first and the last node has its node, and at most two kinks stand twice."""
    first, last = node_number(u[0], bits_per_octave), node_number(u[-1], bits_per_octave)
    grid_nodes = node(np.arange(first, last + 1), bits_per_octave) if last - first <= u.size else np.empty(0)
    kinks = u[:-1][np.diff(u) == 0.0]
    return grid_nodes.size > 1 and kinks.size <= 2 and np.array_equal(np.union1d(grid_nodes, kinks), np.unique(u))
