"""Output of the commands: files that are not overwritten by mistake, results as text and as JSON."""

import argparse
import dataclasses
import functools
import json
import math
import os
import shutil
import sys
from pathlib import Path

from demlaws.errors import DemlawsError
from demlaws.files import PARAVIEW_MARK, csv_text, wrapped, write_atomically


class OutputFile:
    """Kind of argument: a file to write. Its parser has --overwrite; without it only a file of this kind is replaced.

    is_ours: whether the first bytes of a file are those of a file that the command wrote; None: no file of this kind says so.
    is_csv: whether "-" is the standard output.
    """

    metavar = "FILE"

    def __init__(self, is_ours=None, is_csv=False):
        self.is_ours, self.is_csv = is_ours, is_csv

    def __call__(self, text):
        """The path; a folder is refused."""
        path = Path(text)
        if not path.name or os.path.isdir(path):
            raise argparse.ArgumentTypeError(f"{text!r} is a folder: name a file in it")
        return path

    def check(self, path, overwrite=False):
        """Raise DemlawsError if its folder is missing, or the file exists, is not empty and is not known to be of this kind."""
        if not path.parent.exists():
            raise DemlawsError(f"cannot write {path}: the folder {path.parent} does not exist: make it, or name another")
        if overwrite or (self.is_csv and str(path) == "-") or not os.path.isfile(path):
            return
        with open(path, "rb") as file:
            head = file.read(1 << 20)
        if head and not (self.is_ours and self.is_ours(head)):
            raise DemlawsError(
                f"{path} exists and is not known to be a file of this command: name another file, or give --overwrite"
            )


def csv_file(titles, last=True):
    """A CSV file whose first line has these titles; last: and no others."""
    line = ",".join(titles).encode()
    return OutputFile(lambda head: head.startswith((line + b"\n", line + b"\r") if last else line), is_csv=True)


table_file = OutputFile(lambda head: head.startswith(b"# demlaws-table "))
"""A table."""
PICTURES = (".png", ".pdf", ".svg", ".eps", ".jpg", ".jpeg", ".pgf", ".ps", ".svgz", ".tif", ".tiff", ".webp")
"""How names of pictures end."""


class PictureFile(OutputFile):
    """A picture to draw; a name without an ending is that of a PNG file."""

    def __call__(self, text):
        """The path with its ending."""
        path = super().__call__(text)
        return path if path.suffix or text == "-" else path.with_suffix(".png")

    def check(self, path, overwrite=False):
        """As of other files; an ending that no picture has is refused before anything is computed."""
        if str(path) != "-" and path.suffix.lower() not in PICTURES:
            raise DemlawsError(f"cannot draw {path}: a picture must end in {', '.join(PICTURES)}")
        super().check(path, overwrite)


picture_file = PictureFile(
    lambda head: (
        (head.startswith(b"\x89PNG") and b"tEXtSoftware\0demlaws" in head[:4096])
        or (head.startswith(b"<?xml") and b"<dc:title>demlaws</dc:title>" in head[:4096])
        or (head.startswith(b"%PDF-") and b"/Creator (demlaws)" in head)
    )
)
"""A picture: a PNG, SVG or PDF file that names demlaws as the program that drew it."""
lines_file = OutputFile(lambda head: PARAVIEW_MARK in head[:400])
"""Contacts as lines for ParaView."""
other_file = OutputFile()
"""A file that nothing marks as ours, as a height map: it is replaced only with --overwrite."""


class Result:
    """What a command computes: text, printed as it comes, and `values`, which --json prints instead when the command ends."""

    def __init__(self, parsed):
        """Of the parsed arguments, whose files are checked first: DemlawsError where one may not be written."""
        for kind, path in parsed.outputs:
            kind.check(path, getattr(parsed, "overwrite", False))
        places = [os.path.realpath(path) for _, path in parsed.outputs]
        if twice := [place for place in places if places.count(place) > 1 and os.path.basename(place) != "-"]:
            raise DemlawsError(f"two outputs have the name {twice[0]}: the second would replace the first; name another file")
        to_output = [kind for kind, path in parsed.outputs if str(path) == "-"]
        if any(not kind.is_csv for kind in to_output) or len(to_output) > (0 if parsed.json else 1):
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

    def print_wrapped(self, text, rest="    "):
        """Print each line of a text, wrapped; `rest` begins the lines after the first."""
        self.print(*(wrapped(line, rest=rest) for line in text.splitlines()))

    def write_csv(self, path, titles, rows):
        """Write rows to a CSV file and print its name, or to the standard output if the path is "-"; without a path nothing."""
        if path is None:
            return
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


def progress(name):
    """Keyword `progress` of `fit` and `choose`: a bar in a terminal, also in one that states no width."""
    from tqdm import tqdm

    width, lines = shutil.get_terminal_size()
    return functools.partial(tqdm, desc=name, unit="law", leave=False, disable=None, ncols=width - 1, nrows=lines)


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
