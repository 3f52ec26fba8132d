"""Output of the commands: files that are not overwritten by mistake, CSV on standard output, JSON."""

import argparse
import contextlib
import dataclasses
import io
import json
import math
import sys
from pathlib import Path

from demlaws.errors import DemlawsError
from demlaws.files import PARAVIEW


class Output:
    """Kind of argument: a file to write. Its parser has --force, and leaves what is written by others as it is.

    `titles` is the first line of the command's CSV file, for which "-" is standard output, and "" for other kinds of file.
    """

    def __init__(self, titles=()):
        self.titles = ",".join(titles)

    def __call__(self, text):
        """The path; a folder is refused."""
        path = Path(text)
        if not path.name or path.is_dir():
            raise argparse.ArgumentTypeError(f"{text!r} is a folder: name a file in it")
        return path

    def check(self, path):
        """Raise DemlawsError if the file exists and was not written by the same command."""
        if str(path) == "-" or not path.is_file():
            return
        with open(path, "rb") as file:
            # the libraries that write files of contacts know no word of ours but the names of the columns
            head, mark = (file.read(), b"body1") if path.suffix in PARAVIEW else (file.read(4096), b"demlaws")
        ours = head.split(b"\n")[0].decode(errors="replace").strip() == self.titles if self.titles else mark in head
        if head and not ours:
            raise DemlawsError(f"{path} exists and was not written by this command: name another file, or give --force")


output = Output()
"""A picture, table or height map to write."""


_results = {}
_streams = []


def record(**values):
    """Add values to the JSON document that the command prints with --json."""
    _results.update(values)


def recorded(name, default):
    """A value of the JSON document so far."""
    return _results.get(name, default)


def say(text, rest="    "):
    """Print each line of a text, wrapped."""
    from demlaws.files import wrapped

    for line in text.splitlines():
        print(wrapped(line, rest=rest))


def write_csv(path, titles, rows):
    """Write rows to a CSV file and print its name, or to standard output if the path is "-"."""
    from demlaws.files import csv_text, write_atomically

    rows = list(rows)
    text = csv_text(titles, rows)
    if str(path) == "-":
        (_streams[-1] if _streams else sys.stdout).write(text)
    else:
        print(f"{write_atomically(path, text)}: {len(rows)} rows")


def plain(value):
    """A value as JSON has it: arrays as lists, records as objects, NaN and infinity as null."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        value = {field.name: getattr(value, field.name) for field in dataclasses.fields(value)}
    elif hasattr(value, "_asdict"):
        value = value._asdict()
    elif hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, dict):
        return {str(name): plain(part) for name, part in value.items()}
    if isinstance(value, list | tuple):
        return [plain(part) for part in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value if value is None or isinstance(value, bool | int | float | str) else str(value)


@contextlib.contextmanager
def arranged(parsed):
    """Check the files that the command is to write, and arrange its output for --json and for a file named "-"."""
    if not getattr(parsed, "overwrite", False):
        for kind, path in parsed.outputs:
            kind.check(path)
    to_output = [kind for kind, path in parsed.outputs if str(path) == "-"]
    if any(not kind.titles for kind in to_output) or len(to_output) > (0 if parsed.json else 1):
        raise DemlawsError('"-" is standard output, for one CSV file and without --json')
    if not parsed.json and not to_output:
        yield
        return
    _results.clear()
    _streams.append(sys.stdout)
    text = io.StringIO()
    try:
        with contextlib.redirect_stdout(text if parsed.json else sys.stderr):
            yield
    finally:
        stream = _streams.pop()
    if parsed.json:
        answer = plain(_results) if _results else {"text": text.getvalue().splitlines()}
        stream.write(json.dumps(answer, indent=1, ensure_ascii=False) + "\n")
