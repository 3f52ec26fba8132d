"""`python -m studies.triaxial`: the cyclic triaxial test of ballast, its table and picture."""

import sys
from pathlib import Path

from demlaws.cli import Parser, example, execute
from demlaws.errors import DemlawsError
from studies.triaxial import cycles

QUICK = [(cycles.Case(law=law, sigma=sigma, count=30), 3) for law, sigma in (("hertz", 0.0), ("pohrt-popov", 10.0))]


def parser():
    """The command line."""
    parser = Parser(
        prog="python -m studies.triaxial",
        description="Cyclic triaxial tests of granite in LAMMPS; missing runs are added, interrupted ones continued.",
        **example("  python -m studies.triaxial --report\n  python -m studies.triaxial --quick"),
    )
    parser.add_argument("--results", type=Path, default=cycles.RESULTS, help="file of results")
    parser.add_argument("--store", type=Path, default=cycles.STORE, help="folder of samples and of interrupted runs")
    parser.add_argument("--quick", action="store_true", help="two cases of 30 grains and 3 cycles, a minute")
    parser.set_defaults(func=run)
    return parser


def run(arguments, _):
    """Run what is missing, then print the tables."""

    def progress(text):
        print(text, file=sys.stderr, flush=True)

    failed = 0
    for case, number in QUICK if arguments.quick else cycles.wanted():
        try:
            cycles.run_case(case, number, arguments.results, arguments.store, progress)
        except DemlawsError as error:  # the other cases go on
            failed += 1
            progress(f"{' '.join(map(str, case))}: {error}")
    return int(failed > 0)


def main(arguments=None):
    """Run with these arguments (default: the command line's); the exit status."""
    return execute(parser, arguments)


if __name__ == "__main__":
    sys.exit(main())
