"""The command `demlaws`. Each file of this folder has its own commands and is loaded when one of them is used.

`register(add)` of a file adds a command's arguments, `run(arguments, result)` does what they ask.
"""

import argparse
import contextlib
import functools
import importlib
import os
import re
import sys
import warnings
from pathlib import Path

from demlaws.cli.output import OutputFile, Result
from demlaws.errors import DemlawsError, ValidityWarning, most_similar, page

COMMANDS = {
    "check": ("check", "test demlaws with every engine found; --report also prints versions"),
    "granite": ("granite", "reproduce the granite contact tests with every law"),
    "laws": ("laws", "list the laws, or the options of one law"),
    "materials": ("materials", "list typical values of materials, with ranges and sources"),
    "curve": ("curve", "compute one contact along a path of forces or overlaps"),
    "table": ("table", "tabulate a law, or measured points, for an engine"),
    "regime": ("regime", "determine whether asperities or the bulk deform, and which laws apply"),
    "surface": ("surface", "analyse a height map: roughness, fractal dimension, contact, law"),
    "fit": ("fit", "fit laws to measured points and rank them"),
    "choose": ("choose", "find the cheapest law within the tolerance of a scene"),
    "soften": ("soften", "rescale a law for softer grains and longer time steps"),
    "timestep": ("timestep", "compute the largest stable time step of a saved state"),
    "contacts": ("contacts", "list the contacts of dumps, save them as lines for ParaView"),
    "yade": ("yade", "run YADE scripts with these laws, check the installation"),
    "liggghts": ("engine", "use the laws in LIGGGHTS: build, check, export, convert, run"),
    "lammps": ("engine", "use the laws in LAMMPS: build, check, export, convert, run"),
}
"""Command → its file in this folder and its line in `demlaws --help`, which loads none of the files."""


LAW_FILE = "--law-file"


class _LawFile(argparse.Action):
    """Loads the file at once, so that the following arguments can name its laws."""

    def __call__(self, parser, namespace, values, option_string=None):
        from demlaws.laws.registry import load_laws

        load_laws(values)
        namespace.law_files = [*getattr(namespace, "law_files", []), values]


class _SingleUse(argparse._StoreAction):
    """As argparse's store, for an option that is given once: a second one would replace the first silently."""

    def __call__(self, parser, namespace, values, option_string=None):
        if option_string is not None and getattr(namespace, self.dest) is not self.default:
            raise argparse.ArgumentError(self, "given twice: give all its values at once")
        super().__call__(parser, namespace, values, option_string)


class _Help(argparse.RawDescriptionHelpFormatter):
    """Keeps the lines of an example, wraps a description, which is one line, and shows the kind of a value: FORCE, FILE."""

    def _get_default_metavar_for_optional(self, action):
        kind = {Path: "FILE", int: "COUNT"}.get(action.type) or getattr(action.type, "metavar", None)
        return kind or super()._get_default_metavar_for_optional(action)

    def _fill_text(self, text, width, indent):
        if "\n" in text:
            return super()._fill_text(text, width, indent)
        return argparse.HelpFormatter._fill_text(self, text, width, indent)


class Parser(argparse.ArgumentParser):
    """argparse with --law-file and --json, which reads -1e-3 as a number so that the error names its value and unit.

    shows_json: False for a command whose program prints to the standard output itself; it refuses --json.
    """

    def __init__(self, *arguments, shows_json=True, **options):
        # --law would otherwise stand for --law-file where a command has no --law
        super().__init__(*arguments, allow_abbrev=False, **{"formatter_class": _Help, **options})
        self.add_argument(
            LAW_FILE,
            action=_LawFile,
            dest=argparse.SUPPRESS,
            metavar="FILE.py",
            help=f"a Python file that registers user-defined laws (may be repeated; {page('own-laws')})",
        )
        self.register("action", None, _SingleUse)
        self.register("action", "store", _SingleUse)
        text = "print the result as JSON" if shows_json else argparse.SUPPRESS
        self.add_argument("--json", action="store_true", default=argparse.SUPPRESS, help=text)
        self._negative_number_matcher = re.compile(
            r"^-(\d+\.?\d*|\.\d+)(e[-+]?\d+)?\s*[a-zµμ°/³]*$|^-(inf|nan)$", re.IGNORECASE
        )

    def add_argument(self, *names, **options):
        """As argparse; a parser with a file to write also has --overwrite."""
        if isinstance(options.get("type"), OutputFile) and "--overwrite" not in self._option_string_actions:
            super().add_argument("--overwrite", action="store_true", help="replace existing files, whatever wrote them")
        return super().add_argument(*names, **options)

    def parse_args(self, args=None, namespace=None):
        """As argparse; an unknown option is reported with the most similar, and `json` and `outputs` are always set."""
        namespace, unknown = self.parse_known_args(args, namespace)
        parser = self
        while below := next((a for a in parser._actions if isinstance(a, argparse._SubParsersAction)), None):
            parser = below.choices[getattr(namespace, below.dest)]
        if unknown:
            match = most_similar(unknown[0].split("=")[0], parser._option_string_actions)
            parser.error(f"unrecognized argument {unknown[0]!r:.200}{f': did you mean {match}?' if match else ''}")
        namespace.json = getattr(namespace, "json", False)
        outputs = [
            (action.type, getattr(namespace, action.dest)) for action in parser._actions if isinstance(action.type, OutputFile)
        ]
        namespace.outputs = [(kind, path) for kind, path in outputs if path is not None]
        return namespace

    def error(self, message):
        """One line, without the usage."""
        self.exit(2, f"{self.prog}: error: {message}; see {self.prog} --help\n")


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
    for name, (part, line) in COMMANDS.items():
        add = functools.partial(subparsers.add_parser, name, help=line)
        if name in commands:
            module = importlib.import_module(f"{__name__}.{part}")
            module.register(add)
            subparsers.choices[name].set_defaults(func=getattr(module, "run", None))
        else:
            add()
    return parser


