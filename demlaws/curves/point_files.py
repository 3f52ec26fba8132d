"""Measured points of a contact test: displacement and force, read from text files of test machines and spreadsheets."""

import contextlib
import os
import re
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np

from demlaws.errors import DemlawsError, warn
from demlaws.files import read_text
from demlaws.surfaces.cells import decimal_mark, is_missing, is_number, separator, split, value_of
from demlaws.units import LARGEST_OVERLAP, UNITS, plain_unit, unmasked

UNLOADED = 0.02
"""Part of the largest force so far by which the force must fall to count as unloading, rather than as noise."""
MOST_NEGATIVE = 0.9
"""Part of the forces in tension, from the first to the last of them, from which on they are a pull, not noise about 0."""
FEWEST_POINTS = 3  # rows of a file that are a test
NOISE_WIDTHS = 3.0  # standard deviations of the load cell below which a force may be no contact


class Points(NamedTuple):
    """Measured points of one test, SI, in the order of the test."""

    displacement: np.ndarray
    force: np.ndarray
    source: str

    def loading_mask(self):
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
    "displacement": (("displacement", "disp", "overlap", "depth", "penetration", "extension"), UNITS["m"]),
    "force": (("force", "load"), UNITS["N"]),
}
_NOT_VALUES = ("increment", "error", "uncertainty", "deviation")
"""Words of titles whose column has the unit of a displacement or a force and is none."""
_OTHER_UNITS = {"s", "ms", "min", "h", "%", "1", "V", "mV"}
_ENDS = " \t_./,:;-\"'"
"""What stands between the words of a title."""
_POWER = re.compile(r"10\s*(?:\^|\*\*|[⁰¹²³⁴-⁹⁻])|\de[-+]?\d", re.IGNORECASE)
_COMMENTS = ("#", "%", "//")


def _is_unit(word):
    return plain_unit(word) in _OTHER_UNITS.union(*UNITS.values())


def _name_and_unit(title):
    """Words of a title without its unit, in lower case, and the unit as written: that in the last brackets, or the last word.

    Read as "displacement" and "um" are "Displacement (µm)", "Displacement/µm", "Displacement (um) - 1", "displacement_um_"
    and "Displacement..um."; "strain mm/mm" has the unit "mm/mm".
    """
    text = re.sub(r"(?<=[\s_.)\]-])\d+$", "", title.strip(_ENDS)).strip(_ENDS)
    brackets = re.search(r"[(\[]\s*([^()\[\]]*?)\s*[)\]]?$", text)
    before, unit = (text[: brackets.start()], brackets[1]) if brackets else re.search(r"(.*?)([^\s_.,:/]*)$", text).groups()
    left = re.search(r"([^\s_.,:/()\[\]]+)[)\]]?\s*/\s*$", before)
    if left and _is_unit(left[1]):
        before, unit = before[: left.start()], f"{left[1]}/{unit}"
    elif not brackets and not _is_unit(unit):
        before, unit = text, ""
    return before.strip(_ENDS).lower(), unit


def _unit(title, column, where):
    """Factor to SI of a title's unit, as written; another spelling only where it can mean nothing else."""
    units, unit = _COLUMNS[column][1], plain_unit(_name_and_unit(title)[1])
    similar = [unit] if unit in units else [name for name in units if name.lower() == unit.lower()]
    if len(similar) == 1 and not _POWER.search(title):
        return units[similar[0]]
    if len(similar) > 1:
        raise DemlawsError(f"{where}: the unit {unit!r} in {title.strip()!r} may be {' or '.join(similar)}: write which")
    raise DemlawsError(
        f"{where}: no unit of {column} in the column title {title.strip()!r}: write 'displacement (um)' or 'force (N)'; "
        f"the units are {', '.join(units)}"
    )


