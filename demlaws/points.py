"""Measured points of a contact test: displacement and force, read from text files of test machines and spreadsheets."""

import csv
import math
import re
from pathlib import Path
from typing import NamedTuple

import numpy as np

from demlaws.errors import DemlawsError

UNLOADED = 0.02
"""Part of the largest force so far by which the force must fall to count as unloading, rather than as noise."""


class Points(NamedTuple):
    """Measured points of one test, SI, in the order of the test."""

    displacement: np.ndarray
    force: np.ndarray
    source: str

    def first_loading(self):
        """Which points belong to first loading: those up to the largest force that lie in no loop of unloading and reloading.

        A loop is a row of points below an earlier force, one of them by more than UNLOADED of it (or 0.1 % of the largest
        force of all, where that is more): smaller dips are noise and stay.
        """
        force = self.force
        end = int(np.argmax(force)) + 1
        before = np.maximum.accumulate(force[:end])
        below = force[:end] < before
        keep = np.ones(end, bool)
        edges = np.flatnonzero(np.diff(np.concatenate([[False], below, [False]]).astype(int)))
        for start, stop in zip(edges[::2], edges[1::2], strict=True):
            dip = before[start] - force[start:stop].min()
            keep[start:stop] = dip <= max(UNLOADED * before[start], 1e-3 * force[end - 1])
        return np.concatenate([keep, np.zeros(force.size - end, bool)])

    def loading(self, from_force=0.1):
        """Displacement and force of first loading, from `from_force` [N] on."""
        keep = self.first_loading() & (self.force >= from_force)
        return self.displacement[keep], self.force[keep]

    def zero(self, laws, force=0.1):
        """Displacement [m] that the measurement has at `force` [N] of first loading, and the law that says so, or None.

        Between two points it is interpolated. Points that begin above that force are placed by the law that fits best.
        """
        displacement, measured = self.loading(0.0)
        if measured.size and measured[0] <= force <= measured[-1]:
            after = int(np.argmax(measured >= force))
            near = slice(max(after - 1, 0), after + 1)
            return float(np.interp(force, measured[near], displacement[near])), None
        best = min(laws, key=self.misfit)
        displacement, measured = self.loading(force)
        return float(np.mean(displacement - best.overlap(measured)) + best.overlap(force)), best

    def gain_over(self, bound):
        """Displacement measured between the first and the last load, over the law's."""
        displacement, force = self.loading()
        return float((displacement[-1] - displacement[0]) / (bound.overlap(force[-1]) - bound.overlap(force[0])))

    def misfit(self, bound):
        """Root mean square difference in displacement [m] on first loading, after the best shift of the measured zero."""
        displacement, force = self.loading()
        return float(np.std(displacement - bound.overlap(force)))


_COLUMNS = {
    "displacement": (("displacement", "overlap"), {"m": 1.0, "mm": 1e-3, "um": 1e-6, "nm": 1e-9}),
    "force": (("force", "load"), {"N": 1.0, "mN": 1e-3, "kN": 1e3, "MN": 1e6}),
}
_COMMENTS = ("#", "%", "//")


def _unit(title, column, where):
    """Factor to SI of a title's unit, as written; another spelling only where it can mean nothing else."""
    units = _COLUMNS[column][1]
    match = re.search(r"[(\[_ ]\s*([A-Za-zµμ]+)\s*[)\]]?\s*$", title.strip())
    unit = (match.group(1) if match else "").replace("µ", "u").replace("μ", "u")
    if unit in units:
        return units[unit]
    similar = [known for known in units if known.lower() == unit.lower()]
    if len(similar) == 1:
        return units[similar[0]]
    if similar:
        raise DemlawsError(f"{where}: the unit {unit!r} in {title.strip()!r} can mean {' or '.join(similar)}: write which")
    raise DemlawsError(
        f"{where}: no unit of {column} in the column title {title.strip()!r}: write 'displacement (um)' or 'force (N)'; "
        f"the units are {', '.join(units)}"
    )


def _text(path):
    try:
        data = path.read_bytes()
    except OSError as error:
        raise DemlawsError(f"cannot read points {path}: {error.strerror or error}") from error
    try:
        return data.decode("utf-16" if data[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("latin-1")  # older programs' µ; whatever is no text fails as a number


def _split(line, mark):
    if mark is None:
        return re.split(r"\s+(?![(\[])", line.strip())
    return next(csv.reader([line], delimiter=mark))


def _find(titles, column):
    words = _COLUMNS[column][0]
    return next((i for i, title in enumerate(titles) if any(word in title.lower() for word in words)), None)


def _header(lines, path):
    """Number of the title line, the titles, and the mark between columns."""
    for number, line in enumerate(lines):
        text = line.strip()
        comment = next((mark for mark in _COMMENTS if text.startswith(mark)), None)
        if comment is not None:  # numpy.savetxt writes its titles into one
            text = text.removeprefix(comment).strip()
        if not text:
            continue
        mark = next((m for m in (";", "\t", ",") if m in text), None)
        titles = _split(text, mark)
        if all(_find(titles, column) is not None for column in _COLUMNS) and len(titles) > 1:
            return number, titles, mark
        if comment is None:
            wanted = "two columns named displacement and force are needed, with units, separated by commas, semicolons or tabs"
            raise DemlawsError(f"{path}, line {number + 1}: {wanted}; got {text[:60]!r}")
    raise DemlawsError(f"{path}, line 1: two columns are needed, displacement and force with units; the file holds no titles")


def _number(cell, mark):
    text = cell.strip()
    return float(text.replace(",", ".") if mark != "," and "." not in text else text)


def read_points(path):
    """Measured points from a text file: a line of titles with units, then numbers.

    Columns are split by commas, semicolons, tabs or blanks; unless by commas, decimal commas are read. Lines that begin
    with #, % or // are comments (the titles may stand in one); further columns are left aside. Raises DemlawsError that
    names the file and the line.
    """
    path = Path(path)
    lines = _text(path).splitlines()
    first, titles, mark = _header(lines, path)
    places = {column: _find(titles, column) for column in _COLUMNS}
    units = {column: _unit(titles[place], column, f"{path}, line {first + 1}") for column, place in places.items()}
    values = []
    for number, line in enumerate(lines[first + 1 :], start=first + 2):
        if not line.strip() or line.strip().startswith(_COMMENTS):
            continue
        where = f"{path}, line {number}"
        try:
            row = _split(line, mark)
            pair = [_number(row[place], mark) * units[column] for column, place in places.items()]
        except (ValueError, IndexError, csv.Error):
            raise DemlawsError(f"{where}: two numbers are needed, got {line.strip()[:60]!r}") from None
        if any(cell.strip() for cell in row[len(titles) :]):
            remedy = "split columns by ; if commas are decimal"
            raise DemlawsError(f"{where}: {len(row)} columns, but {len(titles)} titles; {remedy}")
        if not all(map(math.isfinite, pair)):
            raise DemlawsError(f"{where}: {line.strip()[:60]!r} is not finite")
        values.append(pair)
    if len(values) < 3:
        raise DemlawsError(f"{path}: {len(values)} points; at least 3 are needed")
    displacement, force = np.array(values).T
    return Points(displacement, force, path.name)
