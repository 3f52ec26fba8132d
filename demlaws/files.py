"""Files are written whole or not at all, and text is read in whatever encoding it came."""

import contextlib
import csv
import errno
import io
import os
import secrets
import shutil
import sys
import textwrap
from pathlib import Path
from typing import Any

from demlaws.errors import DemlawsError

PARAVIEW = (".vtu", ".vtk")
"""How names of files of contacts as lines end."""
PARAVIEW_MARK = b"demlaws contacts"
"""Text in the head of such a file."""


LONGEST_NAME = 4096
"""Characters of a path that Linux accepts."""


def as_path(path: Any) -> Path:
    """A Path of text or of a Path; DemlawsError for what no file can be called."""
    try:
        text = os.fspath(path)
        if isinstance(text, bytes):
            raise TypeError
    except TypeError:
        raise DemlawsError(f"the name of a file must be a str or a Path, got {path!r:.60}") from None
    if not text or "\0" in text or len(text) > LONGEST_NAME:
        raise DemlawsError(f"no file can be called {text!r:.60}: the name is empty, too long, or contains a NUL character")
    return Path(text)


def names_a_file(value: Any) -> bool:
    """Whether a user's word is the path of a file, not the name of a law or of a rule: a Path, or text with a slash or dot."""
    return isinstance(value, os.PathLike) or (isinstance(value, str) and ("/" in value or "." in value))


def read_text(path, what=""):
    """Text of a file that an instrument or a spreadsheet wrote, whatever its encoding; "-" is standard input."""
    data = sys.stdin.buffer.read() if str(path) == "-" else read_bytes(path, what, pipes=True)
    try:
        return data.decode("utf-16" if data[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("latin-1")  # older programs' µ; whatever is no text fails as a number


def read_bytes(path, what="", pipes=False):
    """Content of a file; pipes: also of a pipe, which may wait for another program."""
    path = as_path(path)
    try:
        if path.exists() and not (path.is_file() or path.is_dir() or pipes):
            raise DemlawsError(f"cannot read {what}{path}: not a regular file")
        return path.read_bytes()
    except OSError as error:
        raise DemlawsError(f"cannot read {what}{path!s:.300}: {error.strerror or error}") from error


def write_atomically(path, content):
    """Write text or bytes to `path`: first to a temporary name in the same folder, then rename.

    A failure leaves an older file of that name as it was. The folder is made if it is missing. A file that is replaced keeps
    its mode, access list and, where this process may set them, its owner and group.
    """
    target = as_path(path)
    temporary = None
    try:
        if target.is_symlink():
            target = target.resolve()
        if target.is_dir():
            raise IsADirectoryError(errno.EISDIR, "it is a folder")
        if target.exists() and not target.is_file():
            raise DemlawsError(f"cannot write {target}: not a regular file; name a file")
        if target.exists() and not os.stat(target).st_mode & 0o222:
            raise DemlawsError(f"cannot write {target}: the file is read-only; name another file, or change its mode (chmod)")
        target.parent.mkdir(parents=True, exist_ok=True)
        temporary = target.with_name(f".{target.name[:100]}.{secrets.token_hex(8)}")
        with open(temporary, "xb") as file:
            if target.exists():
                _copy_rights(target, temporary)
            file.write(content.encode() if isinstance(content, str) else content)
        os.replace(temporary, target)
    except OSError as error:
        if temporary is not None:
            with contextlib.suppress(OSError):
                temporary.unlink()
        reason = error.strerror or error
        raise DemlawsError(f"cannot write {target!s:.300}: {reason}; name a file in a folder you may write to") from error
    return as_path(path)


def _copy_rights(old, new):
    """Give the file `new` the mode and the access list of `old`, and its owner and group if this process may."""
    status = os.stat(old)
    for owner in ({"user": status.st_uid}, {"group": status.st_gid}):
        with contextlib.suppress(PermissionError):
            shutil.chown(new, **owner)
    shutil.copystat(old, new)
    if os.stat(new).st_gid != status.st_gid:  # the rights of the group are those of others: they are not for another group
        os.chmod(new, status.st_mode & 0o707 | (status.st_mode & 0o007) << 3)


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
