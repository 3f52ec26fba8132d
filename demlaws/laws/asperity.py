"""Jamari & Schipper 2006-2008: first loading of a measured map against a smooth ball as a law.

The curve is that of one map at one effective radius and modulus. Contacts that differ in radius are blended between curves
at radii 5 % apart.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from demlaws.core.grid import Nodes, grid, shape_from_nodes
from demlaws.errors import DemlawsError
from demlaws.laws.definition import (
    MAP,
    POSITIVE,
    Advice,
    Definition,
    Drawing,
    Limit,
    Loading,
    Numbers,
    Option,
    Rules,
    bulk_yield,
    plastic_asperities,
)
from demlaws.laws.family import CurveNumber, FamilyShape, shared_grid
from demlaws.laws.hertz import HertzShape
from demlaws.solvers.criterion import transition_force
from demlaws.surface import HeightMap, read, self_affine
from demlaws.surfaces.plausibility import doubts, warn_of_map

_BITS = 6  # cells per octave
_SAMPLES = 12  # cuts of the map per octave
_OCTAVES = 12  # from the first cut to an overlap of Sq
_BANDWIDTH = 0.4  # octaves, of the smoothing over the falls of force where patches merge
_RADIUS_STEP = 1.05  # ratio of neighbouring radii of a family of curves
_MOST_CURVES = 64


# --- one curve


class PairCurve(NamedTuple):
    """s(u) of one pair, smooth; x = log2 u."""

    start: float  # u below which it is a power law
    first: float  # s at the start
    rate: Callable  # ds/dx, a spline

    def evaluate(self, u):
        """s and ds/du."""
        inside = np.maximum(u, self.start)
        x = np.log2(inside)
        s, slope = self.first + self.rate.antiderivative()(x), self.rate(x) / (inside * math.log(2.0))
        power = float(self.rate(math.log2(self.start))) / (math.log(2.0) * self.first)
        below = self.first * (u / self.start) ** power
        return np.where(u < self.start, below, s), np.where(u < self.start, power * below / u, slope)


def _curve(pair, surface, reach, max_force, **plasticity):
    from demlaws.solvers.contact import RoughContact

    overlap, force = sample(RoughContact(surface, pair, **plasticity), max_force)
    length = _length(pair)
    coefficient = 4 / 3 * pair.modulus * math.sqrt(pair.radius)
    # a table's last cell may end at twice the tenth of the radius where tables end
    return _smooth(overlap / length, (force / coefficient) ** (2 / 3) / length, reach)


def _length(pair):
    return pair.sigma or pair.radius


def sample(rough, max_force):
    """Overlaps and forces of a `RoughContact` at evenly spaced logarithms of the overlap, up to max_force."""
    from tqdm import tqdm

    limit = math.inf if max_force is None else max_force
    if max_force is None and rough.pair.hardness is not None:
        limit = transition_force(rough.pair.with_values(sigma=rough.heights.sq))
    overlap = max(rough.heights.sq, 1e-12) * 2.0**-_OCTAVES
    overlaps, forces, edge = [], [], 0.0
    for _ in tqdm(range(40 * _SAMPLES), desc="asperity", unit="cut", leave=False, disable=None, delay=1):
        force, _, edge = rough.carried(overlap)
        if force > limit or (edge and max_force is None):
            break
        overlaps.append(overlap)
        forces.append(force)
        overlap *= 2.0 ** (1 / _SAMPLES)
    forces = np.array(forces)
    loaded = forces > 0
    if loaded.sum() < 3 * _SAMPLES:
        raise DemlawsError(
            f"only {int(loaded.sum())} overlaps of this map carry load below {limit:.3g} N: give a larger "
            "max_force or a larger map"
        )
    if max_force is not None and edge:
        rough.warn_of_edge(rough.at(overlaps[-1]))
    return np.array(overlaps)[loaded], forces[loaded]


def _smooth(u, s, reach):
    """A smooth monotone `PairCurve` through (u, s), up to `reach`, never steeper than Hertz.

    ln s is a local parabola in ln u, wide enough to bridge the falls of force where patches merge. A slope ds/du above
    1 would be a contact stiffer than a smooth one at equal load, which comes from leaving the bulk rigid: it is cut to 1.
    Beyond the last u the curve goes on as a power law until that cut holds it to Hertz's stiffness.
    """
    from scipy.interpolate import CubicSpline

    x, y = np.log2(u), np.log2(s)
    fine = np.linspace(x[0], x[-1], int(32 * (x[-1] - x[0])) + 2)
    value, slope = _local_parabola(x, y, fine)
    slope = np.maximum(slope, 0.05)
    beyond = np.arange(1, int(32 * max(math.log2(reach) + 1.5 - x[-1], 1.0))) / 32
    steady = max(slope[-1], 1.2)
    fade = (steady - slope[-1]) * np.exp(-2.0 * beyond)
    value = np.append(value, value[-1] + steady * beyond - 0.5 * (steady - slope[-1] - fade))
    slope, fine = np.append(slope, steady - fade), np.append(fine, x[-1] + beyond)
    steep = np.minimum(slope * 2.0 ** (value - fine), 1e6)
    steep /= (1.0 + steep**12) ** (1 / 12)
    return PairCurve(2.0 ** fine[0], 2.0 ** value[0], CubicSpline(fine, steep * 2.0**fine * math.log(2.0)))


def _local_parabola(x, y, at):
    """Value and slope at `at` of the parabola fitted with a Gaussian weight around each of them."""
    value, slope = np.empty(at.size), np.empty(at.size)
    for i, centre in enumerate(at):
        d = x - centre
        weight = np.exp(-0.5 * (d / _BANDWIDTH) ** 2)
        near = weight > 1e-8
        basis = np.column_stack([np.ones(near.sum()), d[near], d[near] ** 2]) * np.sqrt(weight[near])[:, None]
        value[i], slope[i], _ = np.linalg.lstsq(basis, y[near] * np.sqrt(weight[near]), rcond=None)[0]
    return value, slope


def _shape(curve, pair, start, reach):
    """The curve on a table's grid: the law is what the cells hold."""
    nodes, _ = grid(start, reach, [], _BITS)
    s, slope = curve.evaluate(nodes)
    steepest = _steepest(nodes, s, slope)
    rough = not pair.is_smooth
    return shape_from_nodes(Nodes.from_curve(nodes, s / steepest, slope / steepest), _BITS, float(rough), float(not rough))


