"""The command `demlaws`. Each file of this folder brings its own commands and is loaded when one of them is named."""

import argparse
import contextlib
import importlib
import re
import sys
import warnings

from demlaws.core import notice
from demlaws.errors import DemlawsError, ValidityWarning

COMMANDS = {
    "granite": ("granite", "reproduce the granite contact tests with every law"),
    "laws": ("laws", "list the laws, or one law's options"),
    "curve": ("curve", "one law, one contact, any path"),
    "table": ("table", "a law, or measured points, as a certified table"),
    "regime": ("regime", "do asperities or the bulk deform, and which law fits"),
    "surface": ("surface", "a height map: roughness, fractal dimension, contact, law"),
    "fit": ("fit", "fit laws to measured points and rank them"),
    "choose": ("choose", "the cheapest law that a scene allows"),
    "soften": ("soften", "softer grains that stay on their branch, for longer steps"),
    "timestep": ("timestep", "the largest stable time step of a snapshot"),
    "yade": ("yade", "run YADE scripts with these laws, check the bridge"),
    "liggghts": ("engine", "the laws inside LIGGGHTS: build, check, export, run"),
    "lammps": ("engine", "the laws inside LAMMPS: build, check, export, run"),
}
"""Command → the file of this folder that brings it, and its line of `demlaws --help`, which loads none of them."""


LAWS = "--laws"


class _Laws(argparse.Action):
    """Loads the file at once: what stands after it on the command line may name its laws."""

    def __call__(self, parser, namespace, values, option_string=None):
        from demlaws.laws.registry import load_laws

        load_laws(values)


class Parser(argparse.ArgumentParser):
    """argparse that takes -1e-3 for a number, so that the error about it can name the value and the unit, and --laws."""

    def __init__(self, *arguments, **options):
        super().__init__(*arguments, **options)
        self.add_argument(
            LAWS,
            action=_Laws,
            dest=argparse.SUPPRESS,
            metavar="FILE.py",
            help="a Python file of your own that registers laws (may be repeated; docs/own-laws.md)",
        )
        self._negative_number_matcher = re.compile(
            r"^-(\d+\.?\d*|\.\d+)(e[-+]?\d+)?\s*[a-zµμ°/³]*$|^-(inf|nan)$", re.IGNORECASE
        )

    def _get_option_tuples(self, option_string):
        """--laws has no shorter form: --law is another option, which not every command has."""
        return [found for found in super()._get_option_tuples(option_string) if LAWS not in found[0].option_strings]

    def error(self, message):
        """One line, without the whole usage above it."""
        self.exit(2, f"{self.prog}: error: {message}; see {self.prog} --help\n")


class _Part:
    """What a file registers its commands with: their lines of help stand here, and commands not asked for are left out."""

    def __init__(self, subparsers, wanted):
        self.subparsers, self.wanted = subparsers, wanted

    def add_parser(self, name, **options):
        subparsers = self.subparsers if name in self.wanted else Parser().add_subparsers()
        return subparsers.add_parser(name, help=COMMANDS[name][1], **options)


def build_parser(commands=tuple(COMMANDS)):
    """The command line: `commands` with all their arguments, the others with their line of help only."""
    from demlaws import __version__

    parser = Parser(
        prog="demlaws",
        description="Contact laws of rough and yielding grains for DEM: single contacts, tables, YADE, LIGGGHTS, LAMMPS.",
        epilog="Example: demlaws granite --out granite",
    )
    parser.add_argument("--version", action="version", version=f"demlaws {__version__}")
    subparsers = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    registered = set()
    for name, (part, line) in COMMANDS.items():
        if name not in commands:
            subparsers.add_parser(name, help=line)
        elif part not in registered:
            registered.add(part)
            importlib.import_module(f"{__name__}.{part}").register(_Part(subparsers, commands))
    return parser


def option(text):
    """`name=value` with the value as a number (also with a unit: 1.66GPa), true, false or null, else text."""
    import json

    from demlaws.units import any_quantity

    name, separator, value = text.partition("=")
    if not separator or not name:
        raise argparse.ArgumentTypeError(
            f"{text!r}: write an option of a law as name=value, for instance yield_pressure=1.66GPa"
        )
    number = any_quantity(value)
    if number is not None:
        return name.replace("-", "_"), number
    with contextlib.suppress(json.JSONDecodeError):
        value = json.loads(value)
    if isinstance(value, (list, dict)):
        raise argparse.ArgumentTypeError(f"{text!r}: the value of a law's option is one number or one word")
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
    arguments = sys.argv[1:] if arguments is None else arguments
    commands = [word for word in arguments if word in COMMANDS][:1] or arguments[:1]
    return execute(lambda: build_parser(commands), arguments)


def execute(parser, arguments):
    """Parse the arguments with what `parser()` returns, call its `func`; errors become one line and exit status 2."""
    for stream in (sys.stdout, sys.stderr):  # a terminal without µ gets ? in its place
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")
    try:
        try:
            parsed = parser().parse_args(arguments)
            with warnings.catch_warnings():
                _show_warnings()
                notice.say = _compiling
                status = parsed.func(parsed) or 0
        finally:
            sys.stdout.flush()
        return status
    except DemlawsError as error:
        return _failed(error)
    except MemoryError:
        return _failed("there is not enough memory for this: ask for less (a smaller map, fewer contacts, steps or points)")
    except KeyboardInterrupt:
        print("demlaws: interrupted", file=sys.stderr)
        return 130
    except BrokenPipeError:
        _drop_output(sys.stdout, sys.stderr)  # the reader of our output has gone; say nothing more
        return 0
    except OSError as error:
        try:
            sys.stdout.flush()
        except OSError:
            _drop_output(sys.stdout)
        place = f"{error.filename}: " if error.filename else "output: "
        return _failed(f"{place}{error.strerror or error}")


def _failed(reason):
    print(f"demlaws: error: {reason}", file=sys.stderr)
    return 2


def _drop_output(*streams):
    """What a stream still holds goes nowhere: Python would try to write it again when it ends."""
    import os

    for stream in streams:
        try:
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
        except (OSError, ValueError):
            stream.close()


def _compiling():
    print("demlaws: compiling these laws for this machine; this is done once and kept", file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
