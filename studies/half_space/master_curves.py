"""The data of `demlaws.solvers.master_curves`, computed by `axisymmetric`, and their certificate."""

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np
from tqdm import tqdm

from demlaws.core.curve import read
from demlaws.laws.family import SEATING_SHARE, law_curve
from demlaws.solvers import master_curves
from demlaws.solvers.master_curves import ELASTIC_LAYER, HIGHEST, HIGHEST_FORCE, LOWEST, LOWEST_FORCE, PLASTIC_LAYER
from studies.half_space.axisymmetric import curve, solve

ROWS = {PLASTIC_LAYER: 121, ELASTIC_LAYER: 73}
"""Values of ln A from LOWEST to HIGHEST; one more is added on each side."""
COLUMNS = {
    PLASTIC_LAYER: {"offset": (LOWEST_FORCE, 0.25), "pressure": (1e-6, 0.25)},
    ELASTIC_LAYER: {"offset": (LOWEST_FORCE, 0.25), "pressure": (1e-12, 0.5), "radius": (1e-12, 0.5)},
}
"""Model → column → lowest f at which it is read, and step of ln f."""
FILES = Path(master_curves.__file__).parent


def numbers(model):
    """Values of A of the rows, and the first and the step of ln A."""
    step = math.log(HIGHEST / LOWEST) / (ROWS[model] - 1)
    first = math.log(LOWEST) - step
    return np.exp(first + step * np.arange(ROWS[model] + 2)), (first, step)


def nodes(model, column):
    """ln f of the nodes of a column: a polynomial goes through 3 nodes before a place and 4 after it."""
    lowest, step = COLUMNS[model][column]
    first, last = (math.floor(math.log(force) / step) for force in (lowest, HIGHEST_FORCE))
    return step * np.arange(first - 3, last + 5)


def row(model, number):
    """Column → its values for one value of A."""
    at = nodes(model, "offset")
    offset = curve(model, number).approach(np.exp(at)) - np.exp((at + math.log(0.75)) * (2.0 / 3.0))
    points = solve(model, number, np.exp(nodes(model, "pressure")))
    found = {"offset": rounded(offset), "pressure": points.central_pressure.astype(np.float32)}
    return found | ({"radius": points.effective_radius.astype(np.float32)} if model == ELASTIC_LAYER else {})


def rounded(values):
    """Values to 1e-11, and to 1e-12 of themselves: digits that are not exact would not be compressed."""
    unit = 2.0 ** np.ceil(np.log2(1e-11 * np.maximum(1.0, 0.1 * np.abs(values))))
    return np.round(values / unit) * unit


def compute(model):
    """name → array, of the file of a model."""
    values, log_number = numbers(model)
    rows = [row(model, float(value)) for value in tqdm(values, desc=model)]
    columns = {name: np.array([one[name] for one in rows]) for name in rows[0]}
    grids = {f"{name}_nodes": (nodes(model, name)[0], COLUMNS[model][name][1]) for name in columns}
    return {"log_number": log_number, **grids, **columns}


def save(model):
    """Compute the file of a model again, beside the module that reads it: some minutes. Returns its path."""
    path = FILES / f"{model}.npz"
    np.savez_compressed(path, **compute(model))
    return path


class Certificate(NamedTuple):
    """Largest relative errors at one value of A, from a seating load to the yield of the bulk or to f = 1e6."""

    model: str
    number: float  # A
    force: float  # at equal overlap, past the first 4 % of overlap: in this cell of the law's table the curve bends
    stiffness: float
    seat: float  # of the force within this cell
    pressure: float  # p(0)/p0 at equal force
    radius: float  # a*/a_H; NaN for PLASTIC_LAYER
    beyond: float  # of the force above that, to f = 1e7


def certify(model, number, share=SEATING_SHARE):
    """The `Certificate` of the law's own curve for one value of A, solved afresh."""
    whole = curve(model, number)
    limit = min(1e6, whole.bulk_yield_force())
    force = np.geomspace(share, HIGHEST_FORCE, 1500)
    approach = whole.approach(force)
    equivalent, slope = whole.hertz_overlap(approach[0])
    overlap = approach - approach[0] + equivalent / slope
    s, rate = read(law_curve(model, number, share, overlap[-1]).grid, overlap)
    errors = np.abs([4.0 / 3.0 * s**1.5 / force - 1.0, 2.0 * np.sqrt(s) * rate / whole.evaluate(approach)[1] - 1.0])
    valid = force <= limit
    some = np.geomspace(share, limit, 7)
    points = solve(model, number, some)
    pressure = master_curves.central_pressure(model, number, some) / points.central_pressure - 1.0
    radius = math.nan
    if model == ELASTIC_LAYER:
        radius = np.abs(master_curves.effective_radius(number, some) / points.effective_radius - 1.0).max()
    past = valid & (overlap > 1.04 * overlap[0])
    beyond = errors[0][~valid].max(initial=0.0)
    seat = errors[0][~past & valid].max()
    force, stiffness = errors[:, past].max(axis=1)
    return Certificate(model, number, force, stiffness, seat, np.abs(pressure).max(), radius, beyond)
