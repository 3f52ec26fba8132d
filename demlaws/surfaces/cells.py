"""Cells of text tables that spreadsheets and instruments write: decimal commas and missing values.

Points of a test and height maps are read by the same rules.
"""

import csv
import math
import re
from collections.abc import Sequence

from demlaws.errors import DemlawsError

MISSING = {
    *("", "nan", "-nan", "nan(ind)", "-nan(ind)", "na", "n/a", "null", "none", "bad", "***", "---", "--", "-"),
    *("#n/a", "#na", "#num!", "#value!", "#div/0!", "#ref!", "#null!", "#name?"),
}
"""Cells without a value, in lower case; those that begin with # are a spreadsheet's."""

_GROUPS = re.compile(r"[-+−]?[1-9]\d{0,2}(?:[.,]\d{3})+")
"""A number whose mark may be before decimals or before thousands: 1,382."""


def is_missing(cell: str) -> bool:
    """Whether a cell has no value."""
    return cell.strip().lower() in MISSING


_NUMBER = re.compile(r"[-+−]?\d*[\d.,'’ \u00a0\u2009\u202f]*\d[.,]?(?:[eE][-+−]?\d+)?")


def is_number(cell: str) -> bool:
    """Whether a cell has digits and their marks alone."""
    return _NUMBER.fullmatch(cell.strip()) is not None


def separator(line: str) -> str | None:
    """The mark between the columns of a line; None: blanks."""
    return next((mark for mark in (";", "\t", ",") if mark in line), None)


def split(line: str, delimiter: str | None) -> list[str]:
    """Cells of a line, without quotation marks. Blanks before a bracket split no title: "force (N)"."""
    if delimiter is None:
        return [cell.strip('"') for cell in re.split(r"\s+(?![(\[])", line.strip())]
    return next(csv.reader([line], delimiter=delimiter, skipinitialspace=True)) if '"' in line else line.split(delimiter)


def decimal_mark(cells: Sequence[str], path: object) -> str:
    """Decimal mark of a file whose numbers these are, "." or ",".

    DemlawsError where numbers have thousands separators, or where all of them may have: "1,382" is 1382 or 1.382.
    """
    commas = [cell for cell in cells if "," in cell and is_number(cell)]
    points = [cell for cell in cells if cell.count(".") == 1]
    remedy = "write the numbers without thousands separators"
    if commas and any(map(is_number, points)):
        raise DemlawsError(f"{path}: numbers with commas ({commas[0].strip()!r}) and with points: {remedy}")
    marked = commas or points
    if marked and all(_GROUPS.fullmatch(cell.strip()) for cell in marked):
        text = marked[0].strip()
        raise DemlawsError(
            f"{path}: {text!r} may have thousands or decimals behind its mark, and no number of the file decides it: {remedy}, "
            f"or one of them as {text}0"
        )
    return "," if commas else "."


def value_of(cell: str, mark: str) -> float:
    """Number of a cell with this decimal mark, NaN where it is missing. Raises ValueError where it is neither."""
    if is_missing(cell):
        return math.nan
    if "_" in cell:
        raise ValueError(f"{cell.strip()!r} is not a number")
    return float(cell.replace("−", "-").replace(mark, "."))
