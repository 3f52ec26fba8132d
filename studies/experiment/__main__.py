"""python -m studies.experiment [--grains N] [--seeds N] [--report]"""

import argparse
import sys
from pathlib import Path

from demlaws.errors import DemlawsError
from studies.experiment import oedometer


def main(arguments=None):
    """Run the missing cases, then write table and figure."""
    parser = argparse.ArgumentParser(
        prog="python -m studies.experiment",
        description="Glass beads in an oedometer, predicted with each law and compared with a measurement.",
    )
    parser.add_argument("--grains", type=int, default=3000, help="number of grains (default: 3000)")
    parser.add_argument("--seeds", type=int, default=5, help="number of packings (default: 5)")
    parser.add_argument("--results", default=str(oedometer.RESULTS), help="file of runs: missing ones are added")
    parser.add_argument("--one-packing", action="store_true", help="instead: YADE's Hertz and ours from the same packing")
    parser.add_argument("--report", action="store_true", help="only table and figure, from the runs in the file")
    parser.add_argument("--figure", default="results/experiment.png", help="file of the figure")
    options = parser.parse_args(arguments)
    if options.grains < 100 or options.seeds < 1:
        parser.error(f"--grains {options.grains} --seeds {options.seeds}: at least 100 grains and one packing")
    try:

        def progress(text):
            print(text, flush=True)

        if options.one_packing:
            oedometer.run_from_one_packing(options.grains, 1, options.results, progress)
        elif not options.report:
            oedometer.run(options.grains, options.seeds, options.results, progress=progress)
            few = [case for case in oedometer.CASES if "calibrated" in case.label]
            oedometer.run(oedometer.FEW, 1, options.results, [*few, *oedometer.STIFFER], progress)
        from studies.experiment.report import figure, table

        print(table(oedometer.read(options.results), options.grains), end="")
        Path(options.figure).parent.mkdir(parents=True, exist_ok=True)
        figure(oedometer.read(options.results), options.grains, options.figure)
    except DemlawsError as error:
        print(f"demlaws: error: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
