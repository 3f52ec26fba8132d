"""R of a contact whose bodies are not spheres and flats: from the curvature of level sets, or from a measured edge radius.

YADE's R of such a shape is the distance from its centre to the contact. Here the curvature of a level set is fitted once: a
quadratic by weighted least squares around each node of the grid that is near the surface. At a contact both bodies' curvatures
are interpolated and added in the common tangent plane, which gives the principal relative radii of the gap, Rx ≥ Ry. Hertz's
elliptical contact of these has the force of a sphere with R = 2 Rm/γ̄³, 1/Rm = 1/Rx + 1/Ry, γ̄ by exact elliptic integrals
(`solvers.ellipsoid`). [The equivalent R is our derivation from Johnson 1985, Eq. 4.26; the force is exact, the true contact
area is smaller than that sphere's, ᾱ β̄ γ̄² of it: by 3 % at Rx/Ry = 2, 10 % at 4, 31 % at 16.]
"""

import functools
import math

import numba
import numpy as np
import yade

from demlaws.core.numba_compat import callback, kernel, loop
from demlaws.core.vectors import cross, dot, minus_scaled, scaled, unit_perpendicular, vector
from demlaws.errors import DemlawsError
from demlaws.solvers.ellipsoid import quick_factors
from demlaws.yade.layout import FIELD, PLANE, SHAPE, SPHERE
from demlaws.yade.records import array, view
from demlaws.yade.search import address

WINDOW = 4.5
"""Reach of the fit in cells. Fields of YADE's fast marching method are rough on a smaller scale: at spacing R/10 the
largest error of an ellipsoid's curvature is 57 % with a reach of 2 cells, 8 % with 3.5 and 6 % with 4.5."""
BAND = 2.3  # cells from the surface within which nodes have a curvature: corners of a cell with a contact are within 1.8
FAR = 100.0
"""A gap is flat where its smaller principal radius is above this multiple of the bodies' R."""


# --- the fit


_TERMS = np.array([i for i in np.ndindex(3, 3, 3) if sum(i) <= 2])
"""Powers of x, y and z in a quadratic: 1, z, z², y, yz, y², x, xz, xy, x²."""
_FIT_AT_ONCE = 4096  # nodes


def fit(field):
    """Curvature of a level set in cells: number of each node's tensor or -1, and tensors (xx, yy, zz, yz, xz, xy) [1/cell]
    of the nodes within BAND of the surface: P H P/|∇φ| of the fitted quadratic φ, P = 1 - n nᵀ; NaN if undefined."""
    reach = int(WINDOW)
    around = np.stack(np.meshgrid(*[np.arange(-reach, reach + 1)] * 3, indexing="ij"), -1).reshape(-1, 3)
    weight = 1.0 - np.sum((around / WINDOW) ** 2, axis=1)
    around, weight = around[weight > 0.0], weight[weight > 0.0] ** 2
    terms = np.prod(around[:, None] ** _TERMS, axis=2)
    products = (terms[:, :, None] * terms[:, None]).reshape(len(terms), -1)
    padded = np.pad(np.asarray(field, float), reach, constant_values=math.nan)
    places = np.argwhere(np.abs(field) < BAND)
    index, tensors = np.full(np.shape(field), -1), np.empty((len(places), 6))
    index[tuple(places.T)] = np.arange(len(places))
    for start in range(0, len(places), _FIT_AT_ONCE):
        part = slice(start, start + _FIT_AT_ONCE)
        values = padded[tuple(np.moveaxis(places[part, None] + around + reach, -1, 0))]
        weights = np.where(np.isfinite(values), weight, 0.0)
        matrices = (weights @ products).reshape(-1, 10, 10)
        right = (weights * np.nan_to_num(values, posinf=0.0, neginf=0.0)) @ terms
        poor = np.linalg.eigvalsh(matrices)[:, 0] <= 1e-9
        matrices[poor], right[poor] = np.eye(10), math.nan
        _, z, zz, y, yz, yy, x, xz, xy, xx = np.linalg.solve(matrices, right[..., None])[..., 0].T
        hessian = np.moveaxis(np.array([[2.0 * xx, xy, xz], [xy, 2.0 * yy, yz], [xz, yz, 2.0 * zz]]), -1, 0)
        slope = np.stack([x, y, z], axis=1)
        size = np.linalg.norm(slope, axis=1)[:, None]
        across = np.eye(3) - (slope / size)[:, :, None] * (slope / size)[:, None]
        curvature = across @ hessian @ across / size[..., None]
        tensors[part] = curvature[:, [0, 1, 2, 1, 0, 0], [0, 1, 2, 2, 2, 1]]
    return index, tensors


