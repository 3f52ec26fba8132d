"""Laws with one master curve per dimensionless number: one curve of the contacts that share it, a family for those that differ.

The curves of Yip & Venart (A = N_H) and of Greenwood & Tripp (A = μ) are data of the package (`solvers.master_curves`): f(U),
U the approach over σ. Gaussian tails never stop touching, so a curve needs a start. It is followed down to the seating load, a
share of E* √R σ^1.5, and continued below it as P ∝ δ^1.5 with the same force and stiffness there [our derivation]: overlap 0 is
where that ends. The stiffness at equal Hertz-equivalent overlap is at most Hertz's: the law is nowhere stiffer than Hertz.
"""

import functools
import math
from typing import NamedTuple

import numpy as np

from demlaws.core.curve import read_curve, scale_table
from demlaws.core.dispatch import bind
from demlaws.core.fastmath import hertz_coefficient, hertz_overlap, kernel, root_finder, sqrt
from demlaws.core.grid import Nodes, grid, shape_from_nodes
from demlaws.core.table_types import BulkYield, Grid
from demlaws.errors import DemlawsError
from demlaws.laws.definition import Limit
from demlaws.laws.hertz import HertzShape
from demlaws.solvers import master_curves
from demlaws.solvers.master_curves import cubic_share, mean_of_four

SEATING_SHARE = 0.0025
"""Default seating load over E* √R σ^1.5: 0.02 N, the resolution of the load cell, in the granite tests."""
_BITS = 6  # cells per octave: they reproduce a master curve to 1e-6 in force
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

    grid: Grid  # these four as in `TableShape`
    bulk: BulkYield
    length_over_roughness: float
    length_over_radius: float
    number: CurveNumber
    value: float  # A of the curve


class FamilyShape(NamedTuple):
    """Master curves at a geometric sequence of A, for contacts that differ."""

    grid: Grid  # of every curve; its cells are those of all curves, one after the other, with one more before and after
    number: CurveNumber
    lowest_value: float  # A of the first curve but one
    log_ratio: float  # ln of the ratio of neighbours
    curves: int  # without the first and the last
    cubic: float  # 1: a cubic in ln A between the inner two of four curves, 0: a straight line
    flattens: float  # A from which the curves bend at large overlaps (`cubic_share`)


class FamilyParams(NamedTuple):
    """One contact between four master curves, at equal overlap: see `mean_of_four`."""

    hertz_coefficient: float
    length: float
    inverse_length: float
    offset: float
    row: float  # where the cells of the first of the four begin (a whole number)
    place: float  # between the inner two, from 0 to 1
    turn: float  # of `cubic_share`


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
    return scale_table(shape, radius, modulus, roughness, 0.0 if same else math.nan)


@kernel
def _family_scale(shape, radius, modulus, roughness):
    value = curve_number(shape.number, radius, modulus, roughness)
    place = math.log(value / shape.lowest_value) / shape.log_ratio
    inside = -1e-9 <= place <= shape.curves - 1 + 1e-9
    row = min(max(math.floor(place), 0.0), shape.curves - 2.0)
    offset = 0.0 if inside else math.nan
    turn = 1.0 / (value * value) if value > shape.flattens else 0.0
    start, coefficient = row * shape.grid.count, hertz_coefficient(radius, modulus)
    return FamilyParams(coefficient, roughness, 1.0 / roughness, offset, start, place - row, turn)


@kernel
def _family_read(contact, u):
    shape, p = contact
    row, g = int(p.row), shape.grid
    share, rate = cubic_share(u, p.turn)
    s0, slope0 = read_curve(g, u, row)
    s1, slope1 = read_curve(g, u, row + g.count)
    s2, slope2 = read_curve(g, u, row + 2 * g.count)
    s3, slope3 = read_curve(g, u, row + 3 * g.count)
    s, bent = mean_of_four(p.place, shape.cubic * share, s0, s1, s2, s3)
    slope, _ = mean_of_four(p.place, shape.cubic * share, slope0, slope1, slope2, slope3)
    return s, slope + shape.cubic * rate * bent


@kernel
def _family_first_loading(shape, p, overlap):
    s, slope = _family_read((shape, p), overlap * p.inverse_length + p.offset)
    equivalent = s * p.length
    root = p.hertz_coefficient * sqrt(equivalent)
    return root * equivalent, 1.5 * root * slope, equivalent, equivalent


_find = root_finder(_family_read)


