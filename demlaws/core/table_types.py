"""Types of a table: the kernels that read it are in `curve`, which a script without tables does not load."""

import math
from typing import NamedTuple

import numpy as np


class Grid(NamedTuple):
    """The cells of one dimensionless curve and their positions, as read by a look-up; the same for all contacts."""

    cells: np.ndarray  # (count, 4): s as a cubic in t, the place in the grid cell from 0 to 1; first those of `grid._below`
    starts: np.ndarray  # (cells between nodes, 5): t, s, ∫f du where a cell or its part after a kink begins; grid u, width
    shift: int  # 52 - bits
    first: int  # grid number of row 0 of `cells`
    kinks: tuple  # u of the kinks that split a cell, then infinity; 2 of them or more, a power of two: see `count_kinks_below`
    lowest: float  # u of the first node
    highest: float  # u of the last node
    floor: float  # u where the cells below the first node begin; linear from there to 0, or to the seat
    inverse_floor: float
    exponent: float  # d ln s/d ln u at the first node
    seat: float  # s at u = 0+: 0, but for curves that start from a force; those are straight below the first node
    count: int  # rows of `cells` that belong to one curve


class BulkYield(NamedTuple):
    """Contact radius of a law whose bulk yields: a²/(R length) = area + slope (s^1.5 - area^1.5) where s > area, else s."""

    area: float = math.inf
    slope: float = 0.0


NO_YIELD = BulkYield()


class TableShape(NamedTuple):
    """One dimensionless curve."""

    grid: Grid
    bulk: BulkYield
    length_over_roughness: float  # length = this σ + the next R
    length_over_radius: float


class TableParams(NamedTuple):
    """One contact."""

    hertz_coefficient: float  # (4/3) E* √R [N/m^1.5]
    length: float  # [m]
    inverse_length: float  # [1/m]
    offset: float  # added to u before the curve is read: 0, but for laws with a seating load
