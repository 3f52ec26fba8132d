"""`python -m studies.cases`: tables and curves of the cases that the documentation shows."""

import csv
import sys
import tempfile

from demlaws.cli import Parser, example, execute
from demlaws.cli.output import other_file
from studies.cases import ENGINES, ballast, chain, compression, impact, waves


def parser():
    """The command line."""
    parser = Parser(
        prog="python -m studies.cases",
        description="Runs a case and prints its table: impact (in Python and each engine, 20 s), compression (LIGGGHTS, "
        "2 minutes), ballast (4 minutes), waves (LAMMPS, a minute), chain (each engine, a minute).",
        **example("  python -m studies.cases ballast --engine lammps -np 2 --rows settlement.csv"),
    )
    parser.add_argument("case", choices=("impact", "compression", "ballast", "waves", "chain"))
    parser.add_argument("--engine", choices=ENGINES, default="liggghts", help="engine of ballast (default: liggghts)")
    parser.add_argument("--quick", action="store_true", help="a small bed or packing, one pressure")
    parser.add_argument("-np", type=int, default=1, help="number of MPI ranks of ballast and waves (default: 1)")
    parser.add_argument("--rows", type=other_file, help="CSV of the curves, as docs/gallery draws them (not of impact, chain)")
    parser.set_defaults(func=run)
    return parser


def run(arguments, _):
    """Run the case, print its table, write its curves."""
    with tempfile.TemporaryDirectory() as folder:
        if arguments.case == "ballast":
            found = ballast.Cycles(arguments.engine, folder, arguments.np, arguments.quick)
            lines, rows = found.table(), found.rows()
        elif arguments.case == "compression":
            found = compression.curves(folder, arguments.quick)
            lines, rows = compression.table(found), compression.rows(found)
        elif arguments.case == "waves":
            found = waves.waves(folder, (100,) if arguments.quick else (10, 100), arguments.np)
            lines, rows = waves.table(found), waves.rows(found)
        elif arguments.case == "chain":
            lines, rows = chain.table(chain.compare(folder)), None
        else:
            lines, rows = impact.table(impact.compare(folder)), None
        print("\n".join(lines))
        if arguments.rows is not None and rows:
            with open(arguments.rows, "w", encoding="utf-8", newline="") as file:
                csv.writer(file, lineterminator="\n").writerows(rows)
            print(arguments.rows)


def main(arguments=None):
    """Run with these arguments (default: the command line's); the exit status."""
    return execute(parser, arguments)


if __name__ == "__main__":
    sys.exit(main())
