"""Contacts of a scene or of a dump as a table, and as lines between centres for ParaView."""

import re
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any, overload

import numpy as np

from demlaws.errors import DemlawsError, counted
from demlaws.files import PARAVIEW, PARAVIEW_MARK, as_path, write_atomically
from demlaws.responses.results import Tabular

COLUMNS = {
    "body1": ("", "number of the first body"),
    "body2": ("", "number of the second body"),
    "overlap": ("m", "present overlap δ"),
    "force": ("N", "normal force P of the law, without damping"),
    "stiffness": ("N/m", "tangent dP/dδ, of unloading where the contact unloads"),
    "radius": ("m", "effective radius R with which the law computes"),
    "modulus": ("Pa", "contact modulus E*"),
    "sigma": ("m", "combined roughness σ"),
    "maximum_overlap": ("m", "largest overlap since the bodies touched; NaN with unloading `elastic`"),
    "plastic_overlap": ("m", "overlap at which the force vanishes on unloading"),
    "radius_ratio": ("", "R_p/R of the curve of unloading (rules `thornton`, `etsion`, `jackson`); NaN with others"),
    "stored": ("J", "energy that unloading returns"),
    "dissipated": ("J", "energy that plastic deformation has taken since the bodies touched"),
    "branch": ("", "0: at the largest overlap so far (first loading); 1: below it (unloading or reloading)"),
    "flattened": (
        "",
        "whether the contact has deformed plastically, asperities or bulk: it has dissipated energy; in dumps: a plastic "
        "overlap remains",
    ),
    "bulk_yielded": ("", "whether the bulk has passed the yield point of the law; only of laws that have one"),
    "contact_radius": ("m", "radius a = K/(2E*) of the contact area, exact for elastic laws"),
    "conductance": ("m", "conductance of heat or current between the bodies over their conductivity, K/E* = 2a"),
    "mean_pressure": ("Pa", "mean pressure P/(π a²), the one of `PressureFriction`"),
    "above": ("", "whether the mean pressure exceeds the given strength"),
    "sliding": ("", "whether the shear force is at Coulomb's limit"),
    "shear_force": ("N", "shear force"),
    "shear_stored": ("J", "energy that the springs of shear return"),
    "shear_dissipated": ("J", "energy that friction and opening springs have taken since the bodies touched"),
    "viscous": ("J", "energy that viscous damping has taken since the bodies touched"),
}
"""Name of a column → unit, meaning."""
MAIN = ("body1", "body2", "overlap", "force", "shear_force", "maximum_overlap", "plastic_overlap", "flattened", "sliding")
SHORT = {"maximum_overlap": "largest (m)", "plastic_overlap": "plastic (m)", "shear_force": "shear (N)"}
"""What `str` shows, and shorter titles there."""


