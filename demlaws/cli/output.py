"""Output of the commands: files that are not overwritten by mistake, results as text and as JSON."""

import argparse
import dataclasses
import json
import math
import sys
from pathlib import Path

from demlaws.errors import DemlawsError
from demlaws.files import PARAVIEW, csv_text, wrapped, write_atomically


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
            # the libraries that write files of contacts contain of demlaws only the names of the columns
            head, mark = (file.read(), b"body1") if path.suffix in PARAVIEW else (file.read(4096), b"demlaws")
        ours = head.split(b"\n")[0].decode(errors="replace").strip() == self.titles if self.titles else mark in head
        if head and not ours:
            raise DemlawsError(f"{path} exists and was not written by this command: name another file, or give --force")


output = Output()
"""A picture, table or height map to write."""


class Result:
    """What a command computes: text, printed as it comes, and `values`, which --json prints instead when the command ends."""

    def __init__(self, parsed):
        """Of the parsed arguments, whose files are checked first: DemlawsError where one may not be written."""
        if not getattr(parsed, "overwrite", False):
            for kind, path in parsed.outputs:
                kind.check(path)
        to_output = [kind for kind, path in parsed.outputs if str(path) == "-"]
        if any(not kind.titles for kind in to_output) or len(to_output) > (0 if parsed.json else 1):
            raise DemlawsError('"-" is standard output, for one CSV file and without --json')
        self.values = {}
        self._as_json, self._file, self._lines = parsed.json, sys.stderr if to_output else sys.stdout, []

    def print(self, *texts):
        """Print texts, each from a new line on."""
        for text in texts:
            if self._as_json:
                self._lines += str(text).splitlines()
            else:
                print(text, file=self._file, flush=True)

    def say(self, text, rest="    "):
        """Print each line of a text, wrapped; `rest` begins the lines after the first."""
        self.print(*(wrapped(line, rest=rest) for line in text.splitlines()))

    def write_csv(self, path, titles, rows):
        """Write rows to a CSV file and print its name, or to the standard output if the path is "-"."""
        rows = list(rows)
        text = csv_text(titles, rows)
        if str(path) == "-":
            sys.stdout.write(text)
        else:
            self.print(f"{write_atomically(path, text)}: {len(rows)} rows")

    def finish(self):
        """With --json: print the values, or the text of a command without values."""
        if self._as_json and (self.values or self._lines):
            print(json.dumps(plain(self.values or {"text": self._lines}), indent=1, ensure_ascii=False))


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
