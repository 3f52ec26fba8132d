"""Files are written whole or not at all."""

import os
import tempfile
from pathlib import Path
from typing import Any

from demlaws.errors import DemlawsError


def as_path(path: Any) -> Path:
    """A Path of text or of a Path."""
    try:
        return Path(path)
    except TypeError:
        raise DemlawsError(f"the name of a file must be text or a Path, got {path!r:.60}") from None


def write_atomically(path, content):
    """Write text or bytes to `path`: first to a temporary name in the same folder, then rename.

    A failure leaves an older file of that name as it was. The folder is made if it is missing.
    """
    path = as_path(path)
    data = content.encode() if isinstance(content, str) else content
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        descriptor, temporary = tempfile.mkstemp(prefix=f".{path.name}.", dir=path.parent)
    except OSError as error:
        raise DemlawsError(f"cannot write {path}: {error.strerror or error}; name a folder you may write to") from error
    try:
        with os.fdopen(descriptor, "wb") as file:
            file.write(data)
        umask = os.umask(0)
        os.umask(umask)
        os.chmod(temporary, 0o666 & ~umask)
        os.replace(temporary, path)
    except OSError as error:
        os.unlink(temporary)
        raise DemlawsError(f"cannot write {path}: {error.strerror or error}; name a folder you may write to") from error
    return path
