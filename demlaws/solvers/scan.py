"""Patches of a map above a cut: labels, areas, volumes and moments, and the elliptic paraboloid of each patch.

Between pixels the surface is made of flat triangles (two per pixel cell), so that areas and volumes are continuous functions of
the cut.
"""

import math

from demlaws.core.numba_compat import kernel, loop

# moments are about each label's first pixel (X0, Y0): those of a patch of a millionth of a pixel keep their digits
AREA, VOLUME, X, Y, XX, XY, YY, EDGE, SPREAD, LIMIT, X0, Y0 = range(12)


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
    stats[i, AREA] += area
    stats[i, VOLUME] += volume
    stats[i, X] += area * sx / 3.0
    stats[i, Y] += area * sy / 3.0
    stats[i, XX] += area / 12.0 * (x1 * x1 + x2 * x2 + x3 * x3 + sx * sx)
    stats[i, XY] += area / 12.0 * (x1 * y1 + x2 * y2 + x3 * y3 + sx * sy)
    stats[i, YY] += area / 12.0 * (y1 * y1 + y2 * y2 + y3 * y3 + sy * sy)


@kernel
def _corner(stats, i, sign, u1, u2, u3, x1, y1, x2, y2, x3, y3):
    """Add (sign 1) or take away (-1) the corner at vertex 1 that the cut divides from the other two; returns its area."""
    s, t = u1 / (u1 - u2), u1 / (u1 - u3)
    area = 0.5 * s * t
    x2, y2, x3, y3 = x1 + s * (x2 - x1), y1 + s * (y2 - y1), x1 + t * (x3 - x1), y1 + t * (y3 - y1)
    _add(stats, i, sign * area, sign * area * u1 / 3.0, x1, y1, x2, y2, x3, y3)
    return area


@kernel
def _triangle(stats, i, u1, u2, u3, x1, y1, x2, y2, x3, y3):
    """The part above the cut of one triangle (half a cell, area 1/2); returns its area."""
    if u1 + u2 + u3 - (u1 + u2 + u3) != 0.0:
        return 0.0  # a missing pixel
    above = (1 if u1 > 0.0 else 0) + (2 if u2 > 0.0 else 0) + (4 if u3 > 0.0 else 0)
    if above == 0:
        return 0.0
    alone = above == 1 or above == 2 or above == 4
    if not alone:
        _add(stats, i, 0.5, (u1 + u2 + u3) / 6.0, x1, y1, x2, y2, x3, y3)
        if above == 7:
            return 0.5
    sign = 1.0 if alone else -1.0
    if above == 1 or above == 6:
        area = _corner(stats, i, sign, u1, u2, u3, x1, y1, x2, y2, x3, y3)
    elif above == 2 or above == 5:
        area = _corner(stats, i, sign, u2, u3, u1, x2, y2, x3, y3, x1, y1)
    else:
        area = _corner(stats, i, sign, u3, u1, u2, x3, y3, x1, y1, x2, y2)
    return area if alone else 0.5 - area


@kernel
def _join(parent, first, second):
    """Make two labels one patch."""
    a, b = _root(parent, first), _root(parent, second)
    if a < b:
        parent[b] = a
    elif b < a:
        parent[a] = b


@kernel
def _add_cell(stats, patch, i, j, u1, u2, u3, u4):
    """Add a cell whose four corners are above the cut."""
    x, y = j - 0.5 - stats[patch, X0], i - 0.5 - stats[patch, Y0]
    stats[patch, AREA] += 1.0
    stats[patch, VOLUME] += (2.0 * u1 + u2 + u3 + 2.0 * u4) / 6.0
    stats[patch, X] += x
    stats[patch, Y] += y
    stats[patch, XX] += x * x + 1.0 / 12.0
    stats[patch, XY] += x * y
    stats[patch, YY] += y * y + 1.0 / 12.0


@kernel
def _add_memory(stats, patch, area, spread, limit):
    """Add the memory of a triangle, given as the sums over its corners."""
    if area > 0.0:
        stats[patch, SPREAD] += area / 3.0 * spread
        stats[patch, LIMIT] += area / 3.0 * limit


