"""Friction by pressure beside constant friction: simple shear, beds of ballast, drained slopes.

python -m studies.friction                the tables of the stored runs
python -m studies.friction --run          runs of beds and slopes that are missing (LAMMPS, an hour)
python -m studies.friction --shear 12     the runs of simple shear of so many packings again (about ten minutes)
"""

import argparse
import sys

from studies.assembly.study import read
from studies.friction import beds, report, shear, slopes

SEEDS = range(1, 5)
KINDS = ("spheres", "clumps")


def main():
    """Run with the command line's arguments."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--run", action="store_true", help="make the runs of beds and slopes that are missing")
    parser.add_argument("--shear", type=int, metavar="PACKINGS", help="make runs of simple shear of so many packings again")
    arguments = parser.parse_args()
    for seed in SEEDS if arguments.run else ():
        for grains in KINDS:
            slopes.run_slope(grains, seed)
            beds.run_bed(grains, seed)
    if arguments.shear:
        shear.make(arguments.shear)
    print(shear.table(), report.bed_table(read(beds.RUNS)), report.slope_table(read(slopes.RUNS)), sep="\n\n")


if __name__ == "__main__":
    sys.exit(main())