# --- at a contact


@kernel
def _turned_back(orientation, a):
    """A vector in the axes of a body whose orientation is a quaternion (x, y, z, w)."""
    axis = scaled(-1.0, vector(orientation))
    twice = scaled(2.0, cross(axis, a))
    return minus_scaled(minus_scaled(a, -orientation[3], twice), -1.0, cross(axis, twice))


@kernel
def _quadratic(diagonal, rest, u, v):
    """uᵀ K v."""
    mixed = u[1] * v[2] + u[2] * v[1], u[0] * v[2] + u[2] * v[0], u[0] * v[1] + u[1] * v[0]
    return dot(diagonal, (u[0] * v[0], u[1] * v[1], u[2] * v[2])) + dot(rest, mixed)


@kernel
def _curvatures(shape, position, orientation, point, t, s):
    """tᵀKt, tᵀKs, sᵀKs [1/m] of a body at a point, for two tangents of the contact; NaN where it has no curvature."""
    size = shape.size
    if shape.kind == PLANE:
        return 0.0, 0.0, 0.0
    if shape.kind == SPHERE:
        return 1.0 / size, 0.0, 1.0 / size
    x, y, z = _turned_back(orientation, minus_scaled(vector(point), 1.0, vector(position)))
    x, y, z = (x - shape.low[0]) / size, (y - shape.low[1]) / size, (z - shape.low[2]) / size
    n0, n1, n2 = shape.count[0], shape.count[1], shape.count[2]
    if not (0.0 <= x <= n0 - 1.0 and 0.0 <= y <= n1 - 1.0 and 0.0 <= z <= n2 - 1.0):
        return math.nan, math.nan, math.nan
    i, j, k = min(int(x), n0 - 2), min(int(y), n1 - 2), min(int(z), n2 - 2)
    x, y, z = x - i, y - j, z - k
    numbers = array(shape.index, (n0, n1, n2), np.int64)
    diagonal = rest = (0.0, 0.0, 0.0)
    for corner in range(8):
        a, b, c = corner & 1, corner >> 1 & 1, corner >> 2
        weight = (x if a else 1.0 - x) * (y if b else 1.0 - y) * (z if c else 1.0 - z)
        number = numbers[i + a, j + b, k + c]
        if number < 0:
            return math.nan, math.nan, math.nan
        tensor = array(shape.tensors, (number + 1, 2, 3), np.float64)[number]
        diagonal = minus_scaled(diagonal, -weight, vector(tensor[0]))
        rest = minus_scaled(rest, -weight, vector(tensor[1]))
    u, v = _turned_back(orientation, t), _turned_back(orientation, s)
    first, mixed = _quadratic(diagonal, rest, u, u) / size, _quadratic(diagonal, rest, u, v) / size
    return first, mixed, _quadratic(diagonal, rest, v, v) / size


