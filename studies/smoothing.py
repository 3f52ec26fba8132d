"""Two ways to smooth measured points of first loading, by the error of the stiffness: the package's and scipy's.

    python -m studies.smoothing [--sets N]

`Table.from_points` averages smoothing splines of ln P over ln δ by restricted likelihood, with noise in proportion to the force
and noise of one size (`curves.points`). `scipy.interpolate.make_smoothing_spline` chooses one such spline by generalised
cross-validation. Points are at equal steps of the overlap, as test machines record them; the uncertainty is not given. Errors
are those at places that are equally far apart in ln δ, where the force is at least three times a noise of one size.
"""

import argparse
import sys

import numpy as np
from scipy.interpolate import make_smoothing_spline

import demlaws as dl
from demlaws.curves.points import MeasuredCurve
from demlaws.errors import DemlawsError, quiet

PAIR = dl.Contact(radius=4.35e-3, modulus=32.32e9, sigma=2.4e-6, fractal_dimension=2.22, hardness=6.266e9)
CURVES = {"hertz": {}, "pohrt-popov": {}, "rough-plastic": {"yield_pressure": 1e9}}
LARGEST = 3e-5
"""Overlap [m] of the last point: at a third of it `rough-plastic` yields, about there `pohrt-popov` bends towards Hertz."""
SIZES = (6, 8, 12, 20, 40, 100, 300, 1000)
NOISES = {"1 %": (0.01, 0.0), "3 %": (0.03, 0.0), "0.3 % of the largest": (0.0, 0.003)}
"""Name → standard deviation over the force, and over the largest force."""


def ours(overlap, force, at):
    """Stiffness [N/m] of the package's curve at overlaps [m]; DemlawsError where it refuses the points."""
    return MeasuredCurve(overlap, force).evaluate(at)[1]


def scipys(overlap, force, at):
    """Stiffness [N/m] of scipy's spline; DemlawsError where it does not rise, so that no table can be made of it."""
    keep = force > 0.0
    spline = make_smoothing_spline(np.log(overlap[keep]), np.log(force[keep]))
    x = np.log(at)
    slope = spline(x, nu=1)
    if not np.all(slope > 0.0):
        raise DemlawsError("the curve falls")
    return slope * np.exp(spline(x)) / at


WAYS = {"demlaws": ours, "scipy": scipys}


def errors(way, law, size, noise, random, sets):
    """Relative errors of the stiffness of `sets` sets of points, and how many sets gave no rising curve."""
    overlap = LARGEST * np.arange(1, size + 1) / size
    force, found, refused = law.force(overlap), [], 0
    at = np.geomspace(overlap[0], overlap[-1], 60)
    at = at[law.force(at) >= 3.0 * noise[1] * force[-1]]
    true = law.stiffness(at)
    for _ in range(sets):
        measured = force + (noise[0] * force + noise[1] * force[-1]) * random.standard_normal(size)
        try:
            found.append(np.abs(way(overlap, measured, at) / true - 1.0))
        except (DemlawsError, ValueError, np.linalg.LinAlgError):
            refused += 1
    return np.concatenate(found) if found else np.zeros(0), refused


def measure(sets):
    """(noise, size) → way → (95th percentile of the stiffness's error, share of sets that gave no rising curve)."""
    with quiet():
        laws = [dl.law(name, PAIR, "elastic", **options) for name, options in CURVES.items()]
        for noise_name, noise in NOISES.items():
            for size in SIZES:
                count = max(4, sets if size <= 100 else sets // 5)
                row = {}
                for name, way in WAYS.items():
                    random = np.random.default_rng(size)
                    parts = [errors(way, law, size, noise, random, count) for law in laws]
                    found = np.concatenate([part for part, _ in parts])
                    lost = sum(refused for _, refused in parts) / (count * len(laws))
                    row[name] = (float(np.percentile(found, 95.0)) if found.size else np.nan), lost
                yield noise_name, size, row


def table(sets):
    """The table as Markdown, line by line."""
    yield "| noise of the force | points | demlaws | scipy | no rising curve: demlaws | scipy |"
    yield "| --- | --- | --- | --- | --- | --- |"
    for noise, size, row in measure(sets):
        values = " | ".join(f"{float(f'{100 * row[name][0]:.2g}'):g} %" for name in WAYS)
        lost = " | ".join(f"{100 * row[name][1]:.0f} %" for name in WAYS)
        yield f"| {noise} | {size} | {values} | {lost} |"


def main(arguments=None):
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sets", type=int, default=5, help="sets of points for each curve, a fifth above 100 points")
    for line in table(parser.parse_args(arguments).sets):
        print(line, flush=True)


if __name__ == "__main__":
    sys.exit(main())
