"""`python -m studies.grading`: heaps and a cyclic oedometer with fines, their tables and picture."""

import csv
import sys
from functools import partial
from pathlib import Path

from demlaws import plots
from demlaws.cli import Parser, example, execute
from demlaws.cli.output import picture_file
from demlaws.errors import DemlawsError
from studies.assembly.study import read
from studies.grading import report, runs
from studies.grading.scenes import MODELS, Case

RATIOS = {2: 84, 5: 400, 10: 250, 20: 250}
"""Ratio of diameters → fines of a heap."""
STORE = Path("results") / "grading"


def heaps(seeds, ratios=RATIOS, models=MODELS):
    """Cases of the heaps, seed by seed."""
    return [Case(ratio=r, model=m, seed=s, fines=RATIOS[r]) for s in seeds for r in ratios for m in models]


def oedometers(seeds, models=MODELS):
    """Cases of the oedometer: 10 % fines by mass."""
    return [Case(ratio=5, model=m, seed=s, large=80, fines=1111, young=1e8) for s in seeds for m in models]


def parser():
    """The command line."""
    parser = Parser(
        prog="python -m studies.grading",
        description="Large grains and fines in LAMMPS, with former, present and stock shear; missing runs are added.",
        **example(
            "  python -m studies.grading heap --report\n  python -m studies.grading heap --former ../before --seeds 1 2 3"
        ),
    )
    parser.add_argument("scene", nargs="?", choices=["heap", "oedometer"], default="heap")
    parser.add_argument("--results", type=Path, help="file of results (default: that of the study)")
    parser.add_argument("--store", type=Path, default=STORE, help="folder of the beds")
    parser.add_argument("--former", type=Path, help='checkout whose plugin is the model "before"; without it that is left out')
    parser.add_argument("--seeds", type=int, nargs="+", default=[1, 2, 3], help="of the places of grains (default 1 2 3)")
    parser.add_argument("--ratios", type=int, nargs="+", choices=RATIOS, default=list(RATIOS), help="of the heap")
    parser.add_argument(
        "--share", type=float, default=report.MAIN, help="step over the Rayleigh time of the fines (default 0.25)"
    )
    parser.add_argument("--models", nargs="+", choices=MODELS, default=list(MODELS))
    parser.add_argument("--quick", action="store_true", help="small scenes with the models after and stock, half a minute")
    parser.add_argument("--report", action="store_true", help="tables only, from the runs in the file")
    parser.add_argument("--figure", type=picture_file, help="picture of the heaps, from the file of the study")
    parser.set_defaults(func=run)
    return parser


def simulated(scene, former, store, **settings):
    """The function case → row."""

    def row(case):
        given = former if case.model == "before" else None
        if scene == "heap":
            return runs.run_heap(case, store, given, **settings)
        return runs.run_oedometer(case, store, given, **settings)

    return row


def run(arguments, _):
    """Run what is missing, then print the table."""
    heap = arguments.scene == "heap"
    path = arguments.results or (runs.HEAPS if heap else runs.OEDOMETERS)
    models = [m for m in arguments.models if m != "before" or arguments.former]
    cases = heaps(arguments.seeds, arguments.ratios, models) if heap else oedometers(arguments.seeds, models)
    cases, settings = [case._replace(share=arguments.share) for case in cases], {}
    if arguments.quick:
        if arguments.results is None:
            raise DemlawsError("--quick: name a file for its rows by --results; the kept runs are longer")
        cases = [c._replace(ratio=2, fines=20, large=20, young=5e6) for c in cases if c.model in ("after", "stock")][:2]
        settings = {"rest": 0.1} if heap else {"cycles": 2}
    if arguments.former is not None and not (arguments.former / "demlaws").is_dir():
        raise DemlawsError(f"--former {arguments.former}: no checkout of demlaws, it has no folder demlaws")
    if not arguments.report:
        fields = runs.HEAP_FIELDS if heap else runs.OEDOMETER_FIELDS
        progress = partial(print, file=sys.stderr, flush=True)
        runs.run_cases(cases, path, fields, simulated(arguments.scene, arguments.former, arguments.store, **settings), progress)
    writer = csv.writer(sys.stdout, lineterminator="\n")
    writer.writerow(report.HEAP_TITLES if heap else report.OEDOMETER_TITLES)
    writer.writerows((report.heap_table if heap else report.oedometer_table)(read(path)))
    if arguments.figure is not None:
        print(plots.save(report.draw(read(runs.HEAPS)), arguments.figure))


def main(arguments=None):
    """Run with these arguments (default: the command line's); the exit status."""
    return execute(parser, arguments)


if __name__ == "__main__":
    sys.exit(main())
