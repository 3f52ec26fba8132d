"""Master curves of rough contacts whose layer of Gaussian asperities rests on an elastic half-space, as data.

The approach U (over σ) under the force f = P/(E* √R σ^1.5) depends on one number A only: N_H = (H_m/E*) √(8R/σ) of Yip &
Venart 1971, μ = (8/3) η σ √(2Rβ) of Greenwood & Tripp 1967. A file beside this one has, for each model and for values of A at
equal steps of ln A, U less Hertz's approach, p(0)/p0 and a*/a_H at equal steps of ln f, as computed by `studies.half_space`.
Between the values of ln A a cubic is put through the four nearest curves, at equal overlap or at equal force. [our derivation]

From the default seating load to f = 1e6 or, of Yip & Venart, to the yield of the bulk at p(0) = 0.6 H_m the laws are within
1e-5 of the solution in force, stiffness and a*/a_H and within 3e-5 in p(0)/p0 and in the force up to 4 % of overlap past the
seat; beyond, the force is within 2e-3. `python -m studies.half_space` prints these errors.
"""

import functools
import math
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from demlaws.core.numba_compat import kernel
from demlaws.errors import DemlawsError

YIELD_RATIO = 0.6
"""p(0)/H_m at which the bulk begins to yield (Tabor)."""
LOWEST, HIGHEST = 0.05, 1e5
"""Range of A."""
LOWEST_FORCE, HIGHEST_FORCE = 1e-7, 1e7
"""Range of f in which a seating load may be, and of U."""
PLASTIC_LAYER, ELASTIC_LAYER = "yip-venart", "greenwood-tripp"
"""Models, by what their asperities do."""
NUMBERS = {PLASTIC_LAYER: "N_H = (H_m/E*) √(8R/σ)", ELASTIC_LAYER: "μ = (8/3) η σ √(2Rβ)"}
"""Name of a model → its A."""
_STENCIL = np.arange(-3, 5)
"""Nodes of ln f, from the one below, through which a polynomial is put."""
_BASIS = np.linalg.inv(np.vander(_STENCIL, increasing=True)).T
_FINE = 1.0 / 16.0  # step of ln f at which U is inverted
ALL = slice(None)
"""The rows of all values of A."""


class Column(NamedTuple):
    """A quantity at ln f = start, start + step, …; one row per value of ln A."""

    start: float
    step: float
    values: np.ndarray

    def at(self, log_force: Any, rows: slice = ALL) -> tuple[np.ndarray, np.ndarray]:
        """Values of these rows and their derivatives by ln f."""
        place = (np.asarray(log_force, float) - self.start) / self.step
        node = np.floor(place).astype(int)
        factors = self.values[rows][:, node[..., None] + _STENCIL] @ _BASIS
        value, slope, place = factors[..., -1], np.zeros_like(factors[..., -1]), place - node
        for factor in np.moveaxis(factors, -1, 0)[-2::-1]:
            slope = slope * place + value
            value = value * place + factor
        return value, slope / self.step


class MasterCurves(NamedTuple):
    """The data of one model; the columns are defined in the docstring of this module."""

    model: str
    log_first: float  # ln A of the first row
    log_ratio: float  # step of ln A
    offset: Column  # U - (3f/4)^(2/3)
    pressure: Column  # p(0)/p0
    radius: Column | None  # a*/a_H, of the elastic layer alone
    flattens: float  # A from which curves bend at large overlaps; infinite for an elastic layer

    def around(self, number: float) -> tuple[slice, float]:
        """The four rows around one value of A, and its place between the inner two, from 0 to 1."""
        place = (math.log(self.checked(number)) - self.log_first) / self.log_ratio
        first = min(max(math.floor(place) - 1, 0), len(self.offset.values) - 4)
        return slice(first, first + 4), place - first - 1.0

    def checked(self, numbers: Any) -> Any:
        """The same value or values of A; DemlawsError where one is outside the range of the data."""
        low, high = float(np.min(numbers)), float(np.max(numbers))
        if not (low >= LOWEST * (1 - 1e-9) and high <= HIGHEST * (1 + 1e-9)):
            raise DemlawsError(
                f"{self.model}: {NUMBERS[self.model]} = {high if low >= LOWEST else low:.4g} is outside {LOWEST:g} to "
                f"{HIGHEST:g}, the range of the law: check hardness, modulus, roughness and radius"
            )
        return numbers


@kernel
def mean_of_four(w, share, y0, y1, y2, y3):
    """Value at w of the straight line through y1 at 0 and y2 at 1, with a share of what the cubic through all four, at -1 to 2,
    has more; and all of that. Numbers or arrays."""
    bent = -w * (1.0 - w) / 6.0 * ((2.0 - w) * (y0 - 2.0 * y1 + y2) + (1.0 + w) * (y1 - 2.0 * y2 + y3))
    return y1 + w * (y2 - y1) + share * bent, bent


@kernel
def cubic_share(u, turn):
    """Share of the cubic at u = δ/σ and its derivative. turn: 1/N_H² where pressures reach the hardness at large u, else 0.

    There a curve has a bend at p(0) = H_m, u = 0.28 N_H². A cubic through curves on both sides of it could be stiffer than
    Hertz, a straight line between two that are not is not: it is used from p(0) = 0.72 H_m on, the cubic up to 0.6 H_m.
    """
    place = (0.16 - u * turn) / 0.05
    share = 0.5 * (1.0 + abs(place) - abs(place - 1.0))
    return share, -turn / 0.05 * ((share > 0.0) & (share < 1.0))


