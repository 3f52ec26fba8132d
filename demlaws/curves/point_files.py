"""Measured points of a contact test: displacement and force, read from text files of test machines and spreadsheets."""

import math
import os
import re
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from demlaws.errors import DemlawsError, counted
from demlaws.files import as_path, read_text
from demlaws.surfaces.cells import decimal_mark, is_missing, is_number, separator, split, value_of
from demlaws.units import LARGEST_OVERLAP, UNITS, plain_unit, unmasked

UNLOADED = 0.02
"""Part of the largest force so far by which the force must fall to count as unloading, rather than as noise."""
MOST_NEGATIVE = 0.9
"""Share of negative forces, between the first and the last of them, from which on they count as adhesion, not as noise."""
FEWEST_POINTS = 3  # rows of a file that are a test
FEWEST_HELD = 5  # rows at constant force that are a hold
_SLOWER = 3.0  # times as many rows as elsewhere within the same range of force, from which on they are a hold
_HELD_NOISE, _HELD_WIDTH = 8.0, 2e-3  # range of the forces of a hold: standard deviations of the load cell, part of the force
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
    "displacement": (("displacement", "disp", "overlap", "depth", "penetration", "extension", "stroke"), UNITS["m"]),
    "force": (("force", "load"), UNITS["N"]),
}
_NOT_VALUES = ("increment", "error", "uncertainty", "deviation")
"""Title words that exclude a column, though its unit fits."""
_BRACKETS = re.compile(r"[(\[]([^()\[\]]*)[)\]]")
LARGEST = 1e12
"""Forces [N] and displacements [m] beyond which a value is no measurement."""
_POWER = re.compile(r"10\s*(?:\^|\*\*|[⁰¹²³⁴-⁹⁻])|\de[-+]?\d", re.IGNORECASE)
_NEED = "two columns titled 'displacement (um)' and 'force (N)' are needed, separated by commas, semicolons or tabs"


def _unit(title):
    """The unit of a title: in brackets, after a slash, or after an underscore: "Depth (nm)", "Depth / nm", "depth_nm"."""
    match = _BRACKETS.search(title)
    if match:
        return plain_unit(match[1].strip())
    text = title.strip(' "')
    _, slash, after = text.rpartition("/")
    if slash:
        return plain_unit(after.strip())
    return plain_unit(re.sub("(?i)_micro_", "_u", text).rsplit("_", 1)[1]) if "_" in text else ""


def _find(titles, column):
    """Places of the titles that name the column; a title without further words ("force (N)") stands for all."""
    words = _COLUMNS[column][0]
    values = [i for i, title in enumerate(titles) if not any(word in title.lower() for word in _NOT_VALUES)]
    matches = [i for i in values if any(word in titles[i].lower() for word in words)]
    alone = [i for i in matches if re.split(r"[(\[/]", titles[i])[0].strip(' "').lower() in words]
    return alone or matches


def _place(titles, column, where):
    """Place and factor to SI of a column, whose title has its unit in brackets; a rate, or a time under load, is none."""
    units, found = _COLUMNS[column][1], {}
    for place in _find(titles, column):
        unit = _unit(titles[place])
        if unit in units and not _POWER.search(titles[place]):
            found[place] = units[unit]
    if len(found) == 1:
        return next(iter(found.items()))
    named = " and ".join(repr(titles[place].strip()) for place in found or _find(titles, column))
    if found:
        raise DemlawsError(
            f"{where}: {named} may be the {column}: remove all but one, or name it {column!r} with its unit alone"
        )
    raise DemlawsError(
        f"{where}: no unit of {column} in the title {named}: write 'displacement (um)' or 'force (N)'; the units are "
        f"{', '.join(units)}"
    )