def option(text):
    """`name=value` with the value as a number, true, false or null, else text, which the law's record reads (1.66GPa)."""
    import json

    name, separator, value = text.partition("=")
    if not separator or not name:
        raise argparse.ArgumentTypeError(
            f"{text!r}: write an option of a law as name=value, for instance yield_pressure=1.66GPa"
        )
    with contextlib.suppress(json.JSONDecodeError):
        value = json.loads(value)
    if isinstance(value, (list, dict)):
        raise argparse.ArgumentTypeError(f"{text!r}: the value of a law's option is one number or one word")
    return name.replace("-", "_"), value


def example(text):
    """Keyword arguments of a sub-parser whose epilog keeps its lines."""
    return {"epilog": "example:\n" + text}


def _show_warnings():
    """Warnings for users as one line without a place, which would be in our files; any other as Python does."""
    otherwise, shown = warnings.showwarning, set()

    def show(message, category, filename, lineno, file=None, line=None):
        if issubclass(category, UserWarning):
            if (text := str(message)) not in shown:
                print(f"demlaws: warning: {text}", file=sys.stderr)
                shown.add(text)
        else:
            otherwise(message, category, filename, lineno, file, line)

    warnings.simplefilter("once", ValidityWarning)
    warnings.showwarning = show


def main(arguments=None):
    """Run the command; returns the exit status: 0, or 2 after an error, which is one line."""
    arguments = sys.argv[1:] if arguments is None else arguments
    if "_ARGCOMPLETE" in os.environ:
        _complete()
    if not arguments:
        build_parser(()).print_help()
        print("\nerror: no command; name one of those above", file=sys.stderr)
        return 2
    commands = [word for word in arguments if word in COMMANDS][:1] or arguments[:1]
    return execute(lambda: build_parser(commands), arguments)


def _complete():
    """Answer the shell that asks for words to complete a command line, and exit: `register-python-argcomplete demlaws`."""
    import argcomplete

    from demlaws.laws import MODULES

    parser, names = build_parser(), [name.replace("_", "-") for name in MODULES]
    for one in _parsers(parser):
        for action in one._actions:
            if action.dest == "law":
                action.completer = lambda **_: names
    argcomplete.autocomplete(parser)


def _parsers(parser):
    """A parser and all below it."""
    yield parser
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for one in dict.fromkeys(action.choices.values()):
                yield from _parsers(one)


def execute(parser, arguments):
    """Parse the arguments with the parser that `parser()` returns and call its `func` with them and a `Result`.

    Returns the exit status: 2 after an error, which is one line.
    """
    if sys.stderr is None:  # closed, as by 2>&-
        sys.stderr = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115
    if sys.stdout is None:  # >&-
        return _failed("the standard output is closed")
    for stream in (sys.stdout, sys.stderr):  # a terminal without µ prints ?
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")
    try:
        try:
            parsed = parser().parse_args(arguments)
            with warnings.catch_warnings():
                _show_warnings()
                result = Result(parsed)
                status = parsed.func(parsed, result) or 0
                result.finish()
        finally:
            sys.stdout.flush()
        return status
    except DemlawsError as error:
        return _failed(error)
    except OverflowError:
        return _failed("a value exceeds the range of numbers: check the units")
    except MemoryError:
        return _failed("not enough memory: use a smaller map, fewer contacts, steps or points")
    except KeyboardInterrupt:
        print("demlaws: interrupted", file=sys.stderr)
        return 130
    except BrokenPipeError:
        _drop_output(sys.stdout, sys.stderr)  # the reader of our output has gone; nothing more is printed
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
    """Discard the unwritten output of streams; Python would try to write it again at exit."""
    for stream in streams:
        try:
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
        except (OSError, ValueError):
            stream.close()


if __name__ == "__main__":
    sys.exit(main())