FLATTENS = 50.0
"""N_H from which `cubic_share` has a `turn`: below, curves have another slope than Hertz's before they bend."""


@functools.cache
def load(model: str) -> MasterCurves:
    """The master curves of a model, of those in NUMBERS."""
    with np.load(Path(__file__).with_name(f"{model}.npz"), allow_pickle=False) as file:

        def column(name):
            start, step = map(float, file[f"{name}_nodes"])
            return Column(start, step, file[name].astype(float))

        first, step = map(float, file["log_number"])
        radius, flattens = (column("radius"), math.inf) if model == ELASTIC_LAYER else (None, FLATTENS)
        return MasterCurves(model, first, step, column("offset"), column("pressure"), radius, flattens)


def central_pressure(model: str, number: float, force: Any) -> np.ndarray:
    """p(0)/p0 for one value of A at an array of f up to 1e7, from 1e-12 on (of the plastic layer from 1e-6)."""
    return _between(load(model).pressure, load(model), number, force)


def effective_radius(number: float, force: Any) -> np.ndarray:
    """a*/a_H, a* = 3π ∫rp dr/(4 ∫p dr), of the elastic layer for one value of μ at an array of f from 1e-12 to 1e7."""
    return _between(load(ELASTIC_LAYER).radius, load(ELASTIC_LAYER), number, force)


def _between(column: Any, curves: MasterCurves, number: float, force: Any) -> np.ndarray:
    force, lowest = np.asarray(force, float), math.exp(column.start - _STENCIL[0] * column.step)
    if not np.all((force >= lowest) & (force <= HIGHEST_FORCE)):
        wrong = np.min(force) if np.min(force) < lowest else np.max(force)
        raise DemlawsError(
            f"P/(E* √R σ^1.5) = {wrong:.4g} is outside {lowest:.2g} to {HIGHEST_FORCE:g}: check force and roughness"
        )
    rows, place = curves.around(number)
    return mean_of_four(place, 1.0, *column.at(np.log(force), rows)[0])[0]


def yield_force(number: float) -> float:
    """f at which p(0) = YIELD_RATIO H_m of the plastic layer for A = N_H, to 1e-4; infinite above HIGHEST_FORCE."""
    force = np.geomspace(1e-6, HIGHEST_FORCE, 4097)[:-1]
    hertz = 8.0 / math.pi * np.cbrt(3.0 / (8.0 * math.sqrt(2.0)) * force)  # p0 = hertz E* √(σ/8R)
    pressure = central_pressure(PLASTIC_LAYER, number, force) * hertz / number
    first = int(np.argmax(pressure >= YIELD_RATIO))
    if pressure[first] < YIELD_RATIO:
        return math.inf
    near = slice(max(first - 1, 0), first + 1)
    return float(np.exp(np.interp(math.log(YIELD_RATIO), np.log(pressure[near]), np.log(force[near]))))


class Seated(NamedTuple):
    """Curves from a seating load on: arrays of one row per curve, with one column per force."""

    start: np.ndarray  # overlap over σ at the seating load, (curves, 1)
    overlap: np.ndarray  # overlap over σ
    equivalent: np.ndarray  # s = (3f/4)^(2/3), one row
    slope: np.ndarray  # ds/du

    def at(self, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """s and ds/du of each curve at u: straight below the seating load, and above the last force."""
        rows = [_hermite(u, self.overlap[i], self.equivalent, self.slope[i]) for i in range(len(self.slope))]
        s, slope = np.array(rows).swapaxes(0, 1)
        below, first = u < self.start, self.slope[:, :1]
        return np.where(below, first * u, s), np.where(below, first, slope)


def seated(curves: MasterCurves, share: float, rows: slice = ALL) -> Seated:
    """These rows of the curves above the force `share`, whose overlap is continued below it as P ∝ δ^1.5 to overlap 0."""
    count = math.ceil(math.log(HIGHEST_FORCE / share) / _FINE) + 1
    log_force = np.linspace(math.log(share), math.log(HIGHEST_FORCE), count)
    offset, rate = curves.offset.at(log_force, rows)
    s = np.exp((log_force + math.log(0.75)) * (2.0 / 3.0))
    slope = (2.0 / 3.0) * s / (rate + (2.0 / 3.0) * s)
    start = s[0] / slope[:, :1]
    return Seated(start, start + (offset - offset[:, :1]) + (s - s[0]), s, slope)


def _hermite(u, x, y, slope):
    """The piecewise cubic with these values and slopes at x, straight beyond its ends, and its derivative."""
    i = np.clip(np.searchsorted(x, u) - 1, 0, x.size - 2)
    h = x[i + 1] - x[i]
    t, chord = np.clip((u - x[i]) / h, 0.0, 1.0), (y[i + 1] - y[i]) / h
    b, c, d = slope[i], 3.0 * chord - 2.0 * slope[i] - slope[i + 1], slope[i] + slope[i + 1] - 2.0 * chord
    beyond = np.maximum(u - x[-1], 0.0) * slope[-1]
    return y[i] + h * t * (b + t * (c + t * d)) + beyond, b + t * (2.0 * c + t * 3.0 * d)
