"""python -m studies.validation [--out FOLDER] [--no-engines]"""

import sys

from demlaws.cli import Parser, execute
from studies.validation.report import collect, write


def parser():
    """The command line."""
    parser = Parser(
        prog="python -m studies.validation",
        description="Published and third-party results compared with ours: one page and figures. Exit status 1 if a row fails.",
    )
    parser.add_argument("--out", default="validation", help="folder of the page and its figures")
    parser.add_argument("--no-engines", action="store_true", help="only what needs no engine")
    parser.set_defaults(func=run)
    return parser


def run(options, _):
    """Run all comparisons and write the page; exit status 1 where one fails."""
    groups = collect(engines=not options.no_engines)
    path = write(groups, options.out)
    rows = [row for group in groups.values() for row in group]
    failed = [row for row in rows if row.verdict == "FAIL"]
    idle = [row for row in rows if row.verdict == "not run"]
    for row in failed:
        print(f"FAIL  {row.where}: {row.what}: {row.found:.7g}, expected {row.expected}")
    for row in idle:
        print(f"not run  {row.where}: {row.what}: {row.note}")
    print(f"{len(rows) - len(failed) - len(idle)} rows pass, {len(failed)} fail, {len(idle)} not run: {path}")
    return 1 if failed else 0


def main(arguments=None):
    """Run the command; returns the exit status."""
    return execute(parser, arguments)


if __name__ == "__main__":
    sys.exit(main())
