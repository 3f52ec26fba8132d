"""Deterministic contact of a measured rough surface with a smooth ball or flat (Jamari & Schipper 2006-2008).

The gap map is cut at a separation; every connected patch above the cut is replaced by the elliptic paraboloid of the same
area and volume, which carries load as an elastic-plastic ellipsoid; the separation is iterated to the load. Unloading
leaves a deformed map that is the input of the next cycle. The bulk stays elastic and its deflection is left out, as in
the papers; `LoadStep.interaction` estimates it.

Between pixels the surface is made of flat triangles (two a pixel cell), so that patch areas and volumes are continuous
functions of the separation and the load can be met to any tolerance.

    contact = RoughContact(heights, pair, poisson=0.34)
    step = contact.load(0.2)                    # LoadStep: area, micro-contacts and their states
    worn = contact.unload(step)                 # RoughContact of the deformed map
    cycles = repeat(contact, 0.2, cycles=20)    # until run-in
"""

import math
import warnings
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from demlaws.core.numba_compat import kernel, loop
from demlaws.errors import DemlawsError, ValidityWarning
from demlaws.units import number

ELASTIC, ELASTIC_PLASTIC, PLASTIC = 0, 1, 2
STATES = ("elastic", "elastic-plastic", "plastic")

# --- one elastic-plastic ellipsoid


@kernel
def _elliptic(log_k):
    """m = 1 - k², K(m) by the arithmetic-geometric mean, S and m - S with E(m) = K (1 - S); nothing cancels as m → 0."""
    m = -math.expm1(2.0 * log_k)
    a, b, c2, weight = 1.0, math.exp(log_k), m, 0.5
    tail = 0.0
    for _ in range(12):
        if c2 < 1e-34:
            break
        a, b = 0.5 * (a + b), math.sqrt(a * b)
        c = c2 / (4.0 * a)
        c2 = c * c
        weight *= 2.0
        tail += weight * c2
    return m, 0.5 * math.pi / a, 0.5 * m + tail, 0.5 * m - tail


@kernel
def _ellipticity(ratio):
    """ln k, k = a/b ≤ 1, of the Hertz contact whose radii of curvature have this ratio ≥ 1 (Johnson 1985, Eq. 4.28).

    Newton on ln[(E/k² - K)/(K - E)] = ln ratio.
    """
    target = math.log(ratio)
    x = -2.0 / 3.0 * target
    if target < 1e-5:
        return x  # odd in the target: the next term is of third order
    for _ in range(50):
        m, _, s, d = _elliptic(x)
        k2 = math.exp(2.0 * x)
        slope = -1.5 if m < 1e-3 else -k2 / d + (d + k2 * s) / (m * s) - 2.0
        step = (math.log(d / s) - 2.0 * x - target) / slope
        x -= step
        if abs(step) < 4e-16 * abs(x):
            break
    return x


@kernel
def _shape_factors(ratio):
    """ᾱ, β̄, γ̄ of an ellipsoid whose radii of curvature have this ratio ≥ 1."""
    x = _ellipticity(ratio)
    _, k_integral, s, _ = _elliptic(x)
    k_integral *= 2.0 / math.pi
    e_root = (k_integral * (1.0 - s)) ** (1.0 / 3.0)
    third = math.exp(x / 3.0)
    return third * e_root, e_root / (third * third), third * third / e_root * k_integral


_STEP = 64.0  # nodes of the table below in a unit of ln ratio


def _factor_table():
    """ln ᾱβ̄ and ln γ̄ at ln ratio = -1/64, 0, 1/64 … 28: what maps with thousands of patches read in place of Newton."""
    target = np.arange(28 * _STEP + 3) / _STEP
    x = -2.0 / 3.0 * target
    for _ in range(30):
        m = -np.expm1(2.0 * x)
        m[0] = 0.5
        a, b, c2, weight, tail = np.ones_like(x), np.exp(x), m.copy(), 0.5, 0.0
        for _ in range(9):
            a, b = 0.5 * (a + b), np.sqrt(a * b)
            c2 = (c2 / (4.0 * a)) ** 2
            weight *= 2.0
            tail = tail + weight * c2
        s, d = 0.5 * m + tail, 0.5 * m - tail
        k2 = np.exp(2.0 * x)
        slope = np.where(m < 1e-3, -1.5, -k2 / d + (d + k2 * s) / (m * s) - 2.0)
        x -= np.where(target > 0, (np.log(d / s) - 2.0 * x - target) / slope, 0.0)
    e_integral, k_integral = (1.0 - s) / a, 1.0 / a
    e_integral[0] = k_integral[0] = 1.0
    table = np.column_stack([2 / 3 * np.log(e_integral) - x / 3, 2 / 3 * x - np.log(e_integral) / 3 + np.log(k_integral)])
    return np.vstack([table[1], table])  # both are even functions of ln ratio


_FACTORS = _factor_table()


