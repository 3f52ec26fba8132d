"""Results with columns: text, HTML for notebooks, pandas."""

import html
from collections.abc import Sequence
from typing import Any

from demlaws.errors import DemlawsError

SHOWN = 10
"""Number of rows that `str` and notebooks show; of more, the first and the last half."""

PATH_COLUMNS = {
    "overlap (m)": "overlap",
    "force (N)": "force",
    "stiffness (N/m)": "stiffness",
    "plastic overlap (m)": "plastic_overlap",
    "work (J)": "work",
    "stored (J)": "stored",
    "dissipated (J)": "dissipated",
}
"""Title of a column of the CSV file of a path → attribute; here, where the command line reads it without numpy."""


def _text(value):
    return value if isinstance(value, str) else str(value) if isinstance(value, bool | int) else f"{value:.5g}"


class Tabular:
    """Methods of results that have columns. A class defines `columns`, and `title` if it has one."""

    most_rows = SHOWN

    def columns(self) -> dict[str, Sequence]:
        """Name of each column, with its unit → its values."""
        raise NotImplementedError

    def title(self) -> str:
        """First line of the text."""
        return ""

    def shown(self) -> dict[str, Sequence]:
        """The columns that `str` and notebooks show; default: all."""
        return self.columns()

    def to_dataframe(self) -> Any:
        """The columns as a `pandas.DataFrame`. Raises DemlawsError if pandas is not installed."""
        try:
            import pandas
        except ImportError as error:
            raise DemlawsError("to_dataframe needs pandas: pip install pandas") from error
        return pandas.DataFrame(self.columns())

    def _table(self):
        """Titles and text of the rows that are shown; None stands for omitted rows."""
        columns = self.shown()
        count = len(next(iter(columns.values())))
        places = range(count)
        if count > self.most_rows:
            places = [*places[: self.most_rows // 2], None, *places[-self.most_rows // 2 :]]
        rows = [None if n is None else [_text(values[n]) for values in columns.values()] for n in places]
        return list(columns), rows

    def __str__(self):
        titles, rows = self._table()
        widths = [max(len(row[k]) for row in [titles, *filter(None, rows)]) for k in range(len(titles))]
        lines = [self.title()] if self.title() else []
        for row in [titles, *rows]:
            cells = ["..."] if row is None else (f"{cell:>{width}}" for cell, width in zip(row, widths, strict=True))
            lines.append("  ".join(cells).rstrip())
        return "\n".join(lines)

    def _repr_html_(self):
        titles, rows = self._table()
        cells = "".join(f"<th>{html.escape(title)}</th>" for title in titles)
        lines = [f"<p>{html.escape(self.title())}</p>"] if self.title() else []
        lines.append(f"<table><thead><tr>{cells}</tr></thead><tbody>")
        for row in rows:
            cells = "".join(f"<td>{html.escape(cell)}</td>" for cell in row or ["…"] * len(titles))
            lines.append(f"<tr>{cells}</tr>")
        return "\n".join([*lines, "</tbody></table>"])
