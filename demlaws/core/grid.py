"""The cells of a curve from its rows: node positions, Hermite cubics, the power law below, and the reverse curve."""

import math
from typing import NamedTuple

import numpy as np

from demlaws.core.curve import CurveShape, invert_loop, read
from demlaws.core.table_types import NO_YIELD, Grid, TableShape
from demlaws.errors import DemlawsError

MOST_BITS = 12
MOST_KINKS = 32
"""Kinks of one curve: each costs a look-up one comparison more, but the first two, which every look-up makes."""
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(6)
_OCTAVES_BELOW, _MOST_OCTAVES_BELOW, _MOST_OF_S = 40.0, 200.0, 100.0
"""Octaves of u, and of s, of cells that continue the power law below the first node, so that reading it takes no power; the
others for an unloading curve, which goes as far down in force as its law's."""


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
        """u, s, ds/du, interpolated by the cells."""
        s = np.cbrt(0.75 * self.force) ** 2
        return self.u, s, self.stiffness / (2.0 * np.sqrt(s))


def grid(lowest, highest, kinks, bits_per_octave):
    """Node positions from the grid cell that holds `lowest` to the end of the one that holds `highest`; kinks twice."""
    first, last = node_number(lowest, bits_per_octave), node_number(highest, bits_per_octave) + 1
    u = node(np.arange(first, last + 1), bits_per_octave)
    inside = sorted({float(k) for k in kinks if u[0] < k < u[-1]})
    if len(inside) > MOST_KINKS:
        raise DemlawsError(f"{len(inside)} kinks of the stiffness in the table's range: a table stores at most {MOST_KINKS}")
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


def _below(u0, s0, exponent, first, bits_per_octave, straight, floor):
    """Rows of cells below the first node and the u where they begin: one linear from 0, then the power law s0 (u/u0)^p.

    floor: s about where the power law ends, or None: 40 octaves of u or of s down, the fewer. straight: a curve that starts
    from a force (p < 1) goes on straight, with the slope of the first node; a power law would have a stiffness without bound.
    """
    octaves = _OCTAVES_BELOW if straight else _OCTAVES_BELOW / max(exponent, 1.0)
    if floor is not None and not straight:
        octaves = min(max(1.0, min(math.log2(s0 / floor), _MOST_OF_S) / exponent), _MOST_OCTAVES_BELOW)
    u = node(np.arange(first - round(octaves * 2**bits_per_octave), first + 1), bits_per_octave)
    if straight:
        seat, slope = s0 * (1.0 - exponent), exponent * s0 / u0
        width = np.append(u[0], np.diff(u))  # the slope as it is: differences of s would be nothing but rounding here
        none = np.zeros(u.size)
        return np.column_stack([seat + slope * np.append(0.0, u[:-1]), slope * width, none, none]), float(u[0])
    s = s0 * (u / u0) ** exponent
    slope = exponent * s / u
    cells = _hermite(0.0, 1.0, np.diff(u), s[:-1], s[1:], slope[:-1], slope[1:])
    return np.concatenate([[[0.0, s[0], 0.0, 0.0]], cells]), float(u[0])


def shape_from_nodes(
    nodes, bits_per_octave, length_over_roughness, length_over_radius, *, bulk=NO_YIELD, straight=False, floor=None
):
    """Cubic Hermite cells through the rows of a table; straight, floor: see `_below`."""
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
    straight = straight and exponent < 1.0 - 1e-9  # the reverse of a straight curve, and Hertz, are straight from 0
    seat = s[0] * (1.0 - exponent) if straight else 0.0
    cells = _hermite(t0, t1, width, s[left], s[right], slope[left], slope[right])
    x = 0.5 * (t0 + t1)[:, None] + 0.5 * (t1 - t0)[:, None] * _NODES
    y = cells[:, :1] + x * (cells[:, 1:2] + x * (cells[:, 2:3] + x * cells[:, 3:4]))
    pieces = 4.0 / 3.0 * (np.maximum(y, 0.0) ** 1.5 @ _WEIGHTS) * 0.5 * (t1 - t0) * width
    below = 4.0 / 3.0 * s[0] ** 1.5 * u[0] / (1.5 * exponent + 1.0)
    if seat > 0.0:
        line = seat + (s[0] - seat) * 0.5 * (1.0 + _NODES)
        below = 2.0 / 3.0 * float(line**1.5 @ _WEIGHTS) * u[0]
    energy = below + np.concatenate([[0.0], np.cumsum(pieces)[:-1]])
    # a kink that lies on the grid splits no cell: the cells on either side have their own slopes there
    splits = [float(k) for k in kinks if k.view(np.int64) & ((1 << shift) - 1)]
    # 2, 4, 8, … kinks and infinities in all: each number is a type of its own, for which look-ups are compiled
    padding = max(2, 2 ** math.ceil(math.log2(max(len(splits), 1)))) - len(splits)
    below, floor = _below(u[0], s[0], exponent, int(numbers[0]), bits_per_octave, straight, floor)
    end = slope[-1] * float(node(numbers[-1] + 2, bits_per_octave) - u[-1])
    cells = np.concatenate([below, cells, [[s[-1], end, 0.0, 0.0]]])  # the last row is read at the last node only
    grid = Grid(
        cells=cells,
        starts=np.ascontiguousarray(np.column_stack([t0, s[left], energy, base, width])),
        shift=shift,
        first=int(numbers[0]) - below.shape[0],
        kinks=(*splits, *([math.inf] * padding)),
        lowest=float(u[0]),
        highest=float(u[-1]),
        floor=floor,
        inverse_floor=1.0 / floor,
        exponent=exponent,
        seat=float(seat),
        count=cells.shape[0],
    )
    return TableShape(grid, bulk, float(length_over_roughness), float(length_over_radius))


def with_reverse(shape, kinks=()):
    """A table's shape with its reverse. kinks: u of the table's."""
    curve = shape.grid
    bits_per_octave = 53 - curve.shift  # finer by a bit, so that one step of Newton's method is exact to rounding
    highest, seat = float(curve.cells[-1, 0]), curve.seat
    # where the curve begins to be straight: the reverse of a straight line is one
    lowest = float(curve.starts[0, 1] - seat if seat > 0.0 else curve.cells[0, 1])
    corners = np.array([k for k in kinks if curve.lowest < k < curve.highest])
    last = node_number(highest - seat, bits_per_octave)  # this node and those before it lie on the curve
    end = float(node(last - 1, bits_per_octave))
    y, corners = grid(lowest, end, list(read(curve, corners)[0] - seat), bits_per_octave)
    place = y.copy()
    for corner in corners:
        first, second = np.flatnonzero(y == corner)
        place[first], place[second] = corner * (1.0 - 1e-14), corner * (1.0 + 1e-14)
    u = np.empty(y.size)
    invert_loop(curve, place + seat, u)
    slope = 1.0 / read(curve, u)[1]
    for corner in corners:
        first, second = np.flatnonzero(y == corner)
        u[second] = u[first]
    nodes = Nodes.from_curve(y, u, slope)
    lengths = shape.length_over_roughness, shape.length_over_radius
    reverse = shape_from_nodes(nodes, bits_per_octave, *lengths, straight=seat > 0.0, floor=float(u[0]))
    return CurveShape(shape, reverse)