@loop
def scan(h, cut, labels, parent, stats, spread, limit):
    """Label the patches of h > cut and gather area, volume and moments of each, in one pass.

    labels: provisional ones, of the map's shape.
    parent, stats: room for them; returns their number. spread, limit: memory of earlier contact, or arrays of shape (0, 0).
    Neighbours are those joined by an edge of the triangulation: left, up, and up-left.
    """
    rows, columns = h.shape
    remembers = spread.shape[0] > 0
    count = 0
    for i in range(rows):
        north_west = west = 0
        for j in range(columns):
            here = h[i, j]
            north = labels[i - 1, j] if i > 0 else 0
            label = 0
            if here > cut:
                label = north_west if north_west else (north if north else west)
                if label == 0:
                    count += 1
                    label = count
                    parent[label] = label
                    stats[label, :X0] = 0.0
                    stats[label, X0], stats[label, Y0] = j, i
                elif north and west and not north_west:
                    _join(parent, north, west)
                if i == 0 or j == 0 or i == rows - 1 or j == columns - 1:
                    stats[label, EDGE] = 1.0
            labels[i, j] = label
            if i > 0 and j > 0 and (label or north or west or north_west):
                u1, u2, u3, u4 = h[i - 1, j - 1] - cut, h[i - 1, j] - cut, h[i, j - 1] - cut, here - cut
                upper = north_west if north_west else (north if north else label)
                lower = north_west if north_west else (west if west else label)
                upper_area = lower_area = 0.0
                if label and north and west and north_west:
                    upper_area = lower_area = 0.5
                    _add_cell(stats, label, i, j, u1, u2, u3, u4)
                else:
                    if upper:
                        x, y = j - stats[upper, X0], i - stats[upper, Y0]
                        upper_area = _triangle(stats, upper, u1, u2, u4, x - 1.0, y - 1.0, x, y - 1.0, x, y)
                    if lower:
                        x, y = j - stats[lower, X0], i - stats[lower, Y0]
                        lower_area = _triangle(stats, lower, u1, u3, u4, x - 1.0, y - 1.0, x - 1.0, y, x, y)
                if remembers:
                    s, s_upper, s_lower = spread[i - 1, j - 1] + spread[i, j], spread[i - 1, j], spread[i, j - 1]
                    m, m_upper, m_lower = limit[i - 1, j - 1] + limit[i, j], limit[i - 1, j], limit[i, j - 1]
                    _add_memory(stats, upper, upper_area, s + s_upper, m + m_upper)
                    _add_memory(stats, lower, lower_area, s + s_lower, m + m_lower)
            north_west, west = north, label
    return count


@loop
def gather_patches(parent, stats, count):
    """Sum provisional labels into patches, move patches to the front; parent then holds each label's patch (from 1)."""
    for i in range(count, 0, -1):
        if parent[i] != i:
            to = parent[i]
            dx, dy = stats[i, X0] - stats[to, X0], stats[i, Y0] - stats[to, Y0]
            area, x, y = stats[i, AREA], stats[i, X], stats[i, Y]
            stats[to, AREA] += area
            stats[to, VOLUME] += stats[i, VOLUME]
            stats[to, X] += x + dx * area
            stats[to, Y] += y + dy * area
            stats[to, XX] += stats[i, XX] + dx * (2.0 * x + dx * area)
            stats[to, XY] += stats[i, XY] + dx * y + dy * x + dx * dy * area
            stats[to, YY] += stats[i, YY] + dy * (2.0 * y + dy * area)
            stats[to, EDGE] = max(stats[to, EDGE], stats[i, EDGE])
            stats[to, SPREAD] += stats[i, SPREAD]
            stats[to, LIMIT] += stats[i, LIMIT]
    patches = 0
    for i in range(1, count + 1):
        if parent[i] == i:
            patches += 1
            for n in range(stats.shape[1]):
                stats[patches, n] = stats[i, n]
            parent[i] = patches
        else:
            parent[i] = parent[parent[i]]
    return patches


@kernel
def paraboloid(stats, i, pixel_x, pixel_y):
    """Area, indentation ω = 2V/A, axes ratio ≥ 1, orientation of the long axis of patch i."""
    area = stats[i, AREA]
    x, y = stats[i, X] / area, stats[i, Y] / area
    xx = (stats[i, XX] / area - x * x) * pixel_x * pixel_x
    yy = (stats[i, YY] / area - y * y) * pixel_y * pixel_y
    xy = (stats[i, XY] / area - x * y) * pixel_x * pixel_y
    half, mean = math.sqrt(0.25 * (xx - yy) ** 2 + xy * xy), 0.5 * (xx + yy)
    small = max(mean - half, 1e-6 * mean)
    aspect = math.sqrt((mean + half) / small) if mean > 0.0 else 1.0
    return area * pixel_x * pixel_y, 2.0 * stats[i, VOLUME] / area, aspect, 0.5 * math.atan2(2.0 * xy, xx - yy)