@loop
def gap_radius(first, position1, orientation1, second, position2, orientation2, point, normal, radius, largest):
    """Equivalent R [m] of the gap between two bodies; all but the last two are addresses.

    NaN: a body has no curvature there; -1: flat on flat. radius: YADE's R; largest: bound of principal radii, 0: none.
    """
    shape1, shape2, n = view(first, SHAPE), view(second, SHAPE), vector(array(normal, 3, np.float64))
    where = array(point, 3, np.float64)
    t = unit_perpendicular(n)
    s = cross(n, t)
    place1, turn1 = array(position1, 3, np.float64), array(orientation1, 4, np.float64)
    place2, turn2 = array(position2, 3, np.float64), array(orientation2, 4, np.float64)
    a1, b1, c1 = _curvatures(shape1, place1, turn1, where, t, s)
    a2, b2, c2 = _curvatures(shape2, place2, turn2, where, t, s)
    a, b, c = a1 + a2, b1 + b2, c1 + c2
    if a - a != 0.0:
        return math.nan
    mean, half = 0.5 * (a + c), math.hypot(0.5 * (a - c), b)
    sharp, blunt = mean + half, mean - half
    least = 1.0 / largest if largest > 0.0 else 1.0 / (FAR * radius)
    if largest <= 0.0 and sharp < least:
        return -1.0
    spacing = 0.0
    for shape in (shape1, shape2):
        if shape.kind == FIELD:
            spacing = max(spacing, shape.size)
    sharp, blunt = max(sharp, least), max(blunt, least)
    gamma = quick_factors(sharp / blunt)[1]
    return max(2.0 / ((sharp + blunt) * gamma * gamma * gamma), spacing)


# --- a scene


@functools.cache
def _compiled_gap_radius():
    """`gap_radius` for C callers."""
    kinds = [numba.types.int64] * 8 + [numba.types.float64] * 2
    return callback(numba.types.float64(*kinds), gap_radius.py_func, {})


class Shapes:
    """The scene's shapes as compiled code reads them; largest: upper bound of the principal radii [m], 0: none."""

    def __init__(self, largest):
        self.largest = largest
        self.table, self._shapes = np.zeros(0, SHAPE), {}

    def fill(self, context):
        """Write what compiled code needs to find R."""
        context["gap_radius"] = _compiled_gap_radius().address
        context["largest_radius"] = self.largest

    def record_of(self, body):
        """`layout.SHAPE` of a body; a shape is fitted once, and kept so that no other shape can have its address."""
        if yade.O.periodic:
            raise DemlawsError('radius="curvature" is not available with periodic boundaries: use walls, or give a number')
        shape = body.shape
        place = address(shape)
        if place not in self._shapes:
            record = np.zeros(1, SHAPE)
            record["shape"], references = place, [shape]
            if isinstance(shape, yade.Facet | yade.Wall | yade.Box):
                record["kind"] = PLANE
            elif type(shape) is yade.Sphere:
                record["kind"], record["size"] = SPHERE, shape.radius
            elif hasattr(yade, "LevelSet") and isinstance(shape, yade.LevelSet):
                field, spacing = np.array(shape.distField, float), float(shape.lsGrid.spacing)
                if field.ndim != 3 or min(field.shape) < 5:
                    raise DemlawsError(
                        f"body {body.id}: a level set with {field.shape} nodes has no curvature; at least 5 per axis are needed"
                    )
                index, tensors = fit(field / spacing)
                record["kind"], record["size"] = FIELD, spacing
                record["count"], record["low"] = field.shape, tuple(shape.lsGrid.min)
                record["index"], record["tensors"] = index.ctypes.data, tensors.ctypes.data
                references += [index, tensors]
            self._shapes[place] = record, references
        return self._shapes[place][0]

    def refresh(self, context):
        """Write the shapes of all bodies to where compiled code reads them."""
        bodies = yade.O.bodies
        if not context["shapes_stale"] and len(self.table) == len(bodies):
            return
        table = np.zeros(len(bodies), SHAPE)
        for number in range(len(bodies)):
            body = bodies[number]
            if body is not None and body.shape is not None:
                table[number] = self.record_of(body)[0]
        self.table = table
        context["shapes"], context["shape_count"] = table.ctypes.data, len(table)
        context["shapes_stale"] = 0
