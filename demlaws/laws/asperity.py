"""Jamari & Schipper 2006-2008: a measured map against a smooth ball, its loading or its elastic reloading curve as a law."""

import math

import numpy as np

from demlaws.errors import DemlawsError
from demlaws.laws.definition import Definition, Limit, number
from demlaws.surface import HeightMap, read, self_affine
from demlaws.table import Nodes, grid, shape_from_nodes

_BITS = 6  # cells an octave
_SAMPLES = 12  # cuts of the map an octave
_OCTAVES = 12  # below the largest overlap
_BANDWIDTH = 0.4  # octaves, of the smoothing over the jumps where patches merge


def _contact(contact, surface, poisson, plastic_factor, plastic_ratio):
    from demlaws.asperity import RoughContact

    if isinstance(surface, str):
        surface = read(surface).without_form(2)
    if not isinstance(surface, HeightMap):
        raise DemlawsError(
            f"surface must be a demlaws.surface.HeightMap (form removed) or the path of a map, got {type(surface).__name__}; "
            "a table read from a file is used as it is"
        )
    return RoughContact(surface, contact, poisson, plastic_factor, plastic_ratio)


def _single(contact):
    if contact.size is None:
        return contact
    values = {n: np.atleast_1d(getattr(contact, n)) for n in ("radius", "modulus", "roughness")}
    if any(np.ptp(v) > 1e-12 * np.max(np.abs(v)) for v in values.values()):
        raise DemlawsError(
            "law 'asperity' is computed for one pair of bodies, the contacts given differ: make one law for each pair"
        )
    return contact.with_values(**{n: float(v[0]) for n, v in values.items()})


def _prepare(
    contact,
    surface=None,
    curve="loading",
    load=None,
    max_force=None,
    poisson=0.3,
    plastic_factor=0.71,
    plastic_ratio=160.0,
):
    """Shape of the law.

    surface: height map, form removed, or the path of one; curve: "loading" or "reloading" (elastic, after a first loading to
    `load` [N]); max_force: end of the computed curve [N], by default where the contact reaches the edge of the map or
    the bulk yields, whichever comes first. Above it the curve is extrapolated: a power law until it has Hertz's stiffness,
    then that.
    """
    if curve not in ("loading", "reloading"):
        raise DemlawsError(f"curve = {curve!r}: the curves are 'loading' and 'reloading'")
    pair = _single(contact)
    rough = _contact(pair, surface, poisson, plastic_factor, plastic_ratio)
    start = 0.0
    if curve == "reloading":
        first = rough.load(number(load, "load (first loading, for curve='reloading')", "N"), 1e-6)
        rough = rough.unload(first)
        start = rough.origin - rough.highest
    overlap, force = sample(rough, start, None if max_force is None else number(max_force, "max_force", "N"))
    over_roughness, over_radius = (1.0, 0.0) if pair.roughness > 0 else (0.0, 1.0)
    length = over_roughness * pair.roughness + over_radius * pair.radius
    coefficient = 4 / 3 * pair.modulus * math.sqrt(pair.radius)
    return _shape(
        overlap / length, (force / coefficient) ** (2 / 3) / length, pair.radius / length, over_roughness, over_radius
    )


def sample(rough, start, max_force):
    """Overlaps past `start` and forces of a `RoughContact` at evenly spaced logarithms of the overlap, up to max_force."""
    limit = _limit_force(rough) if max_force is None else max_force
    guess = max(rough.heights.sq, 1e-12)
    highest = guess * 2.0**-_OCTAVES
    step = 2.0 ** (1 / _SAMPLES)
    overlaps, forces = [], []
    while len(overlaps) < 40 * _SAMPLES:
        force, _, edge = rough._force(rough.origin - (start + highest), rough._whole())
        if force > limit or (edge and max_force is None):
            break
        overlaps.append(highest)
        forces.append(force)
        highest *= step
    forces = np.array(forces)
    used = forces > 0
    if used.sum() < 3 * _SAMPLES:
        raise DemlawsError(
            f"only {int(used.sum())} overlaps of this map carry load below {limit:.3g} N: give a larger max_force "
            "or a larger map"
        )
    if max_force is not None and edge:
        rough._advise(rough.at(start + overlaps[-1]))
    return np.array(overlaps)[used], forces[used]


def _limit_force(rough):
    from demlaws import regime

    if rough.pair.hardness is None:
        return math.inf
    return regime.transition_load(rough.pair.with_values(roughness=rough.heights.sq))


