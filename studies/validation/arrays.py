"""What the engines' rows share: regular arrays of spheres, a rigid plane."""

import math

RIGID = 1e9
"""Modulus of a rigid plane over the sphere's."""
CELLS = 4  # along each edge of the periodic cell
SITES = {
    "SC": [(0, 0, 0)],
    "FCC": [(0, 0, 0), (0.5, 0.5, 0), (0.5, 0, 0.5), (0, 0.5, 0.5)],
}
EDGE = {"SC": 2.0, "FCC": 2.0 * math.sqrt(2.0)}  # of the cubic cell over the radius, spheres just touching
