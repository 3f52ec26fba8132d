"""`python -m studies.assembly`: moduli and wave speeds of packings over pressure, their exponents, table and picture."""

import sys
from pathlib import Path

from demlaws import plots
from demlaws.cli import Parser, example, execute
from demlaws.cli.output import picture_file
from studies.assembly import attenuation, probe, report, study

QUICK = [
    study.Series(law=law, sigma=sigma, path=path, count=200)
    for law, sigma in (("hertz", 0.0), ("pohrt-popov", 0.5))
    for path in study.PATHS
]


def parser():
    """The command line."""
    parser = Parser(
        prog="python -m studies.assembly",
        description="Exponents of small-strain moduli and wave speeds over pressure; missing runs are added.",
        **example("  python -m studies.assembly --report --figure small-strain.png\n  python -m studies.assembly --quick"),
    )
    parser.add_argument("--grains", type=int, default=1000, help="spheres per packing (default: 1000)")
    parser.add_argument("--seeds", type=int, default=5, help="packings of each kind (default: 5)")
    parser.add_argument("--results", type=Path, default=study.RESULTS, help="file of results")
    parser.add_argument("--store", type=Path, default=study.STORE, help="folder of initial packings")
    parser.add_argument("--quick", action="store_true", help="four series of 200 spheres, two minutes")
    parser.add_argument("--probe", action="store_true", help="compare moduli with small strains in LAMMPS")
    parser.add_argument(
        "--ratios", type=float, nargs="+", metavar="K_t/K", help="moduli of rough granite at 100 kPa with these"
    )
    parser.add_argument("--sensitivity", action="store_true", help="three series with other settings of the compression")
    parser.add_argument("--report", action="store_true", help="tables only, from the runs in the file")
    parser.add_argument("--attenuation", action="store_true", help="energy that friction takes from small waves, in LAMMPS")
    parser.add_argument("--table", type=Path, help="CSV file with the exponents of all packings")
    parser.add_argument("--figure", type=picture_file, help="picture of the exponents")
    parser.set_defaults(func=run)
    return parser


def run(arguments, _):
    """Run what is missing, then print the tables."""

    def progress(text):
        print(text, file=sys.stderr, flush=True)

    if arguments.ratios:
        for ratio, constrained, shear in study.at_ratios(arguments.ratios, arguments.grains, arguments.store):
            print(f"K_t/K = {ratio:g}: M = {1e-6 * constrained:.1f} MPa, G = {1e-6 * shear:.1f} MPa")
        return
    if arguments.probe:
        if not arguments.report:
            probe.run_probes(arguments.grains, store=arguments.store, progress=progress)
        print(probe.table(), end="")
        return
    if arguments.attenuation:
        if not arguments.report:
            attenuation.run_waves(store=arguments.store, progress=progress)
        print(attenuation.table(), end="")
        return
    if arguments.sensitivity:
        if not arguments.report:
            study.run_sensitivity(arguments.grains, store=arguments.store, progress=progress)
        print(report.sensitivity(study.read(study.SENSITIVITY)), end="")
        return
    if not arguments.report:
        series = QUICK if arguments.quick else study.wanted(arguments.grains, arguments.seeds)
        study.run(series, arguments.results, arguments.store, progress)
    count = QUICK[0].count if arguments.quick else arguments.grains
    kept = study.read(arguments.results)
    rows = [row for row in kept if row["count"] == count]
    print(report.table(rows))
    if arguments.table is not None:
        print(report.save(kept, arguments.table))
    if arguments.figure is not None:
        print(plots.save(report.draw(rows), arguments.figure))


def main(arguments=None):
    """Run with these arguments (default: the command line's); the exit status."""
    return execute(parser, arguments)


if __name__ == "__main__":
    sys.exit(main())
