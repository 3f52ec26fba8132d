"""Engines as processes of their own."""

import os
import re
import subprocess
from pathlib import Path

from demlaws.errors import DemlawsError


def cache_folder():
    """Where plugins are kept: $DEMLAWS_CACHE, else $XDG_CACHE_HOME/demlaws, else ~/.cache/demlaws; always an absolute path."""
    named = os.environ.get("DEMLAWS_CACHE")
    if named:
        return Path(named).absolute()  # an engine is started in the input's folder
    try:
        return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache").absolute() / "demlaws"
    except RuntimeError:  # neither HOME nor an entry of the user's, as in containers
        raise DemlawsError("this user has no home folder for what is built once and kept: set DEMLAWS_CACHE or HOME") from None


def output(command, folder, environment, echo=False, timeout=None):
    """(exit status, lines of output) of a command in `folder`; echo: shown as they come. What stops us stops it, too."""
    lines = []
    with subprocess.Popen(
        command, cwd=folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace"
    ) as process:
        try:
            if echo:
                for text in process.stdout:
                    print(text, end="", flush=True)
                    lines.append(text)
                process.wait()
            else:
                lines = process.communicate(timeout=timeout)[0].splitlines(keepends=True)
        except BaseException:
            process.kill()
            raise
    return process.returncode, lines


def log_lines(path):
    """Lines of an engine's log."""
    try:
        return Path(path).read_text(errors="replace").splitlines()
    except OSError as error:
        raise DemlawsError(f"cannot read {path}: {error.strerror}") from error


def thermo_of_log(path, begins, column=str):
    """`thermo` of a log, in which there must be some."""
    found = thermo(log_lines(path), begins, column)
    if not found:
        raise DemlawsError(f"{path} holds no thermo output")
    return found


_MULTI = re.compile(r"-+ Step\s+(\S+) -+ CPU =\s+(\S+)")
_VALUE = re.compile(r"(\S+)\s*=\s*([-+]?\d\S*)")


def _numbers(words):
    try:
        return [float(word) for word in words]
    except ValueError:
        return None


def thermo(lines, begins, column=str):
    """Columns of all thermo tables of LIGGGHTS or LAMMPS: dict name → array; empty where there are none.

    A table stands between a line that begins with `begins` and the line "Loop time" of a run; its first line names the
    columns, which may be numbers themselves (LIGGGHTS heads c_1 by 1); column: from such a word to the name of the column.
    `thermo_style multi` prints a paragraph a row, `yaml` of LAMMPS lists. Rows that a run repeats (its first step is the last
    one of the run before) are kept once; where the columns change, only the rows after the last change are returned.
    """
    import numpy as np

    names, rows = [], []

    def put(words, row):
        nonlocal names, rows
        found = [column(word) for word in words]
        if found != names:
            names, rows = found, []
        step = found.index("Step") if "Step" in found else None
        if step is None or not rows or row[step] > rows[-1][step]:
            rows.append(row)

    header, multi = None, None  # header: None outside a table, [] where its line comes next
    for line in lines:
        words = line.split()
        start = _MULTI.match(line)
        if line.startswith(begins):
            header = []
        elif start or line.startswith("Loop time"):
            if multi:
                put(list(multi), list(multi.values()))
            multi = {"Step": float(start[1]), "CPU": float(start[2])} if start else None
            if not start:
                header = None
        elif multi is not None:
            multi.update((name, float(value)) for name, value in _VALUE.findall(line) if _numbers([value]))
        elif header == []:
            if words[:1] == ["keywords:"]:
                header = re.findall(r"'([^']*)'", line)
            elif words and words[0] not in ("---", "WARNING:"):
                header = words
        elif header:
            listed = line.strip()
            if listed.startswith("- ["):
                words = listed[3:].rstrip("], ").split(",")
            row = _numbers(words) if len(words) == len(header) else None
            if row:
                put(header, row)
    return dict(zip(names, np.array(rows).T, strict=True)) if rows else {}
