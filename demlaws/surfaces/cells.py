"""Cells of text tables that spreadsheets and instruments write: decimal commas, thousands separators, missing values.

Points of a test and height maps are read by the same rules.
"""

import csv
import math
import re
from collections.abc import Iterable

from demlaws.errors import DemlawsError

MISSING = {
    *("", "nan", "-nan", "nan(ind)", "-nan(ind)", "na", "n/a", "null", "none", "bad", "***", "---", "--", "-"),
    *("#n/a", "#na", "#num!", "#value!", "#div/0!", "#ref!", "#null!", "#name?"),
}
"""Cells without a value, in lower case; those that begin with # are a spreadsheet's."""

_OTHER_GROUPS = re.compile(r"(?<=\d)[  '’\u00a0\u2009\u202f](?=\d{3}(?!\d))")
"""Thousands separators that are never decimal marks."""
_MARKS = {",": re.compile(r"[1-9]\d{0,2}(?:,\d{3})+"), ".": re.compile(r"[1-9]\d{0,2}(?:\.\d{3})+")}


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


def split(line: str, mark: str | None) -> list[str]:
    """Cells of a line, without quotation marks. Blanks before a bracket split no title: "force (N)"."""
    if mark is None:
        return [cell.strip('"') for cell in re.split(r"\s+(?![(\[])", line.strip())]
    return next(csv.reader([line], delimiter=mark, skipinitialspace=True)) if '"' in line else line.split(mark)


class Decimals:
    """Marks of the numbers of one file, decided by the cells that can be read in one way only.

    "1,5" and "0,382" have a decimal comma, "1,234,567" and "1,234.5" thousands separators; "1,382" may have either, and so
    may "1.382". A file in which nothing decides is refused.
    """

    def __init__(self) -> None:
        self.decimal: dict[str, str] = {}  # mark → cell that shows it before decimals
        self.thousands: dict[str, str] = {}  # mark → cell that shows it before thousands
        self.open: dict[str, tuple[str, str]] = {}  # mark → first cell that shows neither, and its place

    def see(self, cells: Iterable[str], place: str) -> None:
        """Note what the cells of a line show; place: file and line, for errors."""
        for cell in cells:
            if "," in cell or ("." in cell and "." not in self.decimal):
                self._see(cell.strip().lstrip("+-−"), place)

    def _see(self, text, place):
        marks = [mark for mark in ",." if mark in text]
        if not marks or not is_number(text):
            return
        if len(marks) == 2:
            first, last = sorted(marks, key=text.rindex)
            self.thousands.setdefault(first, text)
            self.decimal.setdefault(last, text)
        elif _MARKS[marks[0]].fullmatch(text):
            several = text.count(marks[0]) > 1
            self.thousands.setdefault(marks[0], text) if several else self.open.setdefault(marks[0], (text, place))
        elif text.count(marks[0]) == 1:
            self.decimal.setdefault(marks[0], text)

    def is_decided(self, text: str) -> bool:
        """Whether the marks that a line may have in its numbers have shown their meaning."""
        return all(mark in self.decimal or mark in self.thousands for mark in self.open if mark in text)

    def decide(self) -> None:
        """Raise DemlawsError where a mark may be before thousands or before decimals."""
        for mark in set(self.decimal) & set(self.thousands):
            raise DemlawsError(
                f"{self.decimal[mark]!r} and {self.thousands[mark]!r} in one file: is {mark} before decimals or before "
                "thousands? Write the numbers without thousands separators"
            )
        for mark, (cell, place) in self.open.items():
            other = "," if mark == "." else "."
            if mark in self.decimal or mark in self.thousands or other in self.thousands:
                continue
            raise DemlawsError(
                f"{place}: {cell!r} may be {cell.replace(mark, '')} or {cell.replace(mark, '.')}, and no number of the file "
                f"decides it: write the numbers without thousands separators, or one of them as {cell.replace(mark, '.')}0"
            )

    def number(self, cell: str) -> float:
        """Number of a cell, NaN where it is missing. Raises ValueError where it is neither."""
        if is_missing(cell):
            return math.nan
        text = cell.strip().replace("−", "-")
        for mark in self.thousands:
            if mark in text and _MARKS[mark].match(text.lstrip("+-")):
                text = text.replace(mark, "")
        if "_" in text:
            raise ValueError(text)
        return float(_OTHER_GROUPS.sub("", text).replace(",", "."))
