"""Measured points of a contact test: displacement and force, read from text files of test machines and spreadsheets."""

import contextlib
import csv
import math
import os
import re
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np

from demlaws.errors import DemlawsError
from demlaws.files import read_text
from demlaws.units import LARGEST_OVERLAP, UNITS, unmasked

UNLOADED = 0.02
"""Part of the largest force so far by which the force must fall to count as unloading, rather than as noise."""
NOISE_WIDTHS = 3.0  # standard deviations of the load cell below which a force may be no contact


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


_COLUMNS = {
    "displacement": (("displacement", "disp.", "overlap", "depth", "penetration", "extension"), UNITS["m"]),
    "force": (("force", "load"), UNITS["N"]),
}
_UNIT = re.compile(r"(?:[(\[]\s*([A-Za-zµμ]+)\s*[)\]]?|[_ /]\s*([A-Za-zµμ]+))\s*$")
"""The unit at the end of a title."""
_THOUSANDS = re.compile(r"[-+]?\d{1,3},\d{3}$")
_COMMENTS = ("#", "%", "//")


def _plain(unit):
    return unit.replace("µ", "u").replace("μ", "u")


def _unit(title, column, where):
    """Factor to SI of a title's unit, as written; another spelling only where it can mean nothing else."""
    units = _COLUMNS[column][1]
    match = _UNIT.search(title.strip())
    unit = _plain((match[1] or match[2]) if match else "")
    if unit in units:
        return units[unit]
    similar = [name for name in units if name.lower() == unit.lower()]
    if len(similar) == 1:
        return units[similar[0]]
    if similar:
        raise DemlawsError(f"{where}: the unit {unit!r} in {title.strip()!r} may be {' or '.join(similar)}: write which")
    raise DemlawsError(
        f"{where}: no unit of {column} in the column title {title.strip()!r}: write 'displacement (um)' or 'force (N)'; "
        f"the units are {', '.join(units)}"
    )


def _split(line, mark):
    if mark is None:
        return re.split(r"\s+(?![(\[])", line.strip())
    return next(csv.reader([line], delimiter=mark))


def _find(titles, column):
    """Places of the titles that name the column; a title without further words ("force (N)") stands for all."""
    words = _COLUMNS[column][0]
    matches = [i for i, title in enumerate(titles) if any(word in title.lower() for word in words)]
    alone = [i for i in matches if _UNIT.sub("", titles[i].strip()).strip(' /"').lower() in words]
    return alone or matches


def _place(titles, column, where):
    """Place and factor to SI of a column."""
    places, units = _find(titles, column), {}
    for place in places:
        with contextlib.suppress(DemlawsError):  # a rate, or a time under load
            units[place] = _unit(titles[place], column, where)
    if len(units) == 1:
        return next(iter(units.items()))
    if not units:
        return places[0], _unit(titles[places[0]], column, where)
    several = " and ".join(repr(titles[place].strip()) for place in units)
    raise DemlawsError(f"{where}: {several} may be the {column}: remove all but one, or name it {column!r} with its unit alone")