def _is_row(cells):
    """Whether a line is one of numbers, two at least: measured values, not the words or the date of an instrument."""
    return is_number(cells[0]) and sum(map(is_number, cells)) > max(1, len(cells) // 2)


def _with_units(titles, below):
    """Titles with the units of the line below them, if it is one of units."""
    cells = [cell.strip(" ()[]") for cell in below]
    if any(plain_unit(cell) in units for cell in cells for _, units in _COLUMNS.values()):
        return [f"{title} ({cell})" for title, cell in zip(titles, cells, strict=False)]
    return titles


def _table(lines, path):
    """Number and titles of the last line that names both columns, with (number, cells) of the lines below it.

    Comments begin with #, % or //; the titles may be in one (numpy.savetxt), where no row precedes it.
    """
    titles, title_line, rows, delimiter, untitled = [], 0, [], None, []
    for number, line in enumerate(lines, 1):
        text = line.strip().lstrip("#%/ ")
        cells = split(text, separator(text))
        comment = line.strip().startswith(("#", "%", "//")) and not is_missing(split(line, separator(line))[0])  # no "#N/A"
        if len(cells) > 1 and all(_find(cells, column) for column in _COLUMNS) and not (comment and rows):
            if sum(_is_row(row) for _, row in rows) >= FEWEST_POINTS:
                raise DemlawsError(
                    f"{path} has several tables of points, with titles in lines {title_line} and {number}: keep one"
                )
            titles, title_line, rows, delimiter = cells, number, [], separator(text)
        elif not titles and not comment and _is_row(cells):
            untitled.append(number)
            if len(untitled) == FEWEST_POINTS:  # fewer are a summary of the test
                above = " ".join(lines[: untitled[0] - 1])[-60:]
                raise DemlawsError(f"{path}, line {untitled[0]}: {_NEED}; above the first numbers: {above!r}")
        elif titles and not comment:
            rows.append((number, split(line.strip(), delimiter)))
    if not rows:
        raise DemlawsError(f"{path}: {_NEED}; the file begins with {' '.join(lines)[:60]!r}")
    with_units = _with_units(titles, rows[0][1])
    return title_line, with_units, rows if with_units is titles else rows[1:]


def read_points(path):
    """Measured points from a text file: a line of titles with units in brackets, then rows of numbers.

    Columns are split by commas, semicolons, tabs or blanks; decimal commas are read where the file decides that they are,
    numbers with thousands separators are refused. Words before the titles, rows without any value, comments and further columns
    are left aside. Of several columns that may be the force or the displacement the one named so alone is taken. A line below
    the titles may contain the units. "-" is standard input. Raises DemlawsError that names the file and the line.
    """
    path = as_path(path)
    text = read_text(path, "points ")
    if "\0" in text:
        raise DemlawsError(f"{path} is not a text file: export the table as text, with tabs or as CSV")
    line, titles, rows = _table(text.splitlines(), path)
    columns = [_place(titles, column, f"{path}, line {line}") for column in _COLUMNS]
    rows = [(number, cells) for number, cells in rows if not all(map(is_missing, cells))]
    mark, values = decimal_mark([cell for _, cells in rows for cell in cells], path), []
    for number, cells in rows:
        try:
            values.append([value_of(cells[place], mark) * unit for place, unit in columns])
        except (ValueError, IndexError):
            values.append([math.nan, math.nan])
        if not np.isfinite(values[-1]).all() or any(cell.strip() for cell in cells[len(titles) :]):
            raise DemlawsError(
                f"{path}, line {number}: two finite numbers in {len(titles)} columns are needed, got {' '.join(cells)[:60]!r}: "
                "remove the line, or split columns by ; if commas are decimal"
            )
    if len(values) < FEWEST_POINTS:
        raise DemlawsError(f"{path}: {len(values)} points; at least {FEWEST_POINTS} points are needed")
    return Points(*np.array(values).T, "standard input" if str(path) == "-" else path.name)


# --- points of a contact that a law is to follow


def columns_of(points):
    """Displacement [m] and force [N] of `Points`, of a file, of (n, 2) values, or of a table with titles: a DataFrame, a
    dict. Titles are read as those of files ("Depth (nm)"); "displacement" and "force" alone are in SI."""
    if isinstance(points, str | os.PathLike):
        points = read_points(points)
    columns = points if isinstance(points, Mapping) else getattr(points, "columns", ())
    if isinstance(points, Points):
        points, columns = np.column_stack([unmasked(points.displacement), unmasked(points.force)]), ()
    elif callable(columns):  # a table of this package: a path, with units in its titles
        points = columns = columns()
    titles = list(columns)
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
    if np.any(np.abs(array) > LARGEST):
        row, column = np.argwhere(np.abs(array) > LARGEST)[0]
        name, unit = (("displacement", "m"), ("force", "N"))[column]
        raise DemlawsError(f"points: the {name} {array[row, column]:g} {unit} of point {row + 1} is no measurement: remove it")
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
    skipped = {counted(int(np.sum(~keep & ~pull)), "point"): reason} if np.any(~keep & ~pull) else {}
    if np.any(pull):
        lowest = float(np.min(force))
        skipped[f"{counted(int(np.sum(pull)), 'point')} in tension"] = (
            f"the bodies adhere (to {lowest:.2g} N in unloading): no law of demlaws has adhesion"
        )
    return keep, skipped


def creeping_holds(displacement, force):
    """(First row, last row) of each hold, at constant force, over which the displacement creeps.

    The forces of a hold lie within 8 standard deviations of the load cell, from the second differences of all forces, and 0.2 %
    of the force; they are at least 5 rows, 3 times as many as elsewhere in such a range, and without a trend. The displacement
    has one, with the logarithm of time, that chance gives to 1 hold of 100.
    """
    holds, first = [], 0
    if force.size < FEWEST_HELD:
        return holds
    noise = 1.4826 * float(np.median(np.abs(np.diff(force, 2)))) / math.sqrt(6.0)
    density = force.size / _path_of(force)
    while first <= force.size - FEWEST_HELD:
        width = _HELD_NOISE * noise + _HELD_WIDTH * abs(force[first])
        rows = max(FEWEST_HELD, math.ceil(_SLOWER * width * density))
        if first + rows > force.size or np.ptp(force[first : first + rows]) > width:
            first += 1
            continue
        away = np.maximum.accumulate(force[first:]) - np.minimum.accumulate(force[first:]) > width
        last = first + int(np.argmax(away)) - 1 if away[-1] else force.size - 1
        inside = np.abs(force[first : last + 1] - np.median(force[first : last + 1])) <= 0.5 * width  # not the ramps beside it
        first, last = first + int(np.argmax(inside)), last - int(np.argmax(inside[::-1]))
        if last - first + 1 >= rows and _creeps(displacement[first : last + 1], force[first : last + 1], width):
            holds.append((first, last))
        first = last + 1
    return holds


def _path_of(force):
    """Sum [N] of the rises and falls of the force; those below `UNLOADED` of its range are noise."""
    path, turn, end, least = 0.0, force[0], force[0], UNLOADED * float(np.ptp(force))
    for one in force:
        if (one - end) * (end - turn) >= 0.0:
            end = one
        elif abs(one - end) > least:
            path, turn, end = path + abs(end - turn), end, one
    return max(path + abs(end - turn), 1e-300)


def _creeps(displacement, force, width):
    """Whether the displacement of the rows of a hold has a trend, and the force has none."""
    from scipy import special

    place = np.log1p(np.arange(force.size))  # creep slows down
    place -= np.mean(place)
    square = float(place @ place)
    rise, creep = (float(place @ one) / square for one in (force, displacement))
    left = displacement - np.mean(displacement) - creep * place
    error = math.sqrt(float(left @ left) / (force.size - 2) / square)
    return abs(rise) * np.ptp(place) <= width / 4.0 and abs(creep) > special.stdtrit(force.size - 2, 0.995) * error
