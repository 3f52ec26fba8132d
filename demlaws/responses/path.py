"""Response of one contact along a path of overlaps."""

from collections.abc import Iterator
from dataclasses import dataclass, fields
from typing import Any, overload

import numpy as np

from demlaws.responses.results import PATH_COLUMNS, Tabular


@dataclass(frozen=True, eq=False, repr=False)
class Path(Tabular):
    """Response of one contact along a path: arrays with one entry per overlap, SI units.

    `path[:100]` is a part of it, `path[-1]` one point, `path["force"]` an array by its name; `for point in path` gives the
    points. `numpy.asarray(path)` has a row per point with the printed columns. `dl.fit(path, contact)` takes it as a test.

    Attributes
    ----------
    overlap, maximum_overlap : ndarray
        Overlap and its largest value since first contact [m].
    plastic_overlap : ndarray
        Overlap at which the force vanishes on unloading [m]; NaN if the unloading rule has no state of that name.
    force : ndarray
        Normal force [N].
    stiffness : ndarray
        Tangent stiffness [N/m].
    stored, dissipated : ndarray
        Recoverable energy of the contact, and energy that it has dissipated [J], over all its closings, those along earlier
        paths of the same state included.

    Examples
    --------
    >>> law = dl.law("hertz", dl.Contact(radius=4e-3, modulus=32e9))
    >>> path = law.follow([0.0, 1e-6, 0.5e-6])
    >>> print(path)
    overlap (m)  force (N)  stiffness (N/m)  plastic_overlap (m)   work (J)
              0          0                0                    0          0
          1e-06     2.6985       4.0477e+06                    0 1.0794e-06
          5e-07    0.95406       2.8622e+06                    0 1.9081e-07
    """

    overlap: np.ndarray
    force: np.ndarray
    stiffness: np.ndarray
    maximum_overlap: np.ndarray
    plastic_overlap: np.ndarray
    stored: np.ndarray
    dissipated: np.ndarray

    def __len__(self) -> int:
        return np.size(self.overlap)

    @overload
    def __getitem__(self, index: str) -> np.ndarray: ...

    @overload
    def __getitem__(self, index: Any) -> "Path": ...

    def __getitem__(self, index: Any) -> Any:
        if isinstance(index, str):
            return self.named(index, (*PATH_COLUMNS.values(), "maximum_overlap"))
        return Path(*(np.atleast_1d(getattr(self, field.name))[index] for field in fields(self)))

    def __iter__(self) -> Iterator["Path"]:
        return (self[number] for number in range(len(self)))

    def columns(self) -> dict:
        """Overlap, force, stiffness, plastic overlap and work, each an array."""
        units = {"overlap": "m", "force": "N", "stiffness": "N/m", "plastic_overlap": "m", "work": "J"}
        return {f"{name} ({unit})": np.atleast_1d(getattr(self, name)) for name, unit in units.items()}

    def csv_rows(self) -> np.ndarray:
        """One row per point, one column per entry of `PATH_COLUMNS`."""
        return np.column_stack([getattr(self, name) for name in PATH_COLUMNS.values()])

    @property
    def displacement(self) -> np.ndarray:
        """The overlap [m], by its name in points of a test."""
        return self.overlap

    @property
    def work(self) -> np.ndarray:
        """Work done on the contact [J], ∫P dδ, exact between the points: stored and dissipated."""
        return self.stored + self.dissipated

    def plot(self, ax: Any = None, **style: Any) -> Any:
        """Draw force against overlap; returns matplotlib's axes. Keywords go to `Axes.plot`, see `Law.plot`."""
        from demlaws import plots

        return plots.plot(self, ax, **style)