@kernel
def _family_inverse(shape, p, force):
    """Where the blended curve reaches the force; NaN above the table."""
    s = hertz_overlap(p, force) * p.inverse_length
    high = shape.grid.highest
    if not (s <= _family_read((shape, p), high)[0]):
        return math.nan
    return max((_find((shape, p), s, 0.0, high, 0.5 * high, 1e-14) - p.offset) * p.length, 0.0)


@kernel
def _family_energy(shape, p, overlap):
    """Gauss's rule on panels a thirty-second of an octave wide or narrower, cut where the cells are."""
    top = overlap * p.inverse_length + p.offset
    u = p.offset
    total = 0.0
    while u < top:
        end = min(u + max(u, shape.grid.lowest) / 64.0, top)
        half = 0.5 * (end - u)
        for k in range(_NODES.size):
            s, _ = _family_read((shape, p), u + half * (1.0 + _NODES[k]))
            total += half * _WEIGHTS[k] * s * sqrt(s)
        u = end
    return p.hertz_coefficient * p.length * p.length * sqrt(p.length) * total


bind(ImplicitShape, scale=_scale)
bind(FamilyShape, scale=_family_scale)
bind(FamilyParams, first_loading=_family_first_loading, inverse=_family_inverse, energy=_family_energy)


def seating_limit(contact, share):
    """`Limit` below the seating load, the largest of an array of contacts."""
    load = share * contact.modulus * np.sqrt(contact.radius) * np.asarray(contact.sigma) ** 1.5
    reason = "below the seating load the curve is not the source's: it is continued as P ∝ δ^1.5 (see seating_share)"
    return Limit(float(np.max(load)), math.inf, reason)


@functools.lru_cache(maxsize=4)
def _family(model, law, share):
    """The shape for any contacts."""
    data = master_curves.load(model)
    seated = master_curves.seated(data, share)
    u, _ = grid(float(np.min(seated.start)), 0.1 / SMOOTH, [], _BITS)
    shapes = [_shape(u, s, slope) for s, slope in zip(*seated.at(u), strict=True)]
    lowest = math.exp(data.log_first + data.log_ratio)
    return FamilyShape(shared_grid(shapes), law, lowest, data.log_ratio, len(shapes) - 2, 1.0, data.flattens)


def law_curve(model, value, share, reach=0.0):
    """The table of one value of A, up to overlaps of `reach` over σ at least."""
    data = master_curves.load(model)
    rows, place = data.around(value)
    seated = master_curves.seated(data, share, rows)
    highest = max(reach, float(np.min(seated.overlap[:, -1])))
    u, _ = grid(float(np.min(seated.start)), highest, [], _BITS)
    cubic, rate = cubic_share(u, 1.0 / value**2 if value > data.flattens else 0.0)
    curves, slopes = seated.at(u)
    s, bent = mean_of_four(place, cubic, *curves)
    slope = mean_of_four(place, cubic, *slopes)[0] + rate * bent
    return _shape(u, s, slope)


def _shape(u, s, slope):
    """The table of a curve, nowhere stiffer than Hertz: u - s rises in every cell (limits of Fritsch & Carlson 1980), where
    polynomials through a bend at p(0) = H_m would let it fall, too."""
    offset = np.maximum.accumulate(u - s)
    chord = np.diff(offset) / np.diff(u)
    rate = np.clip(1.0 - slope, 0.0, 3.0 * np.minimum(np.append(chord, chord[-1]), np.insert(chord, 0, chord[0])))
    return shape_from_nodes(Nodes.from_curve(u, u - offset, 1.0 - rate), _BITS, 1.0, 0.0)


def prepare(model, law, contact, seating_share):
    """Shape of the law of a model: one curve if the contacts share A = `law`, else those of all A.

    Contacts smoother than SMOOTH get the Hertz law, to which the model tends.
    """
    radius, modulus, roughness = (np.asarray(v, float) for v in (contact.radius, contact.modulus, contact.sigma))
    smooth = roughness < SMOOTH * radius
    if np.all(smooth):
        return HertzShape()
    if np.any(smooth):
        raise DemlawsError(
            f"{int(np.sum(smooth))} contacts are smooth (σ below {SMOOTH:g} R): give them law 'hertz', the others law {model!r}"
        )
    numbers = law.factor * modulus**law.modulus * radius**law.radius * roughness**law.roughness
    low, high = float(np.min(numbers)), float(np.max(master_curves.load(model).checked(numbers)))
    if high > low * (1.0 + 1e-9):
        return _family(model, law, seating_share)
    return ImplicitShape(*law_curve(model, low, seating_share, float(np.max(0.1 * radius / roughness))), law, low)
