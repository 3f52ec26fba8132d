"""`demlaws granite`: the granite tests with every law, tables, claims, CSV files and figures."""

from pathlib import Path

from demlaws.cli import example


def register(add):
    """Add this command."""
    parser = add(
        description="Computes the seven granite tests of Altuhafi, Baudet & Coop (2023) with every law, prints displacement "
        "per test and the claims of the paper with verdicts, and writes CSV files and figures.",
        **example('  demlaws granite --out granite\n  demlaws granite --test "SS(18-18)" --law pohrt-popov --out ss18'),
    )
    parser.add_argument("--test", help="one test only, for instance SS(18-18)")
    parser.add_argument("--law", help="one law only")
    parser.add_argument(
        "--modulus",
        choices=("text", "figures"),
        default="text",
        help="E* of tables and figures: E/(2(1 - ν²)), the definition in the text (default), or E/(2(1 - ν)), which fits the "
        "three printed numbers that depend on E*; claims are given with both",
    )
    parser.add_argument("--verbose", action="store_true", help="a table per test, and numbers and criterion of each claim")
    parser.add_argument("--out", type=Path, default=Path("granite"), help="folder for CSV files and figures (default: granite)")


def run(arguments, result):
    """Do what the command's arguments ask."""
    from demlaws.granite.command import run

    run(arguments, result)