@dataclass(frozen=True, eq=False, repr=False)
class Contacts(Tabular):
    """Contacts: arrays with one entry per contact, SI units; `COLUMNS` describes them. Unknown values are NaN, or None.

    `len` is the number of contacts; `contacts[3]`, a slice, numbers or a mask give some of
    them, `contacts["force"]` a column. `print`, `to_dataframe()` give
    a row for each, `save` lines for ParaView. centre1, centre2: (n, 3), of the bodies; the point of contact on a wall.
    """

    body1: np.ndarray
    body2: np.ndarray
    overlap: np.ndarray
    force: np.ndarray
    stiffness: np.ndarray | None = None
    radius: np.ndarray | None = None
    modulus: np.ndarray | None = None
    sigma: np.ndarray | None = None
    maximum_overlap: np.ndarray | None = None
    plastic_overlap: np.ndarray | None = None
    radius_ratio: np.ndarray | None = None
    stored: np.ndarray | None = None
    dissipated: np.ndarray | None = None
    branch: np.ndarray | None = None
    flattened: np.ndarray | None = None
    bulk_yielded: np.ndarray | None = None
    mean_pressure: np.ndarray | None = None
    above: np.ndarray | None = None
    sliding: np.ndarray | None = None
    shear_force: np.ndarray | None = None
    shear_stored: np.ndarray | None = None
    shear_dissipated: np.ndarray | None = None
    viscous: np.ndarray | None = None
    centre1: np.ndarray | None = None
    centre2: np.ndarray | None = None

    @property
    def contact_radius(self) -> np.ndarray | None:
        """a = K/(2E*) [m] of the contact area: exact for elastic contacts of axisymmetric bodies, rough ones included.

        None where stiffness or modulus is not known.
        """
        return None if self.stiffness is None or self.modulus is None else 0.5 * self.stiffness / self.modulus

    @property
    def conductance(self) -> np.ndarray | None:
        """Conductance of the contact over the conductivity k of the bodies [m]: K/E* (Barber 2003, Proc. R. Soc. A 459, 53).

        Times k [W/(m K)] it is W/K; k of two materials is 2 k1 k2/(k1 + k2). None where stiffness or modulus is not known.
        """
        return None if self.stiffness is None or self.modulus is None else self.stiffness / self.modulus

    def __len__(self) -> int:
        return len(self.body1)

    @overload
    def __getitem__(self, which: str) -> np.ndarray: ...

    @overload
    def __getitem__(self, which: Any) -> "Contacts": ...

    def __getitem__(self, which: Any) -> Any:
        if isinstance(which, str):
            return self.named(which, tuple(COLUMNS))
        chosen = np.atleast_1d(np.arange(len(self))[which])
        columns: dict[str, Any] = {field.name: getattr(self, field.name) for field in fields(self)}
        return replace(self, **{name: values[chosen] for name, values in columns.items() if values is not None})

    def columns(self) -> dict[str, Sequence]:
        """Columns of which something is known, with their units."""
        return {f"{name} ({unit})" if unit else name: values for name, unit, values in self._known()}

    def _known(self) -> Iterator[tuple[str, str, Any]]:
        """Name, unit and values of the columns of which something is known."""
        for name, (unit, _) in COLUMNS.items():
            values = getattr(self, name)
            if values is not None and not (values.size and values.dtype.kind == "f" and np.all(np.isnan(values))):
                yield name, unit, values

    def shown(self) -> dict[str, Sequence]:
        """What fits on a line."""
        known = {name: (f"{name} ({unit})" if unit else name, values) for name, unit, values in self._known()}
        return {SHORT.get(name, known[name][0]): known[name][1] for name in MAIN if name in known}

    def title(self) -> str:
        """Number of contacts."""
        return counted(len(self), "contact")

    def save(self, path: str | Path) -> Path:
        """Lines between the centres with the columns as cell data, for ParaView: .vtu or .vtk. Needs meshio.

        Parameters
        ----------
        path : str or Path
            File to write, ending with .vtu or .vtk.

        Returns
        -------
        Path

        Raises
        ------
        DemlawsError
            If the places of the bodies are not known, the ending is another one, or meshio is not installed.
        """
        path = as_path(path)
        if self.centre1 is None or self.centre2 is None:
            raise DemlawsError("these contacts have no places of their bodies: nothing to draw")
        data = {name: v.astype(np.uint8) if v.dtype == bool else v for name, _, v in self._known()}
        if path.suffix not in PARAVIEW:
            raise DemlawsError(f"contacts are saved as .vtu or .vtk, got {path.suffix!r}")
        try:
            import meshio
        except ImportError:
            raise DemlawsError(f"a {path.suffix} file needs meshio: pip install 'demlaws[vtk]'") from None
        lines = np.stack([np.arange(len(self)), np.arange(len(self)) + len(self)], axis=1)  # numbers of their points
        points, cells = np.concatenate([self.centre1, self.centre2]), {name: [values] for name, values in data.items()}
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder, f"lines{path.suffix}")
            meshio.Mesh(points, [("line", lines)], cell_data=cells).write(file)
            marked = re.sub(rb"(written|created) by meshio", PARAVIEW_MARK + rb", \g<0>", file.read_bytes(), count=1)
        return write_atomically(path, marked)
