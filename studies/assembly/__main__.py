"""python -m studies.assembly [--grains N] [--seeds N] [--report] [--figure FILE] [--quick]"""

import argparse
import sys
import tempfile
from pathlib import Path

from studies.assembly import study


def main(arguments=None):
    """Run the missing series, then print the table and draw the picture."""
    parser = argparse.ArgumentParser(prog="python -m studies.assembly", description=__doc__.splitlines()[0])
    parser.add_argument("--grains", type=int, default=1000, help="spheres per packing (default: 1000)")
    parser.add_argument("--seeds", type=int, default=5, help="packings of each kind (default: 5)")
    parser.add_argument("--results", type=Path, default=study.RESULTS, help="file of results: missing series are added")
    options = parser.parse_args(arguments)
    study.run(options.grains, options.seeds, options.results, progress=lambda text: print(text, flush=True))


if __name__ == "__main__":
    sys.exit(main())
