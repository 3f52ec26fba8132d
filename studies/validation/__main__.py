"""python -m studies.validation [--out FOLDER] [--no-engines] [--quick]"""

import argparse
import sys

from demlaws.errors import DemlawsError
from studies.validation.report import collect, write


def main(arguments=None):
    """Run all comparisons and write the page; exit status 1 where one fails."""
    parser = argparse.ArgumentParser(
        prog="python -m studies.validation",
        description="Published and third-party results compared with ours: one page and figures.",
    )
    parser.add_argument("--out", default="validation", help="folder of the page and its figures")
    parser.add_argument("--no-engines", action="store_true", help="only what needs no engine")
    parser.add_argument("--quick", action="store_true", help="without the random packing (a minute)")
    options = parser.parse_args(arguments)
    try:
        groups = collect(engines=not options.no_engines, packing=not options.quick)
        path = write(groups, options.out)
    except DemlawsError as error:
        print(f"demlaws: error: {error}", file=sys.stderr)
        return 2
    rows = [row for group in groups.values() for row in group]
    failed = [row for row in rows if row.verdict == "FAIL"]
    idle = [row for row in rows if row.verdict == "not run"]
    for row in failed:
        print(f"FAIL  {row.where}: {row.what}: {row.found:.7g}, expected {row.expected}")
    for row in idle:
        print(f"not run  {row.where}: {row.what}: {row.note}")
    print(f"{len(rows) - len(failed) - len(idle)} rows pass, {len(failed)} fail, {len(idle)} not run: {path}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
