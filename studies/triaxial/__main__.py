"""`python -m studies.triaxial`: the cyclic triaxial test of ballast, its table and picture."""

import sys
from pathlib import Path

from demlaws import plots
from demlaws.cli import Parser, example, execute
from demlaws.cli.output import picture_file
from demlaws.errors import DemlawsError
from studies.assembly.study import read
from studies.triaxial import cycles, picture, report

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
    parser.add_argument("--report", action="store_true", help="tables only, from the runs in the file")
    parser.add_argument("--figure", type=picture_file, help="picture of strain over cycles, with measured bands")
    parser.set_defaults(func=run)
    return parser


def run(arguments, _):
    """Run what is missing, then print the tables."""

    def progress(text):
        print(text, file=sys.stderr, flush=True)

    failed = 0
    for case, number in () if arguments.report else QUICK if arguments.quick else cycles.wanted():
        try:
            cycles.run_case(case, number, arguments.results, arguments.store, progress)
        except DemlawsError as error:  # the other cases go on
            failed += 1
            progress(f"{' '.join(map(str, case))}: {error}")
    rows = read(arguments.results)
    settings = {"count": QUICK[0][0].count} if arguments.quick else {}
    print(report.table(rows, **settings), report.effects(rows, **settings), sep="\n\n")
    if not arguments.quick:
        print(report.course_text(rows))
    if arguments.figure is not None:
        print(plots.save(picture.draw(rows), arguments.figure))
    return int(failed > 0)


def main(arguments=None):
    """Run with these arguments (default: the command line's); the exit status."""
    return execute(parser, arguments)


if __name__ == "__main__":
    sys.exit(main())
