"""`python -m studies.ballast`: settlement of a bed of ballast under cyclic load, its tables and picture."""

import sys
from pathlib import Path

from demlaws import plots
from demlaws.cli import Parser, example, execute
from demlaws.cli.output import picture_file
from studies.assembly.study import read
from studies.ballast import beds, cycles, picture, report

QUICK = [cycles.Case(law=law, sigma=sigma, cycles=5, count=80) for law, sigma in (("hertz", 0.0), ("pohrt-popov", 2.4))]


def parser():
    """The command line."""
    parser = Parser(
        prog="python -m studies.ballast",
        description="A bed of granite under a plate with cyclic load, in LAMMPS; missing runs are added.",
        **example("  python -m studies.ballast --report --figure ballast.png\n  python -m studies.ballast --quick"),
    )
    parser.add_argument("--results", type=Path, default=cycles.RESULTS, help="file of results")
    parser.add_argument("--store", type=Path, default=cycles.STORE, help="folder of beds and of interrupted runs")
    parser.add_argument("--quick", action="store_true", help="two cases of 80 spheres and 5 cycles, a minute")
    parser.add_argument("--beds", action="store_true", help="beds deposited and loaded with each shear model")
    parser.add_argument("--limit", action="store_true", help="largest stable step of beds at 200 kPa, from their kept states")
    parser.add_argument("--report", action="store_true", help="tables only, from the runs in the file")
    parser.add_argument("--table", type=Path, help="CSV file with the numbers of every bed")
    parser.add_argument("--figure", type=picture_file, help="picture of settlement, resilient modulus and dissipation")
    parser.set_defaults(func=run)
    return parser


def run(arguments, _):
    """Run what is missing, then print the tables."""

    def progress(text):
        print(text, file=sys.stderr, flush=True)

    if arguments.limit:
        for case in QUICK if arguments.quick else (cycles.Case(), cycles.SENSITIVITY["as in the study"]):
            print(f"{report.kind_of(case)}, steps of {case.dt:g} s")
            cycles.stability(case, arguments.store)
        return
    if arguments.beds:
        if not arguments.report:
            beds.run_beds(store=arguments.store, progress=progress)
        print(beds.table(), end="")
        return
    if not arguments.report:
        cycles.run_cases(QUICK if arguments.quick else cycles.wanted(), arguments.results, arguments.store, progress)
        if not arguments.quick:
            cycles.run_cases(cycles.control(), cycles.CONTROL, arguments.store, progress)
            cycles.run_cases(cycles.long(), cycles.LONG, arguments.store, progress)
    rows = read(arguments.results)
    settings = {"least": QUICK[0].cycles, "count": QUICK[0].count} if arguments.quick else {}
    print(report.table(rows, **settings))
    if not arguments.quick:
        for text in (report.effects, report.many, report.course):
            print("\n" + text(rows))
        print("\n" + report.many(read(cycles.LONG)))
        print("\n" + report.effects(read(cycles.CONTROL), report.CONTROL, cycles.SPLIT))
    if arguments.table is not None:
        print(report.save(rows, read(cycles.REPEATS), arguments.table))
    if arguments.figure is not None:
        print(plots.save(picture.draw(rows, read(cycles.LONG)), arguments.figure))


def main(arguments=None):
    """Run with these arguments (default: the command line's); the exit status."""
    return execute(parser, arguments)


if __name__ == "__main__":
    sys.exit(main())