def _steepest(u, s, slope):
    """Largest slope of the cubics between the nodes, or 1 if all are below: between two nodes a cubic may pass 1 a little."""
    width = np.diff(u)
    chord, left, right = np.diff(s) / width, slope[:-1], slope[1:]
    t = np.linspace(0, 1, 17)[:, None]
    inner = left * (1 - t) * (1 - 3 * t) + 6 * t * (1 - t) * chord + right * t * (3 * t - 2)
    return max(1.0, float(inner.max()) * (1 + 1e-9)) if inner.max() > 1 + 1e-10 else 1.0


# --- the law


def _prepare(contact, surface, max_force=None, poisson=0.3, plastic_factor=None, plastic_ratio=None):
    """Shape of the law.

    surface: height map, form removed, or the path of one, whose form of order 2 is then removed; it is the gap map of the
    pair. max_force: end of the computed curve [N], by default where the contact reaches the edge of the map or the bulk
    yields, whichever comes first. Above it the curve is extrapolated: a power law until it has Hertz's stiffness, then that.
    poisson, plastic_factor, plastic_ratio: ν, c_h, c_A of the asperities (without: aluminium's, with a warning). A map
    without any roughness gives Hertz's law.
    """
    surface = _map(surface)
    if surface.sq == 0.0:
        return HertzShape()
    pairs = _pairs(contact)
    reach = max(0.2 * pair.radius / _length(pair) for pair in pairs)
    plasticity = {"poisson": poisson, "plastic_factor": plastic_factor, "plastic_ratio": plastic_ratio}
    curves = [_curve(pair, surface, reach, max_force, **plasticity) for pair in pairs]
    start = min(c.start for c in curves)
    shapes = [_shape(c, pair, start, reach) for c, pair in zip(curves, pairs, strict=True)]
    if len(pairs) == 1:
        return shapes[0]
    # copies at the ends: a curve is read with its neighbours, also where they have no weight
    shared = shared_grid([shapes[0], *shapes, shapes[-1], shapes[-1]])
    ratio = math.log(pairs[-1].radius / pairs[0].radius) / (len(pairs) - 1)
    return FamilyShape(shared, CurveNumber(1.0, 0.0, 1.0, 0.0), pairs[0].radius, ratio, len(pairs), 0.0, math.inf)


