"""`python -m studies.half_space`: the certificate of the master curves of the package, or the curves again."""

import math
import sys

import numpy as np
from tqdm import tqdm

from demlaws.cli import Parser, example, execute
from demlaws.cli.arguments import whole
from demlaws.solvers.master_curves import NUMBERS
from studies.half_space.master_curves import certify, numbers, save


def parser():
    """The command line."""
    parser = Parser(
        prog="python -m studies.half_space",
        description="Compares the master curves of yip-venart and greenwood-tripp with the solver, at values of N_H and μ "
        "between those of the data: largest errors of force, stiffness, p(0)/p0 and a*/a_H.",
        **example(
            "  python -m studies.half_space --values 10\n  python -m studies.half_space --save         (about ten minutes)"
        ),
    )
    parser.add_argument("--values", type=whole(), default=8, help="values of N_H and of μ (default 8)")
    parser.add_argument("--save", action="store_true", help="compute the data again first")
    parser.set_defaults(func=run)
    return parser


def between(model, count):
    """Values of A in the middle between two rows of the data."""
    rows = numbers(model)[0][1:-1]
    first = np.unique(np.linspace(0, rows.size - 2, count).astype(int))
    return np.sqrt(rows[first] * rows[first + 1])


def run(arguments, _):
    """Print the certificate; the status is 1 if an error is above 1e-5, at the seat or in p(0)/p0 above 3e-5."""
    if arguments.save:
        for model in NUMBERS:
            print(save(model))
    print(
        f"{'model':17}{'A':>10}{'force':>10}{'stiffness':>11}{'at seat':>10}{'p(0)/p0':>10}{'a*/a_H':>10}{'force beyond':>14}"
    )
    worst = 0.0
    for model in NUMBERS:
        for number in tqdm(between(model, arguments.values), leave=False, disable=None):
            one = certify(model, float(number))
            radius = "" if math.isnan(one.radius) else f"{one.radius:.1e}"
            errors = f"{one.force:10.1e}{one.stiffness:11.1e}{one.seat:10.1e}{one.pressure:10.1e}"
            print(f"{model:17}{number:10.4g}{errors}{radius:>10}{one.beyond:14.1e}")
            worst = max(worst, np.nanmax([one.force, one.stiffness, one.seat / 3.0, one.pressure / 3.0, one.radius]))
    print("force beyond: above p(0) = 0.6 H_m or f = 1e6, where no bound is stated")
    return int(worst > 1e-5)


def main(arguments=None):
    """Run the command; returns the exit status."""
    return execute(parser, arguments)


if __name__ == "__main__":
    sys.exit(main())