def _find(titles, column):
    """Places of the titles that name the column; a title without further words ("force (N)") stands for all."""
    words = _COLUMNS[column][0]
    values = [i for i, title in enumerate(titles) if not any(word in title.lower() for word in _NOT_VALUES)]
    matches = [i for i in values if any(word in titles[i].lower() for word in words)]
    alone = [i for i in matches if _name_and_unit(titles[i])[0] in words]
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
    return sum(map(is_number, cells)) > max(1, len(cells) // 2)


class _Table(NamedTuple):
    """A table in a file: its titles, and the lines below them up to the next titles."""

    line: int  # of the titles, from 1
    titles: list
    mark: str | None
    first: int  # index of the first line below the titles and their units
    end: int


def _uncommented(line):
    """A line without the mark of a comment, and whether it is one: numpy.savetxt writes its titles into one."""
    text = line.strip()
    mark = next((mark for mark in _COMMENTS if text.startswith(mark)), None)
    if mark is None or is_missing(split(text, separator(text))[0]):  # "#N/A" of a spreadsheet
        return text, False
    return text.removeprefix(mark).strip(), True


def _tables(lines):
    """The tables of a file, each from a line that names both columns; words of an instrument may precede the titles."""
    found, rows = [], 0
    for number, line in enumerate(lines):
        text, comment = _uncommented(line)
        mark = separator(text)
        titles = split(text, mark)
        named = len(titles) > 1 and all(_find(titles, column) for column in _COLUMNS)
        if not named or (comment and rows):  # a comment between rows has words, not titles
            rows += not comment and bool(found) and _is_row(titles)
            continue
        rows, first = 0, number + 1
        below = [cell.strip(" ()[]") for cell in split(lines[first], mark)] if len(lines) > first else []
        if any(plain_unit(cell) in units for cell in below for _, units in _COLUMNS.values()):  # a line of units
            titles = [f"{title} ({cell})" for title, cell in zip(titles, below, strict=False)]
            first += 1
        found = [
            *(one._replace(end=min(one.end, number)) for one in found),
            _Table(number + 1, titles, mark, first, len(lines)),
        ]
    return found


def _header(lines, path):
    """The table of the points: the only one with rows of numbers, or the only one with three."""
    tables = _tables(lines)
    counts = [sum(_is_row(split(line, one.mark)) for line in lines[one.first : one.end]) for one in tables]
    if sum(count >= FEWEST_POINTS for count in counts) > 1:
        several = " and ".join(str(one.line) for one, count in zip(tables, counts, strict=True) if count >= FEWEST_POINTS)
        raise DemlawsError(f"{path} has several tables of points, with titles in lines {several}: keep one")
    if tables:
        return tables[int(np.argmax(counts))]
    need = "two columns named displacement and force are needed, with units, separated by commas, semicolons or tabs"
    for number, line in enumerate(lines, 1):
        if _is_row(split(line, separator(line))):
            above = next((text.strip() for text in reversed(lines[: number - 1]) if text.strip()), "no line")
            raise DemlawsError(f"{path}, line {number}: {need}; above the first numbers: {above[:60]!r}")
    text = next((line.strip() for line in lines if line.strip()), "")
    raise DemlawsError(f"{path}: {need}; the file has no row of numbers and begins with {text[:60]!r}")


def _rows(lines, table, places, path):
    """(line, all cells, those of displacement and force) of a table. Words may follow its last row; empty rows are left out."""
    rows, end = [], None
    for number, line in enumerate(lines[table.first : table.end], table.first + 1):
        text, comment = _uncommented(line)
        cells = split(text, table.mark) if text and not comment else []
        filled = [cell for cell in cells if not is_missing(cell)]
        if not filled:
            continue
        where = f"{path}, line {number}"
        pair = [cells[place] if place < len(cells) else "absent" for place in places]
        if not all(is_number(cell) or is_missing(cell) for cell in pair):
            is_text = bool(rows) and re.search(r"[^\W\d_]{2}", filled[0]) is not None
            end = end or (where, text, is_text)
            continue
        if any(cell.strip() for cell in cells[len(table.titles) :]):
            remedy = "split columns by ; if commas are decimal"
            raise DemlawsError(f"{where}: {len(cells)} columns, but the header has {len(table.titles)}; {remedy}")
        if end is not None:
            break
        rows.append((where, cells, pair))
    else:
        if end is None or end[2]:
            return rows
    raise DemlawsError(f"{end[0]}: two numbers are needed, got {end[1][:60]!r}")


def read_points(path):
    """Measured points from a text file: a line of titles with units, then numbers.

    Columns are split by commas, semicolons, tabs or blanks; decimal commas are read where the file decides that they are,
    numbers with thousands separators are refused. Lines that begin with #, % or // are comments (the titles may be in one).
    Words before the titles and after the last row, results of one or two rows, empty rows and further columns are left aside;
    rows at the end that lack one of the two values are left out with a warning. Of several columns that may be the force or
    the displacement the one named so alone is taken. A line below the titles may contain the units. "-" is standard input.
    Raises DemlawsError that names the file and the line.
    """
    path = Path(path)
    text = read_text(path, "points ")
    if "\0" in text:
        raise DemlawsError(f"{path} is not a text file: export the table as text, with tabs or as CSV")
    lines = text.splitlines()
    table = _header(lines, path)
    columns = {column: _place(table.titles, column, f"{path}, line {table.line}") for column in _COLUMNS}
    rows = _rows(lines, table, [place for place, _ in columns.values()], path)
    mark, values = decimal_mark([cell for _, cells, _ in rows for cell in cells], path), []
    for where, _, pair in rows:
        try:
            values.append([value_of(cell, mark) * unit for cell, (_, unit) in zip(pair, columns.values(), strict=True)])
        except ValueError:
            raise DemlawsError(f"{where}: two numbers are needed, got {' and '.join(pair)[:60]!r}") from None
    displacement, force = _without_tail(np.array(values).reshape(-1, 2), rows, path).T
    return Points(displacement, force, "standard input" if str(path) == "-" else path.name)


def _without_tail(values, rows, path):
    """Values without the rows at the end that lack one of the two: a sensor that was off, or columns of unequal length."""
    whole = ~np.isnan(values).any(axis=1)
    end = int(np.max(np.flatnonzero(whole), initial=-1)) + 1
    bad = np.flatnonzero(~np.isfinite(values[:end]).all(axis=1))
    if bad.size:
        where, _, pair = rows[bad[0]]
        raise DemlawsError(f"{where}: {' and '.join(pair)[:60]!r} is not finite")
    if end < FEWEST_POINTS:
        raise DemlawsError(f"{path}: {end} points; at least {FEWEST_POINTS} points are needed")
    if end < len(values):
        warn(f"{path}: the last {len(values) - end} rows lack the displacement or the force and are left out")
    return values[:end]


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
    """Mask of the points in contact, and names and reasons for `Ranking.skipped` if points were left out.

    Negative forces before contact give the noise of the load cell [N], unless it is known; those after the largest force do
    so only where positive ones lie between them, else they are a pull. A single point from before contact, positive by chance,
    tilts the whole fit: below three standard deviations, and on first loading before the last such point, all go.
    """
    peak, negative = int(np.argmax(force)) if force.size else 0, force < 0.0
    later = np.flatnonzero(negative[peak:]) + peak
    source, pull = "given", np.zeros(force.size, bool)
    if later.size and np.mean(negative[later[0] : later[-1] + 1]) > MOST_NEGATIVE:
        pull[later] = True
    if noise == 0.0 and np.sum(negative & ~pull) >= 3:
        noise = float(np.sqrt(np.mean(force[negative & ~pull] ** 2)))
        source = f"from {np.sum(negative & ~pull)} negative forces"
    pull &= force < -NOISE_WIDTHS * noise
    keep = (force > NOISE_WIDTHS * noise) & ~pull
    if noise > 0.0 and np.any(keep):
        first = int(np.argmax(force > 0.1 * np.max(force)))
        keep[: np.max(np.flatnonzero(~keep[:first]), initial=-1) + 1] = False
    reason = "they carry no force: any displacement before contact fits them"
    if noise > 0.0:
        reason = f"they may be no contact: before it or below {NOISE_WIDTHS:g} times the load cell's {noise:.2g} N ({source})"
    skipped = {f"{int(np.sum(~keep & ~pull))} points": reason} if np.any(~keep & ~pull) else {}
    if np.any(pull):
        lowest = float(np.min(force))
        skipped[f"{int(np.sum(pull))} points in tension"] = (
            f"the bodies adhere (to {lowest:.2g} N in unloading): no law of demlaws has adhesion"
        )
    return keep, skipped
