"""Files are written whole or not at all, and text is read in whatever encoding it came."""

import contextlib
import csv
import io
import os
import secrets
import sys
import textwrap
from pathlib import Path
from typing import Any

from demlaws.errors import DemlawsError

PARAVIEW = (".vtu", ".vtk")
"""How names of files of contacts as lines end."""


def as_path(path: Any) -> Path:
    """A Path of text or of a Path."""
    try:
        return Path(path)
    except TypeError:
        raise DemlawsError(f"the name of a file must be a str or a Path, got {path!r:.60}") from None


def names_a_file(value: Any) -> bool:
    """Whether a user's word is the path of a file, not the name of a law or of a rule: a Path, or text with a slash or dot."""
    return isinstance(value, os.PathLike) or (isinstance(value, str) and ("/" in value or "." in value))


def read_text(path, what=""):
    """Text of a file that an instrument or a spreadsheet wrote, whatever its encoding; "-" is standard input."""
    try:
        data = sys.stdin.buffer.read() if str(path) == "-" else path.read_bytes()
    except OSError as error:
        raise DemlawsError(f"cannot read {what}{path}: {error.strerror or error}") from error
    try:
        return data.decode("utf-16" if data[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("latin-1")  # older programs' µ; whatever is no text fails as a number


def write_atomically(path, content):
    """Write text or bytes to `path`: first to a temporary name in the same folder, then rename.

    A failure leaves an older file of that name as it was. The folder is made if it is missing.
    """
    target = as_path(path)
    if target.is_symlink():
        target = target.resolve()
    if target.exists() and not target.is_file() and not target.is_dir():
        raise DemlawsError(f"cannot write {target}: it is a device or a pipe, which a file would replace; name a file")
    temporary = target.with_name(f".{target.name[:100]}.{secrets.token_hex(8)}")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        with open(temporary, "xb") as file:
            file.write(content.encode() if isinstance(content, str) else content)
        os.replace(temporary, target)
    except OSError as error:
        with contextlib.suppress(OSError):
            temporary.unlink()
        raise DemlawsError(f"cannot write {target}: {error.strerror or error}; name a folder you may write to") from error
    return as_path(path)


def csv_text(titles, rows):
    """Text of a CSV file; numbers with nine digits."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(titles)
    writer.writerows([[f"{v:.9g}" if isinstance(v, float) else v for v in row] for row in rows])
    return text.getvalue()


def save_csv(path, titles, rows):
    """Write a CSV file; returns its path."""
    return write_atomically(path, csv_text(titles, rows))


WIDTH = 100
"""Characters per line of printed results."""


def wrapped(text, first="", rest="    "):
    """Lines of at most `WIDTH` characters; `rest` begins those after the first."""
    return textwrap.fill(
        text, WIDTH, initial_indent=first, subsequent_indent=rest, break_long_words=False, break_on_hyphens=False
    )
