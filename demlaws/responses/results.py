"""Results with columns: text, pandas."""

from collections.abc import Sequence
from typing import Any

from demlaws.errors import DemlawsError, did_you_mean

SHOWN = 10
"""Number of rows that `str` shows; of more, the first and the last half."""

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
        """The columns that `str` shows; default: all."""
        return self.columns()

    def named(self, name: str, names: Sequence[str]) -> Any:
        """The values of this name, one of `names`."""
        if name not in names:
            raise DemlawsError(f"no column {name!r:.60}{did_you_mean(name, names)} The columns are {', '.join(names)}")
        return getattr(self, name)

    def __array__(self, dtype: Any = None, copy: Any = None) -> Any:
        import numpy as np

        return np.column_stack(list(self.columns().values())).astype(dtype or None)

    def to_dataframe(self) -> Any:
        """The columns as a `pandas.DataFrame`. Raises DemlawsError if pandas is not installed."""
        try:
            import pandas
        except ImportError as error:
            raise DemlawsError("to_dataframe needs pandas: pip install pandas") from error
        return pandas.DataFrame(self.columns())

    def __str__(self):
        columns = self.shown()
        count = len(next(iter(columns.values())))
        rows = [[_text(values[n]) for values in columns.values()] for n in range(count)]
        if count > self.most_rows:
            rows = [*rows[: self.most_rows // 2], ["..."], *rows[-self.most_rows // 2 :]]
        table = [list(columns), *rows]
        widths = [max(len(row[k]) for row in table if len(row) > k) for k in range(len(columns))]
        lines = ["  ".join(f"{cell:>{width}}" for cell, width in zip(row, widths, strict=False)).rstrip() for row in table]
        return "\n".join([self.title(), *lines] if self.title() else lines)

    __repr__ = __str__