def _shape(u, s, largest, over_roughness, over_radius):
    """A smooth monotone curve through (u, s), never steeper than Hertz.

    ln s is a local parabola in ln u, wide enough to bridge the falls of force where patches merge. A slope ds/du above
    1 would be a contact stiffer than a smooth one at equal load, which comes from leaving the bulk rigid: it is cut to 1.
    """
    x, y = np.log2(u), np.log2(s)
    last = 0.9993 * u[-1]  # off the grid's nodes: a table splits the cell of a kink
    fine = np.arange(x[0], math.log2(last) + 1e-12, 1 / 64)
    fine = np.append(fine[fine < math.log2(last) - 1e-9], math.log2(last))
    value, slope = _local_parabola(x, y, fine)
    slope = np.clip(slope, 0.05, None)
    steep = slope * 2.0 ** (value - fine)  # ds/du
    steep = steep / (1.0 + steep**12) ** (1 / 12)
    curve = 2.0 ** value[0] + np.concatenate([[0.0], np.cumsum(0.5 * (steep[1:] + steep[:-1]) * np.diff(2.0**fine))])
    from scipy.interpolate import PchipInterpolator

    smooth = PchipInterpolator(2.0**fine, curve)
    rate = smooth.derivative()
    # a cubic between two nodes may pass 1 by a little: what is left of that is scaled away
    end_s, end_slope = float(smooth(last)), float(rate(last))
    exponent = max(end_slope * last / end_s, 1.2)
    # beyond its end the curve goes on as a power law until it has Hertz's stiffness, with a corner of dK/dδ at either place
    hertz = last * max(1.0, last / (exponent * end_s)) ** (1.0 / (exponent - 1.0))
    kinks = [last, hertz] if hertz > last * 1.01 else [last]
    nodes, _ = grid(2.0 ** fine[0] * (1 + 1e-12), max(0.2 * largest, 4.0 * kinks[-1]), kinks, _BITS)
    nodes = nodes[nodes >= 2.0 ** fine[0]]
    inside, beyond = nodes <= last, nodes > kinks[-1]
    between = ~inside & ~beyond
    s_nodes, slopes = np.empty(nodes.size), np.ones(nodes.size)
    s_nodes[inside], slopes[inside] = smooth(nodes[inside]), rate(nodes[inside])
    s_nodes[between] = end_s * (nodes[between] / last) ** exponent
    slopes[between] = exponent * s_nodes[between] / nodes[between]
    final = end_s * (kinks[-1] / last) ** exponent
    steepest = _steepest(nodes[~beyond], s_nodes[~beyond], slopes[~beyond])
    s_nodes[~beyond] /= steepest
    slopes[~beyond] /= steepest
    s_nodes[beyond] = final / steepest + nodes[beyond] - kinks[-1]
    twice = np.flatnonzero(np.diff(nodes) == 0)
    if len(kinks) == 2:
        slopes[twice[0] + 1] = exponent * s_nodes[twice[0]] / last
    slopes[twice[-1] + 1] = 1.0
    return shape_from_nodes(Nodes.from_curve(nodes, s_nodes, slopes), _BITS, over_roughness, over_radius)


def _steepest(u, s, slope):
    """Largest slope of the cubics between the nodes, or 1 if all are below."""
    width = np.diff(u)
    keep = width > 0
    chord, left, right = np.diff(s)[keep] / width[keep], slope[:-1][keep], slope[1:][keep]
    t = np.linspace(0, 1, 17)[:, None]
    inner = left * (1 - t) * (1 - 3 * t) + 6 * t * (1 - t) * chord + right * t * (3 * t - 2)
    return max(1.0, float(inner.max()) * (1 + 1e-9))


def _local_parabola(x, y, at):
    """Value and slope at `at` of the parabola fitted with a Gaussian weight around each place."""
    value, slope = np.empty(at.size), np.empty(at.size)
    for i, place in enumerate(at):
        d = x - place
        weight = np.exp(-0.5 * (d / _BANDWIDTH) ** 2)
        near = weight > 1e-8
        basis = np.column_stack([np.ones(near.sum()), d[near], d[near] ** 2]) * np.sqrt(weight[near])[:, None]
        value[i], slope[i], _ = np.linalg.lstsq(basis, y[near] * np.sqrt(weight[near]), rcond=None)[0]
    return value, slope


def _limits(contact, surface=None, max_force=None, **options):
    """Up to the bulk's yield, where the contact has a hardness."""
    from demlaws import regime

    if contact.hardness is None:
        return []
    roughness = surface.sq if isinstance(surface, HeightMap) else contact.roughness
    load = float(np.min(regime.transition_load(contact.with_values(roughness=roughness))))
    return [Limit(0.0, load, "the bulk yields above (p(0)/H_m = 0.6), which the model leaves out")]


def _kinks(params, **options):
    return [k * params.length for k in (params.kink1, params.kink2) if math.isfinite(k)]


LAW = Definition(
    name="asperity",
    prepare=_prepare,
    equation="P = Σ elastic-plastic ellipsoids, one a contact patch of the cut height map, of the patch's area and volume",
    source="Jamari & Schipper, Wear 262 (2007) 138; Wear 264 (2008) 349",
    description="measured surface, deterministic asperities",
    limits=_limits,
    kinks=_kinks,
    collapses=False,
    implicit=True,
    solved=True,
    needs=(),
    example={"surface": self_affine(128, 2e-6, 0.8, 2e-6, seed=1, shortest=8e-6, longest=80e-6)},
)