def _map(surface):
    """`HeightMap` of what a user gave as `surface`."""
    if isinstance(surface, str):
        surface = read(surface).without_form(2)
    if isinstance(surface, dict):
        surface = HeightMap.from_portable(surface)
    if not isinstance(surface, HeightMap):
        raise DemlawsError(
            "law 'asperity' needs surface, a demlaws.surface.HeightMap (form removed) or the path of a map, "
            f"got {type(surface).__name__}"
        )
    warn_of_map(doubts(surface))
    return surface


def _softened(surface, factor):
    """The map of contacts softer by `factor`: heights grow by s^(2/3), lateral lengths by s^(1/3), curvatures stay."""
    surface, root = _map(surface), float(np.cbrt(factor))
    return HeightMap(surface.heights * root**2, surface.pixel_x * root, surface.pixel_y * root, surface.form_order)


def _pairs(contact):
    """The pairs for which curves are made: at radii a step apart."""
    if contact.size is None:
        return [contact]
    modulus, sigma = np.unique(contact.modulus), np.unique(contact.sigma_or_zero)
    if np.ptp(modulus) > 1e-9 * modulus[0] or np.ptp(sigma) > 1e-9 * sigma[0]:
        raise DemlawsError("contacts of one map that differ in modulus or roughness: make a law for each group of equal ones")
    low, high = float(np.min(contact.radius)), float(np.max(contact.radius))
    count = 1 if high <= low * (1 + 1e-9) else max(2, math.ceil(math.log(high / low) / math.log(_RADIUS_STEP)) + 1)
    if count > _MOST_CURVES:
        raise DemlawsError(f"radii from {low:g} to {high:g} m need {count} curves, {_MOST_CURVES} at most are made")
    if count > 1 and sigma[0] == 0:
        raise DemlawsError("roughness = 0 m in an array of contacts: give the map's roughness, the length of the curves")
    common = {"modulus": float(modulus[0]), "sigma": float(sigma[0])}
    return [contact.with_values(radius=float(radius), **common) for radius in np.geomspace(low, high, count)]


def _limits(contact, max_force=None, **options):
    limits = bulk_yield(contact)
    if max_force is not None:
        limits.append(Limit(0.0, max_force, "the curve is extrapolated above max_force"))
    return limits


_EXAMPLE = {"shape": 128, "pixel": 2e-6, "hurst": 0.8, "seed": 1, "shortest": 8e-6, "longest": 80e-6}

LAW = Definition(
    name="asperity",
    prepare=_prepare,
    equation="P = Σ elastic-plastic ellipsoids, one per contact patch of the cut height map, with its area and volume",
    source="Jamari & Schipper, Wear 262 (2007) 138; Wear 264 (2008) 349",
    description="measured surface, deterministic asperities",
    loading=Loading(computed=MAP),
    limits=_limits,
    collapses=False,
    rules=Rules(default="hertz"),
    options={
        "surface": Option("", "a HeightMap or a file", "height map of the rough body, or of the gap between two", _softened),
        "max_force": Option("N", POSITIVE, "end of the computed curve; default: the edge of the map or bulk yield"),
        "poisson": Option("", Numbers(-1.0, 0.5), "Poisson's ratio of the rough body"),
        "plastic_factor": Option("", POSITIVE, "c_h: fully plastic pressure over hardness; default: 0.71 of aluminium"),
        "plastic_ratio": Option("", POSITIVE, "c_A: 2 ω2/ω1 of a sphere; default: 160 of aluminium"),
    },
    advice=Advice(suits=plastic_asperities),
    drawing=Drawing(
        colour="#e377c2",
        example={
            "surface": self_affine(roughness=2e-6, **_EXAMPLE),
            "plastic_factor": 0.71,
            "plastic_ratio": 160.0,
        },
        example_curve={"surface": self_affine(roughness=0.5e-6, **_EXAMPLE)},
    ),
)