def _is_row(cells):
    """Whether a line is one of numbers, two at least: measured values, not the words or the date of an instrument."""
    numbers = 0
    for cell in cells:
        with contextlib.suppress(ValueError):
            float(cell.strip().replace(",", "."))
            numbers += 1
    return numbers > max(1, len(cells) // 2)


def _header(lines, path):
    """Number of the title line, the titles, and the mark between columns. Lines of an instrument may precede it: a date, the
    number of points, a sample's name."""
    first = None
    for number, line in enumerate(lines):
        text = line.strip()
        comment = next((mark for mark in _COMMENTS if text.startswith(mark)), None)
        if comment is not None:  # numpy.savetxt writes its titles into one
            text = text.removeprefix(comment).strip()
        if not text:
            continue
        mark = next((m for m in (";", "\t", ",") if m in text), None)
        titles = _split(text, mark)
        if all(_find(titles, column) for column in _COLUMNS) and len(titles) > 1:
            below = [cell.strip(" ()[]") for cell in _split(lines[number + 1], mark)] if len(lines) > number + 1 else []
            if any(_plain(cell) in units for cell in below for _, units in _COLUMNS.values()):  # a line of units
                titles = [f"{title} ({cell})" for title, cell in zip(titles, below, strict=False)]
                number += 1
            return number, titles, mark
        if comment is None:
            first = first or (number + 1, text)
            if _is_row(titles):
                break
    if first is not None:
        need = "two columns named displacement and force are needed, with units, separated by commas, semicolons or tabs"
        raise DemlawsError(f"{path}, line {first[0]}: {need}; got {first[1][:60]!r}")
    raise DemlawsError(f"{path}, line 1: two columns are needed, displacement and force with units; the file has no header")


def _number(cell, mark):
    text = cell.strip()
    return float(text.replace(",", ".") if mark != "," and "." not in text else text)


def read_points(path):
    """Measured points from a text file: a line of titles with units, then numbers.

    Columns are split by commas, semicolons, tabs or blanks; unless by commas, decimal commas are read. Lines that begin
    with #, % or // are comments (the titles may be in one). Lines of words before the titles and further columns are left
    aside. Of several that may be the
    force or the displacement the one named so alone is taken. A line below the titles may contain the units. "-" is
    standard input. Raises DemlawsError that names the file and the line.
    """
    path = Path(path)
    text = read_text(path, "points ")
    if "\0" in text:
        raise DemlawsError(f"{path} is not a text file: export the table as text, with tabs or as CSV")
    lines = text.splitlines()
    first, titles, mark = _header(lines, path)
    columns = {column: _place(titles, column, f"{path}, line {first + 1}") for column in _COLUMNS}
    values, marks = [], set()
    for number, line in enumerate(lines[first + 1 :], start=first + 2):
        if not line.strip() or line.strip().startswith(_COMMENTS):
            continue
        where = f"{path}, line {number}"
        try:
            row = _split(line, mark)
            pair = [_number(row[place], mark) * unit for place, unit in columns.values()]
        except (ValueError, IndexError, csv.Error):
            raise DemlawsError(f"{where}: two numbers are needed, got {line.strip()[:60]!r}") from None
        if any(cell.strip() for cell in row[len(titles) :]):
            remedy = "split columns by ; if commas are decimal"
            raise DemlawsError(f"{where}: {len(row)} columns, but the header has {len(titles)}; {remedy}")
        marks.update(
            "." if "." in row[k] else "," for k, _ in columns.values() if "." in row[k] or _THOUSANDS.match(row[k].strip())
        )
        if len(marks) > 1:
            raise DemlawsError(f"{where}: {line.strip()[:60]!r}: is , before thousands and . before decimals? Leave the , out")
        if not all(map(math.isfinite, pair)):
            raise DemlawsError(f"{where}: {line.strip()[:60]!r} is not finite")
        values.append(pair)
    if len(values) < 3:
        raise DemlawsError(f"{path}: {len(values)} points; at least 3 points are needed")
    displacement, force = np.array(values).T
    return Points(displacement, force, "standard input" if str(path) == "-" else path.name)


# --- points of a contact that a law is to follow


def columns_of(points):
    """Displacement [m] and force [N] of `Points`, of a file, of (n, 2) values, or of a table with titles: a DataFrame, a
    structured array, a dict. Titles are read as those of files ("Depth (nm)"); "displacement" and "force" alone are in SI."""
    if isinstance(points, str | os.PathLike):
        points = read_points(points)
    if hasattr(points, "displacement"):
        points = np.column_stack([unmasked(points.displacement), unmasked(points.force)])
    titles = getattr(getattr(points, "dtype", None), "names", None) or getattr(points, "columns", None)
    titles = list(points) if isinstance(points, Mapping) else [] if titles is None or callable(titles) else list(titles)
    if titles and all(isinstance(title, str) for title in titles):
        points = _titled(points, titles)
    try:
        array = np.asarray(unmasked(points), dtype=float)
    except (TypeError, ValueError):
        raise DemlawsError("points must be numbers: an array of shape (n, 2), displacement in m and force in N") from None
    if array.ndim != 2 or array.shape[1] != 2:
        raise DemlawsError(f"points have shape {array.shape}: give (n, 2), displacement in m and force in N")
    if not np.all(np.isfinite(array)):
        raise DemlawsError("points contain NaN or infinite values: remove those rows")
    return array.T


def _titled(points, titles):
    """Columns of displacement [m] and force [N], found by their titles."""
    columns = []
    for column, (words, _) in _COLUMNS.items():
        if not _find(titles, column):
            raise DemlawsError(f"points have the columns {', '.join(titles)}: name one {column!r} or '{column} (unit)'")
        bare = [place for place, title in enumerate(titles) if title.strip().lower() in words]
        place, unit = (bare[0], 1.0) if len(bare) == 1 else _place(titles, column, "points")
        try:
            columns.append(unit * np.asarray(unmasked(points[titles[place]]), float))
        except (TypeError, ValueError):
            raise DemlawsError(f"points: the column {titles[place]!r} must be numbers") from None
    if columns[0].shape != columns[1].shape:
        raise DemlawsError(f"points: {columns[0].size} displacements and {columns[1].size} forces: give one force for each")
    return np.column_stack(columns)


def refuse_other_units(displacement, force, contact, compliance):
    """Refuse points in contact that no law can follow: in other units, with exchanged columns or the other sign.

    compliance: the largest of the apparatus [m/N]."""
    travel, most = np.ptp(displacement), LARGEST_OVERLAP * contact.radius + compliance * np.ptp(force)
    if travel > most:
        raise DemlawsError(
            f"points in contact lie {travel:.3g} m apart, more than the effective radius R = {contact.radius:g} m, beyond "
            "which laws are undefined: give displacement in m, first, and force in N, without points from before contact"
        )
    if travel > 0.0 and np.ptp(force) > 0.0 and np.corrcoef(displacement, force)[0, 1] < -0.5:
        raise DemlawsError("the displacement falls where the force rises: count the approach of the bodies as positive, in m")


def in_contact(force, noise):
    """Mask of the points in contact, and name and reason for `Ranking.skipped` if points were left out.

    Negative forces give the noise of the load cell [N], unless it is known. A single point from before contact, positive by
    chance, tilts the whole fit: below three standard deviations, and on first loading before the last such point, all go.
    """
    negative = force[force < 0.0]
    source = "given" if noise > 0.0 else f"from {negative.size} negative forces"
    if noise == 0.0 and negative.size >= 3:
        noise = float(np.sqrt(np.mean(negative**2)))
    keep = force > NOISE_WIDTHS * noise
    if noise > 0.0 and np.any(keep):
        first = int(np.argmax(force > 0.1 * np.max(force)))
        keep[: np.max(np.flatnonzero(~keep[:first]), initial=-1) + 1] = False
    reason = "they carry no force: any displacement before contact fits them"
    if noise > 0.0:
        reason = f"they may be no contact: before it or below {NOISE_WIDTHS:g} times the load cell's {noise:.2g} N ({source})"
    return keep, {} if np.all(keep) else {f"{int(np.sum(~keep))} points": reason}
