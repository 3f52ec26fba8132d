"""The command `demlaws`. Each part of the package brings its own sub-commands; this file joins them."""

import argparse
import importlib
import json
import re
import sys
import warnings

from demlaws.errors import DemlawsError, ValidityWarning

PARTS = (
    "demlaws.cli.granite",
    "demlaws.cli.curve",
    "demlaws.cli.surface",
    "demlaws.cli.fit",
    "demlaws.cli.choose",
    "demlaws.cli.stability",
    "demlaws.cli.trade",
    "demlaws.cli.yade",
    "demlaws.cli.liggghts",
    "demlaws.cli.lammps",
)


class Parser(argparse.ArgumentParser):
    """argparse that takes -1e-3 for a number, so that the error about it can name the value and the unit."""

    def __init__(self, *arguments, **options):
        super().__init__(*arguments, **options)
        self._negative_number_matcher = re.compile(r"^-(\d+\.?\d*|\.\d+)(e[-+]?\d+)?$", re.IGNORECASE)


def build_parser():
    """The whole command line."""
    from demlaws import __version__

    parser = Parser(
        prog="demlaws",
        description="Contact laws of rough and yielding grains for DEM: single contacts, tables, YADE, LIGGGHTS.",
        epilog="Example: demlaws granite --out granite",
    )
    parser.add_argument("--version", action="version", version=f"demlaws {__version__}")
    subparsers = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for part in PARTS:
        importlib.import_module(part).register(subparsers)
    return parser


def option(text):
    """`name=value` with the value as JSON where it is JSON, else text."""
    name, separator, value = text.partition("=")
    if not separator or not name:
        raise argparse.ArgumentTypeError(
            f"{text!r}: write an option of a law as name=value, for instance yield_pressure=1.66e9"
        )
    try:
        return name.replace("-", "_"), json.loads(value)
    except json.JSONDecodeError:
        return name.replace("-", "_"), value


def example(text):
    """Keyword arguments of a sub-parser whose epilog keeps its lines."""
    return {"epilog": "example:\n" + text, "formatter_class": argparse.RawDescriptionHelpFormatter}


def _show_warnings():
    """Validity warnings as one line; any other as Python does."""
    otherwise = warnings.showwarning

    def show(message, category, filename, lineno, file=None, line=None):
        if issubclass(category, ValidityWarning):
            print(f"demlaws: warning: {message}", file=sys.stderr)
        else:
            otherwise(message, category, filename, lineno, file, line)

    warnings.simplefilter("once", ValidityWarning)
    warnings.showwarning = show


def main(arguments=None):
    """Run the command; returns the exit status: 0, or 2 after an error, which is one line."""
    try:
        parsed = build_parser().parse_args(arguments)
        with warnings.catch_warnings():
            _show_warnings()
            return parsed.func(parsed) or 0
    except DemlawsError as error:
        print(f"demlaws: error: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("demlaws: interrupted", file=sys.stderr)
        return 130
    except BrokenPipeError:
        sys.stderr.close()  # the reader of our output has gone; say nothing more
        return 0


if __name__ == "__main__":
    sys.exit(main())
