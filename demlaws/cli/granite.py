"""`demlaws granite`: the granite tests with every law, tables, claims, CSV files and figures."""

from pathlib import Path

from demlaws.cli import example
from demlaws.cli.arguments import figures, law_name
from demlaws.cli.output import record


def register(subparsers):
    """Add this file's commands to the command line."""
    parser = subparsers.add_parser(
        "granite",
        description="Runs the seven granite tests of Altuhafi, Baudet & Coop 2023 with every law; prints displacement and "
        "stiffness per test and the paper's claims with verdicts; writes CSV files and figures.",
        **example(
            "  demlaws granite --out granite\n"
            '  demlaws granite --data "SS(18-18)=my_points.csv" --fit-compliance --out mine\n'
            "  demlaws granite --figures 3-9,11-14 --out paper\n"
            '  demlaws granite --figures 8 --data "SS(18-18)=my_points.csv"\n'
            "  demlaws granite --tables\n"
            '  demlaws granite --test "SS(18-18)" --law pohrt-popov --data my_points.csv --out mine\n\n'
            "my_points.csv: two columns with units in the header, for instance\n"
            "  displacement (um),force (N)"
        ),
    )
    parser.add_argument("--test", help="one test only, for instance SS(18-18)")
    parser.add_argument("--law", type=law_name, help="one law only")
    parser.add_argument(
        "--data",
        action="append",
        default=[],
        metavar="[TEST=]FILE",
        help="CSV file of measured points: overlaid, and compared with the claims about the test; may be repeated for "
        "other tests; with --test the file name alone",
    )
    parser.add_argument("--fit-compliance", action="store_true", help="fit the compliance of the apparatus with each misfit")
    parser.add_argument(
        "--figures",
        type=figures(*range(3, 10), *range(11, 15)),
        metavar="LIST",
        help="only these figures of the paper, by number, with their content: all, or for instance 4,8 or 11-14",
    )
    parser.add_argument("--tables", action="store_true", help="only tables 1 to 3 of the paper, with derived quantities")
    parser.add_argument("--out", type=Path, default=Path("granite"), help="folder for CSV files and figures (default: granite)")
    parser.set_defaults(func=run)


def run(arguments):
    """Do what the command's arguments ask."""
    from demlaws.granite.command import run

    record(**run(arguments))