@kernel
def _quick_factors(ratio):
    """ᾱβ̄ and γ̄ to 1e-10, by cubic interpolation, for ratios up to e^28."""
    place = min(math.log(ratio), 28.0) * _STEP
    i = int(place)
    t = place - i
    w0 = -t * (t - 1.0) * (t - 2.0) / 6.0
    w1 = (t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0
    w2 = -(t + 1.0) * t * (t - 2.0) / 2.0
    w3 = (t + 1.0) * t * (t - 1.0) / 6.0
    f = _FACTORS
    log_ab = w0 * f[i, 0] + w1 * f[i + 1, 0] + w2 * f[i + 2, 0] + w3 * f[i + 3, 0]
    log_gamma = w0 * f[i, 1] + w1 * f[i + 1, 1] + w2 * f[i + 2, 1] + w3 * f[i + 3, 1]
    return math.exp(log_ab), math.exp(log_gamma)


class Plasticity(NamedTuple):
    """Material of the asperities as the compiled code takes it."""

    modulus: float  # E* [Pa]
    hardness: float  # H_m [Pa]
    yield_factor: float  # K_ν: first yield at p0 = K_ν H_m
    plastic_factor: float  # c_h: mean pressure c_h H_m when fully plastic
    plastic_ratio: float  # c_A


@kernel
def _ellipsoid(p, ab, gamma, mean_radius, geometric_radius, indentation, yield_factor, elastic_only):
    """Force, contact area, state, ω1, ω2, elastic area, γ̄/(ᾱβ̄), γ̄ of one ellipsoid.

    ab, gamma: ᾱβ̄ and γ̄; mean_radius: Rm, 1/Rm = 1/Rx + 1/Ry; geometric_radius: √(Rx Ry).
    """
    elastic_area = 2.0 * math.pi * mean_radius * (ab / gamma) * indentation
    relative = indentation / gamma
    elastic_force = 4.0 * math.sqrt(2.0) / 3.0 * p.modulus * math.sqrt(mean_radius * relative) * relative
    pressure = yield_factor * p.hardness / p.modulus
    first = 0.5 * math.pi * math.pi * mean_radius * gamma * (ab * pressure) ** 2
    full = p.plastic_ratio * first * mean_radius * ab / (gamma * geometric_radius)
    if elastic_only or indentation <= first:
        return elastic_force, elastic_area, ELASTIC, first, full, elastic_area, gamma / ab, gamma
    plastic_area = 2.0 * math.pi * geometric_radius * indentation
    at_yield = 2.0 / 3.0 * yield_factor
    ceiling = max(p.plastic_factor, at_yield)
    if indentation >= full:
        return ceiling * p.hardness * plastic_area, plastic_area, PLASTIC, first, full, elastic_area, gamma / ab, gamma
    x = (indentation - first) / (full - first)
    area = elastic_area + (plastic_area - elastic_area) * x * x * (3.0 - 2.0 * x)
    mean = p.hardness * (ceiling - (ceiling - at_yield) * math.log(full / indentation) / math.log(full / first))
    return mean * area, area, ELASTIC_PLASTIC, first, full, elastic_area, gamma / ab, gamma


@loop
def _ellipsoid_loop(p, radius_x, radius_y, indentation, out):
    for i in range(indentation.size):
        rx, ry = radius_x[i], radius_y[i]
        ratio = max(rx, ry) / min(rx, ry)
        mean, geometric = rx * ry / (rx + ry), math.sqrt(rx * ry)
        alpha, beta, gamma = _shape_factors(ratio)
        values = _ellipsoid(p, alpha * beta, gamma, mean, geometric, indentation[i], p.yield_factor, False)
        out[i, 0], out[i, 1], out[i, 2], out[i, 3], out[i, 4] = values[0], values[1], values[2], values[3], values[4]
        out[i, 5] = _residual(p, mean, values[0], values[1], indentation[i], values[6], values[7], values[2])


@kernel
def _residual(p, mean_radius, force, area, indentation, gamma_over_ab, gamma, state):
    """Indentation left after unloading: the ellipsoid that carries the same force elastically over the same area."""
    if state == ELASTIC:
        return 0.0
    g = area * gamma_over_ab / (2.0 * math.pi)  # Rm' ω' of the unloaded shape
    return indentation - 3.0 * force * gamma * math.sqrt(gamma) / (4.0 * math.sqrt(2.0) * p.modulus * math.sqrt(g))


@loop
def _factors_loop(ratio, out):
    for i in range(ratio.size):
        out[i, 0], out[i, 1], out[i, 2] = _shape_factors(ratio[i])
        out[i, 3] = math.exp(_ellipticity(ratio[i]))


def shape_factors(ratio):
    """ᾱ, β̄, γ̄ and k = a/b of the elliptic Hertz contact whose principal radii have `ratio` (≥ 1).

    a = ᾱ (3PRm/(2E*))^(1/3), b = β̄ (…)^(1/3), ω = γ̄ (9P²/(32 E*² Rm))^(1/3), by exact elliptic integrals.
    """
    ratio = np.asarray(ratio, float)
    if not np.all((ratio >= 1) & (ratio < 1e12)):
        raise DemlawsError(f"ratio of radii must be from 1 to 1e12 (larger over smaller), got {ratio}")
    out = np.empty((ratio.size, 4))
    _factors_loop(ratio.ravel(), out)
    return tuple(float(c[0]) if ratio.ndim == 0 else c.reshape(ratio.shape) for c in out.T)


@loop
def quick_factors(ratio):
    """ᾱβ̄ and γ̄ as the patches of a map get them: from a table, to 1e-10."""
    return _quick_factors(ratio)


def yield_factor(poisson):
    """K_ν = 0.4645 + 0.3141 ν + 0.1943 ν²: p0/H_m at first yield (Lin & Lin)."""
    return 0.4645 + 0.3141 * poisson + 0.1943 * poisson**2


ALUMINIUM_FACTOR, ALUMINIUM_RATIO = 0.71, 160.0
"""c_h and c_A of the aluminium of Jamari & Schipper 2008: inputs of a material, which no paper gives for rock."""

MEMORIES = ("pressure", "blunting", "none")
"""What a pixel remembers of a contact that has yielded (`RoughContact.memory`)."""

REMEMBERED = {
    "pressure": "how blunt its patch has become and the pressure it has carried",
    "blunting": "how blunt its patch has become",
    "none": "nothing: geometry alone",
}


def plasticity(modulus, hardness, poisson, plastic_factor=ALUMINIUM_FACTOR, plastic_ratio=ALUMINIUM_RATIO):
    """The material of asperities: E* [Pa], H_m [Pa], ν; c_h and c_A are known for the aluminium of the papers only.

    hardness=inf: elastic asperities.
    """
    hardness = math.inf if hardness == math.inf else number(hardness, "hardness", "Pa")
    nu = number(poisson, "poisson", low=-1.0, high=0.5)
    factor = number(plastic_factor, "plastic_factor (c_h)")
    if factor < 2 / 3 * yield_factor(nu):
        raise DemlawsError(
            f"plastic_factor (c_h) = {factor:g}: the fully plastic pressure cannot be below the mean pressure at first "
            f"yield, {2 / 3 * yield_factor(nu):.3f} H_m"
        )
    ratio = number(plastic_ratio, "plastic_ratio (c_A)", low=2.0)
    return Plasticity(number(modulus, "modulus", "Pa"), hardness, yield_factor(nu), factor, ratio)


class Ellipsoids(NamedTuple):
    """Elastic-plastic ellipsoids: arrays, one entry each, SI units."""

    force: np.ndarray
    area: np.ndarray
    state: np.ndarray  # 0 elastic, 1 elastic-plastic, 2 plastic
    first_yield: np.ndarray  # ω1
    full_plasticity: np.ndarray  # ω2
    residual: np.ndarray  # indentation that stays after unloading from here


def ellipsoids(material, radius_x, radius_y, indentation):
    """Ellipsoids with principal radii Rx, Ry [m] pressed in by ω [m]: `Ellipsoids` (numbers become arrays of length 1).

    Elastic to ω1 (p0 = K_ν H_m), fully plastic from ω2 (P = c_h H_m 2π√(RxRy) ω), between them Jamari & Schipper's
    interpolation. ω1 and ω2 [our derivation] make area and force continuous at both ends. The residual indentation [our
    derivation] is that of the shape which rebuilds the same area elastically at the same force.
    """
    rx, ry, w = (np.ascontiguousarray(v, float).ravel() for v in np.broadcast_arrays(radius_x, radius_y, indentation))
    for name, values in (("radius_x", rx), ("radius_y", ry), ("indentation", w)):
        if not np.all(np.isfinite(values) & (values > 0)):
            raise DemlawsError(f"{name} must be positive and finite, in m")
    out = np.empty((w.size, 6))
    _ellipsoid_loop(material, rx, ry, w, out)
    return Ellipsoids(out[:, 0], out[:, 1], out[:, 2].astype(int), out[:, 3], out[:, 4], out[:, 5])


# --- patches of a map above a cut

# moments are about each label's first pixel (_X0, _Y0): those of a patch of a millionth of a pixel keep their digits
_AREA, _VOLUME, _X, _Y, _XX, _XY, _YY, _EDGE, _SPREAD, _LIMIT, _X0, _Y0 = range(12)


@kernel
def _root(parent, i):
    while parent[i] != i:
        parent[i] = parent[parent[i]]
        i = parent[i]
    return i


@kernel
def _add(stats, i, area, volume, x1, y1, x2, y2, x3, y3):
    """Add a triangle of this area (negative: take it away) to patch i."""
    sx, sy = x1 + x2 + x3, y1 + y2 + y3
    stats[i, _AREA] += area
    stats[i, _VOLUME] += volume
    stats[i, _X] += area * sx / 3.0
    stats[i, _Y] += area * sy / 3.0
    stats[i, _XX] += area / 12.0 * (x1 * x1 + x2 * x2 + x3 * x3 + sx * sx)
    stats[i, _XY] += area / 12.0 * (x1 * y1 + x2 * y2 + x3 * y3 + sx * sy)
    stats[i, _YY] += area / 12.0 * (y1 * y1 + y2 * y2 + y3 * y3 + sy * sy)


@kernel
def _one_above(stats, i, u1, u2, u3, x1, y1, x2, y2, x3, y3):
    s, t = u1 / (u1 - u2), u1 / (u1 - u3)
    area = 0.5 * s * t
    _add(
        stats, i, area, area * u1 / 3.0, x1, y1, x1 + s * (x2 - x1), y1 + s * (y2 - y1), x1 + t * (x3 - x1), y1 + t * (y3 - y1)
    )
    return area


@kernel
def _one_below(stats, i, u1, u2, u3, x1, y1, x2, y2, x3, y3):
    """Vertex 1 below: the whole triangle less its corner."""
    s, t = u1 / (u1 - u2), u1 / (u1 - u3)
    area = 0.5 * s * t
    _add(stats, i, 0.5, (u1 + u2 + u3) / 6.0, x1, y1, x2, y2, x3, y3)
    _add(
        stats,
        i,
        -area,
        -area * u1 / 3.0,
        x1,
        y1,
        x1 + s * (x2 - x1),
        y1 + s * (y2 - y1),
        x1 + t * (x3 - x1),
        y1 + t * (y3 - y1),
    )
    return 0.5 - area


@kernel
def _triangle(stats, i, u1, u2, u3, x1, y1, x2, y2, x3, y3):
    """The part above the cut of one triangle (half a cell, area 1/2); returns its area."""
    if u1 + u2 + u3 - (u1 + u2 + u3) != 0.0:
        return 0.0  # a missing pixel
    above = (1 if u1 > 0.0 else 0) + (2 if u2 > 0.0 else 0) + (4 if u3 > 0.0 else 0)
    if above == 7:
        _add(stats, i, 0.5, (u1 + u2 + u3) / 6.0, x1, y1, x2, y2, x3, y3)
        return 0.5
    if above == 1:
        return _one_above(stats, i, u1, u2, u3, x1, y1, x2, y2, x3, y3)
    if above == 2:
        return _one_above(stats, i, u2, u3, u1, x2, y2, x3, y3, x1, y1)
    if above == 4:
        return _one_above(stats, i, u3, u1, u2, x3, y3, x1, y1, x2, y2)
    if above == 6:
        return _one_below(stats, i, u1, u2, u3, x1, y1, x2, y2, x3, y3)
    if above == 5:
        return _one_below(stats, i, u2, u3, u1, x2, y2, x3, y3, x1, y1)
    if above == 3:
        return _one_below(stats, i, u3, u1, u2, x3, y3, x1, y1, x2, y2)
    return 0.0


@loop
def _scan(h, cut, window, labels, mask, parent, stats, spread, limit):
    """Label the patches of h > cut inside the window and gather area, volume and moments of each, in one pass.

    window: [top, bottom, left, right], inclusive, shrunk to the pixels above the cut. labels: two rows (mask = 1) or the
    whole map (mask = -1) for provisional labels. parent, stats: room for them; returns their number, or -1 if the room
    does not do. spread, limit: memory of earlier contact, or arrays of shape (0, 0).
    Neighbours are those joined by an edge of the triangulation: left, up, and up-left.
    """
    top, bottom, left, right = window[0], window[1], window[2], window[3]
    rows, columns = h.shape
    remembers = spread.shape[0] > 0
    new_top, new_bottom, new_left, new_right = bottom + 1, top - 1, right + 1, left - 1
    count = 0
    # one ring outside the window belongs to the cells that the contour crosses
    first_row, last_row = max(top - 1, 0), min(bottom + 1, rows - 1)
    first_column, last_column = max(left - 1, 0), min(right + 1, columns - 1)
    for i in range(first_row, last_row + 1):
        row, previous = i & mask, (i - 1) & mask
        north_west = west = 0
        for j in range(first_column, last_column + 1):
            here = h[i, j]
            north = labels[previous, j] if i > first_row else 0
            label = 0
            if here > cut:
                if north_west:
                    label = north_west
                elif north:
                    label = north
                    if west:
                        a, b = _root(parent, north), _root(parent, west)
                        if a < b:
                            parent[b] = a
                        elif b < a:
                            parent[a] = b
                elif west:
                    label = west
                else:
                    count += 1
                    if count >= parent.size:
                        return -1
                    label = count
                    parent[count] = count
                    for n in range(10):
                        stats[count, n] = 0.0
                    stats[count, 10] = j
                    stats[count, 11] = i
                if i < new_top:
                    new_top = i
                new_bottom = i
                if j < new_left:
                    new_left = j
                if j > new_right:
                    new_right = j
                if i == 0 or j == 0 or i == rows - 1 or j == columns - 1:
                    stats[label, _EDGE] = 1.0
            labels[row, j] = label
            if i > first_row and j > first_column and (label or north or west or north_west):
                u1, u2, u3, u4 = h[i - 1, j - 1] - cut, h[i - 1, j] - cut, h[i, j - 1] - cut, here - cut
                upper = north_west if north_west else (north if north else label)
                lower = north_west if north_west else (west if west else label)
                upper_area = lower_area = 0.0
                if label and north and west and north_west:
                    upper_area = lower_area = 0.5
                    xc, yc = j - 0.5 - stats[label, _X0], i - 0.5 - stats[label, _Y0]
                    stats[label, _AREA] += 1.0
                    stats[label, _VOLUME] += (2.0 * u1 + u2 + u3 + 2.0 * u4) / 6.0
                    stats[label, _X] += xc
                    stats[label, _Y] += yc
                    stats[label, _XX] += xc * xc + 1.0 / 12.0
                    stats[label, _XY] += xc * yc
                    stats[label, _YY] += yc * yc + 1.0 / 12.0
                else:
                    if upper:
                        x, y = j - stats[upper, _X0], i - stats[upper, _Y0]
                        upper_area = _triangle(stats, upper, u1, u2, u4, x - 1.0, y - 1.0, x, y - 1.0, x, y)
                    if lower:
                        x, y = j - stats[lower, _X0], i - stats[lower, _Y0]
                        lower_area = _triangle(stats, lower, u1, u3, u4, x - 1.0, y - 1.0, x - 1.0, y, x, y)
                if remembers:
                    if upper_area > 0.0:
                        share = upper_area / 3.0
                        stats[upper, _SPREAD] += share * (spread[i - 1, j - 1] + spread[i - 1, j] + spread[i, j])
                        stats[upper, _LIMIT] += share * (limit[i - 1, j - 1] + limit[i - 1, j] + limit[i, j])
                    if lower_area > 0.0:
                        share = lower_area / 3.0
                        stats[lower, _SPREAD] += share * (spread[i - 1, j - 1] + spread[i, j - 1] + spread[i, j])
                        stats[lower, _LIMIT] += share * (limit[i - 1, j - 1] + limit[i, j - 1] + limit[i, j])
            north_west, west = north, label
    window[0], window[1], window[2], window[3] = new_top, new_bottom, new_left, new_right
    return count


@loop
def _gather_patches(parent, stats, count):
    """Sum provisional labels into patches, move patches to the front; parent then holds each label's patch (from 1)."""
    for i in range(count, 0, -1):
        if parent[i] != i:
            to = parent[i]
            dx, dy = stats[i, _X0] - stats[to, _X0], stats[i, _Y0] - stats[to, _Y0]
            area, x, y = stats[i, _AREA], stats[i, _X], stats[i, _Y]
            stats[to, _AREA] += area
            stats[to, _VOLUME] += stats[i, _VOLUME]
            stats[to, _X] += x + dx * area
            stats[to, _Y] += y + dy * area
            stats[to, _XX] += stats[i, _XX] + dx * (2.0 * x + dx * area)
            stats[to, _XY] += stats[i, _XY] + dx * y + dy * x + dx * dy * area
            stats[to, _YY] += stats[i, _YY] + dy * (2.0 * y + dy * area)
            stats[to, _EDGE] = max(stats[to, _EDGE], stats[i, _EDGE])
            stats[to, _SPREAD] += stats[i, _SPREAD]
            stats[to, _LIMIT] += stats[i, _LIMIT]
    patches = 0
    for i in range(1, count + 1):
        if parent[i] == i:
            patches += 1
            for n in range(12):
                stats[patches, n] = stats[i, n]
            parent[i] = patches
        else:
            parent[i] = parent[parent[i]]
    return patches


@kernel
def _paraboloid(stats, i, pixel_x, pixel_y):
    """Area, indentation ω = 2V/A, axes ratio ≥ 1, orientation of the long axis of patch i."""
    area = stats[i, _AREA]
    x, y = stats[i, _X] / area, stats[i, _Y] / area
    xx = (stats[i, _XX] / area - x * x) * pixel_x * pixel_x
    yy = (stats[i, _YY] / area - y * y) * pixel_y * pixel_y
    xy = (stats[i, _XY] / area - x * y) * pixel_x * pixel_y
    half, mean = math.sqrt(0.25 * (xx - yy) ** 2 + xy * xy), 0.5 * (xx + yy)
    small = max(mean - half, 1e-6 * mean)
    aspect = math.sqrt((mean + half) / small) if mean > 0.0 else 1.0
    return area * pixel_x * pixel_y, 2.0 * stats[i, _VOLUME] / area, aspect, 0.5 * math.atan2(2.0 * xy, xx - yy)


@kernel
def _response(p, stats, i, paraboloid, remembers, elastic_only):
    """What patch i remembers (blunting, pressure factor at its yield), its mean radius, and what `_ellipsoid` gives for it."""
    cut_area, indentation, aspect, _ = paraboloid
    blunt = stats[i, _SPREAD] / stats[i, _AREA] if remembers else 1.0
    limit = stats[i, _LIMIT] / stats[i, _AREA] if remembers else p.yield_factor
    geometric = blunt * cut_area / (2.0 * math.pi * indentation)
    mean = geometric / (aspect + 1.0 / aspect)
    ab, gamma = _quick_factors(aspect * aspect)
    return (blunt, limit), mean, _ellipsoid(p, ab, gamma, mean, geometric, indentation, limit, elastic_only)


@loop
def _carry(p, stats, patches, pixel_x, pixel_y, remembers, elastic_only):
    """Force and contact area of all patches, and whether one touches the edge of the map."""
    force = area = edge = 0.0
    for i in range(1, patches + 1):
        if not (stats[i, _AREA] > 0.0 and stats[i, _VOLUME] > 0.0):
            continue
        _, _, values = _response(p, stats, i, _paraboloid(stats, i, pixel_x, pixel_y), remembers, elastic_only)
        force += values[0]
        area += values[1]
        edge = max(edge, stats[i, _EDGE])
    return force, area, edge


_COLUMNS = (
    "x", "y", "cut_area", "volume", "length_long", "length_short", "angle", "indentation", "force", "area", "state",
    "shrink", "spread", "limit", "edge",
)  # fmt: skip


@loop
def _describe(p, stats, patches, pixel_x, pixel_y, remembers, elastic_only, out):
    """Everything about each patch, one row each, columns as in _COLUMNS; patches without volume get zeros."""
    for n in range(patches):
        i = n + 1
        for c in range(out.shape[1]):
            out[n, c] = 0.0
        out[n, 11] = out[n, 12] = 1.0
        out[n, 13] = p.yield_factor
        if not (stats[i, _AREA] > 0.0 and stats[i, _VOLUME] > 0.0):
            continue
        cut_area, indentation, aspect, angle = paraboloid = _paraboloid(stats, i, pixel_x, pixel_y)
        (blunt, limit), mean, values = _response(p, stats, i, paraboloid, remembers, elastic_only)
        force, area, state = values[0], values[1], values[2]
        out[n, 0] = (stats[i, _X] / stats[i, _AREA] + stats[i, _X0]) * pixel_x
        out[n, 1] = (stats[i, _Y] / stats[i, _AREA] + stats[i, _Y0]) * pixel_y
        out[n, 2] = cut_area
        out[n, 3] = stats[i, _VOLUME] * pixel_x * pixel_y
        side = math.sqrt(4.0 * cut_area / math.pi)
        out[n, 4], out[n, 5] = side * math.sqrt(aspect), side / math.sqrt(aspect)
        out[n, 6], out[n, 7] = angle, indentation
        out[n, 8], out[n, 9], out[n, 10] = force, area, state
        residual = _residual(p, mean, force, area, indentation, values[6], values[7], state)
        if state != ELASTIC:
            out[n, 11] = 1.0 - residual / indentation
            out[n, 12] = blunt * area / values[5]
            out[n, 13] = 1.5 * force / (area * p.hardness) * (1.0 + 1e-9)  # rounding is no yield
        else:
            out[n, 12], out[n, 13] = blunt, limit
        out[n, 14] = stats[i, _EDGE]


@loop
def _deform(h, cut, labels, patch_of, described, heights, spread, limit):
    """Shrink plastic patches towards the cut, together with the ring of pixels round them, and note what they remember.

    Scaling h - cut on both sides of the contour keeps the contour, and so the area, where it is. The pixels of the ring
    rise: the pile-up. One that borders several patches follows the one that shrinks least, and remembers the highest pressure.
    """
    rows, columns = h.shape
    for i in range(rows):
        for j in range(columns):
            label = labels[i, j]
            chosen, carried = -1, 0.0
            if label:
                chosen = patch_of[label] - 1
                if described[chosen, 10] != ELASTIC:
                    carried = described[chosen, 13]
            elif h[i, j] == h[i, j]:
                largest = -1.0
                for di in range(-1, 2):
                    for dj in range(-1, 2):
                        if di == -dj and di != 0:
                            continue  # not an edge of the triangulation
                        a, b = i + di, j + dj
                        if 0 <= a < rows and 0 <= b < columns and labels[a, b]:
                            n = patch_of[labels[a, b]] - 1
                            if described[n, 11] > largest:
                                largest, chosen = described[n, 11], n
                            if described[n, 10] != ELASTIC:
                                carried = max(carried, described[n, 13])
            if carried > 0.0:
                limit[i, j] = carried
            if chosen >= 0 and described[chosen, 10] != ELASTIC:
                heights[i, j] += (described[chosen, 11] - 1.0) * (h[i, j] - cut)
                spread[i, j] = described[chosen, 12]


@loop
def _interaction(x, y, force, modulus):
    """Σ_i Σ_{j≠i} P_i P_j/(π E* r_ij) / Σ P_i: force-weighted sinking of each micro-contact by all others."""
    work = total = 0.0
    for i in range(x.size):
        u = 0.0
        for j in range(i):
            u += force[j] / math.sqrt((x[i] - x[j]) ** 2 + (y[i] - y[j]) ** 2)
        work += force[i] * u
        total += force[i]
    return 2.0 * work / (math.pi * modulus * total) if total > 0.0 else 0.0


@loop
def _subtract_ball(z, pixel_x, pixel_y, radius, x0, y0, out):
    highest = -math.inf
    for i in range(z.shape[0]):
        for j in range(z.shape[1]):
            x, y = j * pixel_x - x0, i * pixel_y - y0
            out[i, j] = z[i, j] - (x * x + y * y) / (2.0 * radius)
            if out[i, j] > highest:
                highest = out[i, j]
    return highest


class MicroContacts:
    """Micro-contacts, one entry each: x, y [m] from the map's first pixel, cut_area and volume above the cut [m², m³],
    length_long, length_short, angle of the ellipse, indentation ω, force, contact area, state, edge (touches the map's edge).
    """

    def __init__(self, table):
        self.table = table

    def __len__(self):
        return len(self.table)

    def __getattr__(self, name):
        if name in _COLUMNS:
            column = self.table[:, _COLUMNS.index(name)]
            return column.astype(int) if name == "state" else column
        raise AttributeError(f"micro-contacts have {', '.join(_COLUMNS)}, not {name!r}")


@dataclass(frozen=True)
class LoadStep:
    """A rough contact under load. SI units.

    load; separation of ball apex or flat from the mean plane of the map; overlap since first touch; contact_area (real);
    cut_area and volume of the map above the cut; counts: number of micro-contacts that are elastic, elastic-plastic, plastic;
    micro: `MicroContacts`; evaluations: cuts of the map that the iteration took.
    """

    load: float
    separation: float
    overlap: float
    contact_area: float
    cut_area: float
    volume: float
    counts: tuple
    micro: MicroContacts
    evaluations: int
    cut: float
    touches_edge: bool
    modulus: float

    @property
    def interaction(self):
        """Force-weighted mean sinking [m] of the micro-contacts under each other's load, P/(π E* r) [our estimate].

        The separation does not hold it: the bulk is rigid in the model. Cost grows as the square of their number.
        """
        columns = (np.ascontiguousarray(c) for c in (self.micro.x, self.micro.y, self.micro.force))
        return _interaction(*columns, self.modulus)

    def __str__(self):
        states = ", ".join(f"{n} {name}" for n, name in zip(self.counts, STATES, strict=True))
        return (
            f"load {self.load:.6g} N at separation {self.separation * 1e6:.4g} µm (overlap {self.overlap * 1e6:.4g} µm)\n"
            f"contact area {self.contact_area * 1e12:.5g} µm² in {len(self.micro)} micro-contacts: {states}"
            + (
                "; all are fully plastic, so the area is the load over c_h H_m, whatever the map"
                if self.counts[2] == len(self.micro) > 0
                else ""
            )
        )


@dataclass
class RoughContact:
    """A rough map against a smooth ball of the pair's effective radius, or a flat.

    heights: `demlaws.surface.HeightMap`, form removed; pair: `demlaws.Contact` (its radius, modulus and hardness are used);
    poisson: ν of the rough body; flat=True: the counter-body is a flat; centre: (x, y) [m] of the ball's axis from the first
    pixel (default the middle). Missing pixels never touch; fill them first if they should. Without a hardness the asperities
    are elastic. plastic_factor, plastic_ratio: c_h and c_A of the material; where they are not given aluminium's are taken,
    with a ValidityWarning. memory: what unloading leaves in a pixel besides its height, an assumption that the papers do
    not name: "pressure" (how much blunter its patch is than its outline tells, and the pressure that it has carried, up to
    which it stays elastic: work hardening, residual stress), "blunting" (the first alone), "none" (geometry alone). Only with
    "pressure" does the same load change nothing the second time [our derivation].
    """

    heights: object
    pair: object
    poisson: float = 0.3
    plastic_factor: float | None = None
    plastic_ratio: float | None = None
    flat: bool = False
    centre: tuple | None = None
    memory: str = "pressure"
    spread: np.ndarray | None = field(default=None, repr=False)
    limit: np.ndarray | None = field(default=None, repr=False)
    origin: float | None = None

    def __post_init__(self):
        if self.pair.size is not None:
            raise DemlawsError("a height map belongs to one contact; this pair is an array of contacts")
        if self.memory not in MEMORIES:
            raise DemlawsError(f"memory = {self.memory!r}: a pixel remembers {', '.join(map(repr, MEMORIES))}")
        hardness = math.inf if self.pair.hardness is None else self.pair.hardness
        if self.pair.hardness is not None and None in (self.plastic_factor, self.plastic_ratio):
            warnings.warn(
                f"c_h = {ALUMINIUM_FACTOR} and c_A = {ALUMINIUM_RATIO:g} are aluminium's: give plastic_factor and "
                "plastic_ratio of this material",
                ValidityWarning,
                stacklevel=3,
            )
        self.plastic_factor = ALUMINIUM_FACTOR if self.plastic_factor is None else self.plastic_factor
        self.plastic_ratio = ALUMINIUM_RATIO if self.plastic_ratio is None else self.plastic_ratio
        self.material = plasticity(self.pair.modulus, hardness, self.poisson, self.plastic_factor, self.plastic_ratio)
        rows, columns = self.heights.shape
        px, py = self.heights.pixel_x, self.heights.pixel_y
        if self.centre is None:
            self.centre = (0.5 * (columns - 1) * px, 0.5 * (rows - 1) * py)
        self.gap = np.empty(self.heights.shape)
        radius = math.inf if self.flat else self.pair.radius
        self.highest = _subtract_ball(self.heights.heights, px, py, radius, *self.centre, self.gap)
        if self.origin is None:
            self.origin = self.highest  # where a virgin surface first touches; overlaps count from here
        self.mean = float(np.nanmean(self.heights.heights))
        self._parent = np.zeros(1024, np.int32)
        self._stats = np.zeros((1024, 12))
        self._rows = np.zeros((2, columns), np.int32)
        self._warned = set()

    def _patches(self, cut, window, labels=None):
        none = np.empty((0, 0))
        spread, limit = (none, none) if self.spread is None else (self.spread, self.limit)
        buffer, mask = (self._rows, 1) if labels is None else (labels, -1)
        start = window.copy()
        while True:
            count = _scan(self.gap, cut, window, buffer, mask, self._parent, self._stats, spread, limit)
            if count >= 0:
                break
            window[:] = start
            size = min(4 * self._parent.size, self.gap.size // 2 + 2)
            self._parent, self._stats = np.zeros(size, np.int32), np.zeros((size, 12))
        return _gather_patches(self._parent, self._stats, count)

    def _whole(self):
        return np.array([0, self.gap.shape[0] - 1, 0, self.gap.shape[1] - 1])

    def _force(self, cut, window, elastic_only=False):
        patches = self._patches(cut, window)
        px, py = self.heights.pixel_x, self.heights.pixel_y
        return _carry(self.material, self._stats, patches, px, py, self.spread is not None, elastic_only)

    def at(self, overlap, elastic_only=False, labels=None, evaluations=1):
        """The `LoadStep` at a given overlap [m] since first touch of the virgin surface."""
        cut = self.origin - overlap
        window = self._whole()
        patches = self._patches(cut, window, labels)
        table = np.empty((patches, len(_COLUMNS)))
        px, py = self.heights.pixel_x, self.heights.pixel_y
        remembers = self.spread is not None
        _describe(self.material, self._stats, patches, px, py, remembers, elastic_only, table)
        held = table if labels is not None else table[table[:, 8] > 0]
        micro = MicroContacts(held[held[:, 8] > 0])
        step = LoadStep(
            load=float(held[:, 8].sum()),
            separation=cut - self.mean,
            overlap=overlap,
            contact_area=float(held[:, 9].sum()),
            cut_area=float(held[:, 2].sum()),
            volume=float(held[:, 3].sum()),
            counts=tuple(int((micro.state == s).sum()) for s in range(3)),
            micro=micro,
            evaluations=evaluations,
            cut=cut,
            touches_edge=bool(held[:, 14].any()),
            modulus=self.material.modulus,
        )
        return (step, table) if labels is not None else step

    def _solve(self, load, tolerance, elastic_only=False, guess=None):
        """Overlap at which the patches carry `load` within `tolerance`, and how many cuts that took.

        The force falls in jumps where patches merge, and rises continuously between: a bracket whose upper end carries
        less than the load and whose lower end carries more closes on a continuous crossing.
        """
        base = self.origin - self.highest  # below this overlap nothing touches (a worn surface)
        scale = max(self.heights.sq, 1e-15 * abs(self.highest), 1e-300)
        if guess is None or guess <= base:
            hertz = 0.0 if self.flat else (9 * load**2 / (16 * self.pair.radius * self.pair.modulus**2)) ** (1 / 3)
            guess = base + max(hertz, 0.5 * scale)
        deepest = None
        window = self._whole()
        low, high = base, math.inf
        low_f, high_f = -math.inf, math.inf
        x, evaluations, side = guess, 0, 0
        while evaluations < 300:
            trial = (self._high_window if high < math.inf else window).copy()
            force, _, _ = self._force(self.origin - x, trial, elastic_only)
            evaluations += 1
            if abs(force - load) <= tolerance * load:
                return x, evaluations
            f = math.log(force / load) if force > 0 else -math.inf
            if f < 0:
                if side < 0 and high < math.inf:
                    high_f *= 0.5
                low, low_f, side = x, f, -1
            else:
                if side > 0 and low_f > -math.inf:
                    low_f *= 0.5
                high, high_f, side = x, f, 1
                self._high_window = trial
            if high == math.inf:
                if deepest is None:
                    deepest = self.origin - float(np.nanmin(self.gap)) + 10 * scale
                if x > deepest:
                    raise DemlawsError(
                        f"load = {load:g} N presses the whole map flat, at {force:.3g} N: give a smaller load or a larger map"
                    )
                x = base + (x - base) * (4.0 if f == -math.inf else min(max(math.exp(-0.6 * f), 1.2), 8.0))
            elif low_f == -math.inf:
                x = base + (x - base) * (min(max(math.exp(-0.6 * f), 0.05), 0.8) if side > 0 else 1.5)
                if x >= high or x <= low:
                    x = 0.5 * (low + high)
            else:
                # secant in log-log of the interference, kept off the ends; every sixth step halves
                a, b = math.log(low - base), math.log(high - base)
                share = -low_f / (high_f - low_f) if evaluations % 6 else 0.5
                x = base + math.exp(a + min(max(share, 0.02), 0.98) * (b - a))
                if not low < x < high:
                    break
        raise DemlawsError(
            f"no separation carries {load:g} N within {tolerance:g}: the force jumps there from {math.exp(low_f) * load:g} N; "
            "give a larger tolerance or a map with more pixels in contact"
        )

    def load(self, load, tolerance=0.01, elastic_only=False, guess=None):
        """Press until the micro-contacts carry `load` [N] within `tolerance` (relative): a `LoadStep`.

        Warns (ValidityWarning) where the regime criterion says that the bulk yields too, and where the contact reaches
        the edge of the map.
        """
        load = number(load, "load", "N")
        tolerance = number(tolerance, "tolerance", high=1.0)
        overlap, evaluations = self._solve(load, tolerance, elastic_only, guess)
        step = self.at(overlap, elastic_only, evaluations=evaluations)
        self._advise(step)
        return step

    def _advise(self, step):
        from demlaws import criterion

        if self.flat:
            return
        if self.pair.hardness is not None and "bulk" not in self._warned:
            ratio = criterion.pressure_ratio(self.pair.with_values(roughness=self.heights.sq), step.load)
            if ratio >= criterion.YIELD_RATIO:
                self._warned.add("bulk")
                warnings.warn(
                    f"asperity: at {step.load:.3g} N p(0)/H_m = {ratio:.2f} ≥ {criterion.YIELD_RATIO}: the bulk yields too, "
                    "which this model leaves out",
                    ValidityWarning,
                    stacklevel=4,
                )
        if step.touches_edge and "edge" not in self._warned:
            self._warned.add("edge")
            warnings.warn(
                f"asperity: at {step.load:.3g} N the contact reaches the edge of the map: its load is a lower bound; "
                "measure a larger area",
                ValidityWarning,
                stacklevel=4,
            )

    def unload(self, step):
        """The `RoughContact` that `step` leaves behind: plastic patches lowered, with what `memory` says that pixels keep.

        A plastic patch of indentation ω keeps ω' = 3P γ̄^1.5/(4√2 E* √g), g = A γ̄/(2π ᾱβ̄): the height of the ellipsoid that
        carries the same force elastically over the same area A [our derivation].
        """
        labels = np.zeros(self.gap.shape, np.int32)
        _, table = self.at(step.overlap, labels=labels)
        heights = self.heights.heights.copy()
        spread = np.ones(self.gap.shape) if self.spread is None else self.spread.copy()
        limit = np.full(self.gap.shape, self.material.yield_factor) if self.limit is None else self.limit.copy()
        _deform(self.gap, step.cut, labels, self._parent, table, heights, spread, limit)
        del labels
        if self.memory == "none":
            spread = limit = None
        elif self.memory == "blunting":
            limit[:] = self.material.yield_factor
        return RoughContact(
            self.heights.with_heights(heights),
            self.pair,
            self.poisson,
            self.plastic_factor,
            self.plastic_ratio,
            self.flat,
            self.centre,
            self.memory,
            spread,
            limit,
            self.origin,
        )


class Cycle(NamedTuple):
    """One cycle of loading and unloading."""

    number: int
    step: LoadStep
    contact: RoughContact  # after unloading
    change: float  # volume by which the map changed [m³], ∫|Δz|
    relative_change: float  # over the change of the first cycle


def repeat(contact, load, cycles=20, tolerance=1e-4, run_in=0.01, keep=None, stop=False):
    """Load to `load` [N] and unload, `cycles` times, each time on the map that the last one left: list of `Cycle`.

    Run-in is the first cycle whose change of the map is below `run_in` (ε_r) times the first's; stop=True ends there.
    keep: numbers of the cycles whose maps are kept (default all); others hold contact=None.
    """
    history = []
    first = None
    pixel = contact.heights.pixel_x * contact.heights.pixel_y
    for n in range(1, cycles + 1):
        # starting where the last cycle ended, a map that has run in meets the load at once
        step = contact.load(load, tolerance, guess=history[-1].step.overlap if history else None)
        worn = contact.unload(step)
        change = float(np.nansum(np.abs(worn.heights.heights - contact.heights.heights))) * pixel
        first = change if first is None else first
        relative = change / first if first > 0 else 0.0
        worn._warned = contact._warned
        history.append(Cycle(n, step, worn if keep is None or n in keep else None, change, relative))
        contact = worn
        if stop and n > 1 and relative <= run_in:
            break
    return history


def run_in_cycle(history, run_in=0.01):
    """Number of the last cycle that still changed the map by more than `run_in` of the first's change."""
    return max((c.number for c in history if c.relative_change > run_in), default=0)


def nine_point_summits(heights, cut=-math.inf):
    """Summits higher than all eight neighbours and above `cut` [m]: x, y, z [m] and mean radius of curvature [m].

    The classical definition, beside which the volume-conserving patches stand. The radius comes from three-point
    curvatures, 2/R = -(z_xx + z_yy).
    """
    z = heights.heights
    middle = z[1:-1, 1:-1]
    summit = middle > cut
    for di in range(3):
        for dj in range(3):
            if (di, dj) != (1, 1):
                summit &= middle > z[di : di + middle.shape[0], dj : dj + middle.shape[1]]
    i, j = np.nonzero(summit)
    i, j = i + 1, j + 1
    curvature = (2 * z[i, j] - z[i, j - 1] - z[i, j + 1]) / heights.pixel_x**2
    curvature = curvature + (2 * z[i, j] - z[i - 1, j] - z[i + 1, j]) / heights.pixel_y**2
    return j * heights.pixel_x, i * heights.pixel_y, z[i, j], 2.0 / curvature


class Summits(NamedTuple):
    """The nine-point summits of a map as Greenwood & Tripp's model takes them."""

    total: int
    density: float  # η [1/m²]
    radius: float  # β = 1/⟨curvature⟩ [m]
    mean_radius: float  # ⟨radius⟩ [m] of those that are convex: few flat ones make it larger
    height: float  # mean height of the summits over the mean plane [m]
    spread: float  # their rms height about that [m]
    roughness: float  # Sq of the surface [m]: the σ_s of Jamari & Schipper

    def mu(self, radius):
        """μ = (8/3) η σ √(2Rβ) against a ball of `radius` [m], σ the surface's Sq as in the paper of 2006."""
        return 8.0 / 3.0 * self.density * self.roughness * math.sqrt(2.0 * number(radius, "radius", "m") * self.radius)


def summits(heights):
    """`Summits` of a levelled height map; raises DemlawsError where it has none. η and β depend on the pixel."""
    _, _, z, radius = nine_point_summits(heights)
    if z.size == 0:
        raise DemlawsError("the map has no pixel that is higher than its eight neighbours")
    rows, columns = heights.shape
    area = (rows - 2) * heights.pixel_y * (columns - 2) * heights.pixel_x
    convex = radius[radius > 0]
    return Summits(
        total=z.size,
        density=z.size / area,
        radius=float(1.0 / np.mean(1.0 / radius)),
        mean_radius=float(np.mean(convex[np.isfinite(convex)])),
        height=float(np.mean(z) - np.nanmean(heights.heights)),
        spread=float(np.std(z)),
        roughness=heights.sq,
    )
